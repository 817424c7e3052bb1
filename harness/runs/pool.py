"""Pools of workers for units of work: this process, processes beside it, or a cluster.

A unit has parts, and every part has one result. A worker process sends each result as soon as it
is known, so its death costs only the current part, and a fresh process continues the unit. The
treatment of that part depends on how the process ended:

* By itself: an engine aborted, made an invalid access, or called ``exit``. The part is tried once
  more, as the first in a fresh process, and counts as crashed when that ends by itself, too. A
  single crash proves nothing: it may be the late effect of an earlier part, or a signal that
  somebody sent.
* It was killed from outside, by a user or for lack of memory. That is no property of the part,
  which is tried again. After a few retries its unit is given up, and the others continue.
* The pool killed it because the part took longer than its hard limit: the part has timed out.
"""

from __future__ import annotations

import importlib
import os
import threading
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, CancelledError, Future, ThreadPoolExecutor, wait
from dataclasses import dataclass
from itertools import islice
from typing import Any, Generic, NamedTuple, Protocol, Self, TypeVar

from steadyload.errors import FailedError, UserError, nearest
from steadyload.runs.kept_only import refuse_unless_kept
from steadyload.runs.worker import PartTimeoutError, Phase, ProcessDiedError, Worker

IN_THIS_PROCESS = 0
"""Number of workers for work in the calling process: for debugging, and where starting processes
takes too long. A crash of an engine then ends the caller."""

UNITS_PER_WORKER = 2
"""Units that a pool takes for each worker: one in work, one waiting."""

POLL_SECONDS = 1.0
"""Interval [s] at which the number of units that a pool takes is read: clusters grow."""

_RETRIES = {"start": 10, "crash": 1, "kill": 3}
"""Number of retries of a part by how its workers died: killed before they had started, ended by
themselves at the part, or anything else."""


class WorkUnit(Protocol):
    """Parts that are worked on one after the other."""

    def __len__(self) -> int:
        """Number of parts, 1 or more."""
        ...

    def without(self, done: int) -> Self:
        """The unit of the parts after the first ``done`` ones."""
        ...

    def describe(self, part: int) -> str:
        """Description of a part for messages, such as ``sme on layout "A"``."""
        ...


class SinglePart:
    """Base of units of work with one part, which is never left out."""

    __slots__ = ()

    def __len__(self) -> int:
        return 1

    def without(self, done: int) -> Self:
        """See :meth:`WorkUnit.without`."""
        return self


Unit = TypeVar("Unit", bound=WorkUnit)
Result = TypeVar("Result")
Work = Callable[[Unit], Iterator[Result]]
"""Prepares for a unit, then yields a result for each of its parts."""
NoResult = Callable[[Unit, int, str], Result]
"""Result of a part for which the work gives none; called with the unit, the part counted from 0,
and the reason."""


class ExecutorError(UserError):
    """An unknown executor, or one that cannot work; the message says what is allowed."""


class WorkerDiedError(FailedError):
    """Workers died for a reason outside the work; finished results are kept."""


class GivenUpError(WorkerDiedError):
    """A unit was given up; the others can be worked on."""


@dataclass(frozen=True, slots=True)
class PartLimit(Generic[Unit, Result]):
    """Hard limit on the time of a part: its worker is killed, even during a native call.

    The time of a part begins with the result of the part before it; that of the first one, when the
    work has prepared for the unit.

    Args:
        seconds: CPU time of its worker that a part may take, with a backstop of wall time: see
            :mod:`steadyload.time_limit`.
        timed_out: makes the result of a part that takes longer.
    """

    seconds: float
    timed_out: NoResult[Unit, Result]


@dataclass(frozen=True, slots=True)
class Task(Generic[Unit, Result]):
    """A unit with the work to be done on it; see :func:`run_units`."""

    work: Work[Unit, Result]
    unit: Unit
    crashed: NoResult[Unit, Result]
    limit: PartLimit[Unit, Result] | None = None


class Executor(Protocol):
    """Protocol of executors, with the interface of :class:`concurrent.futures.Executor`.

    It is used in a ``with`` block; leaving the block ends the tasks that are still running.

    Attributes:
        shares_files: its workers can read the files of this process.
    """

    shares_files: bool = True

    @property
    def room(self) -> int:
        """Number of tasks that it takes at a time, 1 or more."""
        ...

    def submit(self, task: Task[Unit, Result]) -> Future[list[Result]]:
        """Future of the results of a unit's parts, with exceptions of :meth:`Processes.results`."""
        ...

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *raised: object) -> None:
        return None


class Serial(Executor):
    """Executor in this process; the reference for all others. It cannot enforce a hard limit."""

    room = 1

    def submit(self, task: Task[Unit, Result]) -> Future[list[Result]]:
        """See :meth:`Executor.submit`; exceptions of the work are raised here."""
        future: Future[list[Result]] = Future()
        future.set_result(list(task.work(task.unit)))
        return future


def all_cores() -> int:
    """Number of workers that fill this machine."""
    return os.cpu_count() or 1


class Processes(Executor):
    """Pool of worker processes, which are kept as long as the work is the same.

    Args:
        workers: number of processes, 1 or more; None for one a core. They are started as needed.
    """

    def __init__(self, workers: int | None = None) -> None:
        self._count = all_cores() if workers is None else workers
        self._threads = ThreadPoolExecutor(self._count)
        self._workers: dict[int, Worker] = {}
        """By the thread that uses it."""
        self._closed = False
        self._lock = threading.Lock()

    @property
    def room(self) -> int:
        """See :attr:`Executor.room`."""
        return UNITS_PER_WORKER * self._count

    def submit(self, task: Task[Unit, Result]) -> Future[list[Result]]:
        """See :meth:`Executor.submit`."""
        return self._threads.submit(self.results, task)

    def results(self, task: Task[Unit, Result]) -> list[Result]:
        """The results of a unit's parts, by the worker of this thread and its replacements.

        Raises:
            GivenUpError: workers were repeatedly killed from outside.
            WorkerDiedError: a worker could not start.
            UnpicklableError: the work, the unit or a result cannot be sent between processes.
            Exception: what the work raised.
        """
        results: list[Result] = []
        deaths: Counter[tuple[int, str]] = Counter()
        while len(results) < len(task.unit):
            try:
                self._work_on(task, results)
            except PartTimeoutError as error:
                assert task.limit is not None
                reason = f"no answer within {error}; its process was killed"
                results.append(task.limit.timed_out(task.unit, len(results), reason))
            except ProcessDiedError as death:
                if self._closed:
                    raise CancelledError from None
                results += _after_death(task, len(results), death, deaths)
        return results

    def _work_on(self, task: Task[Any, Result], results: list[Result]) -> None:
        """Add the results of the remaining parts; a worker that is not idle then is killed."""
        unit, thread = task.unit.without(len(results)), threading.get_ident()
        seconds = None if task.limit is None else task.limit.seconds
        worker = self._worker(thread, task.work)
        try:
            for result in worker.results(unit, seconds):
                assert len(results) < len(task.unit), "more results than parts"
                results.append(result)
            assert len(results) == len(task.unit), "a part has no result"
        except (PartTimeoutError, ProcessDiedError):
            if len(results) < len(task.unit):
                raise
        finally:
            if worker.phase is not Phase.IDLE:
                worker.kill()
                del self._workers[thread]

    def _worker(self, thread: int, work: Work[Any, Any]) -> Worker:
        worker = self._workers.get(thread)
        if worker is not None and worker.work == work:
            return worker
        if worker is not None:
            self._workers.pop(thread).shut_down()
        with self._lock:
            if self._closed:
                raise CancelledError
            self._workers[thread] = worker = Worker(work)
            return worker

    def close(self) -> None:
        """Kill all workers now, and start no other."""
        with self._lock:
            self._closed = True
            for worker in [*self._workers.values()]:
                worker.process.kill()  # its thread notices, and releases the rest

    def __exit__(self, *raised: object) -> None:
        if any(raised):
            self.close()
        self._threads.shutdown(cancel_futures=True)
        for worker in self._workers.values():
            worker.shut_down()


def _after_death(
    task: Task[Any, Result], part: int, death: ProcessDiedError, deaths: Counter[tuple[int, str]]
) -> list[Result]:
    """The result of a part whose worker died; none if the part is to be tried again.

    Raises:
        GivenUpError: its workers died too often.
        WorkerDiedError: they could not start.
    """
    starting, unit = death.phase is Phase.STARTING, task.unit
    kind = "start" if starting else "crash" if death.is_crash else "kill"
    deaths[part, kind] += 1
    if deaths[part, kind] <= _RETRIES[kind] and not (starting and death.code >= 0):
        return []
    if starting:
        raise WorkerDiedError(
            f"a worker process ended {death} before it could begin; what is finished is kept "
            '(a script of your own needs `if __name__ == "__main__":` around the call)'
        )
    if death.is_crash:
        return [task.crashed(unit, part, f"its process ended {death}, the second in a row")]
    what = "" if death.phase is Phase.WORKING else "the preparation for "
    raise GivenUpError(
        f"{what}{unit.describe(part)}: its worker process ended {death}, time and again"
    )


class ExecutorEntry(NamedTuple):
    """Import path of an executor ("module:Class"), its options, and the extra that it needs."""

    target: str
    options: tuple[str, ...] = ()
    extra: str = ""


EXECUTORS: dict[str, ExecutorEntry] = {
    "serial": ExecutorEntry("steadyload.runs.pool:Serial"),
    "processes": ExecutorEntry("steadyload.runs.pool:Processes", ("workers",)),
    "dask": ExecutorEntry("steadyload.runs.with_dask:Dask", ("workers", "scheduler"), "dask"),
}


def make_executor(name: str, **options: Any) -> Executor:
    """An executor by its name.

    Args:
        name: one of :data:`EXECUTORS`.
        options: of the executor; None counts as not given.

    Raises:
        ExecutorError: there is no such executor, it has no such option, a package that it needs is
            not installed, or what :class:`steadyload.runs.with_dask.Dask` raises.
    """
    entry = EXECUTORS.get(name)
    if entry is None:
        raise ExecutorError(f"executor {name!r}; {nearest(name, EXECUTORS)}")
    given = {option: value for option, value in options.items() if value is not None}
    for option in given:
        if option not in entry.options:
            those = " or ".join(k for k, e in EXECUTORS.items() if option in e.options)
            raise ExecutorError(f"executor {name!r} has no {option}; allowed: with {those}")
    module, _, attribute = entry.target.partition(":")
    try:
        return getattr(importlib.import_module(module), attribute)(**given)
    except ModuleNotFoundError as error:
        if not entry.extra:
            raise
        raise ExecutorError(
            f"executor {name!r} needs the package {error.name}: "
            f"pip install 'steadyload[{entry.extra}]'"
        ) from None


def run_units(
    work: Work[Unit, Result],
    units: Iterable[Unit],
    *,
    workers: int | Executor,
    crashed: NoResult[Unit, Result],
    limit: PartLimit[Unit, Result] | None = None,
) -> Iterator[tuple[Unit, list[Result]]]:
    """Every unit with the results of its parts, in the order in which units are finished.

    Args:
        work: prepares for a unit, then yields a result for each part. Unless it works here, it is a
            module-level function, and it, units and results are pickled.
        units: the units of work; taken from the iterable as there is room, so that neither units
            nor results pile up.
        workers: number of processes beside this one, 0 (:data:`IN_THIS_PROCESS`) to work here; or
            an executor, which is left as it is.
        crashed: makes the result of a part that ends its process; the reason names the signal.
        limit: hard limit on the time of a part; not enforced in this process.

    Raises:
        ValueError: fewer than 0 workers.
        NotKeptError: see :func:`steadyload.runs.kept_only.kept_only`.
        WorkerDiedError: a worker could not start, or was killed repeatedly from outside or before
            it began a part. In the latter case all other units have been worked on.
        UnpicklableError: the work, a unit or a result cannot be sent between processes.
    """
    tasks = (Task(work, unit, crashed, limit) for unit in _allowed(units))
    if not isinstance(workers, int):
        yield from _finished(workers, tasks)
    elif workers >= 0:
        with Serial() if workers == IN_THIS_PROCESS else Processes(workers) as executor:
            yield from _finished(executor, tasks)
    else:
        raise ValueError(f"workers is {workers}; allowed: 0 (in this process) or more")


def _allowed(units: Iterable[Unit]) -> Iterator[Unit]:
    for unit in units:
        refuse_unless_kept(unit.describe(0), len(unit), len(unit))
        yield unit


def _finished(
    executor: Executor, tasks: Iterator[Task[Unit, Result]]
) -> Iterator[tuple[Unit, list[Result]]]:
    in_flight: dict[Future[list[Result]], Unit] = {}
    given_up: list[str] = []
    try:
        while True:
            for task in islice(tasks, max(0, executor.room - len(in_flight))):
                in_flight[executor.submit(task)] = task.unit
            if not in_flight:
                break
            for future in wait(in_flight, POLL_SECONDS, FIRST_COMPLETED).done:
                unit = in_flight.pop(future)
                try:
                    results = future.result()
                except GivenUpError as error:
                    given_up.append(str(error))
                    continue
                yield unit, results
    finally:
        for future in in_flight:
            future.cancel()
    if given_up:
        first, *others = given_up
        more = f" ({len(others)} more likewise)" if others else ""
        raise WorkerDiedError(
            f"{first}{more}; nothing is recorded of it, what is finished is kept: run it again "
            "to go on"
        )

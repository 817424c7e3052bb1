"""Where units of work run: in this process, in a worker pool, or on a cluster. Equal answers."""

from __future__ import annotations

import importlib
from collections.abc import Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, wait
from contextlib import nullcontext
from dataclasses import dataclass
from itertools import islice
from typing import Any, Protocol, Self

from steadyload.errors import UserError, nearest
from steadyload.runs.pool import (
    Answer,
    GivenUpError,
    NoAnswer,
    PartLimit,
    Processes,
    Task,
    Unit,
    Work,
    WorkerDiedError,
)

IN_THIS_PROCESS = 0
"""Number of workers that means none: for debugging, and where starting processes takes too long.
What kills a worker then kills the caller."""

POLL_SECONDS = 1.0
"""Seconds after which an executor is asked again how many units it takes: clusters grow."""


class ExecutorError(UserError):
    """An executor that there is not, or that cannot work; says what is allowed."""


class SinglePart:
    """Base of units with one part: there is never anything to leave out."""

    __slots__ = ()

    def __len__(self) -> int:
        return 1

    def without(self, done: int) -> Self:
        """See :meth:`steadyload.runs.pool.WorkUnit.without`."""
        return self


class Executor(Protocol):
    """Works on tasks; of the shape of :class:`concurrent.futures.Executor`.

    It is used in a ``with`` block, whose end ends what is still in flight.
    """

    @property
    def room(self) -> int:
        """Tasks that it takes at a time, 1 or more."""
        ...

    def submit(self, task: Task[Unit, Answer]) -> Future[list[Answer]]:
        """The answers to a unit's parts, once they are there.

        The future's exceptions are those of :meth:`steadyload.runs.pool.Processes.answers`.
        """
        ...

    def __enter__(self) -> Self: ...

    def __exit__(self, *raised: object) -> None: ...


class Serial:
    """Works in this process; the reference for all others. It cannot enforce a hard limit."""

    room = 1

    def submit(self, task: Task[Unit, Answer]) -> Future[list[Answer]]:
        """See :meth:`Executor.submit`; what the work raises is raised here."""
        future: Future[list[Answer]] = Future()
        future.set_result(list(task.work(task.unit)))
        return future

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *raised: object) -> None:
        return None


@dataclass(frozen=True, slots=True)
class ExecutorEntry:
    """Where an executor lives ("module:Class"), and what options it has.

    ``extra`` names the optional dependencies of this distribution that it needs.
    """

    target: str
    options: tuple[str, ...] = ()
    extra: str = ""


EXECUTORS: dict[str, ExecutorEntry] = {
    "serial": ExecutorEntry("steadyload.runs.executors:Serial"),
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
    work: Work[Unit, Answer],
    units: Iterable[Unit],
    *,
    workers: int | Executor,
    crashed: NoAnswer[Unit, Answer],
    limit: PartLimit[Unit, Answer] | None = None,
) -> Iterator[tuple[Unit, list[Answer]]]:
    """Every unit with the answers to its parts, in the order in which units are finished.

    Args:
        work: prepares for a unit, then answers its parts in turn. Unless it works here, it is a
            module-level function, and it, units and answers are pickled.
        units: what to work on; asked for as there is room, so that neither units nor answers pile
            up.
        workers: number of processes beside this one, 0 (:data:`IN_THIS_PROCESS`) to work here; or
            an executor, which is left as it is.
        crashed: the answer to a part that ends the process it is worked on in; the reason names the
            signal.
        limit: hard limit on the time of a part; not enforced in this process.

    Raises:
        ValueError: fewer than 0 workers.
        WorkerDiedError: a worker could not start, or died time and again from outside or before it
            came to a part. In the latter case all other units have been worked on.
        UnpicklableError: the work, a unit or an answer cannot be sent between processes.
    """
    tasks = (Task(work, unit, crashed, limit) for unit in units)
    with nullcontext(workers) if not isinstance(workers, int) else _local(workers) as executor:
        yield from _finished(executor, tasks)


def _local(workers: int) -> Executor:
    if workers < 0:
        raise ValueError(f"workers is {workers}; allowed: 0 (in this process) or more")
    return Serial() if workers == IN_THIS_PROCESS else Processes(workers)


def _finished(
    executor: Executor, tasks: Iterator[Task[Unit, Answer]]
) -> Iterator[tuple[Unit, list[Answer]]]:
    in_flight: dict[Future[list[Answer]], Unit] = {}
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
                    answers = future.result()
                except GivenUpError as error:
                    given_up.append(str(error))
                    continue
                yield unit, answers
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

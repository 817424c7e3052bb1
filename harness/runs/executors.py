"""Where units of work run: in this process, in others beside it, or on a cluster. Equal answers.

An executor has the shape of those of :mod:`concurrent.futures`: units are submitted, futures come
back, and leaving its ``with`` block ends all that it started. What differs is what is submitted, a
unit with many answers, and that it says how many units it takes at a time: what is ahead of that
waits in an iterator, so that neither units nor answers pile up.
"""

from __future__ import annotations

import importlib
import os
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from contextlib import nullcontext
from dataclasses import dataclass
from itertools import islice
from typing import Any, Protocol, Self

from steadyload.errors import UserError
from steadyload.methods.spec import nearest
from steadyload.runs.seats import (
    Answer,
    Crashed,
    GivenUpError,
    Seats,
    Unit,
    Work,
    WorkerDiedError,
)

IN_THIS_PROCESS = 0
"""Number of workers that means none: for debugging, and where starting processes takes too long.
What kills a worker then kills the caller."""

AHEAD = 2
"""Units an executor takes for each worker: one that is worked on, one that waits."""

LOOK = 1.0
"""Seconds after which an executor is asked again how many units it takes: clusters grow."""


class ExecutorError(UserError):
    """An executor that there is not, or that cannot work; says what is allowed."""


class SinglePart:
    """Base of units with one part: there is never anything to leave out."""

    __slots__ = ()

    def __len__(self) -> int:
        return 1

    def without(self, done: int) -> Self:
        """See :meth:`steadyload.runs.seats.WorkUnit.without`."""
        return self


class Executor(Protocol):
    """Works on units. It is used in a ``with`` block, whose end ends what is still in flight."""

    @property
    def room(self) -> int:
        """Units that it takes at a time, 1 or more."""
        ...

    def submit(
        self, work: Work[Unit, Answer], unit: Unit, crashed: Crashed[Unit, Answer]
    ) -> Future[list[Answer]]:
        """The answers to a unit's parts, once they are there.

        The future's exceptions are those of :meth:`steadyload.runs.seats.Seat.answers`.
        """
        ...

    def __enter__(self) -> Self: ...

    def __exit__(self, *raised: object) -> None: ...


class Serial:
    """Works in this process, when it is asked to. What others do is held against it."""

    room = 1

    def submit(
        self, work: Work[Unit, Answer], unit: Unit, crashed: Crashed[Unit, Answer]
    ) -> Future[list[Answer]]:
        """See :meth:`Executor.submit`; what the work raises is raised here."""
        future: Future[list[Answer]] = Future()
        future.set_result(list(work(unit)))
        return future

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *raised: object) -> None:
        return None


class Processes:
    """Works in processes beside this one.

    Args:
        workers: how many, 1 or more; None for one a core.
    """

    def __init__(self, workers: int | None = None) -> None:
        self._seats = Seats(all_cores() if workers is None else workers)
        self._threads = ThreadPoolExecutor(len(self._seats))

    @property
    def room(self) -> int:
        """See :attr:`Executor.room`."""
        return AHEAD * len(self._seats)

    def submit(
        self, work: Work[Unit, Answer], unit: Unit, crashed: Crashed[Unit, Answer]
    ) -> Future[list[Answer]]:
        """See :meth:`Executor.submit`."""
        return self._threads.submit(self._seats.answers, work, unit, crashed)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *raised: object) -> None:
        if any(raised):
            self._seats.close()
        self._threads.shutdown(cancel_futures=True)
        self._seats.dismiss()


@dataclass(frozen=True, slots=True)
class ExecutorEntry:
    """Where an executor lives ("module:Class"), and what it can be told by name.

    ``extra`` names the optional dependencies of this distribution that it needs.
    """

    target: str
    options: tuple[str, ...] = ()
    extra: str = ""


EXECUTORS: dict[str, ExecutorEntry] = {
    "serial": ExecutorEntry("steadyload.runs.executors:Serial"),
    "processes": ExecutorEntry("steadyload.runs.executors:Processes", ("workers",)),
    "dask": ExecutorEntry("steadyload.runs.cluster:Dask", ("workers", "scheduler"), "dask"),
}


def make_executor(name: str, **options: Any) -> Executor:
    """An executor by its name.

    Args:
        name: one of :data:`EXECUTORS`.
        options: what it is told; None is as good as nothing.

    Raises:
        ExecutorError: there is no such executor, it cannot be told such a thing, a package that it
            needs is not installed, or what :class:`steadyload.runs.cluster.Dask` raises.
    """
    entry = EXECUTORS.get(name)
    if entry is None:
        raise ExecutorError(f"executor {name!r}; {nearest(name, EXECUTORS)}")
    told = {option: value for option, value in options.items() if value is not None}
    for option in told:
        if option not in entry.options:
            those = " or ".join(k for k, e in EXECUTORS.items() if option in e.options)
            raise ExecutorError(f"executor {name!r} has no {option}; allowed: with {those}")
    module, _, attribute = entry.target.partition(":")
    try:
        return getattr(importlib.import_module(module), attribute)(**told)
    except ModuleNotFoundError as error:
        if not entry.extra:
            raise
        raise ExecutorError(
            f"executor {name!r} needs the package {error.name}: "
            f"pip install 'steadyload[{entry.extra}]'"
        ) from None


def all_cores() -> int:
    """How many workers fill this machine."""
    return os.cpu_count() or 1


def run_units(
    work: Callable[[Unit], Iterator[Answer]],
    units: Iterable[Unit],
    *,
    workers: int | Executor,
    crashed: Crashed[Unit, Answer],
) -> Iterator[tuple[Unit, list[Answer]]]:
    """Every unit with the answers to its parts, in the order in which units are finished.

    Args:
        work: prepares for a unit, then answers its parts in turn. Unless it works here, it is a
            module-level function, and it, units and answers are pickled.
        units: what to work on; asked for as there is room.
        workers: number of processes beside this one, 0 (:data:`IN_THIS_PROCESS`) to work here; or
            an executor, which is left as it is.
        crashed: the answer to a part that ends the process it is worked on in; is given the unit,
            the part counted from 0, and a reason that names the signal.

    Raises:
        ValueError: fewer than 0 workers.
        WorkerDiedError: a worker could not start, or died time and again from outside or before it
            came to a part. In the latter case all other units have been worked on.
        UnpicklableError: the work, a unit or an answer cannot be sent between processes.
    """
    with nullcontext(workers) if not isinstance(workers, int) else _beside(workers) as executor:
        yield from _finished(executor, work, iter(units), crashed)


def _beside(workers: int) -> Executor:
    if workers < 0:
        raise ValueError(f"workers is {workers}; allowed: 0 (in this process) or more")
    return Serial() if workers == IN_THIS_PROCESS else Processes(workers)


def _finished(
    executor: Executor,
    work: Work[Unit, Answer],
    units: Iterator[Unit],
    crashed: Crashed[Unit, Answer],
) -> Iterator[tuple[Unit, list[Answer]]]:
    in_flight: dict[Future[list[Answer]], Unit] = {}
    given_up: list[str] = []
    try:
        while True:
            for unit in islice(units, max(0, executor.room - len(in_flight))):
                in_flight[executor.submit(work, unit, crashed)] = unit
            if not in_flight:
                break
            for future in wait(in_flight, LOOK, FIRST_COMPLETED).done:
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

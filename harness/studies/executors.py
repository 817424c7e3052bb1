"""Where units of work run: in this process, or in others that may die. All give equal answers.

A unit has parts, and every part one answer. A worker sends each answer as soon as it has it: a
death costs the part in flight, and a fresh worker goes on with the unit. What the death says of
the part is decided by its cause:

* The process ended by itself: an engine aborted, made an invalid access, or called ``exit``. The
  part is tried once more, as the first in a fresh process, and counts as crashed when that ends by
  itself, too. A single crash proves nothing: it may be the late effect of a part before it, or a
  signal that somebody sent.
* It was ended from outside, by somebody or for want of memory. That says nothing of the part, which
  is tried again. After a few times in vain its unit is given up and the others go on.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator, Sequence
from multiprocessing.connection import wait
from typing import Any, Generic, Protocol, Self, TypeVar

from harness.studies.workers import Ending, Event, RemoteTracebackError, Worker

IN_THIS_PROCESS = 0
"""Number of workers that means none: for debugging, and where starting processes takes too long.
What kills a worker then kills the caller."""

_CRASHES = 2
"""Processes that must end by themselves on a part for it to count as crashed."""

_RETRIES = 3
"""How often a part is tried again after a death that says nothing of it."""

_MOST_STILLBORN = 10
"""How many processes in a row may be ended from outside before they can begin: that has nothing to
do with any unit."""


class WorkUnit(Protocol):
    """Parts that are worked on one after the other."""

    def __len__(self) -> int:
        """Number of parts, 1 or more."""
        ...

    def without(self, done: int) -> Self:
        """What is left when the first ``done`` parts are done."""
        ...

    def describe(self, part: int) -> str:
        """A part for people, such as ``sme on layout "A"``."""
        ...


class SinglePart:
    """Base of units with one part: there is never anything to leave out."""

    __slots__ = ()

    def __len__(self) -> int:
        return 1

    def without(self, done: int) -> Self:
        """See :meth:`WorkUnit.without`."""
        return self


Unit = TypeVar("Unit", bound=WorkUnit)
Answer = TypeVar("Answer")


class WorkerDiedError(RuntimeError):
    """Workers died where nothing can be said of the work; what was finished before is kept."""


def run_units(
    work: Callable[[Unit], Iterator[Answer]],
    units: Sequence[Unit],
    *,
    workers: int,
    crashed: Callable[[Unit, int, str], Answer],
) -> Iterator[tuple[Unit, list[Answer]]]:
    """Every unit with the answers to its parts, in the order in which units are finished.

    Args:
        work: prepares for a unit, then answers its parts in turn. With workers it is a module-level
            function, and it, units and answers are pickled.
        units: what to work on.
        workers: number of processes beside this one; 0 (:data:`IN_THIS_PROCESS`) works here.
        crashed: the answer to a part that ends the process it is worked on in; is given the unit,
            the part counted from 0, and a reason that names the signal.

    Raises:
        ValueError: fewer than 0 workers.
        WorkerDiedError: a worker could not start, or died time and again from outside or before it
            came to a part. In the latter case all other units have been worked on.
        UnpicklableError: the work, a unit or an answer cannot be sent between processes.
    """
    if workers < 0:
        raise ValueError(f"workers is {workers}; allowed: 0 (in this process) or more")
    if workers == IN_THIS_PROCESS:
        for unit in units:
            yield unit, list(work(unit))
        return
    yield from _Run(work, units, crashed).over(workers)


class _Task(Generic[Unit, Answer]):
    """A unit that a worker is at, and what is known of it."""

    def __init__(self, unit: Unit) -> None:
        self.unit = unit
        self.answers: list[Answer] = []
        self.heard: Event | None = None
        """What its present worker has come to: nothing yet, ``READY`` or ``PREPARED``."""
        self.crashes = self.deaths = 0
        """Processes that have ended on the part in flight, by themselves and otherwise."""

    @property
    def whole(self) -> bool:
        """Every part has its answer."""
        return len(self.answers) == len(self.unit)

    def add(self, answer: Answer) -> None:
        """Take the answer to the part in flight; the next one has a clean record."""
        assert not self.whole, f"more than the {len(self.unit)} answers that were asked for"
        self.answers.append(answer)
        self.crashes = self.deaths = 0

    def __str__(self) -> str:
        part = self.unit.describe(len(self.answers))
        return part if self.heard is Event.PREPARED else f"the preparation for {part}"


class _Run(Generic[Unit, Answer]):
    """Units over workers. Each worker is at one; when it dies, another goes on with the unit."""

    def __init__(
        self,
        work: Callable[[Unit], Iterator[Answer]],
        units: Sequence[Unit],
        crashed: Callable[[Unit, int, str], Answer],
    ) -> None:
        self._work, self._crashed = work, crashed
        self._waiting = deque(_Task[Unit, Answer](unit) for unit in units)
        self._busy: dict[Any, tuple[Worker, _Task[Unit, Answer]]] = {}
        self._idle: list[Worker] = []
        self._given_up: list[str] = []
        self._stillborn = 0

    def over(self, workers: int) -> Iterator[tuple[Unit, list[Answer]]]:
        """Work on all units."""
        try:
            for _ in range(min(workers, len(self._waiting))):
                self._hire(self._waiting.popleft())
            while self._busy:
                for line in wait(list(self._busy)):
                    worker, task = self._busy[line]
                    if self._heed(worker, task):
                        yield task.unit, task.answers
            for worker in self._idle:
                worker.end()
        finally:
            for worker in [*self._idle, *(worker for worker, _ in self._busy.values())]:
                worker.kill()
        if self._given_up:
            first, *others = self._given_up
            more = f" ({len(others)} more likewise)" if others else ""
            raise WorkerDiedError(
                f"{first}{more}; nothing is recorded of it, what is finished is kept: run it again "
                "to go on"
            )

    def _heed(self, worker: Worker, task: _Task[Unit, Answer]) -> bool:
        """Do what a worker's next message asks for; returns whether its unit is finished now."""
        event, value = worker.hear()
        match event:
            case Event.READY:
                task.heard, self._stillborn = event, 0
                worker.give(task.unit.without(len(task.answers)))
            case Event.PREPARED:
                task.heard = event
            case Event.ANSWER:
                task.add(value)
            case Event.DONE:
                assert task.whole, f"{len(task.answers)} answers to {len(task.unit)} parts"
                self._go_on(worker)
                return True
            case Event.FAILED:
                error, text = value
                raise error from RemoteTracebackError(text)
            case Event.ENDED:
                del self._busy[worker.connection]
                self._replace(task, value)
                return task.whole
        return False

    def _hire(self, task: _Task[Unit, Answer]) -> None:
        task.heard = None
        worker = Worker(self._work)
        self._busy[worker.connection] = (worker, task)

    def _go_on(self, worker: Worker) -> None:
        """Give a worker the next unit, or let it go."""
        if self._waiting:
            task = self._waiting.popleft()
            self._busy[worker.connection] = (worker, task)
            task.heard = Event.READY
            worker.give(task.unit)
        else:
            del self._busy[worker.connection]
            worker.dismiss()
            self._idle.append(worker)

    def _replace(self, task: _Task[Unit, Answer], ending: Ending) -> None:
        """Start a worker in place of one that has died, for what it has left or the next unit."""
        if not task.whole and self._is_hopeless(task, ending):
            self._given_up.append(f"{task}: its worker process ended {ending}, time and again")
        elif not task.whole:
            self._hire(task)
            return
        if self._waiting:
            self._hire(self._waiting.popleft())

    def _is_hopeless(self, task: _Task[Unit, Answer], ending: Ending) -> bool:
        """Put a death on record; returns whether it has been one too many to try again."""
        if task.heard is Event.PREPARED and ending.by_itself:
            task.crashes += 1
            if task.crashes == _CRASHES:
                reason = f"its process ended {ending}, the second in a row"
                task.add(self._crashed(task.unit, len(task.answers), reason))
            return False
        if task.heard is None:
            self._stillborn += 1
            if ending.code < 0 and self._stillborn <= _MOST_STILLBORN:
                return False
            raise WorkerDiedError(
                f"a worker process ended {ending} before it could begin; what is finished is kept "
                '(a script of your own needs `if __name__ == "__main__":` around the call)'
            )
        task.deaths += 1
        return task.deaths > _RETRIES

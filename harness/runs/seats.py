"""Where units are worked on in other processes that may die, and what a death says of a part.

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

import queue
import threading
from collections.abc import Callable, Iterator
from typing import Any, Generic, Protocol, Self, TypeVar

from steadyload.errors import FailedError
from steadyload.runs.workers import Ending, Event, RemoteTracebackError, Worker

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


Unit = TypeVar("Unit", bound=WorkUnit)
Answer = TypeVar("Answer")
Work = Callable[[Unit], Iterator[Answer]]
"""Prepares for a unit, then answers its parts in turn."""
Crashed = Callable[[Unit, int, str], Answer]
"""The answer to a part that ends the process it is worked on in; is given the unit, the part
counted from 0, and a reason that names the signal."""


class WorkerDiedError(FailedError):
    """Workers died where nothing can be said of the work; what was finished before is kept."""


class GivenUpError(WorkerDiedError):
    """A unit is left out; the others can be worked on."""


class _ClosedError(RuntimeError):
    """Its seat was closed under a unit: nobody waits for the answers any more."""


class _Task(Generic[Unit, Answer]):
    """A unit that workers are at, and what is known of it."""

    def __init__(self, unit: Unit, crashed: Crashed[Unit, Answer]) -> None:
        self._unit, self._crashed = unit, crashed
        self.answers: list[Answer] = []
        self.heard: Event | None = None
        """What its present worker has come to: nothing yet, ``READY`` or ``PREPARED``."""
        self._crashes = self._deaths = 0
        """Processes that have ended on the part in flight, by themselves and otherwise."""

    @property
    def whole(self) -> bool:
        """Every part has its answer."""
        return len(self.answers) == len(self._unit)

    @property
    def left(self) -> Unit:
        """What has no answer yet."""
        return self._unit.without(len(self.answers))

    def add(self, answer: Answer) -> None:
        """Take the answer to the part in flight; the next one has a clean record."""
        assert not self.whole, f"more than the {len(self._unit)} answers that were asked for"
        self.answers.append(answer)
        self._crashes = self._deaths = 0

    def mourn(self, ending: Ending) -> None:
        """Put on record that a process ended on the part in flight, or while preparing for it.

        Raises:
            GivenUpError: it has been one too many to try again.
        """
        if self.heard is Event.PREPARED and ending.by_itself:
            self._crashes += 1
            if self._crashes == _CRASHES:
                reason = f"its process ended {ending}, the second in a row"
                self.add(self._crashed(self._unit, len(self.answers), reason))
            return
        self._deaths += 1
        if self._deaths > _RETRIES:
            raise GivenUpError(f"{self}: its worker process ended {ending}, time and again")

    def __str__(self) -> str:
        part = self._unit.describe(len(self.answers))
        return part if self.heard is Event.PREPARED else f"the preparation for {part}"


class Seat:
    """A place with one worker at a time, who stays for as long as the work is the same.

    One thread asks for answers; any thread may close it.
    """

    def __init__(self) -> None:
        self._worker: Worker | None = None
        self._work: Work[Any, Any] | None = None
        self._stillborn = 0
        self._closed = False
        self._lock = threading.Lock()

    def answers(
        self, work: Work[Unit, Answer], unit: Unit, crashed: Crashed[Unit, Answer]
    ) -> list[Answer]:
        """The answers to a unit's parts, over as many workers as that takes.

        Raises:
            GivenUpError: workers are ended from outside time and again.
            WorkerDiedError: a worker could not start.
            UnpicklableError: the work, the unit or an answer cannot be sent between processes.
            Exception: what the work raised.
        """
        task = _Task(unit, crashed)
        if self._work != work:
            self.dismiss()
        if self._worker is not None:
            task.heard = Event.READY
            self._worker.give(unit)
        while not task.whole:
            worker = self._worker or self._hire(work, task)
            ending = self._hear_out(worker, task)
            if ending is not None:
                self._worker = None
                self._mourn(task, ending)
        return task.answers

    def dismiss(self) -> None:
        """Let the worker go, if there is one, and wait for its end."""
        if self._worker is not None:
            self._worker.dismiss()
            self._worker.end()
            self._worker = None

    def close(self) -> None:
        """End the worker now, and hire no other."""
        with self._lock:
            self._closed = True
            if self._worker is not None:
                self._worker.stop()

    def _hire(self, work: Work[Any, Any], task: _Task[Any, Any]) -> Worker:
        task.heard = None
        with self._lock:
            if self._closed:
                raise _ClosedError
            self._work, self._worker = work, Worker(work)
            return self._worker

    def _hear_out(self, worker: Worker, task: _Task[Any, Any]) -> Ending | None:
        """Do what a worker asks for until the unit is done, or until it ends, and how."""
        while True:
            event, value = worker.hear()
            match event:
                case Event.READY:
                    task.heard, self._stillborn = event, 0
                    worker.give(task.left)
                case Event.PREPARED:
                    task.heard = event
                case Event.ANSWER:
                    task.add(value)
                case Event.DONE:
                    assert task.whole, f"{task}: was not answered"
                    return None
                case Event.FAILED:
                    error, text = value
                    raise error from RemoteTracebackError(text)
                case Event.ENDED:
                    return value

    def _mourn(self, task: _Task[Any, Any], ending: Ending) -> None:
        if self._closed:
            raise _ClosedError
        if task.heard is None:
            self._stillborn += 1
            if ending.code < 0 and self._stillborn <= _MOST_STILLBORN:
                return
            raise WorkerDiedError(
                f"a worker process ended {ending} before it could begin; what is finished is kept "
                '(a script of your own needs `if __name__ == "__main__":` around the call)'
            )
        if not task.whole:
            task.mourn(ending)


class Seats:
    """A number of seats, for that many threads at a time.

    Args:
        count: 1 or more. Workers are hired when they are needed.
    """

    def __init__(self, count: int) -> None:
        self._all = [Seat() for _ in range(count)]
        # The one used last comes first, so that no more workers are hired than are needed.
        self._free: queue.LifoQueue[Seat] = queue.LifoQueue()
        for seat in self._all:
            self._free.put(seat)

    def __len__(self) -> int:
        return len(self._all)

    def answers(
        self, work: Work[Unit, Answer], unit: Unit, crashed: Crashed[Unit, Answer]
    ) -> list[Answer]:
        """See :meth:`Seat.answers`; waits for a free seat."""
        seat = self._free.get()
        try:
            return seat.answers(work, unit, crashed)
        finally:
            self._free.put(seat)

    def dismiss(self) -> None:
        """Let all workers go; nobody asks for answers now."""
        for seat in self._all:
            seat.dismiss()

    def close(self) -> None:
        """End all workers now."""
        for seat in self._all:
            seat.close()

"""A pool of worker processes, and what becomes of a part whose worker dies.

A unit has parts, and every part has one answer. A worker sends each answer as soon as it has it, so
that a worker that dies costs the part in flight, and a fresh worker goes on with the unit. What
becomes of that part depends on how the process ended:

* By itself: an engine aborted, made an invalid access, or called ``exit``. The part is tried once
  more, as the first in a fresh process, and counts as crashed when that ends by itself, too. A
  single crash proves nothing: it may be the late effect of a part before it, or a signal that
  somebody sent.
* It was killed from outside, by somebody or for want of memory. That says nothing of the part,
  which is tried again. After a few retries its unit is given up, and the others go on.
* The pool killed it because the part took longer than its hard limit: the part has timed out.
"""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any, Generic, Protocol, Self, TypeVar

from steadyload.errors import FailedError
from steadyload.runs.worker import Event, Exit, RemoteTracebackError, State, Worker

UNITS_PER_WORKER = 2
"""Units an executor takes for each worker: one that is worked on, one that waits."""

_CRASHES = 2
"""Processes in a row that must end by themselves on a part for it to count as crashed."""

_RETRIES = 3
"""How often a part is tried again after its worker was killed from outside."""

_FAILED_STARTS = 10
"""How many processes in a row may be killed before they have started: no unit is the cause."""


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
NoAnswer = Callable[[Unit, int, str], Answer]
"""The answer to a part that the work cannot answer itself; is given the unit, the part counted from
0, and the reason."""


class WorkerDiedError(FailedError):
    """Workers died where nothing can be said of the work; what was finished before is kept."""


class GivenUpError(WorkerDiedError):
    """A unit is left out; the others can be worked on."""


class _PoolClosedError(RuntimeError):
    """The pool was closed during a task: nobody waits for the answers any more."""


def all_cores() -> int:
    """How many workers fill this machine."""
    return os.cpu_count() or 1


@dataclass(frozen=True, slots=True)
class PartLimit(Generic[Unit, Answer]):
    """Hard limit on the time of a part: its worker is killed, whatever native call it is in.

    The time of a part begins with the answer to the part before it; that of the first one, when the
    work has prepared for the unit.

    Args:
        seconds: wall time that a part may take.
        timed_out: the answer to a part that takes longer.
    """

    seconds: float
    timed_out: NoAnswer[Unit, Answer]


@dataclass(frozen=True, slots=True)
class Task(Generic[Unit, Answer]):
    """A unit and what is to be done with it; see :func:`steadyload.runs.executors.run_units`."""

    work: Work[Unit, Answer]
    unit: Unit
    crashed: NoAnswer[Unit, Answer]
    limit: PartLimit[Unit, Answer] | None = None


class _Progress(Generic[Unit, Answer]):
    """The answers to a task so far, and the workers that died on the part in flight."""

    def __init__(self, task: Task[Unit, Answer]) -> None:
        self._task = task
        self.answers: list[Answer] = []
        self._crashes = self._kills = self._failed_starts = 0

    @property
    def is_complete(self) -> bool:
        """Every part has its answer."""
        return len(self.answers) == len(self._task.unit)

    def remaining(self) -> Unit:
        """The parts without an answer."""
        return self._task.unit.without(len(self.answers))

    def add(self, answer: Answer) -> None:
        """Record the answer to the part in flight."""
        assert not self.is_complete, f"more than the {len(self._task.unit)} answers asked for"
        self.answers.append(answer)
        self._crashes = self._kills = 0

    def add_timed_out(self, limit: PartLimit[Unit, Answer]) -> None:
        """Record that the part in flight took longer than it may."""
        if not self.is_complete:
            reason = f"no answer within {limit.seconds:g} s; its process was killed"
            self.add(limit.timed_out(self._task.unit, len(self.answers), reason))

    def add_death(self, state: State, how: Exit) -> None:
        """Record that a worker has died in a state: to be tried again, crashed, or given up.

        Raises:
            GivenUpError: it was killed from outside once too often.
            WorkerDiedError: it could not start.
        """
        if state is State.STARTING:
            self._failed_starts += 1
            if how.code >= 0 or self._failed_starts > _FAILED_STARTS:
                raise WorkerDiedError(
                    f"a worker process ended {how} before it could begin; what is finished is kept "
                    '(a script of your own needs `if __name__ == "__main__":` around the call)'
                )
        elif self.is_complete:
            return
        elif state is State.ANSWERING and how.by_itself:
            self._crashes += 1
            if self._crashes == _CRASHES:
                reason = f"its process ended {how}, the second in a row"
                self.add(self._task.crashed(self._task.unit, len(self.answers), reason))
        else:
            self._kills += 1
            if self._kills > _RETRIES:
                part = self._task.unit.describe(len(self.answers))
                what = part if state is State.ANSWERING else f"the preparation for {part}"
                raise GivenUpError(f"{what}: its worker process ended {how}, time and again")

    def add_start(self) -> None:
        """Record that a worker has started."""
        self._failed_starts = 0


class Processes:
    """Pool of worker processes beside this one, which stay for as long as the work is the same.

    Args:
        workers: how many, 1 or more; None for one a core. They are started as they are needed.
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
        """See :attr:`steadyload.runs.executors.Executor.room`."""
        return UNITS_PER_WORKER * self._count

    def submit(self, task: Task[Unit, Answer]) -> Future[list[Answer]]:
        """See :meth:`steadyload.runs.executors.Executor.submit`."""
        return self._threads.submit(self.answers, task)

    def answers(self, task: Task[Unit, Answer]) -> list[Answer]:
        """The answers to a unit's parts, by the worker of this thread and those that replace it.

        Raises:
            GivenUpError: workers were killed from outside time and again.
            WorkerDiedError: a worker could not start.
            UnpicklableError: the work, the unit or an answer cannot be sent between processes.
            Exception: what the work raised.
        """
        progress, thread = _Progress(task), threading.get_ident()
        while not progress.is_complete:
            worker = self._worker(thread, task)
            try:
                self._work_on(task, progress, worker)
            finally:
                if worker.state is not State.IDLE:
                    worker.kill()
                    del self._workers[thread]
        return progress.answers

    def _worker(self, thread: int, task: Task[Any, Any]) -> Worker:
        worker = self._workers.get(thread)
        if worker is not None and worker.work == task.work:
            return worker
        if worker is not None:
            self._workers.pop(thread).shut_down()
        with self._lock:
            if self._closed:
                raise _PoolClosedError
            self._workers[thread] = worker = Worker(task.work)
            return worker

    def _work_on(
        self, task: Task[Any, Answer], progress: _Progress[Any, Answer], worker: Worker
    ) -> None:
        """Let a worker work on a task until the unit is done or the worker has died."""
        if worker.state is State.IDLE:
            worker.send(progress.remaining())
        while True:
            limit = task.limit if worker.state is State.ANSWERING else None
            event, value = worker.receive(None if limit is None else limit.seconds)
            match event:
                case Event.READY:
                    progress.add_start()
                    worker.send(progress.remaining())
                case Event.ANSWER:
                    progress.add(value)
                case Event.DONE:
                    assert progress.is_complete, "a part was not answered"
                    return None
                case Event.FAILED:
                    error, text = value
                    raise error from RemoteTracebackError(text)
                case Event.TIMEOUT:
                    assert limit is not None
                    worker.kill()
                    return progress.add_timed_out(limit)
                case Event.DIED if self._closed:
                    raise _PoolClosedError
                case Event.DIED:
                    return progress.add_death(worker.state, value)

    def close(self) -> None:
        """Kill all workers now, and start no other."""
        with self._lock:
            self._closed = True
            for worker in [*self._workers.values()]:
                worker.signal_kill()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *raised: object) -> None:
        if any(raised):
            self.close()
        self._threads.shutdown(cancel_futures=True)
        for worker in self._workers.values():
            worker.shut_down()

"""A worker process of the pool: it is sent units and reports part by part, until it is shut down.

The pool therefore knows at which part of a unit a worker was when it died.
"""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import pickle
import signal
import threading
import time
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from enum import Enum
from multiprocessing import resource_tracker
from multiprocessing.connection import Connection
from multiprocessing.reduction import ForkingPickler
from typing import Any

Work = Callable[[Any], Iterator[Any]]
"""Prepares for a unit of work, then answers its parts in turn."""

_ENVIRONMENT = {
    "PYTHONSAFEPATH": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "OMP_NUM_THREADS": "1",
    "MKL_NUM_THREADS": "1",
}
"""Variables of workers. A new interpreter imports nothing from the working directory; what this
process can import it can, too, because multiprocessing hands it ``sys.path``. Linear algebra uses
one thread: processes fill the cores already, and threads that wait for each other by spinning made
small factorisations ten times as slow."""

_FATAL_ERRORS = frozenset(
    {signal.SIGABRT, signal.SIGSEGV, signal.SIGBUS, signal.SIGFPE, signal.SIGILL}
)
"""Signals that native code brings upon itself; others come from outside, as from a user or from a
system that is out of memory."""

_START_LOCK = threading.Lock()
"""Held while a process is started, because the environment is changed for it."""

_PATIENCE = 10.0
"""Seconds for a worker whose connection was closed to end by itself."""


class UnpicklableError(TypeError):
    """Something cannot be sent to a worker process or back."""


class RemoteTracebackError(Exception):
    """Cause of an exception that was raised in a worker: its traceback there, as text."""

    def __str__(self) -> str:
        return f"in a worker process:\n\n{self.args[0]}"


class Event(Enum):
    """Report of a worker. Values come with some: an answer, an exception and its traceback."""

    READY = "the process has started"
    PREPARED = "the unit's parts follow"
    ANSWER = "a part is done"
    DONE = "the unit is done"
    FAILED = "the work raised an exception"
    DIED = "the process has ended"
    TIMEOUT = "there was no report in time"


class State(Enum):
    """What a worker is doing; for one that has died, what it was doing."""

    STARTING = "starting"
    IDLE = "idle"
    PREPARING = "preparing for a unit"
    ANSWERING = "answering a unit's parts"


_AFTER = {
    Event.READY: State.IDLE,
    Event.PREPARED: State.ANSWERING,
    Event.DONE: State.IDLE,
    Event.FAILED: State.IDLE,
}
"""States that begin with an event."""


@dataclass(frozen=True, slots=True)
class Exit:
    """How a process ended; ``code`` as of :attr:`multiprocessing.Process.exitcode`."""

    code: int

    @property
    def by_itself(self) -> bool:
        """Whether what ran in the process ended it, rather than something outside."""
        return self.code >= 0 or -self.code in _FATAL_ERRORS

    def __str__(self) -> str:
        if self.code >= 0:
            return f"with exit status {self.code}"
        with contextlib.suppress(ValueError):
            return f"by {signal.Signals(-self.code).name}"
        return f"by signal {-self.code}"


class Worker:
    """A started process and the connection to it.

    Args:
        work: a module-level function.

    Raises:
        UnpicklableError: ``work`` cannot be sent.
    """

    def __init__(self, work: Work) -> None:
        pickled(work)  # raises before there is a process
        self.work, self.state = work, State.STARTING
        # spawn: engines must not inherit each other's native state.
        context = multiprocessing.get_context("spawn")
        self._connection, theirs = context.Pipe()
        self._process = context.Process(target=_serve, args=(theirs, work))
        with theirs, _START_LOCK, worker_environment(), interrupts_blocked():
            self._process.start()

    def send(self, unit: Any) -> None:
        """Send a unit to an idle worker.

        Raises:
            UnpicklableError: it cannot be sent.
        """
        message = pickled(unit)
        self.state = State.PREPARING
        with contextlib.suppress(OSError):  # a worker that has died is found out by `receive`
            self._connection.send_bytes(message)

    def receive(self, seconds: float | None = None) -> tuple[Event, Any]:
        """The next report, waiting for it; with ``DIED`` comes an :class:`Exit`.

        Args:
            seconds: wall time after which the event is ``TIMEOUT``; None for no limit.
        """
        if not self._connection.poll(seconds):
            return Event.TIMEOUT, None
        try:
            event, value = self._connection.recv()
        except (EOFError, OSError):
            self._process.join(_PATIENCE)
            self.kill()
            return Event.DIED, Exit(self._exit_code())
        self.state = _AFTER.get(event, self.state)
        return event, value

    def _exit_code(self) -> int:
        """Another thread that starts a process polls all of them, and may be told first."""
        deadline = time.monotonic() + _PATIENCE
        while (code := self._process.exitcode) is None and time.monotonic() < deadline:
            time.sleep(0.001)
        assert code is not None, "somebody else waits for processes that are ours"
        return code

    def shut_down(self) -> None:
        """Let an idle worker end by itself, and wait for it."""
        self._connection.close()
        self._process.join(_PATIENCE)
        self.kill()

    def signal_kill(self) -> None:
        """Kill the process while another thread may wait in :meth:`receive`, which reports it."""
        self._process.kill()

    def kill(self) -> None:
        """Kill the process and release its resources; nobody waits in :meth:`receive`."""
        self._process.kill()
        self._process.join()
        self._connection.close()


def _serve(connection: Connection, work: Work) -> None:
    """Loop of a worker process: units of work until the connection is closed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
    _end_with_parent()
    with contextlib.suppress(BrokenPipeError, ConnectionResetError):  # the parent has gone
        connection.send((Event.READY, None))
        while True:
            try:
                message = connection.recv_bytes()
            except EOFError:
                return
            try:
                answers = work(pickle.loads(message))  # noqa: S301 - from the parent process
                connection.send((Event.PREPARED, None))
                for answer in answers:
                    connection.send_bytes(pickled((Event.ANSWER, answer)))
                connection.send((Event.DONE, None))
            except Exception as error:
                report = (_picklable(error), traceback.format_exc())
                connection.send((Event.FAILED, report))


def _picklable(error: Exception) -> Exception:
    """The exception, or one with its text where it cannot be sent."""
    try:
        pickle.loads(pickle.dumps(error))  # noqa: S301 - what was dumped here
    except Exception:
        return RuntimeError(f"{type(error).__name__}: {error}")
    return error


def pickled(thing: object) -> bytes:
    """A thing as it is sent to another process.

    Raises:
        UnpicklableError: it cannot be sent.
    """
    try:
        return bytes(ForkingPickler.dumps(thing))
    except Exception as error:
        raise UnpicklableError(
            f"{thing!r:.200} cannot be sent between processes ({error}); allowed: functions and "
            "classes of a module, and what they hold"
        ) from error


@contextmanager
def worker_environment() -> Iterator[None]:
    """Processes that are started meanwhile have the variables of workers; a user's own stay."""
    added = [name for name in _ENVIRONMENT if name not in os.environ]
    os.environ.update({name: _ENVIRONMENT[name] for name in added})
    try:
        yield
    finally:
        for name in added:
            os.environ.pop(name, None)


@contextmanager
def interrupts_blocked() -> Iterator[None]:
    """A process that this thread starts meanwhile gets no interrupts until it asks for them.

    Ctrl-C reaches the whole process group, and only the parent answers. A worker ignores
    interrupts, but only once it has started. Threads that are started meanwhile hand the block on
    to all processes that they start.
    """
    resource_tracker.ensure_running()  # when it starts, it unblocks interrupts in this thread
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _end_with_parent() -> None:
    """Make a worker end when the process that started it is killed, instead of waiting forever."""
    parent = multiprocessing.parent_process()
    assert parent is not None

    def watch() -> None:
        parent.join()
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()

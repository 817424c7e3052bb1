"""One worker: a process of its own, the line to it, and how it ended.

A worker is told what to do and answers part by part, so that whoever asked knows what it was at
when it died.
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

_THREADS = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")

_RAISED_BY_LIBRARIES = frozenset(
    {signal.SIGABRT, signal.SIGSEGV, signal.SIGBUS, signal.SIGFPE, signal.SIGILL}
)
"""Signals that native code brings upon itself; others come from outside, as from a user or from a
system that is out of memory."""

_STARTING = threading.Lock()
"""Held while a process is started, because the environment is changed for it."""

_LAST_WORDS = 10.0
"""Seconds for a worker that has hung up, or has nothing left to do, to end by itself."""


class UnpicklableError(TypeError):
    """Something cannot be sent to a worker process or back."""


class RemoteTracebackError(Exception):
    """Cause of an exception that was raised in a worker: its traceback there, as text."""

    def __str__(self) -> str:
        return f"in a worker process:\n\n{self.args[0]}"


class Event(Enum):
    """What a worker says. Values travel beside: an answer, or an exception and its traceback."""

    READY = "the process has started"
    PREPARED = "the unit's parts follow"
    ANSWER = "a part is done"
    DONE = "the unit is done"
    FAILED = "the work raised an exception"
    ENDED = "the process has ended"


@dataclass(frozen=True, slots=True)
class Ending:
    """How a process ended; ``code`` as of :attr:`multiprocessing.Process.exitcode`."""

    code: int

    @property
    def by_itself(self) -> bool:
        """Whether what ran in the process ended it, rather than something outside."""
        return self.code >= 0 or -self.code in _RAISED_BY_LIBRARIES

    def __str__(self) -> str:
        if self.code >= 0:
            return f"with exit status {self.code}"
        with contextlib.suppress(ValueError):
            return f"by {signal.Signals(-self.code).name}"
        return f"by signal {-self.code}"


class Worker:
    """A started process and the line to it.

    Args:
        work: a module-level function.

    Raises:
        UnpicklableError: ``work`` cannot be sent.
    """

    def __init__(self, work: Work) -> None:
        # spawn: engines must not inherit each other's native state.
        context = multiprocessing.get_context("spawn")
        self.connection, theirs = context.Pipe()
        self._process = context.Process(target=_serve, args=(theirs, work))
        try:
            with _STARTING, _one_thread(), interrupts_held_back():
                self._process.start()
        except (pickle.PicklingError, AttributeError, TypeError) as error:
            self.connection.close()
            raise _unpicklable(work, error) from error
        finally:
            theirs.close()

    def give(self, unit: Any) -> None:
        """Hand over a unit of work, once the worker is ready for one.

        Raises:
            UnpicklableError: it cannot be sent.
        """
        message = pickled(unit)
        with contextlib.suppress(OSError):  # one that has died says so when it is heard next
            self.connection.send_bytes(message)

    def hear(self) -> tuple[Event, Any]:
        """The next thing that it says, waiting for it; with ``ENDED`` comes an :class:`Ending`."""
        try:
            return self.connection.recv()
        except (EOFError, OSError):
            self._process.join(_LAST_WORDS)
            self.kill()
            return Event.ENDED, Ending(self._exit_code())

    def _exit_code(self) -> int:
        """Another thread that starts a process asks after all there are, and may be told first."""
        deadline = time.monotonic() + _LAST_WORDS
        while (code := self._process.exitcode) is None and time.monotonic() < deadline:
            time.sleep(0.001)
        assert code is not None, "somebody else waits for processes that are ours"
        return code

    def dismiss(self) -> None:
        """Let it go: it ends when it has nothing left to do. To be followed by :meth:`end`."""
        self.connection.close()

    def end(self) -> None:
        """Wait for a worker that was dismissed."""
        self._process.join(_LAST_WORDS)
        self.kill()

    def stop(self) -> None:
        """End it now, whoever waits for what it says: that hears of its end."""
        self._process.kill()

    def kill(self) -> None:
        """End it now; nobody else listens to it."""
        self._process.kill()
        self._process.join()
        self.connection.close()


def _serve(connection: Connection, work: Work) -> None:
    """What a worker does: units of work until there are no more."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
    _end_with_parent()
    with contextlib.suppress(BrokenPipeError, ConnectionResetError):  # nobody listens any more
        connection.send((Event.READY, None))
        while True:
            try:
                message = connection.recv_bytes()
            except EOFError:
                return
            try:
                answers = work(pickle.loads(message))  # noqa: S301 - from the process above
                connection.send((Event.PREPARED, None))
                for answer in answers:
                    connection.send_bytes(pickled((Event.ANSWER, answer)))
                connection.send((Event.DONE, None))
            except Exception as error:
                told = (_picklable(error), traceback.format_exc())
                connection.send((Event.FAILED, told))


def _picklable(error: Exception) -> Exception:
    """The exception, or one that says the same where it would not survive the journey."""
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
        raise _unpicklable(thing, error) from error


def _unpicklable(thing: object, error: Exception) -> UnpicklableError:
    return UnpicklableError(
        f"{thing!r:.200} cannot be sent between processes ({error}); allowed: functions and "
        "classes of a module, and what they hold"
    )


@contextmanager
def _one_thread() -> Iterator[None]:
    """Linear algebra in a worker uses one thread.

    Processes fill the cores already; threads beside them wait for each other by spinning, which
    made small factorisations ten times as slow. Libraries read these variables when they load.
    """
    before = {name: os.environ.get(name) for name in _THREADS}
    os.environ.update({name: "1" for name, value in before.items() if value is None})
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)


@contextmanager
def interrupts_held_back() -> Iterator[None]:
    """A process that this thread starts meanwhile gets no interrupts until it asks for them.

    Ctrl-C reaches the whole process group, and only the parent answers. A worker says that it
    ignores interrupts, but only once it has started. Threads that are started meanwhile hand it
    on to all processes that they start.
    """
    resource_tracker.ensure_running()  # when it starts, it lets this thread have interrupts again
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

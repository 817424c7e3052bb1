"""A worker process, and the object by which the pool speaks with it.

A worker receives units of work and sends the result of every part as soon as it is known. The part
at which a process ended is therefore known, too.
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
from enum import Enum, auto
from multiprocessing import resource_tracker, spawn
from multiprocessing.connection import Connection
from multiprocessing.context import SpawnProcess
from multiprocessing.reduction import ForkingPickler
from typing import Any

from steadyload.time_limit import BACKSTOP, exceeded, seconds_of_process

_ENVIRONMENT = {
    "PYTHONSAFEPATH": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "OMP_NUM_THREADS": "1",
    "MKL_NUM_THREADS": "1",
    "MUJOCO_GL": "disable",
}
"""Variables of workers. A new interpreter imports nothing from the working directory; what this
process can import it can, too, because multiprocessing hands it ``sys.path``. Linear algebra uses
one thread: processes fill the cores already, and threads that wait for each other by spinning made
small factorisations ten times as slow. Nothing is rendered, as in the command itself."""

_FATAL_ERRORS = frozenset(
    {signal.SIGABRT, signal.SIGSEGV, signal.SIGBUS, signal.SIGFPE, signal.SIGILL}
)
"""Signals that native code raises in its own process; others come from outside, as from a user or
from a system that is out of memory."""

_START_LOCK = threading.Lock()
"""Held while a process is started, because the environment is changed for it."""

_GLANCE = 0.01
"""Shortest time between two looks at the CPU time of a process [s]."""

_PATIENCE = 10.0
"""Time within which a process must end after its pipe was closed [s]."""


class UnpicklableError(TypeError):
    """An object cannot be sent to a worker process or back."""


class RemoteTracebackError(Exception):
    """Cause of an exception that was raised in a worker: its traceback there, as text."""

    def __str__(self) -> str:
        return f"in a worker process:\n\n{self.args[0]}"


class Phase(Enum):
    """Phase of a worker; of one that has died, the last."""

    STARTING = auto()
    IDLE = auto()
    PREPARING = auto()
    WORKING = auto()


class PartTimeoutError(Exception):
    """A part has taken longer than it may: than the time that the message names."""


class ProcessDiedError(Exception):
    """A worker's process has ended; ``code`` as of :attr:`multiprocessing.Process.exitcode`."""

    def __init__(self, code: int, phase: Phase) -> None:
        super().__init__(code, phase)
        self.code, self.phase = code, phase

    @property
    def is_crash(self) -> bool:
        """True if code of a part ended the process, rather than something outside."""
        by_itself = self.code >= 0 or -self.code in _FATAL_ERRORS
        return by_itself and self.phase is Phase.WORKING

    def __str__(self) -> str:
        if self.code >= 0:
            return f"with exit status {self.code}"
        names = {int(known): known.name for known in signal.Signals}
        return f"by {names.get(-self.code, f'signal {-self.code}')}"


class Worker:
    """A worker process, which is started at once, and the pipe to it.

    Args:
        work: a module-level function that prepares for a unit, then yields the results of its
            parts.

    Raises:
        UnpicklableError: ``work`` cannot be sent.
    """

    def __init__(self, work: Callable[[Any], Iterator[Any]]) -> None:
        pickled(work)  # raises before there is a process
        self.work, self.phase = work, Phase.STARTING
        self.process, self._pipe = start_process(_serve, work)

    def results(self, unit: Any, seconds: float | None) -> Iterator[Any]:
        """The results of a unit's parts, each as soon as it is known; then the worker is idle.

        Args:
            unit: the unit of work.
            seconds: CPU time that a part may take, with a backstop of wall time, see
                :mod:`steadyload.time_limit`; None for no limit.

        Raises:
            PartTimeoutError: a part took longer. The process goes on.
            ProcessDiedError: the process ended.
            UnpicklableError: the unit or a result cannot be sent.
            Exception: of the work; the worker is idle.
        """
        message = pickled(unit)
        if self.phase is Phase.STARTING:
            self._receive()
        self.phase = Phase.PREPARING
        with contextlib.suppress(OSError):  # `_receive` notices a process that has ended
            self._pipe.send_bytes(message)
        self._receive()
        while True:
            result = self._receive(seconds)
            if self.phase is Phase.IDLE:
                return
            yield result

    def _receive(self, seconds: float | None = None) -> Any:
        """The next result, if the message has one; the message sets the phase."""
        if seconds is not None:
            self._wait(seconds)
        try:
            message = self._pipe.recv_bytes()
        except (EOFError, OSError):
            raise ProcessDiedError(self._exit_code(), self.phase) from None
        self.phase, result, failure = pickle.loads(message)  # noqa: S301 - from our own process
        if failure is not None:
            error, text = failure
            raise error from RemoteTracebackError(text)
        return result

    def _wait(self, seconds: float) -> None:
        """Wait for a message, or until the process has taken longer than it may."""
        pid = self.process.pid
        assert pid is not None, "it was started"
        cpu_before, begun = seconds_of_process(pid), time.monotonic()
        patience = seconds
        while not self._pipe.poll(patience):
            cpu, wall = seconds_of_process(pid) - cpu_before, time.monotonic() - begun
            if (over := exceeded(seconds, cpu, wall)) is not None:
                raise PartTimeoutError(over)
            patience = max(min(seconds - cpu, BACKSTOP * seconds - wall), _GLANCE)

    def _exit_code(self) -> int:
        """Exit code; another thread that starts a process polls all, and may read it first."""
        self.shut_down()
        deadline = time.monotonic() + _PATIENCE
        while (code := self.process.exitcode) is None and time.monotonic() < deadline:
            time.sleep(0.001)
        assert code is not None, "somebody else waits for processes that are ours"
        return code

    def shut_down(self) -> None:
        """Let an idle process end by itself, and wait for it."""
        self._pipe.close()
        self.process.join(_PATIENCE)
        self.kill()

    def kill(self) -> None:
        """Kill the process and release its resources; no thread may wait for results."""
        self.process.kill()
        self.process.join()
        self._pipe.close()


def _serve(pipe: Connection, work: Callable[[Any], Iterator[Any]]) -> None:
    """Loop of a worker process: units of work until the pipe is closed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
    threading.Thread(target=_end_with_parent, daemon=True).start()

    def send(
        phase: Phase, result: Any = None, failure: tuple[Exception, str] | None = None
    ) -> None:
        pipe.send_bytes(pickled((phase, result, failure)))

    with contextlib.suppress(EOFError, BrokenPipeError, ConnectionResetError):
        send(Phase.IDLE)
        while True:
            message = pipe.recv_bytes()
            try:
                results = work(pickle.loads(message))  # noqa: S301 - from the parent process
                send(Phase.WORKING)
                for result in results:
                    send(Phase.WORKING, result)
                send(Phase.IDLE)
            except Exception as error:
                send(Phase.IDLE, failure=(_picklable(error), traceback.format_exc()))


def _end_with_parent() -> None:
    """End this process when the one that started it is killed, whatever it is doing."""
    parent = multiprocessing.parent_process()
    assert parent is not None
    parent.join()
    os._exit(1)


def _picklable(error: Exception) -> Exception:
    """The exception, or one with its text where it cannot be sent."""
    try:
        pickle.loads(pickle.dumps(error))  # noqa: S301 - what was dumped here
    except Exception:
        return RuntimeError(f"{type(error).__name__}: {error}")
    return error


def pickled(thing: object) -> bytes:
    """An object as bytes that are sent to another process.

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


def start_process(
    target: Callable[..., None], *arguments: Any, daemon: bool = False
) -> tuple[SpawnProcess, Connection]:
    """A new interpreter that calls ``target(pipe, *arguments)``, and our end of the pipe.

    ``daemon`` is that of :class:`multiprocessing.Process`.
    """
    # spawn: engines must not inherit each other's native state.
    context = multiprocessing.get_context("spawn")
    ours, theirs = context.Pipe()
    process = context.Process(target=_begun, args=(target, theirs, *arguments), daemon=daemon)
    # A parent that is terminated while it starts a process would leave one that cannot read what
    # it is to do, and says so: it ends a moment later.
    both = {signal.SIGINT, signal.SIGTERM}
    with theirs, _START_LOCK, worker_environment(), silent_orphans(), signals_blocked(both):
        process.start()
    return process, ours


def _begun(target: Callable[..., None], *arguments: Any) -> None:
    """The new process: it can be terminated from now on."""
    signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGTERM})
    target(*arguments)


@contextmanager
def silent_orphans() -> Iterator[None]:
    """Context in which processes are started that end in silence where they cannot read their work.

    A parent that is killed while it starts a process leaves one that finds nothing, or half of it,
    in its pipe; Python prints a traceback of that.
    """
    usual = spawn.get_command_line

    def silent(**given: Any) -> list[str]:
        *command, program, last = usual(**given)
        if command[-1] != "-c":
            return [*command, program, last]
        caught = "except (EOFError, pickle.UnpicklingError): raise SystemExit(1)"
        return [*command, f"import pickle\ntry: {program}\n{caught}", last]

    spawn.get_command_line = silent
    try:
        yield
    finally:
        spawn.get_command_line = usual


@contextmanager
def worker_environment() -> Iterator[None]:
    """Context in which new processes get the variables of workers; those of the user stay."""
    added = _ENVIRONMENT.keys() - os.environ.keys()
    os.environ.update({name: _ENVIRONMENT[name] for name in added})
    try:
        yield
    finally:
        for name in added:
            os.environ.pop(name, None)


@contextmanager
def signals_blocked(numbers: set[signal.Signals]) -> Iterator[None]:
    """Context in which this thread, and processes that it starts at first, have signals blocked.

    Ctrl-C reaches the whole process group, and only the parent reacts. A worker ignores
    interrupts, but only once it has started; SIGTERM reaches it from then on. Threads that are
    started meanwhile pass the block on to all processes that they start.
    """
    resource_tracker.ensure_running()  # when it starts, it unblocks interrupts in this thread
    before = signal.pthread_sigmask(signal.SIG_BLOCK, numbers)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)

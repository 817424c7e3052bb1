"""Units of work on the workers of a Dask cluster, in processes beside them.

A Dask worker does not judge. It has seats, as the processes executor has here: what an engine does
to its process is told apart by the same code, and what Dask sees of a crash is an answer. What is
left to Dask is a worker that is lost with all on it: its units are worked on elsewhere.
"""

from __future__ import annotations

import logging
import multiprocessing
import pickle
import time
import traceback
import uuid
from collections.abc import Callable, Iterator
from concurrent.futures import CancelledError, Future
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from typing import Any, Self, TypeVar

from distributed import Client, KilledWorker, LocalCluster, Worker, get_worker
from distributed.comm import get_address_host_port
from distributed.diagnostics.plugin import WorkerPlugin

from steadyload.runs.executors import AHEAD, LOOK, ExecutorError, all_cores
from steadyload.runs.seats import (
    Answer,
    Crashed,
    GivenUpError,
    Seats,
    Unit,
    Work,
    WorkerDiedError,
    WorkUnit,
)
from steadyload.runs.workers import RemoteTracebackError, interrupts_held_back, pickled

_PATIENCE = 10.0
"""Seconds for a scheduler to answer."""

_GONE = "the Dask scheduler is gone; what is finished is kept: run it again to go on"

Told = TypeVar("Told")


class Dask:
    """Works on a Dask cluster.

    Args:
        workers: how many, of a cluster on this machine that ends with the executor; None for one a
            core.
        scheduler: address of the scheduler of another cluster, such as ``tcp://10.0.0.1:8786``. Its
            workers may come and go; all must have this package.
        patience: seconds for the scheduler to answer.

    Raises:
        ExecutorError: both were given, the scheduler does not answer, or a worker cannot import
            this package.
    """

    def __init__(
        self,
        workers: int | None = None,
        scheduler: str | None = None,
        *,
        patience: float = _PATIENCE,
    ) -> None:
        if workers is not None and scheduler is not None:
            raise ExecutorError(
                f"workers is {workers}; allowed: none beside a scheduler, which has its own"
            )
        self._seats = f"steadyload-{uuid.uuid4().hex}"
        self._room, self._asked = AHEAD, -LOOK
        with ExitStack() as stack:
            address = scheduler or stack.enter_context(_cluster_here(workers or all_cores()))
            self._client = stack.enter_context(_connected(address, patience))
            stack.enter_context(_with_seats(self._client, self._seats))
            self._executor = self._client.get_executor(pure=False)
            self._stack = stack.pop_all()

    @property
    def room(self) -> int:
        """See :attr:`steadyload.runs.executors.Executor.room`."""
        if time.monotonic() - self._asked >= LOOK:
            with suppress(OSError, TimeoutError):  # what is in flight hears of a lost scheduler
                threads = self._client.scheduler_info(n_workers=0)["total_threads"]
                self._room = AHEAD * max(1, threads)
            self._asked = time.monotonic()
        return self._room

    def submit(
        self, work: Work[Unit, Answer], unit: Unit, crashed: Crashed[Unit, Answer]
    ) -> Future[list[Answer]]:
        """See :meth:`steadyload.runs.executors.Executor.submit`."""
        if self._client.status == "closed":
            raise WorkerDiedError(_GONE)
        # As bytes, because what they stand for concerns neither the scheduler nor its memory.
        future = self._executor.submit(_answers, self._seats, pickled((work, unit, crashed)))
        return _translated(future, lambda: _outcome(future, unit))

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *raised: object) -> None:
        self._stack.close()


class _WorkerSeats(WorkerPlugin):
    """What a Dask worker has for one executor: a seat for each of its threads."""

    def setup(self, worker: Worker) -> None:
        """Called by Dask on every worker, also on those that come later."""
        # Dask marks workers as daemons, which may have no processes. A seat's ends with its own.
        multiprocessing.current_process().daemon = False
        self.seats = Seats(worker.state.nthreads)

    def teardown(self, worker: Worker) -> None:
        """Called by Dask when the executor or the worker is closed."""
        self.seats.close()


@dataclass(frozen=True, slots=True)
class _Failed:
    """What a task answers instead of raising, which would lose the cause on its way."""

    error: Exception
    worker: str
    traceback: str


def _answers(seats: str, asked: bytes) -> list[Any] | _Failed:
    """What a task does on a Dask worker."""
    worker = get_worker()
    mine = worker.plugins[seats]
    assert isinstance(mine, _WorkerSeats)
    try:
        return mine.seats.answers(*pickle.loads(asked))  # noqa: S301 - from the executor
    except Exception as error:
        return _Failed(error, worker.address, traceback.format_exc())


def _here() -> None:
    """That this module can be imported where this is called."""


def _outcome(done: Future[list[Any] | _Failed], unit: WorkUnit) -> list[Any]:
    """What has become of a task, in the terms of seats."""
    try:
        found = done.result()
    except KilledWorker:
        raise GivenUpError(
            f"{unit.describe(0)}, or what is judged after it: its Dask worker was lost, time and "
            "again"
        ) from None
    except CancelledError:
        raise WorkerDiedError(_GONE) from None
    if isinstance(found, _Failed):
        found.error.add_note(f"(on the Dask worker {found.worker})")
        raise found.error from RemoteTracebackError(found.traceback)
    return found


def _translated(future: Future[Any], outcome: Callable[[], Told]) -> Future[Told]:
    """A future of what becomes of another one; cancelling it cancels that."""
    told: Future[Told] = Future()

    def tell(_: object) -> None:
        if not told.set_running_or_notify_cancel():
            return
        try:
            told.set_result(outcome())
        except Exception as error:
            told.set_exception(error)

    future.add_done_callback(tell)
    told.add_done_callback(lambda told: told.cancelled() and future.cancel())
    return told


@contextmanager
def _cluster_here(workers: int) -> Iterator[str]:
    """A cluster on this machine; its address."""
    with interrupts_held_back():  # by threads started here, and so by all that they start
        cluster = LocalCluster(
            n_workers=workers,
            threads_per_worker=1,
            dashboard_address="127.0.0.1:0",  # without one it takes the port that all others take
            silence_logs=logging.CRITICAL,
        )
    with cluster:
        yield cluster.scheduler_address


@contextmanager
def _connected(scheduler: str, patience: float) -> Iterator[Client]:
    try:
        get_address_host_port(scheduler)  # a client that is told no address leaves a thread behind
        client = Client(scheduler, timeout=patience, set_as_default=False)
    except (OSError, ValueError) as error:
        raise ExecutorError(
            f"scheduler {scheduler!r}: {error}; allowed: the address of a Dask scheduler that "
            "runs, such as tcp://10.0.0.1:8786"
        ) from None
    try:
        yield client
    finally:
        with suppress(TimeoutError, OSError):
            client.close()


@contextmanager
def _with_seats(client: Client, name: str) -> Iterator[None]:
    try:
        client.run_on_scheduler(_here)
        client.register_plugin(_WorkerSeats(), name=name)
    except Exception as error:  # of which kind depends on where it was
        raise ExecutorError(
            f"the Dask scheduler or a worker cannot import what is to run there ({error}); "
            "allowed: the same steadyload there as here"
        ) from error
    try:
        yield
    finally:
        with suppress(Exception):  # a scheduler that is gone needs no more
            client.unregister_worker_plugin(name)

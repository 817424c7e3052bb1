"""Units of work on the workers of a Dask cluster, in processes beside them.

A Dask worker does not judge. It has a pool of worker processes, as the command has here: what
becomes of a part whose process dies is decided by the same code, and what Dask sees of a crash is
an answer. What is left to Dask is a Dask worker that is lost with all on it: its units are worked
on elsewhere.
"""

from __future__ import annotations

import importlib
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

import dask
from distributed import Client, KilledWorker, LocalCluster, Security, Worker, get_worker
from distributed.comm import get_address_host_port
from distributed.diagnostics.plugin import WorkerPlugin

from steadyload.runs.executors import POLL_SECONDS, ExecutorError
from steadyload.runs.pool import (
    UNITS_PER_WORKER,
    Answer,
    GivenUpError,
    Processes,
    Task,
    Unit,
    WorkerDiedError,
    WorkUnit,
    all_cores,
)
from steadyload.runs.worker import (
    RemoteTracebackError,
    interrupts_blocked,
    pickled,
    worker_environment,
)

_PATIENCE = 10.0
"""Seconds for a scheduler to answer."""

_GONE = "the Dask scheduler is gone; what is finished is kept: run it again to go on"

Result = TypeVar("Result")


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
        self._pools = f"steadyload-{uuid.uuid4().hex}"
        self._room, self._asked = UNITS_PER_WORKER, -POLL_SECONDS
        with ExitStack() as stack:
            if scheduler is None:
                cluster = stack.enter_context(_local_cluster(workers or all_cores()))
                client = _connected(cluster.scheduler_address, patience, cluster.security)
            else:
                client = _connected(scheduler, patience)
            self._client = stack.enter_context(client)
            stack.enter_context(_with_pools(self._client, self._pools))
            self._executor = self._client.get_executor(pure=False)
            self._stack = stack.pop_all()

    @property
    def room(self) -> int:
        """See :attr:`steadyload.runs.executors.Executor.room`."""
        if time.monotonic() - self._asked >= POLL_SECONDS:
            with suppress(OSError, TimeoutError):  # what is in flight hears of a lost scheduler
                threads = self._client.scheduler_info(n_workers=0)["total_threads"]
                self._room = UNITS_PER_WORKER * max(1, threads)
            self._asked = time.monotonic()
        return self._room

    def submit(self, task: Task[Unit, Answer]) -> Future[list[Answer]]:
        """See :meth:`steadyload.runs.executors.Executor.submit`."""
        if self._client.status == "closed":
            raise WorkerDiedError(_GONE)
        # As bytes, because what they stand for concerns neither the scheduler nor its memory.
        future = self._executor.submit(_answers, self._pools, pickled(task))
        return _translated(future, lambda: _outcome(future, task.unit))

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *raised: object) -> None:
        self._stack.close()


class _WorkerPool(WorkerPlugin):
    """The pool of a Dask worker for one executor: a process for each of its threads."""

    def setup(self, worker: Worker) -> None:
        """Called by Dask on every worker, also on those that come later."""
        # Dask marks workers as daemons, which may have no processes. Those of the pool end with it.
        multiprocessing.current_process().daemon = False
        self.pool = Processes(worker.state.nthreads)

    def teardown(self, worker: Worker) -> None:
        """Called by Dask when the executor or the worker is closed."""
        self.pool.close()


@dataclass(frozen=True, slots=True)
class _Failed:
    """What a task answers instead of raising, which would lose the cause on its way."""

    error: Exception
    worker: str
    traceback: str


def _answers(pools: str, task: bytes) -> list[Any] | _Failed:
    """What a task does on a Dask worker."""
    worker = get_worker()
    plugin = worker.plugins[pools]
    assert isinstance(plugin, _WorkerPool)
    try:
        return plugin.pool.answers(pickle.loads(task))  # noqa: S301 - from the executor
    except Exception as error:
        return _Failed(error, worker.address, traceback.format_exc())


def _here() -> None:
    """That this module can be imported where this is called."""


def _outcome(done: Future[list[Any] | _Failed], unit: WorkUnit) -> list[Any]:
    """What has become of a task, in the terms of the pool."""
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


def _translated(future: Future[Any], outcome: Callable[[], Result]) -> Future[Result]:
    """A future of what becomes of another one; cancelling it cancels that."""
    translated: Future[Result] = Future()

    def translate(_: object) -> None:
        if not translated.set_running_or_notify_cancel():
            return
        try:
            translated.set_result(outcome())
        except Exception as error:
            translated.set_exception(error)

    future.add_done_callback(translate)
    translated.add_done_callback(lambda other: other.cancelled() and future.cancel())
    return translated


_NO_HTTP: dict[str, list[str]] = {
    "distributed.scheduler.http.routes": [],
    "distributed.worker.http.routes": [],
}
"""Dask's configuration of a cluster whose HTTP servers answer nothing."""


@contextmanager
def _local_cluster(workers: int) -> Iterator[LocalCluster]:
    """A cluster on this machine that talks to nobody without its certificate.

    The certificate is made for this cluster and is never written to a file, so that other users of
    the machine can reach its ports, but not make it run anything.

    Raises:
        ModuleNotFoundError: the package is missing that makes the certificate.
    """
    importlib.import_module("cryptography")  # named by its own error when it is missing
    with worker_environment(), dask.config.set(_NO_HTTP):
        with interrupts_blocked():  # by threads started here, and so by all that they start
            cluster = LocalCluster(
                n_workers=workers,
                threads_per_worker=1,
                security=Security.temporary(),
                dashboard_address="127.0.0.1:0",  # otherwise the port that all others take
                scheduler_kwargs={"dashboard": False},
                silence_logs=logging.CRITICAL,
            )
        with cluster:
            yield cluster


@contextmanager
def _connected(
    scheduler: str, patience: float, security: Security | None = None
) -> Iterator[Client]:
    try:
        get_address_host_port(scheduler)  # a client that is told no address leaves a thread behind
        client = Client(scheduler, timeout=patience, set_as_default=False, security=security)
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
def _with_pools(client: Client, name: str) -> Iterator[None]:
    try:
        client.run_on_scheduler(_here)
        client.register_plugin(_WorkerPool(), name=name)
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

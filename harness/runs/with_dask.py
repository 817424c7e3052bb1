"""Units of work on the workers of a Dask cluster, in processes beside them.

A Dask worker does not judge. It has a pool of worker processes, as the command has here: a part
whose process dies is treated by the same code, and Dask sees a crash as an ordinary result. Dask
itself handles only the loss of a whole Dask worker: its units are worked on elsewhere.
"""

from __future__ import annotations

import importlib
import logging
import multiprocessing
import pickle
import signal
import time
import traceback
import uuid
from collections.abc import Iterator
from concurrent.futures import CancelledError, Future
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from typing import Any

import dask
from distributed import Client, KilledWorker, LocalCluster, Security, Worker, get_worker
from distributed.comm import get_address_host_port
from distributed.diagnostics.plugin import WorkerPlugin

from steadyload.runs.pool import (
    POLL_SECONDS,
    UNITS_PER_WORKER,
    Executor,
    ExecutorError,
    GivenUpError,
    Processes,
    Result,
    Task,
    Unit,
    WorkerDiedError,
    WorkUnit,
    all_cores,
)
from steadyload.runs.worker import (
    RemoteTracebackError,
    pickled,
    signals_blocked,
    worker_environment,
)

_PATIENCE = 10.0
"""Time within which a scheduler must answer [s]."""

_GONE = "the Dask scheduler is gone; what is finished is kept: run it again to go on"


class Dask(Executor):
    """Executor on a Dask cluster.

    Args:
        workers: number of workers of a cluster on this machine that ends with the executor; None
            for one a core.
        scheduler: address of the scheduler of another cluster, such as ``tcp://10.0.0.1:8786``. Its
            workers may come and go; all must have this package.
        patience: seconds for the scheduler to answer.

    Raises:
        ExecutorError: both were given, the scheduler does not answer, or a worker cannot import
            this package.
    """

    shares_files = False

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
        """See :attr:`steadyload.runs.pool.Executor.room`."""
        if time.monotonic() - self._asked >= POLL_SECONDS:
            # Tasks that are running notice the loss of a scheduler.
            with suppress(OSError, TimeoutError):
                threads = self._client.scheduler_info(n_workers=0)["total_threads"]
                self._room = UNITS_PER_WORKER * max(1, threads)
            self._asked = time.monotonic()
        return self._room

    def submit(self, task: Task[Unit, Result]) -> Future[list[Result]]:
        """See :meth:`steadyload.runs.pool.Executor.submit`."""
        if self._client.status == "closed":
            raise WorkerDiedError(_GONE)
        # As bytes, because the scheduler need not unpickle or hold the objects.
        done = self._executor.submit(_results, self._pools, pickled(task))
        results: Future[list[Result]] = Future()
        done.add_done_callback(lambda done: _pass_on(done, results, task.unit))
        results.add_done_callback(lambda results: results.cancelled() and done.cancel())
        return results

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
    """Result of a failed task; raising instead would lose the cause of the exception."""

    error: Exception
    worker: str
    traceback: str


def _results(pools: str, task: bytes) -> list[Any] | _Failed:
    """Results of a task; runs on a Dask worker."""
    worker = get_worker()
    plugin = worker.plugins[pools]
    assert isinstance(plugin, _WorkerPool)
    try:
        return plugin.pool.results(pickle.loads(task))  # noqa: S301 - from the executor
    except Exception as error:
        return _Failed(error, worker.address, traceback.format_exc())


def _here() -> None:
    """Do nothing; calling it shows that this module can be imported there."""


def _outcome(done: Future[list[Any] | _Failed], unit: WorkUnit) -> list[Any]:
    """The results of a finished task; its failures are raised as exceptions of the pool."""
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


def _pass_on(done: Future[list[Any] | _Failed], results: Future[list[Any]], unit: WorkUnit) -> None:
    """Give the outcome of a finished task to the future that the caller has."""
    if not results.set_running_or_notify_cancel():
        return
    try:
        results.set_result(_outcome(done, unit))
    except Exception as error:
        results.set_exception(error)


_NO_HTTP: dict[str, list[str]] = {
    "distributed.scheduler.http.routes": [],
    "distributed.worker.http.routes": [],
}
"""Dask's configuration of a cluster whose HTTP servers have no routes."""


@contextmanager
def _local_cluster(workers: int) -> Iterator[LocalCluster]:
    """A cluster on this machine that refuses connections without its certificate.

    The certificate is made for this cluster and is never written to a file, so that other users of
    the machine can reach its ports, but cannot run anything on it.

    Raises:
        ModuleNotFoundError: the package is missing that makes the certificate.
    """
    importlib.import_module("cryptography")  # named by its own error when it is missing
    with worker_environment(), dask.config.set(_NO_HTTP):
        # By threads started here, and so by all processes that they start.
        with signals_blocked({signal.SIGINT}):
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
        get_address_host_port(scheduler)  # a client without an address leaves a thread behind
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

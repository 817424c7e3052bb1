"""Where units of work run: in this process or in several. All give equal rows."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from typing import TypeVar

Unit = TypeVar("Unit")
Answer = TypeVar("Answer")


_THREADS = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")


class WorkerDiedError(RuntimeError):
    """A worker process ended without an answer; what was finished before is kept."""


def run_units(
    work: Callable[[Unit], Answer], units: Sequence[Unit], *, workers: int
) -> Iterator[Answer]:
    """Answers of ``work`` for every unit, in the order in which they come.

    Args:
        work: a module-level function; with more than one worker, it and the units are pickled.
        units: what to work on.
        workers: number of processes, 1 or more; 1 works in this process.

    Raises:
        WorkerDiedError: a worker was killed or crashed.
    """
    if workers == 1:
        yield from map(work, units)
        return
    # spawn: engines must not inherit each other's native state.
    context = multiprocessing.get_context("spawn")
    with (
        _one_thread_each(),
        ProcessPoolExecutor(workers, mp_context=context, initializer=_end_with_parent) as pool,
    ):
        try:
            with _interrupts_ignored():
                futures = [pool.submit(work, unit) for unit in units]
            for future in as_completed(futures):
                yield future.result()
        except BrokenProcessPool as error:
            raise WorkerDiedError(
                "a worker process died; finished shards are kept, run it again to resume "
                '(a script of your own needs `if __name__ == "__main__":` around the call)'
            ) from error
        finally:
            pool.shutdown(wait=True, cancel_futures=True)


@contextmanager
def _one_thread_each() -> Iterator[None]:
    """Linear algebra in workers uses one thread each.

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
def _interrupts_ignored() -> Iterator[None]:
    """Workers inherit this: Ctrl-C reaches the whole process group, and only the parent answers."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def _end_with_parent() -> None:
    """Make a worker end when the process that started it is killed, instead of waiting forever."""
    parent = multiprocessing.parent_process()
    assert parent is not None

    def watch() -> None:
        parent.join()
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()

"""Time and memory of a step in a process of its own."""

from __future__ import annotations

import multiprocessing
import re
import resource
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any, NamedTuple

from steadyload.reports.columns import column, fixed, row, significant
from steadyload.runs.worker import worker_environment


@row
class Needs:
    """Needs of one process for a step."""

    wall: float = column("wall s", significant)
    cpu: float = column("CPU s", significant)
    peak: float = column("MiB", fixed, "the most memory at a time")


class Measured(NamedTuple):
    """Needs of a process, and of those that it started; what the step returned."""

    own: Needs
    children_cpu: float
    children_peak: float
    result: Any


def in_fresh_process(step: Callable[..., Any], *arguments: Any) -> Measured:
    """Needs of a step."""
    context = multiprocessing.get_context("spawn")
    with worker_environment(), ProcessPoolExecutor(1, mp_context=context) as process:
        return process.submit(_needs, step, arguments).result()


def _needs(step: Callable[..., Any], arguments: tuple[Any, ...]) -> Measured:
    start, busy = time.perf_counter(), time.process_time()
    result = step(*arguments)
    own = Needs(time.perf_counter() - start, time.process_time() - busy, _peak())
    children = resource.getrusage(resource.RUSAGE_CHILDREN)
    cpu = children.ru_utime + children.ru_stime
    return Measured(own, cpu, children.ru_maxrss / 1024.0, result)


def _peak() -> float:
    """Peak memory of this process so far [MiB]."""
    status = Path("/proc/self/status")
    if status.exists():
        # The value of getrusage starts with the memory of the process that started this one.
        found = re.search(r"VmHWM:\s+(\d+) kB", status.read_text(encoding="utf-8"))
        assert found is not None
        return int(found[1]) / 1024.0
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0

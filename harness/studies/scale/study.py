"""Measurement of time and memory of studies by number of rows, of the run and of reading it.

Every step is measured in a fresh process, which alone holds all data that grow with the study:
units, rows, frames. The processes that judge hold one unit each.
"""

from __future__ import annotations

import multiprocessing
import re
import resource
import tempfile
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from steadyload.runs.definition import StudyDefinition
from steadyload.runs.results import load_results
from steadyload.runs.runner import run_study
from steadyload.runs.worker import worker_environment
from steadyload.studies.comparison.summary import compare

METHODS = ("fbs", "pbs0.9", "pbs0.7", "pbs0.5")
"""Cheap methods, so that the measured needs are those of everything but judging."""

REPETITIONS = 10
_ROWS_A_LAYOUT = len(METHODS) * REPETITIONS
_SHARD_SIZE = 100
_SEED = 1


@dataclass(frozen=True, slots=True)
class ScaleStep:
    """Needs of one process for a step: wall and CPU time [s], peak memory [MiB]."""

    wall: float
    cpu: float
    peak: float


@dataclass(frozen=True, slots=True)
class ScalePoint:
    """Needs of a study with a number of rows; ``size`` of its folder [MiB].

    ``run`` is the process that coordinates and writes, ``load`` reads all columns of all rows,
    ``report`` computes the records of a page.
    """

    rows: int
    layouts: int
    size: float
    run: ScaleStep
    load: ScaleStep
    report: ScaleStep


def scale(
    row_counts: Sequence[int],
    *,
    workers: int = 2,
    progress: Callable[[str], None] = lambda what: None,
) -> list[ScalePoint]:
    """Run, load and compare generated studies.

    Args:
        row_counts: of the studies, 40 or more; rounded down to whole layouts.
        workers: processes that judge.
        progress: called with a description of the current measurement.
    """
    points = []
    for asked in row_counts:
        layouts = asked // _ROWS_A_LAYOUT
        rows = layouts * _ROWS_A_LAYOUT
        with tempfile.TemporaryDirectory(prefix="steadyload-scale-") as name:
            folder = Path(name) / "run"
            steps = {}
            for what, step in (("run", _run), ("load", load_results), ("report", compare)):
                progress(f"{rows} rows: {what}")
                told = (folder, layouts, workers) if step is _run else (folder,)
                steps[what] = _measured(step, *told)
            size = sum(file.stat().st_size for file in folder.rglob("*") if file.is_file())
        points.append(ScalePoint(rows, layouts, size / 2**20, **steps))
    return points


def _run(folder: Path, layouts: int, workers: int) -> None:
    study = StudyDefinition(
        "scale",
        METHODS,
        generated=layouts,
        seed=_SEED,
        repetitions=REPETITIONS,
        shard_size=_SHARD_SIZE,
    )
    run_study(study, folder, workers=workers)


def _measured(step: Callable[..., Any], *arguments: Any) -> ScaleStep:
    """A step in a process of its own."""
    context = multiprocessing.get_context("spawn")
    with worker_environment(), ProcessPoolExecutor(1, mp_context=context) as process:
        return process.submit(_measure, step, arguments).result()


def _measure(step: Callable[..., Any], arguments: tuple[Any, ...]) -> ScaleStep:
    start, busy = time.perf_counter(), time.process_time()
    step(*arguments)
    wall, cpu = time.perf_counter() - start, time.process_time() - busy
    return ScaleStep(wall, cpu, _peak())


def _peak() -> float:
    """Peak memory of this process so far [MiB]."""
    status = Path("/proc/self/status")
    if status.exists():
        # The value of getrusage starts with the memory of the process that started this one.
        found = re.search(r"VmHWM:\s+(\d+) kB", status.read_text())
        assert found is not None
        return int(found[1]) / 1024.0
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0

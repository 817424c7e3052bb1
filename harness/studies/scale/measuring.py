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
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any

from steadyload.reports.columns import column, fixed, row, significant
from steadyload.runs.definition import StudyDefinition
from steadyload.runs.results import load_results
from steadyload.runs.runner import run_study
from steadyload.runs.worker import worker_environment
from steadyload.studies.kit import Asked, Lab
from steadyload.studies.registry import study

METHODS = ("fbs", "pbs0.9", "pbs0.7", "pbs0.5")
"""Cheap methods, so that the measured needs are those of everything but judging."""

REPETITIONS = 10
_ROWS_A_LAYOUT = len(METHODS) * REPETITIONS


@row
class Needs:
    """Needs of one process for a step."""

    wall: float = column("wall s", significant)
    cpu: float = column("CPU s", significant)
    peak: float = column("MiB", fixed, "the most memory at a time")


@row
class Point:
    """Needs of a study with a number of rows."""

    rows: int = column()
    size: float = column("folder MiB", significant)
    run: Needs = column(about="the process that coordinates and writes")
    load: Needs = column(about="reads all columns of all rows")
    report: Needs = column(about="computes the records of a page")

    @property
    def layouts(self) -> int:
        """Number of layouts."""
        return self.rows // _ROWS_A_LAYOUT


class Size(Asked[Point], question="scale", methods=METHODS, repetitions=REPETITIONS):
    """A study to be measured."""

    rows: int
    workers: int

    def describe(self, part: int) -> str:
        """Description of the study for messages."""
        return f"a study of {self.rows} rows over {self.workers} processes"

    def measure(self) -> Point:
        """Run, load and compare it."""
        with tempfile.TemporaryDirectory(prefix="steadyload-scale-") as name:
            folder = Path(name) / "run"
            run = _in_fresh_process(_run, folder, self.rows // _ROWS_A_LAYOUT, self.workers)
            load, report = (_in_fresh_process(step, folder) for step in (load_results, _report))
            size = sum(file.stat().st_size for file in folder.rglob("*") if file.is_file())
        return Point(self.rows, size / 2**20, run, load, report)


@row
class Found:
    """Points by rising number of rows; ``growth`` of the memory of each step [bytes a row]."""

    points: Sequence[Point]
    growth: Sequence[float]
    workers: int
    made_with: Mapping[str, str]
    methods: Sequence[str] = METHODS
    repetitions: int = REPETITIONS


def measured(row_counts: Sequence[int], lab: Lab) -> Found:
    """Needs of generated studies, whose numbers of rows are rounded down to whole layouts."""
    counts = [asked - asked % _ROWS_A_LAYOUT for asked in row_counts]
    points, made_with = lab.measure([Size(rows, lab.workers) for rows in counts], Point)
    least, most = points[0], points[-1]
    added = [getattr(most, s).peak - getattr(least, s).peak for s in ("run", "load", "report")]
    more = most.rows - least.rows
    return Found(points, [2**20 * a / more for a in added if more], lab.workers, made_with)


def _run(folder: Path, layouts: int, workers: int) -> None:
    definition = StudyDefinition(
        "scale", METHODS, generated=layouts, seed=1, repetitions=REPETITIONS, shard_size=100
    )
    run_study(definition, folder, workers=workers)


def _report(folder: Path) -> None:
    report: Any = study("report")
    report(directory=folder).run(Lab(folder))


def _in_fresh_process(step: Callable[..., Any], *arguments: Any) -> Needs:
    context = multiprocessing.get_context("spawn")
    with worker_environment(), ProcessPoolExecutor(1, mp_context=context) as process:
        return process.submit(_needs, step, arguments).result()


def _needs(step: Callable[..., Any], arguments: tuple[Any, ...]) -> Needs:
    start, busy = time.perf_counter(), time.process_time()
    step(*arguments)
    return Needs(time.perf_counter() - start, time.process_time() - busy, _peak())


def _peak() -> float:
    """Peak memory of this process so far [MiB]."""
    status = Path("/proc/self/status")
    if status.exists():
        # The value of getrusage starts with the memory of the process that started this one.
        found = re.search(r"VmHWM:\s+(\d+) kB", status.read_text(encoding="utf-8"))
        assert found is not None
        return int(found[1]) / 1024.0
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0

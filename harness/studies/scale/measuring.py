"""Measurement of time and memory of studies by number of rows, of the run and of reading it.

Every step is measured in a fresh process, which alone holds all data that grow with the study:
units, rows, frames. The processes that judge hold one unit each.
"""

from __future__ import annotations

import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from steadyload.reports.columns import column, row, significant
from steadyload.runs.definition import StudyDefinition
from steadyload.runs.results import load_results
from steadyload.runs.runner import run_study
from steadyload.studies.kit import Asked, Lab
from steadyload.studies.registry import study
from steadyload.studies.scale.judging import (
    EACH,
    IN_BLOCKS,
    SIMULATED,
    InThreads,
    Judging,
    Many,
    OneByOne,
    Simulating,
    Threads,
)
from steadyload.studies.scale.needs import Needs, in_fresh_process

METHODS = ("fbs", "pbs0.9", "pbs0.7", "pbs0.5")
"""Cheap methods, so that the measured needs are those of everything but judging."""

_FOR_EACH_SIMULATED = 40
"""Layouts in blocks, for each that is simulated."""

REPETITIONS = 10
_ROWS_A_LAYOUT = len(METHODS) * REPETITIONS


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


class Size(Asked[Point], what="scale", methods=METHODS, repetitions=REPETITIONS):
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
            run = in_fresh_process(_run, folder, self.rows // _ROWS_A_LAYOUT, self.workers).own
            steps = (load_results, _report)
            load, report = (in_fresh_process(step, folder).own for step in steps)
            size = sum(file.stat().st_size for file in folder.rglob("*") if file.is_file())
        return Point(self.rows, size / 2**20, run, load, report)


@row
class Found:
    """Points by rising number of rows; ``growth`` of the memory of each step [bytes a row]."""

    points: Sequence[Point]
    growth: Sequence[float]
    by_layouts: Sequence[Judging]
    by_workers: Sequence[Judging]
    by_threads: Sequence[Threads]
    simulated: Simulating
    workers: int
    made_with: Mapping[str, str]
    methods: Sequence[str] = METHODS
    repetitions: int = REPETITIONS
    in_blocks: Sequence[str] = IN_BLOCKS
    each: int = EACH

    @property
    def beside(self) -> Judging:
        """Needs where one worker judges beside the command."""
        return next(one for one in self.by_workers if one.where == "processes")


def measured(counts: Sequence[int], lab: Lab) -> Found:
    """Needs of generated studies of so many rows, and of so many layouts in blocks."""
    points, made_with = lab.measure([Size(rows, lab.workers) for rows in counts], Point)
    least, most = points[0], points[-1]
    added = [getattr(most, s).peak - getattr(least, s).peak for s in ("run", "load", "report")]
    more = most.rows - least.rows
    largest = counts[-1]
    by_layouts = [Many(layouts, "processes", 1) for layouts in counts]
    places = [("serial", 1), *((where, n) for where in ("processes", "dask") for n in (1, 2))]
    by_workers = [Many(largest, where, n) for where, n in places]
    judging, _ = lab.measure([*by_layouts, *by_workers], Judging, folder="blocks")
    threads = [InThreads(largest, method, n) for method in IN_BLOCKS for n in (1, 2)]
    by_threads, _ = lab.measure(threads, Threads, folder="threads")
    one_by_one = OneByOne(largest // _FOR_EACH_SIMULATED, SIMULATED)
    [simulated], _ = lab.measure([one_by_one], Simulating, folder="one-by-one")
    return Found(
        points, [2**20 * a / more for a in added],
        judging[: len(by_layouts)], judging[len(by_layouts) :], by_threads, simulated,
        lab.workers, made_with,
    )  # fmt: skip


def _run(folder: Path, layouts: int, workers: int) -> None:
    definition = StudyDefinition(
        "scale", METHODS, generated=layouts, seed=1, repetitions=REPETITIONS, shard_size=100
    )
    run_study(definition, folder, workers=workers)


def _report(folder: Path) -> None:
    report: Any = study("report")
    report(directory=folder).run(Lab(folder))

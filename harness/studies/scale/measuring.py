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
from typing import Any, NamedTuple

from steadyload.reports.columns import column, fixed, row, significant
from steadyload.runs.definition import StudyDefinition
from steadyload.runs.pool import make_executor
from steadyload.runs.results import load_results
from steadyload.runs.runner import run_study
from steadyload.runs.worker import worker_environment
from steadyload.studies.kit import Asked, Lab
from steadyload.studies.registry import study
from steadyload.studies.scale.many import write_many

METHODS = ("fbs", "pbs0.9", "pbs0.7", "pbs0.5")
"""Cheap methods, so that the measured needs are those of everything but judging."""

IN_BLOCKS = ("sme", "equilibrium")
"""Methods that judge batches."""

EACH = 1000
"""Layouts of an item list."""

REPETITIONS = 10
_ROWS_A_LAYOUT = len(METHODS) * REPETITIONS


@row
class Needs:
    """Needs of one process for a step."""

    wall: float = column("wall s", significant)
    cpu: float = column("CPU s", significant)
    peak: float = column("MiB", fixed, "the most memory at a time")


class _Measured(NamedTuple):
    """Needs of a process, and of those that it started."""

    own: Needs
    children_cpu: float
    children_peak: float


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
            run = _in_fresh_process(_run, folder, self.rows // _ROWS_A_LAYOUT, self.workers).own
            steps = (load_results, _report)
            load, report = (_in_fresh_process(step, folder).own for step in steps)
            size = sum(file.stat().st_size for file in folder.rglob("*") if file.is_file())
        return Point(self.rows, size / 2**20, run, load, report)


@row
class Judging:
    """Needs of judging layouts in blocks."""

    layouts: int = column(about="that are judged")
    where: str = column(about="what judges: processes beside the command, or workers of Dask")
    workers: int = column()
    wall: float = column("us a layout", significant, "wall time")
    command: float = column(
        "command, CPU us", significant, "a layout: reads, checks, keeps the layouts; writes rows"
    )
    judges: float = column("judges, CPU us", significant, "a layout, their start included")
    peak: float = column("command MiB", fixed, "the most memory at a time")
    worker_peak: float = column("judge MiB", fixed, "the most of one process, or less")
    files: int = column(about="of the run folder")
    size: float = column("folder MiB", significant)


class Many(Asked[Judging], question="layouts in blocks", methods=IN_BLOCKS, each=EACH):
    """A study of many different layouts to be measured."""

    layouts: int
    where: str
    workers: int

    def describe(self, part: int) -> str:
        """Description of the study for messages."""
        return f"{self.layouts} layouts by {self.workers} workers ({self.where})"

    def measure(self) -> Judging:
        """Make the layouts, which is not measured, and judge them."""
        with tempfile.TemporaryDirectory(prefix="steadyload-scale-") as name:
            folder = Path(name) / "run"
            made = write_many(Path(name), self.layouts // EACH, EACH, seed=1)
            found = _in_fresh_process(_judge, folder, made, self.where, self.workers)
            files = [file for file in folder.rglob("*") if file.is_file()]
            size = sum(file.stat().st_size for file in files)
        a_layout = 1e6 / self.layouts
        return Judging(
            self.layouts, self.where, self.workers, found.own.wall * a_layout,
            found.own.cpu * a_layout, found.children_cpu * a_layout, found.own.peak,
            found.children_peak, len(files), size / 2**20,
        )  # fmt: skip


@row
class Found:
    """Points by rising number of rows; ``growth`` of the memory of each step [bytes a row]."""

    points: Sequence[Point]
    growth: Sequence[float]
    by_layouts: Sequence[Judging]
    by_workers: Sequence[Judging]
    workers: int
    made_with: Mapping[str, str]
    methods: Sequence[str] = METHODS
    repetitions: int = REPETITIONS
    in_blocks: Sequence[str] = IN_BLOCKS
    each: int = EACH

    @property
    def throughput(self) -> Mapping[str, float]:
        """How many times as many layouts a second two workers judge as one, by where they are."""
        walls = {(one.where, one.workers): one.wall for one in self.by_workers}
        return {where: walls[where, 1] / walls[where, 2] for where, _ in walls}


def measured(row_counts: Sequence[int], layout_counts: Sequence[int], lab: Lab) -> Found:
    """Needs of generated studies, whose numbers of rows are rounded down to whole layouts."""
    counts = [asked - asked % _ROWS_A_LAYOUT for asked in row_counts]
    points, made_with = lab.measure([Size(rows, lab.workers) for rows in counts], Point)
    least, most = points[0], points[-1]
    added = [getattr(most, s).peak - getattr(least, s).peak for s in ("run", "load", "report")]
    more = most.rows - least.rows
    some = layout_counts[max(len(layout_counts) - 2, 0)]
    by_layouts = [Many(layouts, "processes", 1) for layouts in layout_counts]
    by_workers = [Many(some, where, n) for where in ("processes", "dask") for n in (1, 2)]
    judging, _ = lab.measure([*by_layouts, *by_workers], Judging, folder="blocks")
    return Found(
        points, [2**20 * a / more for a in added if more],
        judging[: len(by_layouts)], judging[len(by_layouts) :], lab.workers, made_with,
    )  # fmt: skip


def _judge(folder: Path, files: Sequence[Path], where: str, workers: int) -> None:
    definition = StudyDefinition("many", IN_BLOCKS, files=tuple(files))
    with make_executor(where, workers=workers) as executor:
        run_study(definition, folder, workers=executor)


def _run(folder: Path, layouts: int, workers: int) -> None:
    definition = StudyDefinition(
        "scale", METHODS, generated=layouts, seed=1, repetitions=REPETITIONS, shard_size=100
    )
    run_study(definition, folder, workers=workers)


def _report(folder: Path) -> None:
    report: Any = study("report")
    report(directory=folder).run(Lab(folder))


def _in_fresh_process(step: Callable[..., Any], *arguments: Any) -> _Measured:
    context = multiprocessing.get_context("spawn")
    with worker_environment(), ProcessPoolExecutor(1, mp_context=context) as process:
        return process.submit(_needs, step, arguments).result()


def _needs(step: Callable[..., Any], arguments: tuple[Any, ...]) -> _Measured:
    start, busy = time.perf_counter(), time.process_time()
    step(*arguments)
    own = Needs(time.perf_counter() - start, time.process_time() - busy, _peak())
    children = resource.getrusage(resource.RUSAGE_CHILDREN)
    return _Measured(own, children.ru_utime + children.ru_stime, children.ru_maxrss / 1024.0)


def _peak() -> float:
    """Peak memory of this process so far [MiB]."""
    status = Path("/proc/self/status")
    if status.exists():
        # The value of getrusage starts with the memory of the process that started this one.
        found = re.search(r"VmHWM:\s+(\d+) kB", status.read_text(encoding="utf-8"))
        assert found is not None
        return int(found[1]) / 1024.0
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0

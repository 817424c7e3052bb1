"""Needs of judging many layouts: in blocks, in threads, and one by one."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Sequence
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

from steadyload.layouts.formats import read_layouts
from steadyload.layouts.model.batch import LayoutBatch
from steadyload.methods.contract.method import judge
from steadyload.methods.registry import make_method
from steadyload.methods.threads import evaluate_in_threads
from steadyload.reports.columns import column, fixed, plain_percent, row, significant
from steadyload.runs.asked import Asked
from steadyload.runs.definition import StudyDefinition
from steadyload.runs.pool import EXECUTORS, make_executor
from steadyload.runs.runner import run_study
from steadyload.studies.scale.many import many_layouts, write_many
from steadyload.studies.scale.needs import in_fresh_process

IN_BLOCKS = ("sme", "equilibrium")
"""Methods that judge batches."""

EACH = 1000
"""Layouts of an item list."""

SIMULATED = "ps_opt@mujoco"
"""A method that judges one layout after the other."""

AHEAD = 100
"""One in so many layouts is judged beforehand by a study whose time is taken off."""

_RUNS = 5
"""Runs in threads, of which the median counts."""


@row
class Judging:
    """Needs of judging layouts in blocks."""

    layouts: int = column(about="that are judged")
    where: str = column(
        about="what judges: the command itself, processes beside it, or workers of Dask"
    )
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


class Many(Asked[Judging], what="layouts in blocks", methods=IN_BLOCKS, each=EACH):
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
            found = in_fresh_process(_judge, folder, made, IN_BLOCKS, self.where, self.workers)
            files = [file for file in folder.rglob("*") if file.is_file()]
            size = sum(file.stat().st_size for file in files)
        a_layout = 1e6 / self.layouts
        return Judging(
            self.layouts, self.where, self.workers, found.own.wall * a_layout,
            found.own.cpu * a_layout, found.children_cpu * a_layout, found.own.peak,
            found.children_peak, len(files), size / 2**20,
        )  # fmt: skip


@row
class Threads:
    """Time of judging a batch in several threads of one process."""

    method: str = column()
    layouts: int = column(about="of the batch")
    threads: int = column()
    wall: float = column("us a layout", significant, "wall time, the median of five runs")
    cpu: float = column("CPU us", significant, "a layout")


class InThreads(Asked[Threads], what="layouts in threads", each=EACH):
    """A batch to be judged in threads."""

    layouts: int
    method: str
    threads: int

    def describe(self, part: int) -> str:
        """Description of the batch for messages."""
        return f"{self.layouts} layouts by {self.method} in {self.threads} threads"

    def measure(self) -> Threads:
        """Judge the batch a few times, after once that does not count."""
        batch = LayoutBatch.joined([*many_layouts(self.layouts // EACH, EACH, seed=1)])
        method, times = make_method(self.method), []
        for _ in range(1 + _RUNS):
            start, busy = time.perf_counter(), time.process_time()
            evaluate_in_threads(method, batch, self.threads)
            times.append((time.perf_counter() - start, time.process_time() - busy))
        wall, cpu = np.median(times[1:], axis=0) * 1e6 / len(batch)
        return Threads(self.method, len(batch), self.threads, float(wall), float(cpu))


@row
class Simulating:
    """Needs of a study that judges one layout after the other, beside those of judging alone."""

    method: str = column()
    layouts: int = column(about="that are judged")
    alone: float = column("judging alone, CPU ms", significant, "a layout, in a loop")
    command: float = column("study: command, CPU ms", significant, "a layout")
    judges: float = column("study: judge, CPU ms", significant, "a layout")
    overhead: float = column(
        "overhead %", plain_percent, "CPU time of the study beyond that of judging alone"
    )


class OneByOne(Asked[Simulating], what="layouts one by one", ahead=AHEAD):
    """A study of simulations to be measured."""

    layouts: int
    method: str

    def describe(self, part: int) -> str:
        """Description of the study for messages."""
        return f"{self.layouts} layouts by {self.method}, one by one"

    def measure(self) -> Simulating:
        """The needs of a study for some more layouts, so that starts do not count."""
        with tempfile.TemporaryDirectory(prefix="steadyload-scale-") as name:
            made = write_many(Path(name), self.layouts, 1, seed=1)
            few = max(self.layouts // AHEAD, 1)
            less, more = (
                in_fresh_process(
                    _judge, Path(name) / f"run-{most}", made, (self.method,), "processes", 1, most
                )
                for most in (few, self.layouts)
            )
            alone = in_fresh_process(_judge_alone, made, self.method, few).result
        each = 1e3 / (self.layouts - few)
        command = each * (more.own.cpu - less.own.cpu)
        judges = each * (more.children_cpu - less.children_cpu)
        return Simulating(
            self.method, self.layouts - few, each * alone, command, judges,
            (command + judges) / (each * alone) - 1.0,
        )  # fmt: skip


def _judge(
    folder: Path,
    files: Sequence[Path],
    methods: Sequence[str],
    where: str,
    workers: int,
    limit: int | None = None,
) -> None:
    definition = StudyDefinition("many", tuple(methods), files=tuple(files), limit=limit)
    options: dict[str, Any] = {"workers": workers} if EXECUTORS[where].options else {}
    with make_executor(where, **options) as executor:
        run_study(definition, folder, workers=executor)


def _judge_alone(files: Sequence[Path], name: str, few: int) -> float:
    """CPU time of judging the layouts of files after the first few [s]."""
    layouts = [one for file in files for one in read_layouts(file)]
    method = make_method(name)
    for layout in layouts[:few]:
        judge(method, layout)
    start = time.process_time()
    for layout in islice(layouts, few, None):
        judge(method, layout)
    return time.process_time() - start

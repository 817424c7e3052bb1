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
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from steadyload.runs.definition import StudyDefinition
from steadyload.runs.pool import SinglePart
from steadyload.runs.provenance import key_of, provenance_lines
from steadyload.runs.results import load_results
from steadyload.runs.runner import run_study
from steadyload.runs.store import kept_records
from steadyload.runs.worker import worker_environment
from steadyload.studies.comparison.summary import compare
from steadyload.studies.study import Progress, silent

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


@dataclass(frozen=True)
class ScaleUnit(SinglePart):
    """A study to be measured; what was measured stays, however fast the code has become since."""

    rows: int
    workers: int

    @property
    def key(self) -> str:
        """The key of its record."""
        asked = {"question": "scale", "methods": METHODS, "repetitions": REPETITIONS}
        return key_of(asked | asdict(self))

    def describe(self, part: int) -> str:
        """Description of the study for messages."""
        return f"a study of {self.rows} rows over {self.workers} processes"


def scale(
    row_counts: Sequence[int], work: Path, *, workers: int = 2, progress: Progress = silent
) -> tuple[list[ScalePoint], dict[str, str]]:
    """Run, load and compare generated studies; those that were measured are not measured again.

    Args:
        row_counts: of the studies, 40 or more; rounded down to whole layouts.
        work: folder of what was measured.
        workers: processes that judge.
        progress: called with what is done, the studies done and those to be done.

    Returns:
        What was measured, and the provenance of the measurement of the largest study.

    Raises:
        ResultsError: another run is at work in the folder.
    """
    counts = [asked - asked % _ROWS_A_LAYOUT for asked in row_counts]
    units = [ScaleUnit(rows, workers) for rows in counts]
    found = kept_records(
        work / "measured", units, _point, progress=lambda *of: progress("studies", *of)
    )
    points = [
        ScalePoint(
            rows,
            rows // _ROWS_A_LAYOUT,
            record["size"],
            *(ScaleStep(**record[what]) for what in ("run", "load", "report")),
        )
        for rows, record in zip(counts, found, strict=True)
    ]
    return points, found[counts.index(max(counts))]["made_with"]


def _point(unit: ScaleUnit) -> Iterator[dict[str, Any]]:
    made_with = provenance_lines()  # of the code that measures
    with tempfile.TemporaryDirectory(prefix="steadyload-scale-") as name:
        folder = Path(name) / "run"
        run = _measured(_run, folder, unit.rows // _ROWS_A_LAYOUT, unit.workers)
        load, report = _measured(load_results, folder), _measured(compare, folder)
        size = sum(file.stat().st_size for file in folder.rglob("*") if file.is_file())
    steps = {"run": asdict(run), "load": asdict(load), "report": asdict(report)}
    yield {**steps, "size": size / 2**20, "made_with": made_with}


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
        found = re.search(r"VmHWM:\s+(\d+) kB", status.read_text(encoding="utf-8"))
        assert found is not None
        return int(found[1]) / 1024.0
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0

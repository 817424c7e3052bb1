"""Methods judged on layouts of real size, and on small ones; an interrupted run is resumed."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path

import pandas as pd

from steadyload.app.recommend.front import SIZES
from steadyload.atomic import without_link
from steadyload.layouts.benchmark import Benchmark, load_benchmark
from steadyload.layouts.benchmark.dataset import set_named
from steadyload.layouts.benchmark.real import PALLET_SOFTWARE
from steadyload.layouts.formats import Format, write_layouts
from steadyload.layouts.model.floor import FloorKind
from steadyload.layouts.model.question import Question, with_question
from steadyload.layouts.model.scenarios import Scenario
from steadyload.methods.contract.spec import parse_spec
from steadyload.methods.registry import each_question
from steadyload.methods.tuned import TUNED, tuned_engines
from steadyload.progress import Progress, silent
from steadyload.runs.able import able_methods
from steadyload.runs.definition import StudyDefinition, StudyError
from steadyload.runs.pool import Executor
from steadyload.runs.runner import run_study


def standard_methods() -> tuple[str, ...]:
    """Specs of the methods that are compared unless others are named.

    Those that cannot judge are left out. Methods that were made for both questions, each for one
    at a time, stand in the list once a question.
    """
    specs = (
        "fbs", "sme", "equilibrium", "equilibrium:margin=0.01", "equilibrium:time=0.3", "settling",
        *(f"{TUNED}@{engine}" for engine in tuned_engines()), "lstm_e", "cascade@mujoco",
    )  # fmt: skip
    return tuple(
        with_question(spec, question)
        for spec in specs
        for question in each_question(parse_spec(spec).name) or (Question.WITHIN,)
    )


FLOOR_METHODS = (
    "equilibrium:margin=0.01", "equilibrium:time=0.3", "settling", "cascade@mujoco",
)  # fmt: skip
"""Of the methods that are compared, those that judge customers' pallets on several floors."""

FLOORS: Mapping[str, tuple[FloorKind, float]] = {
    "deck with edges, as delivered": (FloorKind.AUTO, 0.0),
    "infinite plane": (FloorKind.INFINITE, 0.0),
    "deck, gaps up to 0.35 cm closed": (FloorKind.AUTO, 0.35),
    "deck, gaps up to 1 cm closed": (FloorKind.AUTO, 1.0),
    "deck, gaps up to 2 cm closed": (FloorKind.AUTO, 2.0),
}
"""Floor, and vertical gaps that are closed [cm]."""


PART = "test"
"""Part of the labelled sets; nothing was tuned, trained or fitted on it."""

REAL, SMALL = "real", "small"
"""Run folders in the work folder: of the set of real size, and of small layouts."""

_SHARD_SIZE = 12


@dataclass(frozen=True)
class RealStudyOptions:
    """Options of the study of layouts of real size.

    Attributes:
        methods: required specs: one that cannot judge is an error. Empty for
            :func:`standard_methods`, of which those that cannot judge are left out, with a reason.
            Given methods are replaced by their canonical specs.
        directory: folder of the labelled set, or a word of
            :data:`steadyload.layouts.benchmark.dataset.SETS`.
        timeout: CPU seconds a judgement may take.
        limit: cases a scenario of that set, those of the first ranks; None for all.
        small: cases a scenario of the large set of the package, whose layouts are small.
        sizes: largest numbers of boxes of the bins; empty for :data:`SIZES`.
        pallets: customers' pallets that are judged on several floors.

    Raises:
        StudyError: a number out of range, or sizes that do not rise.
        SpecError, EngineNotInstalledError: a named method cannot judge.
        LearnerError: its weights cannot be read.
    """

    methods: tuple[str, ...] = ()
    directory: str = "real"
    timeout: float = 20.0
    limit: int | None = None
    small: int = 60
    sizes: tuple[int, ...] = ()
    pallets: int = 60
    left_out: Mapping[str, str] = field(init=False)
    """By spec, the reason why one of :func:`standard_methods` cannot judge."""

    def __post_init__(self) -> None:
        if not 0.0 < self.timeout < math.inf:
            raise StudyError(f"timeout is {self.timeout:g}; allowed: more than 0 [s]")
        sizes = self.sizes or SIZES
        if sizes[0] < 1 or any(b <= a for a, b in pairwise(sizes)):
            listed = ", ".join(map(str, sizes))
            raise StudyError(f"sizes are {listed}; allowed: whole numbers that rise from 1 on")
        able, left_out = able_methods(self.methods, standard_methods)
        vars(self).update(methods=able, sizes=sizes, left_out=left_out)

    @property
    def benchmark(self) -> str | Path | None:
        """The set as studies name it: a word, or a folder."""
        return set_named(self.directory)

    @property
    def on_floors(self) -> tuple[str, ...]:
        """Methods that judge on several floors."""
        return tuple(spec for spec in self.methods if spec in FLOOR_METHODS)

    def definition(
        self, name: str, benchmark: str | Path | None, limit: int | None
    ) -> StudyDefinition:
        """Definition of all methods on cases of a labelled set."""
        return StudyDefinition(
            name=name,
            methods=self.methods,
            benchmark=PART,
            benchmark_directory=benchmark,
            limit=limit,
            timeout=self.timeout,
            shard_size=_SHARD_SIZE,
        )


@dataclass(frozen=True)
class JudgedReal:
    """Run folders of a study that was judged.

    Attributes:
        benchmark: the set of real size.
        real: run on its cases.
        small: run on small layouts; None where there is none.
        floors: runs on customers' pallets, by the words of :data:`FLOORS`; empty where the set, or
            the part of it, holds none.
    """

    benchmark: Benchmark
    real: Path
    small: Path | None
    floors: Mapping[str, Path]


def judge_real(
    asked: RealStudyOptions,
    work: Path,
    *,
    workers: int | Executor,
    progress: Progress = silent,
) -> JudgedReal:
    """Judge all cases by all methods, then customers' pallets on several floors by a few.

    Args:
        asked: the options.
        work: folder of the run folders.
        workers: processes that judge, or an executor; 0 judges in this process.
        progress: called with rows done and rows in all, of one run after the other.

    Raises:
        BenchmarkError: no labelled set, or it has no labelled case.
        as :func:`steadyload.runs.runner.run_study`.
    """
    benchmark = load_benchmark(asked.benchmark)
    runs = {work / REAL: asked.definition("real", asked.benchmark, asked.limit)}
    small = work / SMALL if asked.small else None
    if small is not None:
        runs[small] = asked.definition("real small", None, asked.small)
    chosen = _customers_pallets(benchmark, asked.pallets) if asked.on_floors else []
    floors: dict[str, Path] = {}
    if chosen:
        work.mkdir(parents=True, exist_ok=True)
        file = work.resolve() / "pallets.json"
        pallets = [benchmark.layout(name, str(Scenario.S1)) for name in chosen]
        write_layouts(without_link(file), pallets, Format.NATIVE)
        for number, (words, (floor, gap)) in enumerate(FLOORS.items()):
            floors[words] = work / f"floor-{number}"
            runs[floors[words]] = StudyDefinition(
                name=f"real floor {number}",
                methods=asked.on_floors,
                files=(file,),
                floor=floor,
                snap_gap=gap,
                timeout=asked.timeout,
                shard_size=_SHARD_SIZE,
            )
    for folder, definition in runs.items():
        run_study(definition, folder, workers=workers, progress=progress)
    return JudgedReal(benchmark, work / REAL, small, floors)


def _customers_pallets(benchmark: Benchmark, most: int) -> list[str]:
    """Names of customers' pallets of the part that is judged, those of the first ranks."""
    cases = benchmark.select(PART)
    sources: pd.Series = benchmark.layouts["sources"].loc[cases["layout"]]
    delivered = sources.map(lambda names: PALLET_SOFTWARE in names).to_numpy(bool)
    centred = (cases["scenario"] == str(Scenario.S1)).to_numpy(bool)
    return [str(name) for name in cases["layout"][delivered & centred].head(most)]

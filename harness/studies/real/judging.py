"""Methods judged on layouts of real size, and on small ones; an interrupted run is resumed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import pandas as pd

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
from steadyload.runs.able import able_methods
from steadyload.runs.definition import StudyDefinition
from steadyload.runs.runner import run_study
from steadyload.studies.kit import Lab


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
class JudgedReal:
    """Run folders of a study that was judged.

    Attributes:
        benchmark: the set of real size.
        real: run on its cases.
        small: run on small layouts; None where there is none.
        floors: runs on customers' pallets, by the words of :data:`FLOORS`; empty where the set, or
            the part of it, holds none.
        left_out: by spec, the reason why one of :func:`standard_methods` cannot judge.
    """

    benchmark: Benchmark
    real: Path
    small: Path | None
    floors: Mapping[str, Path]
    left_out: Mapping[str, str]


def judge_real(
    lab: Lab,
    methods: tuple[str, ...],
    directory: str,
    *,
    timeout: float,
    limit: int | None,
    small: int,
    pallets: int,
) -> JudgedReal:
    """Judge all cases by all methods, then customers' pallets on several floors by a few.

    Args:
        lab: where they are judged.
        methods: required specs: one that cannot judge is an error. Empty for
            :func:`standard_methods`, of which those that cannot judge are left out.
        directory: folder of the labelled set, or a word of
            :data:`steadyload.layouts.benchmark.dataset.SETS`.
        timeout: CPU seconds a judgement may take.
        limit: cases a scenario of that set, those of the first ranks; None for all.
        small: cases a scenario of the large set of the package, whose layouts are small.
        pallets: customers' pallets that are judged on several floors.

    Raises:
        SpecError, EngineNotInstalledError: a named method cannot judge.
        LearnerError: its weights cannot be read.
        NumberError: the timeout is no limit on a time.
        BenchmarkError: no labelled set, or it has no labelled case.
        as :func:`steadyload.runs.runner.run_study`.
    """
    able, left_out = able_methods(methods, standard_methods)
    asked = partial(StudyDefinition, timeout=timeout, shard_size=_SHARD_SIZE)
    named, work = set_named(directory), lab.work
    benchmark = load_benchmark(named)
    of_part = partial(asked, methods=able, benchmark=PART)
    runs = {work / REAL: of_part("real", benchmark_directory=named, limit=limit)}
    if small:
        runs[work / SMALL] = of_part("real small", limit=small)
    on_floors = tuple(spec for spec in able if spec in FLOOR_METHODS)
    chosen = _customers_pallets(benchmark, pallets) if on_floors else []
    floors: dict[str, Path] = {}
    if chosen:
        work.mkdir(parents=True, exist_ok=True)
        file = work.resolve() / "pallets.json"
        delivered = [benchmark.layout(name, str(Scenario.S1)) for name in chosen]
        write_layouts(without_link(file), delivered, Format.NATIVE)
        for number, (words, (floor, gap)) in enumerate(FLOORS.items()):
            floors[words] = work / f"floor-{number}"
            runs[floors[words]] = asked(
                f"real floor {number}", on_floors, files=(file,), floor=floor, snap_gap=gap
            )
    for folder, definition in runs.items():
        run_study(
            definition,
            folder,
            workers=lab.workers,
            progress=lambda *done: lab.progress("judging", *done),
        )
    return JudgedReal(benchmark, work / REAL, work / SMALL if small else None, floors, left_out)


def _customers_pallets(benchmark: Benchmark, most: int) -> list[str]:
    """Names of customers' pallets of the part that is judged, those of the first ranks."""
    cases = benchmark.select(PART)
    sources: pd.Series = benchmark.layouts["sources"].loc[cases["layout"]]
    delivered = sources.map(lambda names: PALLET_SOFTWARE in names).to_numpy(bool)
    centred = (cases["scenario"] == str(Scenario.S1)).to_numpy(bool)
    return [str(name) for name in cases["layout"][delivered & centred].head(most)]

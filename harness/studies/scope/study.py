"""Cases of real size, judged with the whole pile simulated and with parts of it left out."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from steadyload.layouts.benchmark import Benchmark, BenchmarkError, Part, load_benchmark
from steadyload.layouts.benchmark.dataset import KEYS
from steadyload.layouts.benchmark.tables import (
    CASES,
    OPINIONS,
    STANDS,
    write_further,
    write_tables,
)
from steadyload.layouts.question import Question
from steadyload.methods.registry import make_method
from steadyload.methods.simulation import Simulation
from steadyload.runs.definition import StudyDefinition
from steadyload.runs.pool import Executor
from steadyload.runs.runner import run_study
from steadyload.studies.scope.balanced_steps import BalancedSteps, balanced_steps
from steadyload.studies.scope.summary import ScopeTable, scope_table
from steadyload.studies.study import Progress, silent

WHOLE: Mapping[Question, str] = {
    Question.WITHIN: "label@mujoco",
    Question.STANDS: "label@mujoco:question=stands",
}
"""By question, the simulation of the whole pile that all options are compared with."""

OPTIONS = (
    "label@mujoco:scope=local",
    "label@mujoco:scope=widening,rest_speed=0.01",
    "label@mujoco:scope=moving",
    "label@mujoco:shrink=0.1mm",
    "label@mujoco:rest_speed=0.01",
    "label@mujoco:scope=moving,rest_speed=0.01",
    "label@mujoco:samples=3",
    "label@mujoco:solver_iterations=5",
    "label@mujoco:solver_iterations=20",
    "label@mujoco:solver_iterations=75",
    "label@bullet:scope=moving",
    "label@mujoco:question=stands,scope=widening,rest_speed=0.01",
    "label@mujoco:question=stands,scope=moving",
    "label@mujoco:question=stands,rest_speed=0.01",
    "label@mujoco:question=stands,scope=moving,rest_speed=0.01",
)
"""Options of the published page, of both questions."""

_PARTS = (str(Part.TRAIN), str(Part.VALIDATION))
_SHARD = 10


@dataclass(frozen=True, slots=True)
class ScopeOptions:
    """The methods that are compared, and how their cases are drawn.

    Its fields are those of :class:`steadyload.studies.scope.config.ScopeConfig`.
    """

    benchmark: str
    most_items: int
    cases: int
    standing_cases: int
    seconds: float
    methods: tuple[str, ...] = OPTIONS


@dataclass(frozen=True)
class ScopeResult:
    """Everything that the page shows.

    Attributes:
        tables: options beside the whole pile, by question.
        steps: of the whole labelled set, by balance.
        sources: number of cases drawn, by their source.
        boxes: the least and the greatest number of boxes of a case drawn.
        asked: of the run.
        label, screen: specs of the methods that gave the labels.
    """

    tables: Mapping[Question, ScopeTable]
    steps: BalancedSteps
    sources: Mapping[str, int]
    boxes: tuple[int, int]
    asked: ScopeOptions
    label: str
    screen: str


def run_scope(
    asked: ScopeOptions,
    work: Path,
    *,
    workers: int | Executor = 1,
    progress: Progress = silent,
) -> ScopeResult:
    """Judge the cases with all options, as far as that is missing, and compare verdicts and cost.

    Args:
        asked: the cases and options.
        work: folder of the cases drawn and of a run for each question.
        workers: see :func:`steadyload.runs.runner.run_study`.
        progress: called with the rows done and those to be done.

    Raises:
        BenchmarkError: no labelled set, or it has no such case.
        ResultsError: the folder holds something else.
    """
    benchmark = load_benchmark(asked.benchmark)
    chosen = drawn_cases(benchmark, asked.most_items, asked.cases)
    write_set(benchmark, chosen, work / "set")
    tables = {}
    for question, specs in by_question(asked.methods).items():
        # Ranks of the set drawn count within scenarios, and scenarios take turns.
        scenarios = chosen["scenario"].nunique()
        limit = -(-asked.standing_cases // scenarios) if question is Question.STANDS else None
        definition = StudyDefinition(
            f"scope-{question}",
            specs,
            limit=limit,
            shard_size=_SHARD,
            timeout=asked.seconds,
            benchmark=Part.ALL,
            benchmark_directory=work / "set",
        )
        folder = work / str(question)
        run_study(
            definition,
            folder,
            workers=workers,
            progress=lambda *done, q=question: progress(f"judging, question {q}", *done),
        )
        tables[question] = scope_table(folder, question, definition.methods[0])
    manifest = benchmark.manifest
    return ScopeResult(
        tables,
        balanced_steps(benchmark),
        dict(sorted(Counter(chosen["source"]).items())),
        (int(chosen["item_count"].min()), int(chosen["item_count"].max())),
        asked,
        str(manifest.get("label", "")),
        str(manifest.get("screen", "")),
    )


def by_question(options: tuple[str, ...]) -> dict[Question, tuple[str, ...]]:
    """Canonical specs by their question, that of the whole pile first.

    Raises:
        BenchmarkError: an option is no simulation.
    """
    found: dict[Question, list[str]] = {}
    for spec in options:
        method = make_method(spec)
        if not isinstance(method, Simulation):
            raise BenchmarkError(f"{spec} is no simulation; allowed: such as {OPTIONS[0]}")
        found.setdefault(method.parameters.question, []).append(str(method.spec))
    whole = {question: str(make_method(spec).spec) for question, spec in WHOLE.items()}
    return {
        question: tuple(dict.fromkeys([spec, *found[question]]))
        for question, spec in whole.items()
        if question in found
    }


def drawn_cases(benchmark: Benchmark, most_items: int, count: int) -> pd.DataFrame:
    """Labelled cases of train and validation, drawn in turns over sources and scenarios by rank.

    Args:
        benchmark: the labelled set.
        most_items: boxes that a case may have.
        count: of cases; fewer where there are not so many.

    Returns:
        Rows of the table of cases in the order drawn, with the column ``source``: the first of
        those that gave the layout.

    Raises:
        BenchmarkError: there is no such case.
    """
    cases = benchmark.cases
    allowed = cases["split"].isin(_PARTS) & (cases["item_count"] <= most_items)
    cases = cases[allowed & (cases["status"] == "done")]
    if cases.empty:
        raise BenchmarkError(
            f"the set has no labelled case of {most_items} boxes or fewer in {' or '.join(_PARTS)}"
        )
    first = benchmark.layouts["sources"].map(lambda names: str(names[0]))
    cases = cases.assign(source=first.loc[cases["layout"]].to_numpy())
    cases = cases.sort_values(["rank", "split", "layout"], kind="stable")
    turn = cases.groupby(["source", "scenario"]).cumcount()
    order = cases.assign(turn=turn).sort_values(["turn", "source", "scenario"], kind="stable")
    return order.head(count).drop(columns="turn").reset_index(drop=True)


def write_set(benchmark: Benchmark, chosen: pd.DataFrame, folder: Path) -> None:
    """Write drawn cases as a labelled set of their own, ranked in the order drawn."""
    ranked = chosen.assign(rank=chosen.groupby("scenario").cumcount().astype("Int32"))
    layouts = benchmark.layouts.loc[chosen["layout"].unique()].reset_index()
    keys = pd.MultiIndex.from_frame(chosen[KEYS])
    stands = benchmark.stands
    stands = stands[pd.MultiIndex.from_frame(stands[KEYS]).isin(keys)]
    none = pd.DataFrame(columns=OPINIONS.names)
    write_tables(folder, layouts, ranked[CASES.names], none, {"origin": "drawn"})
    write_further(folder, "stands", stands[STANDS.names], {})

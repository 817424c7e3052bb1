"""Results of Table 5, from verdicts and times. Shares are 0 to 1, times in ms.

A *group* is a scenario, or ``all`` for all cases; mappings by group hold ``all`` first.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path

import numpy as np
import pandas as pd

from steadyload.app.recommend.front import Front, Measured, on_front
from steadyload.app.recommend.kept import NAME, load_fronts, merged, write_fronts
from steadyload.app.recommend.measured import front_of
from steadyload.layouts.benchmark import Benchmark, load_benchmark
from steadyload.layouts.benchmark.dataset import KEYS
from steadyload.layouts.model.question import Question
from steadyload.methods.contract.spec import as_plain
from steadyload.methods.naming import MethodKey, method_key
from steadyload.methods.registry import make_method
from steadyload.methods.simulation.scene import planar_scene
from steadyload.methods.simulation.simulation import Simulation
from steadyload.runs.agreement import AgreementMatrix, agreement_matrix, tuning
from steadyload.runs.answers import judged_layouts, listed_cases
from steadyload.runs.comparison import Family, PairTest
from steadyload.runs.costs import timed_costs
from steadyload.runs.evaluation import (
    ALL,
    Evaluation,
    LabelledPart,
    MethodEvaluation,
    evaluate,
)
from steadyload.runs.judged import load_judged, manifest_lines
from steadyload.runs.labels import load_labels
from steadyload.runs.paper import Paper, paper
from steadyload.runs.results import LAYOUTS_FILE, kept_file
from steadyload.statistics.error_costs import CheapestRange, cheapest_by_ratio
from steadyload.statistics.estimate import Estimate
from steadyload.studies.rankings import Rankings
from steadyload.studies.table5.error_places import (
    ClassBin,
    MarginBin,
    SizeBin,
    class_bins,
    margin_bins,
    size_bins,
)
from steadyload.studies.table5.judging import YARDSTICK, Ran, Table5Options
from steadyload.studies.table5.label_ceiling import Ceiling, label_ceiling
from steadyload.studies.table5.watched import Watch, watched


@dataclass(frozen=True, slots=True)
class Timing:
    """Facts on the timing pass besides the times in the rows of the evaluation.

    ``yardstick``: the method that ratios refer to. ``shares``: by group and spec, CPU time over
    that of the yardstick on the same cases; of the methods that were timed, without the yardstick.
    ``spread``: by spec, largest minus smallest mean of a repeat, over the mean. ``untimed``:
    methods without times, with the reason. ``refused``: of methods with times, number of cases that
    they refuse; no method was timed on those.
    """

    yardstick: MethodKey | None
    shares: Mapping[str, Mapping[str, Estimate]]
    spread: Mapping[str, float]
    layouts: int
    item_lists: int
    repeats: int
    block: int
    untimed: Mapping[str, str]
    refused: Mapping[str, int]


@dataclass(frozen=True, slots=True)
class ErrorCosts:
    """Expected costs of errors, where an overestimation costs more than an underestimation or less.

    ``methods``: those on the front of accuracy and cost, and those that are the cheapest at some
    ratio of costs. ``cheapest``: of all methods, by ratio.
    """

    methods: tuple[MethodEvaluation, ...]
    cheapest: tuple[CheapestRange, ...]

    def title(self, spec: str) -> str:
        """Title of one of the methods."""
        return next(m.method.title for m in self.methods if m.method.spec == spec)


@dataclass(frozen=True, slots=True)
class JudgedSet:
    """All methods on a part of a labelled set.

    ``tunings``: by spec of a simulation, a text of its parameters; equal for equal parameters.
    ``fronts``: by group, specs of methods than which no cheaper one is as accurate, by rising cost;
    empty where nothing was timed. ``classes``: accuracy by class of items, of two classes or more.
    ``margins`` is empty where the set has none. ``without_label``: cases that were judged and have
    no label of the question, by the way in which labelling ended.
    """

    evaluation: Evaluation
    layouts: int
    timing: Timing
    tests: Mapping[str, Family[MethodKey]]
    tunings: Mapping[str, str]
    fronts: Mapping[str, tuple[str, ...]]
    matrix: AgreementMatrix
    classes: tuple[ClassBin, ...]
    sizes: tuple[SizeBin, ...]
    margins: tuple[MarginBin, ...]
    watched: tuple[Watch, ...]
    without_label: Mapping[str, int]

    @property
    def groups(self) -> tuple[str, ...]:
        """All cases, then the scenarios."""
        return self.evaluation.groups

    @property
    def about(self) -> LabelledPart:
        """About the labels of the cases."""
        assert self.evaluation.labelled is not None, "the study is on a labelled set"
        return self.evaluation.labelled

    @property
    def best(self) -> MethodEvaluation:
        """The most accurate method."""
        return max(self.evaluation.methods, key=lambda m: m.accuracy.value)

    @property
    def error_costs(self) -> ErrorCosts:
        """Expected costs of errors, on all cases."""
        own = {m.method.spec: m for m in self.evaluation.methods}
        shares = {spec: m.errors for spec, m in own.items() if m.errors is not None}
        cheapest = cheapest_by_ratio(shares)
        shown = dict.fromkeys((*self.fronts.get(ALL, ()), *(each.method for each in cheapest)))
        return ErrorCosts(tuple(own[spec] for spec in own if spec in shown), cheapest)

    def simulation_pairs(self, *, same_tuning: bool) -> tuple[PairTest[MethodKey], ...]:
        """Pairs of simulations with one tuning on two engines, or two tunings on one engine.

        Their p-values are corrected for the number of these pairs.
        """
        of = self.tunings

        def asked(test: PairTest[MethodKey]) -> bool:
            one, other = test.first, test.second
            return (
                one.spec in of
                and other.spec in of
                and (of[one.spec] == of[other.spec]) == same_tuning
                and (one.engine == other.engine) != same_tuning
            )

        return self.tests[ALL].only(asked).tests


@dataclass(frozen=True, slots=True)
class Table5:
    """All results on the page.

    ``question``: that of labels and methods. ``spatial``: 3-D methods; ``planar``: these and 2-D
    methods on planar layouts, None without 2-D methods. ``flat``: number of cases of ``spatial``
    that a 2-D engine could judge. ``left_out``: by spec, the reason for which a method is in no
    table. ``paper``: its own table; None where the question is not the paper's. ``rules``: methods
    under other rules; None where these were not asked for.
    """

    question: Question
    spatial: JudgedSet
    planar: JudgedSet | None
    flat: int
    planar_methods: tuple[MethodKey, ...]
    left_out: Mapping[str, str]
    paper: Paper | None
    ceiling: Ceiling | None
    same_order: tuple[int, int]
    manifest: Mapping[str, str]
    rules: Rankings | None = None


def summarise(asked: Table5Options, spatial: Ran, planar: Ran | None) -> Table5:
    """The records for the page.

    Raises:
        ResultsError: see :func:`steadyload.runs.judged.load_judged`.
        BenchmarkError: the labelled set cannot be read any more.
    """
    large = load_benchmark(spatial.study.benchmark_directory)
    found, about = _judged_set(asked, spatial, large, all_pairs=True)
    beside, about_planar = None, {}
    if planar is not None:
        small = load_benchmark(planar.study.benchmark_directory)
        # Too few item lists for all pairs: no difference could be significant.
        beside, lines = _judged_set(asked, planar, small, all_pairs=False)
        about_planar = {f"planar {key}": lines[key] for key in ("labelled set", "layouts", "rows")}
    labels = load_labels(spatial.directory)
    the_papers = asked.question is Question.WITHIN
    printed = paper() if the_papers else None
    return Table5(
        question=asked.question,
        spatial=found,
        planar=beside,
        flat=_flat(large, labels) if planar is not None else 0,
        planar_methods=tuple(method_key(make_method(spec)) for spec in asked.planar),
        left_out=asked.left_out,
        paper=printed,
        ceiling=label_ceiling(labels, large.opinions) if the_papers else None,
        same_order=(0, 0) if printed is None else same_order(printed, found.evaluation.methods),
        manifest={**about, **about_planar},
    )


def _flat(benchmark: Benchmark, labels: pd.DataFrame) -> int:
    """Number of cases that a 2-D engine could judge."""
    layouts = (benchmark.layout(name, scenario) for name, scenario in labels.index)
    return sum(planar_scene(layout).across is not None for layout in layouts)


def same_order(printed: Paper, methods: Sequence[MethodEvaluation]) -> tuple[int, int]:
    """Pairs of the paper's methods in the same order of accuracy here, and all that have one there.

    A column of the paper is compared with the mean over engines of the first of its families that
    was judged; namesakes do not count. A pair that is equal here does not count as in the same
    order.
    """
    ours = []
    for row in printed.rows:
        for family in row.families:
            own = [m.accuracy.value for m in methods if m.method.family == family]
            if own:
                ours.append((row.accuracy[ALL], float(np.mean(own))))
                break
    pairs = [(a[0] - b[0], a[1] - b[1]) for a, b in combinations(ours, 2)]
    return sum(there * here > 0.0 for there, here in pairs), sum(there != 0.0 for there, _ in pairs)


def _judged_set(
    asked: Table5Options, ran: Ran, benchmark: Benchmark, *, all_pairs: bool
) -> tuple[JudgedSet, Mapping[str, str]]:
    every = load_judged(ran.directory).of((*asked.shown, *asked.planar))
    judged = every.asked(asked.question)
    ran = ran.timed_among(judged.said.index)
    assert every.labels is not None, "the study is on a labelled set"
    lost = every.labels["stands"].drop(judged.said.index).fillna("not asked")
    timed = pd.MultiIndex.from_tuples(ran.cases, names=KEYS)
    evaluation = evaluate(judged, costs=timed_costs(ran.times, timed))
    said, labels = judged.said, judged.labels
    assert labels is not None, "there are labels of either question"
    compared = evaluation.compared().right.items()
    right = pd.DataFrame({key.spec: own for key, own in compared}, said.index)
    against = _held_against(evaluation).spec
    kept = kept_file(ran.directory, LAYOUTS_FILE, judged.manifest)
    cases = benchmark.cases.set_index(KEYS).loc[said.index]
    found = JudgedSet(
        evaluation=evaluation,
        layouts=judged.results["layout"].nunique(),
        timing=_timing(asked, ran, evaluation, timed),
        tests={
            group: evaluation.pairs(group) if all_pairs else evaluation.versus(against, group)
            for group in evaluation.groups
        },
        tunings=tunings(judged.keys),
        fronts={
            group: on_front(map(Measured.of, evaluation.rows[group])) for group in evaluation.groups
        },
        matrix=agreement_matrix(judged, judged_layouts(judged, kept, listed_cases(judged))),
        classes=class_bins(right, labels),
        sizes=size_bins(right, labels),
        margins=margin_bins(said, labels, list(cases["margin"])),
        watched=watched(ran.study, evaluation.methods, said, right, labels),
        without_label={str(status): int(n) for status, n in lost.value_counts().items()},
    )
    return found, manifest_lines(judged)


def _held_against(evaluation: Evaluation) -> MethodKey:
    """The yardstick, or the most accurate method where it was not judged."""
    known = evaluation.judged.keys
    return known.get(YARDSTICK) or max(evaluation.methods, key=lambda m: m.accuracy.value).method


def tunings(specs: Iterable[str]) -> dict[str, str]:
    """By spec of a simulation, a text of its parameters, equal for equal parameters.

    A tuned preset has different ones on every engine; parameters of a single engine are left out.
    """
    methods = [make_method(spec) for spec in specs]
    return {
        str(m.spec): tuning(as_plain(m.parameters)) for m in methods if isinstance(m, Simulation)
    }


def _timing(asked: Table5Options, ran: Ran, evaluation: Evaluation, timed: pd.MultiIndex) -> Timing:
    yardstick = evaluation.judged.keys.get(YARDSTICK) if YARDSTICK in ran.times.cpu else None
    others = [spec for spec in ran.times.cpu if yardstick is not None and spec != YARDSTICK]
    by_repeat = {spec: cpu.mean(axis=1) for spec, cpu in ran.times.cpu.items()}
    return Timing(
        yardstick=yardstick,
        shares={
            group: {spec: evaluation.cost_ratio(spec, YARDSTICK, group) for spec in others}
            for group in evaluation.groups
        },
        spread={spec: float(np.ptp(means) / means.mean()) for spec, means in by_repeat.items()},
        layouts=len(timed),
        item_lists=evaluation.judged.clusters.loc[timed].nunique(),
        repeats=asked.repeats,
        block=asked.block,
        untimed=ran.untimed,
        refused=ran.refused,
    )


def write_timed_front(found: Table5, work: Path) -> None:
    """Write what ``recommend`` reads to a work folder, beside what it holds of another question."""
    file = work / NAME
    kept = load_fronts(file) if file.exists() else ()
    write_fronts(merged(kept, [timed_front(found)]), file)


def timed_front(found: Table5) -> Front:
    """3-D methods of Table 5, with the times of its timing pass; those untimed are left out."""
    own = found.spatial.evaluation
    timing = found.spatial.timing
    times = f"mean of {timing.layouts} cases, {timing.repeats} times each, one thread"
    return front_of(own.judged, found.question, own.methods, times, found.manifest)

"""From what was judged and timed to the records that the page of Table 5 shows."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from itertools import combinations
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from steadyload.layouts.benchmark import Benchmark, load_benchmark
from steadyload.layouts.benchmark.dataset import KEYS
from steadyload.methods.naming import MethodKey, method_key
from steadyload.methods.registry import make_method
from steadyload.methods.scene import planar_scene
from steadyload.methods.simulation import Simulation
from steadyload.methods.spec import as_plain
from steadyload.runs.costs import timed_costs
from steadyload.runs.evaluation import (
    ALL,
    Evaluation,
    MethodEvaluation,
    evaluate,
    in_group,
    names_the_label,
)
from steadyload.runs.judged import load_judged
from steadyload.runs.labels import load_labels
from steadyload.statistics.metrics import mean
from steadyload.statistics.paired import LEVEL, holm, letters, sign_flip
from steadyload.studies.comparison.summary import agreement_matrix, manifest_lines, tuning
from steadyload.studies.table5.error_places import margin_bins, size_bins
from steadyload.studies.table5.front import Front as Measurements
from steadyload.studies.table5.front import Measured, best
from steadyload.studies.table5.label_ceiling import label_ceiling
from steadyload.studies.table5.paper import Paper, paper
from steadyload.studies.table5.records import (
    Front,
    JudgedSet,
    PairTest,
    PairTests,
    Table5,
    Timing,
    Watch,
)
from steadyload.studies.table5.study import YARDSTICK, Questions, Ran

_WATCHED = 8


def summarise(asked: Questions, spatial: Ran, planar: Ran | None) -> Table5:
    """All that the page shows.

    Raises:
        ResultsError: see :func:`steadyload.runs.judged.load_judged`.
        BenchmarkError: the labelled set cannot be read any more.
    """
    large = load_benchmark(spatial.study.benchmark_directory)
    found, about = _judged_set(asked, spatial, large, all_pairs=True)
    beside, about_planar = None, {}
    if planar is not None:
        small = load_benchmark(planar.study.benchmark_directory)
        # Too few item lists for all pairs: no difference would be too large for chance.
        beside, lines = _judged_set(asked, planar, small, all_pairs=False)
        about_planar = {f"planar {key}": lines[key] for key in ("labelled set", "layouts", "rows")}
    labels, printed = load_labels(spatial.directory), paper()
    return Table5(
        spatial=found,
        planar=beside,
        flat=_flat(large, labels) if planar is not None else 0,
        planar_methods=tuple(method_key(make_method(spec)) for spec in asked.planar),
        left_out=asked.left_out,
        paper=printed,
        ceiling=label_ceiling(labels, large.opinions),
        same_order=same_order(printed, found.evaluation.methods),
        manifest={**about, **about_planar},
    )


def _flat(benchmark: Benchmark, labels: pd.DataFrame) -> int:
    """Cases that an engine of two dimensions could judge."""
    layouts = (benchmark.layout(name, scenario) for name, scenario in labels.index)
    return sum(planar_scene(layout).across is not None for layout in layouts)


def same_order(printed: Paper, methods: Sequence[MethodEvaluation]) -> tuple[int, int]:
    """Pairs of the paper's methods in the same order of accuracy here, and all that have one there.

    A column of the paper is held against the mean over engines of the first of its families that
    was judged. A pair that is equal here is in no order.
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
    asked: Questions, ran: Ran, benchmark: Benchmark, *, all_pairs: bool
) -> tuple[JudgedSet, Mapping[str, str]]:
    judged = load_judged(ran.directory)
    timed = pd.MultiIndex.from_tuples(ran.cases, names=KEYS)
    evaluation = evaluate(judged, costs=timed_costs(ran.times, timed))
    said, labels = judged.said, judged.labels
    assert labels is not None, "the study is on a labelled set"
    specs = list(judged.keys)
    right = pd.DataFrame({spec: names_the_label(judged, spec) for spec in specs}, said.index)
    groups = {group: in_group(judged, group) for group in evaluation.groups}
    against = None if all_pairs else _held_against(evaluation)
    cases = benchmark.cases.set_index(KEYS).loc[said.index]
    found = JudgedSet(
        evaluation=evaluation,
        layouts=judged.results["layout"].nunique(),
        timing=_timing(asked, ran, evaluation, timed),
        tests={
            group: pair_tests(
                list(judged.keys.values()),
                right[here],
                labels["instance"].to_numpy()[here],
                against=against,
            )
            for group, here in groups.items()
        },
        tunings=tunings(specs),
        fronts={group: _front(evaluation.rows[group]) for group in groups},
        matrix=agreement_matrix(judged),
        sizes=size_bins(right, labels),
        margins=margin_bins(said, labels, list(cases["margin"])),
        watched=_watched(ran, evaluation.methods, said, right, labels),
    )
    return found, manifest_lines(judged)


def _held_against(evaluation: Evaluation) -> MethodKey:
    """The yardstick, or the most accurate method where it was not judged."""
    known = evaluation.judged.keys
    return known.get(YARDSTICK) or max(evaluation.methods, key=lambda m: m.accuracy.value).method


def pair_tests(
    methods: Sequence[MethodKey],
    right: pd.DataFrame,
    lists: NDArray[np.object_],
    *,
    against: MethodKey | None = None,
) -> PairTests:
    """Methods two by two on the same cases, corrected for the number of pairs.

    Args:
        methods: to compare.
        right: whether a method is right, cases x specs.
        lists: the item list of each case.
        against: one of the methods, to hold each of the others against; None tests all pairs.
    """
    of = {m: right[m.spec].to_numpy(int) for m in methods}
    pairs = list(combinations(methods, 2))
    if against is not None:
        pairs = [(m, against) for m in methods if m != against]
    lists = pd.factorize(lists)[0]
    raw = [sign_flip(of[a] - of[b], lists) for a, b in pairs]
    corrected = holm(raw)
    order = sorted(methods, key=lambda m: -of[m].mean())
    apart = {(a.spec, b.spec) for (a, b), p in zip(pairs, corrected, strict=True) if p < LEVEL}
    sizes = sorted(np.bincount(lists).tolist(), reverse=True)
    return PairTests(
        pairs=tuple(
            PairTest(a, b, mean(of[a] - of[b], lists), p, q)
            for (a, b), p, q in zip(pairs, raw, corrected, strict=True)
        ),
        letters=letters([m.spec for m in order], apart) if against is None else {},
        sizes=tuple(sizes),
        level=LEVEL,
        least=min(1.0, len(pairs) * 2.0 ** (1 - len(sizes))),
        against=against,
    )


def tunings(specs: Iterable[str]) -> dict[str, str]:
    """By spec of a simulation, a text of its parameters; the same one where they are the same.

    A preset that was tuned has others on every engine, and what only one engine has is left out.
    """
    methods = [make_method(spec) for spec in specs]
    return {
        str(m.spec): tuning(as_plain(m.parameters)) for m in methods if isinstance(m, Simulation)
    }


def _timing(asked: Questions, ran: Ran, evaluation: Evaluation, timed: pd.MultiIndex) -> Timing:
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


def _front(methods: Sequence[MethodEvaluation]) -> Front:
    measured = [
        Measured(m.method.spec, m.method.title, m.method.engine, m.accuracy, m.cpu)
        for m in methods
        if m.cpu.n
    ]
    if not measured:
        return Front(())
    return Front(tuple(m.method for m in best(Measurements(tuple(measured), {}))))


def _watched(
    ran: Ran,
    methods: Sequence[MethodEvaluation],
    said: pd.DataFrame,
    right: pd.DataFrame,
    labels: pd.DataFrame,
) -> tuple[Watch, ...]:
    """Robust cases that divide the methods most evenly, no two of one item list.

    Where half the methods are right, more can be learnt than where one of them is odd. Cases whose
    label nobody was asked again about count where none is known to be robust.
    """
    order = sorted(methods, key=lambda m: -m.accuracy.value)
    robust = labels["robust"].fillna(False).to_numpy(bool)
    cases = right[robust] if robust.any() else right
    wrong = len(order) - cases.sum(axis=1)
    divided = wrong[(wrong > 0) & (wrong < len(order))]
    evenly = (divided - 0.5 * len(order)).abs().sort_values(kind="stable")
    found: dict[str, Watch] = {}
    for case in evenly.index:
        name, scenario = case
        truth, label = right.loc[case], labels.loc[case]
        answers = said.loc[case]
        good = next(m.method for m in order if truth[m.method.spec])
        others = [m.method for m in order if not truth[m.method.spec]]
        bad = next((m for m in others if not pd.isna(answers[m.spec])), None)
        if bad is None or label["instance"] in found:
            continue
        found[label["instance"]] = Watch(
            layout=name,
            scenario=scenario,
            item_count=int(label["item_count"]),
            label=_step(label["failing_step"], label["item_count"]),
            right=good,
            wrong=bad,
            said=_step(answers[bad.spec], label["item_count"]),
            wrong_methods=int(wrong.loc[case]),
            methods=len(order),
            part=str(ran.study.benchmark),
            directory=str(ran.study.benchmark_directory or ""),
        )
        if len(found) == _WATCHED:
            break
    return tuple(found.values())


def _step(safe: Any, item_count: int) -> str:
    """A failing step for people; missing or all items for a stable layout."""
    return "stable" if pd.isna(safe) or int(safe) == int(item_count) else str(int(safe))

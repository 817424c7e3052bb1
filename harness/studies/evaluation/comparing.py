"""Results of an evaluation, from verdicts and times. Shares are 0 to 1, times in ms.

A *group* is a scenario, or ``all`` for all cases; mappings by group hold ``all`` first.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
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
from steadyload.learners.weights import load_weights
from steadyload.methods.contract.declared import Trait
from steadyload.methods.contract.spec import as_plain
from steadyload.methods.naming import MethodKey, method_key
from steadyload.methods.registry import make_method
from steadyload.methods.simulation.scene import planar_scene
from steadyload.methods.simulation.simulation import Simulation
from steadyload.reports.columns import (
    row,
)
from steadyload.runs.agreement import agreement_matrix, tuning
from steadyload.runs.answers import judged_layouts, listed_cases
from steadyload.runs.costs import load_explained, timed_costs
from steadyload.runs.evaluation import (
    ALL,
    Evaluation,
    MethodEvaluation,
    evaluate,
)
from steadyload.runs.judged import load_judged, manifest_lines
from steadyload.runs.labels import load_labels
from steadyload.runs.paper import Paper, paper
from steadyload.runs.results import LAYOUTS_FILE, kept_file
from steadyload.runs.timing import BLOCK
from steadyload.statistics.estimate import Estimate
from steadyload.studies.evaluation.error_places import (
    class_bins,
    margin_bins,
    size_bins,
)
from steadyload.studies.evaluation.judged_set import NEAR, YARDSTICK, JudgedSet
from steadyload.studies.evaluation.judging import Options, Ran, judged_and_timed
from steadyload.studies.evaluation.label_ceiling import Ceiling, label_ceiling
from steadyload.studies.evaluation.rows import Timing
from steadyload.studies.evaluation.watched import watched
from steadyload.studies.kit import Lab
from steadyload.studies.rankings import Rankings, ranked

_CONVERTED = frozenset({"ps3", "ps5"})


@row
class Found:
    """All results on the page.

    Attributes:
        question: that of labels and methods.
        own: 3-D methods.
        planar: these and 2-D methods on planar layouts, None without 2-D methods.
        flat: cases of ``own`` that a 2-D engine could judge.
        left_out: by spec, the reason for which a method is in no table.
        epochs: least and most epochs of the networks that learnt what the paper's are told, and
            those that were asked for; None where no learned method was judged.
        converted: whether PS_3 or PS_5 were judged in a reading converted to SI.
        same_order: pairs of the paper's methods in the same order here, and all pairs.
        rules: methods under other rules; None where these were not asked for.
    """

    question: Question
    own: JudgedSet
    planar: JudgedSet | None
    flat: int
    planar_methods: Sequence[MethodKey]
    left_out: Mapping[str, str]
    epochs: tuple[int, int, int] | None
    converted: bool
    ceiling: Ceiling | None
    same_order: tuple[int, int]
    rules: Rankings | None
    made_with: Mapping[str, str]
    near: float = NEAR

    @property
    def mix(self) -> Sequence[tuple[MethodKey, Sequence[Estimate]]]:
        """Accuracy by class of the best method, and of that on the front that it changes most."""
        own = self.own
        if not own.classes:
            return []

        def by_class(method: MethodEvaluation) -> list[Estimate]:
            return [bin_.accuracy[method.method.spec] for bin_ in own.classes]

        widest = max(own.front or [own.best], key=lambda m: np.ptp([e.value for e in by_class(m)]))
        shown = {m.method: by_class(m) for m in (own.best, widest)}
        return list(shown.items())


def compare(lab: Lab, asked: Options, *, rules: int = 0, views: int = 0) -> Found:
    """Judge and time what is missing, and compare; also writes what ``recommend`` reads.

    Args:
        lab: where it runs.
        asked: the options.
        rules: cases a scenario on which other rules are compared; 0 for none.
        views: cases that pages play.

    Raises:
        ResultsError: see :func:`steadyload.runs.judged.load_judged`.
        as :func:`.judged_and_timed`.
    """
    spatial, planar = judged_and_timed(lab, asked)
    large = load_benchmark(spatial.definition.benchmark_directory)
    own, about = _judged_set(asked, spatial, large, views=views)
    beside, about_planar = None, {}
    if planar is not None:
        small = load_benchmark(planar.definition.benchmark_directory)
        beside, lines = _judged_set(asked, planar, small)
        about_planar = {f"planar {key}": lines[key] for key in ("labelled set", "layouts", "rows")}
    labels = load_labels(spatial.folder)
    paper_asked = asked.question is Question.WITHIN
    keys = [m.method for m in own.evaluation.methods]
    epochs, converted = unlike_the_paper(keys if paper_asked else [])
    found = Found(
        question=asked.question,
        own=own,
        planar=beside,
        flat=_flat(large, labels) if planar is not None else 0,
        planar_methods=[method_key(make_method(spec)) for spec in asked.planar],
        left_out=asked.left_out,
        epochs=epochs,
        converted=converted,
        ceiling=label_ceiling(labels, large.opinions) if paper_asked else None,
        same_order=same_order(paper(), own.evaluation.methods) if paper_asked else (0, 0),
        rules=ranked(
            Lab(lab.work / "rules", lab.workers, lab.progress), asked.methods, rules,
            asked.directory,
        ) if rules and paper_asked else None,
        made_with={**about, **about_planar},
    )  # fmt: skip
    write_timed_front(found, lab.work)
    return found


def unlike_the_paper(methods: Sequence[MethodKey]) -> tuple[tuple[int, int, int] | None, bool]:
    """:attr:`Found.epochs` and :attr:`Found.converted` of some methods."""
    theirs = [key for key in methods if paper().row_of(key)]
    converted = any(key.family in _CONVERTED for key in theirs)
    if not any(Trait.LEARNED in make_method(key.spec).traits for key in theirs):
        return None, converted
    members = load_weights("lstm_e-paper").manifest["members"]
    epochs = [member["epochs"] for member in members]
    return (min(epochs), max(epochs), members[0]["options"]["epochs"]), converted


def _flat(benchmark: Benchmark, labels: pd.DataFrame) -> int:
    layouts = (benchmark.layout(name, scenario) for name, scenario in labels.index)
    return sum(planar_scene(layout).across is not None for layout in layouts)


def same_order(printed: Paper, methods: Sequence[MethodEvaluation]) -> tuple[int, int]:
    """Pairs of the paper's methods in the same order of accuracy here, and all that have one there.

    A column of the paper is compared with the mean over engines of the first of its families that
    was judged; namesakes do not count. A pair that is equal here does not count as in the same
    order.
    """
    ours = []
    for theirs in printed.rows:
        for family in theirs.families:
            own = [m.accuracy.value for m in methods if m.method.family == family]
            if own:
                ours.append((theirs.accuracy[ALL], float(np.mean(own))))
                break
    pairs = [(a[0] - b[0], a[1] - b[1]) for a, b in combinations(ours, 2)]
    return sum(there * here > 0.0 for there, here in pairs), sum(there != 0.0 for there, _ in pairs)


def _judged_set(
    asked: Options, ran: Ran, benchmark: Benchmark, *, views: int = 0
) -> tuple[JudgedSet, Mapping[str, str]]:
    every = load_judged(ran.folder).of((*asked.shown, *asked.planar))
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
    best = max(evaluation.methods, key=lambda m: m.accuracy.value).method.spec
    against = YARDSTICK if YARDSTICK in judged.keys else best
    kept = kept_file(ran.folder, LAYOUTS_FILE, judged.manifest)
    cases = benchmark.cases.set_index(KEYS).loc[said.index]
    # Too few item lists for all pairs of planar methods: no difference could be significant.
    all_pairs = not ran.is_planar
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
        watched=watched(ran.definition, evaluation.methods, said, right, labels, views),
        without_label={str(status): int(n) for status, n in lost.value_counts().items()},
        paper=paper() if asked.question is Question.WITHIN and all_pairs else None,
    )
    return found, manifest_lines(judged)


def tunings(specs: Iterable[str]) -> dict[str, str]:
    """By spec of a simulation, a text of its parameters, equal for equal parameters.

    A tuned preset has different ones on every engine; parameters of a single engine are left out.
    """
    methods = [make_method(spec) for spec in specs]
    return {
        str(m.spec): tuning(as_plain(m.parameters)) for m in methods if isinstance(m, Simulation)
    }


def _timing(asked: Options, ran: Ran, evaluation: Evaluation, timed: pd.MultiIndex) -> Timing:
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
        block=BLOCK,
        untimed=ran.untimed,
        refused=ran.refused,
        load=load_explained(evaluation.cost_source.load),
    )


def write_timed_front(found: Found, work: Path) -> None:
    """Write what ``recommend`` reads to a work folder, beside what it holds of another question."""
    file = work / NAME
    kept = load_fronts(file) if file.exists() else ()
    write_fronts(merged(kept, [timed_front(found)]), file)


def timed_front(found: Found) -> Front:
    """3-D methods, with the times of the timing pass; those untimed are left out."""
    own, timing = found.own.evaluation, found.own.timing
    times = f"mean of {timing.layouts} cases, {timing.repeats} times each, one thread"
    return front_of(own.judged, found.question, own.methods, times, found.made_with)

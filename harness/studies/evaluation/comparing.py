"""Results of an evaluation, from verdicts and times. Shares are 0 to 1, times in ms.

A *group* is a scenario, or ``all`` for all cases; mappings by group hold ``all`` first.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import combinations, pairwise
from pathlib import Path

import numpy as np
import pandas as pd

from steadyload.app.recommend.kept import NAME, SMALL, load_fronts, merged, write_fronts
from steadyload.app.recommend.measured import front_of
from steadyload.labelling.ceiling import Ceiling, label_ceiling
from steadyload.labelling.screened import (
    CheckedScreening,
    ScreenedSteps,
    checked_screening,
    screened_steps,
)
from steadyload.layouts.benchmark.dataset import KEYS, Benchmark, load_benchmark
from steadyload.layouts.benchmark.parts import PLANAR
from steadyload.layouts.model.question import Question
from steadyload.layouts.sizes import FEWER, FINE_SIZES, MOST_SMALL
from steadyload.learners.weights import load_weights
from steadyload.methods.contract.declared import Trait
from steadyload.methods.naming import MethodKey, method_key
from steadyload.methods.registry import make_method
from steadyload.methods.simulation.scene import planar_scene
from steadyload.reports.columns import row
from steadyload.runs.agreement import AgreementMatrix
from steadyload.runs.answers import answers_of, judged_layouts, listed_cases
from steadyload.runs.comparison import compared
from steadyload.runs.costs import CPU, Costs, limited_costs, timed_costs
from steadyload.runs.definition import StudyError
from steadyload.runs.evaluation import ALL, MethodEvaluation, evaluate
from steadyload.runs.judged import JudgedCases, load_judged, manifest_lines
from steadyload.runs.labels import load_labels
from steadyload.runs.paper import Paper, paper
from steadyload.runs.results import kept_layouts
from steadyload.statistics.metrics import share
from steadyload.studies.evaluation.costing import growth_of
from steadyload.studies.evaluation.crossed import Crossed, crossed
from steadyload.studies.evaluation.delivered import Origin, failing_shares, origins
from steadyload.studies.evaluation.error_places import (
    SMALL_SIZES,
    class_bins,
    margin_bins,
    size_bins,
)
from steadyload.studies.evaluation.falls import FallsFound, falls_found
from steadyload.studies.evaluation.floors import FloorRow, floor_rows
from steadyload.studies.evaluation.judged_set import YARDSTICK, JudgedSet
from steadyload.studies.evaluation.judging import (
    Options,
    Ran,
    Timed,
    judged_and_timed,
    tunings,
    without_verdict,
)
from steadyload.studies.evaluation.parts import (
    by_origin,
    by_size,
    failing_accuracy,
    origin_masks,
)
from steadyload.studies.evaluation.rows import Failing, NoVerdict
from steadyload.studies.evaluation.timing_pass import timing_of
from steadyload.studies.evaluation.watched import watched
from steadyload.studies.kit import Lab

_CONVERTED = frozenset({"ps3", "ps5"})


@row
class Found:
    """All results on the page.

    Attributes:
        sets: 3-D methods, by question.
        planar: these and 2-D methods on planar layouts, None without 2-D methods.
        flat: cases that a 2-D engine could judge.
        left_out: by spec, the reason for which a method is in no table.
        epochs: least and most epochs of the networks that learnt what the paper's are told, and
            those that were asked for; None where no learned method was judged.
        converted: whether PS_3 or PS_5 were judged in a reading converted to SI.
        same_order: pairs of the paper's methods in the same order here, and all pairs.
        crossed: how far accuracies of the first set lie apart with other heuristics; empty where
            other software packed it.
        small: whether the first bin of boxes is of small layouts of the large set.
        lost: cases without a verdict.
        origins: who planned the cases; empty where no customer did.
        falls: falls that are found, and false alarms; empty where no customer planned a case.
        floors: shares of customers' pallets that are called stable, by floor.
        screened, checked: how labels were made by screening, in all and by size.
        fails: shares of cases whose label is a failing step, here and in the whole set.
        unlabelled: cases of the set without labels, by status.
    """

    sets: Sequence[JudgedSet]
    planar: JudgedSet | None
    flat: int
    planar_methods: Sequence[MethodKey]
    left_out: Mapping[str, str]
    epochs: tuple[int, int, int] | None
    converted: bool
    ceiling: Ceiling | None
    same_order: tuple[int, int]
    crossed: Sequence[Crossed]
    small: bool
    lost: Sequence[NoVerdict]
    origins: Sequence[Origin]
    falls: Sequence[FallsFound]
    floors: Sequence[FloorRow]
    screened: ScreenedSteps
    checked: Sequence[CheckedScreening]
    fails: Sequence[Failing]
    unlabelled: Mapping[str, int]
    made_with: Mapping[str, str]
    screened_above: int = MOST_SMALL

    @property
    def own(self) -> JudgedSet:
        """The methods for the first question."""
        return self.sets[0]

    @property
    def screens(self) -> Sequence[str]:
        """Simulations on which labels of large layouts of this page rest."""
        return self.own.evaluation.judged.screens

    @property
    def apart(self) -> Sequence[MethodKey]:
        """Methods that are shown, and are compared with no other."""
        judged = [own.evaluation.judged for own in self.sets]
        return list(dict.fromkeys(j.keys[s] for j in judged for s in j.keys if s in j.apart))


def compare(lab: Lab, asked: Options, *, sizes: tuple[int, ...] = (), views: int = 0) -> Found:
    """Judge and time what is missing, and compare; also writes what ``recommend`` reads.

    Args:
        lab: where it runs.
        asked: the options.
        sizes: largest numbers of boxes of bins; empty for the usual ones.
        views: cases that pages play.

    Raises:
        StudyError: sizes that do not rise.
        ResultsError: see :func:`steadyload.runs.judged.load_judged`.
        as :func:`.judged_and_timed`.
    """
    if sizes and (sizes[0] < 1 or any(b <= a for a, b in pairwise(sizes))):
        listed = ", ".join(map(str, sizes))
        raise StudyError(f"sizes are {listed}; allowed: whole numbers that rise from 1 on")
    ran = judged_and_timed(lab, asked)
    main, *_ = ran.values()
    benchmark = load_benchmark(main.definition.benchmark_directory)
    small = load_judged(ran[SMALL].folder) if SMALL in ran else None
    usual = SMALL_SIZES if asked.timeout is None else (SMALL_SIZES[-1], FEWER, *FINE_SIZES)
    judged = load_judged(main.folder)
    labelled = [q for q in asked.questions if len(judged.asked(q).said)]
    sets = [
        _judged_set(asked, main, benchmark, q, sizes or usual, small=small, views=views)
        for q in labelled or asked.questions[:1]
    ]
    planar = None
    if PLANAR in ran:
        of_planar = load_benchmark(PLANAR)
        planar = _judged_set(asked, ran[PLANAR], of_planar, Question.WITHIN, SMALL_SIZES)
    labels = load_labels(main.folder)
    within, first = Question.WITHIN in asked.questions, asked.questions[0]
    papers = within and asked.timeout is None
    epochs, converted = unlike_the_paper(list(sets[0].evaluation.judged.keys.values()))
    unlabelled = benchmark.cases["status"].value_counts().sort_index()
    made_with = manifest_lines(sets[0].evaluation.judged)
    if sets[0].timing:
        made_with |= {f"times: {name}": of for name, of in sets[0].timing.made_with.items()}
    if planar:
        lines = manifest_lines(planar.evaluation.judged)
        made_with |= {f"planar {key}": lines[key] for key in ("labelled set", "layouts", "rows")}
    found = Found(
        sets=sets,
        planar=planar,
        flat=_flat(benchmark, labels) if planar else 0,
        planar_methods=[method_key(make_method(spec)) for spec in asked.planar],
        left_out=asked.left_out,
        epochs=epochs if papers else None,
        converted=converted and papers,
        ceiling=label_ceiling(
            judged.asked(first).labels, benchmark.further_verdicts_on(first), first
        ),
        same_order=same_order(paper(), sets[0].evaluation.methods) if papers else (0, 0),
        crossed=crossed(sets[0]),
        small=small is not None,
        lost=without_verdict(
            [one.folder for one in ran.values()],
            {spec: key for own in sets for spec, key in own.evaluation.judged.keys.items()},
        ),
        origins=origins(judged, benchmark.layouts),
        falls=[
            each
            for own in sets
            for each in falls_found(own.evaluation, benchmark, own.question)
        ],
        floors=floor_rows(lab, asked, benchmark),
        screened=screened_steps(benchmark.screening),
        checked=checked_screening(benchmark.screening, benchmark.cases),
        fails=[
            each
            for own in sets
            for each in failing_shares(own.question, own.evaluation.judged, benchmark)
        ],
        unlabelled={str(k): int(v) for k, v in unlabelled.items() if k != "done"},
        made_with=made_with,
    )  # fmt: skip
    for own in sets:
        _write_front(own, made_with, lab.work)
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
    asked: Options,
    ran: Ran,
    benchmark: Benchmark,
    question: Question,
    sizes: Sequence[int],
    *,
    small: JudgedCases | None = None,
    views: int = 0,
) -> JudgedSet:
    every = load_judged(ran.folder).of((*asked.shown(question), *asked.planar))
    judged = every.asked(question).with_confidence(benchmark.confidence_on(question))
    said, labels = judged.said, judged.labels
    assert every.labels is not None, "the study is on a labelled set"
    assert labels is not None, "there are labels of either question"
    lost = every.labels["stands"].drop(said.index).fillna("not asked")
    timed = ran.timed.among(said.index) if ran.timed else None
    evaluation = evaluate(judged, costs=_costs_of(judged, timed, asked))
    best = evaluation.best.method.spec
    against = YARDSTICK if YARDSTICK in judged.keys else best
    kept = kept_layouts(ran.folder, judged.manifest)
    cases = benchmark.cases.set_index(KEYS).loc[said.index]
    is_planar = ran.definition.benchmark_directory == PLANAR
    right = _right(judged)
    fails = labels["failing_step"].notna().to_numpy(bool)
    limit = asked.timeout
    parts = [judged] if small is None else [small.of(judged.keys).asked(question), judged]
    costs = None if timed else pd.concat([_cpu(own, asked) for own in parts])
    masks = {} if limit is None else origin_masks(judged, benchmark.layouts)
    of_origin = {
        name: size_bins(right[here], labels[here], sizes, _cpu(judged, asked)[here], stated=True)
        for name, here in masks.items()
    }
    return JudgedSet(
        question=question,
        evaluation=evaluation,
        layouts=judged.results["layout"].nunique(),
        timing=timing_of(asked, timed, evaluation) if timed else None,
        # Too few item lists for all pairs of planar methods: no difference could be significant.
        tests={
            group: evaluation.versus(against, group) if is_planar else evaluation.pairs(group)
            for group in evaluation.groups
        },
        tunings=tunings(judged.keys),
        answers=AgreementMatrix(
            tuple(judged.keys.values()),
            (),
            answers_of(judged, judged_layouts(judged, kept, listed_cases(judged))),
        ),
        classes=class_bins(right, labels),
        sizes=size_bins(
            pd.concat(map(_right, parts)),
            pd.concat(_labels(own) for own in parts),
            sizes,
            costs,
            stated=limit is not None,
        ),
        margins=margin_bins(said, labels, list(cases["margin"])),
        watched=watched(ran.definition, evaluation.comparable, said, right, labels, views),
        without_label={str(status): int(n) for status, n in lost.value_counts().items()},
        paper=None if is_planar or timed is None or question == Question.STANDS else paper(),
        failing=failing_accuracy(evaluation),
        stable=share(~fails, judged.clusters),
        growth={} if timed else {spec: growth_of(spec, judged, small) for spec in judged.keys},
        spans=() if limit is None else by_size(judged, limit),
        origins=() if limit is None else by_origin(judged, benchmark.layouts, limit, of_origin),
    )


def _labels(judged: JudgedCases) -> pd.DataFrame:
    assert judged.labels is not None, "the study is on a labelled set"
    return judged.labels


def _right(judged: JudgedCases) -> pd.DataFrame:
    """Mask of the cases on which a method is right, cases x specs."""
    found = compared(judged).right
    return pd.DataFrame({key.spec: own for key, own in found.items()}, judged.said.index)


def _costs_of(judged: JudgedCases, timed: Timed | None, asked: Options) -> Costs:
    if timed is None:
        return limited_costs(judged.results, asked.timeout or math.inf)
    return timed_costs(timed.times, pd.MultiIndex.from_tuples(timed.cases, names=KEYS))


def _cpu(judged: JudgedCases, asked: Options) -> pd.DataFrame:
    """CPU times of judging [ms], cases x specs; missing where there is none."""
    taken = _costs_of(judged, None, asked).milliseconds
    return pd.DataFrame({spec: own[CPU] for spec, own in taken.items()}, judged.said.index)


def _write_front(own: JudgedSet, made_with: Mapping[str, str], work: Path) -> None:
    """Write what ``recommend`` reads to a work folder, beside what it holds of another question.

    Methods without times are left out.
    """
    if own.timing is not None:
        often = f", {own.timing.repeats} times each" if own.timing.repeats > 1 else ""
        times = f"mean of {own.timing.layouts} cases{often}, one thread"
        methods, judged = own.evaluation.methods, own.evaluation.judged
        file = work / NAME
        kept = load_fronts(file) if file.exists() else ()
        about = {**made_with, **own.timing.made_with}  # the machine is that of the times
        new = front_of(judged, own.question, methods, times, about)
        write_fronts(merged(kept, [new]), file)

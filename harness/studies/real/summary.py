"""Records for the page of layouts of real size, and their computation from run folders."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from steadyload.layouts.benchmark import Benchmark, BenchmarkError
from steadyload.layouts.model.question import Question
from steadyload.methods.contract.method import Status
from steadyload.methods.naming import MethodKey
from steadyload.runs.able import asked_question
from steadyload.runs.accuracy import accuracy_of
from steadyload.runs.costs import CPU, CostKind, CostSource, judging_costs
from steadyload.runs.evaluation import evaluate
from steadyload.runs.judged import JudgedCases, load_judged, manifest_lines
from steadyload.runs.results import load_results
from steadyload.statistics.estimate import NOTHING, Estimate
from steadyload.statistics.growth import exponent
from steadyload.statistics.metrics import share
from steadyload.studies.real.best import BestMethod, best_method
from steadyload.studies.real.delivered import Origin, origins
from steadyload.studies.real.floors import FloorRow, floor_rows
from steadyload.studies.real.screened import ScreenedSteps, screened_steps
from steadyload.studies.real.study import JudgedReal, RealStudyOptions

CONSTANT = MethodKey('the constant "stable"', "", "constant")
"""Stands for the verdict that every layout is stable."""

NEAR = 0.01
"""Accuracy by which the method to choose may be behind the most accurate one."""

_WITHOUT_COST = (Status.REFUSED, Status.CRASHED, Status.ERROR)

BoolArray = NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class Accuracy:
    """Accuracy by the labels of one question.

    A refused case is left out; a case without a verdict for another reason counts as wrong.

    Attributes:
        overall: on all cases that have such a label.
        failing: on those whose label is a failing step.
        behind: accuracy minus that of the most accurate method, on the same cases, where refused
            cases count as wrong; None for that method itself, and where it is not asked for.
    """

    overall: Estimate = NOTHING
    failing: Estimate = NOTHING
    behind: Estimate | None = None


@dataclass(frozen=True, slots=True)
class JudgingCost:
    """CPU time of a judgement over cases [ms]: mean, median, 90th percentile, largest."""

    n: int
    mean: float
    median: float
    ninety: float
    worst: float


@dataclass(frozen=True, slots=True)
class MethodResult:
    """Accuracy and cost of one method on a group of cases.

    Attributes:
        method: its name and spec.
        asked: the question that it is asked; None where it has no such parameter.
        accuracy: by the labels of either question.
        cost: of a judgement; None where all were refused or ended their process.
        without_verdict: cases without a verdict, by status.
    """

    method: MethodKey
    asked: Question | None
    accuracy: Mapping[Question, Accuracy]
    cost: JudgingCost | None
    without_verdict: Mapping[str, int]


@dataclass(frozen=True, slots=True)
class SizeGroup:
    """Cases with about as many boxes.

    Attributes:
        fewest, most: boxes of a layout.
        middle: median number of boxes.
        cases, item_lists: how many there are.
        failing: share of cases whose label is a failing step, by question.
        methods: a result a method, in the order of the study; the last one is :data:`CONSTANT`.
    """

    fewest: int
    most: int
    middle: float
    cases: int
    item_lists: int
    failing: Mapping[Question, Estimate]
    methods: tuple[MethodResult, ...]

    @property
    def title(self) -> str:
        """The numbers of boxes."""
        return f"{self.fewest} to {self.most}" if self.most > self.fewest else f"{self.most}"

    def of(self, spec: str) -> MethodResult:
        """The result of a method."""
        return next(result for result in self.methods if result.method.spec == spec)


@dataclass(frozen=True, slots=True)
class Growth:
    """Exponent of the number of boxes in the CPU time of a method.

    Over the cases that it calls stable, so that all boxes were judged: of those of real size, and
    of these with small ones.
    """

    real: Estimate
    everything: Estimate


@dataclass(frozen=True, slots=True)
class NoVerdict:
    """Cases on which a method ended with one status; ``reason`` of that with most boxes."""

    method: str
    status: str
    cases: int
    fewest: int
    most: int
    reason: str


@dataclass(frozen=True)
class RealSummary:
    """Everything that the page shows.

    Attributes:
        real: all cases of the set of real size.
        groups: small cases first, then those of real size by number of boxes.
        small: whether the first group is of small layouts.
        growth: of the CPU time, by spec.
        chosen: by question, the cheapest method (by the median) that is at most :data:`NEAR` behind
            the most accurate one, which itself may be it; a question without a label is missing.
        best: by question, the most accurate method, and those that do not differ from it
            significantly; a question without a label is missing.
        origins: who planned the cases.
        lost: cases without a verdict.
        floors: shares of customers' pallets that are called stable, by floor; empty without any.
        screened: agreement of screen and reference while the labels were made.
        natural: share of failing labels in the whole set, by question.
        unlabelled: cases of the set without labels, by status.
        timeout: CPU seconds a judgement may take.
        left_out: by spec, the reason why a method cannot judge.
        cost_source: explains the costs.
        manifest: provenance.
    """

    real: SizeGroup
    groups: tuple[SizeGroup, ...]
    small: bool
    growth: Mapping[str, Growth]
    chosen: Mapping[Question, MethodResult]
    best: Mapping[Question, BestMethod]
    origins: tuple[Origin, ...]
    lost: tuple[NoVerdict, ...]
    floors: tuple[FloorRow, ...]
    screened: ScreenedSteps
    natural: Mapping[Question, Estimate]
    unlabelled: Mapping[str, int]
    timeout: float
    left_out: Mapping[str, str]
    cost_source: CostSource
    manifest: Mapping[str, str]


def summarise(asked: RealStudyOptions, judged: JudgedReal) -> RealSummary:
    """The summary of a study that was judged.

    Raises:
        ResultsError: see :func:`steadyload.runs.judged.load_judged`.
    """
    real = load_judged(judged.real)
    small = None if judged.small is None else load_judged(judged.small)
    whole = _group(real, asked.timeout, compared=True)
    parts = [real.only(here) for here in bins(real, asked.sizes)]
    groups = [_group(part, asked.timeout) for part in ([small] if small else []) + parts]
    statuses = judged.benchmark.cases["status"].value_counts().sort_index()
    return RealSummary(
        real=whole,
        groups=tuple(groups),
        small=small is not None,
        growth={spec: _growth(spec, real, small) for spec in real.keys},
        chosen={q: found for q in Question if (found := _chosen(whole, q)) is not None},
        best={q: own for q in Question if (own := best_method(real, q)) is not None},
        origins=origins(real, judged.benchmark.layouts),
        lost=_lost([folder for folder in (judged.small, judged.real) if folder]),
        floors=floor_rows(judged),
        screened=screened_steps(judged.benchmark.screening),
        natural={question: _natural(judged.benchmark, question) for question in Question},
        unlabelled={str(k): int(v) for k, v in statuses.items() if k != "done"},
        timeout=asked.timeout,
        left_out=asked.left_out,
        cost_source=CostSource(CostKind.JUDGING),
        manifest=manifest_lines(real),
    )


def _natural(benchmark: Benchmark, question: Question) -> Estimate:
    """Share of failing labels over all cases of a set, whether in a part or not."""
    try:
        cases = benchmark.select(question=question)
    except BenchmarkError:
        return NOTHING
    return share(cases["failing_step"].notna(), cases["instance"])


def bins(judged: JudgedCases, sizes: tuple[int, ...]) -> list[BoolArray]:
    """Masks of the cases of each bin that has any; what is larger than all is a last bin."""
    counts = _labels(judged)["item_count"].to_numpy(int)
    edges = pairwise((0, *sizes, np.inf))
    masks = [(counts > low) & (counts <= high) for low, high in edges]
    return [mask for mask in masks if mask.any()]


def _labels(judged: JudgedCases) -> pd.DataFrame:
    assert judged.labels is not None, "the runs are on labelled sets"
    return judged.labels


def _group(judged: JudgedCases, timeout: float, *, compared: bool = False) -> SizeGroup:
    """The results of all methods on some cases; ``compared`` with the most accurate one, too."""
    labels = _labels(judged)
    counts = labels["item_count"].to_numpy(int)
    by_question = {question: judged.asked(question) for question in Question}
    behind: dict[Question, dict[str, Estimate | None]] = {}
    for question, part in by_question.items():
        found = evaluate(part, by_scenario=False).methods if compared and len(part.said) else ()
        behind[question] = {row.method.spec: row.behind for row in found}
    failing = {
        q: share(_labels(part)["failing_step"].notna(), part.clusters)
        for q, part in by_question.items()
    }
    methods = [
        MethodResult(
            method=key,
            asked=asked_question(spec),
            accuracy={
                q: _accuracy(part, spec, behind[q].get(spec)) for q, part in by_question.items()
            },
            cost=_cost(judged, spec, timeout),
            without_verdict={
                str(k): int(v) for k, v in _status(judged, spec).value_counts().sort_index().items()
                if k != str(Status.DONE)
            },
        )
        for spec, key in judged.keys.items()
    ]  # fmt: skip
    constant = {q: _constant(part) for q, part in by_question.items()}
    return SizeGroup(
        fewest=int(counts.min()),
        most=int(counts.max()),
        middle=float(np.median(counts)),
        cases=len(labels),
        item_lists=labels["instance"].nunique(),
        failing=failing,
        methods=(*methods, MethodResult(CONSTANT, None, constant, None, {})),
    )


def _status(judged: JudgedCases, spec: str) -> pd.Series:
    """The status of a method's verdicts, in the order of the cases."""
    own = judged.results[judged.results["method"] == spec]
    first = own[own["repetition"] == 0].set_index(["layout", "scenario"])
    return first["status"].loc[judged.said.index]


def _accuracy(judged: JudgedCases, spec: str, behind: Estimate | None) -> Accuracy:
    taken = (_status(judged, spec) != str(Status.REFUSED)).to_numpy(bool)
    return _accuracy_of(judged.said[spec][taken], _labels(judged)[taken], behind)


def _constant(judged: JudgedCases) -> Accuracy:
    labels = _labels(judged)
    return _accuracy_of(labels["item_count"], labels, None)


def _accuracy_of(said: pd.Series, labels: pd.DataFrame, behind: Estimate | None) -> Accuracy:
    fails = labels["failing_step"].notna().to_numpy(bool)
    return Accuracy(accuracy_of(said, labels), accuracy_of(said[fails], labels[fails]), behind)


def _costs(judged: JudgedCases, spec: str) -> pd.Series:
    """CPU time of every case [ms], in the order of the cases."""
    taken = judging_costs(judged.results, CostSource(CostKind.JUDGING)).of(spec)
    assert taken is not None, "the method has judged"
    return taken[CPU].loc[judged.said.index]


def judging_times(judged: JudgedCases, spec: str, timeout: float) -> pd.Series:
    """CPU time of judging by case [ms]; of a judgement that was given up, at least the time limit.

    Cases that were refused, or that ended the process, are missing.
    """
    status, cost = _status(judged, spec), _costs(judged, spec)
    given_up = status == str(Status.TIMEOUT)
    cost = cost.where(~given_up, cost.clip(lower=1e3 * timeout))
    return cost[~status.isin([str(s) for s in _WITHOUT_COST])]


def _cost(judged: JudgedCases, spec: str, timeout: float) -> JudgingCost | None:
    """Cost of judging, see :func:`judging_times`."""
    cost = judging_times(judged, spec, timeout)
    if cost.empty:
        return None
    median, ninety = np.quantile(cost, (0.5, 0.9))
    return JudgingCost(
        len(cost), float(cost.mean()), float(median), float(ninety), float(cost.max())
    )


def _growth(spec: str, real: JudgedCases, small: JudgedCases | None) -> Growth:
    of_real = _stable_costs(real, spec)
    everything = of_real if small is None else pd.concat([_stable_costs(small, spec), of_real])
    return Growth(*(exponent(d["boxes"], d["cost"], d["list"]) if len(d) else NOTHING
                    for d in (of_real, everything)))  # fmt: skip


def _stable_costs(judged: JudgedCases, spec: str) -> pd.DataFrame:
    """Boxes, cost and item list of the cases that a method calls stable."""
    boxes = _labels(judged)["item_count"].astype(int)
    stable = (judged.said[spec] == boxes).fillna(False).to_numpy(bool)
    cost = _costs(judged, spec)
    found = pd.DataFrame({"boxes": boxes, "cost": cost, "list": judged.clusters})[stable]
    return found[found["cost"] > 0.0]


def _chosen(whole: SizeGroup, question: Question) -> MethodResult | None:
    """See :attr:`RealSummary.chosen`."""
    close = [
        (result.cost.median, result)
        for result in whole.methods
        if result.cost is not None
        and result.accuracy[question].overall.n
        and ((behind := result.accuracy[question].behind) is None or behind.value >= -NEAR)
    ]
    return min(close, key=lambda pair: pair[0])[1] if close else None


def _lost(folders: list[Path]) -> tuple[NoVerdict, ...]:
    """Cases without a verdict by method and status, over all runs."""
    columns = ("layout", "scenario", "method", "method_name", "engine", "repetition", "status",
               "reason", "item_count")  # fmt: skip
    rows = pd.concat([load_results(folder, columns) for folder in folders], ignore_index=True)
    titles = {
        spec: key.title for folder in folders for spec, key in load_judged(folder).keys.items()
    }
    rows = rows[(rows["status"] != str(Status.DONE)) & (rows["repetition"] == 0)]
    return tuple(
        NoVerdict(
            titles[str(spec)], str(status), len(own), int(own["item_count"].min()),
            int(own["item_count"].max()), str(own.loc[own["item_count"].idxmax(), "reason"]),
        )
        for (spec, status), own in rows.groupby(["method", "status"], sort=False)
    )  # fmt: skip

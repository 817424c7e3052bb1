"""Accuracy and cost of methods on cases with about as many boxes."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise
from operator import attrgetter

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from steadyload.layouts.model.question import Question
from steadyload.methods.contract.method import Status
from steadyload.methods.naming import MethodKey
from steadyload.reports.columns import column, counts, general, percent, row
from steadyload.runs.able import asked_question
from steadyload.runs.accuracy import accuracy_of
from steadyload.runs.evaluation import evaluate
from steadyload.runs.judged import JudgedCases
from steadyload.statistics.estimate import NOTHING, Estimate
from steadyload.statistics.metrics import share
from steadyload.studies.real.costing import Growth, JudgingCost, cost_of, growth_of, statuses

CONSTANT = MethodKey('the constant "stable"', "", "constant")
"""Stands for the verdict that every layout is stable."""

BoolArray = NDArray[np.bool_]


@row
class Accuracy:
    """Accuracy by the labels of one question.

    A refused case is left out; a case without a verdict for another reason counts as wrong.

    Attributes:
        overall: on all cases that have such a label.
        failing: on those whose label is a failing step.
        behind: accuracy minus that of the most accurate method, on the same cases, where refused
            cases count as wrong; None for that method itself, and where it is not asked for.
    """

    overall: Estimate = column("accuracy %", percent, default=NOTHING)
    failing: Estimate = column("failing: accuracy %", percent, default=NOTHING)
    behind: Estimate | None = column("behind the best", percent, default=None)


@row
class MethodResult:
    """Accuracy and cost of one method on a group of cases.

    Attributes:
        method: its name and spec.
        asked: the question that it is asked; None where it has no such parameter.
        within, stands: accuracy by the labels of either question.
        cost: of a judgement; None where all were refused or ended their process.
        without_verdict: cases without a verdict, by status.
        growth: of the CPU time; None where it is not asked for.
    """

    method: MethodKey = column(form=attrgetter("title"), left=True)
    asked: Question | None = column(left=True)
    within: Accuracy
    stands: Accuracy
    cost: JudgingCost | None = None
    without_verdict: Mapping[str, int] = column(
        "no verdict", counts, notable=True, default_factory=dict
    )
    growth: Growth | None = None

    @property
    def accuracy(self) -> Mapping[Question, Accuracy]:
        """By question."""
        return {Question.WITHIN: self.within, Question.STANDS: self.stands}


@row
class Bin:
    """Cases with about as many boxes.

    ``boxes``: their numbers in words. ``middle``: their median. ``within``, ``stands``: share of
    cases whose label is a failing step.
    """

    boxes: str = column(left=False)
    middle: float = column("median", general)
    cases: int = column()
    item_lists: int = column("item lists")
    within: Estimate = column("fails within %", percent)
    stands: Estimate = column("fails stands %", percent)

    def __str__(self) -> str:
        return self.boxes


@row
class SizeGroup:
    """Results on the cases of a bin, in the order of the study; the last is :data:`CONSTANT`."""

    bin: Bin
    methods: tuple[MethodResult, ...]

    def of(self, spec: str) -> MethodResult:
        """The result of a method."""
        return next(result for result in self.methods if result.method.spec == spec)


def bins(judged: JudgedCases, sizes: tuple[int, ...]) -> list[BoolArray]:
    """Masks of the cases of each bin that has any; what is larger than all is a last bin."""
    counts = _labels(judged)["item_count"].to_numpy(int)
    edges = pairwise((0, *sizes, np.inf))
    masks = [(counts > low) & (counts <= high) for low, high in edges]
    return [mask for mask in masks if mask.any()]


def _labels(judged: JudgedCases) -> pd.DataFrame:
    assert judged.labels is not None, "the runs are on labelled sets"
    return judged.labels


def size_group(
    judged: JudgedCases, timeout: float, *, whole: bool = False, small: JudgedCases | None = None
) -> SizeGroup:
    """The results of all methods on some cases.

    Args:
        judged: by all methods.
        timeout: CPU seconds a judgement may take.
        whole: whether methods are compared with the most accurate one, and the growth of their
            cost is looked at, too.
        small: further cases for that growth.
    """
    boxes = _labels(judged)["item_count"].to_numpy(int)
    within, stands = (_by_question(judged.asked(q), compared=whole) for q in Question)
    methods = [
        MethodResult(
            method=key,
            asked=asked_question(spec),
            within=within[1][spec],
            stands=stands[1][spec],
            cost=cost_of(judged, spec, timeout),
            without_verdict=_without_verdict(statuses(judged, spec)),
            growth=growth_of(spec, judged, small) if whole else None,
        )
        for spec, key in judged.keys.items()
    ]
    constant = MethodResult(CONSTANT, None, within[1][CONSTANT.spec], stands[1][CONSTANT.spec])
    return SizeGroup(
        Bin(
            boxes=" to ".join(map(str, dict.fromkeys((boxes.min(), boxes.max())))),
            middle=float(np.median(boxes)),
            cases=len(boxes),
            item_lists=_labels(judged)["instance"].nunique(),
            within=within[0],
            stands=stands[0],
        ),
        (*methods, constant),
    )


def _by_question(judged: JudgedCases, *, compared: bool) -> tuple[Estimate, dict[str, Accuracy]]:
    """Share of failing cases with a label of one question, and accuracies by spec."""
    labels = _labels(judged)
    table = evaluate(judged, by_scenario=False).methods if compared and len(judged.said) else ()
    behind = {own.method.spec: own.behind for own in table}
    found = {CONSTANT.spec: _accuracy(labels["item_count"], labels)}
    for spec in judged.keys:
        taken = (statuses(judged, spec) != str(Status.REFUSED)).to_numpy(bool)
        found[spec] = _accuracy(judged.said[spec][taken], labels[taken], behind.get(spec))
    return share(labels["failing_step"].notna(), judged.clusters), found


def _without_verdict(status: pd.Series) -> dict[str, int]:
    found = status.value_counts().sort_index()
    return {str(k): int(v) for k, v in found.items() if k != str(Status.DONE)}


def _accuracy(said: pd.Series, labels: pd.DataFrame, behind: Estimate | None = None) -> Accuracy:
    fails = labels["failing_step"].notna().to_numpy(bool)
    return Accuracy(accuracy_of(said, labels), accuracy_of(said[fails], labels[fails]), behind)

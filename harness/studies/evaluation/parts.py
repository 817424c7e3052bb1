"""Parts of the cases by number of boxes and by origin, and what the page answers for each."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from operator import itemgetter

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from steadyload.layouts.sizes import FEWER, SIZES, binned
from steadyload.methods.naming import MethodKey
from steadyload.reports.columns import column, milliseconds, percent, row, significant
from steadyload.runs.costs import limited_costs
from steadyload.runs.evaluation import Evaluation, LabelledPart, MethodEvaluation, evaluate
from steadyload.runs.judged import JudgedCases
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.metrics import share
from steadyload.studies.evaluation.costing import Cost, cost_in
from steadyload.studies.evaluation.delivered import CUSTOMERS, PACKERS, of_customers
from steadyload.studies.evaluation.error_places import CaseBin
from steadyload.studies.evaluation.rows import Result

CONSTANT = "the constant verdict *stable*"


@row
class SizeCost:
    """Cost of a method on layouts of one size; by origin, too."""

    method: MethodKey = column(form=lambda key: key.title, left=True)
    cost: Cost
    origins: Mapping[str, str] = column("{}", default_factory=dict)


@row
class OriginBin:
    """Cases of one origin in one bin of the number of boxes."""

    origin: str = column("cases")
    own: CaseBin


@row
class SizeAccuracy:
    """Accuracy of a method, or of the constant verdict, on cases of one origin by size."""

    method: str = column()
    sizes: Mapping[str, Estimate] = column("{}", percent)


NEAR = 0.01
"""Largest difference to the best accuracy at which a method counts as nearly as accurate."""


class OnLabelledCases(ABC):
    """Something with an evaluation on labelled cases."""

    evaluation: Evaluation

    @property
    @abstractmethod
    def results(self) -> Sequence[Result]:
        """The row of each method, on all of the cases."""

    @property
    def about(self) -> LabelledPart:
        """About the labels of the cases."""
        assert self.evaluation.labelled is not None, "the study is on a labelled set"
        return self.evaluation.labelled

    @property
    def best(self) -> MethodEvaluation:
        """The most accurate of the methods that are compared."""
        return self.evaluation.best

    def of(self, method: MethodKey) -> Result:
        """The row of a method."""
        return next(one for one in self.results if one.own.method == method)

    @property
    def leading(self) -> Result:
        """The row of the most accurate method."""
        return self.of(self.best.method)

    @property
    def near_best(self) -> Result | None:
        """The cheapest method, by the median, that is nearly as accurate as the best."""
        least = self.best.accuracy.value - NEAR
        among = [self.of(one.method) for one in self.evaluation.comparable]
        medians = [
            (one.cost.median, one) for one in among if one.cost and one.own.accuracy.value >= least
        ]
        return min(medians, key=itemgetter(0))[1] if medians else None


@dataclass(frozen=True)
class CasePart(OnLabelledCases):
    """Some of the cases, judged with a time limit.

    Attributes:
        name: their origin, or the numbers of their boxes.
        evaluation: of the methods on them alone.
        stable: share of cases whose label is that they stand, on which the constant verdict
            *stable* is right.
        sizes: by number of boxes; empty for parts by size.
    """

    name: str
    evaluation: Evaluation
    stable: Estimate = column("stable by the label %", percent)
    sizes: Sequence[CaseBin] = ()

    @cached_property
    def results(self) -> Sequence[Result]:
        """One row per method."""
        failing = failing_accuracy(self.evaluation)
        return [
            Result(one, None, None, None, failing=failing.get(one.method.spec),
                   cost=cost_in(self.evaluation, one.method.spec))
            for one in self.evaluation.methods
        ]  # fmt: skip

    @property
    def accuracies(self) -> Sequence[SizeAccuracy]:
        """Accuracy of every method by number of boxes, and that of the constant verdict."""
        titles = {one.method.spec: one.method.title for one in self.evaluation.methods}
        named = {f"{bin_.name} (n {bin_.cases})": bin_ for bin_ in self.sizes}
        return [
            *(
                SizeAccuracy(title, {name: own.accuracy[spec] for name, own in named.items()})
                for spec, title in titles.items()
            ),
            SizeAccuracy(CONSTANT, {name: own.stable for name, own in named.items()}),
        ]


def failing_accuracy(evaluation: Evaluation) -> Mapping[str, Estimate]:
    """By spec, accuracy on cases whose label is a failing step; empty where there is none."""
    labels = evaluation.judged.labels
    assert labels is not None, "the study is on a labelled set"
    fails = labels["failing_step"].notna().to_numpy(bool)
    parts = [part for part in evaluation.slices(fails) if part.name]
    return {key.spec: own for part in parts for key, own in part.accuracy.items()}


def by_size(judged: JudgedCases, timeout: float) -> tuple[CasePart, ...]:
    """The cases by the sizes that the page answers for.

    Args:
        judged: by all methods, with labels of a question.
        timeout: CPU time that a judgement may take [s].
    """
    assert judged.labels is not None, "the study is on a labelled set"
    place, names = binned(judged.labels["item_count"], (FEWER, *SIZES))
    return tuple(
        case_part(judged.only(place == number), name, timeout) for number, name in names.items()
    )


def by_origin(
    judged: JudgedCases,
    layouts: pd.DataFrame,
    timeout: float,
    sizes: Mapping[str, Sequence[CaseBin]],
) -> tuple[CasePart, ...]:
    """Customers' pallets and plans of packers; empty where no customer's pallet is.

    Arguments as :func:`by_size`, and the layouts of the labelled set, with their sources, and by
    origin the cases by number of boxes.
    """
    return tuple(
        case_part(judged.only(here), name, timeout, sizes=sizes[name])
        for name, here in origin_masks(judged, layouts).items()
    )


def origin_masks(judged: JudgedCases, layouts: pd.DataFrame) -> dict[str, NDArray[np.bool_]]:
    """Masks of the cases by origin, of those that there are; empty without customers' pallets."""
    theirs = of_customers(judged.said.index, layouts)
    found = {CUSTOMERS: theirs, PACKERS: ~theirs} if theirs.any() else {}
    return {name: here for name, here in found.items() if here.any()}


def case_part(
    judged: JudgedCases,
    name: str,
    timeout: float,
    *,
    sizes: Sequence[CaseBin] = (),
) -> CasePart:
    """Some of the cases, evaluated by themselves."""
    assert judged.labels is not None, "the study is on a labelled set"
    evaluation = evaluate(judged, costs=limited_costs(judged.results, timeout), by_scenario=False)
    stable = share(judged.labels["failing_step"].isna(), judged.clusters)
    return CasePart(name, evaluation, stable, sizes)


def size_costs(
    sizes: Sequence[CaseBin], origins: Sequence[CasePart], keys: Mapping[str, MethodKey]
) -> Mapping[str, Sequence[SizeCost]]:
    """By the name of a bin of the number of boxes, what every method costs; empty without costs."""
    found = {}
    for bin_ in sizes:
        theirs = {part.name: b for part in origins for b in part.sizes if b.name == bin_.name}
        rows = [
            SizeCost(key, cost, _by_origin(theirs, spec))
            for spec, key in keys.items()
            if (cost := bin_.costs.get(spec))
        ]
        if rows:
            found[bin_.name] = rows
    return found


def _by_origin(theirs: Mapping[str, CaseBin], spec: str) -> dict[str, str]:
    return {
        f"{name}, {what}": text
        for name, bin_ in theirs.items()
        if (cost := bin_.costs.get(spec))
        for what, text in (
            ("mean ms", milliseconds(cost.mean)),
            ("median ms", significant(cost.median)),
            ("90 % ms", significant(cost.ninety)),
        )
    }

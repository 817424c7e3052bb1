"""Fitting of accept and reject thresholds: the cheapest cascade within an error budget.

The budget is a share of cases that the stages before the last method may lose, and it applies to
an upper confidence bound of that share, not to the counted share. The bound is that of Clopper and
Pearson, at the effective sample size: layouts packed from one item list are alike, and where one is
lost others are, too. The effective sample size is estimated from a ladder that loses many cases;
the few losses within a budget are not enough to estimate it.

Costs are weighed by size: the cost of a ladder is its share of the cost of the last method alone,
averaged over classes of sizes. So small loads, which are many, and large ones, whose steps cost far
more, count alike. A stage whose cost grows faster than what it saves is kept for steps with few
items, where it pays, and one that pays on large loads alone for the steps with many.

Thresholds may depend on the number of items at a step. One budget holds for all sizes together: a
loss is allowed where it saves most. A class of sizes has thresholds of its own where it has enough
failing steps, see
:func:`steadyload.tuning.cascade.sizes.threshold_classes`; they are no wider than those of the next
smaller class.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from typing import NamedTuple, TypeAlias

import numpy as np
from scipy.stats import beta

from steadyload.methods.cascade.thresholds import Stage
from steadyload.statistics.metrics import effective_size
from steadyload.tuning import TuningError
from steadyload.tuning.cascade.defaults import SIZES
from steadyload.tuning.cascade.evaluation import CascadeEvaluation, evaluate
from steadyload.tuning.cascade.sizes import size_weights, threshold_classes
from steadyload.tuning.cascade.stages import Rung, Share, best_stage, rung_of
from steadyload.tuning.cascade.step_scores import BoolArray, Table

_MANY = 0.05
"""Share of lost cases at which the effective sample size is estimated."""

_PARTS = 4
"""Allowed losses are shared among stages in so many parts, where they are more."""

_REFINED = 6
"""Choices of candidates, the cheapest ones, for which thresholds by size are tried."""


_Shares: TypeAlias = tuple[Share, ...]
"""The same of all stages."""


@dataclass(frozen=True)
class Fit:
    """A ladder that was fitted.

    Attributes:
        stages: those that save more than they cost, with their thresholds.
        last: spec of the method that decides the rest.
        evaluation: on the cases that it was fitted on.
        most: lost cases that the budget allows there.
        independent: effective sample size.
        by_size: thresholds by number of items were tried.
    """

    stages: tuple[Stage, ...]
    last: str
    evaluation: CascadeEvaluation
    most: int
    independent: float
    by_size: bool = True

    def bound(self, confidence: float) -> float:
        """Upper confidence bound of the share of lost cases."""
        lost = self.evaluation.lost
        return upper_bound(int(lost.sum()), len(lost), self.independent, confidence)


def upper_bound(lost: int, cases: int, independent: float, confidence: float) -> float:
    """Upper confidence bound of a share: one-sided Clopper-Pearson bound.

    Args:
        lost: counted.
        cases: of so many.
        independent: effective sample size.
        confidence: above 0, below 1.
    """
    hits = lost * independent / cases
    if hits >= independent:
        return 1.0
    return float(beta.ppf(confidence, hits + 1.0, independent - hits))


def allowed_losses(budget: float, cases: int, independent: float, confidence: float) -> int:
    """The most lost cases whose bound keeps within a budget [share]; -1 if that of 0 does not."""
    found = -1
    while found < cases and upper_bound(found + 1, cases, independent, confidence) <= budget:
        found += 1
    return found


def independent_cases(table: Table, candidates: Sequence[str], last: str) -> float:
    """Effective sample size of the losses in a table.

    Args:
        table: step scores of all that follow.
        candidates: specs of methods that may become stages.
        last: spec of the method that decides the rest.
    """
    rungs = [Rung(spec) for spec in candidates]
    lost = _cheapest(table, _choices(rungs), last, math.ceil(_MANY * len(table.lists)))[1].lost
    return effective_size(lost, table.lists) if lost.any() else float(len(lost))


def fit(
    table: Table,
    candidates: Sequence[str],
    last: str,
    *,
    budget: float,
    confidence: float,
    independent: float,
    by_size: bool = True,
) -> Fit:
    """The cheapest ladder within a budget.

    Every choice of candidates is tried, in their order, and ways of sharing the allowed losses
    among them; a stage's thresholds are as wide as its share allows. Each choice is then tried with
    stages that score steps of few items alone, or of many, as long as that makes it cheaper. The
    cheapest choices are tried with thresholds by size: at first all thresholds lose no case, and
    then allowed losses go to the stage and the class of sizes where they save most.

    Args:
        table: step scores of all of them.
        candidates: specs of methods that may become stages.
        last: spec of the method that decides the rest, and that losses are counted against.
        budget: share of cases that may be lost.
        confidence: of the bound that has to keep within it.
        independent: see :func:`independent_cases`.
        by_size: thresholds may depend on the number of items at a step.

    Raises:
        TuningError: the cases are too few for the budget at this confidence.
    """
    cases = len(table.lists)
    most = allowed_losses(budget, cases, independent, confidence)
    if most < 0:
        least = 100.0 * upper_bound(0, cases, independent, confidence)
        raise TuningError(
            f"error budget is {100 * budget:g} points; allowed: {least:.2f} or more: {cases} cases "
            f"of {len(set(table.lists))} item lists tell as much as {independent:.0f} independent "
            f"ones, and a share of which they show none is below {least:.2f} % with confidence "
            f"{confidence:g}; or add sets of other item lists"
        )
    rungs = [Rung(spec) for spec in candidates]
    stages, found = _cheapest(table, _choices(rungs), last, most, limits=SIZES, by_size=by_size)
    return Fit(stages, last, found, most, independent, by_size)


class _Tried(NamedTuple):
    """A ladder that was tried: its cost, losses and length, and what it was made of."""

    worth: tuple[float, int, int]
    stages: tuple[Stage, ...]
    evaluation: CascadeEvaluation
    rungs: tuple[Rung, ...]
    shares: _Shares


class _Search:
    """Ladders of a table, and what each is worth.

    Args:
        table: step scores.
        last: spec of the method that decides the rest.
    """

    def __init__(self, table: Table, last: str) -> None:
        self._table, self._last = table, last
        self._weights = size_weights(table, last)
        self._best_stage = cache(self._fitted_stage)

    def _fitted_stage(
        self, before: tuple[Stage, ...], rung: Rung, begins: tuple[int, ...], share: Share
    ) -> Stage:
        return best_stage(self._table, before, rung, self._last, begins, share, self._weights)

    def tried(
        self, rungs: tuple[Rung, ...], shares: _Shares, begins: tuple[int, ...] = (0,)
    ) -> _Tried:
        """The ladder of these stages, without those that decide nothing.

        Args:
            rungs: its stages, in order.
            shares: lost cases that each may lose in each class of sizes.
            begins: the numbers of items above which a class begins, the first one 0.
        """
        stages: tuple[Stage, ...] = ()
        for rung, share in zip(rungs, shares, strict=True):
            stage = self._best_stage(stages, rung, begins, share)
            if any((each.low, each.high) != (None, None) for each in stage.ranges):
                stages = (*stages, stage)
        found = evaluate(self._table, stages, self._last)
        worth = float(self._weights @ found.cost), int(found.lost.sum()), len(stages)
        return _Tried(worth, stages, found, rungs, shares)

    def restricted(
        self, best: _Tried, limits: Sequence[int], begins: tuple[int, ...] = (0,)
    ) -> _Tried:
        """The ladder with stages of few items, or of many, where that is cheaper, one by one."""
        better = True
        while better:
            better = False
            for k in range(len(best.rungs)):
                for rung in _moved(best.rungs[k], limits):
                    rungs = (*best.rungs[:k], rung, *best.rungs[k + 1 :])
                    found = self.tried(rungs, best.shares, begins)
                    if found.worth < best.worth:
                        best, better = found, True
        return best

    def by_size(
        self, uniform: _Tried, most: int, limits: Sequence[int], begins: tuple[int, ...]
    ) -> _Tried:
        """The ladder with thresholds by size where that is cheaper, else as it is."""
        best = self.tried(uniform.rungs, ((0,) * len(begins),) * len(uniform.rungs), begins)
        left = most
        while left:
            part = math.ceil(left / _PARTS)
            raised = _raised(best.shares, part)
            more = [self.tried(best.rungs, shares, begins) for shares in raised]
            next_ = min(more, key=lambda each: each.worth, default=best)
            if next_.worth[0] >= best.worth[0]:
                break
            best, left = next_, left - part
        best = self.restricted(best, limits, begins)
        return best if best.worth < uniform.worth else uniform


def _moved(rung: Rung, limits: Sequence[int]) -> Iterator[Rung]:
    """The stage with another limit of the numbers of items of the steps that it scores."""
    if not limits:
        return
    for items in (*limits, None):
        if items != rung.items and (items is None or items > rung.above):
            yield rung._replace(items=items)
    for above in (0, *limits):
        if above != rung.above and (rung.items is None or above < rung.items):
            yield rung._replace(above=above)


def _raised(shares: _Shares, part: int) -> Iterator[_Shares]:
    """The shares with so many more losses in one class of one stage."""
    for k, c in itertools.product(range(len(shares)), range(len(shares[0]) if shares else 0)):
        own = (*shares[k][:c], shares[k][c] + part, *shares[k][c + 1 :])
        yield (*shares[:k], own, *shares[k + 1 :])


def _cheapest(
    table: Table,
    choices: Iterable[tuple[Rung, ...]],
    last: str,
    most: int,
    *,
    limits: Sequence[int] = (),
    by_size: bool = False,
) -> tuple[tuple[Stage, ...], CascadeEvaluation]:
    """The cheapest ladder among those that lose so many cases at most.

    Args:
        table: step scores.
        choices: what may become the stages, in order.
        last: spec of the method that decides the rest.
        most: lost cases.
        limits: numbers of items that a stage may be restricted to, or to more.
        by_size: thresholds may depend on the number of items at a step.
    """
    search, found = _Search(table, last), []
    for chosen in choices:
        shared = (tuple((each,) for each in shares) for shares in _shared(most, len(chosen)))
        of_choice = (search.tried(chosen, shares) for shares in shared)
        own = min(of_choice, key=lambda each: each.worth)
        found.append(search.restricted(own, limits))
    found.sort(key=lambda each: each.worth)
    begins = threshold_classes(table, last) if by_size else (0,)
    if len(begins) > 1:
        refined = [search.by_size(each, most, limits, begins) for each in found[:_REFINED]]
        found = sorted((*refined, *found), key=lambda each: each.worth)
    return found[0].stages, found[0].evaluation


def _choices(rungs: Sequence[Rung]) -> Iterator[tuple[Rung, ...]]:
    for count in range(len(rungs) + 1):
        yield from itertools.combinations(rungs, count)


def _shared(most: int, stages: int) -> Iterator[tuple[int, ...]]:
    if not stages:
        yield ()
        return
    parts = min(most, _PARTS)
    for cuts in itertools.combinations_with_replacement(range(parts + 1), stages - 1):
        edges = (0, *cuts, parts)
        counts = [most * edge // max(parts, 1) for edge in edges]
        yield tuple(b - a for a, b in itertools.pairwise(counts))


@dataclass(frozen=True)
class LeftOut:
    """Cases of item lists that thresholds were fitted without.

    Attributes:
        lost: cases lost, (M,).
        judged: cases that count: the budget can be kept to without their item list, (M,).
        unstable: cases that are said to fail, (M,).
    """

    lost: BoolArray
    judged: BoolArray
    unstable: BoolArray


def left_out(table: Table, fitted: Fit, *, budget: float, confidence: float) -> LeftOut:
    """Cases lost where every item list is judged by thresholds fitted without it.

    The stages and the steps that they score are those that were found. Classes of sizes with
    thresholds of their own, and the losses allowed in each, are chosen anew without the list.
    """
    chosen = tuple(rung_of(stage) for stage in fitted.stages)
    lost, judged, unstable = (np.zeros(len(table.lists), dtype=bool) for _ in range(3))
    for name in sorted(set(table.lists)):
        inside = table.lists == name
        others = table.chosen(~inside)
        independent = fitted.independent * len(others.lists) / len(table.lists)
        most = allowed_losses(budget, len(others.lists), independent, confidence)
        if most < 0:
            continue
        stages, _ = _cheapest(others, [chosen], fitted.last, most, by_size=fitted.by_size)
        own = table.chosen(inside)
        found = evaluate(own, stages, fitted.last)
        lost[inside], judged[inside] = found.lost, True
        unstable[inside] = np.bincount(own.of, found.unstable, len(own.lists)) > 0
    return LeftOut(lost, judged, unstable)

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
failing steps, see :func:`threshold_classes`.
"""

from __future__ import annotations

import itertools
import math
from bisect import bisect_right
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from typing import NamedTuple, TypeAlias

import numpy as np
from scipy.stats import beta

from steadyload.methods.cascade.thresholds import Larger, Stage
from steadyload.statistics.metrics import effective_size
from steadyload.tuning import TuningError
from steadyload.tuning.cascade.defaults import SIZES
from steadyload.tuning.cascade.evaluation import CascadeEvaluation, evaluate
from steadyload.tuning.cascade.step_scores import BoolArray, FloatArray, Indices, Table

_MANY = 0.05
"""Share of lost cases at which the effective sample size is estimated."""

_PARTS = 4
"""Allowed losses are shared among stages in so many parts, where they are more."""

_FEWEST = 20
"""Cases of a class of sizes at least; fewer count among those of the next smaller class."""

_FAILING = 20
"""Failing steps at least of a class of sizes with thresholds of its own. Of thresholds that lose
none of N failing steps, the next one is lost with a probability of 1 / (N + 1) at most, since it is
the lowest of N + 1 no more often: below 5 %."""

_LISTS = 10
"""Item lists at least that these are of: likewise, if steps of a list were alike, below 10 %."""

_REFINED = 6
"""Choices of candidates, the cheapest ones, for which thresholds by size are tried."""


_LEAST = 1e-9
"""Of a cost that is divided by [ms]."""


_Pair: TypeAlias = tuple[float | None, float | None]
"""An accept and a reject threshold; see ``Stage``."""

_NOTHING: _Pair = (None, None)

_Share: TypeAlias = tuple[int, ...]
"""Lost cases that a stage may lose in each class of sizes."""

_Shares: TypeAlias = tuple[_Share, ...]
"""The same of all stages."""


class _Rung(NamedTuple):
    """A stage without thresholds yet: its method, and the numbers of items of the steps that it
    scores: more than ``above``, and ``items`` at most (see ``Stage``).
    """

    method: str
    items: int | None = None
    above: int = 0

    def scores(self, table: Table) -> BoolArray:
        """The steps that it scores, (N,)."""
        scored = table.places >= self.above
        return scored if self.items is None else scored & (table.places < self.items)


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
    rungs = [_Rung(spec) for spec in candidates]
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
    rungs = [_Rung(spec) for spec in candidates]
    stages, found = _cheapest(table, _choices(rungs), last, most, limits=SIZES, by_size=by_size)
    return Fit(stages, last, found, most, independent, by_size)


def size_classes(boxes: Indices) -> Indices:
    """The class of sizes of every case, (M,): 0 for the smallest that hold enough cases."""
    place = np.searchsorted(SIZES, boxes)
    counts = np.bincount(place, minlength=len(SIZES) + 1)
    number, gathered, new = 0, 0, np.zeros(len(counts), dtype=np.intp)
    for k, count in enumerate(counts.tolist()):
        if gathered >= _FEWEST and counts[k:].sum() >= _FEWEST:
            number, gathered = number + 1, 0
        new[k], gathered = number, gathered + count
    return new[place]


def threshold_classes(table: Table, last: str) -> tuple[int, ...]:
    """The numbers of items above which a class of sizes begins that may have thresholds of its own.

    The first is 0. A class has failing steps enough (see above), of which the last method alone is
    right; one that has fewer has the thresholds of the next smaller one. Classes count by the
    number of items at a step, not by that of the case.
    """
    evident = table.fails & evaluate(table, (), last).alone[table.of]
    items, lists = table.places[evident] + 1, table.lists[table.of[evident]]

    def enough(above: int, to: float) -> bool:
        own = (items > above) & (items <= to)
        return own.sum() >= _FAILING and len(set(lists[own])) >= _LISTS

    begins, end = [0], math.inf
    for size in reversed(SIZES):
        if enough(size, end) and enough(0, size):
            begins.insert(1, size)
            end = size
    return tuple(begins)


def size_weights(table: Table, last: str) -> FloatArray:
    """The weight of the CPU time of every case [1/ms], (M,).

    A cost is the sum of weighted CPU times: the share of the cost of the last method alone, in the
    mean over classes of sizes.
    """
    classes = size_classes(table.boxes)
    alone = np.bincount(classes, evaluate(table, (), last).cost)
    return np.asarray(1.0 / (len(alone) * np.maximum(alone, _LEAST))[classes])


class _Tried(NamedTuple):
    """A ladder that was tried: its cost, losses and length, and what it was made of."""

    worth: tuple[float, int, int]
    stages: tuple[Stage, ...]
    evaluation: CascadeEvaluation
    rungs: tuple[_Rung, ...]
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
        self, before: tuple[Stage, ...], rung: _Rung, begins: tuple[int, ...], share: _Share
    ) -> Stage:
        return _best_stage(self._table, before, rung, self._last, begins, share, self._weights)

    def tried(
        self, rungs: tuple[_Rung, ...], shares: _Shares, begins: tuple[int, ...] = (0,)
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
            if any((each.low, each.high) != _NOTHING for each in stage.ranges):
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


def _moved(rung: _Rung, limits: Sequence[int]) -> Iterator[_Rung]:
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
    choices: Iterable[tuple[_Rung, ...]],
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


def _choices(rungs: Sequence[_Rung]) -> Iterator[tuple[_Rung, ...]]:
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


def _best_stage(
    table: Table,
    before: tuple[Stage, ...],
    rung: _Rung,
    last: str,
    begins: tuple[int, ...],
    share: _Share,
    weights: FloatArray,
) -> Stage:
    """The stage that saves most with no more than the allowed losses of each class of sizes.

    Thresholds of a class are limited by all its steps, also by those that the stage does not score
    there: else a stage of few steps would have thresholds that few failing steps speak for. Only
    the first class ends where the stage does: its smallest steps are those with most evidence.
    """
    so_far = evaluate(table, before, last)
    open_ = (so_far.by == len(before)) & ~np.isnan(table.step_scores[rung.method].scores)
    scored = open_ & rung.scores(table)
    price = table.step_scores[last].cost * weights[table.of]
    found = []
    for begin, end, allowed in zip(begins, (*begins[1:], None), share, strict=True):
        own = _Rung(rung.method, end, begin).scores(table)
        evident = open_ & own & so_far.alone[table.of]
        if begin == 0 and rung.items is not None:
            evident &= table.places < rung.items
        found.append(_pair(table, rung.method, evident, scored & own, allowed, price))
    return _stage(rung, begins, found)


def _pair(
    table: Table,
    method: str,
    evident: BoolArray,
    scored: BoolArray,
    allowed: int,
    price: FloatArray,
) -> _Pair:
    """The accept and the reject threshold that save most with no more than the allowed losses.

    ``low`` never goes above the method's own decision threshold, nor ``high`` below it: without a
    case that limits it, there is no evidence for a wider threshold.

    Args:
        table: step scores.
        method: whose thresholds these are.
        evident: the steps that limit them: a wrong decision there would lose the case, (N,).
        scored: the steps that they may decide, (N,).
        allowed: lost cases.
        price: what a decided step saves, (N,).
    """
    step_scores = table.step_scores[method]
    threshold = step_scores.decision_threshold
    missed = np.sort(step_scores.scores[evident & table.fails])
    alarms = -np.sort(-_highest(table, evident & ~table.fails, step_scores.scores))
    scores, price = step_scores.scores[scored], price[scored]
    best = None
    for below in range(allowed + 1):
        above = allowed - below
        low = min(float(missed[below]), threshold) if below < len(missed) else threshold
        high = max(float(alarms[above]), threshold) if above < len(alarms) else threshold
        saved = float(price[(scores < low) | (scores > high)].sum())
        if best is None or saved > best[0]:
            best = saved, low, high
    assert best is not None
    _, low, high = best
    return low if (scores < low).any() else None, high if (scores > high).any() else None


def _stage(rung: _Rung, begins: tuple[int, ...], pairs: Sequence[_Pair]) -> Stage:
    """A stage of the accept and reject thresholds of every class, without ranges that are alike."""
    ranges: list[Larger] = []
    end = rung.items
    for edge in sorted({*begins, rung.above}):
        if end is not None and edge >= end:
            break
        pair = pairs[bisect_right(begins, edge) - 1] if edge >= rung.above else _NOTHING
        if not ranges or (ranges[-1].low, ranges[-1].high) != pair:
            ranges.append(Larger(edge, *pair))
    if len(ranges) > 1 and (ranges[-1].low, ranges[-1].high) == _NOTHING:
        end = ranges.pop().above
    first, *larger = ranges
    return Stage(rung.method, first.low, first.high, end, tuple(larger))


def _highest(table: Table, steps: BoolArray, scores: np.ndarray) -> np.ndarray:
    """The highest score of every case that has such a step."""
    highest = np.maximum.reduceat(np.where(steps, scores, -np.inf), table.starts)
    return highest[highest > -np.inf]


@dataclass(frozen=True)
class LeftOut:
    """Cases of item lists that thresholds were fitted without.

    Attributes:
        lost: cases lost, (M,).
        judged: cases that count: the budget can be kept to without their item list, (M,).
    """

    lost: BoolArray
    judged: BoolArray


def left_out(table: Table, fitted: Fit, *, budget: float, confidence: float) -> LeftOut:
    """Cases lost where every item list is judged by thresholds fitted without it.

    The stages and the steps that they score are those that were found. Classes of sizes with
    thresholds of their own, and the losses allowed in each, are chosen anew without the list.
    """
    chosen = tuple(_rung(stage) for stage in fitted.stages)
    lost, judged = (np.zeros(len(table.lists), dtype=bool) for _ in range(2))
    for name in sorted(set(table.lists)):
        inside = table.lists == name
        others = table.chosen(~inside)
        independent = fitted.independent * len(others.lists) / len(table.lists)
        most = allowed_losses(budget, len(others.lists), independent, confidence)
        if most < 0:
            continue
        stages, _ = _cheapest(others, [chosen], fitted.last, most, by_size=fitted.by_size)
        found = evaluate(table.chosen(inside), stages, fitted.last)
        lost[inside], judged[inside] = found.lost, True
    return LeftOut(lost, judged)


def _rung(stage: Stage) -> _Rung:
    """The method of a stage, and the steps that it scores."""
    scored = (each.above for each in stage.ranges if (each.low, each.high) != _NOTHING)
    return _Rung(stage.method, stage.items, next(scored, 0))

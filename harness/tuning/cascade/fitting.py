"""Fitting of accept and reject thresholds: the cheapest cascade within an error budget.

The budget is a share of cases that the stages before the last method may lose, and it applies to
an upper confidence bound of that share, not to the counted share. The bound is that of Clopper and
Pearson, at the effective sample size: layouts packed from one item list are alike, and where one is
lost others are, too. The effective sample size is estimated from a ladder that loses many cases;
the few losses within a budget are not enough to estimate it.

Costs are weighed by size: the cost of a ladder is its share of the cost of the last method alone,
averaged over classes of sizes. So small loads, which are many, and large ones, whose steps cost far
more, count alike. A stage whose cost grows faster than what it saves is kept for steps with few
items, where it pays.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from typing import NamedTuple

import numpy as np
from scipy.stats import beta

from steadyload.methods.cascade.thresholds import Stage
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


_LEAST = 1e-9
"""Of a cost that is divided by [ms]."""


class _Rung(NamedTuple):
    """A stage without thresholds yet: its method, and how many items it scores (see ``Stage``)."""

    method: str
    items: int | None = None


@dataclass(frozen=True)
class Fit:
    """A ladder that was fitted.

    Attributes:
        stages: those that save more than they cost, with their thresholds.
        last: spec of the method that decides the rest.
        evaluation: on the cases that it was fitted on.
        most: lost cases that the budget allows there.
        independent: effective sample size.
    """

    stages: tuple[Stage, ...]
    last: str
    evaluation: CascadeEvaluation
    most: int
    independent: float

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
    lost = _cheapest(table, rungs, last, math.ceil(_MANY * len(table.lists)))[1].lost
    return effective_size(lost, table.lists) if lost.any() else float(len(lost))


def fit(
    table: Table,
    candidates: Sequence[str],
    last: str,
    *,
    budget: float,
    confidence: float,
    independent: float,
) -> Fit:
    """The cheapest ladder within a budget.

    Every choice of candidates is tried, in their order, and ways of sharing the allowed losses
    among them; a stage's thresholds are as wide as its share allows. Each choice is then tried with
    stages that score steps of few items alone, as long as that makes it cheaper.

    Args:
        table: step scores of all of them.
        candidates: specs of methods that may become stages.
        last: spec of the method that decides the rest, and that losses are counted against.
        budget: share of cases that may be lost.
        confidence: of the bound that has to keep within it.
        independent: see :func:`independent_cases`.

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
    stages, found = _cheapest(table, rungs, last, most, limits=SIZES)
    return Fit(stages, last, found, most, independent)


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


def size_weights(table: Table, last: str) -> FloatArray:
    """The weight of the CPU time of every case [1/ms], (M,).

    A cost is the sum of weighted CPU times: the share of the cost of the last method alone, in the
    mean over classes of sizes.
    """
    classes = size_classes(table.boxes)
    alone = np.bincount(classes, evaluate(table, (), last).cost)
    return np.asarray(1.0 / (len(alone) * np.maximum(alone, _LEAST))[classes])


def _cheapest(
    table: Table, rungs: Sequence[_Rung], last: str, most: int, limits: Sequence[int] = ()
) -> tuple[tuple[Stage, ...], CascadeEvaluation]:
    """The cheapest ladder among those that lose so many cases at most.

    Args:
        table: step scores.
        rungs: what may become a stage, in order.
        last: spec of the method that decides the rest.
        most: lost cases.
        limits: numbers of items that a stage may be restricted to.
    """
    weights = size_weights(table, last)

    @cache
    def best_stage(before: tuple[Stage, ...], rung: _Rung, allowed: int) -> Stage:
        return _best_stage(table, before, rung, last, allowed, weights)

    def tried(chosen: tuple[_Rung, ...], shares: tuple[int, ...]) -> _Tried | None:
        stages: tuple[Stage, ...] = ()
        for rung, share in zip(chosen, shares, strict=True):
            stages = (*stages, best_stage(stages, rung, share))
            if stages[-1].low is None and stages[-1].high is None:
                return None  # it decides nothing: the choice without it is cheaper
        found = evaluate(table, stages, last)
        worth = float(weights @ found.cost), int(found.lost.sum()), len(stages)
        return _Tried(worth, stages, found, chosen, shares)

    best: _Tried | None = None
    for chosen in _choices(rungs):
        of_choice = [t for shares in _shared(most, len(chosen)) if (t := tried(chosen, shares))]
        if not of_choice:
            continue
        own = min(of_choice, key=lambda each: each.worth)
        own = _restricted(own, limits, tried)
        if best is None or own.worth < best.worth:
            best = own
    assert best is not None, "no stage at all is one of the choices"
    return best.stages, best.evaluation


class _Tried(NamedTuple):
    """A ladder that was tried: its cost, losses and length, and what it was made of."""

    worth: tuple[float, int, int]
    stages: tuple[Stage, ...]
    evaluation: CascadeEvaluation
    rungs: tuple[_Rung, ...]
    shares: tuple[int, ...]


def _restricted(
    best: _Tried,
    limits: Sequence[int],
    tried: Callable[[tuple[_Rung, ...], tuple[int, ...]], _Tried | None],
) -> _Tried:
    """The ladder with its stages restricted to few items where that is cheaper, one by one."""
    better = True
    while better:
        better = False
        for k, items in itertools.product(range(len(best.rungs)), (*limits, None)):
            rungs = (*best.rungs[:k], best.rungs[k]._replace(items=items), *best.rungs[k + 1 :])
            found = tried(rungs, best.shares)
            if found is not None and found.worth < best.worth:
                best, better = found, True
    return best


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
    allowed: int,
    weights: FloatArray,
) -> Stage:
    """The stage that saves most with no more than the allowed losses.

    ``low`` never goes above the method's own decision threshold, nor ``high`` below it: without a
    case that limits it, there is no evidence for a wider threshold.
    """
    step_scores = table.step_scores[rung.method]
    threshold = step_scores.decision_threshold
    so_far = evaluate(table, before, last)
    open_ = (so_far.by == len(before)) & ~np.isnan(step_scores.scores)
    if rung.items is not None:
        open_ &= table.places < rung.items
    at_stake = open_ & so_far.alone[table.of]
    missed = np.sort(step_scores.scores[at_stake & table.fails])
    alarms = -np.sort(-_highest(table, at_stake & ~table.fails, step_scores.scores))
    price = np.where(open_, table.step_scores[last].cost * weights[table.of], 0.0)
    best = None
    for below in range(allowed + 1):
        above = allowed - below
        low = min(float(missed[below]), threshold) if below < len(missed) else threshold
        high = max(float(alarms[above]), threshold) if above < len(alarms) else threshold
        with np.errstate(invalid="ignore"):
            saved = float(price[(step_scores.scores < low) | (step_scores.scores > high)].sum())
        if best is None or saved > best[0]:
            best = saved, low, high
    assert best is not None
    _, low, high = best
    scores = step_scores.scores[open_]
    return Stage(
        rung.method,
        low if (scores < low).any() else None,
        high if (scores > high).any() else None,
        rung.items,
    )


def _highest(table: Table, steps: BoolArray, scores: np.ndarray) -> np.ndarray:
    """The highest score of every case that has such a step."""
    highest = np.maximum.reduceat(np.where(steps, scores, -np.inf), table.starts)
    return highest[highest > -np.inf]


def left_out(table: Table, fitted: Fit, *, budget: float, confidence: float) -> tuple[int, int]:
    """Cases lost, and cases, where every item list is judged by thresholds fitted without it.

    The stages and the steps that they score are those that were found. Lists without which the
    budget cannot be kept to are left out of both numbers.
    """
    chosen = [_Rung(stage.method, stage.items) for stage in fitted.stages]
    lost = cases = 0
    for name in sorted(set(table.lists)):
        inside = table.lists == name
        others = table.chosen(~inside)
        independent = fitted.independent * len(others.lists) / len(table.lists)
        most = allowed_losses(budget, len(others.lists), independent, confidence)
        if most < 0:
            continue
        stages, _ = _cheapest(others, chosen, fitted.last, most)
        found = evaluate(table.chosen(inside), stages, fitted.last)
        lost, cases = lost + int(found.lost.sum()), cases + int(inside.sum())
    return lost, cases

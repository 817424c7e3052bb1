"""Fitting of accept and reject thresholds: the cheapest cascade within an error budget.

The budget is a share of cases that the stages before the last method may lose, and it applies to
an upper confidence bound of that share, not to the counted share. The bound is that of Clopper and
Pearson, at the effective sample size: layouts packed from one item list are alike, and where one is
lost others are, too. The effective sample size is estimated from a ladder that loses many cases;
the few losses within a budget are not enough to estimate it.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
from scipy.stats import beta

from steadyload.methods.cascade.thresholds import Stage
from steadyload.statistics.metrics import effective_size
from steadyload.tuning import TuningError
from steadyload.tuning.cascade.evaluation import CascadeEvaluation, evaluate
from steadyload.tuning.cascade.step_scores import BoolArray, Table

_MANY = 0.05
"""Share of lost cases at which the effective sample size is estimated."""

_PARTS = 4
"""Allowed losses are shared among stages in so many parts, where they are more."""


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
    lost = _cheapest(table, candidates, last, math.ceil(_MANY * len(table.lists)))[1].lost
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
    among them; a stage's thresholds are as wide as its share allows.

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
    stages, found = _cheapest(table, candidates, last, most)
    return Fit(stages, last, found, most, independent)


def _cheapest(
    table: Table, candidates: Sequence[str], last: str, most: int
) -> tuple[tuple[Stage, ...], CascadeEvaluation]:
    """The cheapest ladder among those that lose so many cases at most."""

    @cache
    def best_stage(before: tuple[Stage, ...], spec: str, allowed: int) -> Stage:
        return _best_stage(table, before, spec, last, allowed)

    best: tuple[tuple[float, int, int], tuple[Stage, ...], CascadeEvaluation] | None = None
    for chosen in _choices(candidates):
        for shares in _shared(most, len(chosen)):
            stages: tuple[Stage, ...] = ()
            for spec, share in zip(chosen, shares, strict=True):
                stages = (*stages, best_stage(stages, spec, share))
            if any(stage.low is None and stage.high is None for stage in stages):
                continue  # it decides nothing: the choice without it is cheaper
            found = evaluate(table, stages, last)
            worth = float(found.cost.mean()), int(found.lost.sum()), len(stages)
            if best is None or worth < best[0]:
                best = worth, stages, found
    assert best is not None, "no stage at all is one of the choices"
    return best[1:]


def _choices(candidates: Sequence[str]) -> Iterator[tuple[str, ...]]:
    for count in range(len(candidates) + 1):
        yield from itertools.combinations(candidates, count)


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
    table: Table, before: tuple[Stage, ...], spec: str, last: str, allowed: int
) -> Stage:
    """The stage that saves most with no more than the allowed losses.

    ``low`` never goes above the method's own decision threshold, nor ``high`` below it: without a
    case that limits it, there is no evidence for a wider threshold.
    """
    step_scores = table.step_scores[spec]
    threshold = step_scores.decision_threshold
    so_far = evaluate(table, before, last)
    open_ = (so_far.by == len(before)) & ~np.isnan(step_scores.scores)
    at_stake = open_ & so_far.alone[table.of]
    missed = np.sort(step_scores.scores[at_stake & table.fails])
    alarms = -np.sort(-_highest(table, at_stake & ~table.fails, step_scores.scores))
    price = np.where(open_, table.step_scores[last].cost, 0.0)
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
        spec, low if (scores < low).any() else None, high if (scores > high).any() else None
    )


def _highest(table: Table, steps: BoolArray, scores: np.ndarray) -> np.ndarray:
    """The highest score of every case that has such a step."""
    highest = np.maximum.reduceat(np.where(steps, scores, -np.inf), table.starts)
    return highest[highest > -np.inf]


def left_out(table: Table, fitted: Fit, *, budget: float, confidence: float) -> tuple[int, int]:
    """Cases lost, and cases, where every item list is judged by thresholds fitted without it.

    The stages are those that were found. Lists without which the budget cannot be kept to are left
    out of both numbers.
    """
    chosen = [stage.method for stage in fitted.stages]
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

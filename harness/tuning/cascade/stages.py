"""The accept and reject thresholds of one stage, after those before it."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from typing import NamedTuple, TypeAlias

import numpy as np

from steadyload.methods.cascade.thresholds import Larger, Stage
from steadyload.tuning.cascade.evaluation import evaluate
from steadyload.tuning.cascade.step_scores import BoolArray, FloatArray, Table

_Pair: TypeAlias = tuple[float | None, float | None]
"""An accept and a reject threshold; see ``Stage``."""

_NOTHING: _Pair = (None, None)

Share: TypeAlias = tuple[int, ...]
"""Lost cases that a stage may lose in each class of sizes."""


class Rung(NamedTuple):
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


def rung_of(stage: Stage) -> Rung:
    """The method of a stage, and the steps that it scores."""
    scored = (each.above for each in stage.ranges if (each.low, each.high) != _NOTHING)
    return Rung(stage.method, stage.items, next(scored, 0))


def best_stage(
    table: Table,
    before: tuple[Stage, ...],
    rung: Rung,
    last: str,
    begins: tuple[int, ...],
    share: Share,
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
    found: list[_Pair] = []
    for begin, end, allowed in zip(begins, (*begins[1:], None), share, strict=True):
        own = Rung(rung.method, end, begin).scores(table)
        evident = open_ & own & so_far.alone[table.of]
        if begin == 0 and rung.items is not None:
            evident &= table.places < rung.items
        pair = _pair(table, rung.method, evident, scored & own, allowed, price)
        if table.falls is not None:
            lost = open_ & own & table.falls[table.of] & _found(table, last)
            pair = _passing(table, rung.method, lost, pair)
        found.append(_no_wider(pair, found[-1]) if found else pair)
    return _stage(rung, begins, found)


def _found(table: Table, last: str) -> BoolArray:
    """The failing steps that the last method calls unstable, (N,)."""
    own = table.step_scores[last]
    return table.fails & (own.scores > own.decision_threshold)


def _passing(table: Table, method: str, falls: BoolArray, pair: _Pair) -> _Pair:
    """The accept threshold at which none of some failing steps is passed, and no other one."""
    low, scores = pair[0], table.step_scores[method].scores[falls]
    return low if low is None or not len(scores) else min(low, float(scores.min())), None


def _no_wider(pair: _Pair, smaller: _Pair) -> _Pair:
    """Thresholds that accept and reject no more than those of the next smaller class.

    Few failing steps speak for those of large loads. Where many of smaller ones speak against a
    score, it is not enough for a larger load either.
    """
    (low, high), (least, most) = pair, smaller
    return (
        low if low is None or least is None else min(low, least),
        high if high is None or most is None else max(high, most),
    )


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
    for below in range(allowed + 1) if table.falls is None else (allowed,):
        above = allowed - below
        low = min(float(missed[below]), threshold) if below < len(missed) else threshold
        high = max(float(alarms[above]), threshold) if above < len(alarms) else threshold
        saved = float(price[(scores < low) | (scores > high)].sum())
        if best is None or saved > best[0]:
            best = saved, low, high
    assert best is not None
    _, low, high = best
    return low if (scores < low).any() else None, high if (scores > high).any() else None


def _stage(rung: Rung, begins: tuple[int, ...], pairs: Sequence[_Pair]) -> Stage:
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

"""Evaluation of a cascade's stages on a table of step scores: verdicts, losses, cost."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from steadyload.methods.cascade.thresholds import Stage
from steadyload.tuning.cascade.step_scores import BoolArray, FloatArray, Indices, Table


@dataclass(frozen=True)
class CascadeEvaluation:
    """Decisions on N steps of M cases.

    A case is *lost* where the last method alone would be right and the ladder is wrong, *gained*
    the other way round.

    Attributes:
        by: the number of the stage that decided a step, that of stages for the last method, (N,).
        unstable: what was decided, (N,).
        asked: whether a step was reached: none that was called unstable came before it, (N,).
        right, alone: whether the ladder, and the last method alone, name the label's step, (M,).
        blamed: the stage that decided the first wrong step, -1 where there is none, (M,).
        cost: CPU time [ms], (M,).
    """

    by: Indices
    unstable: BoolArray
    asked: BoolArray
    right: BoolArray
    alone: BoolArray
    blamed: Indices
    cost: FloatArray

    @property
    def lost(self) -> BoolArray:
        """Cases that the stages before the last method lost, (M,)."""
        return self.alone & ~self.right

    @property
    def gained(self) -> BoolArray:
        """Cases that they gained, (M,)."""
        return self.right & ~self.alone


def evaluate(table: Table, stages: tuple[Stage, ...], last: str) -> CascadeEvaluation:
    """Evaluate stages, and a last method that decides the rest."""
    count = len(table.of)
    own_scores = table.step_scores[last]
    own = own_scores.scores > own_scores.decision_threshold
    by, unstable = np.full(count, len(stages)), own.copy()
    open_, scored = np.ones(count, dtype=bool), []
    for number, stage in enumerate(stages):
        scores = table.step_scores[stage.method].scores
        accept, reject = _thresholds(table, stage)
        with np.errstate(invalid="ignore"):
            low, high = scores < accept, scores > reject
        scored.append(~(np.isnan(accept) & np.isnan(reject)))
        sure = open_ & (low | high)
        by[sure], unstable[sure] = number, high[sure] & ~low[sure]
        open_ &= ~sure
    # Without a step score even of the last method there is no verdict, which is never right.
    none = np.isnan(own_scores.scores)
    right, asked, wrong = _read(table, unstable, none & open_)
    blamed = np.where(wrong < 0, -1, by[np.maximum(wrong, 0)])
    alone, *_ = _read(table, own, none)
    cost = _cost(table, stages, last, by, asked, [*scored, np.ones(count, dtype=bool)])
    return CascadeEvaluation(by, unstable, asked, right, alone, blamed, cost)


def _thresholds(table: Table, stage: Stage) -> tuple[FloatArray, FloatArray]:
    """Accept and reject thresholds of a stage at every step, not a number where there is none."""
    place = np.searchsorted([each.above for each in stage.larger], table.places, side="right")
    low, high = (
        np.array([math.nan if each is None else each for each in thresholds])[place]
        for thresholds in zip(*((each.low, each.high) for each in stage.ranges), strict=True)
    )
    if stage.items is not None:
        beyond = table.places >= stage.items
        low[beyond], high[beyond] = math.nan, math.nan
    return low, high


def _read(
    table: Table, unstable: BoolArray, none: BoolArray
) -> tuple[BoolArray, BoolArray, Indices]:
    """Correctness of the cases, the steps reached, and the first wrong step, -1 for none."""
    count, starts = len(table.of), table.starts
    place = np.arange(count)
    wrong = (unstable != table.fails) | none
    first_wrong = np.minimum.reduceat(np.where(wrong, place, count), starts)
    first_end = np.minimum.reduceat(np.where(unstable | none, place, count), starts)
    right = first_wrong == count
    return right, place <= first_end[table.of], np.where(right, -1, first_wrong)


def _cost(
    table: Table,
    stages: tuple[Stage, ...],
    last: str,
    by: Indices,
    asked: BoolArray,
    scored: list[BoolArray],
) -> FloatArray:
    cases = len(table.lists)
    total = np.zeros(cases)
    methods = (*(stage.method for stage in stages), last)
    for number, (method, own) in enumerate(zip(methods, scored, strict=True)):
        step_scores = table.step_scores[method]
        here = asked & (by >= number) & own
        spent = np.bincount(table.of, np.where(here, step_scores.cost, 0.0), cases)
        opened = np.bincount(table.of, here, cases) > 0
        total += spent + np.where(opened, step_scores.opening, 0.0)
    return total

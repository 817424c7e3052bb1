"""Evaluation of a cascade's stages on a table of step scores: verdicts, losses, cost."""

from __future__ import annotations

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
    open_ = np.ones(count, dtype=bool)
    for number, stage in enumerate(stages):
        scores = table.step_scores[stage.method].scores
        with np.errstate(invalid="ignore"):
            low = np.zeros(count, bool) if stage.low is None else scores < stage.low
            high = np.zeros(count, bool) if stage.high is None else scores > stage.high
        sure = open_ & (low | high) & _scored(table, stage)
        by[sure], unstable[sure] = number, high[sure] & ~low[sure]
        open_ &= ~sure
    # Without a step score even of the last method there is no verdict, which is never right.
    none = np.isnan(own_scores.scores)
    right, asked, wrong = _read(table, unstable, none & open_)
    blamed = np.where(wrong < 0, -1, by[np.maximum(wrong, 0)])
    alone, *_ = _read(table, own, none)
    cost = _cost(table, stages, last, by, asked)
    return CascadeEvaluation(by, unstable, asked, right, alone, blamed, cost)


def _scored(table: Table, stage: Stage) -> BoolArray:
    """The steps that a stage scores, whatever was decided before, (N,)."""
    if stage.items is None:
        return np.ones(len(table.of), dtype=bool)
    return np.asarray(table.places < stage.items)


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
    table: Table, stages: tuple[Stage, ...], last: str, by: Indices, asked: BoolArray
) -> FloatArray:
    cases = len(table.lists)
    total = np.zeros(cases)
    for number, stage in enumerate((*stages, Stage(last, None, None))):
        step_scores = table.step_scores[stage.method]
        here = asked & (by >= number) & _scored(table, stage)
        spent = np.bincount(table.of, np.where(here, step_scores.cost, 0.0), cases)
        opened = np.bincount(table.of, here, cases) > 0
        total += spent + np.where(opened, step_scores.opening, 0.0)
    return total

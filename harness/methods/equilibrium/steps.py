"""Scores of single steps by equilibrium, with or without a time."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from steadyload.core.constants import FAILS, STANDS, UNDECIDED
from steadyload.core.timed import Followed, Group, Moved
from steadyload.layouts.model.layout import Arrangement, Layout
from steadyload.methods.contract.method import Finding, StepScorer
from steadyload.statics.balance import VerticalBalance
from steadyload.statics.movement import Movement


class Balancing(Protocol):
    """A method whose steps are scored here: equilibrium."""

    parameters: Any

    def is_near_its_edge(self, layout: Arrangement, step: int) -> bool:
        """Whether an item on the floor has its centre of mass near the edge of its base."""

    def braced(self, layout: Arrangement, step: int, item: int) -> int | None:
        """The item that forces at sides do not balance either; None for none."""

    def farthest(self, layout: Arrangement, items: Sequence[int], step: int) -> Movement:
        """The item of a group that gets furthest within the time."""

    def moved(self, step: int, group: NDArray[np.int32], loading: Followed) -> Moved:
        """The motion of a group of a loading that is followed."""

    def beyond_work(self, step: int) -> Finding:
        """The finding at a step whose motion takes more work than is allowed."""


class BalancedSteps(StepScorer):
    """A step that balances scores 0. One that does not scores 1, or with time how far something
    gets, in units of its threshold. Where something placed before is out of balance, or sides are
    needed, a step that balances is no proof that nothing moves: 0.5, or with time no score.
    """

    def __init__(self, method: Balancing, layout: Layout) -> None:
        self._method, self._layout = method, layout
        self._balance = VerticalBalance(layout, method.parameters.margin)
        self._placed = 0
        self._disturbed = False
        self._timed = method.parameters.time is not None
        self._unsure = math.nan if self._timed else 0.5
        self.decision_threshold = 1.0 if self._timed else 0.5

    def step_score(self, step: int) -> float:
        """See :meth:`StepScorer.step_score`."""
        item, disturbed = None, self._disturbed
        try:
            for placed in range(self._placed, step + 1):
                disturbed = self._disturbed
                item = self._place(placed)
                if self._method.is_near_its_edge(self._layout, placed):
                    item = placed
                self._placed = placed + 1
                self._disturbed = disturbed or item is not None
            if item is None:
                return self._unsure if disturbed else 0.0
            if self._method.braced(self._layout, step, item) is None:
                return self._unsure
            if not self._timed:
                return 1.0
            return self._beyond(step)
        except RuntimeError:  # the solver's only way to say that it gave up
            return math.nan

    def _place(self, step: int) -> int | None:
        """Place an item; the one that is out of balance, None where all balance."""
        return self._balance.place(step)

    def _beyond(self, step: int) -> float:
        """How far something of the group of a step gets, in units of its threshold."""
        group = self._balance.group(step)
        return self._method.farthest(self._layout, group, step).beyond


class TimedSteps(BalancedSteps):
    """Steps whose motions are followed in C: the last one is kept as long as nothing of it
    changes, and a step whose motion takes more work than is allowed has no score.
    """

    def __init__(self, method: Balancing, layout: Layout, loading: Followed) -> None:
        super().__init__(method, layout)
        self._loading = loading
        self._ended = STANDS
        self._group = Group(STANDS, False, np.empty(0, dtype=np.int32))

    def _place(self, step: int) -> int | None:
        self._group = self._loading.group(step)
        self._ended = self._group.ended
        return super()._place(step)

    def _beyond(self, step: int) -> float:
        if self._ended == STANDS:  # but for rounding
            return 0.0
        if self._group.kept:
            return float(self._loading.beyond[self._group.items].max())
        if self._ended != FAILS:
            return math.nan
        moved = self._method.moved(step, self._group.items, self._loading)
        self._ended = moved.ended
        return moved.beyond if moved.ended == FAILS else math.nan

    def finding(self, step: int) -> Finding:
        """See :meth:`StepScorer.finding`."""
        if self._ended == UNDECIDED:
            return self._method.beyond_work(step)
        return super().finding(step)

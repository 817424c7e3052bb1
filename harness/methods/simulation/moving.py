"""Simulation of a placement among what moves: everything that balances is frozen until pushed."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from steadyload.core.constants import FAILS, UNRESOLVED
from steadyload.core.timed import Followed
from steadyload.engines.attitudes import rotate
from steadyload.layouts.model.layout import FloatArray, Layout
from steadyload.methods.contract.method import Finding
from steadyload.methods.simulation.criteria import Indices
from steadyload.methods.simulation.placements import Placements
from steadyload.methods.simulation.scene import Across, gaps, in_layout, neighbourhood

BoolArray = NDArray[np.bool_]

VERSION = 1
"""Of what is simulated in this scope: raised when that comes to other verdicts."""

STIRRED = 0.05
"""An item of which a corner has moved by more pushes what it touches at its sides [cm]."""

_TOUCH = 0.1
"""What is closer touches [cm]: engines let boxes overlap a bit, or keep them apart."""


class MovingItems:
    """Loading of a layout on which only what moves is simulated.

    A step at which every item of the new one's group balances, with contact patches drawn in by a
    margin, is stable. Otherwise the items out of balance are simulated, with what stands on them
    and what carries them, among the others, which are frozen. A frozen item that is touched by one
    that is out of balance, or that has moved, is freed, with what stands on it and carries it, and
    the step is simulated once more. The answer is kept until another weight is passed down to what
    was free, or a new item comes in its way.

    What it cannot see: a freed item that leans on a frozen one without moving does not free that,
    which may be too light to hold it. Such a step may pass here and fail where everything is
    simulated. (To free those, too, was tried: hardly a verdict changed, none for the better, and
    nothing was saved, since boxes without gaps free each other.)

    Args:
        layout: what is loaded.
        reach: of some items, how far around them others are in their way [cm].
        margin: see above [cm].
        across: as the boxes of the items are made.
    """

    def __init__(
        self, layout: Layout, reach: Callable[[Indices], float], margin: float, across: Across
    ) -> None:
        self._layout, self._reach, self._across = layout, reach, across
        self._margin = margin
        self._loading = Followed(layout.given, margin)
        self._placed = 0
        self._lost = False
        # By number of the answer, from 1: how far something got, in units of its threshold.
        self._answers = [0.0]

    def place(self, step: int, run: Placements) -> Finding | None:
        """Place an item; a finding when something moves too far.

        Args:
            step: above that of the placement before; the items left out are placed without being
                asked about.
            run: simulates.
        """
        run.forget()
        for earlier in range(self._placed, step):
            self._balanced(earlier)
        kept, moves = self._balanced(step)
        self._placed = step + 1
        if self._lost:
            return run.among_all(step)
        if len(moves):
            return self._simulated(step, moves, run)
        if kept:
            run.forget(self._answers[self._loading.answers[step]])
        return None

    def _balanced(self, step: int) -> tuple[bool, Indices]:
        """Whether the last answer is that with the new item, too, and what moves without one."""
        loading, placed = self._loading, slice(step + 1)
        before = loading.answers.copy()
        ended, kept, group = loading.group(step)
        # Rounding hides whether forces balance: they are those without the item from now on.
        self._lost = self._lost or ended == UNRESOLVED
        # What came in the way of one item came in the way of all that were simulated with it.
        gone = np.unique(before[(loading.answers == 0) & (before > 0)])
        again = np.isin(before, gone)
        loading.answers[again] = 0
        asked = again
        if ended == FAILS and not kept:
            asked[group] = True
        moves = asked & loading.moves
        moves[step] |= loading.is_near_its_edge(step, self._margin)
        return kept, np.flatnonzero(moves[placed])

    def _simulated(self, step: int, moves: Indices, run: Placements) -> Finding | None:
        free = self._with_those_below(self._with_those_above(moves, step), step)
        while True:
            part = neighbourhood(self._layout, free, self._reach(free), step)
            finding = run.locally(step, part)
            low, high = self._reached(free, run)
            if not (np.isfinite(low).all() and np.isfinite(high).all()):
                return finding
            pushed = self._touched(free, part.fixed, low, high, np.isin(free, moves))
            if not len(pushed):
                break
            freed = self._with_those_above(np.union1d(free, pushed), step)
            free = self._with_those_below(freed, step)
        if finding is None:
            self._keep(free, low, high, run.beyond())
        return finding

    def _with_those_above(self, items: Indices, step: int) -> Indices:
        """Some items and what stands on them, directly or over others, in order."""
        loading = self._loading
        return _closure(items, loading.above_starts, loading.above_ends, loading.above, step)

    def _with_those_below(self, items: Indices, step: int) -> Indices:
        """Some items and what carries them, directly or under others, in order."""
        loading = self._loading
        return _closure(items, loading.starts, loading.ends, loading.below, step)

    def _reached(self, free: Indices, run: Placements) -> tuple[FloatArray, FloatArray]:
        """Corners of the free items' bounding boxes by now [cm], shape (n, 3) each."""
        poses = in_layout(run.looked_at(), self._layout, across=self._across)
        centres, quaternions = (part[: len(free)] for part in poses)
        half = 0.5 * (self._layout.upper[free] - self._layout.lower[free])
        turned = [rotate(quaternions, half[:, k, None] * np.eye(3)[k]) for k in range(3)]
        extent = np.abs(turned).sum(axis=0)
        return centres - extent, centres + extent

    def _touched(
        self, free: Indices, fixed: Indices, low: FloatArray, high: FloatArray, moves: BoolArray
    ) -> Indices:
        """Frozen items that are touched by what has moved, or moves.

        What is out of balance pushes though it may not have moved: between firm walls it is jammed.
        """
        layout = self._layout
        moved = np.maximum(np.abs(low - layout.lower[free]), np.abs(high - layout.upper[free]))
        stirred = (moved.max(axis=1) > STIRRED) | moves
        lower, upper = layout.lower[fixed], layout.upper[fixed]
        touches = gaps(lower, upper, low[stirred], high[stirred]) <= _TOUCH
        return fixed[touches.any(axis=1)]

    def _keep(self, free: Indices, low: FloatArray, high: FloatArray, beyond: float) -> None:
        """Keep the answer for what comes later; see :class:`steadyload.core.timed.Followed`."""
        loading, layout = self._loading, self._layout
        loading.answers[free] = len(self._answers)
        self._answers.append(beyond)
        loading.solved[free] = True
        loading.farthest[free, :, 0] = np.maximum(high - layout.upper[free], 0.0)
        loading.farthest[free, :, 1] = np.maximum(layout.lower[free] - low, 0.0)


def _closure(items: Indices, starts: Indices, ends: Indices, others: Indices, last: int) -> Indices:
    """Some items, and all that a relation leads to from them, in order.

    Args:
        items: to begin with.
        starts: of every item, where those that it is related to begin among ``others``.
        ends: where they end.
        others: items; the floor is none.
        last: the last item that is there.
    """
    seen, todo = set(items.tolist()), items.tolist()
    while todo:
        at = todo.pop()
        new = [i for i in others[starts[at] : ends[at]].tolist() if 0 <= i <= last]
        todo += [i for i in new if i not in seen]
        seen.update(new)
    return np.array(sorted(seen), dtype=np.intp)

"""Margins of balance of a layout, step by step, and the item that would lose its balance first.

The yes or no of :mod:`steadyload.methods.equilibrium.equilibrium` (vertical forces) says nothing of
how close it was. Real cargo is not where the plan says by millimetres: a margin below that is a
warning.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.optimize import linprog

from steadyload.core.constants import STANDS
from steadyload.layouts.model.contacts import FLOOR, Patch
from steadyload.layouts.model.layout import FloatArray, Layout
from steadyload.statics.balance import solve
from steadyload.statics.corners import corner_columns

_HALVINGS = 24
"""Of the longest side, or more: a metre is told to a tenth of a micrometre."""


@dataclass(frozen=True, slots=True)
class Margin:
    """The margin after one step, over the items joined to the new one by standing on each other.

    Attributes:
        step: the item placed last.
        item: the one that loses its balance first as patches shrink; the one whose balance cannot
            be met, where it is lost.
        patches: every contact patch, those on the floor too, may be narrower by this on every side
            [cm]; negative where balance is lost: they would have to be wider; -inf where that does
            not help (nothing below an item).
        centres: the least shift of a single centre of mass along x or z that loses the balance
            [cm]; negative where it is lost: every centre would have to be allowed to shift by this
            along both axes; -inf where that does not help; nan where not requested.
    """

    step: int
    item: int
    patches: float
    centres: float


def margins(layout: Layout, *, centres: bool = True) -> list[Margin]:
    """The margin at every step, counted from 0, each judged with all items placed by then.

    Args:
        layout: any layout.
        centres: solve the linear programmes for the centres of mass, too: four an item and step,
            some milliseconds each.
    """
    scene = _Scene(layout)
    return [scene.margin(step, centres) for step in range(len(layout))]


class _Scene:
    def __init__(self, layout: Layout) -> None:
        self.layout, self.supports = layout, layout.supports
        self.sizes = layout.upper - layout.lower
        self.middle = 0.5 * (layout.lower + layout.upper) + layout.mass_offsets
        patches = [patch for below in self.supports.below for patch in below]
        for j in np.flatnonzero(self.supports.on_floor).tolist():
            low = np.maximum(layout.lower[j, ::2], layout.floor.low).tolist()
            high = np.minimum(layout.upper[j, ::2], layout.floor.high).tolist()
            patches.append(Patch(FLOOR, j, *low, *high))
        self.patches = sorted(patches)

    def margin(self, step: int, centres: bool) -> Margin:
        items = self.supports.joined(step)
        patches = [p for p in self.patches if p.above in items and p.below <= step]

        def failing(grow: float) -> int | None:
            found = solve(self.layout, items, patches, grow)
            return None if found.ended == STANDS else found.item

        # Wider than this changes nothing any more: every patch spans its group.
        span = self.layout.upper[items][:, ::2] - self.layout.lower[items].min(axis=0)[::2]
        longest = float(span.max())
        item = failing(0.0)
        if item is None:
            low, high = 0.0, longest
        elif failing(longest) is None:
            low, high = -longest, 0.0
        else:
            low = high = -math.inf
        for _ in range(_HALVINGS if math.isfinite(low) else 0):
            middle = 0.5 * (low + high)
            if failing(-middle) is None:
                low = middle
            else:
                high = middle
        first = failing(-high) if item is None else item
        assert first is not None, "no patch is left at the upper end"
        shift = math.nan
        if centres:
            shift = self._centres(items, patches, held=item is None)
        return Margin(step, first, low, shift)

    def _centres(self, items: list[int], patches: list[Patch], *, held: bool) -> float:
        """Linear programmes over the forces and the shifts of the centres of mass."""
        if not patches:
            return -math.inf
        n = len(items)
        masses = self.layout.weights[items] / self.layout.weights[items].mean()
        balance = corner_columns(items, patches, self.middle, 0.0).reshape(3 * n, -1)
        weight = np.zeros((n, 3))
        weight[:, 0] = masses
        scale = float(self.sizes[items].max())
        if held:
            return min(
                self._solved(balance, self._shifts(n, [(k, axis, sign * m)]), weight, -1.0, scale)
                for k, m in enumerate(masses.tolist())
                for axis in (1, 2)
                for sign in (1.0, -1.0)
            )
        every = [(k, axis, m) for k, m in enumerate(masses.tolist()) for axis in (1, 2)]
        return -self._solved(balance, self._shifts(n, every), weight, 1.0, scale)

    @staticmethod
    def _shifts(n: int, which: list[tuple[int, int, float]]) -> FloatArray:
        """Moments due to unit shifts of centres of mass, one column a shift."""
        columns = np.zeros((n, 3, len(which)))
        for column, (k, axis, moment) in enumerate(which):
            columns[k, axis, column] = moment
        return columns.reshape(3 * n, -1)

    @staticmethod
    def _solved(
        balance: FloatArray, shifts: FloatArray, weight: FloatArray, sign: float, scale: float
    ) -> float:
        """The largest (sign -1) or least (sign 1) t with balance at shifts within t [cm].

        With sign -1 there is one shift, which is t itself.
        """
        forces, count = balance.shape[1], shifts.shape[1]
        equations = np.concatenate((balance, -shifts * scale, np.zeros((len(balance), 1))), axis=1)
        # Moments in units of the longest side, as the shifts.
        equations[1::3] /= scale
        equations[2::3] /= scale
        cost = np.zeros(equations.shape[1])
        cost[-1] = sign
        least = np.zeros((2 * count, len(cost)))
        for k in range(count):
            least[k, forces + k], least[count + k, forces + k] = 1.0, -1.0
        least[:, -1] = -1.0
        bounds = [(0, None)] * forces + [(None, None)] * count + [(0, None)]
        if sign < 0.0:
            least[0, forces], least[0, -1] = -1.0, 1.0  # t <= shift
        found = linprog(
            cost, A_ub=least, b_ub=np.zeros(len(least)), A_eq=equations,
            b_eq=weight.ravel(), bounds=bounds, method="highs",
        )  # fmt: skip
        if found.status == 2:
            return math.inf
        assert found.status == 0, found.message
        return float(found.x[-1]) * scale

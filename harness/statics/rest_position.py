"""The position in which a load comes to rest: that of least potential energy.

Boxes that lost their balance tip into the gaps beside their supports, and most come to rest there:
on a lower neighbour, or with an edge on the floor. Let every box sink by its own amount and tilt
about both horizontal axes, by little: then its base stays a plane, and no box passes through
another if no corner of a face that two share comes below where it meets the other. All of that is
linear, and so is the potential energy. The rest position is the solution of a linear programme,
whose shadow prices are the contact forces: where nothing sinks, they are those of exact
equilibrium. What would have to sink or tilt without end falls.

What this leaves out: boxes do not move sideways, so that they neither slide nor lean on each other,
and the way to the rest position plays no part: none is overshot.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from steadyload.layouts.model.contacts import FLOOR
from steadyload.layouts.model.layout import TOLERANCE, FloatArray, Layout
from steadyload.statics.movement import Movement

VERSION = 1
"""Of rest positions: raised when others are found."""

Indices = NDArray[np.intp]

FAR = 1.5
"""Multiple of a threshold at which something counts as falling: the end of what is looked at."""

_LEAST = 1.0
"""What moves is looked at up to so many cm and degrees, however small thresholds are."""

_LIGHTEST = 1e-6
"""Least weight of a box in the linear programme, in units of the mean of its group: what is lighter
would count for nothing beside the solver's tolerance."""

_CLOSE = 2.0
"""Faces with a wider gap between them enter the linear programme once they would meet [cm]."""

_PASSES = 1e-7
"""By so much one box may be in another [cm]."""

_CORNERS = np.array(((0, 1), (0, 3), (2, 1), (2, 3)))
"""Columns of x and z of a patch's four corners."""


class RestPositionError(RuntimeError):
    """The linear programme could not be solved."""


class Movements(NamedTuple):
    """Movements of several items away from their planned poses.

    Attributes:
        items: their sequence numbers, shape (n,), as all others.
        displacements: [cm].
        rotations: the largest angle about an axis [degrees].
        beyond: the larger of the two, in units of its threshold.
    """

    items: Indices
    displacements: FloatArray
    rotations: FloatArray
    beyond: FloatArray

    def furthest(self, among: NDArray[np.bool_]) -> Movement:
        """The movement that is furthest beyond its threshold, of some of the items."""
        worst = int(np.where(among, self.beyond, -1.0).argmax())
        shift, turn = float(self.displacements[worst]), float(self.rotations[worst])
        return Movement(int(self.items[worst]), shift, turn, float(self.beyond[worst]))


class RestPositions:
    """Rest positions of parts of a layout.

    Args:
        layout: what is loaded.
        margin: by which contact patches are drawn in on every side [cm]; one of which nothing is
            left carries nothing.
        eps_t: displacement that counts as unstable [cm].
        eps_r: angle that counts as unstable [degrees], up to 45.
    """

    def __init__(self, layout: Layout, margin: float, eps_t: float, eps_r: float) -> None:
        self._eps_t, self._eps_r = eps_t, eps_r
        self._layout = layout
        self._middle = 0.5 * (layout.lower + layout.upper)
        self._half = 0.5 * (layout.upper - layout.lower)
        self._tilt = math.tan(math.radians(max(FAR * eps_r, _LEAST)))
        # So far a corner can come down before its box is far beyond a threshold.
        drop = max(FAR * eps_t, _LEAST)
        self._reach = 2.0 * (drop + self._tilt * self._half[:, ::2].sum(axis=1))
        self._find_patches(margin)

    def _find_patches(self, margin: float) -> None:
        """Which faces may meet: what lies below, what above, the gap, and the shared rectangle."""
        lower, upper, floor = self._layout.lower, self._layout.upper, self._layout.floor
        gaps = lower[None, :, 1] - upper[:, None, 1]
        low = np.maximum(lower[:, None, ::2], lower[None, :, ::2])
        high = np.minimum(upper[:, None, ::2], upper[None, :, ::2])
        meets = (high - low).min(axis=2) > TOLERANCE
        meets &= (gaps >= -2.0 * TOLERANCE) & (gaps <= self._reach[None])
        np.fill_diagonal(meets, False)
        below, above = np.nonzero(meets)
        plan_low = np.maximum(lower[:, ::2], floor.low)
        plan_high = np.minimum(upper[:, ::2], floor.high)
        on = ((plan_high - plan_low).min(axis=1) > TOLERANCE) & (lower[:, 1] <= self._reach)
        grounded = np.flatnonzero(on)
        self.below = np.concatenate((below, np.full(len(grounded), FLOOR)))
        self.above = np.concatenate((above, grounded))
        self._gaps = np.maximum(np.concatenate((gaps[meets], lower[grounded, 1])), 0.0)
        patches = np.concatenate(
            (
                np.concatenate((low[meets], high[meets]), axis=1),
                np.concatenate((plan_low[grounded], plan_high[grounded]), axis=1),
            )
        )
        sides = patches[:, 2:] - patches[:, :2]
        left = (sides.min(axis=1) >= 2.0 * margin) | (margin <= TOLERANCE)
        by = np.minimum(margin, 0.5 * sides)
        patches[:, :2] += by
        patches[:, 2:] -= by
        patches = patches[left]
        self.below, self.above = self.below[left], self.above[left]
        self._gaps = self._gaps[left]
        self._corners = patches[:, _CORNERS]

    def movements(self, items: Indices, fixed: Indices) -> Movements:
        """How far items are from their planned poses when all are at rest.

        Args:
            items: that may sink and tilt, in ascending order; nothing else may meet them but the
                floor and what is fixed.
            fixed: other items, which do not move.

        Raises:
            RestPositionError: the solver gave up.
        """
        sunk = self._solve(items, fixed)
        half = self._half[items]
        tilts = np.degrees(np.arctan(np.abs(sunk[:, 1:]))).max(axis=1)
        # The left-bottom-back corner, along the axis along which it moves most.
        down = sunk[:, 0] - sunk[:, 1] * half[:, 0] - sunk[:, 2] * half[:, 2]
        aside = np.abs(sunk[:, 1:]).max(axis=1) * half[:, 1]
        shifts = np.maximum(np.abs(down), aside)
        beyond = np.maximum(shifts / max(self._eps_t, 1e-12), tilts / max(self._eps_r, 1e-12))
        return Movements(items, shifts, tilts, beyond)

    def _solve(self, items: Indices, fixed: Indices) -> FloatArray:
        """Height above the plan [cm] and slopes along x and z of every item, shape (n, 3)."""
        place = np.full(len(self._half) + 1, -2)  # the last one is the floor's
        place[fixed], place[FLOOR] = -1, -1
        place[items] = np.arange(len(items))
        over, under = place[self.above], place[self.below]
        rows = np.flatnonzero((over >= 0) & (under >= -1))
        over, under = np.repeat(over[rows], 4), np.repeat(under[rows], 4)
        points = self._corners[rows].reshape(-1, 2)
        number = np.arange(len(points))
        parts = [(number, over, self.above[rows], -1.0)]
        carried = under >= 0
        parts.append((number[carried], under[carried], self.below[rows], 1.0))
        lines, columns, values = [], [], []
        for at, who, items_of, sign in parts:
            middle = self._middle[np.repeat(items_of, 4)[at]][:, ::2]
            arms = (points[at] - middle) * sign
            lines.append(np.repeat(at, 3))
            columns.append((3 * who[:, None] + np.arange(3)).ravel())
            values.append(np.column_stack((np.full(len(at), sign), arms)).ravel())
        from scipy.optimize import Bounds, LinearConstraint, milp  # takes half a second
        from scipy.sparse import csc_array, csr_array

        n = 3 * len(items)
        entries = np.concatenate(values), (np.concatenate(lines), np.concatenate(columns))
        matrix = csr_array(entries, shape=(len(points), n))
        weights = self._layout.weights[items]
        weights = np.maximum(weights / weights.mean(), _LIGHTEST)
        levers = self._layout.mass_offsets[items][:, ::2]
        cost = (weights[:, None] * np.column_stack((np.ones(len(items)), levers))).ravel()
        most = np.tile((2.0 * self._reach[items].max(), self._tilt, self._tilt), len(items))
        gaps = np.repeat(self._gaps[rows], 4)
        # Most boxes never come down to what is far below them: that is looked at afterwards.
        taken = gaps <= _CLOSE
        while True:
            # SciPy's way to the solver with the least overhead, half of the time at ten boxes.
            found = milp(
                cost,
                constraints=LinearConstraint(csc_array(matrix[taken]), -np.inf, gaps[taken]),
                bounds=Bounds(-most, most),
            )
            if found.status != 0:
                raise RestPositionError(
                    f"the linear programme of the rest position: {found.message}"
                )
            left_out = ~taken & (matrix @ found.x > gaps + _PASSES)
            if not left_out.any():
                return np.asarray(found.x).reshape(-1, 3)
            taken |= left_out

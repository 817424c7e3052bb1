"""Vertical balance in NumPy, for whole groups: what compiled code is held against.

The new weight is passed down one way; where that fails, the forces of all items joined to the new
one are solved for.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from steadyload.core.constants import EDGE, RESIDUE
from steadyload.layouts.model.contacts import FLOOR, Patch, Supports
from steadyload.layouts.model.layout import Arrangement, FloatArray
from steadyload.statics.corners import corner_columns
from steadyload.statics.least_squares import nonnegative_least_squares
from steadyload.statics.resolution import fastest, is_balanced, unresolved

Point = tuple[float, float]
"""(x, z) [cm]."""

_Press = tuple[float, float, float]
"""A force [kg] and its moments about the axes, that is: force times x, force times z [kg cm]."""


class Solution(NamedTuple):
    """The forces that come closest to balance, in the sense of Gauss' principle.

    Attributes:
        forces: at the corners (x0, z0), (x0, z1), (x1, z0), (x1, z1) of every patch [kg], (k, 4).
        motion: of every item [g]: how fast its corner that starts fastest accelerates, (n,).
        balanced: whether nothing accelerates; None where that cannot be told from rounding.
    """

    forces: FloatArray
    motion: FloatArray
    balanced: bool | None


def solve(
    items: Sequence[int],
    patches: Sequence[Patch],
    weights: FloatArray,
    centres: FloatArray,
    sizes: FloatArray,
    grow: float = EDGE,
) -> Solution:
    """Non-negative forces that balance a group of items, or the closest to it.

    The equations are weighed by mass and inertia, so that what is left over of them is the
    acceleration with which the group starts to move if contacts push vertically only (Gauss'
    principle of least constraint). It is zero exactly where a balance exists, names the items that
    fail where none does, and does not depend on units.

    Args:
        items: the group, as indices into the arrays.
        patches: contacts; a ``below`` outside the group is as firm as the floor.
        weights: of all items of the layout [kg], (J,).
        centres: their centres of mass (x, y, z) [cm], (J, 3).
        sizes: their sides [cm], (J, 3).
        grow: how much wider every patch counts on each side [cm]; negative shrinks, and drops what
            becomes narrower than nothing.
    """
    who = list(items)
    n = len(who)
    half = 0.5 * sizes[who]
    kept = [k for k, p in enumerate(patches) if min(p.x1 - p.x0, p.z1 - p.z0) >= -2.0 * grow]
    some = [patches[k] for k in kept]
    flat, target, (root, radii) = equations(who, some, weights, centres, sizes, grow)
    loads = residue = target
    forces = np.zeros((len(patches), 4))
    if kept:
        found, residue = nonnegative_least_squares(flat, target)
        loads = target + np.abs(flat) @ found
        forces[kept] = found.reshape(-1, 4)

    def fastest_corners(left: FloatArray) -> FloatArray:
        acceleration = np.abs(left.reshape(n, 3)) / root[:, None]
        return acceleration[:, 0] + (acceleration[:, 1:] / radii * half[:, (0, 2)]).sum(axis=1)

    motion = fastest_corners(residue)
    stands = is_balanced(motion, fastest_corners(loads), root**2, RESIDUE)
    return Solution(forces * weights[who].mean(), motion, stands)


def equations(
    who: list[int],
    patches: Sequence[Patch],
    weights: FloatArray,
    centres: FloatArray,
    sizes: FloatArray,
    grow: float,
) -> tuple[FloatArray, FloatArray, tuple[FloatArray, FloatArray]]:
    """The equations of balance that :func:`solve` solves: matrix, (3 n, 4 k), target, (3 n,), and
    what rows are weighed by: roots of masses and radii of gyration.
    """
    masses = weights[who] / weights[who].mean()
    half = 0.5 * sizes[who]
    # Radii of gyration: a box of half sides a, b has k2 = (a2 + b2) / 3.
    radii = np.sqrt((half[:, (0, 2)] ** 2 + half[:, 1:2] ** 2) / 3.0)
    root = np.sqrt(masses)
    target = np.zeros((len(who), 3))
    target[:, 0] = root
    if not patches:
        return np.zeros((target.size, 0)), target.ravel(), (root, radii)
    matrix = corner_columns(who, patches, centres, grow)
    matrix /= root[:, None, None]
    matrix[:, 1:] /= radii[:, :, None]
    return matrix.reshape(target.size, -1), target.ravel(), (root, radii)


class VerticalBalance:
    """Balance of a layout's items, step by step, with forces at hand for all that balances.

    Args:
        layout: any layout.
        supports: its contacts, where somebody has them already.

    Attributes:
        solved: how often the whole problem had to be solved so far.
    """

    def __init__(self, layout: Arrangement, supports: Supports | None = None) -> None:
        self.solved = 0
        self._layout = layout
        self._supports = layout.supports if supports is None else supports
        self._weights: list[float] = layout.weights.tolist()
        self._points: list[Point] = [(x, z) for x, _, z in self.centres.tolist()]
        self._bases: list[float] = layout.lower[:, 1].tolist()
        self._balanced = [True] * len(layout.lower)
        # What every item presses on each of the items below it.
        self._presses: list[dict[int, _Press]] = [{} for _ in layout.lower]

    @property
    def centres(self) -> FloatArray:
        """Centres of mass (x, y, z) [cm], shape (J, 3)."""
        layout = self._layout
        return 0.5 * (layout.lower + layout.upper) + layout.mass_offsets

    @property
    def sizes(self) -> FloatArray:
        """Sides [cm], shape (J, 3)."""
        return self._layout.upper - self._layout.lower

    def place(self, step: int) -> int | None:
        """Place an item; the item whose balance cannot be met, or None when all stand.

        Args:
            step: the new item. All items before it must have been placed, whatever came of it.

        Raises:
            UnresolvedError: balance cannot be told from rounding; nothing has changed.
        """
        if self._supports.on_floor[step]:
            return None
        if not any(j < step for j in self._supports.above[step]):
            presses = self._passed_down(step)
            if presses is not None:
                for item, loads in presses.items():
                    self._presses[item] = loads
                return None
            # Nothing holds down the newest item, so no forces elsewhere help it.
            patches = [p for p in self._supports.below[step] if p.below < step]
            if _spread(self._weights[step], self._points[step], patches) is None:
                group = self.group(step)
                for item in group:
                    self._balanced[item] = False
                return step
        return self._solve(step)

    def group(self, step: int) -> list[int]:
        """Items joined to the one placed last by standing on each other, floor items left out."""
        return self._supports.joined(step, floor=False)

    def solution(self, items: Sequence[int], step: int, grow: float = EDGE) -> Solution:
        """The whole problem for a group after a step, see :func:`solve`."""
        self.solved += 1
        patches = self._present(items, step)
        return solve(items, patches, self._layout.weights, self.centres, self.sizes, grow)

    def _present(self, items: Sequence[int], step: int) -> list[Patch]:
        return [p for j in items for p in self._supports.below[j] if p.below <= step]

    def _passed_down(self, step: int) -> dict[int, dict[int, _Press]] | None:
        """The new weight passed down one way: the presses that change, or None when it fails."""
        changed: dict[int, dict[int, _Press]] = {}
        todo = [(-self._bases[step], step)]
        while todo:
            # The highest base first: items above an item have passed on their loads before it.
            todo.sort()
            item = todo.pop(0)[1]
            if not self._balanced[item]:
                return None
            force = self._weights[item]
            x, z = self._points[item]
            x, z = force * x, force * z
            for other in self._supports.above[item]:
                if other <= step:
                    more, along_x, along_z = changed.get(other, self._presses[other])[item]
                    force, x, z = force + more, x + along_x, z + along_z
            patches = [p for p in self._supports.below[item] if p.below < step]
            loads = _spread(force, (x / force, z / force), patches)
            if loads is None:
                return None
            changed[item] = loads
            # Supporters that no longer carry anything must be updated, too.
            for below in {*loads, *self._presses[item]}:
                loads.setdefault(below, (0.0, 0.0, 0.0))
                if below == FLOOR or self._supports.on_floor[below]:
                    continue
                if (-self._bases[below], below) not in todo:
                    todo.append((-self._bases[below], below))
            for patch in patches:
                loads.setdefault(patch.below, (0.0, 0.0, 0.0))
        return changed

    def _solve(self, step: int) -> int | None:
        items = self.group(step)
        found = self.solution(items, step)
        if found.balanced is None:
            raise unresolved(self._layout.weights[items])
        for j in items:
            self._balanced[j] = found.balanced
            self._presses[j] = {}
        if not found.balanced:
            return items[fastest(found.motion)]
        for patch, at in zip(self._present(items, step), found.forces.tolist(), strict=True):
            below, above, x0, z0, x1, z1 = patch
            self._presses[above][below] = (
                sum(at),
                (at[0] + at[1]) * x0 + (at[2] + at[3]) * x1,
                (at[0] + at[2]) * z0 + (at[1] + at[3]) * z1,
            )
        return None


def _spread(force: float, at: Point, patches: Sequence[Patch]) -> dict[int, _Press] | None:
    """One way for patches to carry a force at a point; None when it lies outside their hull."""
    x, z = at
    for p in patches:
        if p.x0 - EDGE <= x <= p.x1 + EDGE and p.z0 - EDGE <= z <= p.z1 + EDGE:
            return {p.below: (force, force * x, force * z)}
    if len(patches) < 2:
        return None
    # First where each patch is nearest to the force, as a stiff beam presses; then at the corners.
    near = [(p.below, min(max(x, p.x0), p.x1), min(max(z, p.z0), p.z1)) for p in patches]
    corners = [(p.below, a, b) for p in patches for a in (p.x0, p.x1) for b in (p.z0, p.z1)]
    for points in (near, corners):
        loads = _shared(force, at, points)
        if loads is not None:
            return loads
    return None


def _shared(
    force: float, at: Point, points: Sequence[tuple[int, float, float]]
) -> dict[int, _Press] | None:
    """Forces at given points (below, x, z) whose resultant is the given one; None without any."""
    x, z = at
    # Lengths in units of the farthest point, so that the residue means the same at every size.
    reach = max(max(abs(a - x), abs(b - z)) for _, a, b in points)
    matrix = np.array(
        [[1.0] * len(points), [(a - x) / reach for _, a, _ in points],
         [(b - z) / reach for _, _, b in points]]
    )  # fmt: skip
    parts, residue = nonnegative_least_squares(matrix, np.array([1.0, 0.0, 0.0]))
    if float(np.linalg.norm(residue)) * reach > 0.1 * EDGE:
        return None
    loads: dict[int, _Press] = {}
    for part, (below, a, b) in zip(parts.tolist(), points, strict=True):
        if part > 0.0:
            f, fx, fz = loads.get(below, (0.0, 0.0, 0.0))
            part *= force
            loads[below] = (f + part, fx + part * a, fz + part * b)
    return loads

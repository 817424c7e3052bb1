"""A layout that grows item by item, and shrinks again, at a cost independent of its size."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from steadyload.layouts.contacts import FLOOR, Patch, Supports
from steadyload.layouts.floor import Floor
from steadyload.layouts.grid import BoxGrid
from steadyload.layouts.model import (
    TOLERANCE,
    FloatArray,
    Item,
    Layout,
    Pallet,
    Vector,
    outside_error,
    overlap_error,
)

_ROOM = 32


class GrowingLayout:
    """The items loaded so far, with the items each one stands on and those near it.

    What is true of a :class:`Layout` of the same items is true of it at any time, numbers included
    to the last bit.

    Args:
        pallet: its contour holds all items, to within :data:`TOLERANCE`.
        name: as of a :class:`Layout`.

    Attributes:
        items: in loading order; their sequence numbers count from 0.
        supports: vertical contacts between them.
    """

    def __init__(self, pallet: Pallet, name: str) -> None:
        self.pallet, self.name = pallet, name
        self.items: list[Item] = []
        self.supports = Supports([], [], [])
        self._corners: list[tuple[Vector, Vector]] = []
        self._grid = BoxGrid()
        self._overhung = 0
        self._arrays = [np.empty((_ROOM, 3)) for _ in range(3)] + [np.empty(_ROOM)]

    def __len__(self) -> int:
        return len(self.items)

    @property
    def floor(self) -> Floor:
        """The floor that the items stand on; an ``auto`` one follows what is loaded by now."""
        return self.pallet.floor_under(overhung=self._overhung > 0)

    @property
    def lower(self) -> FloatArray:
        """Lower corners [cm], shape (J, 3), columns x, y, z: a view, read-only as the others."""
        return self._view(0)

    @property
    def upper(self) -> FloatArray:
        """Upper corners [cm], shape (J, 3)."""
        return self._view(1)

    @property
    def mass_offsets(self) -> FloatArray:
        """Centres of mass minus geometric centres [cm], shape (J, 3)."""
        return self._view(2)

    @property
    def weights(self) -> FloatArray:
        """[kg], shape (J,)."""
        return self._view(3)

    def put(self, item: Item) -> None:
        """Put on the next item.

        Raises:
            LayoutError: it stands out of the contour or overlaps another; nothing has changed.
        """
        low = item.position
        high = (low[0] + item.size[0], low[1] + item.size[1], low[2] + item.size[2])
        self._check_contour(item, low, high)
        below, above = self._touching(item, low, high)
        number = len(self.items)
        if number == len(self._arrays[0]):
            self._arrays = [np.concatenate((a, np.empty_like(a))) for a in self._arrays]
        lower, upper, offsets, weights = self._arrays
        lower[number], upper[number], offsets[number] = low, high, item.mass_offset
        weights[number] = item.weight
        self.items.append(item)
        self._corners.append((low, high))
        self._grid.add(number, low, high)
        self._overhung += self.pallet.is_overhung(low, high)
        stands = low[1] <= TOLERANCE
        at_edge = self._at_edge(number, low, high) if stands and self.floor.has_edges else None
        self.supports.on_floor.append(stands and at_edge is None)
        self.supports.below.append([*(at_edge or []), *below])
        self.supports.above.append([p.above for p in above])
        for patch in below:
            self.supports.above[patch.below].append(number)
        for patch in above:
            self.supports.below[patch.above].append(patch)

    def take_off(self) -> Item:
        """Take off the item put on last, and return it."""
        for carrier in self.supports.carriers(len(self.items) - 1):
            self.supports.above[carrier].pop()
        self.supports.on_floor.pop()
        self.supports.below.pop()
        for above in self.supports.above.pop():
            self.supports.below[above].pop()
        low, high = self._corners.pop()
        self._overhung -= self.pallet.is_overhung(low, high)
        self._grid.remove(len(self.items) - 1, low, high)
        return self.items.pop()

    def beside(self, items: Sequence[int], reach: float) -> list[int]:
        """All other items with a gap of at most ``reach`` [cm] along every axis to one of some."""
        found: set[int] = set()
        for item in items:
            low, high = self._corners[item]
            wider = _grown(low, high, reach + TOLERANCE)
            for other in set(self._grid.meeting(*wider)).difference(found):
                a, b = self._corners[other]
                # To the last bit as for all items at once (steadyload.methods.scene.neighbourhood).
                if max(max(a[k] - high[k], low[k] - b[k]) for k in range(3)) <= reach:
                    found.add(other)
        return sorted(found.difference(items))

    def layout(self, name: str | None = None) -> Layout:
        """The items as a layout.

        Args:
            name: None for the one it has.

        Raises:
            LayoutError: there are no items, or no such name.
        """
        return Layout(self.name if name is None else name, self.pallet, tuple(self.items))

    def copy(self) -> GrowingLayout:
        """Another one with the same items, that grows by itself."""
        other = GrowingLayout(self.pallet, self.name)
        other.items, other._corners = list(self.items), list(self._corners)
        other._grid, other._arrays = self._grid.copy(), [a.copy() for a in self._arrays]
        other._overhung = self._overhung
        mine = self.supports
        other.supports = Supports(
            list(mine.on_floor), [list(p) for p in mine.below], [list(i) for i in mine.above]
        )
        return other

    def _view(self, which: int) -> FloatArray:
        view = self._arrays[which][: len(self.items)]
        view.setflags(write=False)
        return view

    def _check_contour(self, item: Item, low: Vector, high: Vector) -> None:
        least, most = self.pallet.contour
        outside = [max(least[k] - low[k], high[k] - most[k]) for k in range(3)]
        if max(outside) > TOLERANCE:
            axis = outside.index(max(outside))
            raise outside_error(item, self.pallet, axis, (low[axis], high[axis]))

    def _at_edge(self, number: int, low: Vector, high: Vector) -> list[Patch] | None:
        """The patch on the deck of an item that overhangs an edge; None for one that does not.

        What lies beside the deck altogether has no patch.
        """
        if not self.pallet.is_overhung(low, high):
            return None
        (x0, z0), (x1, z1) = self.floor.low, self.floor.high
        x0, x1, z0, z1 = max(x0, low[0]), min(x1, high[0]), max(z0, low[2]), min(z1, high[2])
        if min(x1 - x0, z1 - z0) <= TOLERANCE:
            return []
        return [Patch(FLOOR, number, x0, z0, x1, z1)]

    def _touching(self, item: Item, low: Vector, high: Vector) -> tuple[list[Patch], list[Patch]]:
        """The patches that an item would stand on, and those that would stand on it.

        Raises:
            LayoutError: it overlaps one of those that are near.
        """
        number = len(self.items)
        below, above = [], []
        deepest, under = TOLERANCE, -1
        for other in self._grid.meeting(*_grown(low, high, 2.0 * TOLERANCE)):
            (ax, ay, az), (bx, by, bz) = self._corners[other]
            x0, x1 = max(ax, low[0]), min(bx, high[0])
            z0, z1 = max(az, low[2]), min(bz, high[2])
            if min(x1 - x0, z1 - z0) <= TOLERANCE:
                continue
            depth = min(x1 - x0, z1 - z0, min(by, high[1]) - max(ay, low[1]))
            if depth > deepest:
                deepest, under = depth, other
            if abs(by - low[1]) <= TOLERANCE:
                below.append(Patch(other, number, x0, z0, x1, z1))
            if abs(high[1] - ay) <= TOLERANCE:
                above.append(Patch(number, other, x0, z0, x1, z1))
        if under >= 0:
            raise overlap_error(item, self.items[under], deepest)
        return sorted(below), sorted(above)


def _grown(low: Vector, high: Vector, by: float) -> tuple[Vector, Vector]:
    """Corners of a box that is larger by this on every side [cm]."""
    return (
        (low[0] - by, low[1] - by, low[2] - by),
        (high[0] + by, high[1] + by, high[2] + by),
    )

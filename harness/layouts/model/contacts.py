"""Contacts between the items of a layout: the geometry that all static methods share.

A layout has its own, found once: ``layout.contacts``, ``layout.supports``.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from steadyload.core import whole
from steadyload.core.constants import FLOOR as FLOOR
from steadyload.layouts.model.checks import FloatArray

VERSION = 1
"""Of contacts, supports and layouts that grow: raised when others are found."""


@dataclass(frozen=True, slots=True)
class Contacts:
    """Vertical contacts of a layout, as arrays: P patches, by the items above, then below.

    Faces are level to within :data:`.TOLERANCE` and share an area.

    Attributes:
        on_floor: item stands on the floor with all of its base, shape (J,).
        below: the item that carries, shape (P,); :data:`FLOOR` where one whose base overhangs an
            edge of the floor stands on that.
        above: the item that is carried, shape (P,).
        corners: x0, z0, x1, z1 [cm], shape (P, 4).
    """

    on_floor: NDArray[np.bool_]
    below: NDArray[np.int32]
    above: NDArray[np.intp]
    corners: FloatArray

    @classmethod
    def of(cls, found: whole.Contacts) -> Contacts:
        """The same, as the C library finds them."""
        above = np.repeat(np.arange(len(found.on_floor)), np.diff(found.starts))
        return cls(found.on_floor, found.below, above, found.patches)

    @property
    def areas(self) -> FloatArray:
        """Of patches [cm2], shape (P,)."""
        found: FloatArray = (self.corners[:, 2:] - self.corners[:, :2]).prod(axis=1)
        return found

    @property
    def carries(self) -> NDArray[np.bool_]:
        """``carries[i, j]`` is true where the top of i touches the base of j, shape (J, J)."""
        found = np.zeros((len(self.on_floor), len(self.on_floor)), dtype=np.bool_)
        item = self.below != FLOOR
        found[self.below[item], self.above[item]] = True
        return found


class Patch(NamedTuple):
    """A contact patch: who carries whom, and where [cm]. The floor that carries an item whose base
    overhangs an edge is :data:`FLOOR`.
    """

    below: int
    above: int
    x0: float
    z0: float
    x1: float
    z1: float


@dataclass(slots=True)
class Supports:
    """Vertical contacts as lists by item: for those who look at a few items at a time.

    Attributes:
        on_floor: item stands on the floor with all of its base.
        below: the patches that an item stands on, in the order of the items that carry it; first
            that on the floor, where the item overhangs an edge.
        above: the items that it carries, in order.
    """

    on_floor: list[bool]
    below: list[list[Patch]]
    above: list[list[int]]

    @classmethod
    def of(cls, found: whole.Contacts) -> Supports:
        """The same, as the C library finds them."""
        below, corners, above = found.below.tolist(), found.patches.tolist(), found.above.tolist()
        patches = [
            [Patch(below[k], j, *corners[k]) for k in range(start, end)]
            for j, (start, end) in enumerate(pairwise(found.starts.tolist()))
        ]
        carried = [above[start:end] for start, end in pairwise(found.above_starts.tolist())]
        return cls(found.on_floor.tolist(), patches, carried)

    def carriers(self, item: int) -> list[int]:
        """The items that an item stands on, in order."""
        return [p.below for p in self.below[item] if p.below != FLOOR]

    def joined(self, item: int, *, floor: bool = True) -> list[int]:
        """An item and all earlier ones joined to it by standing on each other, in order.

        Args:
            item: counts from 0.
            floor: items on the floor are among them, and join others.
        """
        todo, seen = [item], {item}
        while todo:
            at = todo.pop()
            for other in self.carriers(at) + self.above[at]:
                if other <= item and other not in seen and (floor or not self.on_floor[other]):
                    seen.add(other)
                    todo.append(other)
        return sorted(seen)

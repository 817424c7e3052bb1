"""Contacts between items: the geometry that all static methods share."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from steadyload.core.constants import FLOOR as FLOOR
from steadyload.layouts.model.layout import TOLERANCE, Arrangement, FloatArray

VERSION = 1
"""Of contacts, supports and layouts that grow: raised when others are found."""


@dataclass(frozen=True, slots=True)
class Contacts:
    """Vertical contacts of a whole layout.

    Attributes:
        on_floor: item stands on the floor with all of its base, shape (J,).
        at_edge: item stands on the floor with a part of its base, and overhangs an edge, shape
            (J,).
        floor_low, floor_high: the rectangle of a base above the floor in (x, z) [cm], shape (J, 2);
            meaningless where there is none.
        carries: ``carries[i, j]`` is true where the top of i touches the base of j, shape (J, J).
        corners_low, corners_high: the contact rectangle of i and j in (x, z) [cm], shape
            (J, J, 2); meaningless where there is no contact.
    """

    on_floor: NDArray[np.bool_]
    at_edge: NDArray[np.bool_]
    floor_low: FloatArray
    floor_high: FloatArray
    carries: NDArray[np.bool_]
    corners_low: FloatArray
    corners_high: FloatArray

    def areas(self) -> FloatArray:
        """Contact areas [cm2] between i (below) and j (above), shape (J, J)."""
        return np.where(self.carries, (self.corners_high - self.corners_low).prod(axis=2), 0.0)

    def edge_areas(self) -> FloatArray:
        """Areas [cm2] with which items that overhang an edge stand on the floor, shape (J,)."""
        return np.where(self.at_edge, (self.floor_high - self.floor_low).prod(axis=1), 0.0)


def find_contacts(layout: Arrangement) -> Contacts:
    """All vertical contacts: faces level to within :data:`TOLERANCE` that share an area."""
    floor_plan_low, floor_plan_high = layout.lower[:, ::2], layout.upper[:, ::2]
    low = np.maximum(floor_plan_low[:, None], floor_plan_low[None])
    high = np.minimum(floor_plan_high[:, None], floor_plan_high[None])
    level = np.abs(layout.upper[:, 1, None] - layout.lower[None, :, 1]) <= TOLERANCE
    shared = (high - low).min(axis=2) > TOLERANCE
    floor = layout.floor
    on_floor, at_edge = layout.lower[:, 1] <= TOLERANCE, np.zeros(len(layout), dtype=bool)
    floor_low, floor_high = floor_plan_low, floor_plan_high
    if floor.has_edges:
        floor_low = np.maximum(floor_low, floor.low)
        floor_high = np.minimum(floor_high, floor.high)
        out = np.maximum(floor_low - floor_plan_low, floor_plan_high - floor_high).max(axis=1)
        above = (floor_high - floor_low).min(axis=1) > TOLERANCE
        at_edge = on_floor & (out > TOLERANCE) & above
        on_floor = on_floor & (out <= TOLERANCE)
    return Contacts(
        on_floor=on_floor,
        at_edge=at_edge,
        floor_low=floor_low,
        floor_high=floor_high,
        carries=level & shared,
        corners_low=low,
        corners_high=high,
    )


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


def find_supports(layout: Arrangement) -> Supports:
    """All vertical contacts of a layout, as lists."""
    contacts = layout.given.contacts()
    starts, above_starts = contacts.starts.tolist(), contacts.above_starts.tolist()
    below, corners = contacts.below.tolist(), contacts.patches.tolist()
    above = contacts.above.tolist()
    patches = [
        [Patch(below[k], j, *corners[k]) for k in range(start, end)]
        for j, (start, end) in enumerate(pairwise(starts))
    ]
    carried = [above[start:end] for start, end in pairwise(above_starts)]
    return Supports(contacts.on_floor.tolist(), patches, carried)

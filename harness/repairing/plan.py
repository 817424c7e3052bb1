"""The boxes of a plan, places of boxes, and the cost of a changed plan."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import cached_property

import numpy as np

from steadyload.layouts.model.layout import FloatArray, Item, Layout, Vector


class Kind(StrEnum):
    """A way in which a plan may change.

    ``order``: the sequence of loading. ``drop``: a box comes straight down. ``shift``: a box moves
    sideways, within a distance, and stays at its height or comes down. ``turn``: a box is turned by
    a quarter about the vertical; its upper side stays up. ``move``: a box is put anywhere.
    ``leave``: a box is left out.
    """

    ORDER = "order"
    DROP = "drop"
    SHIFT = "shift"
    TURN = "turn"
    MOVE = "move"
    LEAVE = "leave"


@dataclass(frozen=True, slots=True)
class Place:
    """Where a box is put: its lower corner [cm], and whether it is turned by a quarter."""

    position: Vector
    turned: bool = False


@dataclass(frozen=True, order=True, slots=True)
class Worth:
    """Cost of a changed plan; the smaller the better, the first number first.

    Attributes:
        left: boxes that are left out.
        volume: of these [cm3].
        moved: boxes at another place.
        distance: that these are moved, all together [cm].
        reordered: boxes that are loaded at another time, at least.
    """

    left: int
    volume: float
    moved: int
    distance: float
    reordered: int


class Boxes:
    """The boxes of a plan, by their steps in it.

    Args:
        layout: the plan.
        limited: what boxes may bear counts.

    Attributes:
        layout: the plan.
        limited: some box states what it may bear, and that counts.
    """

    def __init__(self, layout: Layout, *, limited: bool = True) -> None:
        self.layout = layout
        self.limited = limited and any(item.max_load is not None for item in layout.items)
        self._turned: dict[int, Item] = {}
        self._items: dict[tuple[int, Place], Item] = {}

    def __len__(self) -> int:
        return len(self.layout)

    @cached_property
    def planned(self) -> tuple[Place, ...]:
        """Where they are in the plan."""
        return tuple(Place(item.position) for item in self.layout.items)

    @cached_property
    def volumes(self) -> FloatArray:
        """[cm3], shape (J,)."""
        found: FloatArray = self.layout.sizes.prod(axis=1)
        return found

    @cached_property
    def limits(self) -> FloatArray:
        """The space for boxes (lower, upper) and the deck (x0, z0, x1, z1) [cm], shape (10,).

        Boxes stand out over an edge of the deck no further than in the plan.
        """
        pallet, layout = self.layout.pallet, self.layout
        low, high = map(np.array, pallet.contour)
        deck = np.array([0.0, 0.0, pallet.width, pallet.depth])
        low[::2] = np.maximum(low[::2], np.minimum(deck[:2], layout.lower[:, ::2].min(axis=0)))
        high[::2] = np.minimum(high[::2], np.maximum(deck[2:], layout.upper[:, ::2].max(axis=0)))
        return np.concatenate((low, high, deck))

    def item(self, box: int, place: Place) -> Item:
        """A box at a place."""
        found = self._items.get((box, place))
        if found is None:
            own = self.turned(box) if place.turned else self.layout.items[box]
            found = self._items[box, place] = replace(own, position=place.position)
        return found

    def turned(self, box: int) -> Item:
        """A box turned by a quarter about the vertical through its centre, with its contents."""
        if box not in self._turned:
            own = self.layout.items[box]
            (width, height, depth), (x, y, z) = own.size, own.mass_offset
            self._turned[box] = replace(
                own, size=(depth, height, width), mass_offset=(z, y, -x if x else 0.0)
            )
        return self._turned[box]

    def distance(self, box: int, place: Place) -> float:
        """How far the centre of a box comes to be from where it was in the plan [cm]."""
        own, there = self.layout.items[box], self.item(box, place)
        far = [
            (b + 0.5 * t) - (a + 0.5 * s)
            for a, s, b, t in zip(own.position, own.size, there.position, there.size, strict=True)
        ]
        return float(np.sqrt(np.dot(far, far)))

    def worth(self, places: Sequence[Place | None], order: Sequence[int]) -> Worth:
        """The cost of a changed plan.

        Args:
            places: by box; None for one that is left out.
            order: the boxes that are kept, as they are loaded.
        """
        left = [box for box, place in enumerate(places) if place is None]
        far = [
            self.distance(box, place)
            for box, place in enumerate(places)
            if place is not None and place != self.planned[box]
        ]
        return Worth(
            len(left), round(float(self.volumes[left].sum()), 6), len(far), round(sum(far), 6),
            len(order) - len(kept_in_order(order)),
        )  # fmt: skip


def kept_in_order(order: Sequence[int]) -> list[int]:
    """A longest part of a sequence in which numbers ascend: the boxes that need no other time."""
    ends: list[int] = []  # place in `order` of the smallest last number of a part of each length
    before = [-1] * len(order)
    for place, box in enumerate(order):
        length = int(np.searchsorted([order[end] for end in ends], box))
        before[place] = ends[length - 1] if length else -1
        ends[length : length + 1] = [place]
    found: list[int] = []
    place = ends[-1] if ends else -1
    while place >= 0:
        found.append(order[place])
        place = before[place]
    return found[::-1]

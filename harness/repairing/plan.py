"""The boxes of a plan, places of boxes, and the cost of a changed plan."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import cached_property

import numpy as np

from steadyload.core import loading
from steadyload.core.constants import AS_PLANNED
from steadyload.core.constants import LEFT_OUT as LEFT_OUT
from steadyload.layouts.model.layout import TOLERANCE, FloatArray, Item, Layout


class Kind(StrEnum):
    """A way in which a plan may change.

    ``order``: the sequence of loading. ``drop``: a box comes down. ``shift``: a box moves
    sideways, within a distance; it stays at its height unless ``drop`` is allowed, too. ``turn``: a
    box is turned by a quarter about the vertical; its upper side stays up. ``move``: a box is put
    anywhere. ``leave``: a box is left out.
    """

    ORDER = "order"
    DROP = "drop"
    SHIFT = "shift"
    TURN = "turn"
    MOVE = "move"
    LEAVE = "leave"


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

    A place of a box is a row of four numbers: its lower corner (x, y, z) [cm], and whether it is as
    planned (0), turned by a quarter about the vertical (1), or left out: :data:`LEFT_OUT`.

    Args:
        layout: the plan.
        limited: what boxes may bear counts.

    Attributes:
        layout: the plan.
        limited: some box states what it may bear, and that counts.
        planned: places in the plan, shape (J, 4).
        sides: sizes of boxes as planned and turned [cm], shape (2, J, 3).
        volumes: [cm3], shape (J,).
        given: the boxes as the C library takes them.
    """

    def __init__(self, layout: Layout, *, limited: bool = True) -> None:
        self.layout = layout
        self.limited = limited and any(item.max_load is not None for item in layout.items)
        count = len(layout)
        self.planned: FloatArray = np.column_stack([layout.lower, np.zeros(count)])
        sizes, offsets = layout.sizes, layout.mass_offsets
        self.sides: FloatArray = np.stack([sizes, sizes[:, ::-1]])
        self.volumes: FloatArray = sizes.prod(axis=1)
        turned = offsets[:, ::-1] * (1.0, 1.0, -1.0)
        self.given = loading.Boxes(
            self.sides, np.stack([offsets, turned]) + 0.0, layout.weights, self.planned,
            self.volumes,
        )  # fmt: skip

    def __len__(self) -> int:
        return len(self.layout)

    def is_oblong(self, box: int) -> bool:
        """Whether a box is another one when it is turned."""
        width, _, depth = self.layout.items[box].size
        return abs(width - depth) > TOLERANCE

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

    def item(self, box: int, place: Sequence[float] | FloatArray) -> Item:
        """A box at a place; turned, it keeps its contents."""
        own = self.layout.items[box]
        x, y, z, turn = map(float, place)
        if turn == AS_PLANNED:
            return replace(own, position=(x, y, z))
        (width, height, depth), (over_x, over_y, over_z) = own.size, own.mass_offset
        return replace(
            own,
            position=(x, y, z),
            size=(depth, height, width),
            mass_offset=(over_z, over_y, -over_x if over_x else 0.0),
        )

    def centres(self, places: FloatArray) -> FloatArray:
        """Middles of all boxes at their places [cm], shape (J, 3)."""
        turns = places[:, 3].astype(int)
        found: FloatArray = places[:, :3] + 0.5 * self.sides[turns, np.arange(len(places))]
        return found

    def worth(self, places: FloatArray, order: Sequence[int]) -> Worth:
        """The cost of a changed plan.

        Args:
            places: by box, shape (J, 4).
            order: the boxes that are kept, as they are loaded.
        """
        left, volume, moved, distance = self.given.cost(places)
        return Worth(
            left,
            round(volume, 6),
            moved,
            round(distance, 6),
            len(order) - len(kept_in_order(order)),
        )


def kept_in_order(order: Sequence[int]) -> list[int]:
    """A longest part of a sequence in which numbers ascend: the boxes that need no other time."""
    # The smallest last number of a part of each length, and its place in `order`.
    last: list[int] = []
    ends: list[int] = []
    before = [-1] * len(order)
    for place, box in enumerate(order):
        length = bisect_left(last, box)
        before[place] = ends[length - 1] if length else -1
        ends[length : length + 1], last[length : length + 1] = [place], [box]
    found: list[int] = []
    place = ends[-1] if ends else -1
    while place >= 0:
        found.append(order[place])
        place = before[place]
    return found[::-1]

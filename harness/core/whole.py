"""Whole layouts in C, one or many: see steadyload.h."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from steadyload.core.library import (
    FINDING,
    LIBRARY,
    Finding,
    RefusedError,
    array,
    count_of,
    counted,
    ended_well,
    finding,
    own,
    work,
)

FAULT = np.dtype(
    [("layout", "i4"), ("ended", "i4"), ("item", "i4"), ("other", "i4"), ("number", "f8")]
)
"""``sl_fault``."""


class Given:
    """A layout whose arrays are as C takes them, which is looked at once.

    Args:
        lower: see steadyload.h, as all that follow. The arrays are kept.
        upper: likewise.
        weights: likewise.
        offsets: likewise.
        floor: likewise.

    Attributes:
        addresses: the number of boxes and where the arrays are, as functions take them.
    """

    __slots__ = ("_arrays", "addresses")

    def __init__(self, lower: Any, upper: Any, weights: Any, offsets: Any, floor: Any) -> None:
        self._arrays = lower, upper, weights, offsets, floor
        boxes = _boxes(lower, upper, weights, offsets)
        self.addresses = *boxes, array("floor", floor, 5)

    def __len__(self) -> int:
        return self.addresses[0]

    def __reduce__(self) -> tuple[type[Given], tuple[Any, ...]]:
        """Addresses are those of this process."""
        return type(self), self._arrays

    def judge(self, rule: int, alpha: float) -> Finding:
        """The first failure: ``sl_judge``."""
        mine = own()
        ended = LIBRARY.sl_judge(mine.address, rule, alpha, *self.addresses, mine.found_at)
        ended_well(ended, "a layout")
        return finding(mine.found)

    def contacts(self) -> Contacts:
        """Which boxes stand on which, and where: ``sl_contacts``."""
        count, lower, upper, _, _, floor = self.addresses
        mine = own()
        boxes, patches = mine.boxes, mine.patches
        if boxes.size <= count:
            boxes.widen(2 * count + 1)
        while True:
            size = LIBRARY.sl_contacts(
                mine.address, count, lower, upper, floor, *boxes.addresses, patches.size,
                *patches.addresses,
            )  # fmt: skip
            if counted(size, "the contacts of a layout") <= patches.size:
                break
            patches.widen(2 * size)
        on_floor, starts, above_starts = boxes.first(count + 1)
        below, corners, above = patches.first(size)
        return Contacts(
            on_floor[:count], starts, below, corners, above_starts, above[: above_starts[-1]]
        )

    def margin(self, most: float) -> Finding:
        """The margin of balance, as ``number``: ``sl_margin``."""
        mine = own()
        ended_well(
            LIBRARY.sl_margin(mine.address, most, *self.addresses, mine.found_at), "a margin"
        )
        return finding(mine.found)


class GivenMany:
    """Layouts one after the other whose arrays are as C takes them, which are looked at once.

    Args:
        starts: whole numbers, (L + 1,); they do not descend, nor go beyond the boxes.
        lower: see steadyload.h, as all that follow. The arrays are kept.
        upper: likewise.
        weights: likewise.
        offsets: likewise.
        floors: likewise.

    Attributes:
        count: L.
        addresses: the number of layouts and where the arrays are, as functions take them.

    Raises:
        RefusedError: the starts are wrong.
    """

    __slots__ = ("_arrays", "addresses", "count")

    def __init__(
        self, starts: Any, lower: Any, upper: Any, weights: Any, offsets: Any, floors: Any
    ) -> None:
        boxes, *arrays = _boxes(lower, upper, weights, offsets)
        self.count = count_of("starts", starts) - 1
        of_floors = array("floors", floors, self.count, 5)
        whole = _starts(starts, self.count, boxes)
        self._arrays = whole, lower, upper, weights, offsets, floors
        first = array("starts", whole, self.count + 1, kind=np.int32)
        self.addresses = self.count, first, *arrays, of_floors

    def judge(self, rule: int, alpha: float) -> Any:
        """Findings of all layouts, of type :data:`FINDING`, (L,): ``sl_judge_many``."""
        found = np.empty(self.count, FINDING)
        ended = LIBRARY.sl_judge_many(work(), rule, alpha, *self.addresses, found.ctypes.data)
        ended_well(ended, "a batch of layouts")
        return found


class Fault(NamedTuple):
    """Why a layout is none, the first of many that is: ``sl_fault`` of steadyload.h.

    Attributes:
        layout: its number; that of all layouts where there is none.
        ended: :data:`.STANDS` where there is none, :data:`.REFUSED`, :data:`.OUTSIDE` or
            :data:`.OVERLAPS`.
        item: the box, -1 where the layout has none.
        other: the axis along which it is outside, or the earlier box that it overlaps.
        number: by how much [cm].
    """

    layout: int
    ended: int
    item: int
    other: int
    number: float


def first_fault(
    starts: Any,
    lower: Any,
    upper: Any,
    sizes: Any,
    weights: Any,
    offsets: Any,
    limits: Any,
    contours: Any,
) -> Fault:
    """The first layout that is none, and why: ``sl_first_fault``; see steadyload.h.

    Raises:
        RefusedError: the starts are wrong.
    """
    boxes, *corners, heavy, shifted = _boxes(lower, upper, weights, offsets)
    count = count_of("starts", starts) - 1
    whole = _starts(starts, count, boxes)
    found = np.zeros(1, FAULT)
    LIBRARY.sl_first_fault(
        count, array("starts", whole, count + 1, kind=np.int32), *corners,
        array("sizes", sizes, boxes, 3), heavy, shifted, array("limits", limits, 4),
        array("contours", contours, count, 6), found.ctypes.data,
    )  # fmt: skip
    return Fault(*found[0].item())


class Contacts(NamedTuple):
    """Vertical contacts of a layout: see ``sl_contacts``; (J,), (J + 1,) and (P,) or (P, 4)."""

    on_floor: Any
    starts: Any
    below: Any
    patches: Any
    above_starts: Any
    above: Any


def _starts(starts: Any, count: int, boxes: int) -> Any:
    """Where so many layouts begin among so many boxes, as C takes it."""
    if count < 0 or starts.min() < 0 or starts.max() > boxes:
        raise RefusedError("starts of layouts go beyond the boxes")
    whole = np.ascontiguousarray(starts, np.int32)
    if (np.diff(whole) < 0).any():
        raise RefusedError("starts of layouts descend")
    return whole


def _boxes(lower: Any, upper: Any, weights: Any, offsets: Any) -> tuple[int, int, int, int, int]:
    """How many boxes there are, and the addresses of their arrays."""
    count = count_of("lower", lower)
    return (
        count, array("lower", lower, count, 3), array("upper", upper, count, 3),
        array("weights", weights, count), array("offsets", offsets, count, 3),
    )  # fmt: skip

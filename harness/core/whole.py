"""Whole layouts in C, one or many: see steadyload.h and, of margins, searching.h."""

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

SUPPORTED, CARRIED, BALANCED = range(3)
"""Rules: ``sl_rule`` of steadyload.h."""


class Given:
    """A layout whose arrays are as C takes them, which is looked at once.

    Args:
        lower: see steadyload.h, as all that follow. The arrays are kept.
        upper: likewise.
        weights: likewise.
        offsets: likewise.
        floor: likewise.

    Attributes:
        addresses: the number of boxes, and where the arrays are, in this order.
    """

    __slots__ = ("_arrays", "addresses")

    def __init__(self, lower: Any, upper: Any, weights: Any, offsets: Any, floor: Any) -> None:
        self._arrays = lower, upper, weights, offsets, floor
        boxes = _boxes(lower, upper, weights, offsets)
        self.addresses = *boxes, array("floor", floor, 5)

    def __len__(self) -> int:
        return self.addresses[0]

    def __reduce__(self) -> tuple[Any, ...]:
        """A copy has arrays, and so addresses, of its own."""
        return type(self), self._arrays

    def judge(self, rule: int, alpha: float) -> Finding:
        """The first failure: ``sl_judge``."""
        mine = own()
        ended = LIBRARY.sl_judge(mine.address, rule, alpha, *self.addresses, mine.found_at)
        ended_well(ended, "a layout")
        return finding(mine.found)

    def margin(self, most: float) -> Finding:
        """The margin of balance, as ``number``: ``sl_margin``."""
        mine = own()
        ended_well(
            LIBRARY.sl_margin(mine.address, most, *self.addresses, mine.found_at), "a margin"
        )
        return finding(mine.found)


def judge(
    rule: int, alpha: float, lower: Any, upper: Any, weights: Any, offsets: Any, floor: Any
) -> Finding:
    """See :meth:`Given.judge`."""
    return Given(lower, upper, weights, offsets, floor).judge(rule, alpha)


def margin(most: float, lower: Any, upper: Any, weights: Any, offsets: Any, floor: Any) -> Finding:
    """See :meth:`Given.margin`."""
    return Given(lower, upper, weights, offsets, floor).margin(most)


def judge_many(
    rule: int, alpha: float, starts: Any, lower: Any, upper: Any, weights: Any, offsets: Any,
    floors: Any,
) -> Any:  # fmt: skip
    """Findings of many layouts, of type :data:`FINDING`, (L,): ``sl_judge_many``.

    Args:
        rule: see the header.
        alpha: likewise.
        starts: of type int32, (L + 1,); they do not descend, nor go beyond the boxes.
        lower: see the header, as all that follow.
        upper: likewise.
        weights: likewise.
        offsets: likewise.
        floors: likewise.
    """
    (count, *boxes), layouts = (
        _boxes(lower, upper, weights, offsets),
        count_of("starts", starts) - 1,
    )
    first = array("starts", starts, layouts + 1, kind=np.int32)
    of_floors = array("floors", floors, layouts, 5)
    if layouts < 0 or starts[0] < 0 or starts[-1] > count or (np.diff(starts) < 0).any():
        raise RefusedError("starts of layouts descend, or go beyond the boxes")
    found = np.empty(layouts, FINDING)
    ended = LIBRARY.sl_judge_many(
        work(), rule, alpha, layouts, first, *boxes, of_floors, found.ctypes.data
    )
    ended_well(ended, "a batch of layouts")
    return found


def check(lower: Any, upper: Any, weights: Any, offsets: Any, contour: Any) -> int:
    """0 for a layout that has a meaning, else 1 + the first box that is wrong: ``sl_check``."""
    boxes = _boxes(lower, upper, weights, offsets)
    return int(LIBRARY.sl_check(*boxes, array("contour", contour, 6)))


class Contacts(NamedTuple):
    """Vertical contacts of a layout: see ``sl_contacts``; (J,), (J + 1,) and (P,) or (P, 4)."""

    on_floor: Any
    starts: Any
    below: Any
    patches: Any
    above_starts: Any
    above: Any


def contacts(lower: Any, upper: Any, floor: Any) -> Contacts:
    """Which boxes stand on which, and where: ``sl_contacts``."""
    count = count_of("lower", lower)
    given = array("lower", lower, count, 3), array("upper", upper, count, 3)
    at, room = array("floor", floor, 5), 4 * count
    on_floor = np.empty(count, np.bool_)
    starts, above_starts = np.empty((2, count + 1), np.int32)
    whole = on_floor.ctypes.data, starts.ctypes.data, above_starts.ctypes.data
    while True:
        below, patches, above = (
            np.empty(room, np.int32),
            np.empty((room, 4)),
            np.empty(room, np.int32),
        )
        size = LIBRARY.sl_contacts(
            work(), count, *given, at, *whole, room, below.ctypes.data, patches.ctypes.data,
            above.ctypes.data,
        )  # fmt: skip
        if counted(size, "the contacts of a layout") <= room:
            carried = int(above_starts[-1])
            return Contacts(
                on_floor, starts, below[:size], patches[:size], above_starts, above[:carried]
            )
        room = size


def _boxes(lower: Any, upper: Any, weights: Any, offsets: Any) -> tuple[int, int, int, int, int]:
    """How many boxes there are, and the addresses of their arrays."""
    count = count_of("lower", lower)
    return (
        count, array("lower", lower, count, 3), array("upper", upper, count, 3),
        array("weights", weights, count), array("offsets", offsets, count, 3),
    )  # fmt: skip

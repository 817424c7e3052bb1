"""Sentences on an item that stands out of the contour of its pallet, or overlaps another."""

from __future__ import annotations

from steadyload.core.constants import STATED_TOLERANCE
from steadyload.layouts.model.frame import AxisName, Length, Part
from steadyload.layouts.model.item import Item, LayoutError
from steadyload.layouts.model.pallet import Pallet

WITHIN: tuple[Part, ...] = (" (+-", Length(STATED_TOLERANCE, bare=True), ")")
"""Parts of a message, after lengths: how far off they may be."""


def outside_error(item: Item, pallet: Pallet, axis: int, span: tuple[float, float]) -> LayoutError:
    """Error message for an item that stands out of the pallet's contour along an axis."""
    low, high = (corner[axis] for corner in pallet.contour)
    over: tuple[Part, ...] = (": up to ", Length(pallet.overhang), " over the edge of the deck")
    parts = ("; allowed: inside the pallet's contour, ", *from_to(low, high), *WITHIN)
    return LayoutError(
        "spans ", AxisName(axis), " = ", *from_to(*span), *parts, *(over if low else ()),
        item=str(item),
    )  # fmt: skip


def overlap_error(item: Item, other: Item, depth: float) -> LayoutError:
    """Error message for an item that overlaps one placed before it, by a depth [cm]."""
    return LayoutError(
        f"overlaps {other} by ", Length(depth), " or more along every axis; allowed: at most ",
        Length(STATED_TOLERANCE), item=str(item),
    )  # fmt: skip


def from_to(low: float, high: float) -> tuple[Part, ...]:
    """Parts of a message: from one length [cm] to another."""
    return (Length(low, bare=True), " to ", Length(high))

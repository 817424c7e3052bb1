"""Which items make a valid layout, on arrays; and the sentences on those that do not."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from steadyload.core import whole
from steadyload.core.constants import OUTSIDE, STANDS, STATED_TOLERANCE
from steadyload.layouts.model.checks import FloatArray
from steadyload.layouts.model.frame import AxisName, Length, Part
from steadyload.layouts.model.item import SIDES, WEIGHTS, Item, LayoutError
from steadyload.layouts.model.pallet import Pallet

_LIMITS = np.array([*SIDES, *WEIGHTS])

WITHIN: tuple[Part, ...] = (" (+-", Length(STATED_TOLERANCE, bare=True), ")")
"""Parts of a message, after lengths: how far off they may be."""


def first_fault(
    starts: NDArray[np.int64], arrays: Mapping[str, FloatArray], contours: FloatArray
) -> whole.Fault | None:
    """Why the first of some layouts that is not valid is not; None where all are.

    A layout has one item or more, each of whose numbers an :class:`Item` may have, which stands out
    of the contour by at most :data:`TOLERANCE`; and no two overlap by more along every axis.

    Args:
        starts: the items of layout k are ``starts[k]`` to ``starts[k + 1]``, shape (L + 1,).
        arrays: the arrays of all items, by name, of shapes that fit together.
        contours: opposite corners of the space that they must stay in [cm], shape (L, 6).
    """
    found = whole.first_fault(
        starts,
        arrays["lower"],
        arrays["upper"],
        arrays["sizes"],
        arrays["weights"],
        arrays["mass_offsets"],
        _LIMITS,
        contours,
    )
    return None if found.ended == STANDS else found


def misplaced(
    items: Sequence[Item], arrays: Mapping[str, FloatArray], pallet: Pallet
) -> LayoutError | None:
    """The error of items that do not fit on a pallet, or overlap; None where they may be so.

    Args:
        items: one or more.
        arrays: their numbers, as :func:`arrays_of` has them.
        pallet: under them.
    """
    contour = np.array(pallet.contour).reshape(1, 6)
    found = first_fault(np.array([0, len(items)]), arrays, contour)
    if found is None:
        return None
    item = items[found.item]
    if found.ended == OUTSIDE:
        return _outside(item, pallet, found.other)
    return LayoutError(
        f"overlaps {items[found.other]} by ", Length(found.number), " or more along every axis; "
        "allowed: at most ", Length(STATED_TOLERANCE), item=str(item),
    )  # fmt: skip


def arrays_of(items: Sequence[Item]) -> dict[str, FloatArray]:
    """The read-only arrays of a layout of some items, by name."""
    lower = np.array([i.position for i in items], dtype=float)
    sizes = np.array([i.size for i in items], dtype=float)
    arrays = {
        "lower": lower,
        "upper": lower + sizes,
        "sizes": sizes,
        "weights": np.array([i.weight for i in items], dtype=float),
        "mass_offsets": np.array([i.mass_offset for i in items], dtype=float),
    }
    for array in arrays.values():
        array.setflags(write=False)
    return arrays


def _outside(item: Item, pallet: Pallet, axis: int) -> LayoutError:
    low, high = (corner[axis] for corner in pallet.contour)
    span = item.position[axis], item.position[axis] + item.size[axis]
    over: tuple[Part, ...] = (": up to ", Length(pallet.overhang), " over the edge of the deck")
    parts = ("; allowed: inside the pallet's contour, ", *from_to(low, high), *WITHIN)
    return LayoutError(
        "spans ", AxisName(axis), " = ", *from_to(*span), *parts, *(over if low else ()),
        item=str(item),
    )  # fmt: skip


def from_to(low: float, high: float) -> tuple[Part, ...]:
    """Parts of a message: from one length [cm] to another."""
    return (Length(low, bare=True), " to ", Length(high))

"""Vertical balance: can contacts that only push hold every item against its weight?

A contact patch of two axis-aligned boxes is a rectangle. Whatever the pressure on it, its resultant
lies in the rectangle, and every resultant in the rectangle is a non-negative combination of forces
at the four corners: forces at corners are no approximation. Every item asks for three equations
(weight, and the moments about the two horizontal axes through its centre of mass).

Two things keep the work small. An item with all of its base on the floor needs no equation: its
own weight and all that stands on it press inside its base, which is its patch. (One that overhangs
an edge of the floor has its equation, as if it stood on another item.) And placing an item adds
load to what lies below it only: if the forces found before, with the new load passed down one way,
still balance, that is a proof. Only when this way fails are forces solved for, among the items
joined to the new one by standing on each other.

What is left over of the equations, which are weighed by mass and inertia, is the acceleration with
which the group starts to move if contacts push vertically only (Gauss' principle of least
constraint). Whether it is more than rounding: see :mod:`steadyload.statics.resolution`.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from steadyload.core.constants import EDGE, UNRESOLVED
from steadyload.core.timed import Held, closest_to_balance
from steadyload.layouts.model.contacts import Patch
from steadyload.layouts.model.layout import Arrangement, FloatArray
from steadyload.statics.resolution import unresolved

VERSION = 1
"""Of balance, friction and who touches: raised when they come to other verdicts."""

DRAWN_IN = 1
"""Of balance with patches that are drawn in: likewise."""


def inset(layout: Arrangement, items: int | slice) -> FloatArray:
    """How far inside its base a centre of mass lies [cm], negative outside; shape () or (n,).

    Args:
        layout: any layout.
        items: one item, or several.
    """
    half = 0.5 * (layout.upper[items] - layout.lower[items])[..., ::2]
    found: FloatArray = (half - np.abs(layout.mass_offsets[items][..., ::2])).min(axis=-1)
    return found


class Solution(NamedTuple):
    """The forces that come closest to balance.

    Attributes:
        forces: at the corners (x0, z0), (x0, z1), (x1, z0), (x1, z1) of every patch [kg], (k, 4).
        ended: ``STANDS``, ``FAILS``, or ``UNRESOLVED`` where rounding hides which.
        item: the one that starts fastest, -1 where none does.
    """

    forces: FloatArray
    ended: int
    item: int


def solve(
    layout: Arrangement, items: Sequence[int], patches: Sequence[Patch], grow: float = EDGE
) -> Solution:
    """Non-negative forces that balance a group of items, or the closest to it.

    Args:
        layout: with the items.
        items: the group.
        patches: contacts; a ``below`` outside the group is as firm as the floor.
        grow: how much wider every patch counts on each side [cm]; negative shrinks, and drops what
            becomes narrower than nothing.

    Raises:
        RuntimeError: the search did not end.
    """
    table = np.array(patches, dtype=np.float64).reshape(-1, 6)
    kept = np.flatnonzero((table[:, 4:] - table[:, 2:4]).min(axis=1) >= -2.0 * grow)
    used = np.column_stack((kept, table[kept, 1], table[kept, 0])).astype(np.int32)
    found = closest_to_balance(
        layout.given, np.array(items, dtype=np.int32), used, table[:, 2:].copy(), grow
    )
    if not found.is_found:
        raise RuntimeError("the search for contact forces did not end")
    forces = np.zeros((len(patches), 4))
    forces[kept] = found.forces
    return Solution(forces, found.ended, found.item)


class VerticalBalance:
    """Balance of a layout's items, step by step, whatever came of the steps before.

    Forces are solved for of whole groups.

    Args:
        layout: any layout.
        margin: by which contact patches are drawn in on every side [cm].
    """

    def __init__(self, layout: Arrangement, margin: float = 0.0) -> None:
        self._weights = layout.weights
        self._held = Held(layout.given, margin)

    def place(self, step: int) -> int | None:
        """Place an item; the item whose balance cannot be met, or None when all stand.

        Args:
            step: the new item. All items before it must have been placed, whatever came of it.

        Raises:
            UnresolvedError: balance cannot be told from rounding; nothing has changed.
        """
        ended, item = self._held.place(step)
        if ended == UNRESOLVED:
            raise unresolved(self._weights[self.group(step)])
        return None if item < 0 else item

    def group(self, step: int) -> list[int]:
        """Items joined to the one placed last by standing on each other, floor items left out."""
        found: list[int] = self._held.group(step).tolist()
        return found

"""Places that a box may be let down to: a grid over the deck, and two ways to turn the box."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from steadyload.core.constants import TOLERANCE
from steadyload.layouts.model.layout import FloatArray, Item, Pallet


def grid_of(pallet: Pallet, cell: float) -> FloatArray:
    """Lower corners (x, z) of the cells of a deck [cm], shape (X, Z, 2).

    The last ones may be cut by the edges of the deck.

    Args:
        pallet: with the deck.
        cell: side of a cell [cm].
    """
    x = np.arange(0.0, pallet.width - TOLERANCE, cell)
    z = np.arange(0.0, pallet.depth - TOLERANCE, cell)
    return np.stack(np.meshgrid(x, z, indexing="ij"), axis=2)


def turned(item: Item) -> Item:
    """An item turned by a quarter about the vertical axis, its centre of mass with it."""
    width, height, depth = item.size
    x, y, z = item.mass_offset
    return replace(item, size=(depth, height, width), mass_offset=(z, y, -x))


def heights_over(corners: FloatArray, size: FloatArray, lower: FloatArray, upper: FloatArray) -> (
    FloatArray
):  # fmt: skip
    """Height of the highest top under each of some rectangles [cm], 0 where there is none.

    Args:
        corners: lower corners of the rectangles, (x, z) [cm], shape (..., 2).
        size: their sides along x and z [cm], shape (2,).
        lower: corners of the items, (x, y, z) [cm], shape (J, 3).
        upper: likewise.
    """
    if not len(lower):
        return np.zeros(corners.shape[:-1])
    ends = corners + size
    shared = np.minimum(upper[:, ::2], ends[..., None, :]) - np.maximum(
        lower[:, ::2], corners[..., None, :]
    )
    over = (shared > TOLERANCE).all(axis=-1)
    found: FloatArray = np.where(over, upper[:, 1], 0.0).max(axis=-1)
    return found

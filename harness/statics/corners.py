"""Vertical forces at the corners of contact patches, as columns of equations of balance."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from steadyload.layouts.model.contacts import Patch
from steadyload.layouts.model.layout import FloatArray


def corner_columns(
    items: Sequence[int], patches: Sequence[Patch], centres: FloatArray, grow: float
) -> FloatArray:
    """Forces and moments that unit forces at the corners of patches exert on every item of a group.

    Args:
        items: the group, as indices into the arrays.
        patches: contacts, one or more.
        centres: centres of mass of all items (x, y, z) [cm], (J, 3).
        grow: how much wider every patch counts on each side [cm].

    Returns:
        Force and its moments about the axes through the item's centre of mass (force times x, force
        times z) [1, cm, cm], shape (n, 3, 4 k), four columns a patch in the order of
        ``(x0, z0), (x0, z1), (x1, z0), (x1, z1)``.
    """
    table = np.array(patches)
    at, who, values = corner_entries(items, table[:, :2].astype(int), table[:, 2:], centres, grow)
    columns = np.zeros((len(items), 3, len(patches), 4))
    columns[who, :, at] = values
    return columns.reshape(len(items), 3, -1)


def corner_entries(
    items: Sequence[int],
    pairs: NDArray[np.int64],
    rectangles: FloatArray,
    centres: FloatArray,
    grow: float,
) -> tuple[NDArray[np.int64], NDArray[np.int64], FloatArray]:
    """The part of :func:`corner_columns` that is not zero: at most two boxes a patch.

    Args:
        items: see there.
        pairs: the lower and the upper item of every patch, shape (k, 2).
        rectangles: ``(x0, z0, x1, z1)`` of every patch [cm], shape (k, 4).
        centres: see there.
        grow: likewise.

    Returns:
        The patch, the place of the item in the group, and force and moments at the four corners,
        shape (e, 3, 4).
    """
    place = np.full(len(centres) + 1, -1)  # the last for the floor
    place[list(items)] = np.arange(len(items))
    low, high = rectangles[:, :2] - grow, rectangles[:, 2:] + grow
    x = np.stack((low[:, 0], low[:, 0], high[:, 0], high[:, 0]), axis=1)
    z = np.stack((low[:, 1], high[:, 1], low[:, 1], high[:, 1]), axis=1)
    found = []
    for side, sign in ((1, 1.0), (0, -1.0)):
        member = place[pairs[:, side]]
        at = np.flatnonzero(member >= 0)
        centre = centres[pairs[at, side]]
        values = np.empty((len(at), 3, 4))
        values[:, 0] = sign
        values[:, 1] = sign * (x[at] - centre[:, :1])
        values[:, 2] = sign * (z[at] - centre[:, 2:])
        found.append((at, member[at], values))
    at, who, values = (np.concatenate(parts) for parts in zip(*found, strict=True))
    return at, who, values

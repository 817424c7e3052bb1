"""Vertical forces at the corners of contact patches, as columns of equations of balance."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from steadyload.layouts.contacts import Patch
from steadyload.layouts.model import FloatArray


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
    row = {item: k for k, item in enumerate(items)}
    table = np.array(patches)
    low, high = table[:, 2:4] - grow, table[:, 4:6] + grow
    x = np.stack((low[:, 0], low[:, 0], high[:, 0], high[:, 0]), axis=1)
    z = np.stack((low[:, 1], high[:, 1], low[:, 1], high[:, 1]), axis=1)
    columns = np.zeros((len(items), 3, len(patches), 4))
    for name, sign in (("above", 1.0), ("below", -1.0)):
        member = np.array([row.get(getattr(p, name), -1) for p in patches])
        at = np.flatnonzero(member >= 0)
        who = member[at]
        centre = centres[[items[k] for k in who]]
        columns[who, 0, at] = sign
        columns[who, 1, at] = sign * (x[at] - centre[:, :1])
        columns[who, 2, at] = sign * (z[at] - centre[:, 2:])
    return columns.reshape(len(items), 3, -1)

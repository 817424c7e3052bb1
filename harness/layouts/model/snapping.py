"""Closing the slits that real data leave under items."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from steadyload.layouts.model.layout import TOLERANCE, Layout, replace_items
from steadyload.numbers import number_within

SNAP_GAP = 0.5
"""Vertical gaps up to this [cm] are closed unless another limit is given."""


def snap(layout: Layout, gap: float = SNAP_GAP) -> Layout:
    """Lower items onto what lies just below them.

    Real data leave slits of some millimetres under an item, which a geometric rule reads as "no
    support". From the bottom up, an item whose slit is at most ``gap`` [cm] follows the highest top
    face (or the floor) that lies below it in plan; slits of a whole stack are closed, however high
    it is. An item with a wider gap stays where it is.

    Raises:
        NumberError: the gap is no finite number, 0 or more.
    """
    gap = number_within("gap", gap, 0.0, unit="[cm]")
    lower, upper = layout.lower.copy(), layout.upper.copy()
    height = layout.upper[:, 1] - layout.lower[:, 1]
    floor = layout.floor
    over = np.minimum(upper[:, ::2], floor.high) - np.maximum(lower[:, ::2], floor.low)
    floors = np.where(over.min(axis=1) > TOLERANCE, 0.0, -np.inf)
    for index in np.argsort(layout.lower[:, 1], kind="stable"):
        shared = np.minimum(upper, upper[index]) - np.maximum(lower, lower[index])
        below = (shared[:, ::2] > TOLERANCE).all(axis=1)
        below &= layout.upper[:, 1] <= layout.lower[index, 1] + TOLERANCE
        slit = layout.lower[index, 1] - layout.upper[below, 1].max(initial=floors[index])
        if slit <= gap:
            lower[index, 1] = min(lower[index, 1], upper[below, 1].max(initial=floors[index]))
            upper[index, 1] = lower[index, 1] + height[index]
    items = tuple(
        replace(item, position=(item.position[0], float(y), item.position[2]))
        for item, y in zip(layout.items, lower[:, 1], strict=True)
    )
    return replace_items(layout, items)

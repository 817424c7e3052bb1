"""Closing the slits that real data leave under items."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from harness.layouts.model import TOLERANCE, Item, Layout, replace_items

SNAP_GAP = 0.5
"""Vertical gaps up to this [cm] are closed unless another limit is given."""


def snap(layout: Layout, gap: float = SNAP_GAP) -> Layout:
    """Lower items, in loading order, onto what lies just below them.

    Real data leave slits of some millimetres under an item, which a geometric rule reads as "no
    support". An item moves down by at most ``gap`` [cm], onto the highest top face (or the floor)
    that it overlaps in plan; an item that finds nothing that close stays where it is.
    """
    items: list[Item] = []
    lower, upper = layout.lower.copy(), layout.upper.copy()
    for index, item in enumerate(layout.items):
        below = np.minimum(upper[:index], upper[index]) - np.maximum(lower[:index], lower[index])
        tops = upper[:index, 1][(below[:, ::2] > TOLERANCE).all(axis=1)]
        tops = tops[tops <= lower[index, 1] + TOLERANCE]
        drop = lower[index, 1] - max([0.0, *tops.tolist()])
        if 0.0 < drop <= gap:
            lower[index, 1] -= drop
            upper[index, 1] -= drop
            x, _, z = item.position
            item = replace(item, position=(x, float(lower[index, 1]), z))
        items.append(item)
    return replace_items(layout, tuple(items))

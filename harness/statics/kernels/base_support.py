"""Full and partial base support: the first item of which too little rests on something."""

from __future__ import annotations

from typing import Any

import numpy as np

from steadyload.statics.kernels.compiled import compiled
from steadyload.statics.kernels.constants import ROUNDING, TOLERANCE

_PLACES = 16
"""Patches under one item that have room at first."""


@compiled
def first_with_little_support(lower: Any, upper: Any, floor: Any, alpha: float) -> Any:
    """The first item of which less than a share of the base rests on earlier ones or the floor.

    Slivers that are bare and narrower than the tolerance count as supported.

    Args:
        lower: see :mod:`steadyload.statics.kernels`.
        upper: likewise.
        floor: likewise, shape (5,).
        alpha: the share that is required.

    Returns:
        The item and its share; the number of items and 1 where every item has enough.
    """
    count = len(lower)
    patches = np.empty((_PLACES, 4))
    for j in range(count):
        x0, y0, z0, x1, z1 = lower[j, 0], lower[j, 1], lower[j, 2], upper[j, 0], upper[j, 2]
        at_edge = False
        if y0 <= TOLERANCE:
            if floor[4] == 0.0:
                continue
            out = max(max(floor[0] - x0, floor[1] - z0), max(x1 - floor[2], z1 - floor[3]))
            if out <= TOLERANCE:
                continue
            at_edge = True
        area, found = 0.0, 0
        for i in range(j):
            if abs(upper[i, 1] - y0) <= TOLERANCE:
                a, c = max(lower[i, 0], x0), min(upper[i, 0], x1)
                b, d = max(lower[i, 2], z0), min(upper[i, 2], z1)
                if min(c - a, d - b) > TOLERANCE:
                    area += (c - a) * (d - b)
                    if found == len(patches):
                        patches = np.concatenate((patches, np.empty_like(patches)))
                    patches[found, 0], patches[found, 1] = a, b
                    patches[found, 2], patches[found, 3] = c, d
                    found += 1
        if at_edge:
            a, c = max(floor[0], x0), min(floor[2], x1)
            b, d = max(floor[1], z0), min(floor[3], z1)
            if min(c - a, d - b) > TOLERANCE:
                area += (c - a) * (d - b)
                if found == len(patches):
                    patches = np.concatenate((patches, np.empty_like(patches)))
                patches[found, 0], patches[found, 1] = a, b
                patches[found, 2], patches[found, 3] = c, d
                found += 1
        share = area / ((x1 - x0) * (z1 - z0))
        if share < alpha - ROUNDING and not covered(x0, z0, x1, z1, patches[:found]):
            return j, share
    return count, 1.0


@compiled
def first_with_little_support_of_many(
    lower: Any, upper: Any, floors: Any, starts: Any, alpha: float
) -> Any:
    """Results of :func:`first_with_little_support` for every layout of a batch, shape (L,)."""
    count = len(starts) - 1
    steps, shares = np.empty(count, dtype=np.int64), np.empty(count)
    for k in range(count):
        part = slice(starts[k], starts[k + 1])
        steps[k], shares[k] = first_with_little_support(lower[part], upper[part], floors[k], alpha)
    return steps, shares


@compiled
def covered(x0: float, z0: float, x1: float, z1: float, patches: Any) -> bool:
    """True if nothing of a base is bare but slivers narrower than the tolerance.

    Such slivers come from rounding in a file; they count as supported, whatever their area.

    Args:
        x0: of the base [cm], as the next three.
        z0: see there.
        x1: see there.
        z1: see there.
        patches: x0, z0, x1, z1 of what it stands on [cm], shape (k, 4).
    """
    area = 0.0
    for p in patches:
        area += (p[2] - p[0]) * (p[3] - p[1])
    around = (x1 - x0) + (z1 - z0)
    if (x1 - x0) * (z1 - z0) - area > TOLERANCE * 2.0 * around * (len(patches) + 1):
        return False
    # Every contact rectangle grown by half the tolerance; then no cell of the base may be bare.
    half = TOLERANCE / 2.0
    xs = _cuts(patches[:, 0] - half, patches[:, 2] + half, x0 + half, x1 - half)
    zs = _cuts(patches[:, 1] - half, patches[:, 3] + half, z0 + half, z1 - half)
    for a in range(len(xs) - 1):
        x = 0.5 * (xs[a + 1] + xs[a])
        for b in range(len(zs) - 1):
            z = 0.5 * (zs[b + 1] + zs[b])
            bare = True
            for p in patches:
                if p[0] - half < x < p[2] + half and p[1] - half < z < p[3] + half:
                    bare = False
                    break
            if bare and xs[a + 1] > xs[a] and zs[b + 1] > zs[b]:
                return False
    return True


@compiled
def _cuts(low: Any, high: Any, first: float, last: float) -> Any:
    """Ends of intervals in ascending order, within a span that is among them."""
    cuts = np.concatenate((low, high, np.array([first, last])))
    for k in range(len(cuts)):
        cuts[k] = min(max(cuts[k], first), last)
    return np.sort(cuts)

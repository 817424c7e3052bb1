"""Convex hulls of a few points of the plane, and whether a point lies inside."""

from __future__ import annotations

from typing import Any

import numpy as np

from steadyload.statics.kernels.compiled import compiled


@compiled
def strictly_inside_hull(x: float, z: float, points: Any, least: float) -> bool:
    """True if a point lies strictly inside the convex hull of others.

    Args:
        x: of the point [cm].
        z: likewise.
        points: (x, z) [cm], shape (k, 2).
        least: the cross product of every edge and the way to the point must exceed this [cm2].
    """
    hull = convex_hull(points)
    count = len(hull)
    if count < 3:
        return False
    for k in range(count):
        ax, az = hull[k]
        bx, bz = hull[(k + 1) % count]
        if not (bx - ax) * (z - az) - (bz - az) * (x - ax) > least:
            return False
    return True


@compiled
def convex_hull(points: Any) -> Any:
    """Corners of the convex hull, counter-clockwise, shape (h, 2)."""
    ordered = _ordered(points)
    count = len(ordered)
    line = np.empty((2 * count + 1, 2))
    size = hull_of(ordered[:, 0], ordered[:, 1], count, line[:, 0], line[:, 1], 0.0)
    return line[:size]


@compiled
def hull_of(xs: Any, zs: Any, count: int, hx: Any, hz: Any, least: float) -> int:
    """The number of corners of a convex hull, counter-clockwise (Andrew's monotone chain).

    Args:
        xs: of points sorted by x, then by z [cm].
        zs: of the same points.
        count: of the points.
        hx: the corners are put there, room for 2 count + 1.
        hz: likewise.
        least: the cross product of two edges at a corner must exceed this [cm2].
    """
    size = 0
    for way in range(2):
        begin = size
        for step in range(count):
            k = step if way == 0 else count - 1 - step
            while size - begin > 1:
                cross = (hx[size - 1] - hx[size - 2]) * (zs[k] - hz[size - 2]) - (
                    hz[size - 1] - hz[size - 2]
                ) * (xs[k] - hx[size - 2])
                if cross > least:
                    break
                size -= 1
            hx[size], hz[size] = xs[k], zs[k]
            size += 1
        size -= 1  # it begins the other way, or stands there already
    return size


@compiled
def _ordered(points: Any) -> Any:
    """Points by x, then by z, each once."""
    ordered = points.copy()
    size = 0
    for k in range(len(points)):
        x, z = points[k]
        at = size
        while at and (
            ordered[at - 1, 0] > x or (ordered[at - 1, 0] == x and ordered[at - 1, 1] > z)
        ):
            at -= 1
        if at and ordered[at - 1, 0] == x and ordered[at - 1, 1] == z:
            continue
        for later in range(size, at, -1):
            ordered[later, 0], ordered[later, 1] = ordered[later - 1, 0], ordered[later - 1, 1]
        ordered[at, 0], ordered[at, 1] = x, z
        size += 1
    return ordered[:size]

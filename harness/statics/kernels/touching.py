"""Points where an item touches others, or soon may: on tops and bases, and on faces at sides."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from steadyload.statics.kernels.compiled import compiled
from steadyload.statics.kernels.constants import FLOOR, TOLERANCE


class Points(NamedTuple):
    """Corners of contact patches, and of patches that close when a gap does; room for more.

    Attributes:
        pairs: the two bodies, items or :data:`~steadyload.statics.kernels.constants.FLOOR`, shape
        (K, 2). axes: of the normals, which point from the first body to the second, shape (K,).
        planned: (x, y, z) [cm] while all items are where they were planned, shape (K, 3).
        gaps: how far the faces are apart there now [cm], shape (K,).
    """

    pairs: Any
    axes: Any
    planned: Any
    gaps: Any


@compiled
def room_for_points(count: int) -> Points:
    """Room for so many points."""
    return Points(
        np.empty((count, 2), dtype=np.int64),
        np.empty(count, dtype=np.int64),
        np.empty((count, 3)),
        np.empty(count),
    )


@compiled
def with_points_of(
    points: Points, count: int, item: int, step: int, listed: Any, lower: Any, upper: Any,
    floor: Any, reach: float,
) -> Any:  # fmt: skip
    """Points, with those of one item.

    Args:
        points: so far.
        count: number of points so far.
        item: whose points are added.
        step: later items are not there.
        listed: items whose points are there already, shape (J,).
        lower: corners [cm], shape (J, 3).
        upper: likewise.
        floor: see :mod:`steadyload.statics.kernels`.
        reach: gaps up to this are listed [cm].

    Returns:
        The points and their number.
    """
    room = count + 4 * (step + 3)
    if room > len(points.axes):
        more = room_for_points(2 * room)
        for k in range(count):
            more.pairs[k], more.axes[k] = points.pairs[k], points.axes[k]
            more.planned[k], more.gaps[k] = points.planned[k], points.gaps[k]
        points = more
    low, high = np.empty(3), np.empty(3)
    for surface in range(2 if floor[4] > 0.0 else 1):
        level = -floor[4] if surface == 1 else 0.0
        gap = lower[item, 1] - level
        for c in range(3):
            low[c], high[c] = lower[item, c], upper[item, c]
        if surface == 0:
            low[0], low[2] = max(low[0], floor[0]), max(low[2], floor[1])
            high[0], high[2] = min(high[0], floor[2]), min(high[2], floor[3])
        if gap <= reach and min(high[0] - low[0], high[2] - low[2]) > TOLERANCE:
            count = _with_corners(points, count, FLOOR, item, 1, low, high, level, gap)
    for other in range(step + 1):
        if other == item or listed[other]:
            continue
        wide = 0
        axis = -1
        for c in range(3):
            low[c] = max(lower[item, c], lower[other, c])
            high[c] = min(upper[item, c], upper[other, c])
            if high[c] - low[c] > TOLERANCE:
                wide += 1
            else:
                axis = c
        if wide != 2:
            continue
        is_first = lower[other, axis] + upper[other, axis] > lower[item, axis] + upper[item, axis]
        first, second = (item, other) if is_first else (other, item)
        level = upper[first, axis]
        gap = lower[second, axis] - level
        if -TOLERANCE <= gap <= reach:
            count = _with_corners(points, count, first, second, axis, low, high, level, gap)
    return points, count


@compiled
def _with_corners(
    points: Points, count: int, first: int, second: int, axis: int, low: Any, high: Any,
    level: float, gap: float,
) -> int:  # fmt: skip
    """Put the four corners of a patch behind the points; their number then."""
    one, two = (1, 2) if axis == 0 else ((0, 2) if axis == 1 else (0, 1))
    for corner in range(4):
        k = count + corner
        points.pairs[k, 0], points.pairs[k, 1] = first, second
        points.axes[k], points.gaps[k] = axis, max(gap, 0.0)
        points.planned[k, axis] = level
        points.planned[k, one] = low[one] if corner < 2 else high[one]
        points.planned[k, two] = low[two] if corner % 2 == 0 else high[two]
    return count + 4

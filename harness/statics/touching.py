"""Points where items touch, or soon may: on tops and bases, and on the faces at their sides."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from steadyload.engines.attitudes import cross
from steadyload.layouts.model.floor import Surface
from steadyload.layouts.model.layout import TOLERANCE, Arrangement, FloatArray

Indices = NDArray[np.intp]

_Corners = tuple[Indices, Indices, FloatArray, Indices, FloatArray]
"""The fields of :class:`Points`."""

FIRM = -1
"""Index of the floor and of items that do not move, in place of a body."""


@dataclass(frozen=True, slots=True)
class Points:
    """Corners of contact patches, and of patches that close when a gap does.

    Attributes:
        first, second: the two bodies, as places in the list of items or :data:`FIRM`, shape (k,).
        positions: (x, y, z) [cm], shape (k, 3).
        axes: axis of the normal, 0, 1 or 2, which points from the first body to the second; 1 for
            tops and bases, shape (k,).
        gaps: how far the faces are apart [cm], 0 where they touch, shape (k,).
    """

    first: Indices
    second: Indices
    positions: FloatArray
    axes: Indices
    gaps: FloatArray

    def __len__(self) -> int:
        return len(self.axes)


def touching_points(
    layout: Arrangement,
    items: Sequence[int],
    firm: Sequence[int] = (),
    *,
    reach: float = TOLERANCE,
    grow: float = 0.0,
) -> Points:
    """All points of a group of items, with each other, with the floor and with firm items.

    Args:
        layout: any layout.
        items: the group.
        firm: items that touch the group and do not move.
        reach: gaps up to this are listed [cm].
        grow: how much wider every patch counts on each side [cm].
    """
    order = [*items, *firm]
    lower, upper = layout.lower[order], layout.upper[order]
    n = len(items)
    low, high = np.maximum(lower[:, None], lower[None]), np.minimum(upper[:, None], upper[None])
    shared = high - low > TOLERANCE
    found = [
        _on_surface(surface, lower[:n], upper[:n], reach, grow)
        for surface in layout.floor.surfaces()
    ]
    for axis in range(3):
        one, two = (a for a in range(3) if a != axis)
        gap = lower[None, :, axis] - upper[:, None, axis]
        met = shared[:, :, one] & shared[:, :, two] & (gap >= -TOLERANCE) & (gap <= reach)
        met[n:, n:] = False
        at = first, second = np.nonzero(met)
        found.append(
            _corners(axis, first, second, gap[at], low[at] - grow, high[at] + grow,
                     upper[first, axis])
        )  # fmt: skip
    first, second, positions, axes, gaps = (np.concatenate(p) for p in zip(*found, strict=True))
    return Points(
        np.where(first < n, first, FIRM),
        np.where(second < n, second, FIRM),
        positions,
        axes,
        np.maximum(gaps, 0.0),
    )


def _on_surface(
    surface: Surface, lower: FloatArray, upper: FloatArray, reach: float, grow: float
) -> _Corners:
    """The corners of items' patches on the floor, or on the ground."""
    low, high = lower.copy(), upper.copy()
    low[:, ::2] = np.maximum(lower[:, ::2], surface.low)
    high[:, ::2] = np.minimum(upper[:, ::2], surface.high)
    gap = lower[:, 1] - surface.level
    above = (high - low)[:, ::2].min(axis=1) > TOLERANCE
    stands = np.flatnonzero((gap <= reach) & above)
    firm, level = np.full(len(stands), FIRM), np.full(len(stands), surface.level)
    return _corners(1, firm, stands, gap[stands], low[stands] - grow, high[stands] + grow, level)


def _corners(
    axis: int,
    first: Indices,
    second: Indices,
    gap: FloatArray,
    low: FloatArray,
    high: FloatArray,
    level: FloatArray,
) -> _Corners:
    """The four corners of every patch, as the fields of :class:`Points`."""
    one, two = (a for a in range(3) if a != axis)
    four = np.empty((len(first), 4, 3))
    four[:, :, axis] = level[:, None]
    for k, (a, b) in enumerate(((low, low), (low, high), (high, low), (high, high))):
        four[:, k, one], four[:, k, two] = a[:, one], b[:, two]
    return (
        np.repeat(first, 4),
        np.repeat(second, 4),
        four.reshape(-1, 3),
        np.full(4 * len(first), axis),
        np.repeat(gap, 4),
    )


def directions(axes: Indices, friction: FloatArray, facets: int) -> tuple[Indices, FloatArray]:
    """Forces that span the friction cone of every point.

    Args:
        axes: axis of every point's normal, shape (k,).
        friction: Coulomb coefficient of every point, shape (k,).
        facets: a cone is replaced by the pyramid with this many edges on it, 3 or more.

    Returns:
        The point of every direction and the directions on the second body, normal part 1.
    """
    smooth = friction == 0.0
    angles = 2.0 * np.pi * np.arange(facets) / facets
    rough = np.flatnonzero(~smooth)
    point = np.concatenate((np.flatnonzero(smooth), np.repeat(rough, facets)))
    force = np.zeros((len(point), 3))
    force[np.arange(len(point)), axes[point]] = 1.0
    start = int(smooth.sum())
    around = np.arange(start, len(point))
    slope = np.repeat(friction[rough], facets)
    force[around, (axes[point[start:]] + 1) % 3] = slope * np.tile(np.cos(angles), len(rough))
    force[around, (axes[point[start:]] + 2) % 3] = slope * np.tile(np.sin(angles), len(rough))
    return point, force


def wrenches(
    points: Points,
    positions: FloatArray,
    centres: FloatArray,
    point: Indices,
    force: FloatArray,
) -> FloatArray:
    """Wrenches of unit forces on every body: force and moment about its centre, shape (n, 6, m).

    Args:
        points: the contacts.
        positions: where they are now [cm], shape (k, 3).
        centres: centres of mass of the group [cm], shape (n, 3).
        point: the point at which each force acts, shape (m,).
        force: on the second body; the first feels its opposite, shape (m, 3).
    """
    result = np.zeros((len(centres), 6, len(point)))
    for body, sign in ((points.second[point], 1.0), (points.first[point], -1.0)):
        column = np.flatnonzero(body != FIRM)
        who = body[column]
        lever = positions[point[column]] - centres[who]
        result[who, :3, column] += sign * force[column]
        result[who, 3:, column] += sign * cross(lever, force[column])
    return result

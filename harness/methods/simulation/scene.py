"""Scene of a layout for a physics engine: boxes in metres, z up, and no more than needed."""

from __future__ import annotations

import zlib
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from steadyload.engines.world import Box, Poses
from steadyload.layouts.model.layout import TOLERANCE, Arrangement, FloatArray

VERSION = 1
"""Of boxes, groups and neighbourhoods: raised when engines are given others."""

CM = 0.01
"""Metres in a centimetre."""

_NEAR = 4096.0
"""Worlds have their origin at multiples of this [cm]: a power of two, by which nothing is rounded.
No item of a pallet of usual size is shifted."""

Across = Literal["width", "depth"]
"""A horizontal axis of the layout, the one that becomes the world's y."""

_UPRIGHT: tuple[tuple[int, int], ...] = ((2, 1), (0, 1), (1, 1))
"""World (x, y, z) = layout (z, x, y): z up instead of y up, by a rotation, not a mirror. Each pair
is a layout axis and its sign."""

_ALONG_WIDTH: tuple[tuple[int, int], ...] = ((0, 1), (2, -1), (1, 1))
"""World (x, y, z) = layout (x, -z, y): the rotation that puts the depth across the x-z plane."""


def origin(layout: Arrangement) -> NDArray[np.float64]:
    """Point of the floor (x, y, z) [cm] above a world's origin: within 29 m of the first item.

    Far from their origin engines lose digits, or the floor. The first item alone decides, so that
    the point stays while a layout grows. The origin lies on the ground, below a deck.
    """
    return np.round(layout.lower[0] / _NEAR) * (_NEAR, 0.0, _NEAR)


def boxes(
    layout: Arrangement,
    *,
    across: Across = "width",
    shrink: float = 0.0,
    jitter: float = 0.0,
    seed: int = 0,
    first: int = 0,
) -> list[Box]:
    """A layout's items as boxes of a world. The one place where units and axes change.

    On a deck all stand higher by its height: the floor of a world is the ground.

    Args:
        layout: any layout.
        across: which of the layout's horizontal axes becomes the world's y. The other becomes x,
            the only horizontal axis of a 2-D engine.
        shrink: draw in every side face by this [m], top and base excepted, so that neighbours do
            not touch; never more than a thousandth of a side.
        jitter: displace every item along every axis by up to this [m], at random.
        seed: of the jitter; together with the layout's name it fixes every displacement.
        first: only boxes of the items from this one on.
    """
    axes, signs = _frame(across)
    lower, upper = layout.lower[first:] - origin(layout), layout.upper[first:] - origin(layout)
    sizes = (upper - lower)[:, axes] * CM
    sizes[:, :2] -= 2.0 * np.minimum(shrink, 1e-3 * sizes[:, :2])
    centres = (0.5 * (lower + upper))[:, axes] * signs * CM
    centres[:, 2] += layout.floor.height * CM
    offsets = layout.mass_offsets[first:, axes] * signs * CM
    if jitter:
        random = np.random.default_rng([seed, zlib.crc32(layout.name.encode())])
        centres += random.uniform(-jitter, jitter, (len(layout), 3))[first:]
    return [
        Box(tuple(size), weight, tuple(centre), tuple(offset))
        for size, weight, centre, offset in zip(
            sizes.tolist(),
            layout.weights[first:].tolist(),
            centres.tolist(),
            offsets.tolist(),
            strict=True,
        )
    ]


def surroundings(
    layout: Arrangement, *, across: Across = "width", planar: bool = False
) -> list[Box]:
    """Fixed boxes that a world holds beside a layout's items: a slab for a deck.

    Args:
        layout: any layout.
        across: as the boxes of the items are made.
        planar: the slab has the items' extent across, as a 2-D engine needs it.
    """
    floor = layout.floor
    if not floor.has_edges:
        return []
    axes, signs = _frame(across)
    low = np.array((floor.low[0], 0.0, floor.low[1])) - origin(layout)
    high = np.array((floor.high[0], floor.height, floor.high[1])) - origin(layout)
    if planar:
        side, start = axes[1], origin(layout)[axes[1]]
        low[side], high[side] = layout.lower[0, side] - start, layout.upper[0, side] - start
    size = (high - low)[axes] * CM
    centre = (0.5 * (low + high))[axes] * signs * CM
    return [Box(tuple(size.tolist()), 1.0, tuple(centre.tolist()), fixed=True)]


def in_layout(poses: Poses, layout: Arrangement, *, across: Across = "width") -> Poses:
    """A world's poses in the layout's units and axes: centres [cm], y up. Undoes :func:`boxes`.

    Args:
        poses: arrays of shape (..., 3) and (..., 4).
        layout: whose boxes they are of.
        across: as the boxes were made.
    """
    axes, signs = _frame(across)
    centres, quaternions = np.empty_like(poses.centres), np.array(poses.quaternions)
    centres[..., axes] = poses.centres * signs / CM
    centres += origin(layout)
    centres[..., 1] -= layout.floor.height
    # The frames differ by a rotation, under which a turn's axis is a vector like any other.
    quaternions[..., [a + 1 for a in axes]] = poses.quaternions[..., 1:] * signs
    return Poses(centres, quaternions)


def _frame(across: Across) -> tuple[list[int], NDArray[np.float64]]:
    frame = _UPRIGHT if across == "width" else _ALONG_WIDTH
    return [a for a, _ in frame], np.array([s for _, s in frame], dtype=float)


def fixed(box: Box) -> Box:
    """The same box as part of the surroundings."""
    return replace(box, fixed=True)


@dataclass(frozen=True, slots=True)
class PlanarScene:
    """Planarity of a layout: by symmetry it moves in a vertical plane only, or it does not.

    Attributes:
        across: the horizontal axis along which nothing happens, ``width`` or ``depth``; None when
            the layout is not planar.
        reason: one sentence that says why it is not.
    """

    across: Across | None
    reason: str = ""


def planar_scene(layout: Arrangement) -> PlanarScene:
    """Planarity of a layout: can a 2-D engine judge it exactly?

    It can when all items have the same extent along one horizontal axis (walls of full depth, a
    single column of equal depth) and every centre of mass lies in the middle of it: then each item
    and each contact is symmetric about one vertical plane, and so is the motion. Beyond an edge of
    a deck along that axis contacts would no longer be.
    """
    reasons = []
    floor = layout.floor
    for axis, across in ((2, "depth"), (0, "width")):
        low, high = layout.lower[:, axis], layout.upper[:, axis]
        if np.ptp(low) > TOLERANCE or np.ptp(high) > TOLERANCE:
            odd = int((np.abs(low - low[0]) + np.abs(high - high[0]) > TOLERANCE).argmax())
            reasons.append(f"item {odd} does not share its {across} with item 0")
        elif np.abs(layout.mass_offsets[:, axis]).max() > TOLERANCE:
            odd = int(np.abs(layout.mass_offsets[:, axis]).argmax())
            reasons.append(f"the centre of mass of item {odd} is off the middle of its {across}")
        elif max(floor.low[axis // 2] - low.min(), high.max() - floor.high[axis // 2]) > TOLERANCE:
            reasons.append(f"its {across} overhangs the deck")
        else:
            return PlanarScene("depth" if across == "depth" else "width")
    return PlanarScene(None, f"the layout is not planar: {' and '.join(reasons)}")


@dataclass(frozen=True, slots=True)
class Neighbourhood:
    """The part of a layout that placing one item can affect.

    Attributes:
        free: items that may move: those joined to the new one by standing on each other, directly
            or over others.
        fixed: items beside them, which carry and stop them but do not move.
    """

    free: NDArray[np.intp]
    fixed: NDArray[np.intp]


def neighbourhood(
    layout: Arrangement, group: NDArray[np.intp], reach: float, step: int | None = None
) -> Neighbourhood:
    """Items that placing the last of some joined items, on all items before it, can affect.

    Args:
        layout: any layout.
        group: the new item, last, and what is joined to it: see :meth:`.Supports.joined`.
        reach: how far around the free items others count as beside them [cm].
        step: the item placed last, where it is none of the group.
    """
    count = int(group[-1] if step is None else step) + 1
    lower, upper = layout.lower[:count], layout.upper[:count]
    beside = gaps(lower, upper, lower[group], upper[group]).min(axis=1) <= reach
    beside[group] = False
    return Neighbourhood(group, np.flatnonzero(beside))


def gaps(lower: FloatArray, upper: FloatArray, low: FloatArray, high: FloatArray) -> FloatArray:
    """Distances between boxes along the axis that parts them most; negative where they overlap.

    Args:
        lower: corners of some boxes, shape (n, 3).
        upper: likewise.
        low: corners of others, shape (m, 3).
        high: likewise.

    Returns:
        Shape (n, m), in the unit of the corners.
    """
    apart = np.maximum(lower[:, None] - high[None], low[None] - upper[:, None])
    found: FloatArray = apart.max(axis=2)
    return found

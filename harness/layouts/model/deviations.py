"""Layouts as they come out of a loading: centres of mass, positions and weights off the plan.

No plan is carried out exactly. A centre of mass is known to so many millimetres, an item is put
down so many millimetres off, a weight is known to so many per cent. Here a plan becomes the layout
that may really stand there, one for every row of random numbers.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from steadyload.layouts.model.layout import (
    SIDES,
    TOLERANCE,
    WEIGHTS,
    FloatArray,
    Layout,
    replace_items,
)

CENTRE, PLACE, WEIGHT = slice(0, 3), slice(3, 5), 5
"""Which of an item's numbers moves what: its centre of mass along x, y and z, its place along x and
z, its weight."""

NUMBERS_AN_ITEM = 6

_PLAN = (0, 2)
"""The horizontal axes."""

_TRIFLE = 1e-9
"""[cm]"""


def deviated(
    layout: Layout,
    uniforms: FloatArray,
    *,
    centre: float = 0.0,
    place: float = 0.0,
    weight: float = 0.0,
    still: int | None = None,
) -> list[Layout]:
    """Layouts that deviate from a plan, one a row of random numbers; names stay.

    All deviations are normal and independent. A centre of mass stays inside its item: its
    deviations are cut off there, and the rest of the distribution scaled to 1. Places are those of
    :func:`made_room`. A weight is multiplied by the exponential of its deviation, and kept to what
    a layout may hold.

    Args:
        layout: the plan.
        uniforms: numbers in (0, 1), shape (n, J or more, :data:`NUMBERS_AN_ITEM`). An item's
            deviations depend on its own numbers alone.
        centre: standard deviation of a centre of mass along each axis [cm].
        place: that of the place that an item is meant for along x and z [cm]; heights stay.
        weight: that of the logarithm of a weight.
        still: an axis, 0 to 2, along which nothing deviates.
    """
    from scipy.special import ndtr, ndtri

    uniforms = uniforms[:, : len(layout)]
    free = np.arange(3) != still
    offsets = np.broadcast_to(layout.mass_offsets, (len(uniforms), len(layout), 3))
    if centre:
        half = 0.5 * (layout.upper - layout.lower)
        least, most = (ndtr((end - layout.mass_offsets) / centre) for end in (-half, half))
        shifts = centre * ndtri(least + (most - least) * uniforms[..., CENTRE])
        offsets = np.clip(offsets + shifts * free, -half, half)
    lower = np.broadcast_to(layout.lower, offsets.shape)
    if place:
        shifts = np.zeros(offsets.shape)
        shifts[..., _PLAN] = place * ndtri(uniforms[..., PLACE])
        lower = made_room(layout, lower + shifts * free)
    weights = np.broadcast_to(layout.weights, offsets.shape[:2])
    if weight:
        weights = np.clip(weights * np.exp(weight * ndtri(uniforms[..., WEIGHT])), *WEIGHTS)
    plan = layout.with_floor_kept()
    if place and plan.floor.has_edges:
        # Its limit is one of plans: no item is stopped there.
        plan = replace(plan, pallet=replace(plan.pallet, overhang=SIDES[1]))
    return [
        replace_items(
            plan,
            tuple(
                replace(item, position=tuple(at), mass_offset=tuple(offset), weight=heavy)
                for item, at, offset, heavy in zip(layout.items, *rows, strict=True)
            ),
        )
        for rows in zip(lower.tolist(), offsets.tolist(), weights.tolist(), strict=True)
    ]


def made_room(layout: Layout, meant: FloatArray) -> FloatArray:
    """Positions of items that are meant for places where there is no room for all of them.

    Items in each other's way push each other apart, each by half of what is missing, and those in
    turn the next ones; on a plane an item stays at the contour's end, and the other one gives way.
    What stood left of another in the plan stands left of it still, and likewise behind: pairs that
    share heights are kept apart along that horizontal axis along which the plan has them further
    apart.

    Args:
        layout: the plan; it shows that there is room for all.
        meant: left-bottom-back corners [cm], shape (n, J, 3).

    Returns:
        Corners of the same shape; those of items that nobody is in the way of are unchanged.
    """
    found = np.array(meant)
    gaps = np.maximum(
        layout.lower[:, None] - layout.upper[None], layout.lower[None] - layout.upper[:, None]
    )
    facing = gaps[..., 1] < -TOLERANCE
    behind = gaps[..., 2] > gaps[..., 0]
    for axis in _PLAN:
        found[..., axis] = _apart(layout, axis, facing & (behind == (axis == 2)), found[..., axis])
    return found


def _apart(layout: Layout, axis: int, pairs: NDArray[np.bool_], meant: FloatArray) -> FloatArray:
    """Places along an axis with the pairs kept apart: pushed up, pushed down, and the mean of both.

    Room for all is kept by either push, and so by their mean.
    """
    at, size = layout.lower[:, axis], (layout.upper - layout.lower)[:, axis]
    order = np.argsort(at, kind="stable").tolist()
    before = [(j, [i for i in order[:rank] if pairs[i, j]]) for rank, j in enumerate(order)]
    # What the plan itself lets overlap may go on to; a trifle less, so that rounding does not add.
    apart = np.minimum(size[:, None], at[None] - at[:, None] + _TRIFLE)
    # On a plane no item comes to overhang: the plan's floor is that of all its deviations. On a
    # deck nothing stops an item.
    out = np.inf if layout.floor.has_edges else 0.0
    low, high = np.minimum(-out, at), np.maximum(layout.pallet.size[axis] + out - size, at)
    for j, others in before:
        low[j] = max([low[j], *(low[i] + apart[i, j] for i in others)])
    for j, others in reversed(before):
        for i in others:
            high[i] = min(high[i], high[j] - apart[i, j])
    up = np.clip(meant, low, high)
    down = up.copy()
    for j, others in before:
        for i in others:
            up[:, j] = np.maximum(up[:, j], up[:, i] + apart[i, j])
    for j, others in reversed(before):
        for i in others:
            down[:, i] = np.minimum(down[:, i], down[:, j] - apart[i, j])
    return 0.5 * (up + down)

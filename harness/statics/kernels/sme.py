"""Static mechanical equilibrium as the authors compute it: the first step that fails."""

from __future__ import annotations

from typing import Any

import numpy as np

from steadyload.statics.kernels.compiled import compiled
from steadyload.statics.kernels.constants import FLOOR, ROUNDING
from steadyload.statics.kernels.contacts import contacts_of
from steadyload.statics.kernels.convex_hull import strictly_inside_hull


@compiled
def first_unsupported(lower: Any, upper: Any, weights: Any, offsets: Any, floor: Any) -> Any:
    """The first step after which an item is not supported.

    Args:
        lower: see :mod:`steadyload.statics.kernels`.
        upper: likewise.
        weights: likewise.
        offsets: likewise.
        floor: likewise, shape (5,).

    Returns:
        The step and the item, and whether something is below it; the number of items, -1 and False
        where every step is supported.
    """
    count = len(lower)
    contacts = contacts_of(lower, upper, floor)
    centres = np.empty((count, 3))
    for j in range(count):
        for c in range(3):
            centres[j, c] = 0.5 * (lower[j, c] + upper[j, c]) + offsets[j, c]
    for step in range(count):
        item = unsupported_at(step, contacts, centres, weights, lower, upper, floor)
        if item >= 0:
            return step, item, contacts.ends[item] > contacts.starts[item]
    return count, -1, False


@compiled
def unsupported_at(
    step: int, contacts: Any, centres: Any, weights: Any, lower: Any, upper: Any, floor: Any
) -> int:
    """The first item at or below a new one that is not supported, -1 where all are.

    The new item is looked at, then what carries it from the last to the first: further down every
    load is the same as at the last check.
    """
    first, end = contacts.starts[step], contacts.ends[step]
    for k in range(end, first - 1, -1):
        item = step if k == end else contacts.below[k]
        if item == FLOOR or item > step or contacts.on_floor[item]:
            continue
        if not supported(item, step, contacts, centres, weights, lower, upper, floor):
            return item
    return -1


@compiled
def first_unsupported_of_many(
    lower: Any, upper: Any, weights: Any, offsets: Any, floors: Any, starts: Any
) -> Any:
    """Results of :func:`first_unsupported` for every layout of a batch, each of shape (L,)."""
    count = len(starts) - 1
    steps, items = np.empty(count, dtype=np.int64), np.empty(count, dtype=np.int64)
    carried = np.empty(count, dtype=np.bool_)
    for k in range(count):
        part = slice(starts[k], starts[k + 1])
        steps[k], items[k], carried[k] = first_unsupported(
            lower[part], upper[part], weights[part], offsets[part], floors[k]
        )
    return steps, items, carried


@compiled
def supported(
    item: int, step: int, contacts: Any, centres: Any, weights: Any, lower: Any, upper: Any,
    floor: Any,
) -> bool:  # fmt: skip
    """True if the weighted mean of an item and those directly on it lies in its support."""
    weight = weights[item]
    x, z = weight * centres[item, 0], weight * centres[item, 2]
    for k in range(contacts.above_starts[item], contacts.above_ends[item]):
        other = contacts.above[k]
        if other <= step:
            weight += weights[other]
            x += weights[other] * centres[other, 0]
            z += weights[other] * centres[other, 2]
    x, z = x / weight, z / weight
    first, end = contacts.starts[item], contacts.ends[item]
    patches = 0
    for k in range(first, end):
        carrier = contacts.below[k]
        if carrier > step:
            continue
        patches += 1
        if carrier == FLOOR:
            x0, z0, x1, z1 = floor[0], floor[1], floor[2], floor[3]
        else:
            x0, z0 = lower[carrier, 0], lower[carrier, 2]
            x1, z1 = upper[carrier, 0], upper[carrier, 2]
        if x0 - ROUNDING <= x <= x1 + ROUNDING and z0 - ROUNDING <= z <= z1 + ROUNDING:
            return True
    if patches < 2:  # a point in the hull of one patch is in the top face that it is a part of
        return False
    corners = np.empty((4 * patches, 2))
    at = 0
    for k in range(first, end):
        if contacts.below[k] <= step:
            p = contacts.patches[k]
            corners[at, 0], corners[at, 1] = p[0], p[1]
            corners[at + 1, 0], corners[at + 1, 1] = p[0], p[3]
            corners[at + 2, 0], corners[at + 2, 1] = p[2], p[1]
            corners[at + 3, 0], corners[at + 3, 1] = p[2], p[3]
            at += 4
    return strictly_inside_hull(x, z, corners, ROUNDING)

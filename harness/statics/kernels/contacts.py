"""Vertical contacts of a layout: which items stand on which, and where."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from steadyload.statics.kernels.compiled import compiled
from steadyload.statics.kernels.constants import FLOOR, TOLERANCE

_FEW = 48
"""Up to this many items all pairs are looked at; of more, those whose heights meet."""


class Contacts(NamedTuple):
    """Contact patches of a layout, item by item.

    Attributes:
        on_floor: item stands on the floor with all of its base, shape (J,).
        starts: the patches that item j stands on are ``starts[j]`` to ``ends[j]``, shape (J + 1,)
            where they are found for all items at once.
        ends: see there, shape (J,).
        below: what carries, in ascending order for every item: :data:`FLOOR` (an item that
            overhangs an edge of the floor) or an item, shape (P,).
        patches: x0, z0, x1, z1 of every contact rectangle [cm], shape (P, 4).
        above_starts: the items that item i carries are ``above_starts[i]`` to ``above_ends[i]``,
            shape as that of ``starts``.
        above_ends: see there, shape (J,).
        above: those items, in ascending order for every carrier.
    """

    on_floor: Any
    starts: Any
    ends: Any
    below: Any
    patches: Any
    above_starts: Any
    above_ends: Any
    above: Any


@compiled
def contacts_of(lower: Any, upper: Any, floor: Any) -> Contacts:
    """All vertical contacts: faces level to within the tolerance that share an area.

    Args:
        lower: see :mod:`steadyload.statics.kernels`.
        upper: likewise.
        floor: likewise, shape (5,).
    """
    count = len(lower)
    on_floor = np.zeros(count, dtype=np.bool_)
    starts = np.zeros(count + 1, dtype=np.int64)
    below = np.empty(4 * count, dtype=np.int64)
    patches = np.empty((4 * count, 4))
    many = count > _FEW
    order = _by_top(upper) if many else np.empty(0, dtype=np.int64)
    found = 0
    for j in range(count):
        x0, y0, z0 = lower[j, 0], lower[j, 1], lower[j, 2]
        x1, z1 = upper[j, 0], upper[j, 2]
        if len(below) < found + count + 1:
            below, patches = _with_room(below, patches, 2 * found + 2 * count)
        if y0 <= TOLERANCE:
            on_floor[j] = True
            if floor[4] > 0.0:
                a, b = max(x0, floor[0]), max(z0, floor[1])
                c, d = min(x1, floor[2]), min(z1, floor[3])
                if max(max(a - x0, b - z0), max(x1 - c, z1 - d)) > TOLERANCE:
                    on_floor[j] = False
                    if min(c - a, d - b) > TOLERANCE:
                        below[found] = FLOOR
                        patches[found, 0], patches[found, 1] = a, b
                        patches[found, 2], patches[found, 3] = c, d
                        found += 1
        first = _first_from(order, upper, y0 - 2.0 * TOLERANCE) if many else 0
        begin = found
        for k in range(first, count):
            i = order[k] if many else k
            if many and upper[i, 1] > y0 + 2.0 * TOLERANCE:
                break
            if abs(upper[i, 1] - y0) <= TOLERANCE:
                a, c = max(lower[i, 0], x0), min(upper[i, 0], x1)
                b, d = max(lower[i, 2], z0), min(upper[i, 2], z1)
                if min(c - a, d - b) > TOLERANCE:
                    at = found
                    while many and at > begin and below[at - 1] > i:
                        below[at] = below[at - 1]
                        for side in range(4):  # rows at once take two seconds more to compile
                            patches[at, side] = patches[at - 1, side]
                        at -= 1
                    below[at] = i
                    patches[at, 0], patches[at, 1], patches[at, 2], patches[at, 3] = a, b, c, d
                    found += 1
        starts[j + 1] = found
    above_starts, above = _turned_round(starts, below[:found])
    return Contacts(
        on_floor, starts, starts[1:], below[:found], patches[:found], above_starts,
        above_starts[1:], above,
    )  # fmt: skip


@compiled
def draw_in(patches: Any, margin: float) -> None:
    """Draw in patches by a margin [cm] on every side, in place.

    Of what is narrower than twice that nothing is left: it carries nothing, see :func:`is_left`. A
    margin within the tolerance of plans guards against rounding alone, and leaves a line of it.

    Args:
        patches: x0, z0, x1, z1 [cm], shape (P, 4).
        margin: 0 or more.
    """
    for k in range(len(patches)):
        x0, z0, x1, z1 = patches[k]
        if margin > TOLERANCE and min(x1 - x0, z1 - z0) < 2.0 * margin:
            patches[k, 0], patches[k, 1], patches[k, 2], patches[k, 3] = 0.0, 0.0, -1.0, -1.0
            continue
        for axis in range(2):
            by = min(margin, 0.5 * (patches[k, axis + 2] - patches[k, axis]))
            patches[k, axis] += by
            patches[k, axis + 2] -= by


@compiled
def is_left(patches: Any, number: int) -> bool:
    """Whether something is left of a patch that was drawn in."""
    return bool(patches[number, 2] >= patches[number, 0])


@compiled
def _turned_round(starts: Any, below: Any) -> Any:
    """The items on every item, from the items below every item."""
    count = len(starts) - 1
    above_starts = np.zeros(count + 1, dtype=np.int64)
    for i in below:
        if i != FLOOR:
            above_starts[i + 1] += 1
    for i in range(count):
        above_starts[i + 1] += above_starts[i]
    ends = above_starts[:-1].copy()
    above = np.empty(above_starts[count], dtype=np.int64)
    for j in range(count):
        for i in below[starts[j] : starts[j + 1]]:
            if i != FLOOR:
                above[ends[i]] = j
                ends[i] += 1
    return above_starts, above


@compiled
def _with_room(below: Any, patches: Any, size: int) -> Any:
    """Arrays with the same beginning and more places."""
    more_below, more_patches = np.empty(size, dtype=np.int64), np.empty((size, 4))
    for k in range(len(below)):
        more_below[k] = below[k]
        for c in range(4):
            more_patches[k, c] = patches[k, c]
    return more_below, more_patches


@compiled
def _by_top(upper: Any) -> Any:
    """Items in ascending order of their tops (a heap sort: it compiles soon)."""
    count = len(upper)
    order = np.arange(count)
    for end in range(count + count // 2 - 1, 0, -1):
        # First a heap is made, then its largest item goes behind it, again and again.
        root, size = end - count, count
        if end < count:
            order[0], order[end] = order[end], order[0]
            root, size = 0, end
        child = 2 * root + 1
        while child < size:
            if child + 1 < size and upper[order[child + 1], 1] > upper[order[child], 1]:
                child += 1
            if upper[order[child], 1] <= upper[order[root], 1]:
                break
            order[root], order[child] = order[child], order[root]
            root, child = child, 2 * child + 1
    return order


@compiled
def _first_from(order: Any, upper: Any, least: float) -> int:
    """The first place in ascending order of tops at which a top is not below a height."""
    low, high = 0, len(order)
    while low < high:
        middle = (low + high) // 2
        if upper[order[middle], 1] < least:
            low = middle + 1
        else:
            high = middle
    return low

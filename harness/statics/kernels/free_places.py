"""Places at which a box would lie on something and overlap nothing, the nearest ones first."""

from __future__ import annotations

from typing import Any

import numpy as np

from steadyload.statics.kernels.compiled import compiled
from steadyload.statics.kernels.constants import TOLERANCE

_PARTS = 1e3
"""Of a cm, in which coordinates are that no other box has."""

_ALIKE = 1e6
"""Distances are alike that are the same in these parts of a cm."""


@compiled
def nearest_places(
    lower: Any, upper: Any, centres: Any, sides: Any, offsets: Any, planned: Any, margin: float,
    limits: Any, ways: Any, turns: int, most: int,
) -> Any:  # fmt: skip
    """Free places of a box, the nearest first.

    Args:
        lower: corners of the others [cm], shape (J, 3).
        upper: likewise.
        centres: of mass of the others [cm], shape (J, 3).
        sides: of the box as planned and turned by a quarter [cm], shape (2, 3).
        offsets: of its centre of mass from its middle, likewise.
        planned: its lower corner in the plan [cm], shape (3,).
        margin: see :func:`free_places`.
        limits: likewise.
        ways: likewise.
        turns: 2 where it may be turned, else 1.
        most: places of a side that are looked for.

    Returns:
        Lower corners [cm] and whether the box is turned, shape (K, 4), and how far its middle comes
        from where it was [cm], shape (K,).
    """
    levels = np.empty(len(upper) + 1)
    levels[0] = 0.0
    levels[1:] = upper[:, 1]
    levels = np.unique(levels)
    levels = levels[np.argsort(np.abs(levels - planned[1]), kind="mergesort")]
    places, far = np.empty((turns * most, 4)), np.empty(turns * most)
    count, start = 0, np.empty(3)
    for turn in range(turns):
        size = sides[turn]
        for axis in range(3):
            start[axis] = planned[axis]
            if turn == 1:
                start[axis] = planned[axis] + 0.5 * sides[0, axis] - 0.5 * size[axis]
        made = free_places(
            lower, upper, centres, size, 0.5 * size + offsets[turn], start, margin, limits, levels,
            ways, most,
        )  # fmt: skip
        for k in range(len(made)):
            squares = 0.0
            for axis in range(3):
                places[count, axis] = made[k, axis]
                squares += (made[k, axis] - start[axis]) ** 2
            places[count, 3] = turn
            far[count] = np.sqrt(squares)
            count += 1
    order = np.argsort(np.rint(far[:count] * _ALIKE), kind="mergesort")
    for k in range(1, count):
        at, m = order[k], k
        while m > 0 and _comes_before(at, order[m - 1], places, far):
            order[m] = order[m - 1]
            m -= 1
        order[m] = at
    return places[order], far[order]


@compiled
def _comes_before(one: int, other: int, places: Any, far: Any) -> bool:
    """Whether a place that is as far as another one comes before it."""
    if np.rint(far[one] * _ALIKE) != np.rint(far[other] * _ALIKE):
        return False
    for column in (1, 0, 2, 3):
        if places[one, column] != places[other, column]:
            return bool(places[one, column] < places[other, column])
    return False


@compiled
def free_places(
    lower: Any, upper: Any, centres: Any, size: Any, middle: Any, start: Any, margin: float,
    limits: Any, levels: Any, ways: Any, most: int,
) -> Any:  # fmt: skip
    """Places of a box among others: flush with their faces, or just far enough over their edges.

    Along x and z a place is where the box was; at an end of the contour; flush with a side of a
    box beside, below or above it; or such that its centre of mass lies ``margin`` inside an edge
    of what it lies on, or that of what lies on it ``margin`` inside its own. Along y it lies on the
    floor or on the top of a box.

    Args:
        lower: corners of the others [cm], shape (J, 3).
        upper: likewise.
        centres: of mass of the others [cm], shape (J, 3).
        size: of the box [cm], shape (3,).
        middle: of its centre of mass from its lower corner [cm], shape (3,).
        start: its lower corner before [cm], shape (3,).
        margin: [cm], 0 or more.
        limits: contour (lower, upper) and deck (x0, z0, x1, z1) [cm], shape (10,).
        levels: heights at which it may lie [cm], the most wanted ones first, shape (L,).
        ways: how far it may move sideways, and how far up, at least and at most [cm], shape (3,).
        most: places that are looked for; of further levels there are none then.

    Returns:
        Lower corners [cm], shape (K, 3), in no order.
    """
    found = np.empty((most, 3))
    count = 0
    beside, below = np.empty(len(lower), np.int64), np.empty(len(lower), np.int64)
    above = np.empty(len(lower), np.int64)
    taken = np.empty(8 + 4 * len(lower), np.int64)
    carried = np.empty_like(taken)
    all_xs, all_zs = np.empty(len(taken)), np.empty(len(taken))
    for y in levels:
        if y + size[1] > limits[4] + TOLERANCE or not ways[1] <= y - start[1] <= ways[2]:
            continue
        on_floor = y <= TOLERANCE
        besides, belows, aboves = 0, 0, 0
        for k in range(len(lower)):
            if min(upper[k, 1], y + size[1]) - max(lower[k, 1], y) > TOLERANCE:
                beside[besides] = k
                besides += 1
            elif abs(upper[k, 1] - y) <= TOLERANCE:
                below[belows] = k
                belows += 1
            elif abs(lower[k, 1] - y - size[1]) <= TOLERANCE:
                above[aboves] = k
                aboves += 1
        if not on_floor and belows == 0:
            continue
        xs = all_xs[: _coordinates(
            all_xs, 0, lower, upper, centres, size, middle, start, margin, limits,
            beside[:besides], below[:belows], above[:aboves], on_floor,
        )]  # fmt: skip
        if not len(xs):
            continue
        zs = all_zs[: _coordinates(
            all_zs, 2, lower, upper, centres, size, middle, start, margin, limits,
            beside[:besides], below[:belows], above[:aboves], on_floor,
        )]  # fmt: skip
        besides_at = _ranges(zs, size[2], lower, upper, beside[:besides])
        belows_at = _ranges(zs, size[2], lower, upper, below[:belows])
        for x in xs:
            carried[: len(zs) + 1] = 0
            carriers = 0
            for m in range(belows):
                k = below[m]
                if min(upper[k, 0], x + size[0]) - max(lower[k, 0], x) > TOLERANCE:
                    carried[belows_at[m, 0]] += 1
                    carried[belows_at[m, 1]] -= 1
                    carriers += 1
            if not on_floor and carriers == 0:
                continue
            taken[: len(zs) + 1] = 0
            for m in range(besides):
                k = beside[m]
                if min(upper[k, 0], x + size[0]) - max(lower[k, 0], x) > TOLERANCE:
                    taken[besides_at[m, 0]] += 1
                    taken[besides_at[m, 1]] -= 1
            in_the_way, carriers = 0, int(on_floor)
            for n in range(len(zs)):
                in_the_way += taken[n]
                carriers += carried[n]
                if in_the_way > 0 or carriers == 0:
                    continue
                z = zs[n]
                if np.sqrt((x - start[0]) ** 2 + (z - start[2]) ** 2) > ways[0]:
                    continue
                if count == most:
                    return found
                found[count, 0], found[count, 1], found[count, 2] = x, y, z
                count += 1
    return found[:count]


@compiled
def _ranges(zs: Any, side: float, lower: Any, upper: Any, boxes: Any) -> Any:
    """Of each of some boxes the first coordinate along z that meets it, and the first behind."""
    found = np.zeros((len(boxes), 2), np.int64)
    for m in range(len(boxes)):
        k = boxes[m]
        for n in range(len(zs)):
            if min(upper[k, 2], zs[n] + side) - max(lower[k, 2], zs[n]) > TOLERANCE:
                if found[m, 1] == 0:
                    found[m, 0] = n
                found[m, 1] = n + 1
            elif found[m, 1] > 0:
                break
    return found


@compiled
def _coordinates(
    made: Any, axis: int, lower: Any, upper: Any, centres: Any, size: Any, middle: Any, start: Any,
    margin: float, limits: Any, beside: Any, below: Any, above: Any, on_floor: bool,
) -> int:  # fmt: skip
    """Put coordinates along an axis at which something may carry a box, ascending, each once; how
    many there are.
    """
    side = size[axis]
    least, most = limits[axis] - TOLERANCE, limits[3 + axis] + TOLERANCE
    if not on_floor:
        first, end = np.inf, -np.inf
        for k in below:
            first, end = min(first, lower[k, axis]), max(end, upper[k, axis])
        least, most = max(least, first - side), min(most, end + side)
    most -= side
    count = _with(made, 0, start[axis], least, most)
    count = _with(made, count, limits[axis], least, most)
    count = _with(made, count, limits[3 + axis] - side, least, most)
    if on_floor:
        low, high = limits[6 + axis // 2], limits[8 + axis // 2]
        count = _with(made, count, low, least, most)
        count = _with(made, count, high - side, least, most)
        count = _with(made, count, low + margin - middle[axis], least, most)
        count = _with(made, count, high - margin - middle[axis], least, most)
    for k in beside:
        count = _with(made, count, lower[k, axis], least, most)
        count = _with(made, count, upper[k, axis] - side, least, most)
        count = _with(made, count, upper[k, axis], least, most)
        count = _with(made, count, lower[k, axis] - side, least, most)
    for k in below:
        count = _with(made, count, lower[k, axis], least, most)
        count = _with(made, count, upper[k, axis] - side, least, most)
        inner = _rounded(lower[k, axis] + margin - middle[axis], True)
        count = _with(made, count, inner, least, most)
        inner = _rounded(upper[k, axis] - margin - middle[axis], False)
        count = _with(made, count, inner, least, most)
    for k in above:
        count = _with(made, count, lower[k, axis], least, most)
        count = _with(made, count, upper[k, axis] - side, least, most)
        inner = _rounded(centres[k, axis] + margin - side, True)
        count = _with(made, count, inner, least, most)
        inner = _rounded(centres[k, axis] - margin, False)
        count = _with(made, count, inner, least, most)
    kept = 0
    for n in range(count):
        value = made[n]
        if abs(value - start[axis]) < 1e-6:
            value = start[axis]
        if kept > 0 and value - made[kept - 1] < 1e-6:
            made[kept - 1] = value if value == start[axis] else made[kept - 1]
            continue
        made[kept] = value
        kept += 1
    return kept


@compiled
def _with(made: Any, count: int, value: float, least: float, most: float) -> int:
    """Put a coordinate among others that ascend, if it is new; how many there are then."""
    if not least <= value <= most:
        return count
    k = count
    while k > 0 and made[k - 1] > value:
        k -= 1
    if k > 0 and made[k - 1] == value:
        return count
    for n in range(count, k, -1):
        made[n] = made[n - 1]
    made[k] = value
    return count + 1


@compiled
def _rounded(value: float, up: bool) -> float:
    """A coordinate in decimals that a plan has, rounded to the side where the margin is kept."""
    scaled = value * _PARTS
    whole = np.ceil(scaled - 1e-6) if up else np.floor(scaled + 1e-6)
    return float(whole / _PARTS)

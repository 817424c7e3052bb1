"""Places at which a box would lie on something and overlap nothing, and what it would meet on the
way down.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from steadyload.statics.kernels.compiled import compiled
from steadyload.statics.kernels.constants import TOLERANCE

_DECIMALS = 3
"""Of coordinates that no other box has, in cm."""


@compiled
def free_places(
    lower: Any, upper: Any, centres: Any, size: Any, middle: Any, start: Any, margin: float,
    limits: Any, levels: Any, most: int,
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
        most: places that are looked for; of further levels there are none then.

    Returns:
        Lower corners [cm], shape (K, 3), in no order.
    """
    found = np.empty((most, 3))
    count = 0
    beside, below = np.empty(len(lower), np.int64), np.empty(len(lower), np.int64)
    above = np.empty(len(lower), np.int64)
    for y in levels:
        if y + size[1] > limits[4] + TOLERANCE:
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
        xs = _coordinates(
            0, lower, upper, centres, size, middle, start, margin, limits, beside[:besides],
            below[:belows], above[:aboves], on_floor,
        )  # fmt: skip
        zs = _coordinates(
            2, lower, upper, centres, size, middle, start, margin, limits, beside[:besides],
            below[:belows], above[:aboves], on_floor,
        )  # fmt: skip
        columns, carriers = np.empty(besides, np.int64), np.empty(belows, np.int64)
        for x in xs:
            column, carrier = 0, 0
            for k in beside[:besides]:
                if min(upper[k, 0], x + size[0]) - max(lower[k, 0], x) > TOLERANCE:
                    columns[column] = k
                    column += 1
            for k in below[:belows]:
                if min(upper[k, 0], x + size[0]) - max(lower[k, 0], x) > TOLERANCE:
                    carriers[carrier] = k
                    carrier += 1
            for z in zs:
                carried = on_floor
                for k in carriers[:carrier]:
                    if min(upper[k, 2], z + size[2]) - max(lower[k, 2], z) > TOLERANCE:
                        carried = True
                        break
                if not carried:
                    continue
                is_free = True
                for k in columns[:column]:
                    if min(upper[k, 2], z + size[2]) - max(lower[k, 2], z) > TOLERANCE:
                        is_free = False
                        break
                if not is_free:
                    continue
                if count == most:
                    return found
                found[count, 0], found[count, 1], found[count, 2] = x, y, z
                count += 1
    return found[:count]


@compiled
def _coordinates(
    axis: int, lower: Any, upper: Any, centres: Any, size: Any, middle: Any, start: Any,
    margin: float, limits: Any, beside: Any, below: Any, above: Any, on_floor: bool,
) -> Any:  # fmt: skip
    """Coordinates of places along an axis, ascending, each once."""
    side, least, most = size[axis], limits[axis], limits[3 + axis]
    made = np.empty(7 + 4 * (len(beside) + len(below) + len(above)))
    made[0], made[1], made[2] = start[axis], least, most - side
    count = 3
    if on_floor:
        low, high = limits[6 + axis // 2], limits[8 + axis // 2]
        made[3], made[4] = low, high - side
        made[5], made[6] = low + margin - middle[axis], high - margin - middle[axis]
        count = 7
    for k in beside:
        made[count], made[count + 1] = upper[k, axis], lower[k, axis] - side
        made[count + 2], made[count + 3] = lower[k, axis], upper[k, axis] - side
        count += 4
    for k in below:
        made[count], made[count + 1] = lower[k, axis], upper[k, axis] - side
        made[count + 2] = _rounded(lower[k, axis] + margin - middle[axis], True)
        made[count + 3] = _rounded(upper[k, axis] - margin - middle[axis], False)
        count += 4
    for k in above:
        made[count], made[count + 1] = lower[k, axis], upper[k, axis] - side
        made[count + 2] = _rounded(centres[k, axis] + margin - side, True)
        made[count + 3] = _rounded(centres[k, axis] - margin, False)
        count += 4
    made = np.sort(made[:count])
    kept = 0
    for value in made:
        if not (least - TOLERANCE <= value and value + side <= most + TOLERANCE):
            continue
        if abs(value - start[axis]) < 1e-6:
            value = start[axis]
        if kept > 0 and value - made[kept - 1] < 1e-6:
            made[kept - 1] = value if value == start[axis] else made[kept - 1]
            continue
        made[kept] = value
        kept += 1
    return made[:kept]


@compiled
def _rounded(value: float, up: bool) -> float:
    """A coordinate in decimals that a plan has, rounded to the side where the margin is kept."""
    scaled = value * 10.0**_DECIMALS
    whole = np.ceil(scaled - 1e-6) if up else np.floor(scaled + 1e-6)
    return float(whole / 10.0**_DECIMALS)


@compiled
def boxes_over(lower: Any, upper: Any, low: Any, high: Any) -> Any:
    """Boxes that one which is let down to its place would meet, by number.

    Args:
        lower: corners of the boxes [cm], shape (J, 3).
        upper: likewise.
        low: of the one that is let down, at its place, shape (3,).
        high: likewise.
    """
    found = np.empty(len(lower), np.int64)
    count = 0
    for k in range(len(lower)):
        if lower[k, 1] < high[1] - TOLERANCE:
            continue
        across = min(upper[k, 0], high[0]) - max(lower[k, 0], low[0])
        if min(across, min(upper[k, 2], high[2]) - max(lower[k, 2], low[2])) > TOLERANCE:
            found[count] = k
            count += 1
    return found[:count]

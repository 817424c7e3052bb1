"""Support of every item by those below it, step by step: compiled, some microseconds a layout.

Everything follows from the items placed by then. At step j the weight of item j goes down one way
(the evenest pressure that has its resultant where it must be), and for every item that it reaches
two quantities are computed: how far inside its support the resultant of its load lies, and, where
it lies outside, how far the item would tip or fall within the time that a label gives it. No
equilibrium is solved: where forces could be shared otherwise, this reports an instability that is
none.
"""

from __future__ import annotations

import math

import numpy as np

from steadyload.layouts.model import TOLERANCE, FloatArray
from steadyload.learners.compiled import compiled
from steadyload.learners.convex_hull import hull_of, margin_in, pressures, sort_points

SECONDS, GRAVITY = 0.3, 980.0
"""Time [s] and acceleration [cm/s2] that a label gives an item to fall."""

OWN = (
    "on the floor", "supported share", "supporters", "margin", "relative margin", "drop",
    "free angle", "touch angle", "side angle", "catch angle", "angle", "way", "height",
)  # fmt: skip
WORST = (
    "worst margin", "worst relative margin", "worst drop", "worst free angle", "worst touch angle",
    "worst side angle", "worst catch angle", "worst angle", "worst way", "worst load",
    "least margin", "items below",
)  # fmt: skip
COLUMNS = OWN + WORST
"""Columns of :func:`support_table`: of item j itself, then of the item in the greatest danger among
those that the step reaches, and over them all.

Margins [cm] are signed distances of a resultant from the border of the support, positive inside;
relative ones are in shares of the item's shorter horizontal side. ``drop``: free height below an
item that nothing supports [cm]; its margin is that where it lands. ``free angle``: how far an item
would tip in the time, were there nothing in its way; ``touch angle``: at which it first meets
something below; ``side angle``: at its side; ``catch angle``: at which all that it has met below
holds it, as the resultant lies over it [degrees]. ``angle``: the lesser of free and catch;
``way``: of the corner that gets furthest, the drop included [cm]. ``load``: weight carried over own
weight.
"""

_FAR, _SAFE = 500.0, 90.0
"""Margin of items on the floor [cm], and the angle that means that nothing is in the way."""

_REACH = 0.5 * GRAVITY * SECONDS * SECONDS


@compiled
def _side(i: int, step: int, lower: FloatArray, upper: FloatArray, nx: float, nz: float) -> float:
    """The angle [rad] at which an item that tips towards (nx, nz) meets one at its side."""
    best = math.pi / 2.0
    for k in range(step + 1):
        top = min(upper[i, 1], upper[k, 1])
        if k == i or top - max(lower[i, 1], lower[k, 1]) <= TOLERANCE:
            continue
        lever = top - lower[i, 1]
        deep = min(upper[i, 2], upper[k, 2]) - max(lower[i, 2], lower[k, 2])
        wide = min(upper[i, 0], upper[k, 0]) - max(lower[i, 0], lower[k, 0])
        if deep > TOLERANCE and abs(nx) > 0.3:
            gap = lower[k, 0] - upper[i, 0] if nx > 0 else lower[i, 0] - upper[k, 0]
            if gap >= -TOLERANCE:
                best = min(best, math.atan2(max(gap, 0.0), lever * abs(nx)))
        if wide > TOLERANCE and abs(nz) > 0.3:
            gap = lower[k, 2] - upper[i, 2] if nz > 0 else lower[i, 2] - upper[k, 2]
            if gap >= -TOLERANCE:
                best = min(best, math.atan2(max(gap, 0.0), lever * abs(nz)))
    return best


@compiled
def _catch(
    i: int, step: int, level: float, lower: FloatArray, upper: FloatArray, x: float, z: float,
    edge: FloatArray, corners: int, hx: FloatArray, hz: FloatArray,
) -> tuple[float, float]:  # fmt: skip
    """The angles [rad] at which an item that tips first meets something below, and is held by it.

    Args:
        i: the item, whose base is at ``level`` [cm].
        step: items placed by then.
        level: see ``i``.
        lower: of all items.
        upper: of all items.
        x: of the resultant, with ``z``.
        z: see ``x``.
        edge: the point that it tips over, and the way outwards: x, z, nx, nz.
        corners: of its support's hull, which ``hx`` and ``hz`` hold.
        hx: see ``corners``.
        hz: see ``corners``.
    """
    size = 4 * (step + 3) + corners
    angles, rects, met = np.empty(step + 2), np.empty((step + 2, 4)), 0
    for k in range(-1, step + 1):
        if k == i:
            continue
        # The floor, numbered -1, lies under the whole base.
        top = 0.0 if k < 0 else upper[k, 1]
        x0, x1, z0, z1 = lower[i, 0], upper[i, 0], lower[i, 2], upper[i, 2]
        if k >= 0:
            x0, x1 = max(x0, lower[k, 0]), min(x1, upper[k, 0])
            z0, z1 = max(z0, lower[k, 2]), min(z1, upper[k, 2])
        if top > level - TOLERANCE or x1 - x0 <= TOLERANCE or z1 - z0 <= TOLERANCE:
            continue
        far = ((x1 if edge[2] > 0 else x0) - edge[0]) * edge[2]
        far += ((z1 if edge[3] > 0 else z0) - edge[1]) * edge[3]
        if far > 1e-6:
            place = met
            angle = math.atan2(level - top, far)
            while place and angles[place - 1] > angle:
                angles[place], rects[place] = angles[place - 1], rects[place - 1]
                place -= 1
            angles[place] = angle
            rects[place, 0], rects[place, 1], rects[place, 2], rects[place, 3] = x0, x1, z0, z1
            met += 1
    if not met:
        return math.pi / 2.0, math.pi / 2.0
    xs, zs, own = np.empty(size), np.empty(size), np.zeros(size)
    ox, oz, who = np.empty(2 * size), np.empty(2 * size), np.zeros(size, dtype=np.int64)
    xs[:corners], zs[:corners] = hx[:corners], hz[:corners]
    count = corners
    for k in range(met):
        for px in (rects[k, 0], rects[k, 1]):
            for pz in (rects[k, 2], rects[k, 3]):
                xs[count], zs[count] = px, pz
                count += 1
        sort_points(xs, zs, own, who, count)
        hull = hull_of(xs, zs, count, ox, oz)
        if margin_in(x, z, ox, oz, hull)[0] >= 0.0:
            return angles[0], angles[k]
    return angles[0], math.pi / 2.0


@compiled
def _drop(i: int, step: int, lower: FloatArray, upper: FloatArray) -> float:
    """Height that an item without support can fall [cm]."""
    gap = lower[i, 1]
    for k in range(step + 1):
        if k != i and upper[k, 1] <= lower[i, 1] + TOLERANCE:
            wide = min(upper[i, 0], upper[k, 0]) - max(lower[i, 0], lower[k, 0])
            deep = min(upper[i, 2], upper[k, 2]) - max(lower[i, 2], lower[k, 2])
            if wide > TOLERANCE and deep > TOLERANCE:
                gap = min(gap, max(lower[i, 1] - upper[k, 1], 0.0))
    return gap


@compiled
def support_table(
    lower: FloatArray, upper: FloatArray, weights: FloatArray, centres: FloatArray
) -> FloatArray:
    """The :data:`COLUMNS` of every step.

    Args:
        lower: left-bottom-back corners of the items in loading order [cm], shape (n, 3), y up.
        upper: the opposite corners.
        weights: [kg], shape (n,).
        centres: centres of mass in space [cm], shape (n, 3).

    Returns:
        Shape (n, len(COLUMNS)); row j depends on the items 0 to j alone.
    """
    n = len(weights)
    out = np.zeros((n, 25))
    state = np.zeros((n, 11))
    press = np.zeros((n, n, 3))  # of the item above (second) on the one below: force, times x, z
    carries = np.zeros((n, n), dtype=np.bool_)
    reached = np.zeros(n, dtype=np.bool_)
    order = np.argsort(-lower[:, 1], kind="mergesort")
    size = 4 * n + 4
    xs, zs, areas, forces = np.zeros(size), np.zeros(size), np.zeros(size), np.zeros(size)
    hx, hz, who = np.zeros(2 * size), np.zeros(2 * size), np.zeros(size, dtype=np.int64)
    for step in range(n):
        for k in range(step):
            for below, above in ((k, step), (step, k)):
                wide = min(upper[k, 0], upper[step, 0]) - max(lower[k, 0], lower[step, 0])
                deep = min(upper[k, 2], upper[step, 2]) - max(lower[k, 2], lower[step, 2])
                carries[below, above] = (
                    abs(upper[below, 1] - lower[above, 1]) <= TOLERANCE
                    and wide > TOLERANCE
                    and deep > TOLERANCE
                )
        for k in range(step + 1):
            reached[k] = k == step or carries[step, k]
        count = 0
        for place in range(n):
            i = order[place]
            if i > step:
                continue
            if not reached[i]:
                for k in range(step + 1):
                    if carries[i, k] and reached[k]:
                        reached[i] = True
                        break
            if reached[i]:
                count += 1
                _stand(i, step, lower, upper, weights, centres, carries, press, state,
                       xs, zs, areas, forces, hx, hz, who)  # fmt: skip
        row = out[step]
        row[0] = 1.0 if lower[step, 1] <= TOLERANCE else 0.0
        row[1:12] = state[step]
        row[12] = lower[step, 1]
        worst, least = step, 1e300
        for k in range(step + 1):
            if reached[k]:
                least = min(least, state[k, 2])
                danger = max(state[k, 9], state[k, 10]) - 1e-3 * state[k, 2]
                if danger > max(state[worst, 9], state[worst, 10]) - 1e-3 * state[worst, 2]:
                    worst = k
        row[13:22] = state[worst, 2:11]
        load = 0.0
        for k in range(step + 1):
            load += press[worst, k, 0]
        row[22] = load / weights[worst]
        row[23] = least
        row[24] = count - 1
    return out


@compiled
def _stand(
    i: int, step: int, lower: FloatArray, upper: FloatArray, weights: FloatArray,
    centres: FloatArray, carries: FloatArray, press: FloatArray, state: FloatArray, xs: FloatArray,
    zs: FloatArray, areas: FloatArray, forces: FloatArray, hx: FloatArray, hz: FloatArray,
    who: FloatArray,
) -> None:  # fmt: skip
    """Support of item i under its load, into ``state``; the force it exerts, into ``press``."""
    row = state[i]
    wide, deep = upper[i, 0] - lower[i, 0], upper[i, 2] - lower[i, 2]
    row[:] = 0.0
    row[6] = row[7] = row[8] = _SAFE
    if lower[i, 1] <= TOLERANCE:
        row[0], row[2], row[3] = 1.0, _FAR, 1.0
        return
    weight, x, z = weights[i], weights[i] * centres[i, 0], weights[i] * centres[i, 2]
    for k in range(step + 1):
        weight += press[i, k, 0]
        x += press[i, k, 1]
        z += press[i, k, 2]
        press[k, i, :] = 0.0
    x /= weight
    z /= weight
    supported = False
    for k in range(step + 1):
        supported = supported or carries[k, i]
    level = lower[i, 1] if supported else lower[i, 1] - _drop(i, step, lower, upper)
    row[4] = lower[i, 1] - level
    row[10] = min(row[4], _REACH)
    if level <= TOLERANCE:  # falls to the floor, and stays upright
        row[2], row[3] = _FAR, 1.0
        return
    count, covered = 0, 0.0
    for k in range(step + 1):
        x0, x1 = max(lower[i, 0], lower[k, 0]), min(upper[i, 0], upper[k, 0])
        z0, z1 = max(lower[i, 2], lower[k, 2]), min(upper[i, 2], upper[k, 2])
        held = abs(upper[k, 1] - level) <= TOLERANCE and k != i
        if held and x1 - x0 > TOLERANCE and z1 - z0 > TOLERANCE:
            area = (x1 - x0) * (z1 - z0)
            if supported:
                covered += area
                row[1] += 1.0
            for px in (x0, x1):
                for pz in (z0, z1):
                    xs[count], zs[count], areas[count], who[count] = px, pz, 0.25 * area, k
                    count += 1
    row[0] = covered / (wide * deep)
    sort_points(xs, zs, areas, who, count)
    corners = hull_of(xs, zs, count, hx, hz)
    margin, bx, bz, nx, nz = margin_in(x, z, hx, hz, corners)
    row[2], row[3] = margin, margin / min(wide, deep)
    seconds = SECONDS - math.sqrt(2.0 * min(row[4], _REACH) / GRAVITY)
    if margin < 0.0:
        # A box that tips over an edge: (r2 + d2 + h2) a'' = g (d + h a), from rest.
        lever, high = -margin, max(centres[i, 1] - lower[i, 1], 1e-6)
        along = abs(nx) * wide + abs(nz) * deep
        inertia = (along * along + (upper[i, 1] - lower[i, 1]) ** 2) / 12.0 + lever**2 + high**2
        rate = max(seconds, 0.0) * math.sqrt(GRAVITY * high / inertia)
        free = min(lever / high * (math.cosh(min(rate, 20.0)) - 1.0), math.pi / 2.0)
        touch, catch = _catch(
            i, step, level, lower, upper, x, z, np.array([bx, bz, nx, nz]), corners, hx, hz
        )
        angle = min(free, catch)
        furthest = upper[i, 1] - lower[i, 1]
        for px in (lower[i, 0], upper[i, 0]):
            for pz in (lower[i, 2], upper[i, 2]):
                furthest = max(furthest, abs((px - bx) * nx + (pz - bz) * nz))
        row[5], row[6] = math.degrees(free), math.degrees(touch)
        row[7] = math.degrees(_side(i, step, lower, upper, nx, nz))
        row[8], row[9] = math.degrees(catch), math.degrees(angle)
        row[10] += angle * furthest
        x, z = bx + 1e-6 * (x - bx), bz + 1e-6 * (z - bz)
    if supported:
        pressures(x, z, xs, zs, areas, count, forces)
        for k in range(count):
            share = weight * forces[k]
            press[who[k], i, 0] += share
            press[who[k], i, 1] += share * xs[k]
            press[who[k], i, 2] += share * zs[k]

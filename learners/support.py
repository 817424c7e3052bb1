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

from steadyload.layouts.model.layout import TOLERANCE, FloatArray
from steadyload.learners.compiled import compiled
from steadyload.learners.convex_hull import margin_in, pressures, sort_points
from steadyload.statics.kernels.convex_hull import hull_of

SECONDS, GRAVITY = 0.3, 980.0
"""Time [s] and acceleration [cm/s2] that a label gives an item to fall."""

STATE = (
    "supported share", "supporters", "margin", "relative margin", "drop", "free angle",
    "touch angle", "side angle", "catch angle", "angle", "way", "excess", "held angle",
    "box height", "lever", "load", "shorter side",
)  # fmt: skip
OWN = ("on the floor", *STATE, "height", "weight", "mass height")
WORST = (
    *(f"worst {name}" for name in (*STATE, "height")),
    "least margin", "items below", "unbalanced", "moving",
)  # fmt: skip
COLUMNS = OWN + WORST
"""Columns of :func:`support_table`: of item j itself, then of the item in the greatest danger among
those that the step reaches, and over them all. None depends on the pallet but for the edges of a
deck, nor on where on it an item stands, nor on the unit of weight; none changes when the layout is
turned or mirrored.

Margins [cm] are signed distances of a resultant from the border of the support, positive inside;
relative ones are in shares of the item's shorter horizontal side. ``drop``: free height below an
item that nothing supports [cm]; its margin is that where it lands. ``free angle``: how far an item
would tip in the time, were there nothing in its way; ``touch angle``: at which it first meets
something below; ``side angle``: at its side; ``catch angle``: at which all that it has met below
holds it, as the resultant lies over it [degrees]. ``angle``: the lesser of free and catch;
``held angle``: of that and side; ``way``: of the corner that gets furthest, the drop included [cm].
``excess``: by how much the greater of angle and way exceeds a label's threshold, finely, and cut
off where it is far. ``lever``: of the resultant about the edge that it tips over [cm]; ``load``:
weight carried over own weight; ``height``: of the base above the floor [cm]; ``weight``: over that
of the items that it stands on, 1 on the floor; ``mass height``: of the centre of mass, in shares of
the item's height. ``unbalanced``, ``moving``: items with a margin below 0, and an excess above 0.
"""

THRESHOLD = 10.0
"""Of a label: a way [cm] or an angle [degrees] beyond which an item has moved too far."""

FLAT = 1e-9
"""Cross product of two edges below which a point between them is no corner of a hull [cm2]."""

_STATE, _OWN, _COLUMNS = len(STATE), len(OWN), len(COLUMNS)

_FAR, _SAFE = 500.0, 90.0
"""Margin of items on the floor [cm], and the angle that means that nothing is in the way."""

_REACH = 0.5 * GRAVITY * SECONDS * SECONDS


@compiled
def _on_floor(
    i: int, lower: FloatArray, upper: FloatArray, floor: FloatArray
) -> tuple[float, float, float, float]:
    """The part of an item's base that the floor lies below: x0, x1, z0, z1."""
    x0, x1 = max(lower[i, 0], floor[0]), min(upper[i, 0], floor[2])
    return x0, x1, max(lower[i, 2], floor[1]), min(upper[i, 2], floor[3])


@compiled
def _overhangs(i: int, lower: FloatArray, upper: FloatArray, floor: FloatArray) -> bool:
    """True if the base of an item stands out over an edge of the floor."""
    out = max(floor[0] - lower[i, 0], upper[i, 0] - floor[2])
    return max(out, max(floor[1] - lower[i, 2], upper[i, 2] - floor[3])) > TOLERANCE


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
    edge: FloatArray, corners: int, hx: FloatArray, hz: FloatArray, floor: FloatArray,
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
        floor: see :func:`support_table`.
    """
    size = 4 * (step + 4) + corners
    angles, rects, met = np.empty(step + 3), np.empty((step + 3, 4)), 0
    # The floor is numbered -1, and the ground beyond its edges -2.
    for k in range(-2 if _overhangs(i, lower, upper, floor) else -1, step + 1):
        if k == i:
            continue
        x0, x1, z0, z1 = lower[i, 0], upper[i, 0], lower[i, 2], upper[i, 2]
        top = -floor[4] if k == -2 else 0.0
        if k == -1:
            x0, x1, z0, z1 = _on_floor(i, lower, upper, floor)
        if k >= 0:
            top = upper[k, 1]
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
        hull = hull_of(xs, zs, count, ox, oz, FLAT)
        if margin_in(x, z, ox, oz, hull)[0] >= 0.0:
            return angles[0], angles[k]
    return angles[0], math.pi / 2.0


@compiled
def _drop(i: int, step: int, lower: FloatArray, upper: FloatArray, floor: FloatArray) -> float:
    """Height that an item without support can fall [cm]."""
    x0, x1, z0, z1 = _on_floor(i, lower, upper, floor)
    off = min(x1 - x0, z1 - z0) <= TOLERANCE
    gap = lower[i, 1] + floor[4] if off else max(lower[i, 1], 0.0)
    for k in range(step + 1):
        if k != i and upper[k, 1] <= lower[i, 1] + TOLERANCE:
            wide = min(upper[i, 0], upper[k, 0]) - max(lower[i, 0], lower[k, 0])
            deep = min(upper[i, 2], upper[k, 2]) - max(lower[i, 2], lower[k, 2])
            if wide > TOLERANCE and deep > TOLERANCE:
                gap = min(gap, max(lower[i, 1] - upper[k, 1], 0.0))
    return gap


@compiled
def support_table(
    lower: FloatArray, upper: FloatArray, weights: FloatArray, centres: FloatArray,
    floor: FloatArray,
) -> FloatArray:  # fmt: skip
    """The :data:`COLUMNS` of every step.

    Args:
        lower: left-bottom-back corners of the items in loading order [cm], shape (n, 3), y up.
        upper: the opposite corners.
        weights: [kg], shape (n,).
        centres: centres of mass in space [cm], shape (n, 3).
        floor: x0, z0, x1, z1 of what carries, infinite for a plane, and its height above the ground
            beyond its edges, 0 for a plane [cm], shape (5,).

    Returns:
        Shape (n, len(COLUMNS)); row j depends on the items 0 to j alone.
    """
    n = len(weights)
    out = np.zeros((n, _COLUMNS))
    state = np.zeros((n, _STATE))
    press = np.zeros((n, n, 3))  # of the item above (second) on the one below: force, times x, z
    carries = np.zeros((n, n), dtype=np.bool_)
    reached = np.zeros(n, dtype=np.bool_)
    order = np.argsort(-lower[:, 1], kind="mergesort")
    size = 4 * n + 8
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
                _stand(i, step, lower, upper, weights, centres, floor, carries, press, state,
                       xs, zs, areas, forces, hx, hz, who)  # fmt: skip
        row = out[step]
        row[0] = 1.0 if lower[step, 1] <= TOLERANCE else 0.0
        row[1 : _STATE + 1] = state[step]
        carriers = 0.0
        for k in range(step):
            if carries[k, step]:
                carriers += weights[k]
        tall = upper[step, 1] - lower[step, 1]
        row[_STATE + 1] = lower[step, 1]
        row[_STATE + 2] = weights[step] / carriers if carriers > 0.0 else 1.0
        row[_STATE + 3] = (centres[step, 1] - lower[step, 1]) / tall
        worst, least, unbalanced, moving = step, 1e300, 0, 0
        for k in range(step + 1):
            if reached[k]:
                least = min(least, state[k, 2])
                unbalanced += state[k, 2] < 0.0
                moving += state[k, 11] > 0.0
                danger = max(state[k, 9], state[k, 10]) - 1e-3 * state[k, 2]
                if danger > max(state[worst, 9], state[worst, 10]) - 1e-3 * state[worst, 2]:
                    worst = k
        rest = _OWN + _STATE
        row[_OWN:rest] = state[worst]
        row[rest] = lower[worst, 1]
        row[rest + 1], row[rest + 2] = least, count - 1
        row[rest + 3], row[rest + 4] = unbalanced, moving
    return out


@compiled
def _excess(most: float) -> float:
    """Half units above a label's threshold, between -3 and 3."""
    return min(max(2.0 * (most - THRESHOLD), -3.0), 3.0)


@compiled
def _stand(
    i: int, step: int, lower: FloatArray, upper: FloatArray, weights: FloatArray,
    centres: FloatArray, floor: FloatArray, carries: FloatArray, press: FloatArray,
    state: FloatArray, xs: FloatArray, zs: FloatArray, areas: FloatArray, forces: FloatArray,
    hx: FloatArray, hz: FloatArray, who: FloatArray,
) -> None:  # fmt: skip
    """Support of item i under its load, into ``state``; the force it exerts, into ``press``."""
    row = state[i]
    wide, deep = upper[i, 0] - lower[i, 0], upper[i, 2] - lower[i, 2]
    row[:] = 0.0
    row[6] = row[7] = row[8] = _SAFE
    row[11] = _excess(0.0)
    row[13], row[16] = upper[i, 1] - lower[i, 1], min(wide, deep)
    load = 0.0
    for k in range(step + 1):
        load += press[i, k, 0]
    row[15] = load / weights[i]
    overhangs = _overhangs(i, lower, upper, floor)
    if lower[i, 1] <= TOLERANCE and not overhangs:
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
    fx0, fx1, fz0, fz1 = _on_floor(i, lower, upper, floor)
    supported = lower[i, 1] <= TOLERANCE and min(fx1 - fx0, fz1 - fz0) > TOLERANCE
    for k in range(step + 1):
        supported = supported or carries[k, i]
    level = lower[i, 1] if supported else lower[i, 1] - _drop(i, step, lower, upper, floor)
    row[4] = lower[i, 1] - level
    row[10] = min(row[4], _REACH)
    if level <= (-floor[4] if overhangs else 0.0) + TOLERANCE:  # it falls, and stays upright
        row[2], row[3] = _FAR, 1.0
        row[11] = _excess(row[10])
        return
    count, covered = 0, 0.0
    for k in range(-1, step + 1):
        x0, x1, z0, z1 = fx0, fx1, fz0, fz1
        held = abs(level) <= TOLERANCE
        if k >= 0:
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
    corners = hull_of(xs, zs, count, hx, hz, FLAT)
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
            i, step, level, lower, upper, x, z, np.array([bx, bz, nx, nz]), corners, hx, hz, floor
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
        row[12] = min(row[9], row[7])
        row[14] = lever
        x, z = bx + 1e-6 * (x - bx), bz + 1e-6 * (z - bz)
    row[11] = _excess(max(row[9], row[10]))
    if supported:
        pressures(x, z, xs, zs, areas, count, forces)
        for k in range(count):
            share = weight * forces[k]
            if who[k] < 0:
                continue
            press[who[k], i, 0] += share
            press[who[k], i, 1] += share * xs[k]
            press[who[k], i, 2] += share * zs[k]

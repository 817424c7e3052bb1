"""How an item stands on what is below it, step by step: compiled, some microseconds a layout.

Everything is told from the items placed by then. At step j the weight of item j goes down one way
(the evenest pressure that has its resultant where it must be), and every item that it reaches is
asked two things: how far inside its support the resultant of its load lies, and, where it lies
outside, how far the item would tip or fall within the time that a label gives it. No equilibrium is
solved: where forces could be shared otherwise, this sees a danger that is none.
"""

from __future__ import annotations

import math

import numpy as np

from harness.layouts.model import TOLERANCE, FloatArray
from learners.compiled import compiled

SECONDS, GRAVITY = 0.3, 980.0
"""What a label gives an item to fall: time [s] and acceleration [cm/s2]."""

OWN = (
    "on the floor", "supported share", "supporters", "margin", "relative margin", "drop",
    "free angle", "limit angle", "angle", "way", "height",
)  # fmt: skip
WORST = (
    "worst margin", "worst relative margin", "worst drop", "worst free angle", "worst limit angle",
    "worst angle", "worst way", "worst load", "least margin", "items below",
)  # fmt: skip
COLUMNS = OWN + WORST
"""Columns of :func:`support_table`: of item j itself, then of the item in the greatest danger among
those that the step reaches, and over them all.

Margins [cm] are signed distances of a resultant from the border of the support, positive inside;
relative ones are in shares of the item's shorter horizontal side. ``drop``: free height below an
item that nothing supports [cm]. ``free angle``: how far an item would tip in the time, were there
nothing in its way; ``limit angle``: at which something is [degrees]. ``angle``: the lesser of the
two; ``way``: of the corner that gets furthest [cm]. ``load``: weight carried over own weight.
"""

_FAR, _SAFE = 500.0, 90.0
"""A margin of what stands on the floor [cm], and the angle that stands for nothing in the way."""

_ROUNDS = 6
_REACH = 0.5 * GRAVITY * SECONDS * SECONDS


@compiled
def _hull(xs: FloatArray, zs: FloatArray, count: int, hx: FloatArray, hz: FloatArray) -> int:
    """The convex hull, counter-clockwise, of points sorted by (x, z); returns its corners."""
    size = 0
    for turn in range(2):
        start = size
        for step in range(count):
            k = step if turn == 0 else count - 1 - step
            while size - start > 1:
                cross = (hx[size - 1] - hx[size - 2]) * (zs[k] - hz[size - 2]) - (
                    hz[size - 1] - hz[size - 2]
                ) * (xs[k] - hx[size - 2])
                if cross > 1e-9:
                    break
                size -= 1
            hx[size], hz[size] = xs[k], zs[k]
            size += 1
        size -= 1
    return size


@compiled
def _margin(
    x: float, z: float, hx: FloatArray, hz: FloatArray, count: int
) -> tuple[float, float, float, float, float]:
    """Signed distance to the border, positive inside; the nearest point; the way outwards."""
    best, inside = 1e300, True
    bx = bz = nx = nz = 0.0
    for k in range(count):
        ax, az = hx[k], hz[k]
        ex, ez = hx[(k + 1) % count] - ax, hz[(k + 1) % count] - az
        length = math.sqrt(ex * ex + ez * ez)
        if length < 1e-12:
            continue
        side = (ex * (z - az) - ez * (x - ax)) / length
        inside = inside and side >= 0.0
        along = min(max((ex * (x - ax) + ez * (z - az)) / (length * length), 0.0), 1.0)
        px, pz = ax + along * ex, az + along * ez
        away = math.sqrt((x - px) ** 2 + (z - pz) ** 2)
        if away < best - 1e-9:
            best, bx, bz = away, px, pz
            nx, nz = ez / length, -ex / length
    if not inside and best > 1e-9:
        nx, nz = (x - bx) / best, (z - bz) / best
    return (best if inside else -best), bx, bz, nx, nz


@compiled
def _press(
    x: float, z: float, cx: FloatArray, cz: FloatArray, areas: FloatArray, count: int,
    forces: FloatArray,
) -> None:  # fmt: skip
    """Shares of a unit load at (x, z) among points: the evenest pressure that is nowhere below 0.

    A pressure linear in x and z by least squares; points that would pull are left out and it is
    solved again. Where rounds run out, what pulls is cut off and the rest scaled to the load.
    """
    forces[:count] = areas[:count]
    for _ in range(_ROUNDS):
        s = sx = sz = sxx = sxz = szz = 0.0
        for k in range(count):
            if forces[k] > 0.0:
                a, u, v = areas[k], cx[k] - x, cz[k] - z
                s += a
                sx += a * u
                sz += a * v
                sxx += a * u * u
                sxz += a * u * v
                szz += a * v * v
        # A little ridge keeps points on one line solvable.
        sxx += 1e-9 * s
        szz += 1e-9 * s
        # [s sx sz; sx sxx sxz; sz sxz szz] (a, b, c) = (1, 0, 0)
        c0, c1, c2 = sxx * szz - sxz * sxz, sxz * sz - sx * szz, sx * sxz - sxx * sz
        det = s * c0 + sx * c1 + sz * c2
        if not abs(det) > 1e-300:
            break
        pulled = False
        for k in range(count):
            if forces[k] > 0.0:
                value = areas[k] * (c0 + c1 * (cx[k] - x) + c2 * (cz[k] - z)) / det
                forces[k] = value
                pulled = pulled or value < -1e-12
        if not pulled:
            break
    total = 0.0
    for k in range(count):
        forces[k] = max(forces[k], 0.0)
        total += forces[k]
    for k in range(count):
        forces[k] = forces[k] / total if total > 0.0 else 1.0 / count


@compiled
def _limit(
    i: int, step: int, lower: FloatArray, upper: FloatArray, bx: float, bz: float, nx: float,
    nz: float,
) -> float:  # fmt: skip
    """The angle [rad] at which an item that tips over (bx, bz) towards (nx, nz) meets another."""
    best = math.pi / 2.0
    reach = 0.0
    for x in (lower[i, 0], upper[i, 0]):
        for z in (lower[i, 2], upper[i, 2]):
            reach = max(reach, (x - bx) * nx + (z - bz) * nz)
    if reach > 1e-6:
        best = min(best, math.atan2(lower[i, 1], reach))
    for k in range(step + 1):
        if k == i:
            continue
        x0, x1 = max(lower[i, 0], lower[k, 0]), min(upper[i, 0], upper[k, 0])
        z0, z1 = max(lower[i, 2], lower[k, 2]), min(upper[i, 2], upper[k, 2])
        y1 = min(upper[i, 1], upper[k, 1])
        if x1 - x0 > TOLERANCE and z1 - z0 > TOLERANCE and upper[k, 1] <= lower[i, 1] + TOLERANCE:
            far = (x1 if nx > 0 else x0) * nx + (z1 if nz > 0 else z0) * nz - bx * nx - bz * nz
            if far > 1e-6:
                best = min(best, math.atan2(max(lower[i, 1] - upper[k, 1], 0.0), far))
        elif y1 - max(lower[i, 1], lower[k, 1]) > TOLERANCE:
            lever = y1 - lower[i, 1]
            if z1 - z0 > TOLERANCE and abs(nx) > 0.3:
                gap = lower[k, 0] - upper[i, 0] if nx > 0 else lower[i, 0] - upper[k, 0]
                if gap >= -TOLERANCE:
                    best = min(best, math.atan2(max(gap, 0.0), lever * abs(nx)))
            if x1 - x0 > TOLERANCE and abs(nz) > 0.3:
                gap = lower[k, 2] - upper[i, 2] if nz > 0 else lower[i, 2] - upper[k, 2]
                if gap >= -TOLERANCE:
                    best = min(best, math.atan2(max(gap, 0.0), lever * abs(nz)))
    return best


@compiled
def _drop(i: int, step: int, lower: FloatArray, upper: FloatArray) -> float:
    """How far an item without support can fall [cm]."""
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
        Shape (n, len(COLUMNS)); row j hangs on the items 0 to j alone.
    """
    n = len(weights)
    out = np.zeros((n, 21))
    state = np.zeros((n, 9))
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
        row[1:10] = state[step]
        row[10] = lower[step, 1]
        worst, least = step, 1e300
        for k in range(step + 1):
            if reached[k]:
                least = min(least, state[k, 2])
                danger = max(state[k, 7], state[k, 8]) - 1e-3 * state[k, 2]
                if danger > max(state[worst, 7], state[worst, 8]) - 1e-3 * state[worst, 2]:
                    worst = k
        row[11:18] = state[worst, 2:9]
        load = 0.0
        for k in range(step + 1):
            load += press[worst, k, 0]
        row[18] = load / weights[worst]
        row[19] = least
        row[20] = count - 1
    return out


@compiled
def _stand(
    i: int, step: int, lower: FloatArray, upper: FloatArray, weights: FloatArray,
    centres: FloatArray, carries: FloatArray, press: FloatArray, state: FloatArray, xs: FloatArray,
    zs: FloatArray, areas: FloatArray, forces: FloatArray, hx: FloatArray, hz: FloatArray,
    who: FloatArray,
) -> None:  # fmt: skip
    """How item i stands under its load, into ``state``; what it presses with, into ``press``."""
    row = state[i]
    wide, deep = upper[i, 0] - lower[i, 0], upper[i, 2] - lower[i, 2]
    row[:] = 0.0
    if lower[i, 1] <= TOLERANCE:
        row[0], row[2], row[3], row[6] = 1.0, _FAR, 1.0, _SAFE
        return
    weight, x, z = weights[i], weights[i] * centres[i, 0], weights[i] * centres[i, 2]
    for k in range(step + 1):
        weight += press[i, k, 0]
        x += press[i, k, 1]
        z += press[i, k, 2]
    x /= weight
    z /= weight
    count, covered = 0, 0.0
    for k in range(step + 1):
        press[k, i, :] = 0.0
        if carries[k, i]:
            x0, x1 = max(lower[i, 0], lower[k, 0]), min(upper[i, 0], upper[k, 0])
            z0, z1 = max(lower[i, 2], lower[k, 2]), min(upper[i, 2], upper[k, 2])
            area = (x1 - x0) * (z1 - z0)
            covered += area
            row[1] += 1.0
            for px in (x0, x1):
                for pz in (z0, z1):
                    xs[count], zs[count], areas[count], who[count] = px, pz, 0.25 * area, k
                    count += 1
    row[0] = covered / (wide * deep)
    if not count:
        row[4] = _drop(i, step, lower, upper)
        row[2], row[3], row[6] = -max(wide, deep), -1.0, _SAFE
        row[8] = min(row[4], _REACH)
        return
    for a in range(1, count):  # sorted by (x, z), as the hull wants them
        b = a
        while b and (xs[b - 1] > xs[b] or (xs[b - 1] == xs[b] and zs[b - 1] > zs[b])):
            xs[b - 1], xs[b] = xs[b], xs[b - 1]
            zs[b - 1], zs[b] = zs[b], zs[b - 1]
            areas[b - 1], areas[b] = areas[b], areas[b - 1]
            who[b - 1], who[b] = who[b], who[b - 1]
            b -= 1
    corners = _hull(xs, zs, count, hx, hz)
    margin, bx, bz, nx, nz = _margin(x, z, hx, hz, corners)
    row[2], row[3], row[6] = margin, margin / min(wide, deep), _SAFE
    if margin < 0.0:
        # A box that tips over an edge: (r2 + d2 + h2) a'' = g (d + h a), from rest.
        lever, high = -margin, centres[i, 1] - lower[i, 1]
        along = abs(nx) * wide + abs(nz) * deep
        inertia = (along * along + (upper[i, 1] - lower[i, 1]) ** 2) / 12.0 + lever**2 + high**2
        rate = SECONDS * math.sqrt(GRAVITY * high / inertia) if high > 0.0 else 0.0
        ratio = lever / high if high > 0.0 else 0.0
        free = ratio * (math.cosh(min(rate, 20.0)) - 1.0)
        free = min(free, math.pi / 2.0)
        limit = _limit(i, step, lower, upper, bx, bz, nx, nz)
        angle = min(free, limit)
        furthest = 0.0
        for px in (lower[i, 0], upper[i, 0]):
            for pz in (lower[i, 2], upper[i, 2]):
                furthest = max(furthest, abs((px - bx) * nx + (pz - bz) * nz))
        furthest = max(furthest, upper[i, 1] - lower[i, 1])
        row[5], row[6] = math.degrees(free), math.degrees(limit)
        row[7], row[8] = math.degrees(angle), angle * furthest
        x, z = bx + 1e-6 * (x - bx), bz + 1e-6 * (z - bz)
    _press(x, z, xs, zs, areas, count, forces)
    for k in range(count):
        share = weight * forces[k]
        press[who[k], i, 0] += share
        press[who[k], i, 1] += share * xs[k]
        press[who[k], i, 2] += share * zs[k]

"""Margins and pressures in the horizontal plane (x, z) [cm]: compiled, no objects."""

from __future__ import annotations

import math

from steadyload.layouts.model.layout import FloatArray
from steadyload.learners.compiled import compiled

_ROUNDS = 6
"""Of leaving out points that would pull."""


@compiled
def margin_in(
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
def pressures(
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
def sort_points(
    xs: FloatArray, zs: FloatArray, areas: FloatArray, who: FloatArray, count: int
) -> None:
    """Sort points by (x, z), as the hull wants them, with what belongs to them."""
    for a in range(1, count):
        b = a
        while b and (xs[b - 1] > xs[b] or (xs[b - 1] == xs[b] and zs[b - 1] > zs[b])):
            xs[b - 1], xs[b] = xs[b], xs[b - 1]
            zs[b - 1], zs[b] = zs[b], zs[b - 1]
            areas[b - 1], areas[b] = areas[b], areas[b - 1]
            who[b - 1], who[b] = who[b], who[b - 1]
            b -= 1

"""Damping of a contact by the mass that it stops, so that all contacts rebound alike.

A contact that gives way by K W d, with W the weight of the corners that carry, and stops the mass m
along its normal, is damped by 2 z sqrt(K W m). What moves at the contact is taken at the centre of
its pressure, where an impact acts; m is one over what a unit of impulse there changes the speed by.
"""

from __future__ import annotations

import math

from steadyload.engines.reference.compilation import compiled


@compiled
def put_ease(body, out):
    """Fill in one over the mass and the principal moments of a body; zeros where it is fixed."""
    out[:] = 0.0
    if not body.fixed:
        out[0] = 1.0 / body.mass
        for i in range(3):
            out[1 + i] = 1.0 / body.inertia[i]


@compiled
def damp(law, count, want, s):
    """Fill in ``s.damping``, of the whole polygon, and its derivatives by the relative pose.

    The weight W that carries is (sum of w d)^2 / (sum of w d^2), for corners of weights w at depths
    d: that of the corners where all are equally deep, and no jump where another one touches.

    Args:
        law: contact parameters, with a damping ratio.
        count: number of corners.
        want: whether derivatives are wanted.
        s: scratch with the corners, their weights and depths, the normal and what is easily moved.
    """
    first = second = x = y = z = 0.0
    for m in range(count):
        depth = s.depths[m]
        if depth > 0.0:
            load = s.weights[m] * depth
            first += load
            second += load * depth
            x += load * s.points[m, 0]
            y += load * s.points[m, 1]
            z += load * s.points[m, 2]
    if first <= 0.0:
        return
    x, y, z = x / first, y / first, z / first
    n, of, to, spun = s.normal, s.mass_centre, s.reference_centre, s.spun
    # Levers of the impulse about both centres of mass, and the turns that it makes about own axes.
    lx, ly, lz = x - of[0], y - of[1], z - of[2]
    kx, ky, kz = x - to[0], y - to[1], z - to[2]
    ax, ay, az = ly * n[2] - lz * n[1], lz * n[0] - lx * n[2], lx * n[1] - ly * n[0]
    bx, by, bz = ky * n[2] - kz * n[1], kz * n[0] - kx * n[2], kx * n[1] - ky * n[0]
    one, two = s.incident_ease, s.reference_ease
    u0 = spun[0, 0] * ax + spun[1, 0] * ay + spun[2, 0] * az
    u1 = spun[0, 1] * ax + spun[1, 1] * ay + spun[2, 1] * az
    u2 = spun[0, 2] * ax + spun[1, 2] * ay + spun[2, 2] * az
    ease = one[0] + one[1] * u0 * u0 + one[2] * u1 * u1 + one[3] * u2 * u2
    ease += two[0] + two[1] * bx * bx + two[2] * by * by + two[3] * bz * bz
    share = first * first / second
    s.damping = 2.0 * law.damping_ratio * math.sqrt(law.stiffness / (s.softening * share * ease))
    if not want:
        return
    for c in range(6):
        first_slope = second_slope = px = py = pz = 0.0
        for m in range(count):
            depth = s.depths[m]
            if depth > 0.0:
                change = s.weight_slopes[m, c] * depth + s.weights[m] * s.depth_slopes[m, c]
                load = s.weights[m] * depth
                first_slope += change
                second_slope += (change + s.weights[m] * s.depth_slopes[m, c]) * depth
                px += change * (s.points[m, 0] - x) + load * s.slopes[m, 0, c]
                py += change * (s.points[m, 1] - y) + load * s.slopes[m, 1, c]
                pz += change * (s.points[m, 2] - z) + load * s.slopes[m, 2, c]
        kx_, ky_, kz_ = px / first, py / first, pz / first
        lx_, ly_, lz_ = kx_, ky_, kz_
        tx = ty = tz = 0.0  # the incident body's turn
        if c == 0:
            lx_ -= 1.0
        elif c == 1:
            ly_ -= 1.0
        elif c == 2:
            lz_ -= 1.0
        elif c == 3:
            tx = 1.0
        elif c == 4:
            ty = 1.0
        else:
            tz = 1.0
        nx, ny, nz = s.normal_slopes[0, c], s.normal_slopes[1, c], s.normal_slopes[2, c]
        gx = ly_ * n[2] - lz_ * n[1] + ly * nz - lz * ny - (ty * az - tz * ay)
        gy = lz_ * n[0] - lx_ * n[2] + lz * nx - lx * nz - (tz * ax - tx * az)
        gz = lx_ * n[1] - ly_ * n[0] + lx * ny - ly * nx - (tx * ay - ty * ax)
        hx = ky_ * n[2] - kz_ * n[1] + ky * nz - kz * ny
        hy = kz_ * n[0] - kx_ * n[2] + kz * nx - kx * nz
        hz = kx_ * n[1] - ky_ * n[0] + kx * ny - ky * nx
        slope = one[1] * u0 * (spun[0, 0] * gx + spun[1, 0] * gy + spun[2, 0] * gz)
        slope += one[2] * u1 * (spun[0, 1] * gx + spun[1, 1] * gy + spun[2, 1] * gz)
        slope += one[3] * u2 * (spun[0, 2] * gx + spun[1, 2] * gy + spun[2, 2] * gz)
        slope += two[1] * bx * hx + two[2] * by * hy + two[3] * bz * hz
        relative = first_slope / first - 0.5 * second_slope / second + slope / ease
        s.damping_slopes[c] = -s.damping * relative

"""The wrench between two bodies, and its exact derivatives by their relative motion."""

from __future__ import annotations

import math

import numpy as np

from steadyload.engines.reference.compilation import compiled
from steadyload.engines.reference.damping import damp, put_ease
from steadyload.engines.reference.law import friction_ratio, normal_force, softening
from steadyload.engines.reference.polygon import (
    APART,
    CORNERS,
    EDGES,
    FACE_OF_SECOND,
    clip,
    corner_weights,
    crossing,
    incident_face,
    merge_corners,
    rigid,
    separation,
)

FLOOR = -1
"""The body that is not there: an infinite plane with its normal along z."""

_CROSSING_WEIGHT = 0.25
"""Of two edges that cross: the exterior angle of a right corner over 2 pi, as in a polygon."""


BODY = np.dtype(
    [
        ("half", np.float64, (3,)),
        ("offset", np.float64, (3,)),
        ("mass", np.float64),
        ("inertia", np.float64, (3,)),
        ("extent", np.float64),
        ("fixed", np.bool_),
    ],
    align=True,
)
"""What does not change while a body moves: half edge lengths [m], centre of mass minus geometric
centre [m] and principal moments [kg m2] in body axes, the largest distance of a corner from the
centre of mass (or a little more) [m], and whether the body is part of the surroundings."""

_SCRATCH = np.dtype(
    [
        ("points", np.float64, (CORNERS, 3)),
        ("slopes", np.float64, (CORNERS, 3, 6)),
        ("spare", np.float64, (CORNERS, 3)),
        ("spare_slopes", np.float64, (CORNERS, 3, 6)),
        ("weights", np.float64, (CORNERS,)),
        ("weight_slopes", np.float64, (CORNERS, 6)),
        ("normal", np.float64, (3,)),
        ("normal_slopes", np.float64, (3, 6)),
        ("depths", np.float64, (CORNERS,)),
        ("depth_slopes", np.float64, (CORNERS, 6)),
        ("wrench", np.float64, (6,)),
        ("gradient", np.float64, (6, 12)),
        ("turned", np.float64, (6, 12)),
        # Where and how the incident box is, as seen from the reference box: axes, geometric
        # centre, centre of mass, and that body's relative velocities.
        ("spun", np.float64, (3, 3)),
        ("shift", np.float64, (3,)),
        ("mass_centre", np.float64, (3,)),
        ("speed", np.float64, (3,)),
        ("spin", np.float64, (3,)),
        ("softening", np.float64),
        # Damping of the whole polygon, and, where that follows the bodies: what they oppose to it,
        # one over the mass and the moments about their own axes, 0 for what does not move.
        ("damping", np.float64),
        ("damping_slopes", np.float64, (6,)),
        ("incident_ease", np.float64, (4,)),
        ("reference_ease", np.float64, (4,)),
        ("reference_centre", np.float64, (3,)),
    ],
    align=True,
)


def make_scratch() -> np.void:
    """Memory that one evaluation after the other writes into.

    A record travels as one pointer; a tuple of arrays would cost more to hand over than to use.
    """
    return np.rec.array(np.zeros(1, _SCRATCH))[0]


@compiled
def _add_points(law, count, want, s):
    """Add the forces and torques of ``count`` corners to ``s.wrench``, and their derivatives."""
    s.damping = law.damping
    if law.damping_ratio > 0.0:
        damp(law, count, want, s)
    for m in range(count):
        if s.depths[m] > 0.0:
            _add_point(law, m, s.depths[m], s.weights[m], want, s)


@compiled
def _add_point(law, m, depth, weight, want, s):
    """Add the force and torque of corner ``m`` to ``s.wrench``, and their derivatives.

    Columns of ``s.gradient``: the relative translation and rotation, then the relative velocity
    of the incident body's centre of mass and its relative angular velocity.
    """
    n, spin, slopes = s.normal, s.spin, s.slopes
    rx = s.points[m, 0] - s.mass_centre[0]
    ry = s.points[m, 1] - s.mass_centre[1]
    rz = s.points[m, 2] - s.mass_centre[2]
    vx = s.speed[0] + spin[1] * rz - spin[2] * ry
    vy = s.speed[1] + spin[2] * rx - spin[0] * rz
    vz = s.speed[2] + spin[0] * ry - spin[1] * rx
    away = n[0] * vx + n[1] * vy + n[2] * vz
    force, by_depth, by_rate = normal_force(law, s.damping, depth, -away)
    if force == 0.0:
        return
    force, by_depth, by_rate = s.softening * force, s.softening * by_depth, s.softening * by_rate
    vx -= away * n[0]
    vy -= away * n[1]
    vz -= away * n[2]
    ratio, bend = friction_ratio(law, math.sqrt(vx * vx + vy * vy + vz * vz))
    dx, dy, dz = n[0] - ratio * vx, n[1] - ratio * vy, n[2] - ratio * vz
    share = weight * force
    fx, fy, fz = share * dx, share * dy, share * dz
    wrench, gradient = s.wrench, s.gradient
    wrench[0] += fx
    wrench[1] += fy
    wrench[2] += fz
    wrench[3] += ry * fz - rz * fy
    wrench[4] += rz * fx - rx * fz
    wrench[5] += rx * fy - ry * fx
    if not want:
        return
    for c in range(12):
        px = py = pz = 0.0  # derivative of the lever
        nx = ny = nz = 0.0  # of the normal
        change = 0.0  # of the force
        if c < 6:
            px, py, pz = slopes[m, 0, c], slopes[m, 1, c], slopes[m, 2, c]
            if c == 0:
                px -= 1.0
            elif c == 1:
                py -= 1.0
            elif c == 2:
                pz -= 1.0
            ux = spin[1] * pz - spin[2] * py
            uy = spin[2] * px - spin[0] * pz
            uz = spin[0] * py - spin[1] * px
            nx, ny, nz = s.normal_slopes[0, c], s.normal_slopes[1, c], s.normal_slopes[2, c]
            change = s.weight_slopes[m, c] * force + weight * by_depth * s.depth_slopes[m, c]
            if law.damping_ratio > 0.0:
                change -= weight * by_rate * away * s.damping_slopes[c] / s.damping
        elif c == 6:
            ux, uy, uz = 1.0, 0.0, 0.0
        elif c == 7:
            ux, uy, uz = 0.0, 1.0, 0.0
        elif c == 8:
            ux, uy, uz = 0.0, 0.0, 1.0
        elif c == 9:
            ux, uy, uz = 0.0, -rz, ry
        elif c == 10:
            ux, uy, uz = rz, 0.0, -rx
        else:
            ux, uy, uz = -ry, rx, 0.0
        # The normal's derivative is normal to it, so only the sliding velocity and what is left
        # of the whole one (away * n) meet it.
        leave = n[0] * ux + n[1] * uy + n[2] * uz + nx * vx + ny * vy + nz * vz
        change -= weight * by_rate * leave
        ux -= leave * n[0] + away * nx
        uy -= leave * n[1] + away * ny
        uz -= leave * n[2] + away * nz
        sliding = bend * (vx * ux + vy * uy + vz * uz)
        gx = change * dx + share * (nx - ratio * ux - sliding * vx)
        gy = change * dy + share * (ny - ratio * uy - sliding * vy)
        gz = change * dz + share * (nz - ratio * uz - sliding * vz)
        gradient[0, c] += gx
        gradient[1, c] += gy
        gradient[2, c] += gz
        gradient[3, c] += ry * gz - rz * gy + py * fz - pz * fy
        gradient[4, c] += rz * gx - rx * gz + pz * fx - px * fz
        gradient[5, c] += rx * gy - ry * gx + px * fy - py * fx


@compiled
def _on_floor(law, height, half, want, s):
    """Fill the scratch with the wrench of a box on the plane z = ``height``, in world axes."""
    s.normal[0], s.normal[1], s.normal[2] = 0.0, 0.0, 1.0
    s.normal_slopes[:, :] = 0.0
    incident_face(half, s.spun, s.shift, 2, 1.0, s.points)
    for m in range(4):
        s.weights[m] = 0.25
        s.depths[m] = height - s.points[m, 2]
        if want and s.depths[m] > 0.0:
            s.weight_slopes[m] = 0.0
            rigid(s.points[m], s.mass_centre, s.slopes[m])
            for c in range(6):
                s.depth_slopes[m, c] = -s.slopes[m, 2, c]
    _add_points(law, 4, want, s)


@compiled
def _on_face(law, reference, incident, axis, want, s):
    """Fill the scratch with the wrench over a contact polygon, in the reference box's axes."""
    sign = 1.0 if s.shift[axis] >= 0.0 else -1.0
    one, two = (axis + 1) % 3, (axis + 2) % 3
    incident_face(incident, s.spun, s.shift, axis, sign, s.points)
    if want:
        for m in range(4):
            rigid(s.points[m], s.mass_centre, s.slopes[m])
    count = 4
    for a in (one, two):
        for side in (1.0, -1.0):
            count = clip(
                count, s.points, s.slopes, s.spare, s.spare_slopes, a, side, reference[a], want
            )
    if not count:
        return
    count = merge_corners(count, s.points, s.slopes, one, two, want)
    corner_weights(count, s.points, s.slopes, one, two, s.weights, s.weight_slopes, want)
    s.normal[0] = s.normal[1] = s.normal[2] = 0.0
    s.normal[axis] = sign
    s.normal_slopes[:, :] = 0.0
    for m in range(count):
        s.depths[m] = reference[axis] - sign * s.points[m, axis]
        if want and s.depths[m] > 0.0:
            for c in range(6):
                s.depth_slopes[m, c] = -sign * s.slopes[m, axis, c]
    _add_points(law, count, want, s)


@compiled
def _place_on_floor(bodies, a, p, turn, v, w, s):
    """Fill in the pose of a box relative to the floor."""
    for i in range(3):
        centre = p[a, i]
        for j in range(3):
            s.spun[i, j] = turn[a, i, j]
            centre -= turn[a, i, j] * bodies[a].offset[j]
        s.shift[i], s.mass_centre[i] = centre, p[a, i]
        s.speed[i], s.spin[i] = v[a, i], w[a, i]


@compiled
def _place(bodies, a, b, p, turn, s):
    """Fill in the pose of box ``b`` relative to box ``a``."""
    x, y, z = p[b, 0] - p[a, 0], p[b, 1] - p[a, 1], p[b, 2] - p[a, 2]
    bx, by, bz = bodies[b].offset[0], bodies[b].offset[1], bodies[b].offset[2]
    for i in range(3):
        ax, ay, az = turn[a, 0, i], turn[a, 1, i], turn[a, 2, i]
        for j in range(3):
            s.spun[i, j] = ax * turn[b, 0, j] + ay * turn[b, 1, j] + az * turn[b, 2, j]
        s.mass_centre[i] = bodies[a].offset[i] + ax * x + ay * y + az * z
        s.shift[i] = s.mass_centre[i] - (s.spun[i, 0] * bx + s.spun[i, 1] * by + s.spun[i, 2] * bz)


@compiled
def _move(incident, reference, p, turn, v, w, s):
    """Fill in the motion of the incident body relative to the reference body, which rotates."""
    x, y, z = (
        p[incident, 0] - p[reference, 0],
        p[incident, 1] - p[reference, 1],
        p[incident, 2] - p[reference, 2],
    )
    wx, wy, wz = w[reference, 0], w[reference, 1], w[reference, 2]
    vx = v[incident, 0] - v[reference, 0] - (wy * z - wz * y)
    vy = v[incident, 1] - v[reference, 1] - (wz * x - wx * z)
    vz = v[incident, 2] - v[reference, 2] - (wx * y - wy * x)
    wx, wy, wz = w[incident, 0] - wx, w[incident, 1] - wy, w[incident, 2] - wz
    for i in range(3):
        rx, ry, rz = turn[reference, 0, i], turn[reference, 1, i], turn[reference, 2, i]
        s.speed[i] = rx * vx + ry * vy + rz * vz
        s.spin[i] = rx * wx + ry * wy + rz * wz


@compiled
def touch(law, height, bodies, a, b, p, turn, v, w, want, s):
    """The wrench between bodies ``a`` and ``b``, or ``a`` and the floor (``b == FLOOR``).

    Args:
        law: contact parameters.
        height: the floor's z [m].
        bodies: sizes and the like.
        a: index of a body.
        b: index of another, or ``FLOOR``.
        p: centres of mass of all [m], shape (n, 3).
        turn: their axes as columns, shape (n, 3, 3).
        v: their velocities [m/s].
        w: their angular velocities [rad/s].
        want: whether derivatives are wanted.
        s: scratch; ``s.wrench`` is force and torque on the incident body about its centre of mass
            in world axes, ``s.gradient`` its derivatives by the relative motion as seen from the
            reference body, in world axes too.

    Returns:
        The incident and the reference body; (FLOOR, FLOOR) where there is no contact.
    """
    if b == FLOOR:
        lowest = p[a, 2]
        for i in range(3):
            lowest -= turn[a, 2, i] * bodies[a].offset[i] + abs(turn[a, 2, i]) * bodies[a].half[i]
        if lowest >= height:
            return FLOOR, FLOOR
        _clear(want, s)
        s.softening = softening(law, bodies[a].mass)
        _place_on_floor(bodies, a, p, turn, v, w, s)
        if law.damping_ratio > 0.0:
            put_ease(bodies[a], s.incident_ease)
            s.reference_ease[:] = 0.0
            s.reference_centre[:] = 0.0
        _on_floor(law, height, bodies[a].half, want, s)
        return a, FLOOR
    _place(bodies, a, b, p, turn, s)
    kind, one, two = separation(bodies[a].half, bodies[b].half, s.spun, s.shift)
    if kind == APART:
        return FLOOR, FLOOR
    _clear(want, s)
    light = math.inf if bodies[a].fixed else bodies[a].mass
    if not bodies[b].fixed:
        light = min(light, bodies[b].mass)
    s.softening = softening(law, light)
    incident, reference = b, a
    if kind == FACE_OF_SECOND:
        incident, reference = a, b
        _place(bodies, b, a, p, turn, s)
    _move(incident, reference, p, turn, v, w, s)
    if law.damping_ratio > 0.0:
        put_ease(bodies[incident], s.incident_ease)
        put_ease(bodies[reference], s.reference_ease)
        s.reference_centre[:] = bodies[reference].offset
    if kind == EDGES:
        s.depths[0] = crossing(
            bodies[a].half, bodies[b].half, s.spun, s.shift, s.mass_centre, one, two, s.normal,
            s.normal_slopes, s.points[0], s.slopes[0], s.depth_slopes[0],
        )  # fmt: skip
        s.weights[0] = _CROSSING_WEIGHT
        s.weight_slopes[0] = 0.0
        _add_points(law, 1, want, s)
    else:
        _on_face(law, bodies[reference].half, bodies[incident].half, one, want, s)
    _to_world(turn[reference], want, s)
    return incident, reference


@compiled
def _clear(want, s):
    s.wrench[:] = 0.0
    if want:
        s.gradient[:, :] = 0.0


@compiled
def _to_world(frame, want, s):
    """Turn the wrench and its derivatives from a frame into world axes."""
    for block in (0, 3):
        x, y, z = s.wrench[block], s.wrench[block + 1], s.wrench[block + 2]
        for i in range(3):
            s.wrench[block + i] = frame[i, 0] * x + frame[i, 1] * y + frame[i, 2] * z
    if not want:
        return
    for block in (0, 3):
        for i in range(3):
            for c in range(12):
                s.turned[block + i, c] = (
                    frame[i, 0] * s.gradient[block, c]
                    + frame[i, 1] * s.gradient[block + 1, c]
                    + frame[i, 2] * s.gradient[block + 2, c]
                )
    for r in range(6):
        for block in (0, 3, 6, 9):
            x, y, z = s.turned[r, block], s.turned[r, block + 1], s.turned[r, block + 2]
            for i in range(3):
                s.gradient[r, block + i] = frame[i, 0] * x + frame[i, 1] * y + frame[i, 2] * z

"""The wrench between two bodies, and its exact derivatives by their poses and velocities."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from engines.reference.compiled import compiled
from engines.reference.law import friction_ratio, normal_force
from engines.reference.polygon import (
    APART,
    CORNERS,
    EDGES,
    FACE_OF_FIRST,
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


class Bodies(NamedTuple):
    """What does not change while bodies move, shapes (n, 3) or (n,); SI.

    ``half``: half edge lengths. ``offset``: centre of mass minus geometric centre, body axes.
    ``fixed``: part of the surroundings. ``extent``: half the space diagonal.
    """

    half: np.ndarray
    offset: np.ndarray
    mass: np.ndarray
    inertia: np.ndarray
    fixed: np.ndarray
    extent: np.ndarray


class Scratch(NamedTuple):
    """Memory that one evaluation after the other writes into."""

    points: np.ndarray
    slopes: np.ndarray
    spare: np.ndarray
    spare_slopes: np.ndarray
    weights: np.ndarray
    weight_slopes: np.ndarray
    normal: np.ndarray
    normal_slopes: np.ndarray
    depth_slopes: np.ndarray
    wrench: np.ndarray
    gradient: np.ndarray
    turned: np.ndarray
    chained: np.ndarray


@compiled
def make_scratch():
    """Fresh memory for one thread of evaluation."""
    return Scratch(
        np.zeros((CORNERS, 3)),
        np.zeros((CORNERS, 3, 6)),
        np.zeros((CORNERS, 3)),
        np.zeros((CORNERS, 3, 6)),
        np.zeros(CORNERS),
        np.zeros((CORNERS, 6)),
        np.zeros(3),
        np.zeros((3, 6)),
        np.zeros(6),
        np.zeros(6),
        np.zeros((6, 12)),
        np.zeros((6, 12)),
        np.zeros((6, 24)),
    )


@compiled
def _add_point(law, point, slopes, depth, weight, weight_slopes, centre, speed, spin, want, s):
    """Add one point's force and torque about ``centre`` to ``s.wrench``, and their derivatives.

    Columns of ``s.gradient``: the relative translation and rotation, then the relative velocity
    of the incident body's centre of mass and its relative angular velocity.
    """
    n = s.normal
    rx, ry, rz = point[0] - centre[0], point[1] - centre[1], point[2] - centre[2]
    vx = speed[0] + spin[1] * rz - spin[2] * ry
    vy = speed[1] + spin[2] * rx - spin[0] * rz
    vz = speed[2] + spin[0] * ry - spin[1] * rx
    away = n[0] * vx + n[1] * vy + n[2] * vz
    force, by_depth, by_rate = normal_force(law, depth, -away)
    if force == 0.0:
        return
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
            px, py, pz = slopes[0, c], slopes[1, c], slopes[2, c]
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
            change = weight_slopes[c] * force + weight * by_depth * s.depth_slopes[c]
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
def _on_floor(law, height, half, centre, mass_centre, turn, speed, spin, want, s):
    """Fill the scratch with the wrench of a box on the plane z = ``height``, in world axes."""
    s.normal[0], s.normal[1], s.normal[2] = 0.0, 0.0, 1.0
    s.normal_slopes[:, :] = 0.0
    s.weight_slopes[0] = 0.0
    incident_face(half, turn, centre, 2, 1.0, s.points)
    for m in range(4):
        depth = height - s.points[m, 2]
        if depth > 0.0:
            if want:
                rigid(s.points[m], mass_centre, s.slopes[m])
                s.depth_slopes[:] = -s.slopes[m, 2]
            _add_point(
                law, s.points[m], s.slopes[m], depth, 0.25, s.weight_slopes[0], mass_centre,
                speed, spin, want, s,
            )  # fmt: skip


@compiled
def _on_face(law, reference, incident, turn, shift, mass_centre, axis, speed, spin, want, s):
    """Fill the scratch with the wrench over a contact polygon, in the reference box's axes."""
    sign = 1.0 if shift[axis] >= 0.0 else -1.0
    one, two = (axis + 1) % 3, (axis + 2) % 3
    incident_face(incident, turn, shift, axis, sign, s.points)
    if want:
        for m in range(4):
            rigid(s.points[m], mass_centre, s.slopes[m])
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
    s.normal[:] = 0.0
    s.normal[axis] = sign
    s.normal_slopes[:, :] = 0.0
    for m in range(count):
        depth = reference[axis] - sign * s.points[m, axis]
        if depth > 0.0:
            if want:
                s.depth_slopes[:] = -sign * s.slopes[m, axis]
            _add_point(
                law, s.points[m], s.slopes[m], depth, s.weights[m], s.weight_slopes[m],
                mass_centre, speed, spin, want, s,
            )  # fmt: skip


@compiled
def _to(frame, vector):
    """A world vector in the coordinates of a frame whose axes are columns."""
    out = np.empty(3)
    for i in range(3):
        out[i] = frame[0, i] * vector[0] + frame[1, i] * vector[1] + frame[2, i] * vector[2]
    return out


@compiled
def _cross(a, b):
    out = np.empty(3)
    out[0] = a[1] * b[2] - a[2] * b[1]
    out[1] = a[2] * b[0] - a[0] * b[2]
    out[2] = a[0] * b[1] - a[1] * b[0]
    return out


@compiled
def touch(law, height, bodies, a, b, p, turn, v, w, want, s):
    """The wrench between bodies ``a`` and ``b``, or ``a`` and the floor (``b == FLOOR``).

    Args:
        law: contact parameters.
        height: the floor's z [m].
        bodies: sizes and the like.
        a, b: indices.
        p, turn, v, w: centres of mass [m], axes as columns, velocities, angular velocities of all.
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
            lowest -= turn[a, 2, i] * bodies.offset[a, i] + abs(turn[a, 2, i]) * bodies.half[a, i]
        if lowest >= height:
            return FLOOR, FLOOR
        s.wrench[:] = 0.0
        if want:
            s.gradient[:, :] = 0.0
        centre = p[a].copy()
        for i in range(3):
            for j in range(3):
                centre[i] -= turn[a, i, j] * bodies.offset[a, j]
        _on_floor(
            law, height, bodies.half[a], centre, p[a], turn[a], v[a], w[a], want, s
        )  # fmt: skip
        return a, FLOOR
    # The second box in the first's frame.
    spun = np.empty((3, 3))
    shift = np.empty(3)
    apart = np.empty(3)
    for i in range(3):
        apart[i] = p[b, i] - p[a, i]
    for i in range(3):
        for j in range(3):
            spun[i, j] = (
                turn[a, 0, i] * turn[b, 0, j]
                + turn[a, 1, i] * turn[b, 1, j]
                + turn[a, 2, i] * turn[b, 2, j]
            )
        shift[i] = bodies.offset[a, i]
        for j in range(3):
            shift[i] += turn[a, j, i] * apart[j] - spun[i, j] * bodies.offset[b, j]
    kind, one, two = separation(bodies.half[a], bodies.half[b], spun, shift)
    if kind == APART:
        return FLOOR, FLOOR
    s.wrench[:] = 0.0
    if want:
        s.gradient[:, :] = 0.0
    incident, reference = b, a
    if kind != FACE_OF_FIRST and kind != EDGES:
        incident, reference = a, b
        for i in range(3):
            apart[i] = -apart[i]
        back = np.empty(3)
        for i in range(3):
            back[i] = -(spun[0, i] * shift[0] + spun[1, i] * shift[1] + spun[2, i] * shift[2])
        shift = back
        spun = np.ascontiguousarray(spun.T)
    frame = turn[reference]
    mass_centre = _to(frame, apart)
    for i in range(3):
        mass_centre[i] += bodies.offset[reference, i]
    # Velocities as seen from the reference body, which turns.
    drag = _cross(w[reference], apart)
    speed = _to(frame, v[incident] - v[reference] - drag)
    spin = _to(frame, w[incident] - w[reference])
    if kind == EDGES:
        depth, s.depth_slopes[:] = crossing(
            bodies.half[a], bodies.half[b], spun, shift, mass_centre, one, two,
            s.normal, s.normal_slopes, s.points[0], s.slopes[0],
        )  # fmt: skip
        s.weight_slopes[0] = 0.0
        _add_point(
            law, s.points[0], s.slopes[0], depth, _CROSSING_WEIGHT, s.weight_slopes[0],
            mass_centre, speed, spin, want, s,
        )  # fmt: skip
    else:
        _on_face(
            law, bodies.half[reference], bodies.half[incident], spun, shift, mass_centre, one,
            speed, spin, want, s,
        )  # fmt: skip
    _to_world(frame, want, s)
    return incident, reference


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


@compiled
def _add_cross(matrix, row, column, vector, factor):
    """Add ``factor [vector]x`` to a 3 x 3 block: [v]x a = v x a."""
    x, y, z = factor * vector[0], factor * vector[1], factor * vector[2]
    matrix[row, column + 1] -= z
    matrix[row, column + 2] += y
    matrix[row + 1, column] += z
    matrix[row + 1, column + 2] -= x
    matrix[row + 2, column] -= y
    matrix[row + 2, column + 1] += x


@compiled
def chain(incident, reference, p, v, w, by_pose, by_velocity, s):
    """Derivatives of both bodies' wrenches by both bodies' own coordinates, in world axes.

    Rows and columns: the incident body's six, then the reference body's six. Rotations are small
    turns about world axes, torques are about each body's own centre of mass.

    Args:
        incident, reference: as :func:`touch` returned them; a floor's rows and columns are zero.
        p, v, w: centres of mass and velocities.
        by_pose, by_velocity: filled in, shape (12, 12).
        s: scratch as :func:`touch` left it.
    """
    by_pose[:, :] = 0.0
    by_velocity[:, :] = 0.0
    by_pose[:6, :6] = s.gradient[:, :6]
    by_velocity[:6, :6] = s.gradient[:, 6:]
    if reference == FLOOR:
        return
    apart = p[incident] - p[reference]
    spin = w[incident] - w[reference]
    speed = v[incident] - v[reference] - _cross(w[reference], apart)
    force, torque = s.wrench[:3], s.wrench[3:]
    by_pose[:6, 6:] = -s.gradient[:, :6]
    by_velocity[:6, 6:] = -s.gradient[:, 6:]
    for r in range(6):
        for c in range(3):
            k, m = (c + 1) % 3, (c + 2) % 3
            # A row g times [u]x, entry c: g[k] u[m] - g[m] u[k].
            by_pose[r, 9 + c] += s.gradient[r, k] * apart[m] - s.gradient[r, m] * apart[k]
            by_velocity[r, 9 + c] += (
                s.gradient[r, 6 + k] * apart[m] - s.gradient[r, 6 + m] * apart[k]
            )
            by_pose[r, 9 + c] += s.gradient[r, 6 + k] * speed[m] - s.gradient[r, 6 + m] * speed[k]
            by_pose[r, 9 + c] += s.gradient[r, 9 + k] * spin[m] - s.gradient[r, 9 + m] * spin[k]
            # The frame of a turning reference body drags the relative speed along.
            drag = s.gradient[r, 6 + k] * w[reference, m] - s.gradient[r, 6 + m] * w[reference, k]
            by_pose[r, c] -= drag
            by_pose[r, 6 + c] += drag
    _add_cross(by_pose, 0, 9, force, -1.0)
    _add_cross(by_pose, 3, 9, torque, -1.0)
    # The reference body: -F, and -T - apart x F.
    for c in range(12):
        for matrix in (by_pose, by_velocity):
            fx, fy, fz = matrix[0, c], matrix[1, c], matrix[2, c]
            matrix[6, c], matrix[7, c], matrix[8, c] = -fx, -fy, -fz
            matrix[9, c] = -matrix[3, c] - (apart[1] * fz - apart[2] * fy)
            matrix[10, c] = -matrix[4, c] - (apart[2] * fx - apart[0] * fz)
            matrix[11, c] = -matrix[5, c] - (apart[0] * fy - apart[1] * fx)
    _add_cross(by_pose, 9, 0, force, 1.0)
    _add_cross(by_pose, 9, 6, force, -1.0)

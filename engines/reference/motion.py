"""The equations of motion of bodies in contact, and their linearisation.

Coordinates of a body within a step: its centre of mass and a rotation vector (world axes) that
turns the attitude it had at the start of the step, then both velocities. Rates of the first six
are the velocities (and the rotation vector's own rate), of the last six the accelerations.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from steadyload.engines.reference.chain import chain
from steadyload.engines.reference.compilation import compiled
from steadyload.engines.reference.contact import FLOOR, touch


class Field(NamedTuple):
    """External field: everything that acts on bodies besides contact.

    ``gravity`` [m/s2], shape (3,). ``floor``: height of the floor [m]. ``linear_decay``,
    ``angular_decay``: rates at which velocities decay [1/s].
    """

    gravity: np.ndarray
    floor: float
    linear_decay: float
    angular_decay: float


@compiled
def rotation(vector, out):
    """The rotation matrix of a rotation vector (Rodrigues), shape (3, 3)."""
    x, y, z = vector[0], vector[1], vector[2]
    angle2 = x * x + y * y + z * z
    if angle2 < 1e-8:
        sine, versine = 1.0 - angle2 / 6.0, 0.5 - angle2 / 24.0
    else:
        angle = math.sqrt(angle2)
        sine, versine = math.sin(angle) / angle, (1.0 - math.cos(angle)) / angle2
    out[0, 0] = 1.0 - versine * (y * y + z * z)
    out[1, 1] = 1.0 - versine * (x * x + z * z)
    out[2, 2] = 1.0 - versine * (x * x + y * y)
    out[0, 1] = versine * x * y - sine * z
    out[1, 0] = versine * x * y + sine * z
    out[0, 2] = versine * x * z + sine * y
    out[2, 0] = versine * x * z - sine * y
    out[1, 2] = versine * y * z - sine * x
    out[2, 1] = versine * y * z + sine * x


@compiled
def turn_by(vectors, start, out):
    """Attitudes after rotation vectors (n, 3), shape (n, 3, 3)."""
    by = np.empty((3, 3))
    for b in range(len(vectors)):
        rotation(vectors[b], by)
        for i in range(3):
            for j in range(3):
                out[b, i, j] = (
                    by[i, 0] * start[b, 0, j]
                    + by[i, 1] * start[b, 1, j]
                    + by[i, 2] * start[b, 2, j]
                )


@compiled
def rotation_rate(vector, spin, out):
    """Rate of a rotation vector t under an angular velocity w (inverse of the exponential map).

    ``w - t x w / 2 + k t x (t x w)`` with ``k = (1 - (|t|/2) cot(|t|/2)) / |t|^2``, for turns below
    2 pi; small ones by the series, whose next term is below 1e-10.
    """
    x, y, z = vector[0], vector[1], vector[2]
    cx = y * spin[2] - z * spin[1]
    cy = z * spin[0] - x * spin[2]
    cz = x * spin[1] - y * spin[0]
    a = x * x + y * y + z * z
    if a < 0.01:
        k = 1.0 / 12.0 + a / 720.0 + a * a / 30240.0
    else:
        half = 0.5 * math.sqrt(a)
        k = (1.0 - half / math.tan(half)) / a
    out[0] = spin[0] - 0.5 * cx + k * (y * cz - z * cy)
    out[1] = spin[1] - 0.5 * cy + k * (z * cx - x * cz)
    out[2] = spin[2] - 0.5 * cz + k * (x * cy - y * cx)


@compiled
def world_inertia(turn, inertia, out):
    """R diag(inertia) R^T, shape (3, 3)."""
    for i in range(3):
        for j in range(i + 1):
            out[i, j] = out[j, i] = (
                turn[i, 0] * inertia[0] * turn[j, 0]
                + turn[i, 1] * inertia[1] * turn[j, 1]
                + turn[i, 2] * inertia[2] * turn[j, 2]
            )


@compiled
def accelerations(law, field, bodies, pairs, p, turn, v, w, out, s):
    """Linear and angular accelerations of all bodies, shape (n, 6).

    Args:
        law: contact parameters.
        field: what acts besides contact.
        bodies: their sizes and masses.
        pairs: candidates for contact, shape (m, 2); a second index of -1 is the floor.
        p: centres of mass [m], shape (n, 3).
        turn: axes as columns, shape (n, 3, 3).
        v: velocities [m/s].
        w: angular velocities [rad/s].
        out: filled in.
        s: scratch.
    """
    out[:, :] = 0.0
    for k in range(len(pairs)):
        incident, reference = touch(
            law, field.floor, bodies, pairs[k, 0], pairs[k, 1], p, turn, v, w, False, s
        )
        if incident != FLOOR:
            add_wrench(incident, reference, p, s.wrench, out)
    _from_forces(field, bodies, turn, v, w, out)


@compiled
def add_wrench(incident, reference, p, wrench, out):
    """Add a wrench to the incident body, and what balances it to the reference body."""
    for i in range(6):
        out[incident, i] += wrench[i]
    if reference != FLOOR:
        x, y, z = p[incident] - p[reference]
        fx, fy, fz = wrench[0], wrench[1], wrench[2]
        for i in range(3):
            out[reference, i] -= wrench[i]
        out[reference, 3] -= wrench[3] + y * fz - z * fy
        out[reference, 4] -= wrench[4] + z * fx - x * fz
        out[reference, 5] -= wrench[5] + x * fy - y * fx


@compiled
def _from_forces(field, bodies, turn, v, w, out):
    """Forces and torques of contact become accelerations (Newton, Euler), in place."""
    for b in range(len(out)):
        if bodies[b].fixed:
            out[b] = 0.0
            continue
        r, inertia = turn[b], bodies[b].inertia
        for i in range(3):
            out[b, i] = out[b, i] / bodies[b].mass + field.gravity[i] - field.linear_decay * v[b, i]
        # In body axes: I a = t - w x I w.
        tx = r[0, 0] * out[b, 3] + r[1, 0] * out[b, 4] + r[2, 0] * out[b, 5]
        ty = r[0, 1] * out[b, 3] + r[1, 1] * out[b, 4] + r[2, 1] * out[b, 5]
        tz = r[0, 2] * out[b, 3] + r[1, 2] * out[b, 4] + r[2, 2] * out[b, 5]
        sx = r[0, 0] * w[b, 0] + r[1, 0] * w[b, 1] + r[2, 0] * w[b, 2]
        sy = r[0, 1] * w[b, 0] + r[1, 1] * w[b, 1] + r[2, 1] * w[b, 2]
        sz = r[0, 2] * w[b, 0] + r[1, 2] * w[b, 1] + r[2, 2] * w[b, 2]
        ax = (tx - (inertia[2] - inertia[1]) * sy * sz) / inertia[0]
        ay = (ty - (inertia[0] - inertia[2]) * sz * sx) / inertia[1]
        az = (tz - (inertia[1] - inertia[0]) * sx * sy) / inertia[2]
        for i in range(3):
            out[b, 3 + i] = (
                r[i, 0] * ax + r[i, 1] * ay + r[i, 2] * az - field.angular_decay * w[b, i]
            )


class Linearisation(NamedTuple):
    """Derivatives of M u', with M the masses and inertias at the start of a step.

    ``by_pose``, ``by_velocity``: of every touching pair's wrenches, shape (m, 12, 12), for the
    bodies ``ends`` (m, 2). ``own_pose``, ``own_velocity``: of a body's own gyroscopic terms and
    decay, shape (n, 6, 6). ``mass``: M, shape (n, 6, 6).
    """

    by_pose: np.ndarray
    by_velocity: np.ndarray
    ends: np.ndarray
    own_pose: np.ndarray
    own_velocity: np.ndarray
    mass: np.ndarray


@compiled
def make_linearisation(body_count, pair_count):
    """Memory for a linearisation."""
    return Linearisation(
        np.zeros((pair_count, 12, 12)),
        np.zeros((pair_count, 12, 12)),
        np.zeros((pair_count, 2), np.int64),
        np.zeros((body_count, 6, 6)),
        np.zeros((body_count, 6, 6)),
        np.zeros((body_count, 6, 6)),
    )


@compiled
def linearise(law, field, bodies, pairs, p, turn, v, w, out, lin, s):
    """Accelerations into ``out`` (n, 6), and their derivatives into ``lin``.

    Returns:
        The number of touching pairs.
    """
    out[:, :] = 0.0
    count = 0
    for k in range(len(pairs)):
        incident, reference = touch(
            law, field.floor, bodies, pairs[k, 0], pairs[k, 1], p, turn, v, w, True, s
        )
        if incident == FLOOR:
            continue
        add_wrench(incident, reference, p, s.wrench, out)
        chain(incident, reference, p, v, w, lin.by_pose[count], lin.by_velocity[count], s)
        lin.ends[count, 0], lin.ends[count, 1] = incident, reference
        count += 1
    _from_forces(field, bodies, turn, v, w, out)
    lin.own_pose[:, :, :] = 0.0
    lin.own_velocity[:, :, :] = 0.0
    lin.mass[:, :, :] = 0.0
    inertia, spin, alpha, load, moment = (
        np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3))
    )  # fmt: skip
    for b in range(len(out)):
        for i in range(3):
            lin.mass[b, i, i] = bodies[b].mass
            lin.own_velocity[b, i, i] = -field.linear_decay * bodies[b].mass
        world_inertia(turn[b], bodies[b].inertia, inertia)
        turning = out[b, 3:] + field.angular_decay * w[b]
        _skew(w[b], spin)
        _skew(turning, alpha)
        _skew(_times(inertia, turning), load)
        _skew(_times(inertia, w[b]), moment)
        for i in range(3):
            for j in range(3):
                lin.mass[b, 3 + i, 3 + j] = inertia[i, j]
                pose = load[i, j]
                gyro = moment[i, j]
                for m in range(3):
                    pose -= inertia[i, m] * alpha[m, j]
                    pose += spin[i, m] * moment[m, j]
                    gyro -= spin[i, m] * inertia[m, j]
                    for k in range(3):
                        pose -= spin[i, m] * inertia[m, k] * spin[k, j]
                lin.own_pose[b, 3 + i, 3 + j] = pose
                lin.own_velocity[b, 3 + i, 3 + j] = gyro - field.angular_decay * inertia[i, j]
    return count


@compiled
def _skew(vector, out):
    out[:, :] = 0.0
    out[0, 1], out[0, 2] = -vector[2], vector[1]
    out[1, 0], out[1, 2] = vector[2], -vector[0]
    out[2, 0], out[2, 1] = -vector[1], vector[0]


@compiled
def _times(matrix, vector):
    out = np.zeros(3)
    for i in range(3):
        for j in range(3):
            out[i] += matrix[i, j] * vector[j]
    return out

"""From the derivatives of a contact by relative motion to those by both bodies' own coordinates."""

from __future__ import annotations

from steadyload.engines.reference.compilation import compiled
from steadyload.engines.reference.contact import FLOOR


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
        incident: as :func:`~steadyload.engines.reference.contact.touch` returned it.
        reference: likewise; the floor's rows and columns are zero.
        p: centres of mass of all bodies.
        v: their velocities.
        w: their angular velocities.
        by_pose: filled in, shape (12, 12).
        by_velocity: filled in, shape (12, 12).
        s: scratch as that function left it.
    """
    by_pose[:, :] = 0.0
    by_velocity[:, :] = 0.0
    by_pose[:6, :6] = s.gradient[:, :6]
    by_velocity[:6, :6] = s.gradient[:, 6:]
    if reference == FLOOR:
        return
    apart = p[incident] - p[reference]
    spin = w[incident] - w[reference]
    speed = v[incident] - v[reference]
    speed[0] -= w[reference, 1] * apart[2] - w[reference, 2] * apart[1]
    speed[1] -= w[reference, 2] * apart[0] - w[reference, 0] * apart[2]
    speed[2] -= w[reference, 0] * apart[1] - w[reference, 1] * apart[0]
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

"""Forces between items of which some are free to move, at one moment."""

from __future__ import annotations

from typing import Any

import numpy as np

from steadyload.statics.kernels.compiled import compiled
from steadyload.statics.kernels.constants import RESIDUE, TOUCH
from steadyload.statics.kernels.least_squares import least_squares_of_blocks


@compiled
def wrenches_of(
    points: Any, known: int, at: Any, place: Any, centres: Any, way: Any, mass: Any,
    friction: float,
) -> Any:  # fmt: skip
    """Forces that closed points can exert.

    Returns:
        Four times the point plus the edge of its friction pyramid, (m,); the direction on the
        second body, (m, 3); the places of the two free bodies that feel it, -1 for none, (m, 2);
        and what it does to them, scaled by the roots of their masses, (m, 2, 6).
    """
    count = 0
    for k in range(known):
        if points.gaps[k] <= TOUCH:
            count += 4 if points.axes[k] == 1 and friction > 0.0 else 1
    sources, forces = np.empty(count, dtype=np.int64), np.zeros((count, 3))
    bodies, wrenches = np.empty((count, 2), dtype=np.int64), np.zeros((count, 2, 6))
    column = 0
    for k in range(known):
        if points.gaps[k] > TOUCH:
            continue
        edges = 4 if points.axes[k] == 1 and friction > 0.0 else 1
        for edge in range(edges):
            sources[column] = 4 * k + edge
            force = forces[column]
            force[points.axes[k]] = 1.0
            if edges == 4:
                force[2 if edge % 2 == 0 else 0] = friction if edge < 2 else -friction
            for side in range(2):
                body = points.pairs[k, side]
                n = place[body]
                bodies[column, side] = n
                if n >= 0:
                    row = wrenches[column, side]
                    sign = 1.0 if side == 1 else -1.0
                    put_wrench(row, force, at[k], centres[body], way[body], sign)
                    for c in range(6):
                        row[c] /= np.sqrt(mass[n, c])
            column += 1
    return sources, forces, bodies, wrenches


@compiled
def put_wrench(row: Any, force: Any, at: Any, centre: Any, way: Any, sign: float) -> None:
    """A force and its moment about the centre of mass of a body, where that is now."""
    x, y, z = at[0] - centre[0] - way[0], at[1] - centre[1] - way[1], at[2] - centre[2] - way[2]
    row[0], row[1], row[2] = sign * force[0], sign * force[1], sign * force[2]
    row[3] = sign * (y * force[2] - z * force[1])
    row[4] = sign * (z * force[0] - x * force[2])
    row[5] = sign * (x * force[1] - y * force[0])


@compiled
def least_forces(bodies: Any, wrenches: Any, mass: Any, sources: Any, pushed: Any) -> Any:
    """Forces (m,) that leave the least of the weights of free bodies, what they leave (n, 6), both
    in units of a weight of mass 1, and whether the search ended. Bodies that touch no others that
    are free are solved for on their own; sources that ``pushed`` before are tried first.
    """
    count = len(mass)
    parts, rest = np.zeros(len(bodies)), np.zeros((count, 6))
    cluster = np.arange(count)
    for k in range(len(bodies)):
        a, b = bodies[k]
        if a >= 0 and b >= 0:
            merge(cluster, a, b)
    row, column_of = np.empty(count, dtype=np.int64), np.empty(len(bodies), dtype=np.int64)
    for name in range(count):
        size = 0
        for n in range(count):
            if cluster[n] == name:
                row[n] = 6 * size
                size += 1
        if size == 0:
            continue
        width = 0
        for k in range(len(bodies)):
            if cluster[max(bodies[k, 0], bodies[k, 1])] == name:
                column_of[width] = k
                width += 1
        columns, target = np.empty((width, 2, 6)), np.zeros(6 * size)
        blocks = np.full((width, 2), -1, dtype=np.int64)
        for n in range(count):
            if cluster[n] == name:
                target[row[n] + 1] = np.sqrt(mass[n, 0])
        for at in range(width):
            k = column_of[at]
            columns[at] = wrenches[k]
            for side in range(2):
                n = bodies[k, side]
                if n >= 0:
                    blocks[at, side] = row[n]
        likely = np.flatnonzero(pushed[sources[column_of[:width]]])
        found, left, ended = least_squares_of_blocks(columns, target, blocks, likely)
        if not ended:
            return parts, rest, False
        for at in range(width):
            parts[column_of[at]] = found[at]
        for n in range(count):
            if cluster[n] == name:
                rest[n] = left[row[n] : row[n] + 6]
    return parts, rest, True


@compiled
def drop_rounding(
    rest: Any, bodies: Any, wrenches: Any, parts: Any, mass: Any, sizes: Any, thin: float
) -> None:
    """Let thin bodies rest whose acceleration is rounding of the forces on them.

    In a narrow piece, which tips fast, it would grow to a fall.

    Args:
        rest: what forces leave of the weights, which is changed, (n, 6).
        bodies: of :func:`wrenches_of`.
        wrenches: likewise.
        parts: of :func:`least_forces`.
        mass: masses and moments of inertia, (n, 6).
        sizes: of the bodies [cm], (n, 3).
        thin: see :func:`thin_side`; bodies with a shorter side are thin [cm].
    """
    loads = np.zeros((len(mass), 6))
    loads[:, 1] = np.sqrt(mass[:, 1])
    for column in range(len(bodies)):
        for side in range(2):
            n = bodies[column, side]
            if n >= 0:
                loads[n] += parts[column] * np.abs(wrenches[column, side])
    for n in range(len(mass)):
        size = sizes[n]
        if size.min() < thin and _corner_rate(rest[n], mass[n], size) <= RESIDUE * _corner_rate(
            loads[n], mass[n], size
        ):
            rest[n] = 0.0


@compiled
def thin_side(gravity: float, left: float) -> float:
    """The side below which a body that tips within a time grows by more than 1 / RESIDUE.

    A body that tips over a side departs as exp(t sqrt(3 g / 2 side)) at most.
    """
    return 1.5 * gravity * (left / np.log(RESIDUE)) ** 2


@compiled
def _corner_rate(forces: Any, mass: Any, size: Any) -> float:
    """How fast forces can accelerate any corner of a body, in units of gravity."""
    found = 0.0
    for c in range(3):
        found += abs(forces[c]) / np.sqrt(mass[c])
        found += abs(forces[3 + c]) / np.sqrt(mass[3 + c]) * size[c]
    return found


@compiled
def merge(cluster: Any, a: int, b: int) -> None:
    """Give all bodies of the cluster of one body the name of that of another."""
    new, old = cluster[a], cluster[b]
    if new == old:
        return
    for n in range(len(cluster)):
        if cluster[n] == old:
            cluster[n] = new

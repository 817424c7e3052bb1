"""Motion of a group of items that lost its balance, over a given time: a model, no simulation.

The model is that of :mod:`steadyload.methods.motion`, which tells what it assumes. Items that stay
at rest are not solved for: see :mod:`steadyload.kernels.local_balance`.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from steadyload.kernels.carrying import FREE, WAITING, first_overloaded
from steadyload.kernels.compiled import compiled
from steadyload.kernels.constants import FLOOR, TOLERANCE
from steadyload.kernels.contacts import Contacts
from steadyload.kernels.least_squares import least_squares_of_blocks
from steadyload.kernels.local_balance import forget, free_with_those_above
from steadyload.kernels.touching import room_for_points, with_points_of

_EVENTS = 40
_SAMPLES = 60
_TOUCH = 2.0 * TOLERANCE
"""[cm]: a gap below this is closed."""

_FAR = 25.0
"""Keeps a light pendulum watched for long from overflowing; it has tipped anyway."""

_AT_REST = 1e-12
"""Share of the largest energy of motion below which an item counts as at rest."""


class Motion(NamedTuple):
    """Motion of free items.

    Attributes:
        ended: False where a search for forces did not end.
        way: of every item: displacement of the centre of mass [cm] and turn [rad], (J, 6).
        role: which items were solved for, (J,).
        leans: items at rest that carried something of free ones, (J,).
        most: how far any corner came along every axis, forwards and backwards [cm], (J, 3, 2).
    """

    ended: Any
    way: Any
    role: Any
    leans: Any
    most: Any


@compiled
def motion_of(
    step: int, group: Any, reach: float, friction: float, gravity: float, seconds: float,
    contacts: Contacts, meets: Any, centres: Any, weights: Any, lower: Any, upper: Any,
    floor: Any, presses: Any, guess: Any, changed: Any,
) -> Motion:  # fmt: skip
    """Follow the items of a group that are out of balance, from rest.

    Args:
        step: the new item, the last that is there.
        group: items that can move, (n,); all others are firm.
        reach: gaps up to this may close [cm].
        friction: of tops and bases; sides have none.
        gravity: [cm/s2].
        seconds: how long they are followed.
        contacts: of the layout.
        meets: of :func:`~steadyload.kernels.balance.patches_above`.
        centres: of mass (x, y, z) [cm], (J, 3).
        weights: [kg], (J,).
        lower: corners [cm], (J, 3).
        upper: likewise.
        floor: see :mod:`steadyload.kernels`.
        presses: vertical forces between items, those in motion left out, (P, 3).
        guess: items that are solved for from the beginning: those out of balance at least, (J,).
        changed: room, (P, 6).
    """
    count = len(weights)
    role, within = np.zeros(count, dtype=np.int64), np.zeros(count, dtype=np.bool_)
    way, most = np.zeros((count, 6)), np.zeros((count, 3, 2))
    leans, listed = np.zeros(count, dtype=np.bool_), np.zeros(count, dtype=np.bool_)
    loads = np.zeros((count, 6))
    for item in group:
        within[item] = True
        if guess[item]:
            role[item] = FREE
    points, known = room_for_points(64 * len(group)), 0
    pushed = np.zeros(4 * len(points.axes), dtype=np.bool_)
    left = seconds
    for _ in range(_EVENTS):
        while True:
            for item in group:
                if role[item] == FREE and not listed[item]:
                    points, known = with_points_of(
                        points, known, item, step, listed, lower, upper, floor, reach
                    )
                    listed[item] = True
            if len(pushed) < 4 * len(points.axes):
                before = pushed
                pushed = np.zeros(4 * len(points.axes), dtype=np.bool_)
                pushed[: len(before)] = before
            free = np.flatnonzero(role == FREE)
            place = np.full(count + 1, -1, dtype=np.int64)  # the last is the floor's
            mass, mean = np.empty((len(free), 6)), 0.0
            for n in range(len(free)):
                mean += weights[free[n]] / len(free)
            for n in range(len(free)):
                place[free[n]] = n
                _put_mass(mass[n], weights[free[n]] / mean, lower[free[n]], upper[free[n]])
            at = _positions(points.planned[:known], points.pairs, place, centres, way)
            sources, forces, bodies, wrenches = _wrenches(
                points, known, at, place, centres, way, mass, friction
            )
            parts, rest, ended = _solved(bodies, wrenches, mass, sources, pushed)
            pushed = np.zeros(4 * len(points.axes), dtype=np.bool_)
            pushed[sources[parts > 0.0]] = True
            if not ended:
                return Motion(False, way, role, leans, most)
            loads[:] = 0.0
            _load_others(points, sources, forces, parts, at, place, within, mean, loads)
            _wake(free, step, contacts, meets, presses, loads, within, role)
            failed = first_overloaded(
                step, role, loads, contacts, meets, centres, weights, lower, presses, changed,
                friction,
            )  # fmt: skip
            if failed < 0:
                break
            forget(role)
            free_with_those_above(failed, step, contacts, role)
        for item in group:
            leans[item] |= role[item] != 0 and role[item] != FREE
        forget(role)
        rates = -gravity * rest / np.sqrt(mass)
        growth = _growth(rates, mass, points, sources, parts, place, gravity)
        left -= _coast(rates, growth, points, known, at, place, free, centres, way, left)
        for item in free:
            _farthest_corners(most[item], way[item], centres[item], lower[item], upper[item])
        if left <= 0.0:
            break
    return Motion(True, way, role, leans, most)


@compiled
def _put_mass(row: Any, mass: float, lower: Any, upper: Any) -> None:
    """Mass and moments of inertia of a box."""
    a, b, c = upper - lower
    row[0], row[1], row[2] = mass, mass, mass
    row[3] = mass / 12.0 * (b**2 + c**2)
    row[4] = mass / 12.0 * (a**2 + c**2)
    row[5] = mass / 12.0 * (a**2 + b**2)


@compiled
def _positions(planned: Any, pairs: Any, place: Any, centres: Any, way: Any) -> Any:
    """Points now: they go with their first body; those on what is at rest stay."""
    at = planned.copy()
    for k in range(len(at)):
        body = pairs[k, 0]
        if place[body] >= 0:
            x, y, z = planned[k] - centres[body]
            a, b, c = way[body, 3:]
            at[k, 0] += way[body, 0] + b * z - c * y
            at[k, 1] += way[body, 1] + c * x - a * z
            at[k, 2] += way[body, 2] + a * y - b * x
    return at


@compiled
def _wrenches(
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
        if points.gaps[k] <= _TOUCH:
            count += 4 if points.axes[k] == 1 and friction > 0.0 else 1
    sources, forces = np.empty(count, dtype=np.int64), np.zeros((count, 3))
    bodies, wrenches = np.empty((count, 2), dtype=np.int64), np.zeros((count, 2, 6))
    column = 0
    for k in range(known):
        if points.gaps[k] > _TOUCH:
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
                    _put_wrench(row, force, at[k], centres[body], way[body], sign)
                    for c in range(6):
                        row[c] /= np.sqrt(mass[n, c])
            column += 1
    return sources, forces, bodies, wrenches


@compiled
def _solved(bodies: Any, wrenches: Any, mass: Any, sources: Any, pushed: Any) -> Any:
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
            _merge(cluster, a, b)
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
        columns, target = np.zeros((width, 6 * size)), np.zeros(6 * size)
        blocks = np.full((width, 2), -1, dtype=np.int64)
        for n in range(count):
            if cluster[n] == name:
                target[row[n] + 1] = np.sqrt(mass[n, 0])
        for at in range(width):
            k = column_of[at]
            for side in range(2):
                n = bodies[k, side]
                if n >= 0:
                    blocks[at, side] = row[n]
                    columns[at, row[n] : row[n] + 6] = wrenches[k, side]
        likely = np.flatnonzero(pushed[sources[column_of[:width]]])
        found, left, ended = least_squares_of_blocks(columns, target, blocks, 6, likely)
        if not ended:
            return parts, rest, False
        for at in range(width):
            parts[column_of[at]] = found[at]
        for n in range(count):
            if cluster[n] == name:
                rest[n] = left[row[n] : row[n] + 6]
    return parts, rest, True


@compiled
def _merge(cluster: Any, a: int, b: int) -> None:
    """Give all bodies of the cluster of one body the name of that of another."""
    new, old = cluster[a], cluster[b]
    if new == old:
        return
    for n in range(len(cluster)):
        if cluster[n] == old:
            cluster[n] = new


@compiled
def _put_wrench(row: Any, force: Any, at: Any, centre: Any, way: Any, sign: float) -> None:
    """A force and its moment about the centre of mass of a body, where that is now."""
    x, y, z = at[0] - centre[0] - way[0], at[1] - centre[1] - way[1], at[2] - centre[2] - way[2]
    row[0], row[1], row[2] = sign * force[0], sign * force[1], sign * force[2]
    row[3] = sign * (y * force[2] - z * force[1])
    row[4] = sign * (z * force[0] - x * force[2])
    row[5] = sign * (x * force[1] - y * force[0])


@compiled
def _load_others(
    points: Any, sources: Any, forces: Any, parts: Any, at: Any, place: Any, within: Any,
    unit: float, loads: Any,
) -> None:  # fmt: skip
    """What free bodies press on those of the group that are at rest."""
    load = np.empty(6)
    for column in range(len(sources)):
        if parts[column] > 0.0:
            k = sources[column] // 4
            for side in range(2):
                body = points.pairs[k, side]
                if body == FLOOR or place[body] >= 0 or not within[body]:
                    continue
                x, y, z = at[k]
                a, b, c = forces[column]
                load[0], load[1], load[2] = a, b, c
                load[3], load[4], load[5] = y * c - z * b, z * a - x * c, x * b - y * a
                for i in range(6):
                    loads[body, i] += (1.0 if side == 1 else -1.0) * parts[column] * unit * load[i]


@compiled
def _wake(
    free: Any, step: int, contacts: Contacts, meets: Any, presses: Any, loads: Any, within: Any,
    role: Any,
) -> None:  # fmt: skip
    """Items at rest whose load may be another one now: on, below or beside free ones."""
    for item in range(step + 1):
        if within[item] and role[item] == 0 and np.any(loads[item] != 0.0):
            role[item] = WAITING
    for item in free:
        for k in range(contacts.starts[item], contacts.ends[item]):
            carrier = contacts.below[k]
            if carrier == FLOOR or carrier > step or not within[carrier]:
                continue
            if role[carrier] == 0 and presses[k, 0] != 0.0:
                role[carrier] = WAITING
        for k in range(contacts.above_starts[item], contacts.above_ends[item]):
            other = contacts.above[k]
            if other <= step and role[other] == 0 and presses[meets[k], 0] != 0.0:
                role[other] = WAITING


@compiled
def _growth(
    rates: Any, mass: Any, points: Any, sources: Any, parts: Any, place: Any,
    gravity: float,
) -> Any:  # fmt: skip
    """k2 of every free body [1/s2]: that of the bodies that move and push each other."""
    count = len(rates)
    gain, energy, part = np.empty(count), np.empty(count), np.arange(count)
    for n in range(count):
        u, w = rates[n, :3], rates[n, 3:]
        gain[n] = gravity * mass[n, 0] * (w[0] * u[2] - w[2] * u[0])
        energy[n] = (mass[n] * rates[n] ** 2).sum()
    least = _AT_REST * max(energy.max(), 1e-300)
    for column in range(len(sources)):
        first, second = points.pairs[sources[column] // 4]
        a, b = place[first], place[second]
        if parts[column] > 0.0 and a >= 0 and b >= 0 and min(energy[a], energy[b]) > least:
            _merge(part, a, b)
    growth = np.empty(count)
    for n in range(count):
        gains, energies = 0.0, 0.0
        for m in range(count):
            if part[m] == part[n]:
                gains += gain[m]
                energies += energy[m]
        growth[n] = gains / (energies if energies > 0.0 else 1.0)
    return growth


@compiled
def _coast(
    rates: Any, growth: Any, points: Any, known: int, at: Any, place: Any, free: Any, centres: Any,
    way: Any, left: float,
) -> float:  # fmt: skip
    """Move until a gap closes, or through the time that is left; the time passed [s]."""
    count = len(free)
    # How gaps change: the relative motion of the two bodies along the normal.
    along = np.zeros((known, 2))
    row, normal = np.empty(6), np.zeros(3)
    for k in range(known):
        normal[:] = 0.0
        normal[points.axes[k]] = 1.0
        for side in range(2):
            body = points.pairs[k, side]
            n = place[body]
            if n >= 0:
                _put_wrench(row, normal, at[k], centres[body], way[body], 1.0 if side else -1.0)
                along[k, side] = (row * rates[n]).sum()
    gone = np.empty(count + 1)
    gone[count] = 0.0
    time = left
    for sample in range(1, _SAMPLES + 1):
        time = left * sample / _SAMPLES
        for n in range(count):
            gone[n] = _pendulum(growth[n], time)
        closes = False
        for k in range(known):
            if points.gaps[k] > _TOUCH and (
                points.gaps[k] + _change(along[k], points.pairs[k], place, gone) <= _TOUCH
            ):
                closes = True
                break
        if closes:
            break
    for k in range(known):
        points.gaps[k] += _change(along[k], points.pairs[k], place, gone)
    for n in range(count):
        for c in range(6):
            way[free[n], c] += rates[n, c] * gone[n]
    return time


@compiled
def _change(along: Any, pair: Any, place: Any, gone: Any) -> float:
    """How much a gap changes; bodies at rest stand last in ``gone``, at place -1."""
    return along[0] * gone[place[pair[0]]] + along[1] * gone[place[pair[1]]]


@compiled
def _pendulum(growth: float, t: float) -> float:
    """The way of s'' = 1 + k2 s from rest at s = 0; near k2 = 0 it is t2 / 2."""
    half = min(max(0.5 * np.sqrt(abs(growth)) * t, 1e-6), _FAR)
    return 0.5 * t * t * ((np.sinh(half) if growth > 0.0 else np.sin(half)) / half) ** 2


@compiled
def _farthest_corners(most: Any, way: Any, centre: Any, lower: Any, upper: Any) -> None:
    """Enlarge how far any corner of a body came along every axis."""
    for axis in range(3):
        b, c = (axis + 1) % 3, (axis + 2) % 3
        # Along an axis, a turn moves a corner by t_b l_c - t_c l_b.
        tb, tc = way[3 + b], way[3 + c]
        one, two = tb * (lower[c] - centre[c]), tb * (upper[c] - centre[c])
        three, four = tc * (lower[b] - centre[b]), tc * (upper[b] - centre[b])
        most[axis, 0] = max(most[axis, 0], way[axis] + max(one, two) - min(three, four))
        most[axis, 1] = max(most[axis, 1], -way[axis] - min(one, two) + max(three, four))

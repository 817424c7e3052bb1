"""Motion of a group of items that lost its balance, over a given time: a model, no simulation.

The model is that of :mod:`steadyload.statics.motion`, which tells what it assumes.
Items that stay at rest are not solved for: see :mod:`steadyload.statics.kernels.local_balance`.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from steadyload.statics.kernels.carrying import FREE, WAITING, first_overloaded
from steadyload.statics.kernels.compiled import compiled
from steadyload.statics.kernels.constants import EVENTS, FLOOR
from steadyload.statics.kernels.contacts import Contacts
from steadyload.statics.kernels.group_forces import (
    drop_rounding,
    least_forces,
    thin_side,
    wrenches_of,
)
from steadyload.statics.kernels.local_balance import forget, free_with_those_above
from steadyload.statics.kernels.pendulums import coast, growth_of
from steadyload.statics.kernels.touching import room_for_points, with_points_of


class Motion(NamedTuple):
    """Motion of free items.

    Attributes:
        ended: False where a search for forces did not end, or more work is not allowed.
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
    floor: Any, presses: Any, guess: Any, changed: Any, pushes: Any, work: Any,
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
        meets: of :func:`~steadyload.statics.kernels.balance.patches_above`.
        centres: of mass (x, y, z) [cm], (J, 3).
        weights: [kg], (J,).
        lower: corners [cm], (J, 3).
        upper: likewise.
        floor: see :mod:`steadyload.statics.kernels`.
        presses: vertical forces between items, those in motion left out, (P, 3).
        guess: items that are solved for from the beginning: those out of balance at least, (J,).
        changed: room, (P, 6).
        pushes: forces between two bodies at the last start, with which the search begins: a bit for
            every corner and edge of its friction pyramid; replaced, (J + 1, J + 1).
        work: taken so far, which is added to, and allowed, (2,): every search for forces takes the
            square of the number of free items, as long as it is allowed.
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
    points, known, recalled = room_for_points(64 * len(group)), 0, 0
    pushed = np.zeros(4 * len(points.axes), dtype=np.bool_)
    left = seconds
    for event in range(EVENTS):
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
            for source in range(4 * recalled, 4 * known):
                first, second = points.pairs[source // 4]
                pushed[source] = (pushes[first, second] >> (source % 16)) & 1 != 0
            recalled = known
            free = np.flatnonzero(role == FREE)
            work[0] += float(len(free)) ** 2
            if work[0] > work[1]:
                return Motion(False, way, role, leans, most)
            place = np.full(count + 1, -1, dtype=np.int64)  # the last is the floor's
            mass, mean = np.empty((len(free), 6)), 0.0
            for n in range(len(free)):
                mean += weights[free[n]] / len(free)
            for n in range(len(free)):
                place[free[n]] = n
                _put_mass(mass[n], weights[free[n]] / mean, lower[free[n]], upper[free[n]])
            at = _positions(points.planned[:known], points.pairs, place, centres, way)
            sources, forces, bodies, wrenches = wrenches_of(
                points, known, at, place, centres, way, mass, friction
            )
            parts, rest, ended = least_forces(bodies, wrenches, mass, sources, pushed)
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
        if event == 0:
            for k in range(known):
                pushes[points.pairs[k, 0], points.pairs[k, 1]] = 0
            for source in sources[parts > 0.0]:
                first, second = points.pairs[source // 4]
                pushes[first, second] |= 1 << (source % 16)
        thin = thin_side(gravity, left)
        drop_rounding(rest, bodies, wrenches, parts, mass, upper[free] - lower[free], thin)
        rates = -gravity * rest / np.sqrt(mass)
        growth = growth_of(rates, mass, points, sources, parts, place, gravity)
        left -= coast(rates, growth, points, known, at, place, free, centres, way, left)
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
def _load_others(
    points: Any, sources: Any, forces: Any, parts: Any, at: Any, place: Any, within: Any,
    unit: float, loads: Any,
) -> None:  # fmt: skip
    """Add up the loads of free bodies on those of the group that are at rest."""
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

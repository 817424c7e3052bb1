"""Advance all bodies of a world: sub-layouts that cannot touch are integrated apart."""

from __future__ import annotations

import math

import numpy as np

from steadyload.engines.reference.compilation import compiled
from steadyload.engines.reference.contact import FLOOR
from steadyload.engines.reference.rodas import FINISHED, NOT_FINITE, Control, integrate

_WINDOW = 0.03
"""Bodies that cannot meet within this time [s] are integrated apart, each group with its own steps.
A third of the ten looks at a placement of 0.3 s would do as well; shorter ones cut steps short."""

_SPARE_REACH = 1e-3
"""Added to what a body's speed and gravity let it do within a window [m]."""

MOST_STRETCH = 1e6
"""How much wider than foreseen groups are made before a motion counts as without bounds."""

_SHARE_OF_THICKNESS = 0.25
"""A step moves no point of a body by more than this share of the thinnest one, at the speed with
which a window begins: none jumps through another."""


@compiled
def reaches(field, bodies, v, w, duration, stretch):
    """Bounds on how far any point of each body moves within ``duration`` [m], shape (n,)."""
    n = len(v)
    reach = np.empty(n)
    fall = math.sqrt(np.sum(field.gravity * field.gravity)) * duration * duration
    for b in range(n):
        speed = math.sqrt(v[b, 0] ** 2 + v[b, 1] ** 2 + v[b, 2] ** 2)
        spin = math.sqrt(w[b, 0] ** 2 + w[b, 1] ** 2 + w[b, 2] ** 2)
        reach[b] = 1.5 * (speed + spin * bodies[b].extent) * duration + fall + _SPARE_REACH
        reach[b] = 0.0 if bodies[b].fixed else stretch * reach[b]
    return reach


@compiled
def candidate_pairs(floor, bodies, p, turn, reach):
    """Pairs of bodies whose bounding boxes, widened by their reaches, overlap; shape (m, 2).

    A second index of -1 is the floor. Two fixed bodies are no pair.
    """
    n = len(p)
    low, high = np.empty((n, 3)), np.empty((n, 3))
    for b in range(n):
        for i in range(3):
            middle, half = p[b, i], reach[b]
            for j in range(3):
                middle -= turn[b, i, j] * bodies[b].offset[j]
                half += abs(turn[b, i, j]) * bodies[b].half[j]
            low[b, i], high[b, i] = middle - half, middle + half
    pairs = np.empty((n * (n + 1) // 2, 2), np.int64)
    count = 0
    for a in range(n):
        if low[a, 2] < floor and not bodies[a].fixed:
            pairs[count, 0], pairs[count, 1] = a, FLOOR
            count += 1
        for b in range(a + 1, n):
            if bodies[a].fixed and bodies[b].fixed:
                continue
            apart = False
            for i in range(3):
                apart = apart or low[a, i] > high[b, i] or low[b, i] > high[a, i]
            if not apart:
                pairs[count, 0], pairs[count, 1] = a, b
                count += 1
    return pairs[:count]


@compiled
def islands(bodies, pairs):
    """A label for every body: free bodies joined by pairs share it, fixed ones have -1."""
    n = len(bodies)
    label = np.arange(n)
    changed = True
    while changed:
        changed = False
        for k in range(len(pairs)):
            a, b = pairs[k, 0], pairs[k, 1]
            if b != FLOOR and not bodies[a].fixed and not bodies[b].fixed and label[a] != label[b]:
                label[a] = label[b] = min(label[a], label[b])
                changed = True
    for b in range(n):
        if bodies[b].fixed:
            label[b] = -1
    return label


@compiled
def _members(island, label, pairs):
    """The bodies of an island and the fixed ones beside it; and its pairs, numbered among them."""
    place = np.full(len(label), -1)
    members = np.empty(len(label), np.int64)
    count = 0
    for b in range(len(label)):
        if label[b] == island:
            place[b], members[count] = count, b
            count += 1
    own = np.empty((len(pairs), 2), np.int64)
    found = 0
    for k in range(len(pairs)):
        a, b = pairs[k, 0], pairs[k, 1]
        if label[a] != island and (b == FLOOR or label[b] != island):
            continue
        for i in (a, b):
            if i != FLOOR and place[i] < 0:
                place[i], members[count] = count, i
                count += 1
        own[found, 0] = place[a]
        own[found, 1] = FLOOR if b == FLOOR else place[b]
        found += 1
    return members[:count], own[:found]


@compiled
def _longest_step(bodies, v, w, control, duration, gravity):
    """The control's longest step, or less where something fast might jump through something."""
    thinnest, fastest = math.inf, 0.0
    for b in range(len(v)):
        for i in range(3):
            thinnest = min(thinnest, 2.0 * bodies[b].half[i])
        speed = math.sqrt(v[b, 0] ** 2 + v[b, 1] ** 2 + v[b, 2] ** 2)
        spin = math.sqrt(w[b, 0] ** 2 + w[b, 1] ** 2 + w[b, 2] ** 2)
        fastest = max(fastest, speed + spin * bodies[b].extent)
    fall = math.sqrt(np.sum(gravity * gravity)) * duration
    return min(control.most_time, _SHARE_OF_THICKNESS * thinnest / (fastest + fall))


@compiled
def advance(law, field, bodies, p, turn, v, w, next_steps, duration, control, s):
    """Advance a world by ``duration`` seconds, in place.

    Args:
        law: contact parameters.
        field: what acts besides contact.
        bodies: their sizes and masses.
        p: centres of mass [m], shape (n, 3).
        turn: axes as columns, shape (n, 3, 3).
        v: velocities [m/s].
        w: angular velocities [rad/s].
        next_steps: the step [s] that each body's group would take next, shape (n,); updated.
        duration: [s].
        control: how time is cut into steps.
        s: scratch.

    Returns:
        The outcome (see :mod:`steadyload.engines.reference.rodas`), steps accepted and steps
        rejected.
    """
    time, accepted, rejected = 0.0, 0, 0
    if not (np.isfinite(p).all() and np.isfinite(v).all() and np.isfinite(w).all()):
        return NOT_FINITE, accepted, rejected
    while duration - time > 1e-12 * duration:
        window = min(_WINDOW, duration - time)
        if duration - time - window < 1e-9:
            window = duration - time
        before = (p.copy(), turn.copy(), v.copy(), w.copy())
        stretch = 1.0
        while True:
            reach = reaches(field, bodies, v, w, window, stretch)
            pairs = candidate_pairs(field.floor, bodies, p, turn, reach)
            label = islands(bodies, pairs)
            for island in range(len(p)):
                if label[island] != island:
                    continue
                members, own = _members(island, label, pairs)
                part = bodies[members]
                ps, turns, vs, ws = p[members], turn[members], v[members], w[members]
                longest = _longest_step(part, vs, ws, control, window, field.gravity)
                count = integrate(
                    law, field, part, own, ps, turns, vs, ws, window,
                    np.min(next_steps[members]),
                    Control(control.tolerance, longest, control.most_work), s,
                )  # fmt: skip
                accepted += count.accepted
                rejected += count.rejected
                for k in range(len(members)):
                    b = members[k]
                    if not bodies[b].fixed:
                        p[b], turn[b], v[b], w[b] = ps[k], turns[k], vs[k], ws[k]
                        next_steps[b] = count.next_step
                if count.outcome != FINISHED:
                    return count.outcome, accepted, rejected
            if within(bodies, before[0], before[1], p, turn, reach):
                break
            # Something was hit and came further than foreseen: once more, with wider groups.
            p[:, :], turn[:, :, :], v[:, :], w[:, :] = before[0], before[1], before[2], before[3]
            stretch *= 2.0
            if stretch > MOST_STRETCH:
                return NOT_FINITE, accepted, rejected
        time += window
    return FINISHED, accepted, rejected


@compiled
def within(bodies, p_before, turn_before, p, turn, reach):
    """True while no point of any free body has come further than its reach."""
    for b in range(len(p)):
        if bodies[b].fixed:
            continue
        shift = math.sqrt(np.sum((p[b] - p_before[b]) ** 2))
        # The Frobenius norm of the difference bounds what a turn does to a unit vector.
        change = math.sqrt(np.sum((turn[b] - turn_before[b]) ** 2))
        if not shift + change * bodies[b].extent <= reach[b]:
            return False
    return True

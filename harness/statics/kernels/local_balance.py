"""Vertical balance of a group in which items may be out of balance, solved only where it changes.

The forces that come closest to balance (see :mod:`steadyload.statics.balance`) leave
most items at rest. Some items are free: their forces are solved for, with everything else as firm
as the floor. Where the items at rest can carry what then presses on them, these are the forces of
the whole group; where one cannot, it is freed, with what stands on it, and the problem is solved
again.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from steadyload.statics.kernels.carrying import FREE, HANDED, WAITING, first_overloaded
from steadyload.statics.kernels.compiled import compiled
from steadyload.statics.kernels.constants import (
    BALANCED,
    EDGE,
    FLOOR,
    NOISE,
    RESIDUE,
    TIE,
    UNBALANCED,
    UNRESOLVED,
)
from steadyload.statics.kernels.contacts import Contacts, is_left
from steadyload.statics.kernels.least_squares import least_squares_of_blocks


@compiled
def balance_group(
    step: int, group: Any, contacts: Contacts, meets: Any, centres: Any, weights: Any, lower: Any,
    upper: Any, presses: Any, replaced: Any, corners: Any, moves: Any, changed: Any,
    whole: bool,
) -> Any:  # fmt: skip
    """Balance the group of a new item as well as can be.

    Args:
        step: the new item, the last that is there.
        group: items joined to it, itself included, (n,).
        contacts: of the layout.
        meets: of :func:`~steadyload.statics.kernels.balance.patches_above`.
        centres: of mass (x, y, z) [cm], (J, 3).
        weights: [kg], (J,).
        lower: corners [cm], (J, 3).
        upper: likewise.
        presses: force [kg] and its moments [kg cm] at every patch before, (P, 3).
        replaced: those of the group are put there, whether they change or not; may be the same.
        corners: of every patch that pressed when it was solved for last, with which the search
            begins; replaced, (P, 4).
        moves: which items were out of balance before, which is replaced, (J,).
        changed: room, (P, 6).
        whole: solve for all items of the group, not only where something changes.

    Returns:
        How it ended, and the item that starts fastest, -1 where none does.
    """
    count = len(weights)
    role, loads = np.zeros(count, dtype=np.int64), np.zeros((count, 6))
    mean, heaviest = 0.0, 0.0
    for item in group:
        mean += weights[item] / len(group)
        heaviest = max(heaviest, weights[item])
        if moves[item] or whole:
            role[item] = FREE
    free_with_those_above(step, step, contacts, role)
    while True:
        free = np.flatnonzero(role == FREE)
        used = patches_of(free, step, contacts, meets, role)
        forces, left, ended = _solved(
            free, used, contacts.patches, centres, weights, lower, upper, mean, EDGE, corners
        )
        if not ended:
            return UNRESOLVED, -1
        for n in range(len(used)):
            corners[used[n, 0]] = forces[n] > 0.0
        loads[:] = 0.0
        for n in range(len(used)):
            _press(used[n, 0], forces[n], contacts, mean, changed)
            _load_other(used[n], contacts, role, presses, changed, loads)
        failed = first_overloaded(
            step, role, loads, contacts, meets, centres, weights, lower, presses, changed, 0.0
        )
        if failed < 0:
            break
        forget(role)
        free_with_those_above(failed, step, contacts, role)
    verdict = _judged(free, used, forces, left, contacts.patches, centres, weights, lower, upper,
                      mean, heaviest, EDGE, moves)  # fmt: skip
    for item in group:
        for k in range(contacts.starts[item], contacts.ends[item]):
            if role[item] == HANDED:
                _keep(k, changed, replaced)
            else:
                replaced[k] = presses[k]
    for k in used[:, 0]:
        _keep(k, changed, replaced)
    return verdict


@compiled
def closest_to_balance(
    items: Any, used: Any, patches: Any, centres: Any, weights: Any, lower: Any, upper: Any,
    grow: float,
) -> Any:  # fmt: skip
    """Forces between some items, and what is firm, that come closest to balance.

    Args:
        items: that have to be balanced, (n,).
        used: of every patch its place in ``patches``, what is above it and what is below, which is
            firm where it is none of the items, (k, 3).
        patches: x0, z0, x1, z1 [cm].
        centres: of mass (x, y, z) [cm], (J, 3).
        weights: [kg], (J,).
        lower: corners [cm], (J, 3).
        upper: likewise.
        grow: how much wider every patch counts on each side [cm].

    Returns:
        The forces at the corners of every patch [kg], (k, 4); how it ended; the item that starts
        fastest, -1 where none does; and whether the search ended.
    """
    mean, heaviest = 0.0, 0.0
    for item in items:
        mean += weights[item] / len(items)
        heaviest = max(heaviest, weights[item])
    corners = np.zeros((len(patches), 4), dtype=np.bool_)
    forces, left, found = _solved(
        items, used, patches, centres, weights, lower, upper, mean, grow, corners
    )
    moves = np.zeros(len(weights), dtype=np.bool_)
    ended, item = _judged(items, used, forces, left, patches, centres, weights, lower, upper, mean,
                          heaviest, grow, moves)  # fmt: skip
    return mean * forces, ended, item, found


@compiled
def free_with_those_above(item: int, step: int, contacts: Contacts, role: Any) -> None:
    """Free an item and what stands on it."""
    role[item] = FREE
    for k in range(contacts.above_starts[item], contacts.above_ends[item]):
        other = contacts.above[k]
        if other <= step and not contacts.on_floor[other]:
            role[other] = FREE


@compiled
def forget(role: Any) -> None:
    """Forget what was handed down; free items stay so."""
    for j in range(len(role)):
        if role[j] != FREE:
            role[j] = 0


@compiled
def patches_of(free: Any, step: int, contacts: Contacts, meets: Any, role: Any) -> Any:
    """Patches at which free items touch anything, and what is above and below each, (k, 3)."""
    count = 0
    for item in free:
        count += contacts.ends[item] - contacts.starts[item]
        count += contacts.above_ends[item] - contacts.above_starts[item]
    found = np.empty((count, 3), dtype=np.int64)
    count = 0
    for item in free:
        for k in range(contacts.starts[item], contacts.ends[item]):
            if contacts.below[k] <= step and is_left(contacts.patches, k):
                found[count, 0], found[count, 1], found[count, 2] = k, item, contacts.below[k]
                count += 1
        for k in range(contacts.above_starts[item], contacts.above_ends[item]):
            other = contacts.above[k]
            if other <= step and role[other] != FREE and not contacts.on_floor[other]:
                if not is_left(contacts.patches, meets[k]):
                    continue
                found[count, 0], found[count, 1], found[count, 2] = meets[k], other, item
                count += 1
    return found[:count]


@compiled
def _solved(
    free: Any, used: Any, patches: Any, centres: Any, weights: Any, lower: Any, upper: Any,
    mean: float, grow: float, corners: Any,
) -> Any:  # fmt: skip
    """Forces at the corners of patches (k, 4) that come closest to balance, what is left over of
    the equations of every item (n, 3), and whether the search ended. It begins with the corners
    named, (P, 4).
    """
    count = len(free)
    row = np.full(len(weights), -1, dtype=np.int64)
    columns, target = np.zeros((4 * len(used), 2, 3)), np.zeros(3 * count)
    blocks = np.full((4 * len(used), 2), -1, dtype=np.int64)
    likely = np.zeros(4 * len(used), dtype=np.bool_)
    for n in range(count):
        row[free[n]] = n
        target[3 * n] = np.sqrt(weights[free[n]] / mean)
    for column in range(4 * len(used)):
        corner = column % 4
        x0, z0, x1, z1 = patches[used[column // 4, 0]]
        x = x0 - grow if corner < 2 else x1 + grow
        z = z0 - grow if corner % 2 == 0 else z1 + grow
        likely[column] = corners[used[column // 4, 0], corner]
        for side in range(2):
            felt = used[column // 4, 1 + side]
            n = row[felt] if felt >= 0 else -1
            if n >= 0:
                blocks[column, side] = 3 * n
                sign = (1.0 if side == 0 else -1.0) / target[3 * n]
                across, along = _radii(felt, lower, upper)
                columns[column, side, 0] = sign
                columns[column, side, 1] = sign * (x - centres[felt, 0]) / across
                columns[column, side, 2] = sign * (z - centres[felt, 2]) / along
    likely_ones = np.flatnonzero(likely)
    forces, left, ended = least_squares_of_blocks(columns, target, blocks, likely_ones)
    return forces.reshape(-1, 4), left, ended


@compiled
def _radii(item: int, lower: Any, upper: Any) -> Any:
    """Radii of gyration for moments of x and of z [cm]."""
    a, b, c = upper[item] - lower[item]
    return np.sqrt((a**2 + b**2) / 12.0), np.sqrt((c**2 + b**2) / 12.0)


@compiled
def _press(k: int, at: Any, contacts: Contacts, mean: float, changed: Any) -> None:
    """The load of forces at the corners of a patch on what is below it."""
    x0, z0, x1, z1 = contacts.patches[k]
    changed[k] = 0.0
    changed[k, 1] = -mean * (at[0] + at[1] + at[2] + at[3])
    changed[k, 3] = mean * ((at[0] + at[2]) * z0 + (at[1] + at[3]) * z1)
    changed[k, 5] = -mean * ((at[0] + at[1]) * x0 + (at[2] + at[3]) * x1)


@compiled
def _keep(k: int, changed: Any, presses: Any) -> None:
    presses[k, 0], presses[k, 1], presses[k, 2] = -changed[k, 1], -changed[k, 5], changed[k, 3]


@compiled
def _load_other(
    patch: Any, contacts: Contacts, role: Any, presses: Any, changed: Any, loads: Any
) -> None:
    """Where one of the two items of a patch is at rest: what it gets from the other."""
    k, above, below = patch
    if role[above] == FREE and (below == FLOOR or role[below] == FREE or contacts.on_floor[below]):
        return
    item, sign = (below, 1.0) if role[above] == FREE else (above, -1.0)
    if changed[k, 1] != 0.0 or presses[k, 0] != 0.0:
        role[item] = WAITING
        for c in range(6):
            loads[item, c] += sign * changed[k, c]


@compiled
def _judged(
    free: Any, used: Any, forces: Any, left: Any, patches: Any, centres: Any, weights: Any,
    lower: Any, upper: Any, mean: float, heaviest: float, grow: float, moves: Any,
) -> Any:  # fmt: skip
    """Whether free items are balanced, and the one that starts fastest; which of them move."""
    count = len(free)
    root, half, radii = np.empty(count), np.empty((count, 2)), np.empty((count, 2))
    pressed = np.zeros(3 * count)
    for n in range(count):
        item = free[n]
        root[n] = np.sqrt(weights[item] / mean)
        radii[n, 0], radii[n, 1] = _radii(item, lower, upper)
        half[n, 0] = 0.5 * (upper[item, 0] - lower[item, 0])
        half[n, 1] = 0.5 * (upper[item, 2] - lower[item, 2])
        pressed[3 * n] = root[n]
        for m in range(len(used)):
            if used[m, 1] != item and used[m, 2] != item:
                continue
            x0, z0, x1, z1 = patches[used[m, 0]]
            for corner in range(4):
                x = x0 - grow if corner < 2 else x1 + grow
                z = z0 - grow if corner % 2 == 0 else z1 + grow
                force = forces[m, corner] / root[n]
                pressed[3 * n] += force
                pressed[3 * n + 1] += abs(x - centres[item, 0]) / radii[n, 0] * force
                pressed[3 * n + 2] += abs(z - centres[item, 2]) / radii[n, 1] * force
    beyond, proven = False, False
    motions = np.empty(count)
    for n in range(count):
        motions[n] = _fastest_corner(left, n, root, radii, half)
        moves[free[n]] = motions[n] > RESIDUE * _fastest_corner(pressed, n, root, radii, half)
        if moves[free[n]]:
            beyond = True
            if motions[n] > NOISE * np.sqrt(heaviest / weights[free[n]]):
                proven = True
    if not beyond:
        return BALANCED, -1
    # Of items that start equally fast the first is named.
    return (UNBALANCED if proven else UNRESOLVED), free[
        np.argmax(motions >= (1.0 - TIE) * motions.max())
    ]


@compiled
def _fastest_corner(left: Any, n: int, root: Any, radii: Any, half: Any) -> float:
    """How fast the corner of an item that starts fastest accelerates [g]."""
    along = abs(left[3 * n])
    turned = abs(left[3 * n + 1]) / radii[n, 0] * half[n, 0]
    turned += abs(left[3 * n + 2]) / radii[n, 1] * half[n, 1]
    return (along + turned) / root[n]

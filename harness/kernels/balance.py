"""Vertical balance of a loading: the first step after which contacts cannot carry every item.

The formula is that of :mod:`steadyload.methods.balance`, which tells why it is exact: the new
weight is passed down one way, and only where that fails are the forces of all joined items solved
for.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from steadyload.kernels.compiled import compiled
from steadyload.kernels.constants import (
    BALANCED,
    EDGE,
    FLOOR,
    NOISE,
    RESIDUE,
    TIE,
    UNBALANCED,
    UNRESOLVED,
)
from steadyload.kernels.contacts import contacts_of
from steadyload.kernels.least_squares import nonnegative_least_squares


@compiled
def first_unbalanced(lower: Any, upper: Any, weights: Any, offsets: Any, floor: Any) -> Any:
    """The first step after which vertical forces at contacts cannot balance every item.

    Args:
        lower: see :mod:`steadyload.kernels`.
        upper: likewise.
        weights: likewise.
        offsets: likewise.
        floor: likewise, shape (5,).

    Returns:
        How the search ended, the step at which it did (the number of items where all are balanced),
        and the item that is out of balance (-1 where none is).
    """
    count = len(lower)
    contacts = contacts_of(lower, upper, floor)
    centres = np.empty((count, 3))
    for j in range(count):
        for c in range(3):
            centres[j, c] = 0.5 * (lower[j, c] + upper[j, c]) + offsets[j, c]
    meets = patches_above(contacts)
    presses = np.zeros((len(contacts.below), 3))
    changed = np.empty_like(presses)
    moves = np.zeros(count, dtype=np.bool_)
    for step in range(count):
        ended, item, items = balance_after(
            step, contacts, meets, centres, weights, lower, upper, moves, presses, changed
        )
        if ended != BALANCED:
            return ended, step, item
        replace_presses(items, step, contacts, presses, changed)
    return BALANCED, count, -1


@compiled
def balance_after(
    step: int, contacts: Any, meets: Any, centres: Any, weights: Any, lower: Any, upper: Any,
    moves: Any, presses: Any, changed: Any,
) -> Any:  # fmt: skip
    """Forces that balance every item once another is placed on items that are balanced.

    Args:
        step: the new item.
        contacts: of the layout; later items do not count.
        meets: of :func:`patches_above`.
        centres: of mass (x, y, z) [cm], shape (J, 3).
        weights: [kg], shape (J,).
        lower: corners [cm], shape (J, 3).
        upper: likewise.
        moves: items that nothing can be passed to, shape (J,).
        presses: force [kg] and its moments [kg cm] at every patch so far, shape (P, 3).
        changed: the new ones are put there, shape (P, 3).

    Returns:
        How the search ended, the item that is out of balance (-1 where none is), and the items
        below which presses change.
    """
    nobody = np.empty(0, dtype=np.int64)
    if contacts.on_floor[step]:
        return BALANCED, -1, nobody
    first = contacts.above_starts[step]
    if first == contacts.above_ends[step] or contacts.above[first] > step:
        passed, items = _passing_down(
            step, contacts, meets, centres, weights, lower, moves, presses, changed
        )
        if passed:
            return BALANCED, -1, items
        # Nothing holds down the newest item, so no forces elsewhere help it.
        x, z = centres[step, 0], centres[step, 2]
        carriers = _carriers(step, step, contacts)
        if not spread(weights[step], x, z, contacts.patches[carriers], changed[carriers]):
            return UNBALANCED, step, nobody
    items = joined(step, contacts)
    ended, item = _solve(step, items, contacts, centres, weights, lower, upper, changed)
    return ended, item, items


@compiled
def replace_presses(items: Any, step: int, contacts: Any, presses: Any, changed: Any) -> None:
    """Replace presses below some items, on what is there after a step, by changed ones."""
    for item in items:
        for k in range(contacts.starts[item], contacts.ends[item]):
            if contacts.below[k] <= step:
                presses[k] = changed[k]


@compiled
def first_unbalanced_of_many(
    lower: Any, upper: Any, weights: Any, offsets: Any, floors: Any, starts: Any
) -> Any:
    """How :func:`first_unbalanced` ended for every layout of a batch, and the step, (L,) each."""
    count = len(starts) - 1
    ended, steps = np.empty(count, dtype=np.int64), np.empty(count, dtype=np.int64)
    for k in range(count):
        part = slice(starts[k], starts[k + 1])
        found = first_unbalanced(lower[part], upper[part], weights[part], offsets[part], floors[k])
        ended[k], steps[k] = found[0], found[1]
    return ended, steps


@compiled
def patches_above(contacts: Any) -> Any:
    """The patch of every pair of ``contacts.above``: where the item above stands on its carrier."""
    meets = np.empty(len(contacts.above), dtype=np.int64)
    ends = contacts.above_starts[:-1].copy()
    for k in range(len(contacts.below)):
        carrier = contacts.below[k]
        if carrier != FLOOR:
            meets[ends[carrier]] = k
            ends[carrier] += 1
    return meets


@compiled
def passed_down(
    step: int, contacts: Any, meets: Any, centres: Any, weights: Any, lower: Any, moves: Any,
    presses: Any, changed: Any,
) -> bool:  # fmt: skip
    """Pass the new weight down one way; presses are replaced only where it succeeds.

    Args:
        step: the new item.
        contacts: of the layout.
        meets: of :func:`patches_above`.
        centres: of mass (x, y, z) [cm], shape (J, 3).
        weights: [kg], shape (J,).
        lower: corners [cm], shape (J, 3).
        moves: items that nothing can be passed to, shape (J,).
        presses: force [kg] and its moments [kg cm] at every patch, shape (P, 3).
        changed: room of that shape.
    """
    passed, items = _passing_down(
        step, contacts, meets, centres, weights, lower, moves, presses, changed
    )
    if passed:
        replace_presses(items, step, contacts, presses, changed)
    return passed


@compiled
def _passing_down(
    step: int, contacts: Any, meets: Any, centres: Any, weights: Any, lower: Any, moves: Any,
    presses: Any, changed: Any,
) -> Any:  # fmt: skip
    """See :func:`passed_down`; whether it succeeds, and the items below which presses change."""
    passed, waiting = [step], [step]
    done = 0
    while done < len(waiting):
        # The highest base first: items above an item have passed on their loads before it.
        best = done
        for k in range(done + 1, len(waiting)):
            a, b = lower[waiting[k], 1], lower[waiting[best], 1]
            if a > b or (a == b and waiting[k] < waiting[best]):
                best = k
        item = waiting[best]
        if moves[item]:
            return False, np.empty(0, dtype=np.int64)
        waiting[best] = waiting[done]
        waiting[done] = item
        done += 1
        force = weights[item]
        x, z = force * centres[item, 0], force * centres[item, 2]
        for k in range(contacts.above_starts[item], contacts.above_ends[item]):
            other = contacts.above[k]
            if other <= step:
                load = changed[meets[k]] if other in passed else presses[meets[k]]
                force, x, z = force + load[0], x + load[1], z + load[2]
        for k in range(contacts.starts[item], contacts.ends[item]):
            changed[k] = 0.0
        carriers = _carriers(item, step, contacts)
        patches = contacts.patches[carriers]
        if not spread(force, x / force, z / force, patches, changed[carriers]):
            return False, np.empty(0, dtype=np.int64)
        passed.append(item)
        for k in range(contacts.starts[item], contacts.ends[item]):
            carrier = contacts.below[k]
            if carrier == FLOOR or carrier >= step or contacts.on_floor[carrier]:
                continue
            # Supporters that no longer carry anything must be updated, too.
            loaded = changed[k, 0] != 0.0 or presses[k, 0] != 0.0
            if loaded and carrier not in waiting:
                waiting.append(carrier)
    return True, np.array(waiting)


@compiled
def _carriers(item: int, step: int, contacts: Any) -> Any:
    """The patches of an item on carriers that were placed before a step: the first of its patches,
    as carriers ascend.
    """
    first, end = contacts.starts[item], contacts.ends[item]
    while end > first and contacts.below[end - 1] >= step:
        end -= 1
    return slice(first, end)


@compiled
def spread(force: float, x: float, z: float, patches: Any, presses: Any) -> bool:
    """One way for patches to carry a force; False where none is found.

    Args:
        force: downwards [kg].
        x: where it acts [cm].
        z: likewise.
        patches: (x0, z0, x1, z1) [cm], shape (k, 4).
        presses: the force at every patch and its moments are put there, shape (k, 3).
    """
    presses[:] = 0.0
    count = len(patches)
    for k in range(count):
        x0, z0, x1, z1 = patches[k]
        if x0 - EDGE <= x <= x1 + EDGE and z0 - EDGE <= z <= z1 + EDGE:
            presses[k, 0], presses[k, 1], presses[k, 2] = force, force * x, force * z
            return True
    if count < 2:
        return False
    # First where each patch is nearest to the force, as a stiff beam presses; then at the corners.
    for corners in (1, 4):
        points = np.empty((count * corners, 2))
        for k in range(count):
            x0, z0, x1, z1 = patches[k]
            for corner in range(corners):
                at = k * corners + corner
                if corners == 1:
                    points[at, 0], points[at, 1] = min(max(x, x0), x1), min(max(z, z0), z1)
                else:
                    points[at, 0] = x0 if corner < 2 else x1
                    points[at, 1] = z0 if corner % 2 == 0 else z1
        if _shared(force, x, z, points, corners, presses):
            return True
    return False


@compiled
def _shared(force: float, x: float, z: float, points: Any, corners: int, presses: Any) -> bool:
    """Forces at given points whose resultant is the given one, added to the presses of their
    patches, which have so many points each; False without any.
    """
    # Lengths in units of the farthest point, so that the residue means the same at every size.
    reach = 0.0
    for a, b in points:
        reach = max(reach, max(abs(a - x), abs(b - z)))
    columns, target = np.empty((len(points), 3)), np.zeros(3)
    for k in range(len(points)):
        columns[k, 0] = 1.0
        columns[k, 1] = (points[k, 0] - x) / reach
        columns[k, 2] = (points[k, 1] - z) / reach
    target[0] = 1.0
    parts, rest, ended = nonnegative_least_squares(columns, target)
    if not ended or np.sqrt((rest**2).sum()) * reach > 0.1 * EDGE:
        return False
    for k in range(len(points)):
        if parts[k] > 0.0:
            part, owner = parts[k] * force, k // corners
            presses[owner, 0] += part
            presses[owner, 1] += part * points[k, 0]
            presses[owner, 2] += part * points[k, 1]
    return True


@compiled
def joined(step: int, contacts: Any) -> Any:
    """The new item and all earlier ones joined to it by standing on each other, without those on
    the floor, in order.
    """
    seen = np.zeros(len(contacts.on_floor), dtype=np.bool_)
    seen[step] = True
    todo = [step]
    while len(todo) > 0:
        at = todo.pop()
        for k in range(contacts.starts[at], contacts.ends[at]):
            other = contacts.below[k]
            if other == FLOOR or contacts.on_floor[other]:
                continue
            if other <= step and not seen[other]:
                seen[other] = True
                todo.append(other)
        for k in range(contacts.above_starts[at], contacts.above_ends[at]):
            other = contacts.above[k]
            if other <= step and not seen[other] and not contacts.on_floor[other]:
                seen[other] = True
                todo.append(other)
    return np.flatnonzero(seen)


@compiled
def _solve(
    step: int, items: Any, contacts: Any, centres: Any, weights: Any, lower: Any, upper: Any,
    presses: Any,
) -> Any:  # fmt: skip
    """The forces among joined items that come closest to balance; put in presses if they balance.

    The equations are weighed by mass and inertia: what is left over of them is an acceleration.
    """
    count = len(items)
    row = np.full(len(weights), -1, dtype=np.int64)
    mean = 0.0
    for n in range(count):
        row[items[n]] = n
        mean += weights[items[n]]
    mean /= count
    used, owners = _present(items, step, contacts)
    # Of every item: the root of its mass, its radii of gyration and half sides along x and z.
    root, radii, half = np.empty(count), np.empty((count, 2)), np.empty((count, 2))
    for n in range(count):
        item = items[n]
        root[n] = np.sqrt(weights[item] / mean)
        high = 0.5 * (upper[item, 1] - lower[item, 1])
        for axis in range(2):
            half[n, axis] = 0.5 * (upper[item, 2 * axis] - lower[item, 2 * axis])
            radii[n, axis] = np.sqrt((half[n, axis] ** 2 + high**2) / 3.0)
    columns, target = np.zeros((4 * len(used), 3 * count)), np.zeros(3 * count)
    for n in range(count):
        target[3 * n] = root[n]
    for column in range(4 * len(used)):
        k, corner = used[column // 4], column % 4
        x0, z0, x1, z1 = contacts.patches[k]
        x = x0 - EDGE if corner < 2 else x1 + EDGE
        z = z0 - EDGE if corner % 2 == 0 else z1 + EDGE
        # The item above feels the force, and the one below its opposite.
        for side in range(2):
            felt = owners[column // 4] if side == 0 else contacts.below[k]
            n = row[felt] if felt >= 0 else -1
            if n >= 0:
                sign = (1.0 if side == 0 else -1.0) / root[n]
                columns[column, 3 * n] = sign
                columns[column, 3 * n + 1] = sign * (x - centres[felt, 0]) / radii[n, 0]
                columns[column, 3 * n + 2] = sign * (z - centres[felt, 2]) / radii[n, 1]
    forces, left, ended = nonnegative_least_squares(columns, target)
    if not ended:
        return UNRESOLVED, -1
    loads = target.copy()
    for pressed in np.flatnonzero(forces):
        for r in range(len(loads)):
            loads[r] += abs(columns[pressed, r]) * forces[pressed]
    noise = NOISE * root.max() / root
    beyond, proven = False, False
    motions = np.empty(count)
    for n in range(count):
        motion = fastest_corner(left, n, root, radii, half)
        motions[n] = motion
        if motion > RESIDUE * fastest_corner(loads, n, root, radii, half):
            beyond = True
            if motion > noise[n]:
                proven = True
    if beyond:
        worst = items[np.argmax(motions >= (1.0 - TIE) * motions.max())]
        return (UNBALANCED, worst) if proven else (UNRESOLVED, -1)
    for at in range(len(used)):
        k = used[at]
        x0, z0, x1, z1 = contacts.patches[k]
        a, b, c, d = forces[4 * at : 4 * at + 4] * mean
        presses[k, 0] = a + b + c + d
        presses[k, 1] = (a + b) * x0 + (c + d) * x1
        presses[k, 2] = (a + c) * z0 + (b + d) * z1
    return BALANCED, -1


@compiled
def _present(items: Any, step: int, contacts: Any) -> Any:
    """The patches that items stand on after a step, and the item that stands on each."""
    most = 0
    for item in items:
        most += contacts.ends[item] - contacts.starts[item]
    used, owners = np.empty(most, dtype=np.int64), np.empty(most, dtype=np.int64)
    found = 0
    for item in items:
        for k in range(contacts.starts[item], contacts.ends[item]):
            if contacts.below[k] <= step:
                used[found], owners[found] = k, item
                found += 1
    return used[:found], owners[:found]


@compiled
def fastest_corner(left: Any, n: int, root: Any, radii: Any, half: Any) -> float:
    """How fast the corner of an item that starts fastest accelerates [g]."""
    along = abs(left[3 * n])
    turned = abs(left[3 * n + 1]) / radii[n, 0] * half[n, 0]
    turned += abs(left[3 * n + 2]) / radii[n, 1] * half[n, 1]
    return (along + turned) / root[n]

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
    centres = np.empty((count, 2))
    for j in range(count):
        centres[j, 0] = 0.5 * (lower[j, 0] + upper[j, 0]) + offsets[j, 0]
        centres[j, 1] = 0.5 * (lower[j, 2] + upper[j, 2]) + offsets[j, 2]
    meets = _patches_above(contacts)
    presses = np.zeros((len(contacts.below), 3))
    changed = np.empty_like(presses)
    for step in range(count):
        ended, item, items = balance_after(
            step, contacts, meets, centres, weights, lower, upper, presses, changed
        )
        if ended != BALANCED:
            return ended, step, item
        for j in items:
            for k in range(contacts.starts[j], contacts.ends[j]):
                if contacts.below[k] <= step:
                    presses[k] = changed[k]
    return BALANCED, count, -1


@compiled
def balance_after(
    step: int, contacts: Any, meets: Any, centres: Any, weights: Any, lower: Any, upper: Any,
    presses: Any, changed: Any,
) -> Any:  # fmt: skip
    """Forces that balance every item once another is placed on items that are balanced.

    Args:
        step: the new item.
        contacts: of the layout; later items do not count.
        meets: the patch of every pair of ``contacts.above``.
        centres: of mass, (x, z) [cm], shape (J, 2).
        weights: [kg], shape (J,).
        lower: corners [cm], shape (J, 3).
        upper: likewise.
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
        passed, items = _passed_down(
            step, contacts, meets, centres, weights, lower, presses, changed
        )
        if passed:
            return BALANCED, -1, items
        # Nothing holds down the newest item, so no forces elsewhere help it.
        x, z = centres[step]
        if not _spread(step, step, weights[step], x, z, contacts, changed):
            return UNBALANCED, step, nobody
    items = _joined(step, contacts)
    ended, item = _solve(step, items, contacts, centres, weights, lower, upper, changed)
    return ended, item, items


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
def _patches_above(contacts: Any) -> Any:
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
def _passed_down(
    step: int, contacts: Any, meets: Any, centres: Any, weights: Any, lower: Any, presses: Any,
    changed: Any,
) -> Any:  # fmt: skip
    """Pass the new weight down one way.

    Args:
        step: the new item.
        contacts: of the layout.
        meets: of :func:`_patches_above`.
        centres: of mass, (x, z) [cm], shape (J, 2).
        weights: [kg], shape (J,).
        lower: corners [cm], shape (J, 3).
        presses: force [kg] and its moments [kg cm] at every patch, shape (P, 3).
        changed: the new ones are put there, shape (P, 3).

    Returns:
        Whether it succeeds, and the items below which presses change.
    """
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
        waiting[best] = waiting[done]
        waiting[done] = item
        done += 1
        force = weights[item]
        x, z = force * centres[item, 0], force * centres[item, 1]
        for k in range(contacts.above_starts[item], contacts.above_ends[item]):
            other = contacts.above[k]
            if other <= step:
                load = changed[meets[k]] if other in passed else presses[meets[k]]
                force, x, z = force + load[0], x + load[1], z + load[2]
        if not _spread(item, step, force, x / force, z / force, contacts, changed):
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
def _spread(
    item: int, step: int, force: float, x: float, z: float, contacts: Any, presses: Any
) -> bool:
    """One way for the patches below an item to carry a force at a point; False where none is found.

    Args:
        item: that is carried.
        step: later items carry nothing yet.
        force: [kg].
        x: where it acts [cm].
        z: likewise.
        contacts: of the layout.
        presses: the forces at those patches are put there, shape (P, 3).
    """
    first, end = contacts.starts[item], contacts.ends[item]
    patches = 0
    for k in range(first, end):
        presses[k] = 0.0
    for k in range(first, end):
        if contacts.below[k] >= step:
            continue
        x0, z0, x1, z1 = contacts.patches[k]
        if x0 - EDGE <= x <= x1 + EDGE and z0 - EDGE <= z <= z1 + EDGE:
            presses[k, 0], presses[k, 1], presses[k, 2] = force, force * x, force * z
            return True
        patches += 1
    if patches < 2:
        return False
    # First where each patch is nearest to the force, as a stiff beam presses; then at the corners.
    for corners in (1, 4):
        points, owners = np.empty((patches * corners, 2)), np.empty(patches * corners, np.int64)
        at = 0
        for k in range(first, end):
            if contacts.below[k] >= step:
                continue
            x0, z0, x1, z1 = contacts.patches[k]
            for corner in range(corners):
                if corners == 1:
                    points[at, 0], points[at, 1] = min(max(x, x0), x1), min(max(z, z0), z1)
                else:
                    points[at, 0] = x0 if corner < 2 else x1
                    points[at, 1] = z0 if corner % 2 == 0 else z1
                owners[at] = k
                at += 1
        if _shared(force, x, z, points, owners, presses):
            return True
    return False


@compiled
def _shared(force: float, x: float, z: float, points: Any, owners: Any, presses: Any) -> bool:
    """Forces at given points whose resultant is the given one, added to the presses of their
    patches; False without any.
    """
    # Lengths in units of the farthest point, so that the residue means the same at every size.
    reach = 0.0
    for a, b in points:
        reach = max(reach, max(abs(a - x), abs(b - z)))
    matrix, target = np.empty((3, len(points))), np.zeros(3)
    for k in range(len(points)):
        matrix[0, k] = 1.0
        matrix[1, k] = (points[k, 0] - x) / reach
        matrix[2, k] = (points[k, 1] - z) / reach
    target[0] = 1.0
    parts, rest, ended = nonnegative_least_squares(matrix, target)
    if not ended or np.sqrt((rest**2).sum()) * reach > 0.1 * EDGE:
        return False
    for k in range(len(points)):
        if parts[k] > 0.0:
            part, owner = parts[k] * force, owners[k]
            presses[owner, 0] += part
            presses[owner, 1] += part * points[k, 0]
            presses[owner, 2] += part * points[k, 1]
    return True


@compiled
def _joined(step: int, contacts: Any) -> Any:
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
    matrix, target = np.zeros((3 * count, 4 * len(used))), np.zeros(3 * count)
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
                matrix[3 * n, column] = sign
                matrix[3 * n + 1, column] = sign * (x - centres[felt, 0]) / radii[n, 0]
                matrix[3 * n + 2, column] = sign * (z - centres[felt, 1]) / radii[n, 1]
    forces, left, ended = nonnegative_least_squares(matrix, target)
    if not ended:
        return UNRESOLVED, -1
    loads = target.copy()
    for pressed in np.flatnonzero(forces):
        for r in range(len(loads)):
            loads[r] += abs(matrix[r, pressed]) * forces[pressed]
    noise = NOISE * root.max() / root
    beyond, proven = False, False
    motions = np.empty(count)
    for n in range(count):
        motion = _fastest_corner(left, n, root, radii, half)
        motions[n] = motion
        if motion > RESIDUE * _fastest_corner(loads, n, root, radii, half):
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
def _fastest_corner(left: Any, n: int, root: Any, radii: Any, half: Any) -> float:
    """How fast the corner of an item that starts fastest accelerates [g]."""
    along = abs(left[3 * n])
    turned = abs(left[3 * n + 1]) / radii[n, 0] * half[n, 0]
    turned += abs(left[3 * n + 2]) / radii[n, 1] * half[n, 1]
    return (along + turned) / root[n]

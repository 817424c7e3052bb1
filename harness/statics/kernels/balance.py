"""Vertical balance of a loading: the first step after which contacts cannot carry every item.

The formula is that of :mod:`steadyload.statics.balance`, which tells why it is exact:
the new weight is passed down one way, and only where that fails are forces solved for, of as few
items as it takes: see :mod:`steadyload.statics.kernels.local_balance`.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from steadyload.statics.kernels.compiled import compiled
from steadyload.statics.kernels.constants import BALANCED, FLOOR, UNBALANCED
from steadyload.statics.kernels.contacts import Contacts, contacts_of, draw_in
from steadyload.statics.kernels.local_balance import balance_group
from steadyload.statics.kernels.spreading import spread


class Held(NamedTuple):
    """Items, and the forces that balance those placed so far.

    What is called at every step takes these arrays one by one: to hand on all of them costs as much
    as to pass a weight down.

    Attributes:
        lower, upper, weights: see :mod:`steadyload.statics.kernels`.
        centres: of mass (x, y, z) [cm], shape (J, 3).
        contacts: of all items.
        meets: of :func:`patches_above`.
        presses: force [kg] and its moments [kg cm] at every patch so far, shape (P, 3).
        changed: the new ones are put there, shape (P, 3).
        moves: items that nothing can be passed to, shape (J,).
    """

    lower: Any
    upper: Any
    weights: Any
    centres: Any
    contacts: Contacts
    meets: Any
    presses: Any
    changed: Any
    moves: Any


@compiled
def begin(lower: Any, upper: Any, weights: Any, offsets: Any, floor: Any, margin: float) -> Held:
    """Items of which none is placed yet.

    Args:
        lower: see :mod:`steadyload.statics.kernels`.
        upper: likewise.
        weights: likewise.
        offsets: likewise.
        floor: likewise, shape (5,).
        margin: by which contact patches are drawn in on every side [cm].
    """
    contacts = contacts_of(lower, upper, floor)
    draw_in(contacts.patches, margin)
    presses = np.zeros((len(contacts.below), 3))
    return Held(
        lower, upper, weights, 0.5 * (lower + upper) + offsets, contacts, patches_above(contacts),
        presses, np.empty_like(presses), np.zeros(len(lower), dtype=np.bool_),
    )  # fmt: skip


@compiled
def first_unbalanced(
    lower: Any, upper: Any, weights: Any, offsets: Any, floor: Any, margin: float
) -> Any:
    """The first step after which vertical forces at contacts cannot balance every item.

    Args:
        lower: see :mod:`steadyload.statics.kernels`.
        upper: likewise.
        weights: likewise.
        offsets: likewise.
        floor: likewise, shape (5,).
        margin: by which contact patches are drawn in on every side [cm].

    Returns:
        How the search ended, the step at which it did (the number of items where all are balanced),
        and the item that is out of balance (-1 where none is).
    """
    count = len(lower)
    held = begin(lower, upper, weights, offsets, floor, margin)
    contacts, meets, centres = held.contacts, held.meets, held.centres
    moves, presses, changed = held.moves, held.presses, held.changed
    for step in range(count):
        if margin > 0.0 and is_near_its_edge(step, contacts, lower, upper, offsets, margin):
            return UNBALANCED, step, step
        ended, item, items = balance_after(
            step, contacts, meets, centres, weights, lower, upper, moves, presses, changed, False
        )
        if ended != BALANCED:
            return ended, step, item
        replace_presses(items, step, contacts, presses, changed)
    return BALANCED, count, -1


@compiled
def balance_whole_group(step: int, held: Held) -> Any:
    """Place an item, whatever came of those before; forces are solved for of whole groups.

    Where rounding hides whether they balance, nothing is changed.

    Args:
        step: the new item.
        held: brought up to date.

    Returns:
        How it ended, and the item that is out of balance, -1 where none is.
    """
    ended, item, items = balance_after(
        step, held.contacts, held.meets, held.centres, held.weights, held.lower, held.upper,
        held.moves, held.presses, held.changed, True,
    )  # fmt: skip
    if ended == BALANCED:
        replace_presses(items, step, held.contacts, held.presses, held.changed)
        held.moves[items] = False
    elif ended == UNBALANCED:
        held.moves[joined(step, held.contacts)] = True
    return ended, item


@compiled
def is_near_its_edge(
    item: int, contacts: Any, lower: Any, upper: Any, offsets: Any, margin: float
) -> bool:
    """Whether an item on the floor has its centre of mass outside its base, drawn in by a margin.

    Nothing else keeps such an item from standing: what it carries presses on its top.

    Args:
        item: any.
        contacts: of the layout.
        lower: corners [cm], shape (J, 3).
        upper: likewise.
        offsets: of centres of mass [cm], shape (J, 3).
        margin: above 0 [cm].
    """
    if not contacts.on_floor[item]:
        return False
    across = 0.5 * (upper[item, 0] - lower[item, 0]) - abs(offsets[item, 0])
    along = 0.5 * (upper[item, 2] - lower[item, 2]) - abs(offsets[item, 2])
    return bool(min(across, along) < margin)


@compiled
def balance_after(
    step: int, contacts: Any, meets: Any, centres: Any, weights: Any, lower: Any, upper: Any,
    moves: Any, presses: Any, changed: Any, whole: bool,
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
        whole: where the new weight cannot be passed down, solve for all items of the group.

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
    ended, item = balance_group(
        step, items, contacts, meets, centres, weights, lower, upper, presses, changed,
        np.zeros((len(presses), 4), dtype=np.bool_), np.zeros_like(moves),
        np.empty((len(presses), 6)), whole,
    )  # fmt: skip
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
    lower: Any, upper: Any, weights: Any, offsets: Any, floors: Any, starts: Any, margin: float
) -> Any:
    """How :func:`first_unbalanced` ended for every layout of a batch, and the step, (L,) each."""
    count = len(starts) - 1
    ended, steps = np.empty(count, dtype=np.int64), np.empty(count, dtype=np.int64)
    for k in range(count):
        part = slice(starts[k], starts[k + 1])
        found = first_unbalanced(
            lower[part], upper[part], weights[part], offsets[part], floors[k], margin
        )
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

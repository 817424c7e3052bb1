"""A layout that grows item by item, in arrays with room for more; a new item costs what it touches.

Compiled functions take :class:`Arrays` as a plain tuple: numba hands that over at the cost of loose
arrays, and takes a microsecond and a half more to find out what a NamedTuple is.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from steadyload.statics.kernels.cells import SLABS, common_items, enter, leave, lowest, rows_near
from steadyload.statics.kernels.compiled import compiled
from steadyload.statics.kernels.constants import FLOOR, FULL, OUTSIDE, OVERLAPS, STANDS, TOLERANCE
from steadyload.statics.kernels.contacts import Contacts

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

BOX = 14
"""Where the next item begins in ``limits``."""

ITEMS, PATCHES, ABOVES, CHANGES, OVERHUNG = range(5)
"""Places in ``counts``."""

_ROOM = 4
"""Places for items above an item at first."""

_FIRST_ROOM = 64


class Arrays(NamedTuple):
    """All that is kept of a layout, with room for J items, P patches and L changes of presses.

    Attributes:
        vectors: lower corners, upper corners, and centres of mass minus geometric centres [cm],
            shape (3, J, 3).
        weights: [kg], shape (J,).
        centres: of mass [cm], shape (J, 3).
        blocks: of every item the start and end of its patches and where their room ends, the same
            of the items on it, the start of its changes, whether it stands on the floor, and 0,
            shape (9, J).
        links: what is below each patch, the items above, and the patch of each of them, (3, P).
        patches: as in :mod:`steadyload.statics.kernels.contacts`, shape (P, 4).
        presses: as in :mod:`steadyload.statics.kernels.balance`, and room for others, (2, P, 3).
        changes: item, number of its patch, and its press before, shape (L, 5).
        cells: see :mod:`steadyload.statics.kernels.cells`, shape (6 * SLABS, J / 64).
        counts: items, patches, places for items above, changes, items that stand out over the deck,
            shape (5,).
        limits: contour (lower, upper), deck (x0, z0, x1, z1) and its height (0 for a plane), slabs
            per cm along x, y, z, and the next item: position, size, offset, weight, shape (24,).
    """

    vectors: FloatArray
    weights: FloatArray
    centres: FloatArray
    blocks: IntArray
    links: IntArray
    patches: FloatArray
    presses: FloatArray
    changes: FloatArray
    cells: IntArray
    counts: IntArray
    limits: FloatArray


_AXES = Arrays(1, 0, 0, 1, 1, 0, 1, 0, 1, None, None)  # type: ignore[arg-type]
"""The axis along which each array grows; None for those that do not."""


def first_arrays(least: Sequence[float], most: Sequence[float], deck: Sequence[float]) -> Arrays:
    """The arrays of a layout without items.

    Args:
        least: lower corner of the contour, (x, y, z) [cm].
        most: upper corner of the contour.
        deck: x0, z0, x1, z1 and the height above the ground [cm], 0 for a plane.
    """
    room, links = _FIRST_ROOM, 8 * _FIRST_ROOM
    slabs = SLABS / (np.array(most) - np.array(least))
    return Arrays(
        np.zeros((3, room, 3)), np.zeros(room), np.zeros((room, 3)),
        np.zeros((9, room), dtype=np.int64), np.zeros((3, links), dtype=np.int64),
        np.zeros((links, 4)), np.zeros((2, links, 3)), np.zeros((links, 5)),
        np.zeros((6 * SLABS, room // 64), dtype=np.int64), np.zeros(5, dtype=np.int64),
        np.concatenate((least, most, deck, slabs, np.zeros(10))),
    )  # fmt: skip


def copied(arrays: Arrays) -> Arrays:
    """The same in other memory."""
    return Arrays._make(array.copy() for array in arrays)


def with_more_room(arrays: Arrays) -> Arrays:
    """The same with twice the room."""
    return Arrays._make(
        array if axis is None else np.concatenate((array, np.zeros_like(array)), axis=axis)
        for array, axis in zip(arrays, _AXES, strict=True)
    )


class Growing(NamedTuple):
    """The arrays, seen as the functions on whole layouts see them; names as in :class:`Arrays`."""

    lower: Any
    upper: Any
    offsets: Any
    weights: Any
    centres: Any
    contacts: Contacts
    rooms: Any
    above_rooms: Any
    meets: Any
    presses: Any
    changed: Any
    moves: Any
    begun: Any
    changes: Any
    cells: Any
    counts: Any
    limits: Any
    box: Any


@compiled
def opened(kept: Any) -> Growing:
    """The arrays, a tuple, under the names by which functions on whole layouts know them."""
    arrays = Arrays(*kept)
    blocks, links, vectors = arrays.blocks, arrays.links, arrays.vectors
    contacts = Contacts(
        blocks[7], blocks[0], blocks[1], links[0], arrays.patches, blocks[3], blocks[4], links[1]
    )
    return Growing(
        vectors[0], vectors[1], vectors[2], arrays.weights, arrays.centres, contacts, blocks[2],
        blocks[5], links[2], arrays.presses[0], arrays.presses[1], blocks[8], blocks[6],
        arrays.changes, arrays.cells, arrays.counts, arrays.limits, arrays.limits[BOX:],
    )  # fmt: skip


@compiled
def put(kept: Any) -> Any:
    """Put on the next item, whether it stands or not; how that ended, in the form of a rule's
    answer (see :mod:`steadyload.statics.kernels.placing`).
    """
    grown = opened(kept)
    ended, below, above = touching(grown)
    if ended == STANDS:
        join(grown, below, above)
        keep(grown)
    return ended, -1, 0.0


@compiled
def take_off(kept: Any, count: int) -> None:
    """Take off all items but the first ``count``, from the last on; what lies behind the blocks of
    these is free again.
    """
    grown = opened(kept)
    counts, patches, aboves = grown.counts, 0, 0
    while counts[ITEMS] > count:
        leave(grown.cells, counts[ITEMS] - 1)
        part(grown)
    for item in range(counts[ITEMS]):
        patches = max(patches, grown.rooms[item])
        aboves = max(aboves, grown.above_rooms[item])
    counts[PATCHES], counts[ABOVES] = patches, aboves


@compiled
def touching(grown: Growing) -> Any:
    """The patches that the next item would stand on, and the items that would stand on it.

    They are put behind those that are in use, and the item in the row behind the last one; neither
    counts until :func:`join`.

    Returns:
        How it ended, the number of patches, and that of the items.
    """
    box, limits, number = grown.box, grown.limits, grown.counts[ITEMS]
    first, first_above = grown.counts[PATCHES], grown.counts[ABOVES]
    used = max(first, first_above)
    if number >= len(grown.weights) or 4 * (used + number + 2) > len(grown.meets):
        return FULL, 0, 0
    if grown.counts[CHANGES] + first + number + 1 > len(grown.changes):
        return FULL, 0, 0
    lower, upper = grown.lower[number], grown.upper[number]
    for axis in range(3):
        lower[axis] = box[axis]
        upper[axis] = box[axis] + box[3 + axis]
        grown.offsets[number, axis] = box[6 + axis]
        inside = limits[axis] - lower[axis] <= TOLERANCE
        if not (inside and upper[axis] - limits[3 + axis] <= TOLERANCE):
            return OUTSIDE, 0, 0
    grown.weights[number] = box[9]
    for axis in range(3):
        grown.centres[number, axis] = 0.5 * (lower[axis] + upper[axis]) + box[6 + axis]
    x0, y0, z0, x1, y1, z1 = lower[0], lower[1], lower[2], upper[0], upper[1], upper[2]
    contacts = grown.contacts
    below, above = 0, 0
    grown.contacts.on_floor[number] = int(y0 <= TOLERANCE)
    if y0 <= TOLERANCE and limits[10] > 0.0 and _stands_out(grown, number):
        contacts.on_floor[number] = 0
        a, b = max(limits[6], x0), max(limits[7], z0)
        c, d = min(limits[8], x1), min(limits[9], z1)
        if min(c - a, d - b) > TOLERANCE:
            _note(contacts, first, FLOOR, a, b, c, d)
            below = 1
    rows, cells = rows_near(limits, lower, upper, 2.0 * TOLERANCE), grown.cells
    for word in range((number + 63) // 64):
        bits = common_items(cells, rows, word)
        while bits != 0:
            other = 64 * word + lowest(bits)
            bits &= bits - 1
            a, c = max(grown.lower[other, 0], x0), min(grown.upper[other, 0], x1)
            b, d = max(grown.lower[other, 2], z0), min(grown.upper[other, 2], z1)
            shared = min(c - a, d - b)
            if shared <= TOLERANCE:
                continue
            base, top = grown.lower[other, 1], grown.upper[other, 1]
            if min(shared, min(top, y1) - max(base, y0)) > TOLERANCE:
                return OVERLAPS, 0, 0
            if abs(top - y0) <= TOLERANCE:
                _note(contacts, first + below, other, a, b, c, d)
                below += 1
            if abs(y1 - base) <= TOLERANCE:
                contacts.above[first_above + above] = other
                above += 1
    return STANDS, below, above


@compiled
def _note(
    contacts: Contacts, place: int, below: int, x0: float, z0: float, x1: float, z1: float
) -> None:
    contacts.below[place] = below
    patch = contacts.patches[place]
    patch[0], patch[1], patch[2], patch[3] = x0, z0, x1, z1


@compiled
def _stands_out(grown: Growing, item: int) -> bool:
    """True if an item stands out over an edge of the deck."""
    limits, lower, upper = grown.limits, grown.lower, grown.upper
    before = max(limits[6] - lower[item, 0], limits[7] - lower[item, 2])
    return max(before, max(upper[item, 0] - limits[8], upper[item, 2] - limits[9])) > TOLERANCE


@compiled
def join(grown: Growing, below: int, above: int) -> None:
    """Let the item that :func:`touching` looked at last count: who stands on whom, no forces yet.

    Args:
        grown: the arrays.
        below: the number of its patches.
        above: the number of the items on it.
    """
    counts, contacts = grown.counts, grown.contacts
    number, first, first_above = counts[ITEMS], counts[PATCHES], counts[ABOVES]
    grown.begun[number] = counts[CHANGES]
    contacts.starts[number], contacts.ends[number] = first, first + below
    contacts.above_starts[number] = first_above
    contacts.above_ends[number] = first_above + above
    grown.rooms[number] = counts[PATCHES] = first + below
    grown.above_rooms[number] = counts[ABOVES] = first_above + max(above, _ROOM)
    counts[ITEMS] = number + 1
    counts[OVERHUNG] += _stands_out(grown, number)
    for k in range(first, first + below):
        for n in range(3):
            grown.presses[k, n] = 0.0
        if contacts.below[k] != FLOOR:
            _carry(grown, contacts.below[k], number, k)
    for m in range(first_above, first_above + above):
        grown.meets[m] = _stand(grown, contacts.above[m], number)


@compiled
def _carry(grown: Growing, carrier: int, item: int, patch: int) -> None:
    """Add an item to those on another; where there is no room, all of these move."""
    contacts = grown.contacts
    start, end = contacts.above_starts[carrier], contacts.above_ends[carrier]
    if end == grown.above_rooms[carrier]:
        first = grown.counts[ABOVES]
        for k in range(end - start):
            contacts.above[first + k] = contacts.above[start + k]
            grown.meets[first + k] = grown.meets[start + k]
        contacts.above_starts[carrier], end = first, first + end - start
        grown.above_rooms[carrier] = grown.counts[ABOVES] = first + 2 * (end - first)
    contacts.above[end], grown.meets[end] = item, patch
    contacts.above_ends[carrier] = end + 1


@compiled
def _stand(grown: Growing, item: int, carrier: int) -> int:
    """Add a patch to those of an item below which another is pushed; where there is no room, all
    of these move.
    """
    contacts, counts = grown.contacts, grown.counts
    start, end = contacts.starts[item], contacts.ends[item]
    if end == grown.rooms[item]:
        first = counts[PATCHES]
        for k in range(end - start):
            p = contacts.patches[start + k]
            _note(contacts, first + k, contacts.below[start + k], p[0], p[1], p[2], p[3])
            grown.presses[first + k] = grown.presses[start + k]
            under = contacts.below[first + k]
            if under != FLOOR:
                for m in range(contacts.above_starts[under], contacts.above_ends[under]):
                    if contacts.above[m] == item:
                        grown.meets[m] = first + k
        contacts.starts[item], end = first, first + end - start
        grown.rooms[item] = counts[PATCHES] = first + 2 * (end - first) + 1
    a, b = grown.lower[item], grown.lower[carrier]
    c, d = grown.upper[item], grown.upper[carrier]
    x0, z0, x1, z1 = max(a[0], b[0]), max(a[2], b[2]), min(c[0], d[0]), min(c[2], d[2])
    _note(contacts, end, carrier, x0, z0, x1, z1)
    for n in range(3):
        grown.presses[end, n] = 0.0
    contacts.ends[item] = end + 1
    return end


@compiled
def keep(grown: Growing) -> None:
    """Let the last item be found by its place; :func:`take_off` undoes it."""
    number = grown.counts[ITEMS] - 1
    enter(grown.cells, grown.limits, grown.lower[number], grown.upper[number], number)


@compiled
def part(grown: Growing) -> None:
    """Undo :func:`join` of the last item, which is not kept, and the presses that it changed."""
    counts, contacts = grown.counts, grown.contacts
    number = counts[ITEMS] - 1
    for k in range(counts[CHANGES] - 1, grown.begun[number] - 1, -1):
        change = grown.changes[k]
        at = contacts.starts[int(change[0])] + int(change[1])
        for n in range(3):
            grown.presses[at, n] = change[2 + n]
    counts[CHANGES] = grown.begun[number]
    for k in range(contacts.starts[number], contacts.ends[number]):
        if contacts.below[k] != FLOOR:
            contacts.above_ends[contacts.below[k]] -= 1
    for m in range(contacts.above_starts[number], contacts.above_ends[number]):
        contacts.ends[contacts.above[m]] -= 1
    # Room between others stays unused until :func:`take_off` finds that nothing lies behind it.
    if grown.rooms[number] == counts[PATCHES]:
        counts[PATCHES] = contacts.starts[number]
    if grown.above_rooms[number] == counts[ABOVES]:
        counts[ABOVES] = contacts.above_starts[number]
    counts[OVERHUNG] -= _stands_out(grown, number)
    counts[ITEMS] = number


@compiled
def replace_presses(grown: Growing, items: Any) -> None:
    """Replace the presses below some items by ``changed``, and note those before.

    Args:
        grown: the arrays.
        items: in any order, each once.
    """
    starts = grown.contacts.starts
    for item in items:
        for k in range(starts[item], grown.contacts.ends[item]):
            change = grown.changes[grown.counts[CHANGES]]
            change[0], change[1] = item, k - starts[item]
            for n in range(3):
                change[2 + n] = grown.presses[k, n]
                grown.presses[k, n] = grown.changed[k, n]
            grown.counts[CHANGES] += 1

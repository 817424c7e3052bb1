"""Boxes loaded at given places, each as soon as it stands, in nearly the order of a plan.

A place is a row (x, y, z, turn): the lower corner [cm], and :data:`AS_PLANNED`, :data:`TURNED` or
:data:`LEFT_OUT`. ``boxes`` is a tuple of the arrays of :class:`Boxes`, ``turns`` one of those of
:class:`Turns`, ``kept`` one of those of :class:`steadyload.statics.kernels.growing.Arrays`.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from steadyload.statics.kernels.compiled import compiled
from steadyload.statics.kernels.constants import FULL, STANDS, TOLERANCE
from steadyload.statics.kernels.free_places import nearest_places
from steadyload.statics.kernels.growing import ITEMS, opened, take_off
from steadyload.statics.kernels.placing import BALANCED, ending, place

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

LEFT_OUT, AS_PLANNED, TURNED = -1.0, 0.0, 1.0
"""Last number of a place: the box is left out, as planned, or turned by a quarter."""

OF_MOVED = 0.5
"""Margin of balance [cm] of a box that is not at its place in the plan, at least."""

ALL, LOOK = 0, 1
"""How loading ended besides :data:`FULL`: all boxes had their turn, or one was put on, and it is to
be said whether it stays."""

UNREACHED = 7
"""How a box ended that cannot be let down to its place, or may not be there."""

NEXT, WAITING, AGAIN = range(3)
"""Places in ``cursor``: the next box that has its turn, how many wait, and which of these is tried
next, -1 for none."""


class Boxes(NamedTuple):
    """The boxes of a plan.

    Attributes:
        sides: as planned and turned by a quarter [cm], shape (2, J, 3).
        offsets: of their centres of mass from their middles, likewise.
        weights: [kg], shape (J,).
        planned: their places in the plan, shape (J, 4).
        volumes: [cm3], shape (J,).
    """

    sides: FloatArray
    offsets: FloatArray
    weights: FloatArray
    planned: FloatArray
    volumes: FloatArray


class Turns(NamedTuple):
    """The turns that boxes had, and their outcomes, by their numbers.

    Attributes:
        tried: the place of a box in its turn, and its margin [cm], shape (J, 5).
        loaded: number of boxes that were loaded before, shape (J,).
        waited: number of boxes that waited before, shape (J,).
        waiting_then: these, shape (J, J).
        order: the boxes that are loaded, shape (J,).
        waiting: those that wait now, shape (J,).
        cursor: see :data:`NEXT`, shape (3,).
    """

    tried: FloatArray
    loaded: IntArray
    waited: IntArray
    waiting_then: IntArray
    order: IntArray
    waiting: IntArray
    cursor: IntArray

    @property
    def looked_at(self) -> int:
        """The box that was put on last, of which it is still to be said whether it stays."""
        again = self.cursor[AGAIN]
        return int(self.waiting[again] if again >= 0 else self.cursor[NEXT] - 1)

    @property
    def stuck(self) -> tuple[int, ...]:
        """The boxes that wait."""
        return tuple(self.waiting[: self.cursor[WAITING]].tolist())


def no_turns(count: int) -> Turns:
    """Before the first turn of so many boxes."""
    of_each = np.zeros((4, count), dtype=np.int64)
    waiting_then = np.zeros((count, count), dtype=np.int64)
    cursor = np.array([0, 0, -1], dtype=np.int64)
    return Turns(
        np.zeros((count, 5)), of_each[0], of_each[1], waiting_then, of_each[2], of_each[3], cursor
    )


@compiled
def begin(
    kept: Any, boxes: Any, turns: Any, places: Any, margins: Any, refused: Any, first: int
) -> None:
    """Go back to before the first box that is at another place, or has another margin, than when it
    had its turn.

    Args:
        kept: see the module, as all that follow.
        boxes: likewise.
        turns: likewise.
        places: of all boxes, shape (J, 4).
        margins: of all boxes [cm], shape (J,).
        refused: places at which a box does not stand: its number and the place, shape (R, 5).
        first: a box; go back to before its turn at the latest.
    """
    tried, loaded, waited, waiting_then, _, waiting, cursor = turns
    for box in range(min(cursor[NEXT], first)):
        same = tried[box, 4] == _margin(box, boxes[3], places, margins, refused)
        for column in range(4):
            same = same and tried[box, column] == places[box, column]
        if not same:
            first = box
            break
    if first >= cursor[NEXT]:
        return
    take_off(kept, loaded[first])
    for k in range(waited[first]):
        waiting[k] = waiting_then[first, k]
    cursor[NEXT], cursor[WAITING], cursor[AGAIN] = first, waited[first], -1


@compiled
def load(
    kept: Any, boxes: Any, turns: Any, places: Any, margins: Any, refused: Any, reorder: bool,
    looks: bool,
) -> int:  # fmt: skip
    """Let all boxes that had no turn yet have theirs.

    A box that does not stand waits until others are loaded, where the order may change. A box is
    let down from above: no box that is loaded before may be in the way, unless both are at their
    places in the plan, where that was so, too.

    Args:
        kept: see :func:`begin`.
        boxes: likewise.
        turns: likewise.
        places: likewise.
        margins: likewise.
        refused: likewise.
        reorder: the order may change.
        looks: end as soon as a box is put on; :func:`said` goes on.

    Returns:
        :data:`ALL`, :data:`LOOK`, or :data:`FULL`: there was no more room, and nothing is known.
    """
    tried, loaded, waited, waiting_then, _, waiting, cursor = turns
    grown = opened(kept)
    while True:
        if cursor[AGAIN] >= cursor[WAITING]:
            cursor[AGAIN] = -1
        if cursor[AGAIN] >= 0:
            box = waiting[cursor[AGAIN]]
        else:
            box = cursor[NEXT]
            if box == len(places):
                return ALL
            cursor[NEXT] = box + 1
            tried[box, :4] = places[box]
            tried[box, 4] = _margin(box, boxes[3], places, margins, refused)
            loaded[box], waited[box] = grown.counts[ITEMS], cursor[WAITING]
            for k in range(cursor[WAITING]):
                waiting_then[box, k] = waiting[k]
            if places[box, 3] == LEFT_OUT:
                continue
        ended = _put(kept, grown, boxes, turns, box)
        if ended == FULL:
            return FULL
        if ended == STANDS and looks:
            return LOOK
        said(turns, grown.counts[ITEMS] - 1, box, ended == STANDS, reorder)


@compiled
def said(turns: Any, place_: int, box: int, stands: bool, reorder: bool) -> None:
    """Note whether a box stands that was tried, so that :func:`load` goes on with the next one.

    Args:
        turns: see :func:`begin`.
        place_: in the order, where it stands.
        box: its number.
        stands: it does.
        reorder: see :func:`load`.
    """
    order, waiting, cursor = turns[4], turns[5], turns[6]
    again = cursor[AGAIN]
    if stands:
        order[place_] = box
        if again >= 0:
            for k in range(again, cursor[WAITING] - 1):
                waiting[k] = waiting[k + 1]
            cursor[WAITING] -= 1
        cursor[AGAIN] = 0 if reorder else -1
    elif again >= 0:
        cursor[AGAIN] = again + 1
    else:
        waiting[cursor[WAITING]] = box
        cursor[WAITING] += 1


@compiled
def _put(kept: Any, grown: Any, boxes: Any, turns: Any, box: int) -> int:
    """Put a box on if it stands at its place; how it ended."""
    at = turns[0][box]
    if at[4] == np.inf:
        return UNREACHED
    _write(grown, boxes, box, int(at[3]), at)
    if not _reachable(grown, boxes[3], turns, box):
        return UNREACHED
    return int(place(kept, BALANCED, at[4])[0])


@compiled
def _write(grown: Any, boxes: Any, box: int, turn: int, corner: Any) -> None:
    """Let a box be the next one of a growing layout."""
    sides, offsets, weights = boxes[0], boxes[1], boxes[2]
    for axis in range(3):
        grown.box[axis] = corner[axis]
        grown.box[3 + axis] = sides[turn, box, axis]
        grown.box[6 + axis] = offsets[turn, box, axis]
    grown.box[9] = weights[box]


@compiled
def _reachable(grown: Any, planned: Any, turns: Any, box: int) -> bool:
    """Whether the next box of a growing layout can be let down to its place."""
    tried, order = turns[0], turns[4]
    x0, z0 = grown.box[0], grown.box[2]
    x1, top, z1 = x0 + grown.box[3], grown.box[1] + grown.box[4], z0 + grown.box[5]
    for k in range(grown.counts[ITEMS]):
        if grown.lower[k, 1] < top - TOLERANCE:
            continue
        across = min(grown.upper[k, 0], x1) - max(grown.lower[k, 0], x0)
        if min(across, min(grown.upper[k, 2], z1) - max(grown.lower[k, 2], z0)) <= TOLERANCE:
            continue
        other = order[k]
        if other > box or not is_same(tried[box], planned[box]):
            return False
        if not is_same(tried[other], planned[other]):
            return False
    return True


@compiled
def is_same(one: Any, other: Any) -> bool:
    """Whether two places are the same."""
    if one[0] != other[0] or one[1] != other[1]:
        return False
    return bool(one[2] == other[2] and one[3] == other[3])


@compiled
def _margin(box: int, planned: Any, places: Any, margins: Any, refused: Any) -> float:
    """The margin of a box at its place; infinite where it may not be there."""
    for k in range(len(refused)):
        if refused[k, 0] == box and is_same(refused[k, 1:], places[box]):
            return np.inf
    if is_same(places[box], planned[box]):
        return float(margins[box])
    return max(float(margins[box]), OF_MOVED)


@compiled
def places_among(
    boxes: Any, places: Any, without: Any, box: int, margin: float, limits: Any, ways: Any,
    turns: int, most: int,
) -> Any:  # fmt: skip
    """Free places of a box among others; see :func:`.free_places.nearest_places`.

    Args:
        boxes: see :func:`begin`.
        places: likewise.
        without: boxes that it may overlap, shape (J,).
        box: its number.
        margin: [cm].
        limits: see :func:`.free_places.free_places`.
        ways: likewise.
        turns: see :func:`.free_places.nearest_places`.
        most: likewise.
    """
    sides, offsets, planned = boxes[0], boxes[1], boxes[3]
    lower, upper = np.empty((len(places), 3)), np.empty((len(places), 3))
    centres, count = np.empty((len(places), 3)), 0
    for other in range(len(places)):
        if other == box or without[other] or places[other, 3] == LEFT_OUT:
            continue
        turn = int(places[other, 3])
        for axis in range(3):
            lower[count, axis] = places[other, axis]
            upper[count, axis] = places[other, axis] + sides[turn, other, axis]
            middle = 0.5 * (lower[count, axis] + upper[count, axis])
            centres[count, axis] = middle + offsets[turn, other, axis]
        count += 1
    return nearest_places(
        lower[:count], upper[:count], centres[:count], np.ascontiguousarray(sides[:, box]),
        np.ascontiguousarray(offsets[:, box]),
        planned[box, :3], margin, limits, ways, turns, most,
    )  # fmt: skip


@compiled
def first_standing(
    kept: Any, boxes: Any, box: int, places: Any, margin: float, refused: Any, found: Any
) -> int:
    """The first places at which a box stands on what is loaded, and may be: not as planned.

    Args:
        kept: see :func:`begin`.
        boxes: likewise.
        box: its number; it is not loaded.
        places: to be looked at, shape (K, 4).
        margin: [cm].
        refused: see :func:`begin`.
        found: the numbers of the first ones are put there, shape (N,).

    Returns:
        How many there are, at most N; -1 where there was no more room.
    """
    grown, planned = opened(kept), boxes[3]
    count = 0
    for k in range(len(places)):
        if count == len(found):
            break
        is_refused = is_same(places[k], planned[box])
        for r in range(len(refused)):
            is_refused |= refused[r, 0] == box and is_same(refused[r, 1:], places[k])
        if is_refused:
            continue
        _write(grown, boxes, box, int(places[k, 3]), places[k])
        ended = ending(grown, BALANCED, margin)
        if ended == FULL:
            return -1
        if ended == STANDS:
            found[count] = k
            count += 1
    return count


@compiled
def cost(boxes: Any, places: Any) -> Any:
    """Boxes that are left out, their volume [cm3], boxes that are elsewhere than in the plan, and
    how far their middles are from where they were, all together [cm].
    """
    sides, planned, volumes = boxes[0], boxes[3], boxes[4]
    left, volume, moved, distance = 0, 0.0, 0, 0.0
    for box in range(len(places)):
        if places[box, 3] == LEFT_OUT:
            left += 1
            volume += volumes[box]
        elif not is_same(places[box], planned[box]):
            moved += 1
            turn, squares = int(places[box, 3]), 0.0
            for axis in range(3):
                to = places[box, axis] + 0.5 * sides[turn, box, axis]
                squares += (to - (planned[box, axis] + 0.5 * sides[0, box, axis])) ** 2
            distance += np.sqrt(squares)
    return left, volume, moved, distance

"""Loadings in C of which boxes that lose their balance are followed, or whose balance alone is
looked at: see timed.h.
"""

from __future__ import annotations

import ctypes as ct
import math
from typing import Any, NamedTuple

import numpy as np

from steadyload.core.library import (
    HELD,
    LIBRARY,
    Kept,
    RefusedError,
    array,
    count_of,
    ended_well,
    finding,
    own,
    work,
)
from steadyload.core.whole import Given, GivenMany


class How(ct.Structure):
    """How boxes are followed: friction, gravity [cm/s2], how long [s], and the displacement [cm]
    and the angle [degrees] that count as moved, all 0 or more: ``sl_how``.
    """

    _fields_ = [
        (name, ct.c_double) for name in ("friction", "gravity", "seconds", "eps_t", "eps_r")
    ]


class Moved(NamedTuple):
    """How a step ended, and the box that comes farthest: see ``sl_moved`` [cm, degrees]."""

    ended: int
    step: int
    item: int
    shift: float
    turn: float
    beyond: float


class _MovedInC(ct.Structure):
    _fields_ = [
        *((name, ct.c_int32) for name in ("ended", "step", "item", "unused")),
        *((name, ct.c_double) for name in ("shift", "turn", "beyond")),
    ]

    def read(self, what: str) -> Moved:
        """The answer that C has put here, unless it ended without one."""
        ended = ended_well(self.ended, what)
        return Moved(ended, self.step, self.item, self.shift, self.turn, self.beyond)


MOVED = np.dtype(_MovedInC)
"""``sl_moved``."""


def first_moved(given: Given, limit: float, how: How) -> Moved:
    """The first step of a layout at which a box comes too far: ``sl_first_moved``.

    Args:
        given: the layout.
        limit: the most work on its motions, infinite for none.
        how: boxes are followed.
    """
    found = _MovedInC()
    LIBRARY.sl_first_moved(work(), *given.addresses, limit, ct.addressof(how), ct.addressof(found))
    return found.read("a layout")


def first_moved_many(given: GivenMany, limit: float, how: How) -> Any:
    """The same of many layouts, with a limit of work each, of type :data:`MOVED`, (L,):
    ``sl_first_moved_many``.
    """
    found = np.empty(given.count, MOVED)
    ended = LIBRARY.sl_first_moved_many(
        work(), *given.addresses, limit, ct.addressof(how), found.ctypes.data
    )
    ended_well(ended, "a batch of layouts")
    return found


class Group(NamedTuple):
    """The boxes joined to a new one, in order, (n,): see ``sl_timed_group``.

    Attributes:
        ended: FAILS where something of the group is out of balance.
        kept: whether its last motion is that with the new box, too.
        items: the group where something of it is out of balance, else none.
    """

    ended: int
    kept: bool
    items: Any


class Followed:
    """A loading whose boxes are followed once they lose their balance: ``sl_timed_new``.

    Motions take long: other threads run while they are followed. The loading is for one thread at a
    time.

    Args:
        given: the layout, J boxes with P contact patches; it is copied.
        margin: by which contact patches are drawn in on every side [cm], 0 or more.
        limit: the most work on its motions, infinite for none.

    Attributes:
        starts, ends, below, above_starts, above_ends, above: its contacts, see ``sl_timed_view``,
            as for the others; int32.
        pressing: bool, (P, 4); may be written to.
        pushes: uint16, (J + 1, J + 1); may be written to.
        moves: bool, (J,); may be written to, as all that follow but counts.
        answers: int32, (J,).
        solved: bool, (J,).
        farthest: [cm], (J, 3, 2).
        beyond: (J,).
        counts: steps whose motion was kept, and was asked for, int64, (2,).
    """

    def __init__(self, given: Given, margin: float = 0.0, limit: float = math.inf) -> None:
        self._kept = Kept(HELD.sl_timed_new(*given.addresses, margin), HELD.sl_timed_free)
        self._timed, view = self._kept.address, _ViewInC()
        HELD.sl_timed_look(self._timed, ct.addressof(view))
        boxes, patches = view.count, view.patches
        self._group: Any = np.empty(boxes, np.int32)
        self.starts = self._seen(view.starts, np.int32, boxes)
        self.ends = self._seen(view.ends, np.int32, boxes)
        self.below = self._seen(view.below, np.int32, patches)
        self.above_starts = self._seen(view.above_starts, np.int32, boxes)
        self.above_ends = self._seen(view.above_ends, np.int32, boxes)
        self.above = self._seen(view.above, np.int32, int((self.below >= 0).sum()))
        self.pressing = self._seen(view.pressing, np.bool_, patches, 4)
        self.pushes = self._seen(view.pushes, np.uint16, boxes + 1, boxes + 1)
        self.moves = self._seen(view.moves, np.bool_, boxes)
        self.answers = self._seen(view.answers, np.int32, boxes)
        self.solved = self._seen(view.solved, np.bool_, boxes)
        self.farthest = self._seen(view.farthest, np.float64, boxes, 3, 2)
        self.beyond = self._seen(view.beyond, np.float64, boxes)
        self.counts = self._seen(view.counts, np.int64, 2)
        self._seen(view.work, np.float64, 2)[1] = limit

    def _seen(self, address: int, kind: Any, *shape: int) -> Any:
        return np.asarray(_Seen(self._kept, address, np.dtype(kind), shape))

    def first(self, first: int, end: int, how: How) -> Moved:
        """Place boxes up to, without, one of them until one comes too far: ``sl_timed_first``."""
        found = _MovedInC()
        LIBRARY.sl_timed_first(self._timed, first, end, ct.addressof(how), ct.addressof(found))
        return found.read("boxes")

    def group(self, step: int) -> Group:
        """Place a box, and look whether its group is out of balance: ``sl_timed_group``."""
        kept, size = ct.c_int32(), ct.c_int32()
        ended = HELD.sl_timed_group(
            self._timed, step, ct.addressof(kept), ct.addressof(size), self._group.ctypes.data
        )
        return Group(ended_well(ended, "a box"), kept.value == 1, self._group[: size.value].copy())

    def moved(self, step: int, group: Any, how: How) -> Moved:
        """The motion of a group that :meth:`group` found, int32, (n,): ``sl_timed_moved``."""
        found, size = _MovedInC(), count_of("group", group)
        LIBRARY.sl_timed_moved(
            self._timed, step, size, array("group", group, size, kind=np.int32),
            ct.addressof(how), ct.addressof(found),
        )  # fmt: skip
        return found.read("a group")

    def is_near_its_edge(self, item: int, margin: float) -> bool:
        """Whether a box on the floor has its centre of mass outside its base, drawn in by a margin
        [cm]: ``sl_timed_is_near_its_edge``.
        """
        return bool(HELD.sl_timed_is_near_its_edge(self._timed, item, margin))


class _ViewInC(ct.Structure):
    _fields_ = [
        *((name, ct.c_int32) for name in ("count", "patches")),
        *((name, ct.c_void_p) for name in (
            "starts", "ends", "below", "above_starts", "above_ends", "above", "pressing", "pushes",
            "moves", "answers", "solved", "farthest", "beyond", "counts", "work",
        )),
    ]  # fmt: skip


class _Seen:
    """An array in C as NumPy has it; it is not freed as long as it can be seen."""

    def __init__(self, kept: Kept, address: int, kind: Any, shape: tuple[int, ...]) -> None:
        self._kept = kept
        self.__array_interface__ = {
            "data": (address, False), "typestr": kind.str, "shape": shape, "version": 3,
        }  # fmt: skip


class Held:
    """Balance of a layout step by step, whatever came of the steps before, with forces that are
    solved for of whole groups: ``sl_held_new``.

    Args:
        given: the layout; it is copied.
        margin: by which contact patches are drawn in on every side [cm], 0 or more.
    """

    def __init__(self, given: Given, margin: float = 0.0) -> None:
        self._kept = Kept(HELD.sl_held_new(*given.addresses, margin), HELD.sl_held_free)
        self._held = self._kept.address
        self._group: Any = np.empty(given.addresses[0], np.int32)

    def place(self, step: int) -> tuple[int, int]:
        """Place a box; how that ended, and what is out of balance then: ``sl_held_place``."""
        item = ct.c_int32()
        ended = HELD.sl_held_place(self._held, step, ct.addressof(item))
        return ended_well(ended, "a box"), item.value

    def group(self, step: int) -> Any:
        """The boxes joined to one by standing on each other, int32, (n,): ``sl_held_group``."""
        size = HELD.sl_held_group(self._held, step, self._group.ctypes.data)
        if size < 0:
            raise RefusedError("there is no such box, or no memory for its group")
        return self._group[:size].copy()


class Closest(NamedTuple):
    """Forces that come closest to balance: see ``sl_closest_to_balance``.

    Attributes:
        forces: at the corners of every patch [kg], (k, 4).
        ended: how.
        item: the one that starts fastest, -1 where none does.
        is_found: whether the search ended.
    """

    forces: Any
    ended: int
    item: int
    is_found: bool


def closest_to_balance(given: Given, items: Any, used: Any, corners: Any, grow: float) -> Closest:
    """Forces that come closest to balancing some boxes: ``sl_closest_to_balance``.

    Args:
        given: the layout with them.
        items: the boxes, int32, (n,).
        used: of every patch its place in ``corners``, the box above it and the one below, -1 for
            the floor, int32, (k, 3).
        corners: x0, z0, x1, z1 [cm], (p, 4).
        grow: how much wider every patch counts on each side [cm].
    """
    mine, size, patches = own(), count_of("items", items), count_of("used", used)
    places, forces = count_of("corners", corners), np.empty((patches, 4))
    *boxes, _ = given.addresses
    ended = LIBRARY.sl_closest_to_balance(
        mine.address, *boxes, size, array("items", items, size, kind=np.int32), patches,
        array("used", used, patches, 3, kind=np.int32), places,
        array("corners", corners, places, 4), grow, forces.ctypes.data, mine.found_at,
    )  # fmt: skip
    ended_well(ended, "items and patches")
    found = finding(mine.found)
    return Closest(forces, found.ended, found.item, found.number == 1.0)


def thin_side(gravity: float, seconds: float) -> float:
    """The side [cm] below which the acceleration of a box that tips may be rounding:
    ``sl_thin_side``.

    Args:
        gravity: [cm/s2].
        seconds: for which it tips.
    """
    return float(LIBRARY.sl_thin_side(gravity, seconds))

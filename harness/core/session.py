"""Layouts in C that grow box by box: see steadyload.h."""

from __future__ import annotations

from collections.abc import Sequence
from struct import Struct
from typing import Any, NamedTuple

import numpy as np

from steadyload.core.library import (
    FINDING,
    HELD,
    LIBRARY,
    Finding,
    Kept,
    Scratch,
    WrongArrayError,
    array,
    count_of,
    ended_well,
    finding,
)

_BOX = Struct("10d")


class Boxes(NamedTuple):
    """Boxes of a session: corners [cm] and offsets [cm], (J, 3), and weights [kg], (J,)."""

    lower: Any
    upper: Any
    offsets: Any
    weights: Any


class Patches(NamedTuple):
    """The patches that a box stands on, in the order in which that came about.

    Attributes:
        below: boxes, -1 for the floor, (k,).
        patches: x0, z0, x1, z1 [cm], (k, 4).
        presses: force [kg], and force times its x and times its z [kg cm], (k, 3).
    """

    below: Any
    patches: Any
    presses: Any


class Session:
    """A layout that grows box by box, and shrinks again.

    A box is ten numbers: position, size, offset of the centre of mass from the middle [cm], and
    weight [kg].

    Args:
        limits: contour (lower, upper), deck (x0, z0, x1, z1) and its height, 0 for a plane [cm].
    """

    def __init__(self, limits: Sequence[float]) -> None:
        numbers = np.array(limits, dtype=np.float64)
        self._keep(HELD.sl_session_new(array("limits", numbers, 11)))

    def copy(self) -> Session:
        """Another one with the same boxes, that grows by itself."""
        other = Session.__new__(Session)
        other._keep(HELD.sl_session_copy(self._session))
        return other

    def place(self, box: Sequence[float], rule: int, alpha: float) -> Finding:
        """Put on a box if it stands by a rule: ``sl_place``."""
        self._write(box)
        ended = HELD.sl_place(self._session, self._box_at, rule, alpha, self._found_at)
        ended_well(ended, "a box")
        return finding(self._found)

    def put(self, box: Sequence[float]) -> int:
        """Put on a box, whether it stands or not; how that ended: ``sl_put``."""
        self._write(box)
        return ended_well(HELD.sl_put(self._session, self._box_at), "a box")

    def endings(self, box: Sequence[float], positions: Any, rule: int, alpha: float) -> Any:
        """How putting a box at each of some positions (K, 3) would end, (K,): ``sl_stand``."""
        count = count_of("positions", positions)
        at, found = array("positions", positions, count, 3), np.empty(count, np.int8)
        self._write(box)
        ended = LIBRARY.sl_stand(
            self._session, self._box_at, rule, alpha, count, at, found.ctypes.data
        )
        ended_well(ended, "positions of a box")
        return found

    def cut(self, count: int) -> None:
        """Take off all boxes but the first ``count``."""
        HELD.sl_cut(self._session, count)

    def __len__(self) -> int:
        return int(HELD.sl_session_count(self._session))

    @property
    def overhung(self) -> int:
        """How many boxes stand out over an edge of the deck."""
        return int(HELD.sl_session_overhung(self._session))

    def boxes(self, first: int = 0) -> Boxes:
        """Copies of the boxes from one of them on."""
        count = max(len(self) - first, 0)
        corners = np.empty((3, count, 3))
        found = Boxes(corners[0], corners[1], corners[2], np.empty(count))
        addresses = [values.ctypes.data for values in found]
        ended_well(HELD.sl_session_boxes(self._session, first, count, *addresses), "first")
        return found

    def is_on_floor(self, box: int) -> bool:
        """Whether a box stands on the floor with all of its base."""
        return self._has(HELD.sl_session_on_floor(self._session, box)) == 1

    def below(self, box: int) -> Patches:
        """The patches that a box stands on."""
        count = self._fill(self._patches, HELD.sl_session_below, box)
        return Patches(*self._patches.first(count))

    def above(self, box: int) -> Any:
        """The boxes on a box."""
        count = self._fill(self._above, HELD.sl_session_above, box)
        return next(self._above.first(count))

    def near(self, lower: Any, upper: Any, wider: float) -> Any:
        """The boxes that share a point with a region, in order: ``sl_session_near``."""
        found = np.empty(len(self), np.int32)
        low, high = array("lower", lower, 3), array("upper", upper, 3)
        at = found.ctypes.data
        return found[: HELD.sl_session_near(self._session, low, high, wider, len(found), at)]

    def _keep(self, made: int | None) -> None:
        self._kept = Kept(made, HELD.sl_session_free)
        self._session = self._kept.address
        self._patches = Scratch((np.int32, ()), (np.float64, (4,)), (np.float64, (3,)))
        self._above = Scratch((np.int32, ()))
        self._next: Any = np.zeros(10)
        self._found: Any = np.zeros(1, FINDING)
        self._box_at, self._found_at = self._next.ctypes.data, self._found.ctypes.data

    def _write(self, box: Sequence[float]) -> None:
        if len(box) != 10:
            raise WrongArrayError(f"a box has 10 numbers, not {len(box)}")
        _BOX.pack_into(self._next, 0, *box)

    def _fill(self, scratch: Scratch, function: Any, box: int) -> int:
        """How many rows a function has put in some arrays, which are made as large as it takes."""
        while True:
            count = self._has(function(self._session, box, scratch.size, *scratch.addresses))
            if count <= scratch.size:
                return count
            scratch.widen(2 * count)

    @staticmethod
    def _has(found: int) -> int:
        if found < 0:
            raise IndexError("the session has no such box")
        return found

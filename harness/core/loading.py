"""Boxes in C that are loaded at given places, and free places of them: see searching.h."""

from __future__ import annotations

import ctypes as ct
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from steadyload.core.constants import STANDS
from steadyload.core.library import (
    HELD,
    LIBRARY,
    Kept,
    RefusedError,
    Scratch,
    array,
    count_of,
    counted,
    ended_well,
    work,
)


class _BoxesInC(ct.Structure):
    _fields_ = [("count", ct.c_int32)] + [
        (name, ct.c_void_p) for name in ("sides", "offsets", "weights", "planned", "volumes")
    ]


class _WishesInC(ct.Structure):
    _fields_ = [
        ("places", ct.c_void_p), ("margins", ct.c_void_p),
        ("refused_count", ct.c_int32), ("refused", ct.c_void_p),
    ]  # fmt: skip


class _WantedInC(ct.Structure):
    _fields_ = [
        ("limits", ct.c_void_p), ("ways", ct.c_void_p), ("margin", ct.c_double),
        ("most", ct.c_int32),
    ]  # fmt: skip


class Boxes:
    """The boxes of a plan: ``sl_boxes``. The arrays are kept, and must not change.

    Args:
        sides: as planned and turned by a quarter [cm], (2, J, 3).
        offsets: of centres of mass from middles, likewise.
        weights: [kg], (J,).
        planned: places in the plan, (J, 4).
        volumes: [cm3], (J,).
    """

    def __init__(self, sides: Any, offsets: Any, weights: Any, planned: Any, volumes: Any) -> None:
        self.count = count = count_of("weights", weights)
        self._arrays, self.planned = (sides, offsets, weights, volumes), planned
        self._in_c = _BoxesInC(
            count, array("sides", sides, 2, count, 3), array("offsets", offsets, 2, count, 3),
            array("weights", weights, count), array("planned", planned, count, 4),
            array("volumes", volumes, count),
        )  # fmt: skip
        self.address = ct.addressof(self._in_c)

    def cost(self, places: Any) -> tuple[int, float, int, float]:
        """Boxes that are left out, their volume, boxes that are elsewhere than in the plan, and how
        far these are moved, all together: ``sl_cost``.
        """
        found = np.empty(4)
        at = array("places", places, self.count, 4)
        LIBRARY.sl_cost(self.address, at, found.ctypes.data)
        left, volume, moved, distance = found.tolist()
        return int(left), volume, int(moved), distance

    def places_among(
        self, places: Any, without: Any, box: int, margin: float, limits: Any, ways: Any,
        turns: int, most: int,
    ) -> tuple[Any, Any]:  # fmt: skip
        """Free places of a box among the others, (K, 4), and how far these are, (K,), the nearest
        first: ``sl_places_among``.

        Args:
            places: of all boxes, (J, 4).
            without: boxes that it may overlap, of type bool, (J,).
            box: its number.
            margin: see ``sl_wanted``.
            limits: likewise, (10,).
            ways: likewise, (3,).
            turns: 2 where it may be turned, else 1.
            most: see ``sl_wanted``.
        """
        if turns not in (1, 2) or most < 0:
            raise RefusedError("a box has 1 or 2 sides, and no fewer places than none")
        found, far = np.empty((turns * most, 4)), np.empty(turns * most)
        wanted = _WantedInC(array("limits", limits, 10), array("ways", ways, 3), margin, most)
        count = LIBRARY.sl_places_among(
            work(), self.address, array("places", places, self.count, 4),
            array("without", without, self.count, kind=bool), box, ct.addressof(wanted), turns,
            found.ctypes.data, far.ctypes.data,
        )  # fmt: skip
        counted(count, "places of a box")
        return found[:count].copy(), far[:count].copy()


class Wishes:
    """Where boxes are to be, with which margins: ``sl_wishes``. The arrays are kept, and must not
    change.

    Args:
        boxes: of the plan.
        places: of all boxes, (J, 4).
        margins: of all boxes at their places in the plan, and at others [cm], (2, J).
        refused: places at which a box does not stand: its number and the place, (R, 5).
    """

    def __init__(self, boxes: Boxes, places: Any, margins: Any, refused: Any) -> None:
        self._arrays, refusals = (places, margins, refused), count_of("refused", refused)
        self._in_c = _WishesInC(
            array("places", places, boxes.count, 4), array("margins", margins, 2, boxes.count),
            refusals, array("refused", refused, refusals, 5),
        )  # fmt: skip
        self.address = ct.addressof(self._in_c)


class Loaded(NamedTuple):
    """The boxes that are loaded, in order, and those that wait."""

    order: tuple[int, ...]
    stuck: tuple[int, ...]


class Loading:
    """Boxes loaded at given places, each as soon as it stands, in nearly the order of a plan.

    Args:
        limits: see :class:`steadyload.core.session.Session`.
        boxes: of the plan.
    """

    def __init__(self, limits: Sequence[float], boxes: Boxes) -> None:
        numbers = np.array(limits, dtype=np.float64)
        made = HELD.sl_loading_new(array("limits", numbers, 11), boxes.count)
        self._kept, self._boxes = Kept(made, HELD.sl_loading_free), boxes
        self._loading, count = self._kept.address, boxes.count
        self._found = Scratch((np.int32, ()), (np.int32, ()))
        self._found.widen(count)
        self._counts = np.empty(2, np.int32)
        self._counts_at = int(self._counts.ctypes.data)

    def begin(self, wishes: Wishes, first: int) -> None:
        """Go back to before the first change, and to before the turn of box ``first`` at the
        latest: ``sl_load_begin``.
        """
        ended = HELD.sl_load_begin(self._loading, self._boxes.address, wishes.address, first)
        ended_well(ended, "boxes to load")

    def load(self, wishes: Wishes, *, reorder: bool, looks: bool) -> bool:
        """Let all boxes that had no turn yet have theirs; False where it is first to be said
        whether one stays: ``sl_load``.
        """
        ended = LIBRARY.sl_load(self._loading, self._boxes.address, wishes.address, reorder, looks)
        return ended_well(ended, "boxes to load") == STANDS

    @property
    def looked_at(self) -> int:
        """The box of which it is to be said whether it stays, -1 for none."""
        return int(HELD.sl_looked_at(self._loading))

    def say(self, stays: bool, *, reorder: bool) -> None:
        """Whether that box stays: ``sl_said``."""
        ended_well(HELD.sl_said(self._loading, stays, reorder), "an answer that nothing asked for")

    def loaded(self) -> Loaded:
        """The boxes that are loaded, and those that wait: ``sl_loaded``."""
        HELD.sl_loaded(self._loading, *self._found.addresses, self._counts_at)
        (order, stuck), (loaded, waiting) = self._found.arrays, self._counts.tolist()
        return Loaded(tuple(order[:loaded].tolist()), tuple(stuck[:waiting].tolist()))

    def tried(self) -> Any:
        """Where boxes were tried, and their margins, (J, 5): ``sl_tried``."""
        found = np.empty((self._boxes.count, 5))
        HELD.sl_tried(self._loading, found.ctypes.data)
        return found

    def first_standing(
        self, wishes: Wishes, box: int, places: Any, margin: float, most: int
    ) -> Any:
        """The numbers of the first of some places (K, 4) at which a box would stand, those refused
        apart: ``sl_first_standing``.

        Args:
            wishes: of these only what is refused counts.
            box: it is not loaded.
            places: to be looked at.
            margin: [cm].
            most: places that are looked for.
        """
        count, found = count_of("places", places), np.empty(most, np.int32)
        made = LIBRARY.sl_first_standing(
            self._loading, self._boxes.address, wishes.address, box, margin, count,
            array("places", places, count, 4), most, found.ctypes.data,
        )  # fmt: skip
        return found[: counted(made, "places of a box")]

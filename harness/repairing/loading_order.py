"""The order in which boxes at given places can be loaded."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from steadyload.layouts.model.layout import FloatArray, Item
from steadyload.repairing.mask import Mask
from steadyload.repairing.plan import Boxes, Place
from steadyload.statics import kernels


class Loaded(NamedTuple):
    """Result of loading: the boxes that stand, in order, and those that cannot be loaded."""

    order: tuple[int, ...]
    stuck: tuple[int, ...]


class _Turn(NamedTuple):
    """The state before a box is tried for the first time, and what it was tried with."""

    tried: tuple[Place | None, float]
    loaded: int
    waiting: tuple[int, ...]


class LoadingOrder:
    """Loads boxes at given places, each as soon as it stands, in nearly the order of the plan.

    A box that does not stand waits for others, where the order may change. A box is let down from
    above: no box that is loaded before may be in the way, unless both are where they were in the
    plan, where that was so, too.

    Args:
        boxes: of the plan.
        reorder: the order may change.
    """

    def __init__(self, boxes: Boxes, *, reorder: bool) -> None:
        self._boxes, self._reorder = boxes, reorder
        self._mask = Mask(boxes.layout.pallet, limited=boxes.limited)
        self._turns: list[_Turn] = []
        self._places: Sequence[Place | None] = ()
        self._margins: FloatArray = np.zeros(0)

    def load(self, places: Sequence[Place | None], margins: FloatArray) -> Loaded:
        """Load the boxes.

        Args:
            places: by box; None for one that is left out.
            margins: by box, see :class:`Mask` [cm].
        """
        first = self._first_change(places, margins)
        self._places, self._margins = places, margins
        waiting = self._back_to(first)
        for box in range(first, len(places)):
            turn = _Turn((places[box], float(margins[box])), len(self._mask.boxes), tuple(waiting))
            self._turns.append(turn)
            if places[box] is None:
                continue
            if not self._place(box):
                waiting.append(box)
            elif self._reorder:
                waiting = self._retried(waiting)
        return Loaded(tuple(self._mask.boxes), tuple(waiting))

    def stands(
        self, box: int, item: Item, positions: FloatArray, margin: float
    ) -> NDArray[np.bool_]:
        """Whether a box that is not loaded would stand on each of many places.

        With all boxes that are loaded, or, where the order is fixed, with those before it.

        Args:
            box: its number.
            item: the box, turned as it would be.
            positions: lower corners [cm], shape (K, 3).
            margin: see :class:`Mask` [cm].
        """
        if not self._reorder:
            self._back_to(box)
        return self._mask.stands(item, positions, margin)

    def _first_change(self, places: Sequence[Place | None], margins: FloatArray) -> int:
        for box, turn in enumerate(self._turns):
            if turn.tried != (places[box], margins[box]):
                return box
        return len(self._turns)

    def _back_to(self, box: int) -> list[int]:
        """Go back to before a box was tried; returns those that waited then."""
        if box == len(self._turns):
            # Nothing changed for those tried; what waits now is what waited in the end.
            loaded = set(self._mask.boxes)
            return [b for b in range(box) if self._places[b] is not None and b not in loaded]
        turn = self._turns[box]
        self._mask.cut(turn.loaded)
        del self._turns[box:]
        return list(turn.waiting)

    def _retried(self, waiting: list[int]) -> list[int]:
        """Load what can be loaded now, the earliest first; returns what still waits."""
        again = True
        while again and waiting:
            again = False
            for box in waiting:
                if self._place(box):
                    waiting = [other for other in waiting if other != box]
                    again = True
                    break
        return waiting

    def _place(self, box: int) -> bool:
        place = self._places[box]
        assert place is not None, "the box is kept"
        item = self._boxes.item(box, place)
        margin = float(self._margins[box])
        return self._reachable(box, item) and self._mask.place(box, item, margin)

    def _reachable(self, box: int, item: Item) -> bool:
        """Whether the box can be let down to its place."""
        lower = np.array(item.position)
        in_the_way = kernels.free_places.boxes_over(*self._mask.corners, lower, lower + item.size)
        if not len(in_the_way):
            return True
        if not self._is_planned(box):
            return False
        before = [self._mask.boxes[place] for place in in_the_way]
        return all(other < box and self._is_planned(other) for other in before)

    def _is_planned(self, box: int) -> bool:
        return self._places[box] == self._boxes.planned[box]

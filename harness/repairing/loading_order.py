"""The order in which boxes at given places can be loaded."""

from __future__ import annotations

import numpy as np

from steadyload.core.loading import Loaded, Loading, Wishes
from steadyload.layouts.model.growing import GrowingLayout, limits_of, numbered
from steadyload.layouts.model.layout import FloatArray
from steadyload.repairing.plan import Boxes
from steadyload.statics.bearing.crushing import crushed_by_now

OF_MOVED = 0.5
"""Margin of balance [cm] of a box that is not at its place in the plan, at least."""


class LoadingOrder:
    """Loads boxes at given places, each as soon as it stands, in nearly the order of the plan.

    Every step stands by exact vertical equilibrium, no box is crushed, and each is let down from
    above; see :meth:`.Loading.load`. What was loaded last stays: boxes before the first change are
    not loaded again.

    Args:
        boxes: of the plan.
        reorder: the order may change.
        margins: of boxes at first [cm], shape (J,), or of all alike.

    Attributes:
        margins: by which the contact patches of boxes are drawn in on every side [cm], at their
            places in the plan and at others, shape (2, J); :meth:`set_margin` sets them.
    """

    def __init__(self, boxes: Boxes, *, reorder: bool, margins: float | FloatArray) -> None:
        self._boxes, self._reorder = boxes, reorder
        self.margins: FloatArray = np.empty((2, len(boxes)))
        self.set_margin(slice(None), margins)
        self._refused: FloatArray = np.empty((0, 5))
        self._places = boxes.planned
        self._loading = Loading(limits_of(boxes.layout.pallet), boxes.given)
        self._looked_at = _LookedAt(boxes) if boxes.limited else None

    def set_margin(self, boxes: int | slice, margin: float | FloatArray) -> None:
        """Give boxes a margin [cm]: where they are moved, :data:`OF_MOVED` at least."""
        self.margins[0, boxes], self.margins[1, boxes] = margin, np.maximum(margin, OF_MOVED)

    def refuse(self, box: int, place: FloatArray) -> None:
        """Take a place of a box for one at which it does not stand."""
        self._refused = np.vstack([self._refused, [float(box), *place]])

    def load(self, places: FloatArray) -> Loaded:
        """Load the boxes.

        Args:
            places: by box, shape (J, 4), see :class:`Boxes`; they must not change afterwards.
        """
        self._places = places
        looks = self._looked_at is not None
        wishes = self._wishes()
        self._loading.begin(wishes, len(places))
        while not self._loading.load(wishes, reorder=self._reorder, looks=looks):
            self._look()
        return self._loading.loaded()

    def first_standing(
        self, box: int, places: FloatArray, margin: float, most: int
    ) -> list[FloatArray]:
        """The first places at which a box would stand, whatever boxes may bear.

        With all boxes that are loaded, or, where the order is fixed, with those before it.

        Args:
            box: its number; it is not loaded.
            places: to be looked at, shape (K, 4); that in the plan and refused ones do not count.
            margin: as of :attr:`margins` [cm].
            most: places that are looked for.
        """
        wishes = self._wishes()
        if not self._reorder:
            self._loading.begin(wishes, box)
        return list(places[self._loading.first_standing(wishes, box, places, margin, most)])

    def _wishes(self) -> Wishes:
        return Wishes(self._boxes.given, self._places, self.margins, self._refused)

    def _look(self) -> None:
        """Take off the box that was put on last if one is crushed by it."""
        assert self._looked_at is not None, "some box states what it may bear"
        now = [*self._loading.loaded().order, self._loading.looked_at]
        is_crushed = self._looked_at.is_crushed(now, self._loading.tried()[now, :4].tolist())
        self._loading.say(not is_crushed, reorder=self._reorder)


class _LookedAt:
    """A load that is looked at after each box: does one bear more than it may?"""

    def __init__(self, boxes: Boxes) -> None:
        self._boxes = boxes
        self._layout = GrowingLayout(boxes.layout.pallet, "repair")
        self._loaded: list[tuple[int, list[float]]] = []

    def is_crushed(self, order: list[int], places: list[list[float]]) -> bool:
        """Whether a box is crushed by the last one.

        Args:
            order: the boxes that are loaded.
            places: of these.
        """
        now, same = list(zip(order, places, strict=True)), 0
        while same < min(len(now), len(self._loaded)) and now[same] == self._loaded[same]:
            same += 1
        self._layout.cut(same)
        for turn, (box, place) in enumerate(now[same:], same):
            self._layout.put(numbered(self._boxes.item(box, place), turn))
        self._loaded = now
        return crushed_by_now(self._layout, self._layout.items) is not None

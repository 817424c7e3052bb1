"""A load that is built up box by box, each of which has to be balanced with a margin of its own."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from steadyload.layouts.model.growing import GrowingLayout, numbered
from steadyload.layouts.model.layout import FloatArray, Item, LayoutError, Pallet
from steadyload.statics.bearing.crushing import crushed_by_now
from steadyload.statics.kernels.constants import STANDS
from steadyload.statics.kernels.placing import BALANCED


class Mask:
    """A load of which every step stands by exact vertical equilibrium, and no box is crushed.

    Args:
        pallet: what is loaded.
        limited: some box states what it may bear.

    Attributes:
        boxes: numbers of those that are loaded, in order.
    """

    def __init__(self, pallet: Pallet, *, limited: bool) -> None:
        self._layout, self._limited = GrowingLayout(pallet, "repair"), limited
        self._layout.warm()
        self.boxes: list[int] = []

    @property
    def corners(self) -> tuple[FloatArray, FloatArray]:
        """Lower and upper corners of what is loaded [cm], shape (J, 3) each: views."""
        return self._layout.lower, self._layout.upper

    def place(self, box: int, item: Item, margin: float) -> bool:
        """Load a box if all is balanced with it; else nothing changes.

        Args:
            box: its number.
            item: the box at its place.
            margin: by which its contact patches are drawn in on every side [cm].
        """
        count = len(self.boxes)
        try:
            ended, _, _ = self._layout.try_put(numbered(item, count), BALANCED, margin)
        except LayoutError:
            return False
        if ended != STANDS:
            return False
        if self._limited and crushed_by_now(self._layout, self._layout.items) is not None:
            self._layout.cut(count)
            return False
        self.boxes.append(box)
        return True

    def stands(self, item: Item, positions: FloatArray, margin: float) -> NDArray[np.bool_]:
        """Whether a box would be balanced on each of many places, whatever boxes may bear.

        Args:
            item: the box; its own position does not matter.
            positions: lower corners [cm], shape (K, 3).
            margin: see :meth:`place`.
        """
        next_ = numbered(item, len(self.boxes))
        found: NDArray[np.bool_] = (
            self._layout.endings(next_, positions, BALANCED, margin) == STANDS
        )
        return found

    def cut(self, count: int) -> None:
        """Take off all boxes but the first ``count``."""
        if count < len(self.boxes):
            self._layout.cut(count)
            del self.boxes[count:]

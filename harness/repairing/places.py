"""Where else a box may be put, the nearest places first."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from steadyload.layouts.model.layout import TOLERANCE, FloatArray
from steadyload.repairing.plan import Boxes, Kind

_MOST = 4000
"""Places of a side of a box, at most."""


class Places:
    """Free places of boxes.

    Args:
        boxes: of the plan.
        allowed: what may change.
        shift_cm: how far a box that is shifted may move sideways.

    Attributes:
        exist: a box may be elsewhere than in the plan.
    """

    def __init__(self, boxes: Boxes, allowed: Collection[Kind], shift_cm: float) -> None:
        self._boxes = boxes
        self.exist = bool({Kind.DROP, Kind.SHIFT, Kind.MOVE, Kind.TURN} & set(allowed))
        self._turns = 2 if Kind.TURN in allowed else 1
        aside = (shift_cm if Kind.SHIFT in allowed else 0.0) + 1e-9
        lowest = -np.inf if Kind.DROP in allowed else -TOLERANCE
        anywhere = (np.inf, -np.inf, np.inf)
        self._ways = np.array(anywhere if Kind.MOVE in allowed else (aside, lowest, TOLERANCE))

    def of(
        self, box: int, places: FloatArray, margin: float, ignored: Collection[int] = ()
    ) -> tuple[FloatArray, FloatArray]:
        """Free places of a box, the nearest first.

        Args:
            box: its number.
            places: of all boxes, which it may not overlap, shape (J, 4).
            margin: how far its centre of mass is to lie inside the edges of what it lies on [cm].
            ignored: boxes that it may overlap.

        Returns:
            The places, shape (K, 4), and how far its centre comes from where it was [cm], (K,).
        """
        if not self.exist:
            return np.empty((0, 4)), np.empty(0)
        without = np.zeros(len(places), dtype=np.bool_)
        without[list(ignored)] = True
        found: tuple[FloatArray, FloatArray] = self._boxes.given.places_among(
            places, without, box, margin, self._boxes.limits, self._ways,
            self._turns if self._boxes.is_oblong(box) else 1, _MOST,
        )  # fmt: skip
        return found

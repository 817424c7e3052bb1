"""Which item rests on which: the geometry that all static methods share."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from harness.layouts.model import TOLERANCE, FloatArray, Layout


@dataclass(frozen=True, slots=True)
class Contacts:
    """Vertical contacts of a whole layout.

    Attributes:
        on_floor: item stands on the floor, shape (J,).
        carries: ``carries[i, j]`` is true where the top of i touches the base of j, shape (J, J).
        corners_low, corners_high: the contact rectangle of i and j in (x, z) [cm], shape
            (J, J, 2); meaningless where there is no contact.
    """

    on_floor: NDArray[np.bool_]
    carries: NDArray[np.bool_]
    corners_low: FloatArray
    corners_high: FloatArray

    def areas(self) -> FloatArray:
        """Contact areas [cm2] between i (below) and j (above), shape (J, J)."""
        return np.where(self.carries, (self.corners_high - self.corners_low).prod(axis=2), 0.0)


def find_contacts(layout: Layout) -> Contacts:
    """All vertical contacts: faces level to within :data:`TOLERANCE` that share an area."""
    floor_plan_low, floor_plan_high = layout.lower[:, ::2], layout.upper[:, ::2]
    low = np.maximum(floor_plan_low[:, None], floor_plan_low[None])
    high = np.minimum(floor_plan_high[:, None], floor_plan_high[None])
    level = np.abs(layout.upper[:, 1, None] - layout.lower[None, :, 1]) <= TOLERANCE
    shared = (high - low).min(axis=2) > TOLERANCE
    return Contacts(
        on_floor=layout.lower[:, 1] <= TOLERANCE,
        carries=level & shared,
        corners_low=low,
        corners_high=high,
    )

"""Where else a box may be put, the nearest places first."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from steadyload.layouts.model.layout import TOLERANCE, FloatArray, Item
from steadyload.repairing.plan import Boxes, Kind
from steadyload.statics import kernels

_MOST = 4000
"""Places of a box, at most."""


class Places:
    """Free places of boxes.

    Args:
        boxes: of the plan.
        allowed: what may change.
        shift_cm: how far a box that is shifted may move sideways.
    """

    def __init__(self, boxes: Boxes, allowed: Collection[Kind], shift_cm: float) -> None:
        self._boxes, self._allowed, self._shift = boxes, allowed, shift_cm
        self.of(0, (), 0.0)  # compiled code is loaded

    def of(
        self, box: int, others: Sequence[Item], margin: float
    ) -> tuple[FloatArray, FloatArray, list[bool]]:
        """Free places of a box, the nearest first.

        Args:
            box: its number.
            others: the boxes that it may not overlap, at their places.
            margin: how far its centre of mass is to lie inside the edges of what it lies on [cm].

        Returns:
            Lower corners, shape (K, 3), and how far its centre comes from where it was, shape (K,),
            both in cm, and for each whether it is turned by a quarter.
        """
        if not {Kind.DROP, Kind.SHIFT, Kind.MOVE, Kind.TURN} & set(self._allowed):
            return np.empty((0, 3)), np.empty(0), []
        lower = np.array([i.position for i in others], dtype=float).reshape(-1, 3)
        upper = lower + np.array([i.size for i in others], dtype=float).reshape(-1, 3)
        centres = 0.5 * (lower + upper)
        centres += np.array([i.mass_offset for i in others], dtype=float).reshape(-1, 3)
        planned = self._boxes.layout.items[box]
        middle = np.array(planned.position) + 0.5 * np.array(planned.size)
        levels = np.unique(np.concatenate(([0.0], upper[:, 1])))
        levels = levels[np.argsort(np.abs(levels - planned.position[1]), kind="stable")]
        found, far, turns = [], [], []
        for item in self._sides(box):
            size = np.array(item.size)
            start = middle - 0.5 * size
            if item is planned:
                start = np.array(planned.position)
            made = kernels.free_places.free_places(
                lower, upper, centres, size, 0.5 * size + item.mass_offset, start, margin,
                self._boxes.limits, levels, _MOST,
            )  # fmt: skip
            made = made[self._may_be(made - start)]
            found.append(made)
            far.append(np.sqrt(((made - start) ** 2).sum(axis=1)))
            turns += [item is not planned] * len(made)
        places, distances = np.concatenate(found), np.concatenate(far)
        order = np.lexsort(
            (np.array(turns), places[:, 2], places[:, 0], places[:, 1], distances.round(6))
        )
        return places[order], distances[order], [turns[k] for k in order]

    def _sides(self, box: int) -> Iterator[Item]:
        """The box as planned and, where that may be, turned."""
        item = self._boxes.layout.items[box]
        yield item
        if Kind.TURN in self._allowed and abs(item.size[0] - item.size[2]) > TOLERANCE:
            yield self._boxes.turned(box)

    def _may_be(self, way: FloatArray) -> NDArray[np.bool_]:
        """Which ways from the plan are allowed.

        Args:
            way: of the lower corner, (K, 3).
        """
        aside = np.sqrt(way[:, 0] ** 2 + way[:, 2] ** 2)
        if Kind.MOVE in self._allowed:
            return np.ones(len(way), dtype=bool)
        near = aside <= (self._shift if Kind.SHIFT in self._allowed else 0.0) + 1e-9
        lowest = -np.inf if Kind.DROP in self._allowed else -TOLERANCE
        found: NDArray[np.bool_] = near & (way[:, 1] <= TOLERANCE) & (way[:, 1] >= lowest)
        return found

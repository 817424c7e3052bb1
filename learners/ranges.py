"""What a learner was trained on, quantity by quantity, and what of a layout lies outside."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np

from harness.layouts.model import FloatArray, Layout

SLACK = 0.1
"""A range is this much wider at both ends, in shares of its ends, before something is outside."""

QUANTITIES: Mapping[str, str] = {
    "items": "",
    "longest pallet side": " cm",
    "shortest side": " cm",
    "longest side": " cm",
    "weight": " kg",
    "shift of the centre of mass": " of a side",
}
"""What is looked at, and its unit. Positions lie in the pallet, and need no range of their own."""


def _of_items(layout: Layout) -> FloatArray:
    """The quantities of every item, (4, J), in the order of :data:`QUANTITIES`."""
    sides = layout.upper - layout.lower
    shifts = np.abs(layout.mass_offsets / sides)
    return np.stack((sides.min(axis=1), sides.max(axis=1), layout.weights, shifts.max(axis=1)))


def trained_ranges(layouts: Iterable[Layout]) -> dict[str, list[float]]:
    """The least and the greatest value of every quantity: name -> [least, greatest]."""
    least, most = np.full(len(QUANTITIES), np.inf), np.full(len(QUANTITIES), -np.inf)
    for layout in layouts:
        of_items = _of_items(layout)
        whole = [len(layout), max(layout.pallet.size)]
        least = np.minimum(least, [*whole, *of_items.min(axis=1)])
        most = np.maximum(most, [*whole, *of_items.max(axis=1)])
    return {
        name: [float(low), float(high)]
        for name, low, high in zip(QUANTITIES, least, most, strict=True)
    }


def widest(ranges: Iterable[Mapping[str, list[float]]]) -> dict[str, list[float]]:
    """What several ranges hold together."""
    found = list(ranges)
    return {
        name: [min(r[name][0] for r in found), max(r[name][1] for r in found)]
        for name in QUANTITIES
    }


class TrainedRanges:
    """Ranges as a judge asks for them.

    Args:
        ranges: as of :func:`trained_ranges`.
    """

    def __init__(self, ranges: Mapping[str, list[float]]) -> None:
        self.ranges = {name: (ranges[name][0], ranges[name][1]) for name in QUANTITIES}
        ends = np.array([self.ranges[name] for name in QUANTITIES])
        self._least = ends[:, 0] * (1.0 - SLACK)
        self._most = ends[:, 1] * (1.0 + SLACK)

    def outside(self, layout: Layout) -> str:
        """What lies outside, of which item: a sentence; empty where nothing does."""
        for k, value in enumerate((len(layout), max(layout.pallet.size))):
            if not self._least[k] <= value <= self._most[k]:
                return self._sentence("the layout", k, value)
        of_items = _of_items(layout)
        beyond = (of_items < self._least[2:, None]) | (of_items > self._most[2:, None])
        if not beyond.any():
            return ""
        item, quantity = np.argwhere(beyond.T)[0].tolist()
        return self._sentence(f"item {item}", 2 + quantity, float(of_items[quantity, item]))

    def _sentence(self, of: str, quantity: int, value: float) -> str:
        name, unit = list(QUANTITIES.items())[quantity]
        low, high = self.ranges[name]
        return f"{of}: {name} is {value:g}{unit}; trained on {low:g} to {high:g}{unit}"

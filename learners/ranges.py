"""Training ranges of a learner, quantity by quantity, and the items of a layout outside them."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping

import numpy as np
from numpy.typing import NDArray

from steadyload.core import learned
from steadyload.core.whole import Given
from steadyload.layouts.model.layout import Arrangement, FloatArray
from steadyload.learners.features import FeatureKind
from steadyload.methods.contract.declared import LayoutRange

SLACK = 0.1
"""A range is this much wider at both ends, in shares of its ends, before something is outside."""

QUANTITIES: Mapping[str, str] = {
    "longest pallet side": " cm",
    "shortest side": " cm",
    "longest side": " cm",
    "weight": " kg",
    "shift of the centre of mass": " of a side",
    "heaviest over lightest": "",
    "overhang": " cm",
}
"""Quantities with a range, and their units. The last two are of all items placed by then, and of
an item over the edges of a deck. Positions lie in the pallet, and need no range. The number of
items has none either: a network judges step by step, and no feature of a step is that number.
Weights that state a range of it are read, and it limits nothing."""

_UNSEEN = ("longest pallet side", "weight")
"""Quantities that features of support do not depend on."""


def quantities_of(kind: FeatureKind) -> tuple[str, ...]:
    """The quantities that learners with these features have a range of."""
    return tuple(q for q in QUANTITIES if kind is FeatureKind.PLAIN or q not in _UNSEEN)


def extent_of(given: Given, longest: float) -> FloatArray:
    """The least and the greatest value of every quantity in one layout, (2, quantities).

    Args:
        given: the layout.
        longest: side of the pallet [cm].
    """
    of_items = learned.quantities(given)
    return np.array([[longest, *of_items.min(axis=0)], [longest, *of_items.max(axis=0)]])


def extents_of(layouts: Iterable[Arrangement]) -> FloatArray:
    """:func:`extent_of` each layout, (M, 2, quantities)."""
    return np.array([extent_of(each.given, max(each.pallet.size)) for each in layouts])


def trained_ranges(extents: Iterable[FloatArray], kind: FeatureKind) -> dict[str, list[float]]:
    """Ranges that many layouts span, name -> [least, greatest], from their :func:`extent_of`."""
    stacked = np.array(list(extents))
    low, high = stacked[:, 0].min(axis=0), stacked[:, 1].max(axis=0)
    known = quantities_of(kind)
    return {
        name: [float(low[k]), float(high[k])] for k, name in enumerate(QUANTITIES) if name in known
    }


def widest(ranges: Iterable[Mapping[str, list[float]]]) -> dict[str, list[float]]:
    """Union of several ranges."""
    found = list(ranges)
    return {
        name: [min(r[name][0] for r in found), max(r[name][1] for r in found)] for name in found[0]
    }


class TrainedRanges:
    """Ranges as a learned method needs them.

    Args:
        ranges: as of :func:`trained_ranges`.
        kind: of the features.

    Attributes:
        ranges: of all quantities; infinite where features do not depend on one.
    """

    def __init__(self, ranges: Mapping[str, list[float]], kind: FeatureKind) -> None:
        known = {name: (ranges[name][0], ranges[name][1]) for name in quantities_of(kind)}
        self.ranges = {name: known.get(name, (0.0, math.inf)) for name in QUANTITIES}
        ends = np.array([self.ranges[name] for name in QUANTITIES])
        self._least = ends[:, 0] * (1.0 - SLACK)
        self._most = ends[:, 1] * (1.0 + SLACK)

    def of_layouts(self) -> LayoutRange:
        """The layouts inside, without the slack."""
        most = {name: high for name, (_, high) in self.ranges.items()}
        return LayoutRange(
            pallet_side=self.ranges["longest pallet side"],
            shortest_side=self.ranges["shortest side"],
            longest_side=self.ranges["longest side"],
            weight=self.ranges["weight"],
            weight_ratio=most["heaviest over lightest"],
            mass_offset=most["shift of the centre of mass"],
            overhang=most["overhang"],
        )

    def outside(self, layout: Arrangement) -> str:
        """Sentence on the quantity and item that lie outside; empty if none does."""
        longest = max(layout.pallet.size)
        if not self._least[0] <= longest <= self._most[0]:
            return self._sentence("the layout", 0, longest)
        of_items, inside = self._of_items(layout)
        if inside == len(layout):
            return ""
        found, least, most = of_items[inside], self._least[1:], self._most[1:]
        quantity = int(np.argmax(~((least <= found) & (found <= most))))
        return self._sentence(f"item {inside}", 1 + quantity, float(found[quantity]))

    def beyond(self, extents: FloatArray) -> NDArray[np.bool_]:
        """Which quantities of M layouts lie outside, (M, quantities).

        Args:
            extents: their :func:`extents_of`.
        """
        found: NDArray[np.bool_] = extents[:, 0] < self._least
        return found | (extents[:, 1] > self._most)

    def steps_inside(self, layout: Arrangement) -> int:
        """Number of first steps with nothing outside; all if :meth:`outside` is empty."""
        if not self._least[0] <= max(layout.pallet.size) <= self._most[0]:
            return 0
        return self._of_items(layout)[1]

    def _of_items(self, layout: Arrangement) -> tuple[FloatArray, int]:
        """Quantities of every item, and the number of first items inside; the pallet apart."""
        found: FloatArray = learned.quantities(layout.given)
        return found, learned.count_inside(found, self._least[1:], self._most[1:])

    def _sentence(self, of: str, quantity: int, value: float) -> str:
        name, unit = list(QUANTITIES.items())[quantity]
        low, high = self.ranges[name]
        return f"{of}: {name} is {value:g}{unit}; trained on {low:g} to {high:g}{unit}"

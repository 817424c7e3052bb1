"""Changes of a layout that change no verdict of exact mechanics: its place, and its size.

A layout that is moved over the floor behaves as before. Only numbers of few digits notice: far from
the origin of a world the same digits have to tell a larger coordinate. A layout whose lengths are
multiplied by a factor behaves as before where times are multiplied by its square root, under the
same gravity and at any density (Froude's law of similitude). There all numbers keep their digits;
what notices are lengths, speeds and times that are fixed within an engine. So the first change
shows what precision costs, the second what a contact model does.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from steadyload.layouts.model.floor import FloorKind
from steadyload.layouts.model.item import Item
from steadyload.layouts.model.layout import Layout

_TIME, _FREQUENCY, _DISTANCE = 0.3, 480.0, 10.0
"""Of the label: seconds a placement, substeps a second, threshold [cm]."""


@dataclass(frozen=True, slots=True)
class Change:
    """A change of layouts, and of the methods that judge them.

    Attributes:
        moved: metres along both sides of the pallet.
        scale: factor of all lengths.
    """

    moved: float = 0.0
    scale: float = 1.0

    @property
    def name(self) -> str:
        """Name for folders and tables."""
        if self.moved:
            return f"moved {self.moved:g} m"
        if self.scale == 1.0:
            return "as it is"
        if self.scale > 1.0:
            return f"{self.scale:g} times larger"
        return f"{1.0 / self.scale:g} times smaller"

    def __str__(self) -> str:
        return self.name

    def of(self, layout: Layout) -> Layout:
        """The changed layout, on a pallet that holds it, on an infinite floor."""
        way, s = 100.0 * self.moved, self.scale
        pallet = replace(
            layout.pallet,
            width=s * layout.pallet.width + way,
            height=s * layout.pallet.height,
            depth=s * layout.pallet.depth + way,
            floor=FloorKind.INFINITE,
        )
        return Layout(layout.name, pallet, tuple(self._item(item, way) for item in layout.items))

    def _item(self, item: Item, way: float) -> Item:
        s, (x, y, z) = self.scale, item.position
        (width, height, depth), (p, q, r) = item.size, item.mass_offset
        return replace(
            item,
            position=(s * x + way, s * y, s * z + way),
            size=(s * width, s * height, s * depth),
            mass_offset=(s * p, s * q, s * r),
        )

    def method(self, engine: str) -> str:
        """The method that asks the label's question of a changed layout."""
        if self.scale == 1.0:
            return f"label@{engine}"
        pace = math.sqrt(self.scale)
        return (
            f"label@{engine}:t_max={_TIME * pace:.10g},frequency={_FREQUENCY / pace:.10g},"
            f"eps_t={_DISTANCE * self.scale:.10g}"
        )


AS_IT_IS = Change()
DISTANCES = tuple(Change(moved=metres) for metres in (1.0, 5.0, 20.0))
"""Within 20 m of its origin a world has the origin that it has for a layout at the corner."""

SCALES = tuple(Change(scale=factor) for factor in (1 / 16, 1 / 4, 4.0, 16.0))
"""Squares of powers of two: their roots are exact, and so are all lengths."""

CHANGES = (AS_IT_IS, *DISTANCES, *SCALES)

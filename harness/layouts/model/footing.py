"""Footing of a box: what carries it when it is loaded, and how far it drops where nothing does.

A box is carried by the floor and by boxes that are loaded before it. A gap is geometry: the
distance that a box without anything under it falls straight down in the plan.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from steadyload.layouts.model.contacts import FLOOR, Patch, Supports
from steadyload.layouts.model.frame import Frame
from steadyload.layouts.model.layout import TOLERANCE, Layout
from steadyload.layouts.model.naming import label_in


class Side(StrEnum):
    """A side of a box: left and right are low and high x, back and front low and high z."""

    LEFT = "left"
    RIGHT = "right"
    BACK = "back"
    FRONT = "front"

    def way(self, frame: Frame) -> str:
        """The direction that it faces, in the axes of the file: "+x"."""
        axis = 0 if self in (Side.LEFT, Side.RIGHT) else 2
        return f"{'-' if self in (Side.LEFT, Side.BACK) else '+'}{frame.axes[axis]}"


@dataclass(frozen=True, slots=True)
class Gap:
    """The space below a box that has nothing under it when it is loaded.

    Attributes:
        item: number of the box.
        height: how far it drops until it meets a box that is loaded before it, the floor, or the
            ground beyond the edge of a deck [cm], more than 0.
        onto: number of the box that it meets; None for the floor and the ground.
    """

    item: int
    height: float
    onto: int | None

    def exceeds(self, limit: float) -> bool:
        """Whether it is larger than a limit [cm]; one that is equal within 0.1 mm is not."""
        return self.height > limit + TOLERANCE

    def sentence(self, layout: Layout, frame: Frame | None = None) -> str:
        """Which box it is and onto what it drops: "box 7 ... has nothing under it; ..."."""
        if self.onto is not None:
            below = label_in(layout.items, self.onto)
        else:
            on_deck = self.height <= float(layout.lower[self.item, 1])
            below = "the floor" if on_deck else "the ground"
        drop = (frame or Frame()).length(self.height, finely=True)
        box = label_in(layout.items, self.item)
        return f"{box} has nothing under it; it drops {drop} onto {below}"


@dataclass(frozen=True, slots=True)
class Edge:
    """An edge of a support, and how far past it a weight acts.

    Attributes:
        side: of the box, beyond the rectangle about its support; of several the one on which the
            weight acts farthest out.
        beyond: how far outside [cm]; 0 for a weight that acts on the edge, within 0.1 mm.
        box: number of the box whose edge it is; None for the deck.
    """

    side: Side
    beyond: float
    box: int | None

    def sentence(self, layout: Layout, frame: Frame | None = None) -> str:
        """Where the weight acts: "5.0 cm past the edge of box A (1st of 2) (+x)"."""
        frame = frame or Frame()
        past = f"{frame.length(self.beyond)} past" if self.beyond else "on"
        of = "the deck" if self.box is None else label_in(layout.items, self.box)
        return f"{past} the edge of {of} ({self.side.way(frame)})"


@dataclass(frozen=True, slots=True)
class Footing:
    """How a box stands when it is loaded.

    Attributes:
        item: number of the box.
        support: share of its base that the floor and boxes loaded before it carry, 0 to 1.
        edge: past or on which its centre of mass lies; None where that lies inside the rectangle
            about its support, or there is no support.
        gap: below the box; None where something carries it.
    """

    item: int
    support: float
    edge: Edge | None = None
    gap: Gap | None = None

    @property
    def share(self) -> str:
        """How much of the base is supported: "38 % of its base is supported"."""
        return f"{_per_cent(self.support)} of its base is supported"

    def sentence(self, layout: Layout, frame: Frame | None = None) -> str:
        """The footing in numbers: "the centre of mass of box 7 lies 5.0 cm past ..."."""
        if self.gap is not None:
            return self.gap.sentence(layout, frame)
        box = label_in(layout.items, self.item)
        if self.edge is None:
            return f"{_per_cent(self.support)} of the base of {box} is supported"
        where = self.edge.sentence(layout, frame)
        return f"the centre of mass of {box} lies {where}; {self.share}"


def footing(layout: Layout, item: int) -> Footing:
    """The footing of a box.

    Args:
        layout: the plan.
        item: number of the box; those that are loaded after it do not matter.
    """
    supports = layout.supports
    if supports.on_floor[item]:
        return Footing(item, 1.0)
    patches = _carrying(supports, item)
    if not patches:
        return Footing(item, 0.0, gap=_gap(layout, item))
    box = layout.items[item]
    width, _, depth = box.size
    area = sum((p.x1 - p.x0) * (p.z1 - p.z0) for p in patches)
    x, _, z = (
        low + 0.5 * side + offset
        for low, side, offset in zip(box.position, box.size, box.mass_offset, strict=True)
    )
    support = min(area / (width * depth), 1.0)
    return Footing(item, support, edge_of(patches, x, z))


def edge_of(patches: Sequence[Patch], x: float, z: float) -> Edge | None:
    """The edge of a support past or on which a weight acts; None where it acts inside.

    Args:
        patches: of the support.
        x: of the weight [cm].
        z: likewise.
    """
    out = (
        (min(p.x0 for p in patches) - x, Side.LEFT, min(patches, key=lambda p: p.x0)),
        (x - max(p.x1 for p in patches), Side.RIGHT, max(patches, key=lambda p: p.x1)),
        (min(p.z0 for p in patches) - z, Side.BACK, min(patches, key=lambda p: p.z0)),
        (z - max(p.z1 for p in patches), Side.FRONT, max(patches, key=lambda p: p.z1)),
    )
    beyond, side, patch = max(out, key=lambda entry: entry[0])
    if beyond < -TOLERANCE:
        return None
    box = None if patch.below == FLOOR else patch.below
    return Edge(side, beyond if beyond > TOLERANCE else 0.0, box)


def gaps(layout: Layout) -> tuple[Gap, ...]:
    """The gaps of a plan, in the order of loading.

    Args:
        layout: the plan.
    """
    supports = layout.supports
    return tuple(
        _gap(layout, item)
        for item, on_floor in enumerate(supports.on_floor)
        if not on_floor and not _carrying(supports, item)
    )


def largest(found: tuple[Gap, ...]) -> Gap | None:
    """The largest of some gaps, of equal ones the first; None where there is none."""
    return max(found, key=lambda gap: gap.height, default=None)


def _carrying(supports: Supports, item: int) -> list[Patch]:
    """The patches on which a box is carried when it is loaded."""
    return [p for p in supports.below[item] if p.below == FLOOR or p.below < item]


def _gap(layout: Layout, item: int) -> Gap:
    """The gap below a box that nothing carries."""
    base, floor = float(layout.lower[item, 1]), layout.floor
    low, high = layout.lower[: item + 1, ::2], layout.upper[: item + 1, ::2]
    over = np.minimum(high[item], floor.high) - np.maximum(low[item], floor.low)
    shared = np.minimum(high[item], high[:item]) - np.maximum(low[item], low[:item])
    tops = layout.upper[:item, 1]
    beneath = np.flatnonzero((shared.min(axis=1) > TOLERANCE) & (tops <= base))
    ground = 0.0 if over.min() > TOLERANCE else -floor.height
    if not len(beneath) or tops[beneath].max() <= ground:
        return Gap(item, base - ground, None)
    onto = int(beneath[tops[beneath].argmax()])
    return Gap(item, base - float(tops[onto]), onto)


def _per_cent(share: float) -> str:
    """A share in whole per cent; only all of it reads 100 %, and only nothing 0 %."""
    if 0.0 < share < 0.005:
        return "less than 1 %"
    return f"{min(round(100.0 * share), 99) if share < 1.0 else 100} %"

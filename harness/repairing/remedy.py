"""The smallest change by which a step that fails would stand."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

from steadyload.layouts.model.footing import Side, footing
from steadyload.layouts.model.frame import Frame
from steadyload.layouts.model.layout import TOLERANCE, Layout, Vector
from steadyload.layouts.model.naming import label_in
from steadyload.methods.registry import make_method
from steadyload.repairing.changes import sideways
from steadyload.repairing.loading_order import OF_MOVED, LoadingOrder
from steadyload.repairing.places import Places
from steadyload.repairing.plan import Boxes, Kind
from steadyload.repairing.search import MARGIN

REACH = 30.0
"""How far a box is shifted at most [cm]."""


@dataclass(frozen=True, slots=True)
class Remedy:
    """Changes, each of which alone would let a step stand with a margin of balance of 5 mm.

    Attributes:
        step: that fails.
        after: step of a later box that would have to be loaded before; None where none helps.
        way: by which the box would have to be elsewhere (x, y, z) [cm], the shortest one; None
            where it stands nowhere within :data:`REACH`.
        side: of the box on which its support ends too early; None where that is not the fault.
        missing_cm: how much further the support would have to reach there [cm].
        gives_way: step of the box below that loses its balance; None where it is the box itself.
    """

    step: int
    after: int | None = None
    way: Vector | None = None
    side: Side | None = None
    missing_cm: float = 0.0
    gives_way: int | None = None

    @property
    def helps(self) -> bool:
        """Whether some change would let the step stand."""
        return self.after is not None or self.way is not None or self.side is not None

    def sentence(self, layout: Layout, frame: Frame | None = None) -> str:
        """The changes in words: "box 7 would stand if it lay 5.5 cm towards -x".

        Args:
            layout: the plan.
            frame: axes and unit of the sentence; None for ours.
        """
        frame, ways = frame or Frame(), []
        if self.after is not None:
            other = label_in(layout.items, self.after)
            ways.append(f"if it were loaded after {other}")
        if self.way is not None:
            parts = [sideways(self.way, frame)] * bool(self.way[0] or self.way[2])
            if self.way[1]:
                parts.append(f"{frame.length(-self.way[1], finely=True)} lower")
            ways.append(f"if it lay {' and '.join(parts)}")
        if self.side is not None:
            missing = frame.length(self.missing_cm, finely=True)
            ways.append(f"if its support reached {missing} further to {self.side.way(frame)}")
        box, below = label_in(layout.items, self.step), ""
        if self.gives_way is not None:
            below = f"; {label_in(layout.items, self.gives_way)} gives way below it"
        if ways:
            return f"{box} would stand {', or '.join(ways)}{below}"
        return f"{box} stands nowhere within {frame.length(REACH)} sideways of its place{below}"


def remedy(layout: Layout, step: int) -> Remedy | None:
    """The smallest changes by which a step would stand; None where it is balanced as it is.

    Args:
        layout: the plan.
        step: that fails.
    """
    boxes = Boxes(layout, limited=False)
    loading = LoadingOrder(boxes, reorder=True, margins=MARGIN)
    loaded, after = loading.load(boxes.planned), None
    if step in loaded.order:
        before = loaded.order[: loaded.order.index(step)]
        after = max((box for box in before if box > step), default=None)
        if after is None:
            return None
    at_fault = footing(layout, step)
    edge = at_fault.edge
    missing = 0.0 if edge is None else edge.beyond + OF_MOVED
    in_turn = LoadingOrder(boxes, reorder=False, margins=0.0)
    stuck = in_turn.load(boxes.planned).stuck
    below, way = _gives_way(boxes, step, stuck), _shift(boxes, step, in_turn)
    if way is None and below is not None:
        return Remedy(step, after, gives_way=below)
    return Remedy(step, after, way, None if edge is None else edge.side, missing, below)


def _gives_way(boxes: Boxes, step: int, unloaded: Collection[int]) -> int | None:
    """The lowest box below another one that is out of balance by its turn; None for none.

    Args:
        boxes: of the plan.
        step: of the other one.
        unloaded: boxes that are out of balance in their own turn.
    """
    supports = boxes.layout.supports
    below, found = [step], set[int]()
    while below:
        for carrier in supports.carriers(below.pop()):
            if carrier < step and carrier not in found:
                found.add(carrier)
                below.append(carrier)
    stuck = found.intersection(unloaded)
    unbalanced = make_method("equilibrium").judge(boxes.layout.first(step + 1))
    if unbalanced.failing_step == step and unbalanced.moved_item not in (None, step):
        stuck.add(unbalanced.moved_item)
    return min(stuck, key=lambda box: float(boxes.layout.lower[box, 1]), default=None)


def _shift(boxes: Boxes, step: int, in_turn: LoadingOrder) -> Vector | None:
    """The shortest way to where a box stands in its turn, free of all others of the plan.

    Args:
        boxes: of the plan.
        step: of the box.
        in_turn: the plan, loaded in its order.
    """
    free = Places(boxes, {Kind.SHIFT, Kind.DROP}, REACH)
    found, far = free.of(step, boxes.planned, OF_MOVED)
    nearest = in_turn.first_standing(step, found[far > TOLERANCE], OF_MOVED, 1)
    if not nearest:
        return None
    x, y, z = (nearest[0][:3] - boxes.planned[step, :3]).round(6).tolist()
    return (x, y, z)

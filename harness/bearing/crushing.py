"""Is a box crushed while a load is built up? Its top may bear so much, and bears so much by now."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from steadyload.bearing.forces import Statics
from steadyload.layouts.contacts import Supports, find_supports
from steadyload.layouts.item import Item
from steadyload.layouts.model import Arrangement, Layout
from steadyload.layouts.naming import box_label

_OVER = 1e-6
"""Share by which a load may exceed a limit: weights that add up to it do not."""


@dataclass(frozen=True, slots=True)
class Crushed:
    """A box that bears more than it may.

    Attributes:
        step: placement after which it does.
        item: the box.
        label: its id with its step, or its number where it has no id, as a sentence has it.
        bears_kg: the load on its top, by the contact forces of least energy, or by those that come
            nearest to balance where none balance.
        allowed_kg: what it may bear.
    """

    step: int
    item: int
    label: str
    bears_kg: float
    allowed_kg: float

    def __str__(self) -> str:
        bears, allowed = f"{self.bears_kg:.4g}", f"{self.allowed_kg:.4g}"
        if bears == allowed:
            bears, allowed = f"{self.bears_kg:.9g}", f"{self.allowed_kg:.9g}"
        return f"crushed at step {self.step}: {self.label} bears {bears} kg of {allowed}"


def first_crushed(layout: Layout) -> Crushed | None:
    """The box that is crushed first while a load is built up, box by box; None where none is.

    After a step at which no forces balance the load, those that come nearest count.

    Args:
        layout: the plan, in the order of loading.
    """
    if not _limited(layout.items):
        return None
    kept = layout.with_floor_kept()
    supports = find_supports(kept)
    # No box bears more than all that stands on it, directly or not.
    suspects = _suspects(range(len(layout)), len(layout) - 1, layout.items, supports)
    may = set(suspects)
    for step in range(min(suspects, default=len(layout)), len(layout)):
        found = _crushed_at(step, kept, layout.items, supports, may)
        if found is not None:
            return found
    return None


def crushed_by_now(layout: Arrangement, items: Sequence[Item]) -> Crushed | None:
    """The box that bears most beyond what it may since the last one was placed; None where none
    does.

    Args:
        layout: where the items are, one or more; it may still grow.
        items: with what they may bear; none was crushed before the last was placed.
    """
    if not _limited(items):
        return None
    every = set(range(len(items)))
    return _crushed_at(len(items) - 1, layout, items, find_supports(layout), every)


def _crushed_at(
    step: int, layout: Arrangement, items: Sequence[Item], supports: Supports, among: set[int]
) -> Crushed | None:
    """See :func:`crushed_by_now`, after one of the steps; of some of the boxes.

    A box changes the forces of those alone that are joined to it by standing on each other.
    """
    group = supports.joined(step)
    suspects = _suspects(sorted(among.intersection(group)), step, items, supports)
    if not suspects:
        return None
    statics = Statics(layout, group, supports)
    forces = statics.least_energy()
    if forces is None:
        forces = statics.nearest()
    borne = dict(zip(group, (statics.tops() @ forces).tolist(), strict=True))
    worst = max(
        (k for k in suspects if _beyond(borne[k], items[k].max_load)),
        key=lambda k: borne[k] - (items[k].max_load or 0.0),
        default=None,
    )
    if worst is None:
        return None
    item = items[worst]
    allowed = item.max_load
    assert allowed is not None, "only a box with a limit is crushed"
    label = box_label(item.sequence, item.name)
    return Crushed(step, worst, label, borne[worst], allowed)


def _limited(items: Sequence[Item]) -> bool:
    return any(item.max_load is not None for item in items)


def _beyond(load: float, allowed: float | None) -> bool:
    return allowed is not None and load > allowed * (1.0 + _OVER) + 1e-9


def _suspects(
    among: Sequence[int], step: int, items: Sequence[Item], supports: Supports
) -> list[int]:
    """Boxes on which more stands by a step, directly or not, than they may bear."""
    found = []
    for box in among:
        allowed = items[box].max_load
        if allowed is None:
            continue
        todo, seen, weight = [box], {box}, 0.0
        while todo and not _beyond(weight, allowed):
            for on in supports.above[todo.pop()]:
                if on <= step and on not in seen:
                    seen.add(on)
                    todo.append(on)
                    weight += items[on].weight
        if _beyond(weight, allowed):
            found.append(box)
    return found

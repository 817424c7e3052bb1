"""Is a box crushed while a load is built up? Its top may bear so much, and bears so much by now."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from steadyload.bearing.forces import Statics
from steadyload.layouts.contacts import find_supports
from steadyload.layouts.item import Item
from steadyload.layouts.model import Arrangement, FloatArray, Layout

_OVER = 1e-6
"""Share by which a load may exceed a limit: weights that add up to it do not."""


@dataclass(frozen=True, slots=True)
class Crushed:
    """A box that bears more than it may.

    Attributes:
        step: placement after which it does.
        item: the box.
        label: its id, or its number where it has none, as a sentence has it.
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
    weighed = _most_on_tops(layout, layout.items)
    # No box bears more than all that stands on it, directly or not.
    suspect = [k for k, item in enumerate(layout.items) if _beyond(weighed[k], item.max_load)]
    if not suspect:
        return None
    kept = layout.with_floor_kept()
    for step in range(min(suspect), len(layout)):
        found = crushed_by_now(kept.first(step + 1), layout.items[: step + 1])
        if found is not None:
            return found
    return None


def crushed_by_now(layout: Arrangement, items: Sequence[Item]) -> Crushed | None:
    """The box that bears most beyond what it may, all items in place; None where none does.

    Args:
        layout: where the items are; it may still grow.
        items: with what they may bear.
    """
    if not _limited(items):
        return None
    weighed = _most_on_tops(layout, items)
    if not any(_beyond(weighed[k], item.max_load) for k, item in enumerate(items)):
        return None
    statics = Statics(layout)
    forces = statics.least_energy()
    if forces is None:
        forces = statics.nearest()
    borne = statics.tops() @ forces
    worst = max(
        (k for k, item in enumerate(items) if _beyond(borne[k], item.max_load)),
        key=lambda k: borne[k] - (items[k].max_load or 0.0),
        default=None,
    )
    if worst is None:
        return None
    item = items[worst]
    allowed = item.max_load
    assert allowed is not None, "only a box with a limit is crushed"
    label = f"box {item.name}" if item.name else f"item {item.sequence}"
    return Crushed(len(items) - 1, worst, label, float(borne[worst]), allowed)


def _limited(items: Sequence[Item]) -> bool:
    return any(item.max_load is not None for item in items)


def _beyond(load: float, allowed: float | None) -> bool:
    return allowed is not None and load > allowed * (1.0 + _OVER) + 1e-9


def _most_on_tops(layout: Arrangement, items: Sequence[Item]) -> FloatArray:
    """The weight of all that stands on a box, directly or not [kg], shape (J,)."""
    supports = find_supports(layout)
    found = np.zeros(len(items))
    above: list[set[int]] = [set() for _ in items]
    for item in np.argsort(-layout.lower[:, 1], kind="stable").tolist():
        for on in supports.above[item]:
            above[item] |= {on} | above[on]
        found[item] = sum(items[k].weight for k in above[item])
    return found

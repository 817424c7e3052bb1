"""Remedies of loads that fail, in sentences."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING

from steadyload.app.faults import Fault
from steadyload.layouts.model.frame import Frame
from steadyload.layouts.model.layout import Item, Layout, Pallet

if TYPE_CHECKING:
    from steadyload.repairing.remedy import Remedy


def remedy_of(layout: Layout, fault: Fault, frame: Frame) -> str:
    """The smallest change by which the failing step would stand, in a sentence.

    Where nothing helps there, and balance is lost before, that by which balance would be kept.
    """
    found = _look_for_remedy(layout, fault.step)
    if found is not None and not found.helps and fault.lost and fault.lost.step < fault.step:
        earlier = _look_for_remedy(layout, fault.lost.step)
        found = earlier if earlier is not None and earlier.helps else found
    return "" if found is None else found.sentence(layout, frame)


@cache
def prepare_remedies() -> None:
    """Import the modules that the look for a remedy calls."""
    side = (20.0, 20.0, 20.0)
    boxes = (Item(0, (0.0, 0.0, 0.0), side, 5.0), Item(1, (15.0, 20.0, 0.0), side, 5.0))
    _look_for_remedy(Layout("leans", Pallet(100.0, 100.0, 100.0), boxes), 1)


def _look_for_remedy(layout: Layout, step: int) -> Remedy | None:
    """See :func:`steadyload.repairing.remedy.remedy`, which is imported when a plan fails."""
    from steadyload.repairing.remedy import remedy

    return remedy(layout, step)

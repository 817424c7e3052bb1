"""Reasons for which loads fail, in numbers of the load: the footing of the box at fault."""

from __future__ import annotations

from functools import cache

from steadyload.layouts.model.footing import Footing, footing
from steadyload.layouts.model.frame import Frame
from steadyload.layouts.model.layout import Layout
from steadyload.layouts.model.naming import box_label
from steadyload.methods.contract.method import Method, Status, Verdict
from steadyload.methods.registry import make_method


def footing_at_fault(layout: Layout, verdict: Verdict) -> Footing | None:
    """The footing of the box at fault in the plan; None for a load that does not fail."""
    item = verdict.item_at_fault
    return None if item is None or verdict.failing_step is None else footing(layout, item)


def reason_of(layout: Layout, verdict: Verdict, frame: Frame | None = None, *, method: str) -> str:
    """How the box at fault stands in the plan, in a sentence; empty for a load that does not fail.

    Of a box that is supported and does not lean in the plan the sentence says that it moves in the
    simulation alone, and whether contact forces balance the boxes placed by then.

    Args:
        layout: the plan.
        verdict: on it.
        frame: axes and unit of the sentence.
        method: spec of the method whose verdict it is.
    """
    found, step = footing_at_fault(layout, verdict), verdict.failing_step
    if found is None or step is None:
        return ""
    said = found.sentence(layout, frame)
    if step != found.item:
        said += f"; it gives way when {_label(layout, step)} is placed"
    if found.gap is None and found.side is None and verdict.displacement is not None:
        said += f"; it moves too far only in the simulation of {method}{_balance(layout, step)}"
    return said


def _balance(layout: Layout, step: int) -> str:
    """Whether contact forces balance the plan after a step, to follow what the simulation says."""
    balance = _equilibrium().judge(layout.first(step + 1))
    if balance.stable:
        return ", while contact forces balance every box in the plan"
    if balance.status is not Status.DONE or balance.item_at_fault is None:
        return ""
    lost = _label(layout, balance.item_at_fault)
    return f"; the first box that contact forces do not balance in the plan is {lost}"


@cache
def _equilibrium() -> Method:
    """The method that knows whether contact forces balance; it reads no file, and is made once."""
    return make_method("equilibrium")


def _label(layout: Layout, item: int) -> str:
    return box_label(item, layout.items[item].name)

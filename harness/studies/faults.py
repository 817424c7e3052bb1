"""Reasons for which loads fail, in numbers of the load: the footing of the box at fault."""

from __future__ import annotations

from steadyload.layouts.footing import Footing, footing
from steadyload.layouts.frame import Frame
from steadyload.layouts.model import Layout
from steadyload.layouts.naming import box_label
from steadyload.methods.verdict import Verdict


def footing_at_fault(layout: Layout, verdict: Verdict) -> Footing | None:
    """The footing of the box at fault in the plan; None for a load that does not fail."""
    item = verdict.item_at_fault
    return None if item is None or verdict.failing_step is None else footing(layout, item)


def reason_of(layout: Layout, verdict: Verdict, frame: Frame | None = None) -> str:
    """How the box at fault stands in the plan, in a sentence; empty for a load that does not fail.

    Args:
        layout: the plan.
        verdict: on it.
        frame: axes and unit of the sentence.
    """
    found = footing_at_fault(layout, verdict)
    if found is None:
        return ""
    said, step = found.sentence(layout, frame), verdict.failing_step
    if step is None or step == found.item:
        return said
    return f"{said}; it gives way when {box_label(step, layout.items[step].name)} is placed"

"""Margin filter: selects the verdicts that neither rounding nor any sound engine should change."""

from __future__ import annotations

from steadyload.layouts.model.layout import Layout
from steadyload.methods.contract.declared import Trait
from steadyload.methods.contract.method import Verdict
from steadyload.properties.property import MethodUnderTest
from steadyload.statics.margins import margins
from steadyload.statistics.placed import items_placed

CLEARANCE = 0.3
"""A balance kept or lost by this much is clear [cm]: every contact patch could be narrower, or
would have to be wider, by it. An engine's own error in where a box begins to tip is a tenth."""

_FAR = 1.5
"""A movement beyond this multiple of a threshold is clear."""


def balance_lost(layout: Layout) -> tuple[int, bool] | None:
    """The first step that vertical forces do not balance by a clear margin; None without one.

    Returns:
        The step, and whether it is out of balance by a clear margin, too.
    """
    for step, margin in enumerate(margins(layout, centres=False)):
        if margin.patches < CLEARANCE:
            return step, margin.patches <= -CLEARANCE
    return None


def is_clear(tested: MethodUnderTest, layout: Layout, verdict: Verdict) -> bool:
    """True if a verdict is beyond every limit by a clear margin.

    A method of exact geometry, which asks for no movement, is always clear. Otherwise the layout
    has to balance clearly at every step; or up to one that is out of balance clearly, and what
    moves by then to be far beyond a threshold. Whether the verdict is right plays no part.
    """
    if not tested.has(Trait.MOVEMENT):
        return True
    lost = balance_lost(layout)
    if lost is None:
        return True
    step, clearly = lost
    if not clearly or items_placed(verdict.failing_step, len(layout)) > step:
        return False
    assert verdict.displacement is not None
    assert verdict.rotation is not None
    limits = tested.method.movement_limits
    assert limits is not None, "a method that judges by movement declares its limits"
    far = verdict.displacement >= _FAR * limits.displacement
    return far or verdict.rotation >= _FAR * limits.rotation

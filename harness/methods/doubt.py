"""Doubt about a simulation: it moves a box of a load that closed forms find in balance.

Vertical contact forces that balance every box, also with all contact patches drawn in, leave a
rigid load at rest. A simulation that moves it too far all the same errs: its contacts are too soft
for the weights, or its solver gave up. Envelopes tell this where it was measured
(:mod:`steadyload.methods.envelope`); this tells it of the load that was judged.
"""

from __future__ import annotations

from steadyload.layouts.model.frame import Frame
from steadyload.layouts.model.layout import Layout
from steadyload.methods.contract.method import Method
from steadyload.methods.contract.verdict import Verdict
from steadyload.statics.load_margin import margin_as_planned

_MARGIN, _SHARE = 0.5, 0.05
"""Of a load in balance the margin is at least this [cm], or this share of the shortest edge of a
base."""


def doubt(layout: Layout, method: Method, verdict: Verdict, frame: Frame | None = None) -> str:
    """A sentence on a load that a simulation sees fall although it is in balance; else empty.

    Takes a fraction of a millisecond where a simulation sees a load fall, and nothing otherwise.

    Args:
        layout: that was judged.
        method: that judged it.
        verdict: on it.
        frame: unit of the sentence.
    """
    step = verdict.failing_step
    if method.spec.engine is None or step is None or verdict.displacement is None:
        return ""
    margin = margin_as_planned(layout.first(step + 1))
    edges = layout.sizes[: step + 1, ::2]
    if margin is None or margin.cm < min(_MARGIN, _SHARE * float(edges.min())):
        return ""
    spare = (frame or Frame()).length(margin.cm, finely=True)
    return (
        f"item {verdict.item_at_fault} moves too far in {method.spec.engine} when item {step} is "
        f"placed, but contact forces balance the load, with {spare} to spare"
    )

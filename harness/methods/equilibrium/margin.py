"""The margin of a whole load, as planned or at rest."""

from __future__ import annotations

from steadyload.layouts.model.layout import Layout
from steadyload.methods.contract.method import Stopwatch
from steadyload.methods.equilibrium.settling import FIRM, RestingSteps, SettlingParameters
from steadyload.statics.load_margin import (
    MOST,
    LoadMargin,
    MarginKind,
    load_margin,
    margin_as_planned,
)

_FINEST_AT_REST = 0.05
"""A margin at rest is known so closely [cm]; each halving is a linear programme."""


def margin_of(layout: Layout, watch: Stopwatch | None = None) -> LoadMargin | None:
    """The margin of a load, over all steps of its loading; None where it has none.

    As planned it is the largest m, up to :data:`MOST`, at which every step still balances with all
    contact patches drawn in by m on every side. Where the plan itself does not balance it is the
    largest m at which, with all rectangles in which boxes may come to lie on each other drawn in
    likewise, each step's rest position (:mod:`steadyload.methods.equilibrium.settling`) stays
    within 10 cm and 10 degrees of the plan. There is none where that is too far with nothing drawn
    in, or where a solver gives up.

    Args:
        layout: any layout.
        watch: raises :class:`TimeoutExpiredError` between steps once its time is up.
    """
    return margin_as_planned(layout) or _at_rest(layout, watch or Stopwatch())


def _at_rest(layout: Layout, watch: Stopwatch) -> LoadMargin | None:
    """Each step is tried at the least margin so far, and only one that fails there is halved."""

    def settling(margin: float) -> RestingSteps:
        return RestingSteps(SettlingParameters(margin=margin), layout)

    margin, at, first = MOST, -1, -1
    whole, steps = settling(FIRM), settling(margin)
    for step in range(len(layout)):
        watch.check()
        # A narrow contact of which nothing is left at a margin may be what a box tips over.
        if not whole.step_score(step) <= 1.0:
            return None
        if steps.step_score(step) <= 1.0:
            continue
        item = steps.finding(step).moved_item
        low, high, at, first = FIRM, margin, step, -1 if item is None else item
        steps = settling(low)
        while high - low > _FINEST_AT_REST:
            watch.check()
            middle = 0.5 * (low + high)
            tried = settling(middle)
            if tried.step_score(step) <= 1.0:
                low, steps = middle, tried
            else:
                item = tried.finding(step).moved_item
                high, first = middle, -1 if item is None else item
        margin = low
    return load_margin(margin, MarginKind.AT_REST, at, first)

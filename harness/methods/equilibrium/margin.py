"""The margin of a load that stands: by how much all contacts may be smaller with it still standing.

The yes of a judge does not say how close it was. Boxes are not where a plan says by millimetres,
and nobody knows where the centre of mass of a box is: a load whose margin is below that is a close
call, whatever a judge says of its plan.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from steadyload.layouts.model.frame import Frame
from steadyload.layouts.model.layout import Layout
from steadyload.methods.contract.method import Stopwatch
from steadyload.methods.equilibrium.settling import FIRM, RestingSteps, SettlingParameters
from steadyload.statics import kernels
from steadyload.statics.kernels.constants import BALANCED

MOST = 10.0
"""A larger margin is not looked for [cm]."""

CLOSE_CALL = 1.0
"""A load that stands by less is a close call [cm]."""

_FINEST_AT_REST = 0.05
"""A margin at rest is known so closely [cm]; each halving is a linear programme."""


class MarginKind(StrEnum):
    """What a margin is of: the plan, or the position in which its boxes come to rest.

    ``as planned``: contact forces balance every step of the plan. ``at rest``: they do not, since
    boxes have gaps below them, but all rest within the thresholds of a fall.
    """

    AS_PLANNED = "as planned"
    AT_REST = "at rest"


@dataclass(frozen=True, slots=True)
class LoadMargin:
    """The margin of a load.

    Attributes:
        cm: every contact patch may be narrower by this on every side [cm], up to :data:`MOST`; a
            patch of which nothing is left carries nothing.
        kind: see :class:`MarginKind`.
        step: at which the margin is smallest, counted from 0; None where it is :data:`MOST`.
        item: the one that is the first to lose its balance, or to come too far, there; likewise.
    """

    cm: float
    kind: MarginKind
    step: int | None
    item: int | None

    @property
    def is_close_call(self) -> bool:
        """Whether it is below :data:`CLOSE_CALL`."""
        return self.cm < CLOSE_CALL

    def words(self, frame: Frame) -> str:
        """The margin as people read it: "3.4 cm", "10 cm or more"."""
        if self.cm >= MOST:
            return f"{frame.stated(MOST)} {frame.unit} or more"
        return frame.length(self.cm)


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


def margin_as_planned(layout: Layout) -> LoadMargin | None:
    """The margin of a load as planned, see :func:`margin_of`; None where not every step balances.

    It takes about twice as long as equilibrium itself: microseconds a box.

    Args:
        layout: any layout.
    """
    ended, margin, step, item = kernels.margin.margin_as_planned(
        layout.lower, layout.upper, layout.weights, layout.mass_offsets, layout.floor.corners, MOST
    )
    if ended != BALANCED:
        return None
    return _margin(margin, MarginKind.AS_PLANNED, step, item)


def _margin(cm: float, kind: MarginKind, step: int, item: int) -> LoadMargin:
    return LoadMargin(
        float(cm), kind, None if step < 0 else int(step), None if item < 0 else int(item)
    )


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
    return _margin(margin, MarginKind.AT_REST, at, first)

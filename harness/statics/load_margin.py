"""The margin of a load that stands: by how much all contacts may be smaller with it still standing.

The yes of a judge does not say how close it was. Boxes are not where a plan says by millimetres,
and nobody knows where the centre of mass of a box is: a load whose margin is below that is a close
call, whatever a judge says of its plan.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from steadyload.core.constants import STANDS
from steadyload.layouts.model.frame import Frame
from steadyload.layouts.model.layout import Layout

MOST = 10.0
"""A larger margin is not looked for [cm]."""

CLOSE_CALL = 1.0
"""A load that stands by less is a close call [cm]."""


class MarginKind(StrEnum):
    """Kind of a margin: of the plan, or of the position in which its boxes come to rest.

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


def margin_as_planned(layout: Layout) -> LoadMargin | None:
    """The margin of a load as planned, see :class:`LoadMargin`; None where not every step balances.

    It takes about twice as long as equilibrium itself: microseconds a box.

    Args:
        layout: any layout.
    """
    ended, step, item, margin = layout.given.margin(MOST)
    if ended != STANDS:
        return None
    return load_margin(margin, MarginKind.AS_PLANNED, step, item)


def load_margin(cm: float, kind: MarginKind, step: int, item: int) -> LoadMargin:
    """A margin from its numbers, with steps and items below 0 for none."""
    return LoadMargin(
        float(cm), kind, None if step < 0 else int(step), None if item < 0 else int(item)
    )

"""Static stability with settling: a box that tips into a gap and comes to rest there is stable."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from steadyload.core.constants import BALANCED, STANDS
from steadyload.core.constants import VERSION as CORE
from steadyload.engines.quantities import quantity
from steadyload.layouts.model.contacts import VERSION as CONTACTS
from steadyload.layouts.model.layout import Layout
from steadyload.methods.contract.declared import MovementLimits, Trait
from steadyload.methods.contract.method import (
    STABLE,
    Finding,
    Method,
    Status,
    StepScorer,
    Stopwatch,
)
from steadyload.statics.balance import DRAWN_IN, VerticalBalance, inset
from steadyload.statics.balance import VERSION as BALANCE
from steadyload.statics.movement import Movement
from steadyload.statics.rest_position import VERSION as REST
from steadyload.statics.rest_position import RestPositions

AT_REST = Movement(-1, 0.0, 0.0, 0.0)
"""Where nothing moves at all."""

FIRM = 0.01
"""Balance within this is none [cm]: what needs the very edge stands for no time."""


@dataclass(frozen=True)
class SettlingParameters:
    """Parameters: how firmly balance must hold, and how far a load may settle."""

    margin: float = quantity(
        FIRM, "draw in contact patches by this on every side: balance within it counts as none",
        unit="cm", least=0, most=10,
    )  # fmt: skip
    eps_t: float = quantity(10, "displacement that counts as unstable", unit="cm", least=0)
    eps_r: float = quantity(10, "angle that counts as unstable", unit="deg", least=0, most=45)


class Settling(Method):
    """Static stability with settling: a step fails if its rest position is too far from the plan.

    Where contact forces balance every item, with contact patches drawn in by a margin, nothing
    moves. Where they do not, boxes sink and tilt to the position of least potential energy
    (:mod:`steadyload.statics.rest_position`); the step fails if a left-bottom-back
    corner comes further than ``eps_t`` along an axis, or a box tilts by more than ``eps_r``. Real
    pallets have gaps of some millimetres everywhere: nearly all of their boxes settle, and few
    balance as planned. A larger ``margin`` asks for more: rest with it as well as without.

    It answers whether a load stands in the end. Boxes do not slide, lean on each other sideways, or
    overshoot. A time limit is looked at between steps.
    """

    title = "Settling"
    Parameters = SettlingParameters
    built_on: ClassVar[Mapping[str, int]] = {
        "core": CORE, "contacts": CONTACTS, "balance": BALANCE, "rest position": REST
    }  # fmt: skip
    packages = ("numpy", "scipy")

    def parts(self) -> Mapping[str, int]:
        """See :meth:`Method.parts`."""
        drawn = {"drawn in": DRAWN_IN} if self.parameters.margin > FIRM else {}
        return {**super().parts(), **drawn}

    @property
    def traits(self) -> frozenset[Trait]:
        """See :attr:`Method.traits`."""
        return frozenset((Trait.STEPWISE, Trait.CENTRES_OF_MASS, Trait.BALANCE, Trait.MOVEMENT))

    @property
    def movement_limits(self) -> MovementLimits:
        """See :attr:`Method.movement_limits`: it judges where everything rests in the end."""
        return MovementLimits(math.inf, self.parameters.eps_t, self.parameters.eps_r)

    def steps(self, layout: Layout, watch: Stopwatch) -> StepScorer:
        """See :meth:`Method.steps`, and :class:`SettlingSteps` for the scores."""
        return SettlingSteps(self.parameters, layout)

    def _judge(self, layout: Layout, watch: Stopwatch) -> Finding:
        found = layout.given.judge(BALANCED, self.parameters.margin)
        if found.ended == STANDS:
            return STABLE
        steps = SettlingSteps(self.parameters, layout)
        for step in range(found.step, len(layout)):
            watch.check()
            # One that is no number is above nothing.
            if not steps.step_score(step) <= 1.0:
                return steps.finding(step)
        return STABLE


class SettlingSteps(StepScorer):
    """Scores of single steps: the largest movement of a box, in units of its threshold.

    With a margin above :data:`FIRM` boxes must rest with that one, too: of a narrow contact over
    which one tips nothing is left with the larger. Only then a box that came too far at a step that
    was scored before does not count again: that step answers for it.

    Args:
        parameters: of the method.
        layout: any layout.
    """

    decision_threshold = 1.0

    def __init__(self, parameters: SettlingParameters, layout: Layout) -> None:
        margins = dict.fromkeys((parameters.margin, min(FIRM, parameters.margin)))
        self._at = [RestingSteps(replace(parameters, margin=each), layout) for each in margins]
        self._worst = self._at[0]

    def step_score(self, step: int) -> float:
        """See :meth:`StepScorer.step_score`."""
        worst = -1.0
        for at in self._at:
            score = at.step_score(step)
            if not score <= worst:
                self._worst, worst = at, score
            if not worst <= 1.0:
                break
        return worst

    def finding(self, step: int) -> Finding:
        """See :meth:`StepScorer.finding`."""
        return self._worst.finding(step)


class RestingSteps(StepScorer):
    """The same with contact patches that are drawn in by one margin.

    Args:
        parameters: of the method.
        layout: any layout.
    """

    decision_threshold = 1.0

    def __init__(self, parameters: SettlingParameters, layout: Layout) -> None:
        self._layout, self._margin = layout, parameters.margin
        self._on_floor = np.array(layout.supports.on_floor)
        self._balance = VerticalBalance(layout, self._margin)
        self._rest = RestPositions(layout, self._margin, parameters.eps_t, parameters.eps_r)
        inside = inset(layout, slice(None)) >= self._margin
        self._fixed = self._on_floor & inside
        meets: list[list[int]] = [[] for _ in range(len(layout))]
        for below, above in zip(self._rest.below.tolist(), self._rest.above.tolist(), strict=True):
            if below >= 0:
                meets[max(below, above)].append(min(below, above))
        self._meets = meets
        # By item: those that can meet it, directly or over others; one list a group.
        self._groups: list[list[int]] = []
        self._placed = 0
        self._balanced: set[int] = set()
        self._settles: set[int] = set()
        # Items that came too far at a step before.
        self._falls = np.zeros(len(layout), dtype=np.bool_)
        self._found: Finding | None = None

    def step_score(self, step: int) -> float:
        """See :meth:`StepScorer.step_score`."""
        self._found = None
        for placed in range(self._placed, step + 1):
            group = self._join(placed)
        self._placed = step + 1
        try:
            far = self._far(step, sorted(group))
        except RuntimeError as error:  # the solvers' only way to say that they gave up
            self._found = Finding(status=Status.ERROR, reason=f"step {step}: {error}")
            return np.nan
        if far.beyond > 1.0:
            self._found = Finding(
                step,
                far.item,
                far.displacement,
                far.rotation,
                f"item {far.item} settles too far, or falls, when item {step} is placed",
            )
        return far.beyond

    def finding(self, step: int) -> Finding:
        """See :meth:`StepScorer.finding`."""
        return self._found or super().finding(step)

    def _join(self, item: int) -> list[int]:
        """Add an item; the group that it is in now."""
        group = [item]
        self._groups.append(group)
        for other in self._meets[item]:
            joined = self._groups[other]
            if joined is not group:
                group.extend(joined)
                for member in joined:
                    self._groups[member] = group
        return group

    def _far(self, step: int, group: list[int]) -> Movement:
        """The movement of the item of a group that gets furthest after a step, of those that did
        not come too far before.
        """
        if self._settles.isdisjoint(group):
            for item in group:
                if item not in self._balanced:
                    fails = not self._fixed[item] and self._on_floor[item]
                    if fails or self._balance.place(item) is not None:
                        break
                    self._balanced.add(item)
            else:
                return AT_REST
        self._settles.update(group)
        who = np.array(group)
        firm = self._fixed[who]
        moved = self._rest.movements(who[~firm], who[firm])
        before = self._falls[moved.items] & (self._margin > FIRM)
        self._falls[moved.items] = ~(moved.beyond <= 1.0)
        return AT_REST if before.all() else moved.furthest(~before)

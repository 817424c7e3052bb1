"""Exact equilibrium: do contact forces exist that balance every item, and what if they do not?"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from engines.quantities import quantity
from harness.layouts.model import Layout
from harness.methods.balance import VerticalBalance
from harness.methods.friction import Sides, unbalanced_item
from harness.methods.method import STABLE, Finding, Method, Status, Stopwatch, Trait
from harness.methods.motion import Bodies, moved
from harness.methods.touching import touching_points


class Cones(StrEnum):
    """How friction cones are treated.

    ``linear``: as pyramids inside them, with ``facets`` edges. ``exact``: pyramids inside and
    around them are refined until both give the same answer.
    """

    LINEAR = "linear"
    EXACT = "exact"


@dataclass(frozen=True)
class EquilibriumParameters:
    """What pushes, and how long an item that lost its balance is watched."""

    sides: Sides = quantity(Sides.NONE, "contact forces at side faces that touch")
    friction: float = quantity(0.5, "Coulomb friction of a contact", least=0, most=10)
    cones: Cones = quantity(Cones.LINEAR, "how friction cones are treated")
    facets: int = quantity(8, "edges of the pyramid in a friction cone", least=3, most=64)
    time: float | None = quantity(
        None, "how long items that lost their balance are watched; none: any loss is a failure",
        unit="s", least=1e-6, most=1000,
    )  # fmt: skip
    eps_t: float = quantity(10, "with time: displacement that counts as unstable", unit="cm",
                            least=0)  # fmt: skip
    eps_r: float = quantity(10, "with time: angle that counts as unstable", unit="deg", least=0)


class Equilibrium(Method):
    """Exact equilibrium: the loading fails where no contact forces balance every item.

    At every step it is asked whether non-negative vertical forces exist, at the corners of every
    contact patch, that carry the weight of every item and let none of them tip. That is a linear
    programme; it is solved only where passing the new weight down one way does not prove balance,
    and where the new item does not plainly stick out too far. A centre of mass exactly above an
    edge is balanced, as with SME.

    ``sides`` lets side faces that touch push, too, with or without friction, and then all
    horizontal faces have friction. Full friction accepts jammed states: a box between two others
    and nothing under it "stands" because they could clamp it.

    With ``time``, a step fails only if the items that lost their balance get far enough within it:
    further than ``eps_t`` (the left-bottom-back corner, along one axis) or ``eps_r``, at its end. A
    model of the first moments (:mod:`harness.methods.motion`) says how far that is: pendulums
    between events, stopped by what is in the way. Every step is judged from the planned positions.
    The displacement and the angle in the verdict are that model's, good up to some 20 degrees.
    """

    Parameters = EquilibriumParameters

    @property
    def traits(self) -> frozenset[Trait]:
        """See :attr:`Method.traits`."""
        exact = frozenset((Trait.STEPWISE, Trait.CENTRES_OF_MASS, Trait.BALANCE))
        return exact if self.parameters.time is None else exact | {Trait.MOVEMENT}

    def _judge(self, layout: Layout, watch: Stopwatch) -> Finding:
        balance = VerticalBalance(layout)
        try:
            for step in range(len(layout)):
                watch.check()
                item = balance.place(step)
                if item is not None:
                    finding = self._unbalanced(layout, balance, step, item)
                    if finding is not None:
                        return finding
        except RuntimeError as error:  # the solver's only way to say that it gave up
            return Finding(status=Status.ERROR, reason=f"step {step}: {error}")
        return STABLE

    def _unbalanced(
        self, layout: Layout, balance: VerticalBalance, step: int, item: int
    ) -> Finding | None:
        """The finding at a step where vertical forces alone do not balance an item."""
        p = self.parameters
        if p.sides is not Sides.NONE:
            exact = p.cones is Cones.EXACT
            among = unbalanced_item(layout, step, p.sides, p.friction, p.facets, exact=exact)
            if among is None:
                return None
            item = among
        if p.time is None:
            reason = f"no contact forces balance item {item} when item {step} is placed"
            return Finding(step, item, reason=reason)
        return self._moved(layout, balance, step)

    def _moved(self, layout: Layout, balance: VerticalBalance, step: int) -> Finding | None:
        """The finding when something gets too far within the time.

        Items beside the group are in the way and do not move. Letting those move, too, that the
        group leans on was tried: four times the cost, and no more verdicts right.
        """
        p = self.parameters
        items = balance.group(step)
        others = sorted(set(range(step + 1)) - set(items))
        sizes = balance.sizes[items]
        # How far a corner can come before its item counts as moved.
        turned = 2.0 * math.sin(0.5 * math.radians(min(p.eps_r, 180.0)))
        reach = p.eps_t + turned * float(np.sqrt((sizes**2).sum(axis=1)).max())
        points = touching_points(layout, items, others, reach=reach)
        rough = (points.axes == 1) | (p.sides is Sides.FRICTION)
        centres = balance.centres[items]
        bodies = Bodies(layout.weights[items], centres, sizes)
        way = moved(bodies, points, np.where(rough, p.friction, 0.0), p.time)
        corners = layout.lower[items] - centres
        shifts = np.abs(way.shifts + np.cross(way.turns, corners)).max(axis=1)
        turns = np.degrees(np.abs(way.turns)).max(axis=1)
        beyond = np.maximum(shifts / max(p.eps_t, 1e-12), turns / max(p.eps_r, 1e-12))
        worst = int(beyond.argmax())
        if not beyond[worst] > 1.0:
            return None
        shift, turn = float(shifts[worst]), min(float(turns[worst]), 180.0)
        reason = f"item {items[worst]} loses its balance and tips or falls too far in {p.time:g} s"
        return Finding(step, items[worst], shift, turn, reason)

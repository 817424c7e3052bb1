"""Exact equilibrium: do contact forces exist that balance every item, and what if they do not?"""

from __future__ import annotations

import contextlib
import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from steadyload.core.constants import BALANCED, FAILS, STANDS, UNDECIDED, UNRESOLVED
from steadyload.core.constants import VERSION as CORE
from steadyload.core.timed import Followed, How, Moved, first_moved, first_moved_many
from steadyload.engines.attitudes import cross
from steadyload.engines.quantities import quantity
from steadyload.engines.world import GRAVITY
from steadyload.layouts.model.batch import LayoutBatch
from steadyload.layouts.model.contacts import VERSION as CONTACTS
from steadyload.layouts.model.growing import GrowingLayout
from steadyload.layouts.model.layout import TOLERANCE, Arrangement, Layout
from steadyload.methods.contract.declared import MovementLimits, Trait
from steadyload.methods.contract.method import (
    STABLE,
    BatchVerdicts,
    Finding,
    Loader,
    Method,
    Status,
    StepScorer,
    Stopwatch,
)
from steadyload.methods.equilibrium.steps import BalancedSteps, TimedSteps
from steadyload.methods.rules.rule_loading import BalancedLoader
from steadyload.statics.balance import DRAWN_IN, VerticalBalance, inset
from steadyload.statics.balance import VERSION as BALANCE
from steadyload.statics.friction import Sides, unbalanced_item
from steadyload.statics.motion import VERSION as MOTION
from steadyload.statics.motion import Bodies, displacements_after
from steadyload.statics.movement import Movement
from steadyload.statics.resolution import UnresolvedError, fastest, unresolved
from steadyload.statics.touching import touching_points


class Cones(StrEnum):
    """Treatment of friction cones.

    ``linear``: as pyramids inside them, with ``facets`` edges. ``exact``: pyramids inside and
    around them are refined until both give the same answer.
    """

    LINEAR = "linear"
    EXACT = "exact"


@dataclass(frozen=True)
class EquilibriumParameters:
    """Parameters: the forces allowed, and how long an item that lost its balance is followed.

    Raises:
        ValueError: there is a margin with a time, or with forces at sides; or a limit of work
            without a time, or with forces at sides.
    """

    sides: Sides = quantity(Sides.NONE, "contact forces at side faces that touch")
    friction: float = quantity(0.5, "Coulomb friction of a contact", least=0, most=10)
    cones: Cones = quantity(Cones.LINEAR, "how friction cones are treated")
    facets: int = quantity(8, "edges of the pyramid in a friction cone", least=3, most=64)
    time: float | None = quantity(
        None, "how long items that lost their balance are watched; none: any loss is a failure",
        unit="s", least=1e-6, most=1000,
    )  # fmt: skip
    margin: float = quantity(
        0, "draw in contact patches by this on every side: balance within it counts as none",
        unit="cm", least=0, most=10, later=True,
    )  # fmt: skip
    eps_t: float = quantity(10, "with time: displacement that counts as unstable", unit="cm",
                            least=0)  # fmt: skip
    eps_r: float = quantity(10, "with time: angle that counts as unstable", unit="deg", least=0)
    work: float | None = quantity(
        None, "with time: most work on motions of a layout, in squares of the numbers of boxes "
        "solved for; steps beyond it have no verdict; none: no limit",
        least=0, most=1e18, later=True,
    )  # fmt: skip

    def __post_init__(self) -> None:
        if self.margin and (self.time is not None or self.sides is not Sides.NONE):
            raise ValueError("a margin is for vertical forces alone: without time and sides")
        if self.work is not None and (self.time is None or self.sides is not Sides.NONE):
            raise ValueError("a limit of work is for motions: with a time, and without sides")


_AT_ONCE = 32
"""Steps before the first look at the time limit."""

_LATER = 4
"""Steps between two more, while they take less than :data:`_LONG`."""

_LONG = 0.05
"""CPU time of this thread, in which the C library computes [s]."""


_Near = Callable[[Sequence[int], float], Sequence[int]]
"""Of some items and a reach [cm]: at least those that they can meet within it."""


class Equilibrium(Method):
    """Exact equilibrium: the loading fails where no contact forces balance every item.

    A step is stable if non-negative vertical forces exist, at the corners of every contact patch,
    that carry the weight of every item and let none of them tip. That is a linear programme;
    it is solved only where passing the new weight down one way does not prove balance, and where
    the new item does not plainly stick out too far. A centre of mass exactly above an
    edge is balanced, as with SME.

    ``margin`` asks for more: balance with contact patches that are smaller by so much on every
    side; one of which nothing is left carries nothing. A load that needs an edge, or nearly,
    stands for 0.3 s; in the end it falls.

    ``sides`` lets side faces that touch push, too, with or without friction, and then all
    horizontal faces have friction. Full friction accepts jammed states: a box between two others
    and nothing under it "stands" because they could clamp it.

    With ``time``, a step fails only if the items that lost their balance get far enough within it:
    further than ``eps_t`` (the left-bottom-back corner, along one axis) or ``eps_r``, at its end. A
    model of the first moments (:mod:`.equilibrium.motion`) says how far that is: pendulums
    between events, stopped by what is in the way. Every step is judged from the planned positions.
    The displacement and the angle in the verdict are that model's, good up to some 20 degrees.
    ``work`` limits what the motions of a layout may cost, the same on every machine: a loading
    that comes to a step beyond it has no verdict, with status ``timeout``.
    """

    title = "Equilibrium"
    Parameters = EquilibriumParameters
    built_on: ClassVar[Mapping[str, int]] = {
        "core": CORE, "contacts": CONTACTS, "balance": BALANCE, "motion": MOTION
    }  # fmt: skip
    packages = ("numpy", "scipy")

    def parts(self) -> Mapping[str, int]:
        """See :meth:`Method.parts`."""
        drawn = {"drawn in": DRAWN_IN} if self.parameters.margin > TOLERANCE else {}
        return {**super().parts(), **drawn}

    @property
    def traits(self) -> frozenset[Trait]:
        """See :attr:`Method.traits`."""
        exact = frozenset((Trait.STEPWISE, Trait.CENTRES_OF_MASS, Trait.BALANCE))
        return exact if self.parameters.time is None else exact | {Trait.MOVEMENT}

    @property
    def movement_limits(self) -> MovementLimits | None:
        """See :attr:`Method.movement_limits`."""
        own = self.parameters
        return None if own.time is None else MovementLimits(own.time, own.eps_t, own.eps_r)

    def steps(self, layout: Layout, watch: Stopwatch) -> StepScorer:
        """See :meth:`Method.steps`."""
        if self._is_timed:
            return TimedSteps(self, layout, self._loading(layout))
        return BalancedSteps(self, layout)

    @property
    def _is_vertical(self) -> bool:
        """Vertical forces alone decide."""
        return self.parameters.time is None and self.parameters.sides is Sides.NONE

    @property
    def _is_timed(self) -> bool:
        """Vertical forces decide, and items that lost their balance are followed."""
        return self.parameters.time is not None and self.parameters.sides is Sides.NONE

    def evaluate(self, batch: LayoutBatch) -> BatchVerdicts:
        """See :meth:`Method.evaluate`; not with ``sides``.

        Where rounding hides whether forces balance the status is ``error``; :meth:`judge` then
        looks again, for the items of the whole group.
        """
        if self._is_timed:
            moved = first_moved_many(batch.given, self._work, self._motion)
            late = moved["ended"] == UNDECIDED
            open_ = late | (moved["ended"] == UNRESOLVED)
            verdicts = BatchVerdicts.of_steps(batch, moved["step"], unresolved=open_)
            verdicts.status[late] = Status.TIMEOUT
            fails = verdicts.failing_step >= 0
            verdicts.displacement[fails] = moved["shift"][fails]
            verdicts.rotation[fails] = moved["turn"][fails]
            return verdicts
        if not self._is_vertical:
            return super().evaluate(batch)
        found = batch.given.judge(BALANCED, self.parameters.margin)
        unresolved = found["ended"] == UNRESOLVED
        return BatchVerdicts.of_steps(batch, found["step"], unresolved=unresolved)

    @property
    def _motion(self) -> How:
        """How items that lost their balance are followed."""
        p = self.parameters
        return How(p.friction, 100.0 * GRAVITY, p.time or 0.0, p.eps_t, p.eps_r)

    @property
    def _work(self) -> float:
        """The most work on the motions of a layout."""
        return math.inf if self.parameters.work is None else float(self.parameters.work)

    def step_counts(self, layout: Layout) -> tuple[int, int, int]:
        """Number of steps judged, and of those whose motion was kept or asked for.

        Only for ``time`` without ``sides``.
        """
        loading = self._loading(layout)
        step = loading.first(0, len(layout), self._motion).step
        return min(step + 1, len(layout)), int(loading.counts[0]), int(loading.counts[1])

    def _loading(self, layout: Arrangement) -> Followed:
        """A loading of which nothing is placed yet."""
        return Followed(layout.given, limit=self._work)

    def moved(self, step: int, group: NDArray[np.int32], loading: Followed) -> Moved:
        """The motion of a group.

        Args:
            step: the item placed last.
            group: of it, of which something is out of balance.
            loading: with the item.
        """
        return loading.moved(step, group, self._motion)

    def _judge(self, layout: Layout, watch: Stopwatch) -> Finding:
        if self._is_timed:
            return self._judge_motion(layout, watch)
        found = layout.given.judge(BALANCED, self.parameters.margin)
        if found.ended == STANDS:
            return STABLE
        if found.ended == FAILS and self._is_vertical:
            return self._unbalanced(found.step, found.item)
        balance = VerticalBalance(layout, self.parameters.margin)
        for step in range(len(layout)):
            watch.check()
            finding = self.judge_step(layout, balance, step)
            if finding is not None:
                return finding
        return STABLE

    def _judge_motion(self, layout: Arrangement, watch: Stopwatch) -> Finding:
        if len(layout) <= _AT_ONCE:
            found = first_moved(layout.given, self._work, self._motion)
        else:
            loading = self._loading(layout)
            first, at_once = 0, _AT_ONCE
            while first < len(layout):
                begun = time.thread_time()
                end = min(first + at_once, len(layout))
                found = loading.first(first, end, self._motion)
                if found.ended != STANDS:
                    break
                watch.check()
                # Steps that take long are judged one by one, so that a limit is kept.
                first, at_once = end, 1 if time.thread_time() - begun > _LONG else _LATER
        if found.ended == STANDS:
            return STABLE
        if found.ended == UNDECIDED:
            return self.beyond_work(found.step)
        if found.ended == UNRESOLVED:
            group = layout.supports.joined(found.step, floor=False)
            why = f"{unresolved(layout.weights[group])}, or no search for them ended"
            return Finding(status=Status.ERROR, reason=f"step {found.step}: {why}")
        return self._moved(found.step, found.item, found.shift, found.turn)

    def _moved(self, step: int, item: int, displacement: float, rotation: float) -> Finding:
        within = f"{self.parameters.time:g} s"
        reason = f"item {item} loses its balance and tips or falls too far in {within}"
        return Finding(step, item, displacement, rotation, reason)

    def beyond_work(self, step: int) -> Finding:
        """The finding at a step whose motion takes more work than is allowed."""
        why = f"step {step}: motions take more work than work={self._work:g} allows"
        return Finding(status=Status.TIMEOUT, reason=why)

    def begin(self, layout: GrowingLayout) -> Loader:
        """A loader that passes the new weight down, and solves only where that fails."""
        if self._is_vertical:
            return BalancedLoader(
                layout, lambda loaded, watch: self._judge(loaded.layout(), watch),
                self._unbalanced, float(self.parameters.margin),
            )  # fmt: skip
        if self._is_timed:
            return BalancedLoader(layout, self._judge_motion)
        return BalancedLoader(layout, self._judge_last)

    def _judge_last(self, layout: GrowingLayout, watch: Stopwatch) -> Finding:
        """Judge the last step, whatever came of others: forces of its group are found anew."""
        balance, last = VerticalBalance(layout), len(layout) - 1
        for step in balance.group(last)[:-1]:
            watch.check()
            with contextlib.suppress(UnresolvedError):  # with which that step ended
                balance.place(step)
        return self.judge_step(layout, balance, last, layout.beside) or STABLE

    def is_near_its_edge(self, layout: Arrangement, step: int) -> bool:
        """Whether an item on the floor has its centre of mass outside its base, with the margin."""
        margin = self.parameters.margin
        if not margin or layout.lower[step, 1] > TOLERANCE:
            return False
        return bool(inset(layout, step) < margin)

    def judge_step(
        self, layout: Arrangement, balance: VerticalBalance, step: int, near: _Near | None = None
    ) -> Finding | None:
        """The finding at a step, None where it does not fail.

        Args:
            layout: with the step's item, and perhaps later ones.
            balance: of the layout; all steps before have been judged with it.
            step: counts from 0.
            near: which items may be in the way; None for all that have been placed.
        """
        try:
            item = step if self.is_near_its_edge(layout, step) else balance.place(step)
            among = None if item is None else self.braced(layout, step, item)
            if among is None:
                return None
            if self.parameters.time is None:
                return self._unbalanced(step, among)
            far = self.farthest(layout, balance.group(step), step, near)
        except RuntimeError as error:  # the solver's only way to say that it gave up
            return Finding(status=Status.ERROR, reason=f"step {step}: {error}")
        if not far.beyond > 1.0:
            return None
        return self._moved(step, far.item, far.displacement, far.rotation)

    @staticmethod
    def _unbalanced(step: int, item: int) -> Finding:
        reason = f"no contact forces balance item {item} when item {step} is placed"
        return Finding(step, item, reason=reason)

    def braced(self, layout: Arrangement, step: int, item: int) -> int | None:
        """The item that forces at sides, where requested, do not balance either; None for none.

        Args:
            layout: any layout.
            step: the item placed last.
            item: the one that vertical forces alone do not balance.
        """
        p = self.parameters
        if p.sides is Sides.NONE:
            return item
        exact = p.cones is Cones.EXACT
        return unbalanced_item(layout, step, p.sides, p.friction, p.facets, exact=exact)

    def farthest(
        self, layout: Arrangement, items: Sequence[int], step: int, near: _Near | None = None
    ) -> Movement:
        """The item of a group that gets furthest within the time.

        Items beside the group are in the way and do not move. Letting those move, too, that the
        group leans on was tried: four times the cost, and no more verdicts right.

        Args:
            layout: any layout.
            items: the group, of which something is out of balance.
            step: the item placed last.
            near: which items may be in the way; None for all that have been placed.
        """
        p = self.parameters
        lower, upper = layout.lower[items], layout.upper[items]
        sizes, centres = upper - lower, 0.5 * (lower + upper) + layout.mass_offsets[items]
        # How far a corner can come before its item counts as moved.
        turned = 2.0 * math.sin(0.5 * math.radians(min(p.eps_r, 180.0)))
        reach = p.eps_t + turned * float(np.sqrt((sizes**2).sum(axis=1)).max())
        among = range(step + 1) if near is None else near(items, reach)
        others = sorted(set(among).difference(items))
        points = touching_points(layout, items, others, reach=reach)
        rough = (points.axes == 1) | (p.sides is Sides.FRICTION)
        bodies = Bodies(layout.weights[items], centres, sizes)
        way = displacements_after(bodies, points, np.where(rough, p.friction, 0.0), p.time)
        shifts = np.abs(way.shifts + cross(way.turns, lower - centres)).max(axis=1)
        turns = np.degrees(np.abs(way.turns)).max(axis=1)
        beyond = np.maximum(shifts / max(p.eps_t, 1e-12), turns / max(p.eps_r, 1e-12))
        worst = fastest(beyond)
        turn = min(float(turns[worst]), 180.0)
        return Movement(items[worst], float(shifts[worst]), turn, float(beyond[worst]))

"""Placements in an engine's world, one at a time: the parts of the loading loop."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from steadyload.engines.registry import open_world
from steadyload.engines.world import Box, FixedStepWorld, FloatArray, Poses, WorldSettings
from steadyload.layouts.model.question import Question
from steadyload.methods.contract.method import Effort, Finding, Phase, Status, Stopwatch
from steadyload.methods.simulation.criteria import Examiner, Indices
from steadyload.methods.simulation.foresight import Foresight
from steadyload.methods.simulation.scene import CM, Neighbourhood
from steadyload.methods.simulation.scene import fixed as as_fixed
from steadyload.methods.simulation.simulation_parameters import (
    STILL,
    BetweenSteps,
    SimulationParameters,
)

REST = 1
"""Of what is at rest at the end of a placement: raised when something else is."""

_SUBSTEPS_BETWEEN_LOOKS_AT_THE_CLOCK = 10

_PATIENCE = 3.0
"""A placement is at rest no earlier than after this many times the free fall to the rest speed."""

_BEHIND = 0.3
"""Whether something gets anywhere is seen by comparison with where it was so long before [s]."""

_RATTLE = 0.01
"""What has moved by no more of a threshold in that time rattles in its place."""

_FIXED = -1

NOTHING: Indices = np.zeros(0, dtype=np.intp)


class Placements:
    """Simulates placements of boxes, one at a time.

    Args:
        engine: its registered name.
        parameters: those of the method on that engine.
        items: at their planned poses; may grow.
        examiner: looks at them at every sample.
        watch: of the judgement.
        surroundings: fixed boxes that stand in every world before any item does.
        subsets: where only some items take part, keep one world with all of them.
    """

    def __init__(
        self,
        engine: str,
        parameters: SimulationParameters,
        items: list[Box],
        examiner: Examiner,
        watch: Stopwatch,
        *,
        surroundings: Sequence[Box] = (),
        subsets: bool = False,
    ) -> None:
        self.engine, self.parameters, self.watch = engine, parameters, watch
        self.items, self.examiner = items, examiner
        reseat = parameters.between_steps is BetweenSteps.RESEAT
        settings = parameters.world_settings()
        self._stage = _Stage(
            engine, settings, items, list(surroundings), reseat=reseat, subsets=subsets
        )
        self._substeps = self._body_substeps = self._looks = 0
        self._looked_at: tuple[FixedStepWorld, Indices] | None = None
        self._beyond = 0.0
        self._behind = max(1, round(_BEHIND * parameters.samples / parameters.t_max))
        # Whatever is going to move needs some time to become faster than the speed of rest.
        fall = _PATIENCE * parameters.rest_speed / parameters.gravity if parameters.gravity else 0.0
        self._patience = max(1, math.ceil(fall * parameters.frequency))

    @property
    def effort(self) -> Effort:
        """Effort of everything simulated so far."""
        stage = self._stage
        return Effort(stage.worlds, stage.boxes, self._looks, self._substeps, self._body_substeps)

    def among_all(self, step: int) -> Finding | None:
        """Place an item among all that have been placed; a finding when something moves too far."""
        return self._settle(step, np.arange(step + 1))

    def locally(self, step: int, part: Neighbourhood) -> Finding | None:
        """The same in ``scope=local`` and ``moving``, among what the placement can affect."""
        return self._settle(step, part.free, part.fixed)

    def widening(
        self, step: int, group: Indices, *, on_floor: bool, carried: bool
    ) -> Finding | None:
        """The same in ``scope=widening``.

        Args:
            step: the item.
            group: it and all that are joined to it by standing on each other.
            on_floor: the item stands on the floor with all of its base.
            carried: every item of the group stands on the floor or on another.
        """
        self.forget()
        alone = len(group) == 1 and on_floor
        # An item over a gap would fall past the items below it, and might rest on the floor.
        apart = len(group) <= step and carried
        if alone or (apart and self._rests(step, group)):
            return None
        return self.among_all(step)

    def beyond(self) -> float:
        """Largest movement of an item after the last placement, in units of its threshold."""
        if self._looked_at is None:
            return self._beyond
        world, items = self._looked_at
        return self.examiner.most_moved(self.poses(world), items).beyond

    def looked_at(self) -> Poses:
        """Poses of the items of the last placement that was simulated, free ones first."""
        assert self._looked_at is not None, "something was simulated"
        return self.poses(self._looked_at[0])

    def forget(self, beyond: float = 0.0) -> None:
        """Forget the last placement that was simulated.

        Args:
            beyond: what :meth:`beyond` says until the next one is.
        """
        self._looked_at, self._beyond = None, beyond

    def surround(self, boxes: Sequence[Box]) -> None:
        """Have these fixed boxes in every world from now on."""
        self.close()
        self._stage.surroundings = list(boxes)

    def poses(self, world: FixedStepWorld) -> Poses:
        """Poses of the items that take part."""
        first = len(self._stage.surroundings)
        centres, quaternions = world.poses()
        return Poses(centres[first:], quaternions[first:])

    def start(self, watch: Stopwatch) -> None:
        """Another judgement begins: its time and effort count from here."""
        self.watch = watch
        self._substeps = self._body_substeps = self._looks = 0
        self._stage.worlds = self._stage.boxes = 0

    def close(self) -> None:
        """Give back the world, if there is one; the next placement opens another."""
        self.watch.enter(Phase.BUILD)
        self._stage.close()
        self._looked_at = None

    def _rests(self, step: int, items: Indices) -> bool:
        """True if these items come to rest by themselves, within the limits.

        Gives up on items that speed up: they need not be watched to the end.
        """
        p = self.parameters
        world = self._hold(items)
        self._looked_at = world, items
        start, speed, calm = self._substeps, math.inf, 0
        foresight = self._foresight()
        for _ in range(p.samples):
            executed = self._step(world, p.t_max / p.samples)
            if not executed or self._substeps - start < self._patience:
                continue
            before, speed = speed, self._fastest(world)
            if speed >= p.rest_speed and speed > before:
                return False
            calm = calm + 1 if speed < p.rest_speed else 0
            poses = None
            if foresight is not None:
                poses = self._read(world)
                moved = self.examiner.moved_along(poses, items)
                if foresight.is_safe((self._substeps - start) / p.frequency, moved):
                    return self._examine(step, world, items, poses=poses) is None
            if p.ends_at_rest and calm == p.rest_samples:
                return self._examine(step, world, items, poses=poses) is None
        return False

    def _settle(self, step: int, items: Indices, fixed: Indices = NOTHING) -> Finding | None:
        """Simulate one placement; a finding when something moves too far."""
        p = self.parameters
        world = self._hold(items, fixed)
        items = np.concatenate((items, fixed))
        self._looked_at = world, items
        any_sample = p.any_sample
        foresight = self._foresight()
        before = None
        calm = 0
        start = self._substeps
        for sample in range(1, p.samples + 1):
            last = sample == p.samples
            executed = self._step(world, p.t_max / p.samples)
            if not executed and not last:
                continue
            if p.question == Question.STANDS and sample == p.samples - self._behind:
                before = self.poses(world)
            poses = None
            if p.ends_at_rest and not last and self._substeps - start >= self._patience:
                calm = calm + 1 if self._fastest(world) < p.rest_speed else 0
                if calm == p.rest_samples:
                    return self._examine(step, world, items)
            if foresight is not None and not last:
                poses = self._read(world)
                moved = self.examiner.moved_along(poses, items)
                if foresight.is_safe((self._substeps - start) / p.frequency, moved):
                    return self._examine(step, world, items, poses=poses)
            # Items at rest give no reason to end early.
            excess = 1.0 if last or any_sample else 0.0 if calm else p.early_exit
            if excess:
                finding = self._examine(step, world, items, excess, poses)
                if finding is not None:
                    return finding
        if p.question == Question.STANDS:
            return self._unsettled(step, world, items, before)
        return None

    def _unsettled(
        self, step: int, world: FixedStepWorld, items: Indices, before: Poses | None
    ) -> Finding | None:
        """A finding where something still moves at the end of a placement.

        What is fast and gets nowhere rattles in its place: stiff contacts make it do so.
        """
        speeds = self._speeds(world)
        if not np.isfinite(speeds).all():
            reason = f"speeds became non-finite when item {step} was placed"
            return Finding(status=Status.DIVERGED, reason=reason)
        fast = speeds >= (self.parameters.rest_speed or STILL)
        if fast.any() and before is not None:
            fast &= self.examiner.between(before, self.poses(world), items) > _RATTLE
        if not fast.any():
            return None
        speeds = np.where(fast, speeds, 0.0)
        worst = int(speeds.argmax())
        item = int(items[worst])
        return Finding(
            status=Status.UNSETTLED,
            moved_item=item,
            reason=f"item {item} still moves, by {1e3 * speeds[worst]:.1f} mm/s, "
            f"{self.parameters.t_max:g} s after item {step} was placed",
        )

    def _foresight(self) -> Foresight | None:
        """Of a placement that begins, where it may end early by what is foreseen."""
        p = self.parameters
        return Foresight(p.early_stop, p.t_max, p.eps_t * CM) if p.early_stop else None

    def _hold(self, items: Indices, fixed: Indices = NOTHING) -> FixedStepWorld:
        self.watch.enter(Phase.BUILD)
        return self._stage.hold(items.tolist(), fixed.tolist())

    def _step(self, world: FixedStepWorld, duration: float) -> int:
        """Step ``duration`` seconds; under a timeout in parts, with a look at the clock after each.

        The parts add up to the same substeps: the clock of a world counts exactly.
        """
        self.watch.enter(Phase.STEP)
        length, parts = 1.0 / self.parameters.frequency, 1
        if self.watch.timeout is not None:
            parts = math.ceil(duration / length / _SUBSTEPS_BETWEEN_LOOKS_AT_THE_CLOCK)
        limit = math.ceil(duration / length) + 1
        before = self._substeps
        for _ in range(parts):
            executed = world.stepSimulation(duration / parts, limit, length).executed
            self._substeps += executed
            self._body_substeps += executed * self._stage.taking_part
            self.watch.check()
        return self._substeps - before

    def _read(self, world: FixedStepWorld) -> Poses:
        self.watch.enter(Phase.READ)
        self._looks += 1
        return self.poses(world)

    def _examine(
        self,
        step: int,
        world: FixedStepWorld,
        items: Indices,
        excess: float = 1.0,
        poses: Poses | None = None,
    ) -> Finding | None:
        """The examiner's finding on these poses, by default on those of now."""
        return self.examiner.examine(step, poses or self._read(world), items, excess)

    def _fastest(self, world: FixedStepWorld) -> float:
        """The largest speed of any item [m/s]; see :meth:`_speeds`."""
        return float(self._speeds(world).max())

    def _speeds(self, world: FixedStepWorld) -> FloatArray:
        """Speeds of items [m/s], shape (n,): of the centre of mass plus a turn's, 10 cm from it."""
        self.watch.enter(Phase.READ)
        self._looks += 1
        linear, angular = world.speeds()[len(self._stage.surroundings) :].T
        found: FloatArray = linear + 0.1 * angular
        return found


class _Stage:
    """The world that items are placed in: one at a time, kept while the next items only add to it.

    Args:
        engine: registered name.
        settings: of every world.
        items: all items of the layout.
        surroundings: fixed boxes of every world, its first.
        reseat: put those that stay back to their planned poses.
        subsets: keep one world, with items that do not take part; needs ``reseat``.
    """

    def __init__(
        self,
        engine: str,
        settings: WorldSettings,
        items: list[Box],
        surroundings: list[Box],
        *,
        reseat: bool,
        subsets: bool,
    ) -> None:
        self._engine, self._settings, self._items = engine, settings, items
        self._reseat, self._subsets = reseat, subsets
        self.surroundings = surroundings
        self._world: FixedStepWorld | None = None
        self._held: list[int] = []
        self.worlds = self.boxes = self.taking_part = 0

    def hold(self, free: list[int], fixed: list[int]) -> FixedStepWorld:
        """A world with these items in this order, as planned and ready to be stepped.

        Without ``reseat``, items that are in it already are where they have come to.
        """
        # In the order of all items whichever is asked for first, as engines take them in order.
        wanted = list(range(free[-1] + 1)) if self._subsets else free
        held, partly = self._held, len(free) < len(wanted)
        if self._world is None or fixed or wanted[: len(held)] != held:
            self.close()
            self._world = open_world(self._engine, self._settings)
            self.worlds += 1
            for box in self.surroundings:
                self._world.add_box(box)
            self.boxes += len(self.surroundings)
        elif self._reseat and held and not partly:
            self._world.reset_poses()
        for index in wanted[len(self._held) :]:
            self._world.add_box(self._items[index])
        for index in fixed:
            self._world.add_box(as_fixed(self._items[index]))
        self.boxes += len(wanted) - len(self._held) + len(fixed)
        # Fixed boxes come last, and nothing can be added before them.
        self._held = wanted + [_FIXED] * len(fixed)
        around = len(self.surroundings)
        self.taking_part = around + len(free) + len(fixed)
        if partly:
            chosen = [*range(around), *(around + index for index in free)]
            self._world.reset_poses(only=chosen)
        self._world.prepare()
        return self._world

    def close(self) -> None:
        """Give back the world, if there is one."""
        if self._world is not None:
            self._world.close()
        self._world, self._held = None, []

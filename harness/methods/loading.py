"""Algorithm 1 of the paper: the one loading loop, over any engine."""

from __future__ import annotations

import math
from functools import cached_property

import numpy as np

from engines.registry import open_world, world_class
from engines.world import Box, FixedStepWorld, WorldSettings
from harness.layouts.contacts import Contacts, find_contacts
from harness.layouts.model import Layout
from harness.methods.criteria import Criterion, Examiner, Indices
from harness.methods.method import STABLE, Effort, Finding, Phase, RefusedError, Stopwatch
from harness.methods.scene import (
    Across,
    boxes,
    joined_groups,
    neighbourhood,
    planar_scene,
)
from harness.methods.scene import fixed as as_fixed
from harness.methods.simulation_parameters import BetweenSteps, Scope, SimulationParameters

_SUBSTEPS_BETWEEN_LOOKS_AT_THE_CLOCK = 10

_PATIENCE = 3.0
"""A placement is at rest no earlier than after this many times the free fall to the rest speed."""

_FIXED = -1

NOTHING: Indices = np.zeros(0, dtype=np.intp)


class Loading:
    """One run of Algorithm 1.

    Args:
        layout: what is loaded.
        engine: the engine's registered name.
        parameters: those of the method on that engine.
        watch: of the judgement.
        examiner: looks at the items at every sample; the default examines as ``parameters`` say.

    Raises:
        RefusedError: the engine has two dimensions and the layout is not planar.
    """

    def __init__(
        self,
        layout: Layout,
        engine: str,
        parameters: SimulationParameters,
        watch: Stopwatch,
        examiner: type[Examiner] = Examiner,
    ) -> None:
        self.layout, self.engine, self.parameters, self.watch = layout, engine, parameters, watch
        across: Across = "width"
        if world_class(engine).capabilities.dimensions == 2:
            scene = planar_scene(layout)
            if scene.across is None:
                raise RefusedError(scene.reason)
            across = scene.across
        self.across = across
        self.items = boxes(
            layout,
            across=across,
            shrink=parameters.shrink,
            jitter=parameters.jitter,
            seed=parameters.seed,
        )
        self.examiner = examiner(
            self.items, parameters.criterion, parameters.eps_t, parameters.eps_r
        )
        reseat = parameters.between_steps is BetweenSteps.RESEAT
        subsets = parameters.scope is Scope.WIDENING and world_class(engine).capabilities.subsets
        self._stage = _Stage(
            engine, parameters.world_settings(), self.items, reseat=reseat, subsets=subsets
        )
        self._ways = {
            Scope.ALL: self._place_among_all,
            Scope.LOCAL: self._place_locally,
            Scope.WIDENING: self._place_widening,
        }
        self._looked_at: tuple[FixedStepWorld, Indices] | None = None
        self._substeps = self._body_substeps = self._looks = 0
        # Whatever is going to move needs some time to become faster than the speed of rest.
        fall = _PATIENCE * parameters.rest_speed / parameters.gravity if parameters.gravity else 0.0
        self._patience = max(1, math.ceil(fall * parameters.frequency))

    @cached_property
    def _reach(self) -> float:
        """How far a corner of any item can come before it counts as moved [cm]."""
        p = self.parameters
        sides = self.layout.upper - self.layout.lower
        diagonal = float(np.sqrt((sides * sides).sum(axis=1)).max())
        return p.eps_t + 2.0 * math.sin(math.radians(min(p.eps_r, 180.0)) / 2.0) * diagonal

    @property
    def effort(self) -> Effort:
        """What has been simulated so far."""
        stage = self._stage
        return Effort(stage.worlds, stage.boxes, self._looks, self._substeps, self._body_substeps)

    def load(self) -> Finding:
        """Place item after item until one moves or all stand."""
        try:
            for step in range(len(self.items)):
                finding = self.place(step)
                if finding is not None:
                    return finding
            return STABLE
        finally:
            self.close()

    def place(self, step: int) -> Finding | None:
        """Place one item; a finding when something moves too far.

        Args:
            step: above that of the placement before. Where the state is carried over, the next one;
                where items are reseated any, and the items left out are put where they are planned.
        """
        self._looked_at = None
        # What diverges may overflow on its way; that it did is found out when it is examined.
        with np.errstate(over="ignore", invalid="ignore"):
            return self._ways[self.parameters.scope](step)

    def beyond(self) -> float:
        """How far the item furthest from its plan is after the last placement, in thresholds."""
        if self._looked_at is None:
            return 0.0
        world, items = self._looked_at
        return self.examiner.most_moved(world.poses(), items).beyond

    def close(self) -> None:
        """Give back the world."""
        self.watch.enter(Phase.BUILD)
        self._stage.close()
        self._looked_at = None

    def _place_among_all(self, step: int) -> Finding | None:
        return self._settle(step, np.arange(step + 1))

    def _place_locally(self, step: int) -> Finding | None:
        part = neighbourhood(self.layout, self._groups[step], self._reach)
        return self._settle(step, part.free, part.fixed)

    def _place_widening(self, step: int) -> Finding | None:
        contacts, group = self._contacts, self._groups[step]
        carried = contacts.on_floor | contacts.carries[: step + 1].any(axis=0)
        alone = len(group) == 1 and contacts.on_floor[step]
        # What hangs over a gap would fall past what is below it, and might rest on the floor.
        apart = len(group) <= step and carried[group].all()
        if alone or (apart and self._rests(step, group)):
            return None
        return self._place_among_all(step)

    @cached_property
    def _contacts(self) -> Contacts:
        return find_contacts(self.layout)

    @cached_property
    def _groups(self) -> list[Indices]:
        return joined_groups(self._contacts)

    def _rests(self, step: int, items: Indices) -> bool:
        """Whether these items come to rest by themselves, within the limits.

        Gives up on items that speed up: they need not be watched to the end.
        """
        p = self.parameters
        world = self._hold(items)
        self._looked_at = world, items
        start, speed = self._substeps, math.inf
        for _ in range(p.samples):
            executed = self._step(world, p.t_max / p.samples)
            if not executed or self._substeps - start < self._patience:
                continue
            before, speed = speed, self._fastest(world)
            if speed >= p.rest_speed and speed > before:
                return False
            if speed < p.rest_speed and before < p.rest_speed:
                return self._examine(step, world, items) is None
        return False

    def _settle(self, step: int, items: Indices, fixed: Indices = NOTHING) -> Finding | None:
        """Simulate one placement; a finding when something moves too far."""
        p = self.parameters
        world = self._hold(items, fixed)
        items = np.concatenate((items, fixed))
        self._looked_at = world, items
        any_sample = p.criterion is Criterion.PAPER
        calm = False
        start = self._substeps
        for sample in range(1, p.samples + 1):
            last = sample == p.samples
            executed = self._step(world, p.t_max / p.samples)
            if not executed and not last:
                continue
            if p.rest_speed and not last and self._substeps - start >= self._patience:
                was_calm, calm = calm, self._fastest(world) < p.rest_speed
                if was_calm and calm:
                    return self._examine(step, world, items)
            # What is calm has no reason to end early.
            excess = 1.0 if last or any_sample else 0.0 if calm else p.early_exit
            if excess:
                finding = self._examine(step, world, items, excess)
                if finding is not None:
                    return finding
        return None

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

    def _examine(
        self, step: int, world: FixedStepWorld, items: Indices, excess: float = 1.0
    ) -> Finding | None:
        self.watch.enter(Phase.READ)
        self._looks += 1
        return self.examiner.examine(step, world.poses(), items, excess)

    def _fastest(self, world: FixedStepWorld) -> float:
        """The largest speed of any item [m/s]: of its centre of mass, or a point 10 cm from it."""
        self.watch.enter(Phase.READ)
        self._looks += 1
        linear, angular = world.speeds().T
        return float((linear + 0.1 * angular).max())


class _Stage:
    """The world that items are placed in: one at a time, kept while the next items only add to it.

    Args:
        engine: registered name.
        settings: of every world.
        items: all items of the layout.
        reseat: put those that stay back to their planned poses.
        subsets: keep one world, with items that do not take part; needs ``reseat``.
    """

    def __init__(
        self, engine: str, settings: WorldSettings, items: list[Box], *, reseat: bool, subsets: bool
    ) -> None:
        self._engine, self._settings, self._items = engine, settings, items
        self._reseat, self._subsets = reseat, subsets
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
        elif self._reseat and held and not partly:
            self._world.reset_poses()
        for index in wanted[len(self._held) :]:
            self._world.add_box(self._items[index])
        for index in fixed:
            self._world.add_box(as_fixed(self._items[index]))
        self.boxes += len(wanted) - len(self._held) + len(fixed)
        # Fixed boxes come last, and nothing can be added before them.
        self._held = wanted + [_FIXED] * len(fixed)
        self.taking_part = len(free) + len(fixed)
        if partly:
            self._world.reset_poses(only=free)
        self._world.prepare()
        return self._world

    def close(self) -> None:
        """Give back the world, if there is one."""
        if self._world is not None:
            self._world.close()
        self._world, self._held = None, []

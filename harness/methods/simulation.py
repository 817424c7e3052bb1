"""Algorithm 1 of the paper: the one loading loop, over any engine."""

from __future__ import annotations

import dataclasses
import math
import typing
from dataclasses import dataclass, field
from enum import StrEnum
from functools import cache

import numpy as np

from engines.quantities import quantity
from engines.registry import engine_options, open_world, world_class
from engines.world import SETTINGS, BroadPhase, EngineError, World, WorldSettings
from harness.layouts.contacts import find_contacts
from harness.layouts.model import Layout
from harness.methods.criteria import Criterion, Examiner, Indices
from harness.methods.method import (
    STABLE,
    Finding,
    Method,
    Phase,
    RefusedError,
    Status,
    Stopwatch,
    TimeoutExpiredError,
    Trait,
)
from harness.methods.scene import Across, boxes, fixed, neighbourhood, planar_scene

_SUBSTEPS_BETWEEN_LOOKS_AT_THE_CLOCK = 10

_PATIENCE = 3.0
"""A placement is at rest no earlier than after this many times the free fall to the rest speed."""


class BetweenSteps(StrEnum):
    """What happens between two placements.

    ``carry``: the state goes on (Algorithm 1 as printed). ``reseat``: every item goes back to its
    planned pose, at rest (the authors' code, and the way their labels were made).
    """

    CARRY = "carry"
    RESEAT = "reseat"


class Scope(StrEnum):
    """Which items are simulated when one is placed.

    ``all``: all that have been placed. ``local``: those joined to the new one by standing on each
    other; items beside them are fixed, as far as a corner can come before the verdict, and the
    others are left out. What is fixed stops others and cannot be pushed over itself: a light stack
    that a heavy neighbour leans on looks firmer than it is. Needs ``between_steps=reseat``.
    """

    ALL = "all"
    LOCAL = "local"


@dataclass(frozen=True)
class SimulationParameters:
    """Table 3 of the paper and what it leaves open, in its units.

    Raises:
        ValueError: ``t_max`` is shorter than one substep, the scope is local without reseating, or
            there is an early exit below the threshold or with the criterion ``paper``.
    """

    t_max: float = quantity(0.3, "simulated time a placement", unit="s", least=1e-6, most=1000)
    frequency: float = quantity(240, "substeps a second", unit="Hz", least=1, most=1e6)
    eps_t: float = quantity(10, "displacement that counts as unstable", unit="cm", least=0)
    eps_r: float = quantity(10, "angle that counts as unstable", unit="deg", least=0)
    friction: float = quantity(0.5, "Coulomb friction of a contact", least=0, most=10)
    restitution: float = quantity(0, "restitution of a contact", least=0, most=1)
    linear_damping: float = quantity(
        0, "share of linear velocity lost a second", least=0, most=0.999999
    )
    angular_damping: float = quantity(
        0, "share of angular velocity lost a second", least=0, most=0.999999
    )
    margin: float = quantity(0, "collision margin", unit="m", least=0, most=1)
    broad_phase: BroadPhase | None = quantity(None, "broad-phase collision detection")
    solver_iterations: int | None = quantity(
        None, "iterations of the contact solver", least=1, most=100_000
    )
    gravity: float = quantity(9.8, "gravitational acceleration", unit="m/s2", least=0, most=1000)
    between_steps: BetweenSteps = quantity(BetweenSteps.CARRY, "state between two placements")
    criterion: Criterion = quantity(Criterion.PAPER, "when an item counts as moved")
    samples: int = quantity(
        10, "looks at the items a placement, the last at its end", least=1, most=100_000
    )
    shrink: float = quantity(
        0, "draw in side faces by this, so that neighbours do not touch", unit="m", least=0, most=1
    )
    jitter: float = quantity(
        0, "displace every item at random by up to this, along every axis", unit="m", least=0,
        most=1,
    )  # fmt: skip
    seed: int = quantity(0, "seed of the jitter", least=0, most=2**31)
    rest_speed: float = quantity(
        0, "end a placement when nothing is faster at two samples in a row; 0: never",
        unit="m/s", least=0, most=1000,
    )  # fmt: skip
    early_exit: float = quantity(
        0, "criterion adams: end at a sample beyond this multiple of a threshold; 0: never", least=0
    )
    scope: Scope = quantity(Scope.ALL, "which items are simulated when one is placed")
    emulate: frozenset[str] = quantity(
        frozenset(),
        "settings to imitate where an engine can do so only at a price",
        choices=SETTINGS,
    )

    def __post_init__(self) -> None:
        if self.t_max * self.frequency < 1.0 - 1e-9:
            raise ValueError(
                f"t_max times frequency is {self.t_max * self.frequency:g} substeps a placement; "
                "allowed: 1 or more"
            )
        if self.scope is Scope.LOCAL and self.between_steps is BetweenSteps.CARRY:
            raise ValueError("scope=local needs between_steps=reseat")
        if 0.0 < self.early_exit < 1.0:
            raise ValueError(f"early_exit is {self.early_exit:g}; allowed: 0, or 1 or more")
        if self.early_exit and self.criterion is Criterion.PAPER:
            raise ValueError("early_exit needs criterion=adams: with paper every sample may end it")

    def world_settings(self) -> WorldSettings:
        """The part of the parameters that a world is made with."""
        shared = {name: getattr(self, name) for name in (*SETTINGS, "emulate")}
        gravity = (0.0, 0.0, -self.gravity)
        return WorldSettings(**shared, gravity=gravity, options=self._options())

    def _options(self) -> object | None:
        return None


@cache
def _parameters_on(engine: str) -> type[SimulationParameters]:
    """The parameters of a simulation, and after them those that this engine alone has."""
    options = engine_options(engine)
    if options is None:
        return SimulationParameters
    own, hints = dataclasses.fields(options), typing.get_type_hints(options)

    def make_options(parameters: SimulationParameters) -> object:
        return options(**{f.name: getattr(parameters, f.name) for f in own})

    def check(parameters: SimulationParameters) -> None:
        SimulationParameters.__post_init__(parameters)
        make_options(parameters)

    return dataclasses.make_dataclass(
        f"SimulationParameters_{engine}",
        [(f.name, hints[f.name], field(default=f.default, metadata=f.metadata)) for f in own],
        bases=(SimulationParameters,),
        namespace={"_options": make_options, "__post_init__": check},
        frozen=True,
    )


class Simulation(Method):
    """Loading stability by rigid-body simulation (Algorithm 1, Eq. 6 and 7).

    Items are added one after the other. After each, the world is stepped for ``t_max`` seconds and
    looked at ``samples`` times; the first sample at which an item violates the criterion ends the
    loading. The printed algorithm looks before it steps and never after the last item: a slip, not
    a rule, and not followed here. A 2-D engine refuses layouts that are not planar.
    """

    Parameters = SimulationParameters
    needs_engine = True

    @classmethod
    def parameters_on(cls, engine: str | None) -> type[SimulationParameters]:
        """See :meth:`Method.parameters_on`: an engine's own options are parameters, too."""
        return SimulationParameters if engine is None else _parameters_on(engine)

    @property
    def traits(self) -> frozenset[Trait]:
        """See :attr:`Method.traits`."""
        return frozenset((Trait.STEPWISE, Trait.CENTRES_OF_MASS, Trait.BALANCE, Trait.MOVEMENT))

    @property
    def _engine(self) -> str:
        assert self.spec.engine is not None, "make_method asks for an engine"
        return self.spec.engine

    def prepare(self, item_count: int = 0) -> None:
        """Import the engine and warm it up.

        Raises:
            EngineNotInstalledError: its library is missing.
        """
        world_class(self._engine).warm_up(item_count)

    def _judge(self, layout: Layout, watch: Stopwatch) -> Finding:
        watch.enter(Phase.BUILD)
        settings = self.parameters.world_settings()
        run = Loading(layout, self._engine, self.parameters, watch)
        try:
            finding = run.load()
        except EngineError as error:
            finding = Finding(status=Status.ERROR, reason=str(error))
        except TimeoutExpiredError as error:
            finding = Finding(status=Status.TIMEOUT, reason=str(error))
        facts = world_class(self._engine).capabilities
        return dataclasses.replace(
            finding,
            ignored=facts.ignored(settings),
            emulated=facts.emulated(settings),
            substeps=run.substeps,
        )


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
        self.settings = parameters.world_settings()
        self.substeps = 0
        across: Across = "width"
        if world_class(engine).capabilities.dimensions == 2:
            scene = planar_scene(layout)
            if scene.across is None:
                raise RefusedError(scene.reason)
            across = scene.across
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

    def _reach(self) -> float:
        """How far a corner of any item can come before it counts as moved [cm]."""
        p = self.parameters
        sides = self.layout.upper - self.layout.lower
        diagonal = float(np.sqrt((sides * sides).sum(axis=1)).max())
        return p.eps_t + 2.0 * math.sin(math.radians(min(p.eps_r, 180.0)) / 2.0) * diagonal

    def load(self) -> Finding:
        """Place item after item until one moves or all stand."""
        if self.parameters.scope is Scope.LOCAL:
            return self._load_locally()
        reseat = self.parameters.between_steps is BetweenSteps.RESEAT
        world = open_world(self.engine, self.settings)
        try:
            for step, item in enumerate(self.items):
                self.watch.enter(Phase.BUILD)
                world.add_box(item)
                world.prepare()
                finding = self._settle(step, world, slice(step + 1))
                if finding is not None:
                    return finding
                self.watch.enter(Phase.BUILD)
                if reseat:
                    world.reset_poses()
            return STABLE
        finally:
            self.watch.enter(Phase.BUILD)
            world.close()

    def _load_locally(self) -> Finding:
        contacts, reach = find_contacts(self.layout), self._reach()
        for step in range(len(self.items)):
            self.watch.enter(Phase.BUILD)
            part = neighbourhood(self.layout, contacts, step, reach)
            world = open_world(self.engine, self.settings)
            try:
                for index in part.free:
                    world.add_box(self.items[index])
                for index in part.fixed:
                    world.add_box(fixed(self.items[index]))
                world.prepare()
                items = np.concatenate((part.free, part.fixed))
                finding = self._settle(step, world, items)
                if finding is not None:
                    return finding
            finally:
                self.watch.enter(Phase.BUILD)
                world.close()
        return STABLE

    def _settle(self, step: int, world: World, items: Indices) -> Finding | None:
        """Simulate one placement; a finding when something moves too far."""
        p = self.parameters
        any_sample = p.criterion is Criterion.PAPER
        # Whatever is going to move needs some time to become faster than the speed of rest.
        patience = math.ceil(_PATIENCE * p.rest_speed / p.gravity * p.frequency) if p.gravity else 1
        calm = False
        before = self.substeps
        for sample in range(1, p.samples + 1):
            last = sample == p.samples
            executed = self._step(world, p.t_max / p.samples)
            excess = 1.0 if last or any_sample else p.early_exit
            if excess and (executed or last):
                self.watch.enter(Phase.READ)
                finding = self.examiner.examine(step, world.poses(), items, excess)
                if finding is not None:
                    return finding
            if p.rest_speed and executed and not last and self.substeps - before >= patience:
                self.watch.enter(Phase.READ)
                was_calm, calm = calm, _fastest(world) < p.rest_speed
                if was_calm and calm:
                    return self.examiner.examine(step, world.poses(), items)
        return None

    def _step(self, world: World, duration: float) -> int:
        """Step ``duration`` seconds; under a timeout in parts, with a look at the clock after each.

        The parts add up to the same substeps: the clock of a world counts exactly.
        """
        self.watch.enter(Phase.STEP)
        length, parts = 1.0 / self.parameters.frequency, 1
        if self.watch.timeout is not None:
            parts = math.ceil(duration / length / _SUBSTEPS_BETWEEN_LOOKS_AT_THE_CLOCK)
        limit = math.ceil(duration / length) + 1
        before = self.substeps
        for _ in range(parts):
            self.substeps += world.stepSimulation(duration / parts, limit, length).executed
            self.watch.check()
        return self.substeps - before


def _fastest(world: World) -> float:
    """The largest speed of any item [m/s]: of its centre of mass, or of a point 10 cm from it."""
    linear, angular = world.velocities()
    speeds = np.sqrt((linear * linear).sum(axis=1)) + 0.1 * np.sqrt((angular * angular).sum(axis=1))
    return float(speeds.max())

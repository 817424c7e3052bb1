"""Loading stability by rigid-body simulation, as a method."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Mapping
from typing import Any, ClassVar

from steadyload.engines.registry import numerics, warm_up, world_class
from steadyload.engines.world import VERSION as WORLD
from steadyload.engines.world import EngineError
from steadyload.layouts.model.contacts import VERSION as CONTACTS
from steadyload.layouts.model.growing import GrowingLayout
from steadyload.layouts.model.layout import Layout
from steadyload.layouts.model.question import Question
from steadyload.methods.contract.declared import MovementLimits, Trait
from steadyload.methods.contract.method import (
    Effort,
    Finding,
    Loader,
    Method,
    NotStepwiseError,
    Phase,
    Status,
    StepScorer,
    Stopwatch,
    TimeoutExpiredError,
)
from steadyload.methods.simulation.foresight import VERSION as FORESIGHT
from steadyload.methods.simulation.loading import VERSION as LOADING
from steadyload.methods.simulation.loading import GrowingLoading, Loading
from steadyload.methods.simulation.moving import VERSION as MOVING
from steadyload.methods.simulation.placements import REST, Placements
from steadyload.methods.simulation.scene import VERSION as SCENE
from steadyload.methods.simulation.simulation_parameters import (
    OF_STANDS,
    BetweenSteps,
    Scope,
    SimulationParameters,
    parameters_on,
)


class Simulation(Method):
    """Loading stability by rigid-body simulation (Algorithm 1, Eq. 6 and 7).

    Items are added one after the other. After each, the world is stepped for ``t_max`` seconds and
    looked at ``samples`` times; the first sample at which an item violates the criterion ends the
    loading. The printed algorithm looks before it steps and never after the last item: a slip, not
    a rule, and not followed here. A 2-D engine refuses layouts that are not planar.
    """

    title = "PS"
    Parameters = SimulationParameters
    needs_engine = True
    built_on: ClassVar[Mapping[str, int]] = {
        "contacts": CONTACTS, "scene": SCENE, "loading": LOADING, "world": WORLD
    }  # fmt: skip

    @classmethod
    def parameters_on(cls, engine: str | None) -> type[SimulationParameters]:
        """See :meth:`Method.parameters_on`: an engine's own options are parameters, too."""
        return SimulationParameters if engine is None else parameters_on(engine)

    @classmethod
    def implied_by(cls, values: Mapping[str, Any]) -> Mapping[str, Any]:
        """See :meth:`Method.implied_by`: whether a load stands is seen later than a label."""
        return OF_STANDS if values.get("question") == Question.STANDS else {}

    @property
    def traits(self) -> frozenset[Trait]:
        """See :attr:`Method.traits`."""
        return frozenset((Trait.STEPWISE, Trait.CENTRES_OF_MASS, Trait.BALANCE, Trait.MOVEMENT))

    @property
    def movement_limits(self) -> MovementLimits:
        """See :attr:`Method.movement_limits`."""
        own = self.parameters
        return MovementLimits(own.t_max, own.eps_t, own.eps_r, own.gravity)

    def parts(self) -> Mapping[str, int]:
        """See :meth:`Method.parts`: the engine's adapter is one, and what a scope or a question has
        of its own.
        """
        own = {"moving": MOVING} if self.parameters.scope is Scope.MOVING else {}
        if self.parameters.question == Question.STANDS:
            own["rest"] = REST
        if self.parameters.early_stop:
            own["foresight"] = FORESIGHT
        return {**super().parts(), "engine": world_class(self.engine).capabilities.version, **own}

    def numerics(self) -> frozenset[str]:
        """See :meth:`Method.numerics`."""
        return super().numerics() | numerics(self.engine)

    def classes(self) -> tuple[type, ...]:
        """See :meth:`Method.classes`."""
        return (*super().classes(), world_class(self.engine))

    @property
    def engine(self) -> str:
        """The engine's registered name."""
        assert self.spec.engine is not None, "make_method asks for an engine"
        return self.spec.engine

    def prepare(self, item_count: int = 0) -> None:
        """Import the engine and warm it up.

        Raises:
            EngineNotInstalledError: its library is missing.
        """
        warm_up(self.engine, item_count)

    def steps(self, layout: Layout, watch: Stopwatch) -> StepScorer:
        """See :meth:`Method.steps`: the score is the largest movement in units of a threshold."""
        if self.parameters.between_steps is BetweenSteps.CARRY:
            raise NotStepwiseError(
                f"{self.spec}: carries the state over from step to step; allowed: "
                "between_steps=reseat"
            )
        watch.enter(Phase.BUILD)
        return _SimulatedSteps(self, layout, watch)

    def begin(self, layout: GrowingLayout) -> Loader:
        """A loader that simulates nothing but the new placement; see :class:`GrowingLoading`.

        With ``scope=moving`` all of the layout is judged at every placement.
        """
        if self.parameters.scope is Scope.MOVING:
            return super().begin(layout)
        return _SimulationLoader(self, layout)

    def _judge(self, layout: Layout, watch: Stopwatch) -> Finding:
        watch.enter(Phase.BUILD)
        run = Loading(layout, self.engine, self.parameters, watch)
        return self.simulated(run, run.load)

    def simulated(self, run: Placements, load: Callable[[], Finding]) -> Finding:
        """Finding of a simulation, its effort and the settings that the engine did not honour."""
        try:
            finding = load()
        except EngineError as error:
            finding = Finding(status=Status.ERROR, reason=str(error))
        except TimeoutExpiredError as error:
            finding = Finding(status=Status.TIMEOUT, reason=str(error))
        ignored, emulated = self.not_honoured()
        return dataclasses.replace(finding, ignored=ignored, emulated=emulated, effort=run.effort)

    def not_honoured(self) -> tuple[tuple[str, ...], tuple[str, ...]]:
        """Settings that the engine ignores, and those that it emulates."""
        settings = self.parameters.world_settings()
        facts = world_class(self.engine).capabilities
        return facts.ignored(settings), facts.emulated(settings)


class _SimulationLoader(Loader):
    def __init__(self, method: Simulation, layout: GrowingLayout) -> None:
        super().__init__(layout)
        self._method = method
        self._loading = GrowingLoading(layout, method.engine, method.parameters)

    def place(self, watch: Stopwatch) -> Finding:
        watch.enter(Phase.BUILD)
        run = self._loading.placements
        run.start(watch)
        return self._method.simulated(run, self._loading.place)

    def go_back(self, count: int) -> None:
        self._loading.go_back(count)

    def fork(self, layout: GrowingLayout) -> _SimulationLoader:
        """Boxes are made, and a state that is carried on is simulated, when they are needed."""
        return _SimulationLoader(self._method, layout)

    def close(self) -> None:
        self._loading.close()


class _SimulatedSteps(StepScorer):
    decision_threshold = 1.0

    def __init__(self, method: Simulation, layout: Layout, watch: Stopwatch) -> None:
        self._watch = watch
        self._run = Loading(layout, method.engine, method.parameters, watch)
        self._limits = method.parameters.eps_t, method.parameters.eps_r
        self.ignored, self.emulated = method.not_honoured()
        self._found: Finding | None = None

    @property
    def effort(self) -> Effort:
        return self._run.effort

    def step_score(self, step: int) -> float:
        try:
            found = self._run.place(step)
            beyond = self._run.beyond() if found is None else math.nan
        except EngineError as error:
            found = Finding(status=Status.ERROR, reason=str(error))
        finally:
            self._watch.enter(None)
        self._found = found
        if found is None:
            return beyond
        if found.displacement is None or found.rotation is None:  # the engine came to no end
            return math.nan
        moved = found.displacement, found.rotation
        return max(m / max(limit, 1e-12) for m, limit in zip(moved, self._limits, strict=True))

    def finding(self, step: int) -> Finding:
        return self._found or super().finding(step)

    def close(self) -> None:
        self._run.close()

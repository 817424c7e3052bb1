"""Loading stability by rigid-body simulation, as a method."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

from engines.registry import world_class
from engines.world import EngineError
from harness.layouts.growing import GrowingLayout
from harness.layouts.model import Layout
from harness.methods.loading import GrowingLoading, Loading
from harness.methods.method import (
    Finding,
    Loader,
    Method,
    Phase,
    Status,
    Stopwatch,
    TimeoutExpiredError,
    Trait,
)
from harness.methods.placements import Placements
from harness.methods.simulation_parameters import SimulationParameters, parameters_on


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
        return SimulationParameters if engine is None else parameters_on(engine)

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

    def begin(self, layout: GrowingLayout) -> Loader:
        """A loader that simulates nothing but the new placement; see :class:`GrowingLoading`."""
        return _SimulationLoader(self, layout)

    def _judge(self, layout: Layout, watch: Stopwatch) -> Finding:
        watch.enter(Phase.BUILD)
        run = Loading(layout, self._engine, self.parameters, watch)
        return self.simulated(run, run.load)

    def simulated(self, run: Placements, load: Callable[[], Finding]) -> Finding:
        """What a simulation finds, with what it took and what the engine did not honour."""
        try:
            finding = load()
        except EngineError as error:
            finding = Finding(status=Status.ERROR, reason=str(error))
        except TimeoutExpiredError as error:
            finding = Finding(status=Status.TIMEOUT, reason=str(error))
        facts, settings = world_class(self._engine).capabilities, self.parameters.world_settings()
        return dataclasses.replace(
            finding,
            ignored=facts.ignored(settings),
            emulated=facts.emulated(settings),
            effort=run.effort,
        )


class _SimulationLoader(Loader):
    def __init__(self, method: Simulation, layout: GrowingLayout) -> None:
        super().__init__(layout)
        self._method = method
        self._loading = GrowingLoading(layout, method._engine, method.parameters)

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

"""Algorithm 1 of the paper, over any engine: on a whole layout, and on one that grows."""

from __future__ import annotations

import math
from functools import cached_property

import numpy as np

from steadyload.engines.registry import world_class
from steadyload.engines.world import Box
from steadyload.layouts.model.floor import INFINITE
from steadyload.layouts.model.growing import GrowingLayout
from steadyload.layouts.model.layout import Arrangement, Layout
from steadyload.methods.contract.method import STABLE, Finding, RefusedError, Stopwatch
from steadyload.methods.simulation.criteria import Examiner, Indices
from steadyload.methods.simulation.moving import MovingItems
from steadyload.methods.simulation.placements import Placements
from steadyload.methods.simulation.scene import (
    Across,
    Neighbourhood,
    boxes,
    neighbourhood,
    planar_scene,
    surroundings,
)
from steadyload.methods.simulation.simulation_parameters import (
    BetweenSteps,
    Scope,
    SimulationParameters,
)

VERSION = 1
"""Of Algorithm 1, its placements and criteria: raised when they come to other verdicts."""


class Loading(Placements):
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
        p = parameters
        self.layout, self.across = layout, _across(layout, engine)
        items = boxes(layout, across=self.across, shrink=p.shrink, jitter=p.jitter, seed=p.seed)
        examines = examiner(items, p.criterion, p.eps_t, p.eps_r)
        subsets = parameters.scope is Scope.WIDENING and world_class(engine).capabilities.subsets
        around = _surroundings(layout, engine, self.across)
        super().__init__(
            engine, parameters, items, examines, watch, surroundings=around, subsets=subsets
        )

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
        # What diverges may overflow on its way; that it did is found out when it is examined.
        with np.errstate(over="ignore", invalid="ignore"):
            scope = self.parameters.scope
            if scope is Scope.ALL:
                return self.among_all(step)
            if scope is Scope.MOVING:
                return self._moving.place(step, self)
            supports = self.layout.supports
            group = np.array(supports.joined(step))
            if scope is Scope.LOCAL:
                reach = _reach(self.layout, group, self.parameters)
                return self.locally(step, neighbourhood(self.layout, group, reach))
            carried = all(
                supports.on_floor[item] or any(p.below <= step for p in supports.below[item])
                for item in group.tolist()
            )
            return self.widening(step, group, on_floor=supports.on_floor[step], carried=carried)

    @cached_property
    def _moving(self) -> MovingItems:
        def reach(items: Indices) -> float:
            return _reach(self.layout, items, self.parameters)

        return MovingItems(self.layout, reach, self.parameters.balance_margin, self.across)


class GrowingLoading:
    """Algorithm 1 on a layout that grows, placement by placement.

    With ``reseat`` a placement is simulated by itself, and without, as long as no item is taken
    off again: then what has been placed is simulated once more.

    Args:
        layout: what is loaded.
        engine: the engine's registered name.
        parameters: those of the method on that engine.
    """

    def __init__(
        self, layout: GrowingLayout, engine: str, parameters: SimulationParameters
    ) -> None:
        p = parameters
        self._layout, self._engine, self._parameters = layout, engine, p
        self._across: Across = "width"
        self._floor = INFINITE
        examiner = Examiner([], p.criterion, p.eps_t, p.eps_r)
        self.placements = Placements(engine, p, [], examiner, Stopwatch())
        self._carried = 0
        """So many placements have made the state that is carried on."""

    def place(self) -> Finding:
        """Simulate the placement of the item that was put on the layout last.

        Raises:
            RefusedError: see :class:`Loading`.
        """
        step = len(self._layout) - 1
        self._take_in()
        with np.errstate(over="ignore", invalid="ignore"):
            if self._parameters.between_steps is BetweenSteps.CARRY:
                for earlier in range(self._carried, step):
                    self.placements.among_all(earlier)
                self._carried = step + 1
            return self._simulate(step) or STABLE

    def go_back(self, count: int) -> None:
        """Forget all items but the first ``count``."""
        del self.placements.items[count:]
        self.placements.examiner.cut(count)
        self.close()

    def close(self) -> None:
        """Give back the world, if there is one; another placement opens a new one."""
        self.placements.close()
        self._carried = 0

    def _take_in(self) -> None:
        """Boxes for the items that are new; for all, where they lie in another plane now, or stand
        on another floor.
        """
        p, run = self._parameters, self.placements
        across, floor = _across(self._layout, self._engine), self._layout.floor
        if (across, floor) != (self._across, self._floor):
            self.go_back(0)
            self._across, self._floor = across, floor
            run.surround(_surroundings(self._layout, self._engine, across))
        fresh = boxes(
            self._layout, across=across, shrink=p.shrink, jitter=p.jitter, seed=p.seed,
            first=len(run.items),
        )  # fmt: skip
        run.items += fresh
        run.examiner.add(fresh)

    def _simulate(self, step: int) -> Finding | None:
        scope, run = self._parameters.scope, self.placements
        if scope is Scope.ALL:
            return run.among_all(step)
        supports = self._layout.supports
        group = np.array(supports.joined(step))
        if scope is Scope.LOCAL:
            reach = _reach(self._layout, group, self._parameters)
            beside = self._layout.beside(group.tolist(), reach)
            return run.locally(step, Neighbourhood(group, np.array(beside, dtype=np.intp)))
        carried = all(supports.on_floor[i] or supports.below[i] for i in group)
        return run.widening(step, group, on_floor=supports.on_floor[step], carried=carried)


def _across(layout: Arrangement, engine: str) -> Across:
    """The axis along which nothing happens, for a 2-D engine; for others any will do.

    Raises:
        RefusedError: the engine has two dimensions and the layout is not planar.
    """
    if world_class(engine).capabilities.dimensions == 3:
        return "width"
    scene = planar_scene(layout)
    if scene.across is None:
        raise RefusedError(scene.reason)
    return scene.across


def _surroundings(layout: Arrangement, engine: str, across: Across) -> list[Box]:
    planar = world_class(engine).capabilities.dimensions == 2
    return surroundings(layout, across=across, planar=planar)


def _reach(layout: Arrangement, group: Indices, parameters: SimulationParameters) -> float:
    """Largest distance a corner of any item of a group can move before it counts as moved [cm]."""
    sides = layout.upper[group] - layout.lower[group]
    diagonal = float(np.sqrt((sides * sides).sum(axis=1)).max())
    turn = 2.0 * math.sin(math.radians(min(parameters.eps_r, 180.0)) / 2.0)
    return parameters.eps_t + turn * diagonal

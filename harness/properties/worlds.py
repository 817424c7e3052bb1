"""Properties of an engine's world: closed forms for a body alone, and energy for a whole pile."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing, contextmanager
from typing import Any, cast

import numpy as np
from hypothesis import strategies as st
from hypothesis.strategies import DrawFn, SearchStrategy

from steadyload.engines.attitudes import rotate
from steadyload.engines.registry import open_world
from steadyload.engines.world import GRAVITY, FixedStepWorld, Velocities, WorldSettings
from steadyload.methods.simulation.scene import Across, boxes, planar_scene
from steadyload.methods.simulation.simulation import Simulation
from steadyload.properties.property import (
    Case,
    MethodUnderTest,
    Property,
    Violation,
    errors_as_violations,
)
from steadyload.properties.strategies import (
    Placed,
    built,
    density_weight,
    ordinary_layouts,
)

_EXACT, _SINGLE = 1e-6, 1e-4
"""Relative error of a closed form, in double and in single precision."""

_LIFT = 0.001
"""Energy that counts as none: what lifts all items by this [m]."""

_SLIDING = 0.03
"""Relative error of a sliding distance, beside one substep at the starting speed."""


class _ViolationWorld:
    """A world that turns every exception of its engine into a violation."""

    def __init__(self, world: FixedStepWorld) -> None:
        self._world = world

    def __getattr__(self, name: str) -> Any:
        with errors_as_violations():
            found = getattr(self._world, name)
        return errors_as_violations()(found) if callable(found) else found


@contextmanager
def _world(
    tested: MethodUnderTest, case: Case, settings: WorldSettings
) -> Iterator[FixedStepWorld]:
    """The case's layout, all items at once."""
    assert tested.engine is not None
    across: Across = "width"
    if tested.planar:
        across = planar_scene(case.layout).across or across
    content = boxes(case.layout, across=across)
    with errors_as_violations():
        opened = open_world(tested.engine, settings)
    world = cast(FixedStepWorld, _ViolationWorld(opened))
    with closing(world):
        for box in content:
            world.add_box(box)
        world.prepare()
        yield world


@st.composite
def _dropped(draw: DrawFn) -> Case:
    size = (draw(st.integers(2, 40).map(float)), draw(st.integers(2, 40).map(float)), 20.0)
    substeps, frequency = draw(st.integers(1, 100)), draw(st.integers(30, 1000))
    fall = 0.5 * GRAVITY * (substeps / frequency) ** 2
    height = 100.0 * float(np.ceil(2.0 * fall)) + 100.0
    layout = built("dropped", [Placed((0.0, height, 0.0), size, density_weight(size))])
    return Case(layout, {"substeps": substeps, "frequency [Hz]": frequency})


def falls_freely(tested: MethodUnderTest, case: Case) -> bool:
    """After n substeps of h the speed is g n h, the way g (n h)^2 / 2 to first order."""
    count, frequency = int(case.change["substeps"]), case.change["frequency [Hz]"]
    seconds = count / frequency
    with _world(tested, case, WorldSettings()) as world:
        start = float(world.poses().centres[0, 2])
        done = world.stepSimulation(seconds, count + 1, 1.0 / frequency)
        speed = -float(world.velocities().linear[0, 2])
        way = start - float(world.poses().centres[0, 2])
    if done.executed != count:
        raise Violation(f"{done.executed} substeps; expected: {count}")
    single = world.capabilities.single_precision
    # A way in single precision is the difference of two heights, each rounded at every substep.
    exact, lost = (_SINGLE, 1e-5 * start) if single else (_EXACT, 1e-9)
    if not np.isclose(speed, GRAVITY * seconds, rtol=exact, atol=0.0):
        raise Violation(f"speed {speed:.6g} m/s; expected: {GRAVITY * seconds:.6g}")
    expected = 0.5 * GRAVITY * seconds**2
    if abs(way - expected) > expected * (exact + 1.0 / count) + lost:
        raise Violation(f"way {way:.6g} m; expected: {expected:.6g}, to one part in {count}")
    return True


@st.composite
def _pushed(draw: DrawFn) -> Case:
    size = (draw(st.integers(30, 60).map(float)), draw(st.integers(2, 10).map(float)), 30.0)
    layout = built("sliding", [Placed((0.0, 0.0, 0.0), size, density_weight(size))])
    change = {
        "speed [m/s]": draw(st.integers(5, 20)) / 10.0,
        "friction": draw(st.integers(2, 10)) / 10.0,
    }
    return Case(layout, change)


def slides_to_a_stop(tested: MethodUnderTest, case: Case) -> bool:
    """A flat box with a starting speed slides v^2 / (2 f g)."""
    speed, friction = case.change["speed [m/s]"], case.change["friction"]
    frequency = tested.method.parameters.frequency
    expected = speed**2 / (2.0 * friction * GRAVITY)
    steps = int(np.ceil(1.5 * speed / (friction * GRAVITY) * frequency))
    with _world(tested, case, WorldSettings(friction=friction)) as world:
        start = world.poses().centres[0, 0]
        push = Velocities(np.array([[speed, 0.0, 0.0]]), np.zeros((1, 3)))
        world.set_velocities(push)
        world.stepSimulation(steps / frequency, steps + 1, 1.0 / frequency)
        found = float(world.poses().centres[0, 0] - start)
    if not abs(found - expected) <= _SLIDING * expected + speed / frequency:
        raise Violation(f"slides {found:.4g} m; expected: {expected:.4g}")
    return True


def _piles(tested: MethodUnderTest) -> SearchStrategy[Case]:
    return ordinary_layouts(planar=tested.planar).map(Case)


def energy_does_not_grow(tested: MethodUnderTest, case: Case) -> bool:
    """A pile let go at rest has at no time more energy than at the start.

    Allowed are what lifts everything by a millimetre, and what lifts every item by its way within
    one substep: twice what an integrator of first order is off by in free fall.
    """
    parameters = tested.method.parameters
    settings = WorldSettings(friction=parameters.friction)
    samples, length = parameters.samples, 1.0 / parameters.frequency
    with _world(tested, case, settings) as world:
        weight = sum(box.mass for box in world.boxes) * GRAVITY
        start, _ = _energy(world)
        for sample in range(samples):
            world.stepSimulation(
                parameters.t_max / samples, int(parameters.t_max / length) + 2, length
            )
            energy, way = _energy(world)
            if not np.isfinite(energy):
                raise Violation(f"energy is {energy} at sample {sample + 1}")
            gained = (energy - start) / weight
            if gained > _LIFT + length * way:
                raise Violation(
                    f"energy grows by what lifts everything by {1e3 * gained:.3g} mm until "
                    f"sample {sample + 1}; allowed: {1e3 * (_LIFT + length * way):.3g} mm"
                )
    return True


def _energy(world: FixedStepWorld) -> tuple[float, float]:
    """Kinetic and potential energy [J], and the mean speed of the mass [m/s]."""
    masses = np.array([box.mass for box in world.boxes])
    offsets = np.array([box.mass_offset for box in world.boxes])
    inertias = np.array([box.inertia for box in world.boxes])
    poses, velocities = world.poses(), world.velocities()
    heights = (poses.centres + rotate(poses.quaternions, offsets))[:, 2]
    inverse = poses.quaternions * (1.0, -1.0, -1.0, -1.0)
    spins = rotate(inverse, velocities.angular)
    speeds = (velocities.linear**2).sum(axis=1)
    kinetic = 0.5 * (masses * speeds).sum() + 0.5 * (inertias * spins**2).sum()
    mean = (masses * np.sqrt(speeds)).sum() / masses.sum()
    return float(kinetic + GRAVITY * (masses * heights).sum()), float(mean)


def _simulated(tested: MethodUnderTest) -> bool:
    """A world is run as the method says; one that simulates in parts only says nothing of it."""
    return isinstance(tested.method, Simulation)


PROPERTIES = (
    Property(
        "free fall",
        "After n substeps of h a body falls at g n h, by g (n h)^2 / 2 to first order.",
        lambda tested: _dropped(),
        falls_freely,
        _simulated,
    ),
    Property(
        "sliding",
        "A flat box with a starting speed slides v^2 / (2 f g), at any friction f.",
        lambda tested: _pushed(),
        slides_to_a_stop,
        _simulated,
    ),
    Property(
        "energy",
        "A pile let go at rest never has more energy than at the start.",
        _piles,
        energy_does_not_grow,
        _simulated,
    ),
)

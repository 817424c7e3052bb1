"""Checks of free flight against Euler's equations and the parabola; all need three dimensions."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from steadyload.engines.attitudes import degrees_apart, rotate
from steadyload.engines.checks.euler import spun
from steadyload.engines.checks.scenes import (
    FloatArray,
    WorldClass,
    expect,
    fill,
    mass_centres,
    require_flight,
    require_space,
    rounding,
    turned_about,
)
from steadyload.engines.world import GRAVITY, Box, FixedStepWorld, Poses, WorldSettings

_FREQUENCY = 1920
_SIZE = (0.1, 0.2, 0.4)
_CUBE = (0.3, 0.3, 0.3)
_OFFSET = (0.02, 0.03, -0.05)
_ATTITUDE = turned_about((1.0, 2.0, -0.5), 63.0)

_RATES = ((10.0, 0.2, 0.1), (0.2, 10.0, 0.1), (0.1, 0.2, 10.0))
"""Angular velocities in body axes [rad/s]: about the axis of the largest moment of inertia, of the
middle one and of the smallest one. About the middle one it turns over within a second; without the
gyroscopic term its attitude would be 149 degrees off by then."""


class _Flight(NamedTuple):
    """Boxes in flight, and where they are after some time."""

    scene: list[Box]
    poses: Poses


def check_free_rotation(world_class: WorldClass) -> None:
    """A second of rotation about each of three axes, by Euler's equations to a degree."""
    require_flight(world_class)
    require_space(world_class)
    scene = _spinning()
    with world_class(WorldSettings(gravity=(0.0, 0.0, 0.0))) as world:
        fill(world, scene)
        start = mass_centres(world.poses(), scene)
        world.stepSimulation(1.0, 10**6, 1.0 / _FREQUENCY)
        poses = world.poses()
    _expect_attitudes(world_class, _Flight(scene, poses), 1.0)
    way = mass_centres(poses, scene) - start
    expect(way, 0.0, rounding(world_class), "way of the centres of mass")


def check_free_rotation_of_stated_moments(world_class: WorldClass) -> None:
    """The same of cubes that are turned as boxes are, by moments that are not a cube's."""
    require_flight(world_class)
    require_space(world_class)
    moments = _spinning()[0].inertia
    scene = [replace(box, size=_CUBE, moments=moments) for box in _spinning()]
    with world_class(WorldSettings(gravity=(0.0, 0.0, 0.0))) as world:
        fill(world, scene)
        world.stepSimulation(1.0, 10**6, 1.0 / _FREQUENCY)
        poses = world.poses()
    _expect_attitudes(world_class, _Flight(scene, poses), 1.0)


def check_free_rotation_keeps_energy_and_momentum(world_class: WorldClass) -> None:
    """Kinetic energy and angular momentum, vector and all, stay over two seconds, to 2 per cent."""
    require_flight(world_class)
    require_space(world_class)
    scene = _spinning()
    allowed = 1e-5 if world_class.capabilities.error_controlled else 0.02
    with world_class(WorldSettings(gravity=(0.0, 0.0, 0.0))) as world:
        fill(world, scene)
        energies, momenta = _invariants(world, scene)
        sizes = np.linalg.norm(momenta, axis=1)
        for _ in range(20):
            world.stepSimulation(0.1, 10**6, 1.0 / _FREQUENCY)
            energy, momentum = _invariants(world, scene)
            off = np.linalg.norm(momentum - momenta, axis=1) / sizes
            expect(energy / energies, 1.0, allowed, "energy, of that at the start")
            expect(off, 0.0, allowed, "change of angular momentum, of that at the start")


def check_a_spinning_box_falls_along_a_parabola(world_class: WorldClass) -> None:
    """Its centre of mass follows v t + g t^2 / 2; its attitude follows Euler's equations."""
    require_flight(world_class)
    require_space(world_class)
    velocity, t = (1.0, -0.5, 3.0), 0.8
    scene = _spinning(velocity)
    with world_class(WorldSettings()) as world:
        fill(world, scene)
        world.stepSimulation(t, 10**6, 1.0 / _FREQUENCY)
        poses, linear = world.poses(), world.velocities().linear
    _expect_attitudes(world_class, _Flight(scene, poses), t)
    way = mass_centres(poses, scene) - [b.mass_centre for b in scene]
    wanted = np.array(velocity) * t - (0.0, 0.0, 0.5 * GRAVITY * t * t)
    expect(way, np.tile(wanted, (3, 1)), 0.51 * GRAVITY * t / _FREQUENCY, "way")
    flown = np.array(velocity) - (0.0, 0.0, GRAVITY * t)
    expect(linear, np.tile(flown, (3, 1)), 10.0 * rounding(world_class), "velocity")


def _spinning(velocity: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> list[Box]:
    """A box for each of the rates, side by side."""
    turns = np.tile(_ATTITUDE, (3, 1))
    return [
        Box(
            _SIZE,
            2.0,
            (2.0 * k, 0.0, 50.0),
            _OFFSET,
            attitude=_ATTITUDE,
            velocity=velocity,
            angular_velocity=tuple(spin),
        )
        for k, spin in enumerate(rotate(turns, np.array(_RATES)).tolist())
    ]


def _expect_attitudes(world_class: WorldClass, flight: _Flight, seconds: float) -> None:
    allowed = 0.01 if world_class.capabilities.error_controlled else 1.0
    for box, rates, found in zip(flight.scene, _RATES, flight.poses.quaternions, strict=True):
        expected = spun(np.array(box.inertia), rates, seconds, _ATTITUDE)[:4]
        expect(degrees_apart(found, expected), 0.0, allowed, f"degrees off at rates {rates}")


def _invariants(world: FixedStepWorld, scene: list[Box]) -> tuple[FloatArray, FloatArray]:
    """Kinetic energies of rotation [J] and angular momenta in world axes [kg m2/s]."""
    turns, angular = world.poses().quaternions, world.velocities().angular
    rates = rotate(turns * (1.0, -1.0, -1.0, -1.0), angular)
    momenta = np.array([b.inertia for b in scene]) * rates
    return 0.5 * (momenta * rates).sum(axis=1), rotate(turns, momenta)

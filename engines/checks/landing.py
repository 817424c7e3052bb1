"""Checks of boxes that arrive: on an edge, on a corner, and sliding fast."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from steadyload.engines.attitudes import rotate
from steadyload.engines.checks.scenes import (
    CUBE,
    FloatArray,
    WorldClass,
    angles,
    expect,
    lowest_corner,
    mass_centres,
    require_flight,
    require_space,
    turned_about,
)
from steadyload.engines.world import (
    GRAVITY,
    Box,
    FixedStepWorld,
    Poses,
    WorldSettings,
    planned_poses,
)

_FREQUENCY = 960
_GAP = 0.02
"""Height of the lowest corner above the floor, from which a cube is dropped [m]."""


class _Landing(NamedTuple):
    """A cube that was dropped: its last poses, and the extremes of its way.

    ``gained``: mechanical energy above that at the start, in metres of height. ``deepest``:
    height of its lowest corner at the lowest [m].
    """

    poses: Poses
    gained: float
    deepest: float


def check_an_edge_drop_ends_on_the_nearer_face(world_class: WorldClass) -> None:
    """A cube that falls on an edge, turned by less or more than 45 degrees, lands on a face.

    What it strikes gives no bounce, so it turns to the side on which its centre of mass is; from
    the face it does not turn on, as the impact leaves a sixteenth of the energy of its turning.
    """
    require_flight(world_class)
    for degrees in (5.0, 40.0, 50.0):
        attitude = turned_about((0.0, 1.0, 0.0), degrees)
        _expect_landed(_dropped(world_class, attitude), attitude, f"edge at {degrees:g} degrees")


def check_a_corner_drop_ends_on_the_nearest_face(world_class: WorldClass) -> None:
    """A cube that falls on a corner lands on the face that was the nearest to level."""
    require_flight(world_class)
    require_space(world_class)
    for axis, degrees in (((1.0, 0.5, 0.2), 38.0), ((1.0, -0.8, 0.2), 130.0)):
        attitude = turned_about(axis, degrees)
        _expect_landed(_dropped(world_class, attitude), attitude, f"corner, {axis}, {degrees:g}")


def check_a_fast_slide(world_class: WorldClass) -> None:
    """A cube that slides at 3 m/s stops after v^2 / (2 mu g), stays on the floor and upright."""
    require_flight(world_class)
    side, speed, friction = 0.2, 3.0, 0.5
    box = Box((side, side, side), 8.0, (0.0, 0.0, 0.5 * side), velocity=(speed, 0.0, 0.0))
    highest, tilted = 0.0, 0.0
    with world_class(WorldSettings(friction=friction)) as world:
        world.add_box(box)
        for _ in range(200):
            world.stepSimulation(0.005, 100, 1.0 / _FREQUENCY)
            poses = world.poses()
            highest = max(highest, lowest_corner(poses, box))
            tilted = max(tilted, _tilt(poses))
    way = float(poses.centres[0, 0])
    expected = speed**2 / (2.0 * friction * GRAVITY)
    right = abs(way / expected - 1.0) < 0.02 and highest < 1e-3 and tilted < 1.0
    assert right, (
        f"stops after {way:.3f} m, expected {expected:.3f} m; lowest corner up to "
        f"{1e3 * highest:.1f} mm high, base tilted by up to {tilted:.1f} degrees; turned by "
        f"{float(angles(poses)[0]):.1f} degrees at the end"
    )


def _dropped(world_class: WorldClass, attitude: tuple[float, float, float, float]) -> _Landing:
    flat = Box(CUBE, 1.0, (0.0, 0.0, 0.0), attitude=attitude)
    height = _GAP - lowest_corner(planned_poses([flat]), flat)
    box = Box(CUBE, 1.0, (0.0, 0.0, height), attitude=attitude)
    gained = deepest = 0.0
    with world_class(WorldSettings()) as world:
        world.add_box(box)
        start = _energy(world, box)
        for _ in range(round(1.5 * _FREQUENCY)):
            world.stepSimulation(1.0 / _FREQUENCY, 1, 1.0 / _FREQUENCY)
            gained = max(gained, (_energy(world, box) - start) / (box.mass * GRAVITY))
            deepest = min(deepest, lowest_corner(world.poses(), box))
        return _Landing(world.poses(), gained, deepest)


def _expect_landed(
    landing: _Landing, attitude: tuple[float, float, float, float], what: str
) -> None:
    before, after = (_upward(np.array(q)) for q in (attitude, landing.poses.quaternions[0]))
    nearest = int(np.abs(before).argmax())
    wanted = np.zeros(3)
    wanted[nearest] = np.sign(before[nearest])
    expect(after, wanted, 2e-3, f"{what}: upward direction in axes of the cube")
    expect(landing.poses.centres[0, 2], 0.5 * CUBE[2], 3e-4, f"{what}: height at the end")
    # Penetration that is pushed out lifts a cube by less than a millimetre.
    expect(landing.gained, 0.0, 1e-3, f"{what}: energy gained, in metres of height")
    expect(landing.deepest, 0.0, 2e-3, f"{what}: height of the lowest corner, at the lowest")


def _upward(quaternion: FloatArray) -> FloatArray:
    """The world's upward direction in axes of a body."""
    back = quaternion * (1.0, -1.0, -1.0, -1.0)
    return rotate(back[None], np.array([(0.0, 0.0, 1.0)]))[0]


def _tilt(poses: Poses) -> float:
    """Angle of the upward axis of the first box from upright [degrees]."""
    return float(np.degrees(np.arccos(min(1.0, _upward(poses.quaternions[0])[2]))))


def _energy(world: FixedStepWorld, box: Box) -> float:
    """Mechanical energy of the only box [J]."""
    poses, (linear, angular) = world.poses(), world.velocities()
    rates = rotate(poses.quaternions * (1.0, -1.0, -1.0, -1.0), angular)[0]
    turning = 0.5 * float(rates @ (np.array(box.inertia) * rates))
    height = float(mass_centres(poses, [box])[0, 2])
    return box.mass * (GRAVITY * height + 0.5 * float(linear[0] @ linear[0])) + turning

"""Checks of worlds whose gravity changes while they run, as on a floor that is accelerated."""

from __future__ import annotations

import math
from functools import partial

import numpy as np

from steadyload.engines.checks.refusals import expect_refusal
from steadyload.engines.checks.scenes import (
    CUBE,
    NotApplicable,
    WorldClass,
    angles,
    expect,
    fill,
    rounding,
    two_cubes,
)
from steadyload.engines.world import (
    GRAVITY,
    Box,
    FixedStepWorld,
    Support,
    Velocities,
    WorldSettings,
)

_H = 1.0 / 480.0

_DOWN = (0.0, 0.0, -GRAVITY)

_FRICTION = 0.5


def check_a_gravity_that_is_set_is_one_that_was_given(world_class: WorldClass) -> None:
    """Two cubes move alike, whether gravity was tilted before the world was made or is now."""
    _require(world_class)
    tilted = _along(0.4 * GRAVITY)
    found = []
    for given, later in ((tilted, tilted), (_DOWN, tilted)):
        with world_class(WorldSettings(friction=0.3, gravity=given)) as world:
            fill(world, two_cubes(0.02))
            world.set_gravity(later)
            world.stepSimulation(0.3, 1000, _H)
            found.append(world.poses().centres)
    assert found[0][1, 0] > 0.03, f"the upper cube should have slid: {found[0]}"
    emulated = world_class.capabilities.changing_gravity.support is Support.EMULATED
    tolerance = max(rounding(world_class), 1e-3 if emulated else 0.0)
    expect(found[1], found[0], tolerance, "centres under a gravity that was set")


def check_a_pulse_gives_its_impulse(world_class: WorldClass) -> None:
    """A box in free fall is faster by a t along x after a pulse of a for t, and then no more."""
    _require(world_class)
    sideways, seconds = 6.0, 0.1
    with world_class(WorldSettings()) as world:
        world.add_box(Box(CUBE, 3.0, (0.0, 0.0, 20.0), (0.02, 0.0, -0.01)))
        for gravity in (_DOWN, _along(sideways), _DOWN):
            world.set_gravity(gravity)
            world.stepSimulation(seconds, 1000, _H)
        velocity, spin = world.velocities()
    allowed = rounding(world_class)
    expect(velocity[0], (sideways * seconds, 0.0, -3.0 * seconds * GRAVITY), allowed, "velocity")
    expect(spin[0], 0.0, allowed, "angular velocity")


def check_a_box_slides_beyond_its_friction(world_class: WorldClass) -> None:
    """A flat box stays under 0.95 of mu g along the floor; beyond, it gains a - mu g."""
    _require(world_class)
    limit = _FRICTION * GRAVITY
    flat = Box((0.4, 0.4, 0.1), 4.0, (0.0, 0.0, 0.05))
    with _at_rest(world_class, flat) as world:
        world.set_gravity(_along(0.95 * limit))
        world.stepSimulation(0.5, 1000, _H)
        expect(world.poses().centres[0, 0], 0.0, 0.003, "creep at 0.95 of the limit")
    with _at_rest(world_class, flat) as world:
        world.set_gravity(_along(2.0 * limit))
        world.stepSimulation(0.5, 1000, _H)
        speed = world.velocities().linear[0, 0]
    expect(speed, 0.5 * limit, 0.0, "speed at twice the limit", relative=_closeness(world_class))


def check_a_box_tips_beyond_its_lever(world_class: WorldClass) -> None:
    """A tall box stays under 0.97 of g b / h along the floor and tips over at 1.03 of it.

    b is the lever from its centre of mass to the edge that it turns over, h the height of that
    centre; its mass is shifted, so that the two directions differ.
    """
    _require(world_class)
    size, offset = (0.1, 0.1, 0.3), (0.01, 0.0, -0.02)
    tall = Box(size, 2.0, (0.0, 0.0, 0.5 * size[2]), offset)
    height = 0.5 * size[2] + offset[2]
    for sign in (1.0, -1.0):
        lever = 0.5 * size[0] - sign * offset[0]
        for factor in (0.97, 1.03):
            with _at_rest(world_class, tall, friction=0.9) as world:
                world.set_gravity(_along(sign * factor * GRAVITY * lever / height))
                world.stepSimulation(2.0, 10_000, _H)
                angle = float(angles(world.poses())[0])
            if factor < 1.0:
                assert angle < 0.5, f"turned by {angle:.2f} degrees at 0.97 of the limit"
            else:
                assert angle > 10.0, f"turned by {angle:.2f} degrees only at 1.03 of the limit"


def check_a_box_near_its_edge_falls(world_class: WorldClass) -> None:
    """A board turned on its edge falls to the side on which its centre is, as its equation says.

    Without gravity it is turned to almost the angle at which its centre of mass stands over the
    edge, and less or more than it; then gravity sets in. An engine must not hold what is out of
    balance: https://github.com/dimforge/rapier/issues/934 shows a box that stands on its edge.
    """
    _require(world_class)
    for degrees, seconds, closeness in ((1.0, 0.5, 0.02), (0.1, 0.8, 0.1)):
        for off in (degrees, -degrees):
            found, expected = _fallen(world_class, off, seconds)
            expect(found, expected, 0.0, f"angle, {off:g} degree from its edge", closeness)


def _fallen(world_class: WorldClass, degrees: float, seconds: float) -> tuple[float, float]:
    """Angle of a board from that at which it stands on its edge [degrees]: found, and expected."""
    along, across, thick = 0.4, 0.1, 0.09
    balance = math.atan2(along, thick)
    angle = balance + math.radians(degrees)
    height = 0.5 * (along * math.sin(angle) + thick * math.cos(angle))
    turning, above = 0.5, 0.1
    still = np.zeros((1, 3))
    down, turn = np.array([(0.0, 0.0, -above / turning)]), np.array([(0.0, angle / turning, 0.0)])
    with world_class(WorldSettings(friction=1.0)) as world:
        world.add_box(Box((along, across, thick), 2.0, (0.0, 0.0, height + above)))
        world.set_gravity((0.0, 0.0, 0.0))
        world.set_velocities(Velocities(down, turn))
        world.stepSimulation(turning, 1000, _H)
        world.set_velocities(Velocities(still, still))
        world.set_gravity(_DOWN)
        world.stepSimulation(seconds, 1000, _H)
        found = float(angles(world.poses())[0]) - math.degrees(balance)
    # An upright pendulum; the moment of inertia of a board about its edge is 4 / 3 m r^2.
    rate = 0.75 * GRAVITY / (0.5 * math.hypot(along, thick))
    expected, speed, h = math.radians(degrees), 0.0, 1e-5
    for _ in range(round(seconds / h)):
        speed += h * rate * math.sin(expected)
        expected += h * speed
    return found, math.degrees(expected)


def check_a_reset_restores_gravity(world_class: WorldClass) -> None:
    """After a reset a world moves to the last bit as one whose gravity never was another."""
    _require(world_class)
    found = []
    for pulse in (False, True):
        with world_class(WorldSettings()) as world:
            fill(world, two_cubes(0.06))
            if pulse:
                world.set_gravity(_along(5.0))
            world.stepSimulation(0.1, 1000, _H)
            world.reset_poses()
            world.stepSimulation(0.2, 1000, _H)
            found.append(world.poses().centres)
    assert found[0].tobytes() == found[1].tobytes(), f"not the same bits: {found}"


def check_a_gravity_of_no_number_is_refused(world_class: WorldClass) -> None:
    """It is refused by name, and the world goes on under the gravity that it had."""
    _require(world_class)
    with world_class(WorldSettings()) as world:
        world.add_box(Box(CUBE, 1.0, (0.0, 0.0, 20.0)))
        for bad in (math.nan, math.inf, -math.inf):
            expect_refusal(partial(world.set_gravity, (bad, 0.0, -GRAVITY)), "gravity is ")
        world.stepSimulation(0.1, 1000, _H)
        speed = world.velocities().linear[0, 2]
    expect(speed, -0.1 * GRAVITY, rounding(world_class), "speed after refusals")


def _require(world_class: WorldClass) -> None:
    if world_class.capabilities.changing_gravity.support is Support.IGNORED:
        raise NotApplicable(f"{world_class.__name__} declares that its gravity cannot change")


def _along(sideways: float) -> tuple[float, float, float]:
    return sideways, 0.0, -GRAVITY


def _closeness(world_class: WorldClass) -> float:
    return 1e-3 if world_class.capabilities.error_controlled else 1e-2


def _at_rest(world_class: WorldClass, box: Box, friction: float = _FRICTION) -> FixedStepWorld:
    """A world in which a box has come to rest."""
    world = world_class(WorldSettings(friction=friction))
    world.add_box(box)
    world.stepSimulation(0.2, 1000, _H)
    return world

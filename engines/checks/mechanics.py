"""Checks against mechanics that can be written down."""

from __future__ import annotations

import math

import numpy as np

from steadyload.engines.attitudes import rotate
from steadyload.engines.checks.scenes import (
    CUBE,
    WorldClass,
    angles,
    expect,
    fall_speed,
    fill,
    require,
    require_space,
    rounding,
    two_cubes,
)
from steadyload.engines.substeps import StepCount
from steadyload.engines.world import GRAVITY, Box, Support, WorldSettings

_TIPPED, _TIPPED_MASS = (0.1, 0.1, 0.3), 3.0
"""Size [m] and mass [kg] of a box that turns over its edge."""


def check_free_fall(world_class: WorldClass) -> None:
    """v = g t to the last substep, z to within half a substep's worth of a first-order method.

    27, 31, 54 and 62 are numbers of substeps of which a count in floating point loses one.
    """
    for substeps, frequency in ((1, 60), (27, 90), (31, 90), (54, 90), (62, 100), (240, 600)):
        h = 1.0 / frequency
        with world_class(WorldSettings()) as world:
            world.add_box(Box(CUBE, 1.0, (0.0, 0.0, 50.0), (0.01, 0.0, 0.03)))
            count = world.stepSimulation(substeps * h, 10**6, h)
            assert count == StepCount(substeps, substeps, 0), f"{count}"
            expect(fall_speed(world), GRAVITY * substeps * h, rounding(world_class), "speed")
            fallen = 50.0 - world.poses().centres[0, 2]
        t = substeps * h
        expect(fallen, 0.5 * GRAVITY * t * t, 0.51 * GRAVITY * t * h, "distance fallen")


def check_sliding_threshold(world_class: WorldClass) -> None:
    """A flat box slides on a slope of 1.05 times its friction and not on one of 0.95."""
    for friction in (0.3, 0.5):
        for factor in (0.95, 1.05):
            slope = factor * friction
            moved = _slide(world_class, friction, slope, 1.0)
            if factor < 1.0:
                expect(moved, 0.0, 0.003, f"creep at {factor} of the limit")
            else:
                expect(moved, _slid(friction, slope, 1.0), 0.03, f"slide at {factor}", relative=0.1)


def check_friction_is_that_of_the_contact(world_class: WorldClass) -> None:
    """Sliding distance g (sin a - f cos a) t^2 / 2: no product, minimum or maximum shows."""
    for friction in (0.2, 0.8):
        moved = _slide(world_class, friction, friction + 0.3, 0.5)
        expected = _slid(friction, friction + 0.3, 0.5)
        expect(moved, expected, 0.0, f"distance at friction {friction}", relative=0.04)


def check_restitution(world_class: WorldClass) -> None:
    """A cube leaves the floor at e times the speed it came with, and not at all by default."""
    support = world_class.capabilities.settings["restitution"].support
    cases = [(0.0, frozenset[str]())]
    if support is Support.ON_REQUEST:
        cases += [(0.5, frozenset()), (0.5, frozenset({"restitution"}))]
    elif support is not Support.IGNORED:
        cases += [(0.3, frozenset()), (0.7, frozenset())]
    for restitution, emulate in cases:
        settings = WorldSettings(restitution=restitution, emulate=emulate)
        honoured = world_class.capabilities.support("restitution", settings) is not Support.IGNORED
        ratio = _bounce(world_class, settings)
        expected = restitution if honoured else 0.0
        expect(ratio, expected, 0.07, f"bounce at restitution {restitution}")


def check_linear_damping(world_class: WorldClass) -> None:
    """In free fall dv/dt = -g + v ln(1 - d)."""
    require(world_class, "linear_damping")
    decay = -math.log(1.0 - 0.5)
    for frequency in (90, 600):
        with world_class(WorldSettings(linear_damping=0.5)) as world:
            world.add_box(Box(CUBE, 1.0, (0.0, 0.0, 500.0)))
            world.stepSimulation(1.0, 10**6, 1.0 / frequency)
            expected = GRAVITY / decay * (1.0 - math.exp(-decay))
            expect(fall_speed(world), expected, 0.0, f"speed at {frequency} Hz", relative=0.01)


def check_angular_damping(world_class: WorldClass) -> None:
    """A box that turns over its edge is slowed by I ln(1 - d) w, as its equation of motion says."""
    require(world_class, "angular_damping")
    for damping in (0.0, 0.99):
        angle, expected = _turn_over(world_class, (0.0, 0.0, 0.0), damping)
        expect(angle, expected, 0.0, f"angle at damping {damping}", relative=0.03)


def check_tipping_rate_of_a_shifted_mass(world_class: WorldClass) -> None:
    """The angle of a box turning over its edge, by (I + m l^2) a'' = m g l sin(...), any offset."""
    for offset in ((0.0, 0.0, 0.0), (0.02, 0.0, -0.08), (-0.02, 0.0, 0.05)):
        angle, expected = _turn_over(world_class, offset, 0.0)
        expect(angle, expected, 0.0, f"angle at offset {offset}", relative=0.03)


def check_tipping_rate_of_stated_moments(world_class: WorldClass) -> None:
    """The same for a box whose mass lies in its middle, or in its corners."""
    uniform = Box(_TIPPED, _TIPPED_MASS, (0.0, 0.0, 0.15)).inertia
    for factor in (0.5, 2.0):
        x, y, z = (factor * moment for moment in uniform)
        angle, expected = _turn_over(world_class, (0.02, 0.0, -0.08), 0.0, moments=(x, y, z))
        expect(angle, expected, 0.0, f"angle at {factor} of uniform moments", relative=0.03)


def check_tipping_about_the_other_axis(world_class: WorldClass) -> None:
    """The same scene turned by 90 degrees about z turns over along y, at the same rate."""
    require_space(world_class)
    for offset in ((0.0, 0.0, 0.0), (0.0, -0.02, 0.05)):
        across, _ = _turn_over(world_class, offset, 0.0, across=True)
        planar, expected = _turn_over(world_class, (offset[1], 0.0, offset[2]), 0.0)
        expect(across, expected, 0.0, f"angle along y at offset {offset}", relative=0.03)
        expect(across, planar, 2e-3, "angles along x and y")


def check_velocities_are_rates_of_the_poses(world_class: WorldClass) -> None:
    """Angular velocity against differences of attitudes, linear against those of the mass centre.

    A box with a centre of mass shifted along all three axes falls over a corner of another and
    spins about all axes (about y alone in two dimensions).
    """
    space = world_class.capabilities.dimensions == 3
    shift = (0.055, 0.045 if space else 0.0, 0.16)
    offset = (0.02, 0.03 if space else 0.0, 0.01)
    h = 1.0 / 2000.0
    with world_class(WorldSettings()) as world:
        fill(world, [Box(CUBE, 5.0, (0.0, 0.0, 0.05)), Box((0.1, 0.1, 0.12), 1.0, shift, offset)])
        world.stepSimulation(0.22, 10**6, h)
        before = world.poses()
        rates = [world.velocities()]
        world.stepSimulation(h, 1, h)
        rates.append(world.velocities())
        after = world.poses()
    turn, back = after.quaternions[1], before.quaternions[1] * (1.0, -1.0, -1.0, -1.0)
    w = turn[0] * back[0] - turn[1:] @ back[1:]
    axis = turn[0] * back[1:] + back[0] * turn[1:] + np.cross(turn[1:], back[1:])
    spin = 2.0 * np.sign(w) * axis / h
    assert np.abs(spin).max() > 1.0, "the box should be turning"
    # An integrator may move with the velocity before the step or with the one after it.
    angular, linear = rates[0].angular[1] + rates[1].angular[1], rates[0].linear + rates[1].linear
    expect(0.5 * angular, spin, 0.05, "angular velocity", relative=0.02)
    masses = [
        p.centres[1] + rotate(p.quaternions[1:], np.array([offset]))[0] for p in (before, after)
    ]
    expect(0.5 * linear[1], (masses[1] - masses[0]) / h, 0.02, "velocity", relative=0.02)


def check_tipping_threshold(world_class: WorldClass) -> None:
    """A box on a slope tips when gravity's line leaves its base, with any centre of mass."""
    for offset, limit in (((0.0, 0.0, 0.0), 1.0 / 3.0), ((0.0, 0.0, -0.1), 1.0)):
        for factor in (0.93, 1.07):
            with world_class(_on_slope(factor * limit, 2.5)) as world:
                world.add_box(Box((0.1, 0.1, 0.3), 3.0, (0.0, 0.0, 0.15), offset))
                world.stepSimulation(1.5, 10**6, 1.0 / 480.0)
                tipped = bool(angles(world.poses())[0] > 20.0)
            assert tipped is (factor > 1.0), f"offset {offset} at {factor} of the tipping slope"


def check_two_block_overhang(world_class: WorldClass) -> None:
    """The upper of two cubes falls when its centre of mass stands outside the lower one's edge."""
    for overhang, offset in (
        (0.045, 0.0), (0.055, 0.0), (0.0, 0.045), (0.03, 0.025), (0.07, -0.03), (0.02, 0.02),
    ):  # fmt: skip
        with world_class(WorldSettings()) as world:
            fill(world, two_cubes(overhang, offset))
            world.stepSimulation(1.0, 10**6, 1.0 / 480.0)
            fell = bool(angles(world.poses())[1] > 10.0)
        assert fell is (overhang + offset > 0.05), f"overhang {overhang}, offset {offset}"


def check_edge_of_a_deck(world_class: WorldClass) -> None:
    """On a fixed slab, a box stands 1 mm inside the edge and falls 1 mm past it, within 2 s.

    Not at any frequency: how far a box sinks in at its first substep decides a millimetre, too.
    """
    slab = Box((1.0, 0.4, 0.144), 1.0, (-0.5, 0.0, 0.072), fixed=True)
    for height in (0.08, 0.3):
        for past in (-1e-3, 1e-3):
            with world_class(WorldSettings()) as world:
                box = Box((0.3, 0.4, height), 10.0, (past, 0.0, 0.144 + 0.5 * height))
                fill(world, [slab, box])
                world.stepSimulation(2.0, 10**6, 1.0 / 1000.0)
                fell = bool(angles(world.poses())[1] > 10.0)
            assert fell is (past > 0.0), f"{height} m high, {1e3 * past:g} mm past the edge"


def check_rest_without_creep(world_class: WorldClass) -> None:
    """A box at rest stays there: 2 s on the level, and on a slope of 0.8 of the friction."""
    for slope in (0.0, 0.4):
        with world_class(_on_slope(slope, 0.5)) as world:
            world.add_box(Box((0.3, 0.1, 0.1), 2.0, (0.0, 0.0, 0.05), (0.05, 0.0, 0.0)))
            world.stepSimulation(2.0, 10**6, 1.0 / 240.0)
            moved = np.abs(world.poses().centres[0] - (0.0, 0.0, 0.05)).max()
        expect(moved, 0.0, 2e-3, f"creep on slope {slope}")


def check_zero_gap_neighbours(world_class: WorldClass) -> None:
    """A wall of touching cubes of 10 cm and of 1 cm does not push itself apart."""
    for side in (0.1, 0.01):
        wall = [
            Box((side, side, side), 1000.0 * side**3, (side * i, 0.0, side * (0.5 + k)))
            for k in range(3)
            for i in range(4)
        ]
        with world_class(WorldSettings()) as world:
            fill(world, wall)
            world.stepSimulation(0.3, 10**6, 1.0 / 240.0)
            moved = np.abs(world.poses().centres - [b.centre for b in wall]).max()
        expect(moved, 0.0, 1e-3, f"movement of cubes of {side} m")


def check_stack_of_ten(world_class: WorldClass) -> None:
    """Ten cubes placed one after the other stand."""
    with world_class(WorldSettings()) as world:
        for level in range(10):
            world.add_box(Box(CUBE, 1.0, (0.0, 0.0, 0.05 + 0.1 * level)))
            world.stepSimulation(0.3, 10**6, 1.0 / 240.0)
        poses = world.poses()
    planned = np.array([(0.0, 0.0, 0.05 + 0.1 * level) for level in range(10)])
    expect(np.abs(poses.centres - planned).max(), 0.0, 5e-3, "movement in the stack")
    expect(angles(poses).max(), 0.0, 1.0, "angle in the stack")


def check_momentum(world_class: WorldClass) -> None:
    """Two boxes that push each other apart in flight keep their common momentum, m g t."""
    pair = [Box(CUBE, 1.0, (0.0, 0.0, 50.0)), Box(CUBE, 3.0, (0.06, 0.0, 50.099), (0.02, 0.0, 0.0))]
    with world_class(WorldSettings()) as world:
        fill(world, pair)
        world.stepSimulation(0.1, 10**6, 1.0 / 240.0)
        linear = world.velocities().linear
        apart = world.poses().centres[1, 2] - world.poses().centres[0, 2]
    momentum = np.array([1.0, 3.0]) @ linear
    assert apart > 0.099 + 1e-6, "the boxes should have pushed each other"
    expect(momentum, (0.0, 0.0, -4.0 * GRAVITY * 0.1), rounding(world_class), "momentum")


def _on_slope(slope: float, friction: float) -> WorldSettings:
    """Tilted gravity, as on a floor that falls towards +x at ``slope`` = tan(angle)."""
    angle = math.atan(slope)
    gravity = (GRAVITY * math.sin(angle), 0.0, -GRAVITY * math.cos(angle))
    return WorldSettings(friction=friction, gravity=gravity)


def _slide(world_class: WorldClass, friction: float, slope: float, seconds: float) -> float:
    with world_class(_on_slope(slope, friction)) as world:
        world.add_box(Box((0.4, 0.1, 0.05), 2.0, (0.0, 0.0, 0.025)))
        world.stepSimulation(seconds, 10**6, 1.0 / 480.0)
        return float(world.poses().centres[0, 0])


def _slid(friction: float, slope: float, seconds: float) -> float:
    angle = math.atan(slope)
    return 0.5 * GRAVITY * (math.sin(angle) - friction * math.cos(angle)) * seconds**2


def _bounce(world_class: WorldClass, settings: WorldSettings) -> float:
    """Speed upwards after the first contact over the speed before it, at 240 Hz."""
    with world_class(settings) as world:
        world.add_box(Box(CUBE, 1.0, (0.0, 0.0, 0.25)))
        speeds = []
        for _ in range(84):
            world.stepSimulation(1.0 / 240.0, 1, 1.0 / 240.0)
            speeds.append(-fall_speed(world))
    landed = int(np.argmin(speeds))
    # The last speed before the contact may be that of the substep before, or of the one before it.
    two_substeps = 2.0 * GRAVITY / 240.0
    expect(-speeds[landed], math.sqrt(2.0 * GRAVITY * 0.2), two_substeps, "speed of arrival")
    return max(speeds[landed:]) / -speeds[landed]


def _turn_over(
    world_class: WorldClass,
    offset: tuple[float, float, float],
    damping: float,
    *,
    across: bool = False,
    moments: tuple[float, float, float] | None = None,
) -> tuple[float, float]:
    """Angle [rad] of a box that turns over its lower edge: found, and by its equation.

    It turns towards +x, or towards +y when ``across``.
    """
    mass, seconds = _TIPPED_MASS, 0.22
    down_slope, _, down = _on_slope(0.9, 5.0).gravity
    gravity = (0.0, down_slope, down) if across else (down_slope, 0.0, down)
    settings = WorldSettings(friction=5.0, gravity=gravity, angular_damping=damping)
    box = Box(_TIPPED, mass, (0.0, 0.0, 0.15), offset, moments=moments)
    with world_class(settings) as world:
        world.add_box(box)
        world.stepSimulation(seconds, 10**6, 1.0 / 1000.0)
        found = math.radians(float(angles(world.poses())[0]))
    # The centre of mass relative to the edge, turned by the angle a towards +x.
    lever_x, lever_z = offset[1 if across else 0] - 0.05, 0.15 + offset[2]
    inertia = box.inertia[1] + mass * (lever_x**2 + lever_z**2)
    friction_torque = -math.log1p(-damping) * box.inertia[1]
    angle, speed, h = 0.0, 0.0, 1e-5
    for _ in range(round(seconds / h)):
        x = lever_x * math.cos(angle) + lever_z * math.sin(angle)
        z = -lever_x * math.sin(angle) + lever_z * math.cos(angle)
        torque = mass * (z * down_slope - x * down)
        speed += h * (torque - friction_torque * speed) / inertia
        angle += h * speed
    return found, angle

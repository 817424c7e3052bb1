"""Every engine against mechanics that can be written down, through the protocol alone."""

import math

import numpy as np
import pytest

from engines.registry import open_world, world_class
from engines.world import GRAVITY, Box, Support, WorldSettings

CUBE = (0.1, 0.1, 0.1)


def run(engine, boxes, seconds, frequency, **settings):
    """Centres and quaternions after ``seconds``."""
    world = open_world(engine, WorldSettings(**settings))
    try:
        for box in boxes:
            world.add_box(box)
        count = world.stepSimulation(seconds, 10**6, 1.0 / frequency)
        assert count.lost == 0
        return world.poses(), world.velocities()
    finally:
        world.close()


def tilted(slope):
    """Gravity on a floor that falls towards +x at ``slope`` = tan(angle)."""
    angle = math.atan(slope)
    return (GRAVITY * math.sin(angle), 0.0, -GRAVITY * math.cos(angle))


def turned(quaternion):
    """Total angle of a rotation [degrees]."""
    return math.degrees(2.0 * math.acos(min(1.0, abs(quaternion[0]))))


# 27, 31, 54 and 62 substeps are those of which a naive count in floating point loses one.
@pytest.mark.parametrize(
    ("substeps", "frequency"), [(1, 60), (27, 90), (31, 90), (54, 90), (62, 100), (240, 600)]
)
def test_free_fall_counts_every_substep(engine, substeps, frequency):
    # v = -g t exactly for any first-order integrator, so a lost substep shows at once; the
    # semi-implicit Euler step gives z = z0 - g h^2 n (n + 1) / 2, which tends to -g t^2 / 2.
    h = 1.0 / frequency
    poses, velocities = run(
        engine, [Box(CUBE, 1.0, (0.0, 0.0, 50.0), (0.01, -0.02, 0.03))], substeps * h, frequency
    )
    assert velocities.linear[0] == pytest.approx((0.0, 0.0, -GRAVITY * substeps * h), abs=1e-9)
    fallen = 50.0 - poses.centres[0, 2]
    assert abs(fallen - 0.5 * GRAVITY * (substeps * h) ** 2) <= 0.51 * GRAVITY * substeps * h * h
    assert poses.centres[0, :2] == pytest.approx((0.0, 0.0), abs=1e-12)


def test_sliding_starts_at_the_friction_angle(engine):
    # A flat box on a slope: it sticks below tan(angle) = friction and slides above.
    friction = 0.5
    for factor, slides in ((0.95, False), (1.05, True)):
        poses, _ = run(
            engine,
            [Box((0.4, 0.4, 0.05), 2.0, (0.0, 0.0, 0.025))],
            1.0,
            480,
            friction=friction,
            gravity=tilted(factor * friction),
        )
        angle = math.atan(factor * friction)
        free = GRAVITY * (math.sin(angle) - friction * math.cos(angle))
        if slides:
            # x = a t^2 / 2, to within the slip that an engine allows.
            assert poses.centres[0, 0] == pytest.approx(0.5 * free, rel=0.15)
        else:
            assert abs(poses.centres[0, 0]) < 0.002


@pytest.mark.parametrize("friction", [0.3, 0.8])
def test_friction_is_that_of_the_contact(engine, friction):
    # Well above the angle; products, minima and maxima of two bodies' values must not show.
    slope = friction + 0.3
    poses, _ = run(
        engine,
        [Box((0.4, 0.4, 0.02), 2.0, (0.0, 0.0, 0.01))],
        0.5,
        480,
        friction=friction,
        gravity=tilted(slope),
    )
    angle = math.atan(slope)
    free = GRAVITY * (math.sin(angle) - friction * math.cos(angle))
    assert poses.centres[0, 0] == pytest.approx(0.5 * free * 0.25, rel=0.04)


def test_a_tall_box_tips_when_gravity_leaves_its_base(engine):
    # Width 0.1, height 0.3: it tips at tan(angle) = 0.1 / 0.3, long before it slides at 0.9.
    for slope, tips in ((0.30, False), (0.37, True)):
        poses, _ = run(
            engine,
            [Box((0.1, 0.1, 0.3), 3.0, (0.0, 0.0, 0.15))],
            1.5,
            480,
            friction=0.9,
            gravity=tilted(slope),
        )
        assert (turned(poses.quaternions[0]) > 20.0) is tips


def test_a_shifted_centre_of_mass_moves_the_tipping_angle(engine):
    # The same box with its centre of mass 0.1 lower tips at tan(angle) = 0.05 / 0.05 = 1.
    for slope, tips in ((0.9, False), (1.1, True)):
        poses, _ = run(
            engine,
            [Box((0.1, 0.1, 0.3), 3.0, (0.0, 0.0, 0.15), (0.0, 0.0, -0.1))],
            1.5,
            480,
            friction=2.0,
            gravity=tilted(slope),
        )
        assert (turned(poses.quaternions[0]) > 20.0) is tips


@pytest.mark.parametrize(
    ("overhang", "offset", "falls"),
    [
        (0.045, 0.0, False),
        (0.055, 0.0, True),
        (0.0, 0.045, False),
        (0.0, 0.049, False),
        (0.03, 0.025, True),
        (0.07, -0.03, False),
    ],
)
def test_two_blocks_fall_when_the_centre_of_mass_passes_the_edge(engine, overhang, offset, falls):
    # The upper cube's centre of mass stands overhang + offset outside the lower one's centre; the
    # edge is at 0.05.
    boxes = [
        Box(CUBE, 1.0, (0.0, 0.0, 0.05)),
        Box(CUBE, 1.0, (overhang, 0.0, 0.15), (offset, 0.0, 0.0)),
    ]
    poses, _ = run(engine, boxes, 1.0, 480)
    assert (turned(poses.quaternions[1]) > 10.0) is falls


def test_poses_are_those_of_the_geometric_centre(engine):
    # A box hinged by nothing, turned by its fall over an edge: centre and centre of mass must keep
    # their distance whatever the attitude.
    offset = np.array((0.03, 0.0, 0.01))
    boxes = [
        Box(CUBE, 1.0, (0.0, 0.0, 0.05)),
        Box(CUBE, 1.0, (0.06, 0.0, 0.15), tuple(offset)),
    ]
    world = open_world(engine, WorldSettings())
    for box in boxes:
        world.add_box(box)
    assert world.poses().centres == pytest.approx(np.array([b.centre for b in boxes]), abs=1e-12)
    world.stepSimulation(0.2, 1000, 1 / 480)
    centres, quaternions = world.poses()
    world.close()
    # No corner of the tumbling box may lie below the floor by more than a contact's softness.
    assert turned(quaternions[1]) > 15.0
    w, x, y, z = quaternions[1]
    down_row = np.array([2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)])
    lowest = centres[1, 2] - 0.05 * np.abs(down_row).sum()
    assert lowest > -0.002


@pytest.mark.parametrize("frequency", [90, 600])
def test_damping_takes_its_share_a_second(engine, frequency):
    # Free fall with damping d: dv/dt = -g + v ln(1 - d), so |v| tends to g / -ln(1 - d).
    decay = -math.log(1.0 - 0.5)
    _, velocities = run(
        engine, [Box(CUBE, 1.0, (0.0, 0.0, 500.0))], 1.0, frequency, linear_damping=0.5
    )
    expected = GRAVITY / decay * (1.0 - math.exp(-decay))
    assert -velocities.linear[0, 2] == pytest.approx(expected, rel=0.01)


def test_restitution_where_it_is_honoured(engine):
    # The cube leaves the floor at e times the speed it came with, to within what position
    # correction adds; where restitution is ignored, it must not bounce.
    honoured = world_class(engine).capabilities.settings["restitution"].support is Support.HONOURED
    world = open_world(engine, WorldSettings(restitution=0.5))
    world.add_box(Box(CUBE, 1.0, (0.0, 0.0, 0.25)))
    speeds = []
    for _ in range(84):
        world.stepSimulation(1 / 240, 1, 1 / 240)
        speeds.append(world.velocities().linear[0, 2])
    world.close()
    landed = int(np.argmin(speeds))
    assert -speeds[landed] == pytest.approx(math.sqrt(2 * GRAVITY * 0.2), rel=0.02)
    ratio = max(speeds[landed:]) / -speeds[landed]
    assert ratio == pytest.approx(0.5 if honoured else 0.0, abs=0.03)


def test_a_tower_and_an_overhang_at_every_tuning(engine, stack):
    """Eight cubes stand; one whose centre of mass lies 2 cm outside its support falls."""
    from harness.methods import make_method

    for tuning in ("ps3", "ps5", "ps_opt-paper"):
        method = make_method(f"{tuning}@{engine}")
        assert method.judge(stack(*[0.0] * 8)).failing_step is None
        assert method.judge(stack(0.0, 7.0)).failing_step == 1
        assert method.judge(stack(0.0, 4.0, offset=3.0)).failing_step == 1
        assert method.judge(stack(0.0, 3.0)).failing_step is None

"""Checks of boxes that are turned or move when they are added. All but the last two are planar."""

from __future__ import annotations

import math

import numpy as np

from steadyload.engines.attitudes import degrees_apart, rotate
from steadyload.engines.checks.scenes import (
    CUBE,
    WorldClass,
    expect,
    fill,
    mass_centres,
    require_flight,
    require_space,
    require_subsets,
    rounding,
    turned_about,
)
from steadyload.engines.world import GRAVITY, Box, EngineError, FixedStepWorld, Poses, WorldSettings

_H = 1.0 / 480.0
_ABOUT_Y = (0.0, 1.0, 0.0)


def _thrown(x: float = 0.0) -> Box:
    """A box in flight in the plane, with its centre of mass off its middle."""
    return Box(
        (0.12, 0.1, 0.3),
        2.0,
        (x, 0.0, 5.0),
        (0.02, 0.0, -0.05),
        attitude=turned_about(_ABOUT_Y, 130.0),
        velocity=(1.5, 0.0, 2.0),
        angular_velocity=(0.0, -4.0, 0.0),
    )


def check_a_box_starts_as_it_was_added(world_class: WorldClass) -> None:
    """Poses and velocities are read back before the first step, and again after a reset.

    Also where the length of the attitude is not 1 to the last digit, and beside a fixed box.
    """
    require_flight(world_class)
    long = Box(CUBE, 1.0, (9.0, 0.0, 5.0), attitude=(1.0 + 5e-7, 0.0, 0.0, 0.0))
    ramp = Box(CUBE, 1.0, (5.0, 0.0, 0.05), fixed=True, attitude=turned_about(_ABOUT_Y, 20.0))
    scene = [_thrown(), Box(CUBE, 1.0, (2.0, 0.0, 5.0)), ramp, long]
    with world_class(WorldSettings()) as world:
        fill(world, scene)
        _expect_start(world, scene)
        world.stepSimulation(0.2, 1000, _H)
        moved = world.poses()
        assert degrees_apart(moved.quaternions[0], scene[0].attitude) > 20.0, "it should turn"
        expect(moved.centres[2], ramp.centre, 1e-6, "centre of a fixed box")
        expect(degrees_apart(moved.quaternions[2], ramp.attitude), 0.0, 1e-4, "turn of a fixed box")
        world.reset_poses()
        _expect_start(world, scene)
        world.stepSimulation(0.2, 1000, _H)
        _expect_same(world_class, world.poses(), moved, "after a reset")


def check_a_thrown_box_moves_as_one_that_is_set_in_motion(world_class: WorldClass) -> None:
    """Velocities that a box is added with are those that :meth:`World.set_velocities` gives it.

    So are those of a box that is added to a world which has run, and while another is left out.
    """
    require_flight(world_class)
    thrown = _thrown()
    still = Box(thrown.size, thrown.mass, thrown.centre, thrown.mass_offset, False, thrown.attitude)
    found = []
    for box in (still, thrown):
        with world_class(WorldSettings()) as world:
            world.add_box(box)
            velocities = world.velocities()
            if box is still:
                velocities.linear[0], velocities.angular[0] = thrown.velocity, (0.0, -4.0, 0.0)
                world.set_velocities(velocities)
            world.stepSimulation(0.2, 1000, _H)
            found.append(world.poses())
    _expect_same(
        world_class, found[1], found[0], "of one that was thrown and one that was set in motion"
    )
    with world_class(WorldSettings()) as world:
        world.add_box(Box(CUBE, 1.0, (-1.0, 0.0, 0.05)))
        world.stepSimulation(0.1, 1000, _H)
        world.add_box(thrown)
        world.stepSimulation(0.2, 1000, _H)
        poses = world.poses()
    _expect_same(
        world_class, Poses(*(part[1:] for part in poses)), found[0], "of one that was added later"
    )


def check_a_subset_holds_boxes_in_motion(world_class: WorldClass) -> None:
    """A box in motion that was left out starts as it was added when it takes part again."""
    require_flight(world_class)
    require_subsets(world_class)
    scene = [Box(CUBE, 1.0, (0.0, 0.0, 0.05)), _thrown(), _thrown(3.0)]
    with world_class(WorldSettings()) as world:
        fill(world, scene)
        world.stepSimulation(0.2, 1000, _H)
        moved = world.poses()
        for chosen in ([0], [0, 2], [1], [0, 1, 2]):
            world.reset_poses(only=chosen)
            _expect_start(world, [scene[i] for i in chosen])
            world.stepSimulation(0.2, 1000, _H)
            wanted = Poses(*(part[chosen] for part in moved))
            _expect_same(world_class, world.poses(), wanted, f"of boxes {chosen}")


def check_a_ramp_is_a_slope(world_class: WorldClass) -> None:
    """On a fixed box that is turned, a box slides by g (sin a - mu cos a) t^2 / 2, or stays."""
    require_flight(world_class)
    friction, seconds = 0.5, 0.25
    for slope in (0.4, 0.7):
        angle = math.atan(slope)
        attitude = turned_about(_ABOUT_Y, math.degrees(angle))
        normal, down = np.array((slope, 0.0, 1.0)), np.array((1.0, 0.0, -slope))
        normal, down = normal / np.linalg.norm(normal), down / np.linalg.norm(down)
        start = np.array((0.0, 0.0, 3.0)) + 0.125 * normal - 0.4 * down
        x, y, z = start.tolist()
        scene = [
            Box((2.0, 0.1, 0.2), 1.0, (0.0, 0.0, 3.0), fixed=True, attitude=attitude),
            Box((0.2, 0.1, 0.05), 2.0, (x, y, z), attitude=attitude),
        ]
        with world_class(WorldSettings(friction=friction)) as world:
            fill(world, scene)
            world.stepSimulation(seconds, 1000, _H)
            poses = world.poses()
        pull = GRAVITY * max(0.0, math.sin(angle) - friction * math.cos(angle))
        way = poses.centres[1] - start
        expect(way @ down, 0.5 * pull * seconds**2, 1e-3, f"way down {slope:g}", relative=0.04)
        expect(way @ normal, 0.0, 2e-3, f"way into the ramp of {slope:g}")
        expect(degrees_apart(poses.quaternions[1], attitude), 0.0, 0.5, "turn on the ramp")


def check_what_leaves_the_plane_is_refused(world_class: WorldClass) -> None:
    """An engine of two dimensions refuses boxes that are turned or move out of its plane."""
    require_flight(world_class)
    across = (0.0, 1.0, 0.0)
    wrong = [
        Box(CUBE, 1.0, (0.0, 0.0, 9.0), attitude=turned_about((1.0, 0.0, 0.0), 30.0)),
        Box(CUBE, 1.0, (0.0, 0.0, 9.0), attitude=turned_about((0.0, 1.0, 0.1), 30.0)),
        Box(CUBE, 1.0, (0.0, 0.0, 9.0), velocity=across),
        Box(CUBE, 1.0, (0.0, 0.0, 9.0), angular_velocity=(0.0, 1.0, 0.1)),
    ]
    planar = world_class.capabilities.dimensions == 2
    for box in wrong:
        with world_class(WorldSettings()) as world:
            try:
                world.add_box(box)
            except EngineError:
                assert planar, "an engine of three dimensions takes any attitude and motion"
                assert not world.boxes, "a refused box is in the world"
            else:
                assert not planar, f"accepts {box}"


def check_motion_in_space_is_read_back(world_class: WorldClass) -> None:
    """Any attitude and any velocities, in world axes, of boxes with any centre of mass."""
    require_flight(world_class)
    require_space(world_class)
    scene = [
        Box(
            (0.1, 0.2, 0.4),
            2.0,
            (3.0 * k, 1.0, 5.0),
            (0.02, -0.05, 0.1),
            attitude=turned_about(axis, degrees),
            velocity=(1.0, -2.0, 0.5),
            angular_velocity=(3.0, -1.0, 2.0),
        )
        for k, (axis, degrees) in enumerate(
            (((1.0, 2.0, -0.5), 63.0), ((-1.0, 0.3, 0.2), 180.0), ((0.1, -1.0, 2.0), 300.0))
        )
    ]
    with world_class(WorldSettings()) as world:
        fill(world, scene)
        _expect_start(world, scene)
        world.stepSimulation(0.25, 1000, _H)
        world.reset_poses()
        _expect_start(world, scene)


def check_a_fast_spin_is_kept(world_class: WorldClass) -> None:
    """A cube that turns at 300 rad/s goes on doing so for a second; one at 5 mrad/s does so, too.

    There is no gravity: an engine must not put to sleep what is slow.
    """
    require_flight(world_class)
    require_space(world_class)
    speeds, along = (5e-3, 300.0), 5e-3
    axis = np.array((2.0, -1.0, 2.0)) / 3.0
    scene = [
        Box(
            CUBE,
            1.0,
            (2.0 * k, 0.0, 5.0),
            velocity=(along, 0.0, 0.0),
            angular_velocity=tuple((speed * axis).tolist()),
        )
        for k, speed in enumerate(speeds)
    ]
    with world_class(WorldSettings(gravity=(0.0, 0.0, 0.0))) as world:
        fill(world, scene)
        world.stepSimulation(0.1, 1000, _H)
        turned = world.poses().quaternions[1]
        world.stepSimulation(0.9, 1000, _H)
        linear, angular = world.velocities()
        moved = world.poses().centres[0, 0]
    for k, speed in enumerate(speeds):
        what = f"at {speed:g} rad/s"
        expect(angular[k], speed * axis, 0.0, f"angular velocity {what}", relative=1e-3)
        expect(linear[k], (along, 0.0, 0.0), 1e-6, f"velocity {what}", relative=1e-3)
    wanted = turned_about(tuple(axis.tolist()), math.degrees(0.1 * speeds[1]))
    expect(degrees_apart(turned, wanted), 0.0, 3.0, "degrees from the attitude of the fast one")
    expect(moved, along, 0.0, "way of the slow one", relative=0.01)


def _expect_start(world: FixedStepWorld, scene: list[Box]) -> None:
    poses, velocities, exact = world.poses(), world.velocities(), rounding(world.__class__)
    expect(poses.centres, [b.centre for b in scene], exact, "planned centres")
    for k, box in enumerate(scene):
        apart = degrees_apart(poses.quaternions[k], box.unit_attitude)
        expect(apart, 0.0, 1e-4 if exact > 1e-6 else 1e-6, f"degrees from attitude {k}")
    norms = np.linalg.norm(poses.quaternions, axis=1)
    expect(norms, 1.0, 1e-6 if exact > 1e-6 else 1e-12, "lengths of attitudes")
    expect(velocities.linear, [b.velocity for b in scene], exact, "velocities")
    expect(velocities.angular, [b.angular_velocity for b in scene], exact, "angular velocities")
    start = np.array([b.mass_centre for b in scene])
    free = [k for k, b in enumerate(scene) if not b.fixed]
    expect(mass_centres(poses, scene)[free], start[free], exact, "centres of mass")
    turned = rotate(poses.quaternions, np.array([b.mass_offset for b in scene]))
    expect((start - poses.centres)[free], turned[free], exact, "offsets")


def _expect_same(world_class: WorldClass, found: Poses, expected: Poses, what: str) -> None:
    exact = rounding(world_class)
    expect(found.centres, expected.centres, exact, f"centres {what}")
    expect(found.quaternions, expected.quaternions, 10.0 * exact, f"attitudes {what}")

"""Checks of the adapter: signatures, counting, isolation, repetition, resources."""

from __future__ import annotations

import contextlib
import gc
import inspect
import multiprocessing
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np

from steadyload.engines.attitudes import rotate
from steadyload.engines.checks.scenes import (
    CUBE,
    WorldClass,
    angles,
    expect,
    fall_speed,
    fill,
    flat_pile,
    require,
    rounding,
    two_cubes,
)
from steadyload.engines.substeps import StepCount
from steadyload.engines.world import (
    GRAVITY,
    Box,
    BroadPhase,
    EngineError,
    Poses,
    Velocities,
    World,
    WorldClosedError,
    WorldSettings,
)


def check_protocol_signatures(world_class: WorldClass) -> None:
    """Every operation of the protocol is there, with the same parameter names."""
    for name, expected in inspect.getmembers(World, inspect.isfunction):
        if name.startswith("_"):
            continue
        found = getattr(world_class, name, None)
        assert found is not None, f"{name} is missing"
        wanted = list(inspect.signature(expected).parameters)
        assert list(inspect.signature(found).parameters) == wanted, f"{name} differs"


def check_step_counting(world_class: WorldClass) -> None:
    """The returned count is Bullet's, and so is what the engine really did (v = g n h)."""
    sixtieth = 1.0 / 60.0
    with world_class(WorldSettings()) as world:
        world.add_box(Box(CUBE, 1.0, (0.0, 0.0, 500.0)))
        done = 0
        for call, expected in (
            ((sixtieth, 1, sixtieth), StepCount(1, 1, 0)),
            ((0.1, 2, sixtieth), StepCount(2, 6, 4)),
            ((0.025, 10, sixtieth), StepCount(1, 1, 0)),
            ((0.025, 10, sixtieth), StepCount(2, 2, 0)),
            ((0.001, 10, sixtieth), StepCount(0, 0, 0)),
        ):
            assert world.stepSimulation(*call) == expected, f"{call}"
            done += expected.executed
            fallen = GRAVITY * done * sixtieth
            expect(fall_speed(world), fallen, rounding(world_class), "speed after the substeps")


def check_two_worlds_do_not_mix(world_class: WorldClass) -> None:
    """Two worlds stepped in turns give what each gives alone."""
    scenes = [
        two_cubes(0.03),
        [Box(CUBE, 2.0, (0.0, 0.0, 0.3)), Box(CUBE, 1.0, (0.3, 0.0, 0.05))],
    ]
    settings = [WorldSettings(friction=0.3), WorldSettings(gravity=(0.0, 0.0, -5.0))]
    alone = []
    for scene, setting in zip(scenes, settings, strict=True):
        with world_class(setting) as world:
            fill(world, scene)
            for _ in range(20):
                world.stepSimulation(0.01, 10, 1.0 / 200.0)
            alone.append(world.poses())
    with world_class(settings[0]) as first, world_class(settings[1]) as second:
        worlds = (first, second)
        for world, scene in zip(worlds, scenes, strict=True):
            fill(world, scene)
        for _ in range(20):
            for world in worlds:
                world.stepSimulation(0.01, 10, 1.0 / 200.0)
        for world, expected in zip(worlds, alone, strict=True):
            _same_bits(world.poses(), expected)


def check_nothing_leaks_to_the_next_world(world_class: WorldClass) -> None:
    """A world gives the same bits after one whose every setting differs, and one that overflows."""
    expected = _tumble(world_class)
    other = WorldSettings(
        friction=0.05,
        restitution=0.9,
        linear_damping=0.9,
        angular_damping=0.9,
        margin=0.02,
        solver_iterations=1,
        gravity=(3.0, 0.0, -2.0),
    )
    with world_class(other) as world:
        world.add_box(Box((0.3, 0.1, 0.1), 9.0, (0.1, 0.0, 0.2), fixed=True))
        fill(world, two_cubes(0.06))
        world.stepSimulation(0.5, 1000, 1.0 / 50.0)
    _same_bits(_tumble(world_class), expected)
    with world_class(WorldSettings(gravity=(0.0, 0.0, 1e306))) as world:
        fill(world, two_cubes(0.0))
        with contextlib.suppress(EngineError):
            world.stepSimulation(1000.0, 1000, 1.0)
    _same_bits(_tumble(world_class), expected)


def check_solver_iterations_count(world_class: WorldClass) -> None:
    """An engine that honours solver iterations moves otherwise with one than with the default."""
    require(world_class, "solver_iterations")
    few = _tumble(world_class, WorldSettings(solver_iterations=1))
    moved = np.abs(few.centres - _tumble(world_class).centres).max()
    assert moved > 1e-9, "the number of iterations has no effect"


def check_a_margin_lifts_nothing(world_class: WorldClass) -> None:
    """Boxes keep their size under a margin: a tower of four stands where it stood."""
    tower = [Box(CUBE, 1.0, (0.0, 0.0, 0.05 + 0.1 * level)) for level in range(4)]
    with world_class(WorldSettings(margin=0.006)) as world:
        fill(world, tower)
        world.stepSimulation(0.3, 1000, 1.0 / 240.0)
        moved = np.abs(world.poses().centres - [b.centre for b in tower]).max()
    expect(moved, 0.0, 1e-3, "movement under a margin")


def check_repeat_in_a_fresh_process(world_class: WorldClass) -> None:
    """The same scene gives the same bits, here again and in a freshly started process."""
    expected = _tumble(world_class)
    _same_bits(_tumble(world_class), expected)
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(1, mp_context=context) as pool:
        _same_bits(pool.submit(_tumble, world_class).result(), expected)


def check_no_broad_phase_remembers_worlds(world_class: WorldClass) -> None:
    """With every broad phase that it has, the third world gives the bits of the first one.

    A pile in which many forces balance, so that the order in which contacts are solved shows. The
    first one is that of a freshly started process.
    """
    context = multiprocessing.get_context("spawn")
    for broad_phase in (None, *BroadPhase):
        settings = WorldSettings(broad_phase=broad_phase)
        if world_class.capabilities.ignored(settings):
            continue
        with ProcessPoolExecutor(1, mp_context=context) as pool:
            first = pool.submit(_pile, world_class, settings).result()
        for _ in range(2):
            _same_bits(_pile(world_class, settings), first)
            _tumble(world_class, settings)


def check_velocities_can_be_set(world_class: WorldClass) -> None:
    """Velocities are read back as set, then m (v0 + g t) and attitudes follow; a reset ends it.

    Set on boxes in flight that have turned already, so that body axes are not the world's. One has
    its centre of mass off its middle, one is fixed, and in two dimensions all moves in the plane.
    """
    space = world_class.capabilities.dimensions == 3
    along, about = ((1.0, 1.0, 1.0),) * 2 if space else ((1.0, 0.0, 1.0), (0.0, 1.0, 0.0))
    offset, t, h = np.array((0.01, 0.02 * along[1], -0.04)), 0.05, 1e-3
    scene = [
        Box((0.12, 0.1, 0.3), 2.0, (0.0, 0.0, 50.0), (offset[0], offset[1], offset[2])),
        Box(CUBE, 1.0, (1.0, 0.0, 0.05), fixed=True),
        Box(CUBE, 3.0, (2.0, 0.0, 50.0)),
    ]
    given = Velocities(
        np.array([(1.0, -0.5, 2.0), (np.nan, 1.0, 1.0), (0.0, 3.0, -1.0)]) * along,
        np.array([(0.7, -0.4, 0.3), (1.0, np.inf, 1.0), (0.2, 0.5, -2.0)]) * about,
    )
    moving, exact = [0, 2], rounding(world_class)
    with world_class(WorldSettings()) as world:
        fill(world, scene)
        world.set_velocities(Velocities(np.zeros((3, 3)), np.full((3, 3), 3.0) * about))
        world.stepSimulation(0.3, 10**6, h)
        before = world.poses()
        assert min(angles(before)[moving]) > 20.0, "the boxes should have turned"
        world.set_velocities(given)
        _same_bits(world.poses(), before)
        found = world.velocities()
        for one, wanted in zip(found, given, strict=True):
            expect(one[moving], wanted[moving], exact, "velocities read back")
            expect(one[1], 0.0, 0.0, "velocity of a fixed box")
        norms = [np.linalg.norm(part, axis=1) for part in found]
        expect(world.speeds(), np.stack(norms, axis=1), 1e-12, "speeds")
        world.stepSimulation(t, 10**6, h)
        flown = given.linear[moving] + (0.0, 0.0, -GRAVITY * t)
        expect(
            world.velocities().linear[moving], flown, rounding(world_class), "velocities in flight"
        )
        expect(
            world.velocities().angular[2], given.angular[2], max(1e-6, exact), "turning of a cube"
        )
        after = world.poses()
        paths = [p.centres[0] + rotate(p.quaternions[:1], offset[None])[0] for p in (before, after)]
        wanted = given.linear[0] * t + (0.0, 0.0, -0.5 * GRAVITY * t * t)
        expect(paths[1] - paths[0], wanted, 0.51 * GRAVITY * t * h, "way of the centre of mass")
        world.reset_poses()
        planned = np.array([b.centre for b in scene])
        assert np.abs(world.poses().centres - planned).max() < 1e-12, "not at the planned poses"
        assert not any(v.any() for v in world.velocities()), "not at rest"
        for linear in (np.zeros((2, 3)), np.zeros((3, 2)), np.full((3, 3), np.nan)):
            try:
                world.set_velocities(Velocities(linear, np.zeros((3, 3))))
            except ValueError:
                continue
            raise AssertionError(f"accepts velocities {linear.tolist()}")


def check_poses_are_of_the_geometric_centre(world_class: WorldClass) -> None:
    """Also for a box with a shifted centre of mass, at rest, in flight and turning over an edge."""
    offset = (0.03, 0.0, 0.01)
    scene = [Box(CUBE, 1.0, (0.0, 0.0, 0.05)), Box(CUBE, 1.0, (0.06, 0.0, 0.15), offset)]
    with world_class(WorldSettings()) as world:
        fill(world, scene)
        expect(world.poses().centres[1], scene[1].centre, 1e-12, "planned centre")
        world.stepSimulation(0.2, 1000, 1.0 / 480.0)
        poses = world.poses()
        assert angles(poses)[1] > 10.0, "the box should be turning over the edge"
        assert poses.quaternions[1, 2] * poses.quaternions[1, 0] > 0.0, "it turns the other way"
        assert world.velocities().angular[1, 1] > 0.0, "its velocity turns the other way"
        _check_corners_stay_outside(poses, scene)
    with world_class(WorldSettings()) as world:
        world.add_box(Box(CUBE, 1.0, (0.2, 0.0, 10.0), offset))
        world.stepSimulation(0.5, 1000, 1.0 / 240.0)
        expect(
            world.poses().centres[0, :2], (0.2, 0.0), rounding(world_class), "centre in free fall"
        )


def check_fixed_boxes_carry_and_never_move(world_class: WorldClass) -> None:
    """Fixed boxes float; others rest on and between them, and fall when beyond an edge.

    Three fixed boxes, one of them flush beside a free one and one added after it.
    """
    table = Box((0.2, 0.1, 0.02), 0.1, (0.0, 0.0, 0.3), fixed=True)
    flush = Box(CUBE, 0.1, (0.15, 0.0, 0.36), fixed=True)
    post = Box((0.02, 0.1, 0.2), 0.1, (1.0, 0.0, 0.1), fixed=True)
    with world_class(WorldSettings()) as world:
        fill(world, [table, flush, Box(CUBE, 5.0, (0.05, 0.0, 0.36)), post])
        world.stepSimulation(0.3, 1000, 1.0 / 240.0)
        poses = world.poses()
        for index, box in ((0, table), (1, flush), (3, post)):
            expect(poses.centres[index], box.centre, 0.0, "fixed box")
        expect(poses.centres[2], (0.05, 0.0, 0.36), 2e-4, "box between fixed boxes")
        world.add_box(Box(CUBE, 1.0, (-0.16, 0.0, 0.36)))
        world.stepSimulation(0.3, 1000, 1.0 / 240.0)
        assert world.poses().centres[4, 2] < 0.34, "a box beyond the edge should fall"
        world.reset_poses()
        expect(world.poses().centres[4], (-0.16, 0.0, 0.36), 1e-12, "reseated centre")


def check_closing(world_class: WorldClass) -> None:
    """Closing twice is allowed, using a closed world is an error, reading never advances time."""
    world = world_class(WorldSettings())
    world.add_box(Box(CUBE, 1.0, (0.0, 0.0, 1.0)))
    world.stepSimulation(0.1, 100, 0.01)
    _same_bits(world.poses(), world.poses())
    still = world.velocities()
    mine = world.poses()
    mine.centres[:] = 7.0
    assert not (world.poses().centres == 7.0).any(), "the arrays should belong to the caller"
    world.close()
    world.close()
    operations: dict[str, Callable[[], object]] = {
        "poses": world.poses,
        "velocities": world.velocities,
        "speeds": world.speeds,
        "set_velocities": lambda: world.set_velocities(still),
        "set_gravity": lambda: world.set_gravity((0.0, 0.0, 0.0)),
        "reset_poses": world.reset_poses,
        "prepare": world.prepare,
        "add_box": lambda: world.add_box(Box(CUBE, 1.0, (0.0, 0.0, 2.0))),
        "stepSimulation": lambda: world.stepSimulation(0.1, 9, 0.1),
    }
    for name, operation in operations.items():
        try:
            operation()
        except WorldClosedError:
            continue
        raise AssertionError(f"{name} works after close")


def check_many_worlds_leave_no_memory(world_class: WorldClass) -> None:
    """Ten thousand worlds do not make the process grow.

    What worlds leave, they leave time and again. Other memory of the process grows now and then,
    as where the system puts small pages together, so that the least of three growths counts.
    """

    def grown(count: int) -> float:
        before = _allocated_bytes()
        for _ in range(count):
            with world_class(WorldSettings()) as world:
                fill(world, two_cubes(0.03))
                world.stepSimulation(0.02, 10, 0.01)
                world.poses()
        gc.collect()
        return (_allocated_bytes() - before) / 1024**2

    grown(1000)
    least = 3.0 * min(grown(3000) for _ in range(3))
    assert least < 10.0, f"the process grew by {least:.1f} MiB over 9,000 worlds"


def check_a_state_that_is_not_finite_shows(world_class: WorldClass) -> None:
    """An overflow is neither hidden nor mended, nor does it end the process."""
    with world_class(WorldSettings(gravity=(0.0, 0.0, 1e306))) as world:
        world.add_box(Box(CUBE, 1.0, (0.0, 0.0, 1.0)))
        try:
            world.stepSimulation(1000.0, 1000, 1.0)
        except EngineError:
            return
        poses = world.poses()
        assert not np.isfinite(poses.centres).all(), "the state should have overflowed"


def _same_bits(found: Poses, expected: Poses) -> None:
    for one, other in zip(found, expected, strict=True):
        assert one.tobytes() == other.tobytes(), f"not the same bits: {one} and {other}"


def _check_corners_stay_outside(poses: Poses, scene: Sequence[Box]) -> None:
    """No corner of the second box lies below the floor or deep inside the first box."""
    half = 0.5 * np.array(scene[1].size)
    signs = np.array([(a, 0.0, b) for a in (-1.0, 1.0) for b in (-1.0, 1.0)])
    corners = poses.centres[1] + rotate(np.tile(poses.quaternions[1], (4, 1)), signs * half)
    assert corners[:, 2].min() > -2e-3, "a corner lies below the floor"
    inside = (np.abs(corners[:, 0]) < 0.047) & (corners[:, 2] < 0.097)
    assert not inside.any(), "a corner lies inside the box below"


def _tumble(world_class: WorldClass, settings: WorldSettings | None = None) -> Poses:
    scene = [
        *two_cubes(0.03),
        Box((0.06, 0.1, 0.2), 0.7, (0.1, 0.0, 0.3), (0.01, 0.0, 0.05)),
    ]
    with world_class(settings or WorldSettings()) as world:
        for box in scene:
            world.add_box(box)
            world.stepSimulation(0.3, 1000, 1.0 / 120.0)
        return world.poses()


def _pile(world_class: WorldClass, settings: WorldSettings) -> Poses:
    with world_class(settings) as world:
        fill(world, flat_pile(8))
        world.stepSimulation(0.3, 1000, 1.0 / 240.0)
        return world.poses()


def _allocated_bytes() -> int:
    """Resident memory that no file backs: pages of libraries come and go as the machine is used."""
    _, resident, of_files, *_ = Path("/proc/self/statm").read_text(encoding="utf-8").split()
    return (int(resident) - int(of_files)) * 4096

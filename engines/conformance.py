"""The checks that every engine must pass: written once, run for each, importable by others.

A check is a function of a world class. It raises :class:`AssertionError` when the engine does not
conform and :class:`NotApplicable` when the engine declares that it lacks what is checked. All
checks are planar (motion in the x-z plane), so that 2-D engines are asked the same questions.

An outside adapter runs them all with::

    for name, check in CHECKS.items():
        check(MyWorld)

Failures that are known stand beside the adapter, in ``capabilities.known_failures``.
"""

from __future__ import annotations

import gc
import inspect
import math
import multiprocessing
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np

from engines.substeps import StepCount
from engines.world import (
    GRAVITY,
    Box,
    EngineError,
    FixedStepWorld,
    Poses,
    Support,
    Velocities,
    World,
    WorldClosedError,
    WorldSettings,
    rotate,
)

WorldClass = type[FixedStepWorld]
Check = Callable[[WorldClass], None]

CHECKS: dict[str, Check] = {}
"""All checks by name, in the order in which they are run."""

CUBE = (0.1, 0.1, 0.1)


class NotApplicable(Exception):  # noqa: N818 - an outcome, not an error
    """The engine declares that it lacks what a check is about."""


def check(function: Check) -> Check:
    """Register a check under its name, without the ``check_`` prefix."""
    CHECKS[function.__name__.removeprefix("check_")] = function
    return function


# --- the protocol -------------------------------------------------------------------------------


@check
def check_protocol_signatures(world_class: WorldClass) -> None:
    """Every operation of the protocol is there, with the same parameter names."""
    for name, expected in inspect.getmembers(World, inspect.isfunction):
        if name.startswith("_"):
            continue
        found = getattr(world_class, name, None)
        assert found is not None, f"{name} is missing"
        wanted = list(inspect.signature(expected).parameters)
        assert list(inspect.signature(found).parameters) == wanted, f"{name} differs"


@check
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
            _close(_speed(world), GRAVITY * done * sixtieth, 1e-9, "speed after the substeps")


@check
def check_two_worlds_do_not_mix(world_class: WorldClass) -> None:
    """Two worlds stepped in turns give what each gives alone."""
    scenes = [_overhang(0.03), [Box(CUBE, 2.0, (0.0, 0.0, 0.3)), Box(CUBE, 1.0, (0.3, 0.0, 0.05))]]
    settings = [WorldSettings(friction=0.3), WorldSettings(gravity=(0.0, 0.0, -5.0))]
    alone = []
    for scene, setting in zip(scenes, settings, strict=True):
        with world_class(setting) as world:
            _add(world, scene)
            for _ in range(20):
                world.stepSimulation(0.01, 10, 1.0 / 200.0)
            alone.append(world.poses())
    with world_class(settings[0]) as first, world_class(settings[1]) as second:
        worlds = (first, second)
        for world, scene in zip(worlds, scenes, strict=True):
            _add(world, scene)
        for _ in range(20):
            for world in worlds:
                world.stepSimulation(0.01, 10, 1.0 / 200.0)
        for world, expected in zip(worlds, alone, strict=True):
            _same_bits(world.poses(), expected)


@check
def check_repeat_in_a_fresh_process(world_class: WorldClass) -> None:
    """The same scene gives the same bits, here again and in a freshly started process."""
    expected = _tumble(world_class)
    _same_bits(_tumble(world_class), expected)
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(1, mp_context=context) as pool:
        _same_bits(pool.submit(_tumble, world_class).result(), expected)


@check
def check_reseat_equals_a_fresh_world(world_class: WorldClass) -> None:
    """After ``reset_poses`` a scene moves as in a new world, to within 0.1 mm and 0.1 degrees."""
    scene = [*_overhang(0.03), Box((0.3, 0.1, 0.02), 0.5, (0.05, 0.0, 0.21), (0.02, 0.0, 0.0))]
    with world_class(WorldSettings()) as world:
        _add(world, scene)
        world.stepSimulation(0.3, 1000, 1.0 / 240.0)
        expected = world.poses()
        world.reset_poses()
        planned = np.array([b.centre for b in scene])
        assert np.abs(world.poses().centres - planned).max() < 1e-12, "not at the planned poses"
        assert not any(v.any() for v in world.velocities()), "not at rest"
        world.stepSimulation(0.3, 1000, 1.0 / 240.0)
        again = world.poses()
    _close(np.abs(again.centres - expected.centres).max(), 0.0, 1e-4, "centres after reseating")
    turned = np.abs((again.quaternions * expected.quaternions).sum(axis=1)).min()
    _close(2.0 * math.degrees(math.acos(min(1.0, turned))), 0.0, 0.1, "angles after reseating")


@check
def check_poses_are_of_the_geometric_centre(world_class: WorldClass) -> None:
    """Also for a box with a shifted centre of mass, at rest, in flight and turning over an edge."""
    offset = (0.03, 0.0, 0.01)
    scene = [Box(CUBE, 1.0, (0.0, 0.0, 0.05)), Box(CUBE, 1.0, (0.06, 0.0, 0.15), offset)]
    with world_class(WorldSettings()) as world:
        _add(world, scene)
        _close(world.poses().centres[1], scene[1].centre, 1e-12, "planned centre")
        world.stepSimulation(0.2, 1000, 1.0 / 480.0)
        poses = world.poses()
        assert _turned(poses)[1] > 10.0, "the box should be turning over the edge"
        _check_corners_stay_outside(poses, scene)
    with world_class(WorldSettings()) as world:
        world.add_box(Box(CUBE, 1.0, (0.2, 0.0, 10.0), offset))
        world.stepSimulation(0.5, 1000, 1.0 / 240.0)
        _close(world.poses().centres[0, :2], (0.2, 0.0), 1e-9, "centre in free fall")


@check
def check_fixed_boxes_carry_and_never_move(world_class: WorldClass) -> None:
    """A fixed box floats where it is; another rests on it, and falls when beyond its edge."""
    table = Box((0.2, 0.1, 0.02), 0.1, (0.0, 0.0, 0.3), fixed=True)
    with world_class(WorldSettings()) as world:
        _add(world, [table, Box(CUBE, 5.0, (0.05, 0.0, 0.36))])
        world.stepSimulation(0.3, 1000, 1.0 / 240.0)
        poses = world.poses()
        _close(poses.centres[0], table.centre, 0.0, "fixed box")
        _close(poses.centres[1], (0.05, 0.0, 0.36), 1e-3, "box on a fixed box")
        world.add_box(Box(CUBE, 1.0, (-0.16, 0.0, 0.36)))
        world.stepSimulation(0.3, 1000, 1.0 / 240.0)
        assert world.poses().centres[2, 2] < 0.34, "a box beyond the edge should fall"
        world.reset_poses()
        _close(world.poses().centres[2], (-0.16, 0.0, 0.36), 1e-12, "reseated centre")


@check
def check_closing(world_class: WorldClass) -> None:
    """Closing twice is allowed, using a closed world is an error, reading never advances time."""
    world = world_class(WorldSettings())
    world.add_box(Box(CUBE, 1.0, (0.0, 0.0, 1.0)))
    world.stepSimulation(0.1, 100, 0.01)
    _same_bits(world.poses(), world.poses())
    mine = world.poses()
    mine.centres[:] = 7.0
    assert not (world.poses().centres == 7.0).any(), "the arrays should belong to the caller"
    world.close()
    world.close()
    for operation in (world.poses, world.velocities, world.reset_poses):
        try:
            operation()
        except WorldClosedError:
            continue
        raise AssertionError(f"{operation.__name__} works after close")


@check
def check_many_worlds_leave_no_memory(world_class: WorldClass) -> None:
    """Ten thousand worlds do not make the process grow."""

    def worlds(count: int) -> None:
        for _ in range(count):
            with world_class(WorldSettings()) as world:
                _add(world, _overhang(0.03))
                world.stepSimulation(0.02, 10, 0.01)
                world.poses()

    worlds(1000)
    gc.collect()
    before = _resident_bytes()
    worlds(9000)
    gc.collect()
    grown = (_resident_bytes() - before) / 1024**2
    assert grown < 10.0, f"the process grew by {grown:.1f} MiB over 9,000 worlds"


@check
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


# --- mechanics ----------------------------------------------------------------------------------


@check
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
            _close(_speed(world), GRAVITY * substeps * h, 1e-9, "speed")
            fallen = 50.0 - world.poses().centres[0, 2]
        t = substeps * h
        _close(fallen, 0.5 * GRAVITY * t * t, 0.51 * GRAVITY * t * h, "distance fallen")


@check
def check_sliding_threshold(world_class: WorldClass) -> None:
    """A flat box slides on a slope of 1.05 times its friction and not on one of 0.95."""
    for friction in (0.3, 0.5):
        for factor in (0.95, 1.05):
            slope = factor * friction
            moved = _slide(world_class, friction, slope, 1.0)
            if factor < 1.0:
                _close(moved, 0.0, 0.003, f"creep at {factor} of the limit")
            else:
                _close(moved, _slid(friction, slope, 1.0), 0.03, f"slide at {factor}", relative=0.1)


@check
def check_friction_is_that_of_the_contact(world_class: WorldClass) -> None:
    """Sliding distance g (sin a - f cos a) t^2 / 2: no product, minimum or maximum shows."""
    for friction in (0.2, 0.8):
        moved = _slide(world_class, friction, friction + 0.3, 0.5)
        expected = _slid(friction, friction + 0.3, 0.5)
        _close(moved, expected, 0.0, f"distance at friction {friction}", relative=0.04)


@check
def check_restitution(world_class: WorldClass) -> None:
    """A cube leaves the floor at e times the speed it came with, and not at all unless asked."""
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
        _close(ratio, expected, 0.08, f"bounce at restitution {restitution}")


@check
def check_linear_damping(world_class: WorldClass) -> None:
    """In free fall dv/dt = -g + v ln(1 - d)."""
    _require(world_class, "linear_damping")
    decay = -math.log(1.0 - 0.5)
    for frequency in (90, 600):
        with world_class(WorldSettings(linear_damping=0.5)) as world:
            world.add_box(Box(CUBE, 1.0, (0.0, 0.0, 500.0)))
            world.stepSimulation(1.0, 10**6, 1.0 / frequency)
            expected = GRAVITY / decay * (1.0 - math.exp(-decay))
            _close(_speed(world), expected, 0.0, f"speed at {frequency} Hz", relative=0.01)


@check
def check_angular_damping(world_class: WorldClass) -> None:
    """A box that turns over its edge is slowed by I ln(1 - d) w, as its equation of motion says."""
    _require(world_class, "angular_damping")
    for damping in (0.0, 0.99):
        angle, expected = _turn_over(world_class, (0.0, 0.0, 0.0), damping)
        _close(angle, expected, 0.0, f"angle at damping {damping}", relative=0.03)


@check
def check_tipping_rate_of_a_shifted_mass(world_class: WorldClass) -> None:
    """The angle of a box turning over its edge, by (I + m l^2) a'' = m g l sin(...), any offset."""
    for offset in ((0.0, 0.0, 0.0), (0.02, 0.0, -0.08), (-0.02, 0.0, 0.05)):
        angle, expected = _turn_over(world_class, offset, 0.0)
        _close(angle, expected, 0.0, f"angle at offset {offset}", relative=0.03)


@check
def check_tipping_threshold(world_class: WorldClass) -> None:
    """A box on a slope tips when gravity's line leaves its base, with any centre of mass."""
    for offset, limit in (((0.0, 0.0, 0.0), 1.0 / 3.0), ((0.0, 0.0, -0.1), 1.0)):
        for factor in (0.93, 1.07):
            with world_class(_on_slope(factor * limit, 2.5)) as world:
                world.add_box(Box((0.1, 0.1, 0.3), 3.0, (0.0, 0.0, 0.15), offset))
                world.stepSimulation(1.5, 10**6, 1.0 / 480.0)
                tipped = bool(_turned(world.poses())[0] > 20.0)
            assert tipped is (factor > 1.0), f"offset {offset} at {factor} of the tipping slope"


@check
def check_two_block_overhang(world_class: WorldClass) -> None:
    """The upper of two cubes falls when its centre of mass stands outside the lower one's edge."""
    for overhang, offset in (
        (0.045, 0.0), (0.055, 0.0), (0.0, 0.045), (0.03, 0.025), (0.07, -0.03), (0.02, 0.02),
    ):  # fmt: skip
        with world_class(WorldSettings()) as world:
            _add(world, _overhang(overhang, offset))
            world.stepSimulation(1.0, 10**6, 1.0 / 480.0)
            fell = bool(_turned(world.poses())[1] > 10.0)
        assert fell is (overhang + offset > 0.05), f"overhang {overhang}, offset {offset}"


@check
def check_rest_without_creep(world_class: WorldClass) -> None:
    """A box at rest stays there: 2 s on the level, and on a slope of 0.8 of the friction."""
    for slope in (0.0, 0.4):
        with world_class(_on_slope(slope, 0.5)) as world:
            world.add_box(Box((0.3, 0.1, 0.1), 2.0, (0.0, 0.0, 0.05), (0.05, 0.0, 0.0)))
            world.stepSimulation(2.0, 10**6, 1.0 / 240.0)
            moved = np.abs(world.poses().centres[0] - (0.0, 0.0, 0.05)).max()
        _close(moved, 0.0, 2e-3, f"creep on slope {slope}")


@check
def check_zero_gap_neighbours(world_class: WorldClass) -> None:
    """A wall of touching cubes of 10 cm and of 1 cm does not push itself apart."""
    for side in (0.1, 0.01):
        wall = [
            Box((side, side, side), 1000.0 * side**3, (side * i, 0.0, side * (0.5 + k)))
            for k in range(3)
            for i in range(4)
        ]
        with world_class(WorldSettings()) as world:
            _add(world, wall)
            world.stepSimulation(0.3, 10**6, 1.0 / 240.0)
            moved = np.abs(world.poses().centres - [b.centre for b in wall]).max()
        _close(moved, 0.0, 1e-3, f"movement of cubes of {side} m")


@check
def check_stack_of_ten(world_class: WorldClass) -> None:
    """Ten cubes placed one after the other stand."""
    with world_class(WorldSettings()) as world:
        for level in range(10):
            world.add_box(Box(CUBE, 1.0, (0.0, 0.0, 0.05 + 0.1 * level)))
            world.stepSimulation(0.3, 10**6, 1.0 / 240.0)
        poses = world.poses()
    planned = np.array([(0.0, 0.0, 0.05 + 0.1 * level) for level in range(10)])
    _close(np.abs(poses.centres - planned).max(), 0.0, 5e-3, "movement in the stack")
    _close(_turned(poses).max(), 0.0, 1.0, "angle in the stack")


@check
def check_momentum(world_class: WorldClass) -> None:
    """Two boxes that push each other apart in flight keep their common momentum, m g t."""
    pair = [Box(CUBE, 1.0, (0.0, 0.0, 50.0)), Box(CUBE, 3.0, (0.06, 0.0, 50.099), (0.02, 0.0, 0.0))]
    with world_class(WorldSettings()) as world:
        _add(world, pair)
        world.stepSimulation(0.1, 10**6, 1.0 / 240.0)
        linear = world.velocities().linear
        apart = world.poses().centres[1, 2] - world.poses().centres[0, 2]
    momentum = np.array([1.0, 3.0]) @ linear
    assert apart > 0.099 + 1e-6, "the boxes should have pushed each other"
    _close(momentum, (0.0, 0.0, -4.0 * GRAVITY * 0.1), 1e-9, "momentum")


# --- helpers ------------------------------------------------------------------------------------


def _close(
    found: object, expected: object, absolute: float, what: str, relative: float = 0.0
) -> None:
    ok = np.allclose(found, expected, rtol=relative, atol=absolute, equal_nan=False)  # type: ignore[arg-type]
    assert ok, f"{what}: found {found}, expected {expected} +- {absolute:g} + {relative:.0%}"


def _same_bits(found: Poses, expected: Poses) -> None:
    for one, other in zip(found, expected, strict=True):
        assert one.tobytes() == other.tobytes(), f"not the same bits: {one} and {other}"


def _require(world_class: WorldClass, setting: str) -> None:
    if world_class.capabilities.settings[setting].support is Support.IGNORED:
        raise NotApplicable(f"{world_class.__name__} declares that it ignores {setting}")


def _add(world: FixedStepWorld, scene: Sequence[Box]) -> None:
    for box in scene:
        world.add_box(box)


def _overhang(shift: float, offset: float = 0.0) -> list[Box]:
    return [
        Box(CUBE, 1.0, (0.0, 0.0, 0.05)),
        Box(CUBE, 1.0, (shift, 0.0, 0.15), (offset, 0.0, 0.0)),
    ]


def _speed(world: FixedStepWorld) -> float:
    """Downward speed of the first box [m/s]."""
    velocities: Velocities = world.velocities()
    return -float(velocities.linear[0, 2])


def _turned(poses: Poses) -> np.ndarray:
    """Total angles [degrees]."""
    return np.degrees(2.0 * np.arccos(np.minimum(1.0, np.abs(poses.quaternions[:, 0]))))


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
            speeds.append(-_speed(world))
    landed = int(np.argmin(speeds))
    _close(-speeds[landed], math.sqrt(2.0 * GRAVITY * 0.2), 0.06, "speed of arrival")
    return max(speeds[landed:]) / -speeds[landed]


def _turn_over(
    world_class: WorldClass, offset: tuple[float, float, float], damping: float
) -> tuple[float, float]:
    """Angle [rad] of a box that turns over its lower right edge: found, and by its equation."""
    size, mass, seconds = (0.1, 0.1, 0.3), 3.0, 0.22
    settings = _on_slope(0.9, 5.0)
    settings = WorldSettings(friction=5.0, gravity=settings.gravity, angular_damping=damping)
    box = Box(size, mass, (0.0, 0.0, 0.15), offset)
    with world_class(settings) as world:
        world.add_box(box)
        world.stepSimulation(seconds, 10**6, 1.0 / 1000.0)
        found = math.radians(float(_turned(world.poses())[0]))
    # The centre of mass relative to the edge, turned by the angle a towards +x.
    lever_x, lever_z = offset[0] - 0.05, 0.15 + offset[2]
    inertia = box.inertia[1] + mass * (lever_x**2 + lever_z**2)
    friction_torque = -math.log1p(-damping) * box.inertia[1]
    angle, speed, h = 0.0, 0.0, 1e-5
    for _ in range(round(seconds / h)):
        x = lever_x * math.cos(angle) + lever_z * math.sin(angle)
        z = -lever_x * math.sin(angle) + lever_z * math.cos(angle)
        torque = mass * (z * settings.gravity[0] - x * settings.gravity[2])
        speed += h * (torque - friction_torque * speed) / inertia
        angle += h * speed
    return found, angle


def _check_corners_stay_outside(poses: Poses, scene: Sequence[Box]) -> None:
    """No corner of the second box lies below the floor or deep inside the first box."""
    half = 0.5 * np.array(scene[1].size)
    signs = np.array([(a, 0.0, b) for a in (-1.0, 1.0) for b in (-1.0, 1.0)])
    corners = poses.centres[1] + rotate(np.tile(poses.quaternions[1], (4, 1)), signs * half)
    assert corners[:, 2].min() > -2e-3, "a corner lies below the floor"
    inside = (np.abs(corners[:, 0]) < 0.047) & (corners[:, 2] < 0.097)
    assert not inside.any(), "a corner lies inside the box below"


def _tumble(world_class: WorldClass) -> Poses:
    scene = [*_overhang(0.03), Box((0.06, 0.1, 0.2), 0.7, (0.1, 0.0, 0.3), (0.01, 0.0, 0.05))]
    with world_class(WorldSettings()) as world:
        for box in scene:
            world.add_box(box)
            world.stepSimulation(0.3, 1000, 1.0 / 120.0)
        return world.poses()


def _resident_bytes() -> int:
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * 4096

"""Released bodies simulated by an engine until they rest, as trials that can be compared."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from steadyload.engines.attitudes import rotate
from steadyload.engines.registry import open_world
from steadyload.engines.world import Box, FixedStepWorld, WorldSettings
from steadyload.measured.bodies import Body
from steadyload.measured.derived import REST_SPEED, REST_SPIN
from steadyload.measured.motion import FloatArray, Trial

LONGER = 1.0
"""Time after the last frame of a record in which a simulated body may come to rest [s]."""

_STILL = 0.1
"""Time without motion after which a body is at rest for good [s]: one that tips over an edge is
slow for less."""

VERSION = 1
"""Of releases, simulations and deviations: raised when they come out otherwise."""

_DIGITS = 9
"""Of spans between frames [s]: equal ones stay equal where times are rounded."""

_BACK = (1.0, -1.0, -1.0, -1.0)


def simulated(
    name: str,
    box: Box,
    engine: str,
    settings: WorldSettings,
    frequency: float,
    times: Sequence[float] | FloatArray,
) -> Trial:
    """A released body, simulated over the frames of a record and on until it rests.

    It has the frames of the record and, after those, further ones at the last distance in time:
    until the body has been at rest for 0.1 s, at most for :data:`LONGER`.

    Args:
        name: of the trial.
        box: as released at the first frame.
        engine: registered name, of three dimensions.
        settings: of its world.
        frequency: substeps a second, at least; so many more that frames are whole substeps.
        times: of the frames of the record [s], rising.

    Raises:
        KeyError, EngineNotInstalledError: see :func:`steadyload.engines.registry.world_class`.
        EngineError: the engine gave up.
        MotionError: the motion diverged.
    """
    with open_world(engine, settings) as world:
        world.add_box(box)
        world.prepare()
        frames = list(_frames(world, times, frequency))
    ends, centres, attitudes, linear, angular = (
        np.array(column) for column in zip(*frames, strict=True)
    )
    arms = rotate(attitudes, np.tile(box.mass_offset, (len(frames), 1)))
    return Trial(
        name,
        ends,
        centres,
        attitudes,
        linear - np.cross(angular, arms),
        rotate(attitudes * _BACK, angular),
        Body(size=box.size, mass=box.mass),
    )


def end_pose(
    box: Box,
    engine: str,
    settings: WorldSettings,
    frequency: float,
    times: Sequence[float] | FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """Centre [m] and attitude (w, x, y, z) of a released body at rest, at less cost than its way.

    Args:
        box: as released.
        engine: registered name, of three dimensions.
        settings: of its world.
        frequency: substeps a second, at least, as of :func:`simulated`.
        times: of the frames of the record [s], rising. After them it is looked at, and then every
            0.1 s until it rests, at most for :data:`LONGER`.

    Raises:
        EngineError: see :func:`simulated`.
    """
    span = round(float(np.median(np.diff(times))), _DIGITS)
    length = span / _substeps(span, frequency)
    with open_world(engine, settings) as world:
        world.add_box(box)
        world.prepare()
        step(world, round(float(times[-1] - times[0]) / length), length)
        for _ in range(round(LONGER / _STILL)):
            if _is_still(world):
                break
            step(world, round(_STILL / length), length)
        poses = world.poses()
    return poses.centres[0], poses.quaternions[0]


def step(world: FixedStepWorld, count: int, length: float) -> None:
    """Advance a world by exactly so many substeps of a length [s], whatever rounds."""
    if count:
        world.stepSimulation((count + 0.5) * length, count, length)


def _substeps(span: float, frequency: float) -> int:
    """Number of substeps between two frames: at least so many a second, and whole."""
    return max(1, math.ceil(span * frequency - 1e-6))


_Frame = tuple[float, FloatArray, FloatArray, FloatArray, FloatArray]


def _frames(
    world: FixedStepWorld, times: Sequence[float] | FloatArray, frequency: float
) -> Iterator[_Frame]:
    yield _frame(world, float(times[0]))
    still_since, last = math.inf, float(times[-1] - times[-2])
    more = np.arange(1, math.ceil(LONGER / last) + 1) * last + times[-1]
    before = float(times[0])
    for time in np.concatenate([times[1:], more]).tolist():
        span = round(time - before, _DIGITS)
        count = _substeps(span, frequency)
        step(world, count, span / count)
        before = time
        yield _frame(world, time)
        still_since = min(still_since, time) if _is_still(world) else math.inf
        if time >= times[-1] and time - still_since >= _STILL:
            return


def _frame(world: FixedStepWorld, time: float) -> _Frame:
    poses, (linear, angular) = world.poses(), world.velocities()
    return time, poses.centres[0], poses.quaternions[0], linear[0], angular[0]


def _is_still(world: FixedStepWorld) -> bool:
    speed, spin = world.speeds()[0]
    return bool(speed < REST_SPEED and spin < REST_SPIN)

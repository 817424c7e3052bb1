"""Measurement of an engine in the tests of :mod:`steadyload.studies.closed_forms.study`.

Each function sets up a scene, lets it run and returns one number, in the unit of its test.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

from steadyload.engines.registry import open_world, world_class
from steadyload.engines.world import (
    GRAVITY,
    Box,
    Capabilities,
    FixedStepWorld,
    FloatArray,
    Poses,
    Support,
    Velocities,
    WorldSettings,
)
from steadyload.methods.contract.method import Stopwatch
from steadyload.properties import mechanics, rocking

VERSION = 1
"""Version of the measurements and closed forms: raised when a result or a form changes."""

SIDE = 0.1
CUBE = (SIDE, SIDE, SIDE)
FLAT = (0.4, 0.1, 0.05)
_SPUN = (0.1, 0.2, 0.3)
_SPIN = (0.1, 10.0, 0.1)
_BLOCK = (0.2, 0.1, 0.05)

FALL_SECONDS = 0.3
SLIDE_SECONDS = 1.0
FRICTION = 0.5
BEYOND = 1.005
TURNED = 10.0
TIP_SECONDS = 3.0
"""Time in which a cube 1e-15 m past the edge turns by 10 degrees: growth by e every 0.09 s."""

STACK_SECONDS = 2.0
"""Time in which eight blocks scaled by 1.00001 fall: every mode of tipping grows by e in 0.2 s."""

ROCKING = rocking.Block(0.1, 0.4)
_ROUGH = 1.0
"""Friction at which a rocking block does not slip."""

_ROCKING_SECONDS = 1.6
_OVERTURN_SECONDS = 3.0
_OVERTURNED = 60.0
"""Angle of a block that does not come back [degrees]."""

_GLANCE = 0.1
"""Interval at which it is checked whether a box has turned over [s]."""

_STICKING = 5.0
"""Friction at which nothing slips before it turns over."""

SAMPLING = 240
"""Rate at which an engine that chooses its own steps is sampled [1/s]."""

DROP = 0.2
RESTITUTION = 0.5


UNDEFINED = "not defined"
"""Begin of the reason why a test asks for what an engine does not have."""


class NoValueError(Exception):
    """An engine gives no value; the message says why."""


@dataclass(frozen=True, slots=True)
class Stage:
    """One engine at one frequency.

    ``watch``: is checked after every substep; a run that exceeds its limit ends with its
    :class:`steadyload.methods.contract.method.TimeoutExpiredError`.
    """

    engine: str
    frequency: int
    watch: Stopwatch | None = None

    @property
    def facts(self) -> Capabilities:
        """Capabilities of the engine."""
        return world_class(self.engine).capabilities

    @contextmanager
    def scene(self, boxes: Sequence[Box], settings: WorldSettings) -> Iterator[FixedStepWorld]:
        """A world that holds the boxes."""
        with open_world(self.engine, settings) as world:
            for box in boxes:
                world.add_box(box)
            world.prepare()
            yield world

    def run(self, world: FixedStepWorld, seconds: float) -> Poses:
        """Poses after a further time [s]."""
        parts = 1 if self.watch is None else max(1, math.ceil(seconds * self.frequency))
        for _ in range(parts):
            world.stepSimulation(seconds / parts, 10**6, 1.0 / self.frequency)
            if self.watch is not None:
                self.watch.check()
        poses = world.poses()
        if not all(np.isfinite(part).all() for part in poses):
            raise NoValueError("diverged")
        return poses

    def samples(self, world: FixedStepWorld, seconds: float) -> Iterator[tuple[float, Poses]]:
        """Time and poses after every substep."""
        for count in range(1, round(seconds * self.frequency) + 1):
            yield count / self.frequency, self.run(world, 1.0 / self.frequency)

    def turns(self, boxes: Sequence[Box], settings: WorldSettings, seconds: float) -> bool:
        """True if any box turns by 10 degrees within a time [s]."""
        with self.scene(boxes, settings) as world:
            for _ in range(round(seconds / _GLANCE)):
                if total_angles(self.run(world, _GLANCE)).max() >= TURNED:
                    return True
        return False


def fall(stage: Stage) -> float:
    """Change of height in free fall [mm]."""
    with stage.scene([Box(CUBE, 1.0, (0.0, 0.0, 50.0))], WorldSettings()) as world:
        return 1e3 * float(stage.run(world, FALL_SECONDS).centres[0, 2] - 50.0)


def spin(stage: Stage) -> float:
    """Angle between the attitude of a spinning box and the right one [degrees]."""
    if stage.facts.dimensions < 3:
        raise NoValueError(f"{UNDEFINED}: two dimensions")
    weightless = WorldSettings(gravity=(0.0, 0.0, 0.0))
    with stage.scene([Box(_SPUN, 3.0, (0.0, 0.0, 50.0))], weightless) as world:
        world.set_velocities(Velocities(np.zeros((1, 3)), np.array([_SPIN])))
        found = stage.run(world, 1.0).quaternions[0]
    expected = mechanics.spun(mechanics.box_inertia(_SPUN, 3.0), _SPIN, 1.0)[:4]
    # The shorter of both differences; accurate for small angles, as an arc cosine is not.
    apart = min(float(np.linalg.norm(found - s * expected)) for s in (1.0, -1.0))
    return math.degrees(4.0 * math.asin(min(1.0, 0.5 * apart)))


def way(stage: Stage, slope: float) -> float:
    """Metres down a slope in 1 s."""
    angle = math.atan(slope)
    gravity = (GRAVITY * math.sin(angle), 0.0, -GRAVITY * math.cos(angle))
    settings = WorldSettings(friction=FRICTION, gravity=gravity)
    with stage.scene([Box(FLAT, 2.0, (0.0, 0.0, 0.5 * FLAT[2]))], settings) as world:
        return float(stage.run(world, SLIDE_SECONDS).centres[0, 0])


def sliding_threshold(stage: Stage) -> float:
    """The slope on which a box slides as far as it should a little beyond the limit."""
    limit = BEYOND * FRICTION
    far = mechanics.slid(limit, FRICTION, SLIDE_SECONDS)
    return boundary(lambda slope: way(stage, slope) > far, limit, 1e-4, 5e-6, (0.25, 1.0))


def tipping_offset(stage: Stage) -> float:
    """Offset past the edge from which the upper of two cubes turns over [mm]."""
    lower = Box(CUBE, 1.0, (0.0, 0.0, 0.5 * SIDE))

    def tips(offset: float) -> bool:
        upper = Box(CUBE, 1.0, (0.5 * SIDE + offset, 0.0, 1.5 * SIDE))
        return stage.turns([lower, upper], WorldSettings(), TIP_SECONDS)

    return 1e3 * boundary(tips, 0.0, 1e-5, 1e-6, (-0.04, 0.04))


def time_to_turn(stage: Stage, past_edge: float) -> float:
    """Time in which a cube turns by 10 degrees about an edge [s]."""
    table = Box(CUBE, 1.0, (0.0, 0.0, 0.5 * SIDE), fixed=True)
    cube = Box(CUBE, 1.0, (0.5 * SIDE + past_edge, 0.0, 1.5 * SIDE))
    times, found = [0.0], [0.0]
    with stage.scene([table, cube], WorldSettings(friction=_STICKING)) as world:
        for time, poses in stage.samples(world, TIP_SECONDS):
            times.append(time)
            found.append(float(total_angles(poses)[1]))
            if found[-1] >= TURNED:
                return float(CubicSpline(times, found).solve(TURNED, extrapolate=False)[0])
    raise NoValueError(f"not turned by 10 degrees within {TIP_SECONDS:g} s")


def tipping_time(past_edge: float) -> float:
    """The closed form of :func:`time_to_turn` [s]."""
    return mechanics.tipping_time((SIDE, SIDE), past_edge, math.radians(TURNED))


def bounce(stage: Stage, restitution: float = RESTITUTION) -> float:
    """Height of the first rebound over the height of the drop."""
    cube = Box(CUBE, 1.0, (0.0, 0.0, 0.5 * SIDE + DROP))
    with stage.scene([cube], bouncing(stage, restitution)) as world:
        heights = [float(poses.centres[0, 2]) for _, poses in stage.samples(world, 0.6)]
    low = next((i for i in range(1, len(heights) - 1) if heights[i + 1] > heights[i]), None)
    if low is None:
        return 0.0
    rising = range(low + 1, len(heights) - 1)
    top = next((i for i in rising if heights[i + 1] <= heights[i]), None)
    if top is None:  # it rises until the simulation ends
        return (heights[-1] - 0.5 * SIDE) / DROP
    before, at, after = heights[top - 1 : top + 2]
    # In flight heights lie on a parabola, whatever the step.
    bend, rise = before - 2.0 * at + after, 0.5 * (after - before)
    peak = at - (0.5 * rise**2 / bend if bend < 0.0 else 0.0)
    return (peak - 0.5 * SIDE) / DROP


def bouncing(stage: Stage, restitution: float) -> WorldSettings:
    """Settings of a restitution of every contact, emulated where the engine offers that.

    Raises:
        NoValueError: the engine has none.
    """
    settings = WorldSettings(restitution=restitution, emulate=frozenset({"restitution"}))
    if stage.facts.support("restitution", settings) is Support.IGNORED:
        raise NoValueError(f"{UNDEFINED}: no restitution")
    return settings


def overhang(stage: Stage, count: int, *, width: float = 1e-4, resolution: float = 1e-5) -> float:
    """The share of the harmonic overhangs from which on a stack falls; see :func:`boundary`."""
    length, _, height = _BLOCK
    overhangs = mechanics.harmonic_overhangs(count, length)

    def falls(factor: float) -> bool:
        # From the floor up, so that the lowest overhang comes first.
        places = np.concatenate(([0.0], np.cumsum(overhangs[::-1]))) * factor
        boxes = [
            Box(_BLOCK, 1.0, (float(x), 0.0, height * (level + 0.5)))
            for level, x in enumerate(places)
        ]
        return stage.turns(boxes, WorldSettings(), STACK_SECONDS)

    return boundary(falls, 1.0, width, resolution, (0.3, 1.5))


def time_to_impact(stage: Stage, share: float) -> float:
    """Time from release at a share of alpha to the first impact [s]: a quarter of a period."""
    times, found = _rocking(stage, share)
    start = found[0]
    falling = int(np.argmax(found < 0.05 * start))
    if falling < 3:
        raise NoValueError("not back on its base")
    # What is left of the way is short, and lies on a cubic through the samples before it.
    last = slice(falling - 3, falling + 1)
    return float(CubicSpline(found[last][::-1], times[last][::-1])(0.0))


def energy_after_impact(stage: Stage, share: float) -> float:
    """Share of the energy that the first impact leaves to a block released at a share of alpha.

    By the angle of the next turning point.
    """
    _, found = _rocking(stage, share)
    top = int(found.argmin())
    if found[top] > -1e-3 * found[0]:
        return 0.0
    if top == len(found) - 1:
        raise NoValueError("it does not turn back")
    before, at, after = found[top - 1 : top + 2]
    bend = before - 2.0 * at + after
    highest = at - (0.125 * (after - before) ** 2 / bend if bend > 0.0 else 0.0)
    left, given = (rocking.energy_at(ROCKING, float(a)) for a in (highest, found[0]))
    return left / given


def overturning_pulse(stage: Stage, seconds: float) -> float:
    """The least peak of a half sine of ground acceleration that overturns, over g tan(alpha)."""
    _require(stage, "changing_gravity", "gravity does not change")
    substeps, still = round(seconds * stage.frequency), (0.0, 0.0, -GRAVITY)
    block = Box(_block_size(), 2.0, (0.0, 0.0, 0.5 * ROCKING.height))

    def overturns(peak: float) -> bool:
        with stage.scene([block], WorldSettings(friction=_ROUGH)) as world:
            for k in range(substeps):
                height = peak * ROCKING.overturning * math.sin(math.pi * (k + 0.5) / substeps)
                world.set_gravity((height, 0.0, -GRAVITY))
                stage.run(world, 1.0 / stage.frequency)
            world.set_gravity(still)
            for _ in range(round(_OVERTURN_SECONDS / _GLANCE)):
                if total_angles(stage.run(world, _GLANCE)).max() >= _OVERTURNED:
                    return True
        return False

    guess = rocking.overturning_pulse(ROCKING, seconds)
    return boundary(overturns, guess, 2e-3, 2e-4, (1.0, 10.0))


def _rocking(stage: Stage, share: float) -> tuple[FloatArray, FloatArray]:
    """Times [s] and angles [rad] of a block that is released at a share of alpha on an edge."""
    _require(stage, "in_flight", "boxes start upright")
    angle = share * ROCKING.slenderness
    half = 0.5 * angle
    attitude = (math.cos(half), 0.0, math.sin(half), 0.0)
    # Its middle from the edge along +x, turned about it.
    x, z = -0.5 * ROCKING.width, 0.5 * ROCKING.height
    sine, cosine = math.sin(angle), math.cos(angle)
    centre = (x * cosine + z * sine, 0.0, z * cosine - x * sine)
    block = Box(_block_size(), 2.0, centre, attitude=attitude)
    times, found = [0.0], [angle]
    with stage.scene([block], WorldSettings(friction=_ROUGH)) as world:
        for time, poses in stage.samples(world, _ROCKING_SECONDS):
            w, _, y, _ = poses.quaternions[0].tolist()
            times.append(time)
            found.append(2.0 * math.atan2(math.copysign(1.0, w) * y, abs(w)))
    return np.array(times), np.array(found)


def _block_size() -> tuple[float, float, float]:
    return (ROCKING.width, SIDE, ROCKING.height)


def _require(stage: Stage, capability: str, lacking: str) -> None:
    if getattr(stage.facts, capability).support is Support.IGNORED:
        raise NoValueError(f"{UNDEFINED}: {lacking}")


def sink(stage: Stage, ratio: float) -> float:
    """Depth to which a heavy cube sinks into a light one [mm], at most its whole height."""
    with stage.scene(stacked(CUBE, (1.0, ratio)), WorldSettings()) as world:
        height = float(stage.run(world, 1.0).centres[1, 2])
    return 1e3 * min(SIDE, 1.5 * SIDE - height)


def stacked(size: tuple[float, float, float], masses: Sequence[float]) -> list[Box]:
    """Equal boxes on top of each other, with masses from the lowest up."""
    return [Box(size, m, (0.0, 0.0, size[2] * (level + 0.5))) for level, m in enumerate(masses)]


def total_angles(poses: Poses) -> FloatArray:
    """Total angles [degrees], exact also where they are small."""
    turned = np.linalg.norm(poses.quaternions[:, 1:], axis=1)
    return np.degrees(2.0 * np.arctan2(turned, np.abs(poses.quaternions[:, 0])))


def boundary(
    beyond: Callable[[float], bool],
    guess: float,
    width: float,
    resolution: float,
    limits: tuple[float, float],
) -> float:
    """Value at which ``beyond`` changes from false to true, to within ``resolution``.

    The bracket grows from the guess, by a factor of 4 at a time. If there are several such values,
    one of those near the guess is found.

    Raises:
        NoValueError: ``beyond`` is the same up to the limits.
    """
    fails = beyond(guess)
    inside, outside = (guess, guess)
    while True:
        edge = max(limits[0], guess - width) if fails else min(limits[1], guess + width)
        if beyond(edge) is not fails:
            inside, outside = (edge, outside) if fails else (inside, edge)
            break
        if edge in limits:
            raise NoValueError(f"no threshold {'down' if fails else 'up'} to {edge:g}")
        inside, outside = (inside, edge) if fails else (edge, outside)
        width *= 4.0
    while outside - inside > resolution:
        middle = 0.5 * (inside + outside)
        inside, outside = (inside, middle) if beyond(middle) else (middle, outside)
    return 0.5 * (inside + outside)

"""Measurement of one cell of a sweep of :mod:`steadyload.studies.extremes.sweeps`.

Each function runs one engine at one frequency and returns the outcome.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import StrEnum

import numpy as np

from steadyload.engines.attitudes import rotate
from steadyload.engines.registry import world_class
from steadyload.engines.world import (
    GRAVITY,
    Box,
    FixedStepWorld,
    Poses,
    Velocities,
    WorldSettings,
)
from steadyload.methods.simulation.criteria import Criterion, Examiner, euler_angles
from steadyload.properties import closed_forms as runs
from steadyload.properties import mechanics
from steadyload.properties.closed_forms import Stage
from steadyload.studies.extremes import scenes as scenes

VERSION = 1
"""Version of the measurement: raised when the same engine gets another cell."""

SECONDS = 0.3
"""Simulated time of a placement, as the label has it."""

LOOKS = 10
_HOPELESS = 2.0
"""Multiple of a threshold beyond which no box comes back within a placement."""

MOVED, TURNED = 0.1, 10.0
"""The label's thresholds [m], [degrees]."""

MOVED_AT_REST, TURNED_AT_REST = 1e-3, 0.5
"""Displacement and rotation above which a body is not at rest [m], [degrees]."""

PUSHED = 1.0
"""Speed of a box that slides to a stop [m/s]."""

SLIDE_SECONDS = 2.5
"""Simulated time of a slide [s], longer than any in the sweep lasts."""

FREE_SECONDS = 1.0
"""Simulated time of a box without friction [s]."""

CLOSE, HELD = 0.02, 0.1
"""Relative errors up to which a result is close, and held."""

BOUNCE_SLACK = 0.01
"""Rebound that counts as none, as a share of the drop."""


class Outcome(StrEnum):
    """Outcome of an engine in one cell of a sweep.

    ``close``: within the stricter of a sweep's two limits. ``held``: within the other one.
    ``failed``: beyond both, or diverged. ``no verdict``: no result within the time limit of a cell,
    or an error. ``undefined``: the engine has no such setting.
    """

    CLOSE = "close"
    HELD = "held"
    FAILED = "failed"
    NO_VERDICT = "no verdict"
    UNDEFINED = "undefined"

    @property
    def good(self) -> bool:
        """Within at least the wider limit."""
        return self in (Outcome.CLOSE, Outcome.HELD)


@dataclass(frozen=True, slots=True)
class Finding:
    """Outcome of an engine in a cell, with its numbers."""

    outcome: Outcome
    numbers: dict[str, float] = field(default_factory=dict)
    note: str = ""


def settle(
    stage: Stage,
    boxes: Sequence[Box],
    *,
    friction: float = runs.FRICTION,
    restitution: float = 0.0,
    edge: float | None = None,
) -> Finding:
    """One placement of boxes that are in balance: none may move.

    Args:
        stage: engine and frequency.
        boxes: at their planned poses.
        friction: of every contact.
        restitution: of every contact; it is emulated where the engine offers that.
        edge: of the boxes [m], where the displacement thresholds are one edge, and a hundredth of
            one at rest; None for the usual thresholds.
    """
    emulate = frozenset({"restitution"}) if restitution else frozenset()
    settings = WorldSettings(friction=friction, restitution=restitution, emulate=emulate)
    examiner = Examiner(boxes, Criterion.ADAMS, MOVED, TURNED)
    far, little = MOVED, MOVED_AT_REST
    if edge is not None:
        far, little = min(far, edge), min(little, 0.01 * edge)
    with stage.scene(boxes, settings) as world:
        before = energy(world)
        for _ in range(LOOKS):
            poses = stage.run(world, SECONDS / LOOKS)
            moved = float(examiner.corner_shifts(poses, np.arange(len(boxes))).max())
            turned = float(np.degrees(euler_angles(poses.quaternions)).max())
            if moved > _HOPELESS * far or turned > _HOPELESS * TURNED:
                break
        numbers = {
            "moved": 1e3 * moved,
            "turned": turned,
            "energy": 1e3 * (energy(world) - before),
        }
    if moved > far or turned > TURNED:
        return Finding(Outcome.FAILED, numbers)
    numbers["penetration"] = 1e3 * penetration(boxes, poses)
    close = moved <= little and turned <= TURNED_AT_REST
    return Finding(Outcome.CLOSE if close else Outcome.HELD, numbers)


def energy(world: FixedStepWorld) -> float:
    """Potential and kinetic energy over the whole weight: a height [m]."""
    poses, velocities = world.poses(), world.velocities()
    mass = np.array([box.mass for box in world.boxes])
    inverse = poses.quaternions * np.array([1.0, -1.0, -1.0, -1.0])
    spins = rotate(inverse, velocities.angular)
    turning = (np.array([box.inertia for box in world.boxes]) * spins**2).sum()
    moving = (mass * (velocities.linear**2).sum(axis=1)).sum()
    return float((mass @ poses.centres[:, 2] + 0.5 * (moving + turning) / GRAVITY) / mass.sum())


def penetration(boxes: Sequence[Box], poses: Poses) -> float:
    """Largest penetration between neighbours, and with the floor [m], for small angles.

    Neighbours are boxes that touch face to face at their planned poses; their penetration is the
    length by which their centres have approached along the normal of that face.
    """
    planned = np.array([box.centre for box in boxes])
    half = 0.5 * np.array([box.size for box in boxes])
    reach = half[:, None] + half[None]
    gaps = np.abs(planned[:, None] - planned[None]) - reach
    now = reach - np.abs(poses.centres[:, None] - poses.centres[None])
    deepest = float((half[:, 2] - poses.centres[:, 2])[_on_floor(planned, half)].max(initial=0.0))
    for axis in range(3):
        others = [a for a in range(3) if a != axis]
        level = 1e-9 * float(half.max())
        touching = (np.abs(gaps[..., axis]) <= level) & (gaps[..., others] < -level).all(axis=2)
        deepest = max(deepest, float(now[..., axis][touching].max(initial=0.0)))
    return deepest


def _on_floor(planned: np.ndarray, half: np.ndarray) -> np.ndarray:
    return planned[:, 2] <= half[:, 2] * (1.0 + 1e-9)


def plate(stage: Stage, past_edge: float) -> Finding:
    """A plate before an edge stays, one past it falls; ``past_edge`` in m."""
    boxes = scenes.plate_on_table(past_edge)
    if past_edge < 0.0:
        return settle(stage, boxes)
    with stage.scene(boxes, WorldSettings(friction=runs.FRICTION)) as world:
        turned = float(runs.total_angles(stage.run(world, SECONDS))[1])
    fell = turned > TURNED
    return Finding(Outcome.CLOSE if fell else Outcome.FAILED, {"turned": turned})


def items(stage: Stage, count: int) -> Finding:
    """Cubes without gaps; a wall of one cube's depth for an engine with two dimensions."""
    return settle(stage, scenes.pile(count, world_class(stage.engine).capabilities.dimensions))


def grid(stage: Stage, *, friction: float = runs.FRICTION, restitution: float = 0.0) -> Finding:
    """3 x 3 x 3 cubes without gaps; 3 x 3 for an engine with two dimensions."""
    facts = world_class(stage.engine).capabilities
    if _ignores_restitution(stage, restitution):
        return Finding(Outcome.UNDEFINED, note="not defined: no restitution")
    boxes = scenes.pile(3**facts.dimensions, facts.dimensions)
    return settle(stage, boxes, friction=friction, restitution=restitution)


def slide(stage: Stage, friction: float) -> Finding:
    """A flat box pushed along the floor comes to rest after v^2 / (2 mu g), or never."""
    seconds = SLIDE_SECONDS if friction else FREE_SECONDS
    expected = mechanics.stopping(PUSHED, friction) if friction else PUSHED * seconds
    box = Box(runs.FLAT, 2.0, (0.0, 0.0, 0.5 * runs.FLAT[2]))
    with stage.scene([box], WorldSettings(friction=friction)) as world:
        world.set_velocities(Velocities(np.array([[PUSHED, 0.0, 0.0]]), np.zeros((1, 3))))
        found = float(stage.run(world, seconds).centres[0, 0])
    return compared(found, expected)


def bounce(stage: Stage, restitution: float) -> Finding:
    """A cube that fell rebounds to e^2 of the height."""
    return compared(runs.bounce(stage, restitution), restitution**2, slack=BOUNCE_SLACK)


def tip(stage: Stage, past_edge: float) -> Finding:
    """A cube past an edge [m] turns by 10 degrees in the time that the pendulum needs."""
    size, angle = (runs.SIDE, runs.SIDE), float(np.radians(runs.TURNED))
    expected = mechanics.tipping_time(size, past_edge, angle)
    return compared(runs.time_to_turn(stage, past_edge), expected)


def overhang(stage: Stage, count: int) -> Finding:
    """The share of the harmonic overhangs at which a stack of blocks falls."""
    return compared(runs.overhang(stage, count, width=0.01, resolution=1e-3), 1.0)


def compared(found: float, expected: float, *, slack: float = 0.0) -> Finding:
    """Outcome of a comparison with a closed form; ``slack``: additional tolerance, same unit."""
    error = abs(found - expected)
    outcome = Outcome.FAILED
    if error <= CLOSE * abs(expected) + slack * CLOSE / HELD:
        outcome = Outcome.CLOSE
    elif error <= HELD * abs(expected) + slack:
        outcome = Outcome.HELD
    return Finding(outcome, {"found": found, "expected": expected})


def _ignores_restitution(stage: Stage, restitution: float) -> bool:
    settings = WorldSettings(restitution=restitution, emulate=frozenset({"restitution"}))
    return "restitution" in world_class(stage.engine).capabilities.ignored(settings)

"""Measurement of one cell of a sweep of :mod:`steadyload.studies.extremes.sweeps`.

Each function runs one engine at one frequency and returns the outcome.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from enum import StrEnum
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from steadyload.engines.attitudes import rotate
from steadyload.engines.world import GRAVITY, Box, FixedStepWorld, Poses, Velocities, WorldSettings
from steadyload.methods.simulation.criteria import Criterion, Examiner, euler_angles
from steadyload.properties import closed_forms as runs
from steadyload.properties import mechanics
from steadyload.properties.closed_forms import Stage
from steadyload.studies.extremes import scenes

VERSION = 1
"""Version of the measurement: raised when the same engine gets another cell."""

SECONDS, LOOKS = 0.3, 10
"""Simulated time of a placement, as the label has it, and at how many moments it is measured."""

_HOPELESS = 2.0
"""Multiple of a threshold beyond which no box comes back within a placement."""

MOVED, TURNED = 0.1, 10.0
"""The label's thresholds [m], [degrees]."""

MOVED_AT_REST, TURNED_AT_REST = 1e-3, 0.5
"""Displacement and rotation above which a body is not at rest [m], [degrees]."""

PUSHED = 1.0
"""Speed of a box that slides to a stop [m/s]."""

SLIDE_SECONDS, FREE_SECONDS = 2.5, 1.0
"""Simulated time of a box with friction, longer than any slides, and of one without [s]."""

CLOSE, HELD = 0.02, 0.1
"""Relative errors up to which a result is close, and held."""


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


class Finding(NamedTuple):
    """Outcome of an engine in a cell, its numbers, and a remark."""

    outcome: Outcome
    numbers: Mapping[str, float] = MappingProxyType({})
    note: str = ""


def settle(
    stage: Stage,
    boxes: Sequence[Box],
    settings: WorldSettings | None = None,
    *,
    sized: bool = False,
) -> Finding:
    """One placement of boxes that are in balance: none may move.

    Args:
        stage: engine and frequency.
        boxes: at their planned poses.
        settings: of the world; None for the usual ones.
        sized: whether displacement thresholds are an edge of the lowest box, and a hundredth of it
            at rest, where that is less than the usual ones.
    """
    examiner = Examiner(boxes, Criterion.ADAMS, MOVED, TURNED)
    far, little = MOVED, MOVED_AT_REST
    if sized:
        far, little = min(far, edge := boxes[0].size[0]), min(little, 0.01 * edge)
    with stage.scene(boxes, settings or WorldSettings()) as world:
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
    on_floor = planned[:, 2] <= half[:, 2] * (1.0 + 1e-9)
    deepest = float((half[:, 2] - poses.centres[:, 2])[on_floor].max(initial=0.0))
    for axis in range(3):
        others = [a for a in range(3) if a != axis]
        level = 1e-9 * float(half.max())
        touching = (np.abs(gaps[..., axis]) <= level) & (gaps[..., others] < -level).all(axis=2)
        deepest = max(deepest, float(now[..., axis][touching].max(initial=0.0)))
    return deepest


def plate(stage: Stage, past_edge: float) -> Finding:
    """A plate before an edge stays, one past it falls; ``past_edge`` in m."""
    boxes = scenes.plate_on_table(past_edge)
    if past_edge < 0.0:
        return settle(stage, boxes)
    with stage.scene(boxes, WorldSettings()) as world:
        turned = float(runs.total_angles(stage.run(world, SECONDS))[1])
    fell = turned > TURNED
    return Finding(Outcome.CLOSE if fell else Outcome.FAILED, {"turned": turned})


def slide(stage: Stage, friction: float) -> Finding:
    """A flat box pushed along the floor comes to rest after v^2 / (2 mu g), or never."""
    seconds = SLIDE_SECONDS if friction else FREE_SECONDS
    expected = mechanics.stopping(PUSHED, friction) if friction else PUSHED * seconds
    with stage.scene(runs.stacked(runs.FLAT, [2.0]), WorldSettings(friction=friction)) as world:
        world.set_velocities(Velocities(np.array([[PUSHED, 0.0, 0.0]]), np.zeros((1, 3))))
        found = float(stage.run(world, seconds).centres[0, 0])
    return compared(found, expected)


def compared(found: float, expected: float, *, slack: float = 0.0) -> Finding:
    """Outcome of a comparison with a closed form; ``slack``: additional tolerance, same unit."""
    error = abs(found - expected)
    outcome = Outcome.FAILED
    if error <= CLOSE * abs(expected) + slack * CLOSE / HELD:
        outcome = Outcome.CLOSE
    elif error <= HELD * abs(expected) + slack:
        outcome = Outcome.HELD
    return Finding(outcome, {"found": found, "expected": expected})

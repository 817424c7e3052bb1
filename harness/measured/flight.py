"""Free flight before the first impact, and what it says of a body and of its record."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from steadyload.engines.attitudes import lengths, rotate
from steadyload.engines.world import GRAVITY
from steadyload.escaping import shown
from steadyload.measured.errors import MotionError
from steadyload.measured.motion import FEWEST, FloatArray, Trial
from steadyload.statistics.clusters import Clusters
from steadyload.statistics.estimate import Estimate

CLEAR = 0.003
"""Height of the lowest corner above the floor from which on a body is in free flight [m]."""

_LONG_ENOUGH = 6
"""Frames in free flight from which on a trial says something of the body."""

_SINGULAR = 1e9
"""Condition number of the equations above which offsets do not follow from them."""

_PASSES = 3
"""Times that trials are weighted anew by what they leave unexplained."""

_LEAST = 1e-10
"""Sum of squares that is added to what a trial leaves unexplained [m2]: a hundredth of a mm each in
some frames, so that no trial without noise has all the weight."""


def flight_frames(trial: Trial) -> int:
    """Number of frames from the first one on in which a body flies, the last before a contact less.

    Args:
        trial: of a body whose size is known.

    Raises:
        MotionError: the size is not known, or it flies for less than three frames.
    """
    corners = trial.corners
    if corners is None:
        raise MotionError(
            f"trial {shown(trial.name)}: its size is not known; allowed: a trial with size_x, "
            "size_y and size_z"
        )
    near = np.flatnonzero(corners[:, :, 2].min(axis=1) < CLEAR)
    count = int(near[0]) - 1 if len(near) else len(trial)
    if count < FEWEST:
        raise MotionError(
            f"trial {shown(trial.name)}: flies freely for {max(count, 0)} frames; allowed: "
            f"{FEWEST} or more from the first one on, {1e3 * CLEAR:g} mm above the floor"
        )
    return count


def scaled(trial: Trial, factor: float) -> Trial:
    """A trial whose positions and velocities are multiplied by a factor; its body is as it was."""
    speeds = trial.velocities
    return replace(
        trial,
        positions=factor * trial.positions,
        velocities=None if speeds is None else factor * speeds,
    )


@dataclass(frozen=True)
class FlightFacts:
    """The centre of mass of a body and the gravity in its record, by its free flight alone.

    Attributes:
        mass_offset: centre of mass minus geometric centre, in the body's axes [m].
        gravity: acceleration of the centre of mass, downwards, in the lengths of the record [m/s2].
    """

    mass_offset: tuple[Estimate, Estimate, Estimate]
    gravity: Estimate

    @property
    def offset(self) -> tuple[float, float, float]:
        """The offset without its intervals [m]."""
        x, y, z = (part.value for part in self.mass_offset)
        return x, y, z

    @property
    def scale(self) -> float:
        """Factor by which lengths of the record are too short, by its gravity."""
        return GRAVITY / self.gravity.value


def flight_facts(trials: Sequence[Trial]) -> FlightFacts:
    """The centre of mass of a body and the gravity in its record, by least squares.

    In free flight the centre of mass moves on a parabola, and the geometric centre is off it by
    the offset, turned by the attitude: c(t) = p + v t + g t^2 / 2 - R(t) r. Each trial has its own
    p and v; r and the size of g are of all. Trials are weighted by what they leave unexplained, so
    that a few badly tracked ones do not decide. Intervals are of resampled trials.

    Args:
        trials: of one body, whose size is known.

    Raises:
        MotionError: see :func:`flight_frames`; fewer than two trials fly for six frames or more, or
            the body does not turn enough.
    """
    parts = [
        _equations(trial, n) for trial in trials if (n := flight_frames(trial)) >= _LONG_ENOUGH
    ]
    if len(parts) < 2:
        raise MotionError(
            f"{len(parts)} trials fly freely for {_LONG_ENOUGH} frames; allowed: 2 or more"
        )
    weights = np.ones(len(parts))
    for _ in range(_PASSES):
        left = np.array([w * a.T @ a for w, (a, _) in zip(weights, parts, strict=True)])
        right = np.array([w * a.T @ b for w, (a, b) in zip(weights, parts, strict=True)])
        if np.linalg.cond(left.sum(axis=0)) > _SINGULAR:
            raise MotionError("the body does not turn in flight; allowed: one that does")
        found = np.linalg.solve(left.sum(axis=0), right.sum(axis=0))
        weights = np.array([len(b) / (((b - a @ found) ** 2).sum() + _LEAST) for a, b in parts])
    drawn = np.concatenate(
        [
            (np.linalg.pinv(left[k].sum(axis=1)) @ right[k].sum(axis=1)[..., None])[..., 0]
            for k in Clusters.of(None, len(parts)).resamples()
        ]
    )
    low, high = np.quantile(drawn, (0.025, 0.975), axis=0)
    x, y, z, gravity = (
        Estimate(float(value), float(least), float(most), len(parts))
        for value, least, most in zip(found, low, high, strict=True)
    )
    return FlightFacts((x, y, z), gravity)


def _equations(trial: Trial, count: int) -> tuple[FloatArray, FloatArray]:
    """Coefficients of offset and gravity, and positions, without what p and v of a trial explain.

    Shapes (3 n, 4) and (3 n,).
    """
    times = trial.times[:count] - trial.times[0]
    turns = trial.attitudes[:count] / lengths(trial.attitudes[:count])[:, None]
    columns = np.zeros((count, 3, 4))
    for axis, unit in enumerate(np.eye(3)):
        columns[:, :, axis] = -rotate(turns, np.tile(unit, (count, 1)))
    columns[:, 2, 3] = -0.5 * times**2
    lines, _ = np.linalg.qr(np.stack([np.ones(count), times], axis=1))
    rest = np.eye(count) - lines @ lines.T
    left = np.einsum("ij,jkl->ikl", rest, columns).reshape(-1, 4)
    return left, (rest @ trial.positions[:count]).reshape(-1)

"""Quantities that follow from recorded motion: velocities, the face below, rest, impacts."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from steadyload.engines.attitudes import lengths, rotate
from steadyload.measured.motion import FloatArray, Trial

REST_SPEED, REST_SPIN = 0.05, 0.5
"""Speed [m/s] and angular speed [rad/s] below which a body is at rest."""

LEAST_JUMP = 0.2
"""Rise of the vertical velocity from which on it counts as an impact [m/s]."""


@dataclass(frozen=True)
class Face:
    """The face of a body that points down.

    Attributes:
        name: axis of the body along its outward normal: ``-x``, ``+x``, ``-y``, ``+y``, ``-z``,
            ``+z``.
        tilt_deg: angle between that normal and straight down [degrees], 0 to 54.7.
    """

    name: str
    tilt_deg: float


def face_down(attitude: FloatArray) -> Face:
    """The face that points down most.

    Args:
        attitude: unit quaternion w, x, y, z, from the body's axes to the world's, shape (4,).
    """
    unit = np.asarray(attitude, dtype=np.float64)
    unit = np.tile(unit / np.linalg.norm(unit), (3, 1))
    heights = rotate(unit, np.eye(3))[:, 2]  # of the body's axes
    axis = int(abs(heights).argmax())
    sign = "-" if heights[axis] > 0.0 else "+"
    return Face(sign + "xyz"[axis], math.degrees(math.acos(min(1.0, abs(float(heights[axis]))))))


def velocities(trial: Trial) -> FloatArray:
    """Velocities of the centre, world axes [m/s], shape (n, 3): those given, else by differences.

    Differences are of second order, at the first and last frame, too: exact in free flight.
    """
    if trial.velocities is not None:
        return trial.velocities
    found: FloatArray = np.gradient(trial.positions, trial.times, axis=0, edge_order=2)
    return found


def spins(trial: Trial) -> FloatArray:
    """Angular velocities in the body's axes [rad/s], shape (n, 3): given, else by differences.

    The rate of each span between frames is the turn in it over its time; a frame between two spans
    has the rate that is linear between their middles. Exact where the rate is constant. A body
    that turns by more than half a turn in a span is seen to turn the other way.
    """
    if trial.spins is not None:
        return trial.spins
    spans = np.diff(trial.times)
    rates = _turns(trial.attitudes) / spans[:, None]
    before, after = spans[:-1, None], spans[1:, None]
    inner = (after * rates[:-1] + before * rates[1:]) / (before + after)
    return np.concatenate([rates[:1], inner, rates[-1:]])


def _turns(attitudes: FloatArray) -> FloatArray:
    """Rotation vectors from each frame to the next, in the body's axes [rad], shape (n - 1, 3)."""
    unit = attitudes / lengths(attitudes)[:, None]
    back, ahead = unit[:-1] * (1.0, -1.0, -1.0, -1.0), unit[1:]
    real = back[:, 0] * ahead[:, 0] - (back[:, 1:] * ahead[:, 1:]).sum(axis=1)
    axes = (
        back[:, :1] * ahead[:, 1:]
        + ahead[:, :1] * back[:, 1:]
        + np.cross(back[:, 1:], ahead[:, 1:])
    )
    axes[real < 0.0] *= -1.0
    sines = lengths(axes)
    angles = 2.0 * np.arctan2(sines, abs(real))
    scale = np.divide(angles, sines, out=np.full_like(angles, 2.0), where=sines > 0.0)
    found: FloatArray = axes * scale[:, None]
    return found


def rest_frame(trial: Trial, speed: float = REST_SPEED, spin: float = REST_SPIN) -> int | None:
    """The first frame from which on a body stays at rest; None for one that moves in the end.

    Args:
        trial: the motion.
        speed: below which it is at rest [m/s].
        spin: likewise, of its rotation [rad/s].
    """
    still = (lengths(velocities(trial)) < speed) & (lengths(spins(trial)) < spin)
    moving = np.flatnonzero(~still)
    first = int(moving[-1]) + 1 if len(moving) else 0
    return first if first < len(trial) else None


def time_to_rest(trial: Trial, speed: float = REST_SPEED, spin: float = REST_SPIN) -> float | None:
    """Time from the first frame until a body stays at rest [s]; None for one that moves in the end.

    Args:
        trial: the motion.
        speed: see :func:`rest_frame`.
        spin: likewise.
    """
    frame = rest_frame(trial, speed, spin)
    return None if frame is None else float(trial.times[frame] - trial.times[0])


def resting_height(trial: Trial) -> float | None:
    """Height of the centre at rest, on average over its frames [m]; None without rest."""
    frame = rest_frame(trial)
    return None if frame is None else float(trial.positions[frame:, 2].mean())


def impacts(trial: Trial, least: float = LEAST_JUMP) -> tuple[float, ...]:
    """Times of impacts [s]: jumps of the vertical velocity.

    Gravity lets it fall and a resting contact keeps it, so that only an impact makes it rise. A
    rise counts as one impact, over however many frames it is spread; its time is the middle of the
    span in which it is steepest.

    Args:
        trial: the motion.
        least: rise of the vertical velocity that counts [m/s].
    """
    rises = np.diff(velocities(trial)[:, 2])
    middles = 0.5 * (trial.times[1:] + trial.times[:-1])
    slopes = rises / np.diff(trial.times)
    found = []
    edges = np.flatnonzero(np.diff(np.concatenate([[False], rises > 0.0, [False]]).astype(int)))
    for first, last in zip(edges[::2], edges[1::2], strict=True):
        if rises[first:last].sum() >= least:
            found.append(float(middles[first + int(slopes[first:last].argmax())]))
    return tuple(found)

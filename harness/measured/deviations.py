"""How far a simulated trial is from the record of it: at rest, on its way, and through impacts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from steadyload.engines.attitudes import degrees_apart
from steadyload.measured.derived import face_down, impacts, resting_height, time_to_rest
from steadyload.measured.motion import Trial

_BEFORE = 0.015
"""Time before an impact at which a body counts as not yet struck [s]: two frames at 148 Hz, over
which a smoothed velocity shows the impact already."""


@dataclass(frozen=True)
class Deviation:
    """A simulated trial at its end, and its differences from the record.

    Attributes:
        face: that points down in the end, such as ``-z``.
        same_face: whether that is the face of the record.
        off_m: horizontal distance of the last positions [m].
        turn_deg: angle between the last attitudes [degrees].
        height_m: of the centre at rest [m]; None where it moves in the end.
        deepest_m: height of the lowest corner at the lowest, of all frames [m]; 0 or less.
        rest_s: time from the first frame to rest [s]; None where it moves in the end.
    """

    face: str
    same_face: bool
    off_m: float
    turn_deg: float
    height_m: float | None
    deepest_m: float
    rest_s: float | None


def deviation(record: Trial, found: Trial) -> Deviation:
    """How far a simulated trial is from the record of it in the end.

    Args:
        record: as measured.
        found: as :func:`steadyload.measured.simulating.simulated` gives it.
    """
    face, wanted = (face_down(one.attitudes[-1]).name for one in (found, record))
    corners = found.corners
    ends = (one.attitudes[-1] / np.linalg.norm(one.attitudes[-1]) for one in (found, record))
    return Deviation(
        face,
        face == wanted,
        float(np.linalg.norm(found.positions[-1, :2] - record.positions[-1, :2])),
        degrees_apart(*ends),
        resting_height(found),
        0.0 if corners is None else min(0.0, float(corners[:, :, 2].min())),
        time_to_rest(found),
    )


def distances(record: Trial, found: Trial, times: Sequence[float]) -> list[float | None]:
    """Distances of the centres at some times [m].

    Args:
        record: as measured; from its last frame on it stays where it is.
        found: the same frames, and more.
        times: from the first frame [s]; between frames positions are linear.

    Returns:
        None at times before the first frame or after the last one of ``found``.
    """
    ours, theirs = found.times - record.times[0], record.times - record.times[0]
    apart = [
        np.interp(times, ours, found.positions[:, k])
        - np.interp(times, theirs, record.positions[:, k])
        for k in range(3)
    ]
    whole = np.sqrt(np.square(apart).sum(axis=0))
    return [float(d) if 0.0 <= t <= ours[-1] else None for d, t in zip(whole, times, strict=True)]


def before_impacts(record: Trial) -> list[float]:
    """Times just before the impacts of a record, and that of its last frame, from the first [s].

    The k-th one, from 0, is when the body has been through k impacts.
    """
    start = float(record.times[0])
    return [
        *(max(0.0, time - start - _BEFORE) for time in impacts(record)),
        float(record.times[-1]) - start,
    ]

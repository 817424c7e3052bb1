"""Chances of faces by releases that are moved within the noise, and their calibration."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial

import numpy as np
from numpy.typing import NDArray

from steadyload.reports.columns import column, decimal, general, percent, row
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.metrics import mean, share
from steadyload.statistics.reliability import reliability
from steadyload.studies.reality.record import FIT, MEASURED
from steadyload.studies.reality.releasing import FACES, Jittered
from steadyload.studies.reliability import Bin, calibrated

FloatArray = NDArray[np.float64]

_two_digits = partial(decimal, digits=2)

FACTORS = (0.5, 1.0, 2.0, 4.0)
"""Of the noise, among which one is chosen for each engine."""

AS_MEASURED = 1.0

WEIGHT = 1.0
"""Of one release, spread evenly over the faces: no face has the chance 0."""

EDGES = (0.0, 0.5, 0.7, 0.9, 0.97, 1.0)
"""Of bins of chances: most engines are nearly sure of most trials."""


@row
class Chances:
    """Chances of faces by an engine, with the noise times a factor, on a half."""

    engine: str = column(left=True)
    name: str
    half: str = column(left=True)
    factor: float = column("noise times", general)
    trials: int = column("n")
    likeliest: Estimate = column("likeliest face right %", percent)
    sure: Estimate = column("its chance %", percent, "on average")
    log_loss: Estimate = column("log loss", _two_digits)
    brier: Estimate = column("Brier", _two_digits, "sum over the faces")


@row
class Calibration:
    """Chances of an engine as measured and with the factor that suits the half for fitting best.

    Attributes:
        by_factor: on the half for fitting.
        plain: on the other half, with the noise as it is.
        chosen: on the other half, with the factor of least log loss on the half for fitting.
        bins: chances of the likeliest face there, and how often it was that one.
    """

    engine: str
    name: str
    by_factor: Sequence[Chances]
    plain: Chances
    chosen: Chances
    bins: Sequence[Bin]


def probabilities(counts: Sequence[Sequence[int]]) -> FloatArray:
    """Chances of faces, shape (trials, 6), of how often each was seen.

    The weight of one release is spread evenly over the faces, so that a face that was never seen
    is not impossible.
    """
    seen = np.asarray(counts, dtype=float)
    return (seen + WEIGHT / len(FACES)) / (seen.sum(axis=1, keepdims=True) + WEIGHT)


def log_losses(chances: FloatArray, faces: Sequence[str]) -> FloatArray:
    """Minus the logarithm of the chance of each recorded face."""
    found: FloatArray = -np.log(chances[np.arange(len(faces)), [FACES.index(f) for f in faces]])
    return found


def briers(chances: FloatArray, faces: Sequence[str]) -> FloatArray:
    """Sum over the faces of the squares of chance minus outcome, for each trial, 0 to 2."""
    happened = np.array([[face == one for one in FACES] for face in faces], dtype=float)
    found: FloatArray = np.square(chances - happened).sum(axis=1)
    return found


def _right(chances: FloatArray, faces: Sequence[str]) -> list[bool]:
    """Whether the likeliest face is the recorded one, by trial."""
    return [FACES[k] == face for k, face in zip(chances.argmax(axis=1), faces, strict=True)]


def chosen_factor(losses: Mapping[float, float]) -> float:
    """The factor of least log loss; of equals the one nearest to the noise as measured."""
    return min(losses, key=lambda one: (losses[one], abs(np.log(one))))


def chances(
    engine: str, name: str, half: str, factor: float, found: Jittered, faces: Mapping[str, str]
) -> Chances:
    """The row of some trials.

    Args:
        engine: its title.
        name: under which it is registered.
        half: of the record.
        factor: of the noise.
        found: how often each face was seen.
        faces: recorded ones by name of the trial.
    """
    wanted = [faces[trial] for trial in found.names]
    given = probabilities(found.counts)
    return Chances(
        engine,
        name,
        half,
        factor,
        len(wanted),
        share(_right(given, wanted)),
        mean(given.max(axis=1)),
        mean(log_losses(given, wanted)),
        mean(briers(given, wanted)),
    )


def calibration(
    engine: str, name: str, found: Mapping[tuple[str, float], Jittered], faces: Mapping[str, str]
) -> Calibration:
    """The chances of an engine, the factor chosen on the half for fitting.

    Args:
        engine: its title.
        name: under which it is registered.
        found: by half and factor; on the other half the noise as measured and the chosen one.
        faces: recorded ones by name of the trial.
    """
    rows = {
        (half, factor): chances(engine, name, half, factor, own, faces)
        for (half, factor), own in found.items()
    }
    by_factor = [one for (half, _), one in rows.items() if half == FIT]
    factor = chosen_factor({one.factor: one.log_loss.value for one in by_factor})
    own = found[MEASURED, factor]
    given = probabilities(own.counts)
    right = _right(given, [faces[trial] for trial in own.names])
    sure = reliability(given.max(axis=1), right, list(own.names), EDGES)
    bins = calibrated(engine, "likeliest face", sure).bins
    plain, chosen = rows[MEASURED, AS_MEASURED], rows[MEASURED, factor]
    return Calibration(engine, name, by_factor, plain, chosen, bins)

"""Chances of faces by releases that are moved within the noise, and their calibration."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from steadyload.statistics.metrics import mean, share
from steadyload.statistics.reliability import reliability
from steadyload.studies.reality.record import FIT, MEASURED
from steadyload.studies.reality.releasing import FACES, Jittered

FloatArray = NDArray[np.float64]

FACTORS = (0.5, 1.0, 2.0, 4.0)
"""Of the noise, among which one is chosen for each engine."""

AS_MEASURED = 1.0

WEIGHT = 1.0
"""Of one release, spread evenly over the faces: no face has the chance 0."""

EDGES = (0.0, 0.5, 0.7, 0.9, 0.97, 1.0)
"""Of bins of chances: most engines are nearly sure of most trials."""


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


def loss(found: Jittered, faces: Mapping[str, str]) -> float:
    """Log loss of some trials on average."""
    wanted = [faces[trial] for trial in found.names]
    return float(log_losses(probabilities(found.counts), wanted).mean())


def chances(found: Jittered, faces: Mapping[str, str]) -> dict[str, Any]:
    """How good the chances of faces of some trials are; arguments as of :func:`loss`.

    Returns:
        ``likeliest_face``: it is right; ``its_chance``, on average; ``brier``: sum over the faces.
    """
    wanted = [faces[trial] for trial in found.names]
    given = probabilities(found.counts)
    return {
        "trials": len(wanted),
        "likeliest_face": share(_right(given, wanted)),
        "its_chance": mean(given.max(axis=1)),
        "log_loss": mean(log_losses(given, wanted)),
        "brier": mean(briers(given, wanted)),
    }


def calibration(
    found: Mapping[tuple[str, float], Jittered], faces: Mapping[str, str]
) -> list[dict[str, Any]]:
    """The chances of an engine by half and factor of the noise.

    ``chosen``: the half for measuring, with the factor of least log loss on the half for fitting;
    it has ``bins``, chances of the likeliest face and how often it was that one.
    """
    best = chosen_factor({f: loss(one, faces) for (half, f), one in found.items() if half == FIT})
    rows = []
    for (half, factor), own in found.items():
        chosen = (half, factor) == (MEASURED, best)
        row = {"half": half, "factor": factor, "chosen": chosen, **chances(own, faces)}
        if chosen:
            given = probabilities(own.counts)
            right = _right(given, [faces[trial] for trial in own.names])
            row["bins"] = reliability(given.max(axis=1), right, list(own.names), EDGES).bins
        rows.append(row)
    return rows

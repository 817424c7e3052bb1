"""Calibration of a learned method's probabilities, of steps and of scores."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from steadyload.learners.features import Array32
from steadyload.learners.scoring import items_safe, names_the_label
from steadyload.learners.sequences import Sequences
from steadyload.statistics.reliability import Abstention, Reliability, abstention, reliability

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class MethodCalibration:
    """Calibration of one method's probabilities, of steps and of a layout's score."""

    title: str
    steps: Reliability
    layouts: Reliability
    abstention: Abstention


def calibration(title: str, probabilities: Array32, data: Sequences) -> MethodCalibration:
    """Calibration of a learned method's probabilities, of steps and of scores.

    Args:
        title: of the method.
        probabilities: that steps are unstable, (M, T).
        data: the same layouts with their labels.
    """
    steps = np.arange(probabilities.shape[1])
    told = steps < data.valid()[:, None]
    unstable = steps >= data.safe[:, None]
    together = np.broadcast_to(data.instances[:, None], told.shape)
    sure = sureness(probabilities, data.counts)
    right = names_the_label(probabilities, data)
    return MethodCalibration(
        title,
        reliability(probabilities[told], unstable[told], together[told]),
        reliability(sure, right, data.instances),
        abstention(sure, right, data.instances),
    )


def sureness(probabilities: Any, counts: NDArray[np.int64]) -> Floats:
    """Probability that a learned method gives to its own score, (M,).

    A step's probability is conditional on all steps before it being stable: labels end with the
    first unstable one. So a score of k has p_k (1 - p_0) ... (1 - p_(k-1)), and a stable layout the
    product of all 1 - p_j.

    Args:
        probabilities: that steps are unstable, (M, T); values after a layout's end are not used.
        counts: items of every layout, (M,).
    """
    unstable = np.asarray(probabilities, dtype=float)
    safe = items_safe(unstable, counts)
    steps = np.arange(unstable.shape[1])
    placed = np.where(steps < safe[:, None], 1.0 - unstable, 1.0).prod(axis=1)
    last = unstable[np.arange(len(safe)), np.minimum(safe, unstable.shape[1] - 1)]
    found: Floats = placed * np.where(safe < counts, last, 1.0)
    return found

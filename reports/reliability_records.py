"""How a judge's probabilities keep what they say, as small typed records."""

from __future__ import annotations

from dataclasses import dataclass

from steadyload.statistics.estimate import Estimate


@dataclass(frozen=True, slots=True)
class ReliabilityBin:
    """Predictions from ``low`` to ``high``: their ``mean``, and how often it ``happened``."""

    low: float
    high: float
    mean: float
    happened: Estimate


@dataclass(frozen=True, slots=True)
class Reliability:
    """How a probability keeps what it says.

    ``brier``: mean square of probability minus outcome. ``error``: expected calibration error, the
    mean over ``bins`` (of equal width) of the distance between the mean probability and the share
    that happened, weighted by the number of predictions.
    """

    brier: Estimate
    error: Estimate
    bins: tuple[ReliabilityBin, ...]


@dataclass(frozen=True, slots=True)
class Abstention:
    """What is won by not judging what a judge is least sure of.

    ``least``: how sure it must be to judge. ``curve``: (share of cases judged, the surest first;
    share of these that are wrong).
    """

    least: float
    every: Estimate
    sure: Estimate
    unsure: Estimate
    curve: tuple[tuple[float, float], ...]

"""Calibration of probabilities, and the accuracy gained by abstaining from uncertain cases."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from steadyload.statistics.clusters import Clusters
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.metrics import mean, share


@dataclass(frozen=True, slots=True)
class ReliabilityBin:
    """Predictions from ``low`` to ``high``: their ``mean``, and how often it ``happened``."""

    low: float
    high: float
    mean: float
    happened: Estimate


@dataclass(frozen=True, slots=True)
class Reliability:
    """Calibration of a probability.

    ``brier``: mean square of probability minus outcome. ``error``: expected calibration error, the
    mean over ``bins`` (of equal width) of the distance between the mean probability and the share
    that happened, weighted by the number of predictions.
    """

    brier: Estimate
    error: Estimate
    bins: tuple[ReliabilityBin, ...]


@dataclass(frozen=True, slots=True)
class Abstention:
    """Gain of abstaining from the cases that a method is least sure of.

    ``least``: least confidence to judge. ``curve``: (share of cases judged, the most certain first;
    share of these that are wrong).
    """

    least: float
    every: Estimate
    sure: Estimate
    unsure: Estimate
    curve: tuple[tuple[float, float], ...]


BINS = 10
EDGES = tuple(number / BINS for number in range(BINS + 1))
"""Of bins of equal width, from 0 to 1."""

UNSURE = 0.1
"""The share of cases that are not judged."""

_CURVE = 20
"""Places of the curve of risk against coverage."""


def reliability(
    said: ArrayLike,
    happened: ArrayLike,
    clusters: ArrayLike | pd.Series,
    edges: Sequence[float] = EDGES,
) -> Reliability:
    """Calibration of probabilities.

    The interval of the expected calibration error is a percentile bootstrap over clusters. Noise
    moves every bin away from its line, so that an interval leans upward, and that of a method
    without any error does not contain 0.

    Args:
        said: probabilities, 0 to 1, one or more.
        happened: whether each came true.
        clusters: a label for each; those of equal labels belong together.
        edges: of the bins, rising from 0 to 1; a probability on an edge is in the upper bin.
    """
    p, y = np.asarray(said, dtype=float), np.asarray(happened, dtype=float)
    together = pd.Series(clusters).to_numpy()
    groups = Clusters.of(together, len(p))
    count = len(edges) - 1
    where = np.minimum(np.searchsorted(edges, p, side="right") - 1, count - 1)
    shape = (len(groups), count)
    gaps, sizes = np.zeros(shape), np.zeros(shape)
    np.add.at(gaps, (groups.member, where), p - y)
    np.add.at(sizes, (groups.member, where), 1.0)
    drawn = np.concatenate(
        [
            np.abs(gaps[d].sum(axis=1)).sum(axis=1) / sizes[d].sum(axis=(1, 2))
            for d in groups.resamples()
        ]
    )
    low, high = np.quantile(drawn, (0.025, 0.975))
    error = float(np.abs(gaps.sum(axis=0)).sum() / len(p))
    bins = []
    for number, ends in enumerate(pairwise(edges)):
        inside = where == number
        if inside.any():
            happening = share(y[inside], together[inside])
            bins.append(ReliabilityBin(*ends, float(p[inside].mean()), happening))
    return Reliability(
        mean((p - y) ** 2, groups), Estimate(error, float(low), float(high), len(p)), tuple(bins)
    )


def abstention(sure: ArrayLike, right: ArrayLike, clusters: ArrayLike | pd.Series) -> Abstention:
    """Gain of abstaining from the tenth of the cases that a method is least sure of.

    Args:
        sure: how sure it is of each case, 0 to 1.
        right: whether it is right.
        clusters: a label for each; those of equal labels belong together.
    """
    certain, hits = np.asarray(sure, dtype=float), np.asarray(right, dtype=bool)
    together = pd.Series(clusters).to_numpy()
    order = np.argsort(-certain, kind="stable")
    judged = len(order) - round(UNSURE * len(order))
    first, last = order[:judged], order[judged:]
    wrong = np.cumsum(~hits[order]) / np.arange(1, len(order) + 1)
    places = [max(1, round(k / _CURVE * len(order))) for k in range(1, _CURVE + 1)]
    return Abstention(
        least=float(certain[first].min()),
        every=share(hits, together),
        sure=share(hits[first], together[first]),
        unsure=share(hits[last], together[last]),
        curve=tuple((place / len(order), float(wrong[place - 1])) for place in places),
    )

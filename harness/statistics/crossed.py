"""Standard errors where cases belong together in two ways, as by item list and by heuristic."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from steadyload.statistics.clusters import Clusters, Labels


def crossed_errors(values: ArrayLike, first: Labels, second: Labels) -> tuple[float, float]:
    """The standard error of a mean by clusters of one kind, and by those of two that cross.

    The second is that of Cameron, Gelbach and Miller (2011, Journal of Business and Economic
    Statistics 29:238): the variance between clusters of the one kind, plus that between clusters of
    the other, less that between the cases of both alike; no less than the first.

    Args:
        values: a number for each case, of one case or more.
        first: a label for each case; cases with equal labels belong together.
        second: likewise.
    """
    array = np.asarray(values, dtype=float)
    apart = array - array.mean()
    kinds = [Clusters.of(labels, len(array)) for labels in (first, second)]
    both = kinds[0].member * len(kinds[1]) + kinds[1].member
    one, other, shared = (
        _variance(apart, groups) for groups in (*kinds, Clusters.of(both, len(array)))
    )
    return math.sqrt(one), math.sqrt(max(one, one + other - shared))


def _variance(apart: NDArray[np.float64], groups: Clusters) -> float:
    """Variance of a mean, of what each case differs from it."""
    return float((groups.sums(apart) ** 2).sum()) / len(apart) ** 2

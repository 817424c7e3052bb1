"""Growth of a cost with a size: the exponent of a power law, by least squares in log-log."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import stdtrit

from steadyload.statistics.estimate import NOTHING, Estimate


def slope(sizes: ArrayLike, costs: ArrayLike) -> float:
    """Exponent of the power law through some points; not a number for fewer than two sizes.

    Args:
        sizes: above 0.
        costs: above 0, one a size.
    """
    x, y = np.log(np.asarray(sizes, dtype=float)), np.log(np.asarray(costs, dtype=float))
    if len(set(x.tolist())) < 2:
        return math.nan
    return float(np.polyfit(x, y, 1)[0])


def exponent(sizes: ArrayLike, costs: ArrayLike, clusters: ArrayLike | None = None) -> Estimate:
    """The exponent with its 95 % interval: Student's, of the variance between clusters of points.

    The variance is that of least squares with clusters (CR1), with a degree of freedom less than
    there are clusters. With one cluster the ends of the interval are not numbers.

    Args:
        sizes: above 0.
        costs: above 0, one a size.
        clusters: a label for each point; points with equal labels are not independent.
    """
    value = slope(sizes, costs)
    if math.isnan(value):
        return NOTHING
    x, y = np.log(np.asarray(sizes, dtype=float)), np.log(np.asarray(costs, dtype=float))
    x, y = x - x.mean(), y - y.mean()
    _, member = np.unique(np.arange(len(x)) if clusters is None else clusters, return_inverse=True)
    count = int(member.max()) + 1
    half = math.nan
    if count > 1:
        scores = np.bincount(member, weights=x * (y - value * x))
        variance = count / (count - 1) * float(scores @ scores) / float(x @ x) ** 2
        half = float(stdtrit(count - 1, 0.975)) * math.sqrt(variance)
    return Estimate(value, value - half, value + half, len(x))

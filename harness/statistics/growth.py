"""Growth of a cost with a size: the exponent of a power law, by least squares in log-log."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from steadyload.statistics.estimate import NOTHING, Estimate
from steadyload.statistics.metrics import resamples


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
    """The exponent with its 95 % percentile-bootstrap interval over clusters of points.

    A resample in which all sizes are one says nothing and is left out. With one cluster the ends
    of the interval are not numbers.

    Args:
        sizes: above 0.
        costs: above 0, one a size.
        clusters: a label for each point; points with equal labels are drawn together.
    """
    x, y = np.log(np.asarray(sizes, dtype=float)), np.log(np.asarray(costs, dtype=float))
    value = slope(sizes, costs)
    if math.isnan(value):
        return NOTHING
    labels = np.arange(len(x)) if clusters is None else np.asarray(clusters)
    _, member = np.unique(labels, return_inverse=True)
    count = int(member.max()) + 1
    if count < 2:
        return Estimate(value, math.nan, math.nan, len(x))
    x, y = x - x.mean(), y - y.mean()
    terms = np.stack([np.ones(len(x)), x, y, x * x, x * y], axis=1)
    sums = np.zeros((count, 5))
    np.add.at(sums, member, terms)
    found = []
    for drawn in resamples(count):
        n, sx, sy, sxx, sxy = sums[drawn].sum(axis=1).T
        spread = n * sxx - sx * sx
        whole = spread > 1e-9 * n * n
        found.append((n * sxy - sx * sy)[whole] / spread[whole])
    low, high = np.quantile(np.concatenate(found), (0.025, 0.975))
    return Estimate(value, float(low), float(high), len(x))

"""Estimates with intervals. Every function is pure and deterministic.

Cases that share a layout, or an item list that several layouts were packed from, are not
independent. Wherever such cases are pooled, ``clusters`` says which belong together, by a label for
each as :meth:`steadyload.statistics.clusters.Clusters.of` takes it, and intervals are as wide as
the number of *clusters* allows.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike, NDArray
from scipy.special import bdtr

from steadyload.statistics.clusters import Clusters, Labels
from steadyload.statistics.estimate import NOTHING, Estimate
from steadyload.statistics.placed import items_placed_by_case

_Z = 1.959963984540054

_ROUNDING = 1e-9

RARE_CORRELATION = 0.02
"""Correlation of two cases of one cluster, of an event so rare that its own is not measurable.

That of the errors of all methods that are wrong on fewer than 5 % of the cases of a published
table, item lists as clusters, is 0.02 on average, and less for rarer errors. Such correlations fall
with the rate of an event (Gulliford and others 2005, Journal of Clinical Epidemiology 58:246).
"""


def share(hits: ArrayLike, clusters: Labels = None) -> Estimate:
    """A proportion with its 95 % Wilson interval.

    With clusters, the interval is taken at the effective sample size p (1 - p) / Var(p), where the
    variance is that between clusters of a stratum (Kish's design effect), at least the size that
    clusters of equal cases would have (their number, where they are of one size) and at most n.

    A few hits, and above all none, do not show how alike clusters are. So every interval reaches at
    least as far from 0, and from 1, as Wilson's for no hit among n / (1 + (m - 1) r) cases: Kish's
    design effect with m the size of the cluster of a case, on average over cases, and r
    :data:`RARE_CORRELATION`. No hit has exactly that interval, which is therefore never wider than
    that of any number of hits, and close to that of one. A single cluster counts as one case.

    Args:
        hits: what happened in each case, as booleans.
        clusters: a label for each case; cases with equal labels belong together.
    """
    happened = np.asarray(hits, dtype=float)
    n = len(happened)
    if n == 0:
        return NOTHING
    groups = Clusters.of(clusters, n)
    p = float(happened.mean())
    without = _size_without_hits(groups)
    _, least = _wilson(0.0, without)
    low, high = _wilson(p, without if p in (0.0, 1.0) else effective_size(happened, groups))
    return Estimate(p, min(low, 1.0 - least), max(high, least), n)


def mean(values: ArrayLike, clusters: Labels = None) -> Estimate:
    """A mean with its 95 % percentile-bootstrap interval (2000 resamples of clusters, drawn
    within their strata, fixed seed).

    Args:
        values: a number for each case.
        clusters: a label for each case; cases with equal labels are drawn together.
    """
    array = np.asarray(values, dtype=float)
    if len(array) == 0:
        return NOTHING
    groups = Clusters.of(clusters, len(array))
    sums, sizes = groups.sums(array), groups.sizes
    means = [sums[drawn].sum(axis=1) / sizes[drawn].sum(axis=1) for drawn in groups.resamples()]
    low, high = np.quantile(np.concatenate(means), (0.025, 0.975))
    return Estimate(float(array.mean()), float(low), float(high), len(array))


def median(values: ArrayLike) -> Estimate:
    """A median with the interval of order statistics that holds it in at least 95 % of samples.

    Of fewer than six values there is no such interval: it is their range.

    Args:
        values: independent ones.
    """
    found, array = quantile(values, 0.5), np.asarray(values, dtype=float)
    return dataclasses.replace(found, value=float(np.median(array))) if found.n else found


def quantile(values: ArrayLike, share: float) -> Estimate:
    """A quantile with the interval of order statistics that holds it in at least 95 % of samples.

    It is the least value that at least this share of the values does not exceed. The number of
    values below a quantile is binomial; at each end the interval leaves out as many
    values as have a chance of at most 2.5 % together. It ends with the values there are.

    Args:
        values: independent ones; some may be infinite.
        share: of all values that lie below it, above 0 and below 1.
    """
    ordered = np.sort(np.asarray(values, dtype=float))
    n = len(ordered)
    if n == 0:
        return NOTHING
    low = max(_left_out(n, share) - 1, 0)
    high = n - 1 - max(_left_out(n, 1.0 - share) - 1, 0)
    value = ordered[min(n - 1, math.ceil(share * n - _ROUNDING) - 1)]
    return Estimate(float(value), float(ordered[low]), float(ordered[high]), n)


def _left_out(n: int, share: float) -> int:
    """The number k for which fewer than k of n values lie below a quantile in at most 2.5 %."""
    return int(np.searchsorted(bdtr(np.arange(n), n, share), 0.025, side="right"))


def ratio(above: ArrayLike, below: ArrayLike, clusters: Labels = None) -> Estimate:
    """The ratio of two means over the same cases, with a 95 % percentile-bootstrap interval.

    Args:
        above: a number for each case.
        below: another, of a mean above 0.
        clusters: a label for each case; cases with equal labels are drawn together.
    """
    over, under = np.asarray(above, dtype=float), np.asarray(below, dtype=float)
    if len(over) == 0:
        return NOTHING
    groups = Clusters.of(clusters, len(over))
    top, bottom = groups.sums(over), groups.sums(under)
    drawn_ratios = [top[d].sum(axis=1) / bottom[d].sum(axis=1) for d in groups.resamples()]
    low, high = np.quantile(np.concatenate(drawn_ratios), (0.025, 0.975))
    return Estimate(float(over.sum() / under.sum()), float(low), float(high), len(over))


def weighted_share(
    hits: ArrayLike,
    strata: ArrayLike,
    weights: Mapping[str, float],
    clusters: ArrayLike | pd.Series | None = None,
) -> Estimate:
    """The shares of several strata, weighted, with a 95 % percentile-bootstrap interval.

    Resamples draw clusters over all these strata at once. One in which a stratum has no case says
    nothing and is left out.

    Args:
        hits: what happened in each case, as booleans.
        strata: the stratum of each case; cases of strata without a weight are left out.
        weights: by stratum, 0 or more, not all 0; they are taken relative to their sum.
        clusters: a label for each case; cases with equal labels are drawn together.

    Returns:
        Not a number where a stratum of weight above 0 has no case.
    """
    used = {stratum: weight for stratum, weight in weights.items() if weight > 0.0}
    member = pd.Index(list(used)).get_indexer(np.asarray(strata, dtype=object))
    kept = member >= 0
    happened, member = np.asarray(hits, dtype=float)[kept], member[kept]
    if len(set(member.tolist())) < len(used):
        return NOTHING
    labels = None if clusters is None else pd.Series(clusters).to_numpy()[kept]
    groups = Clusters.of(labels, len(happened))
    shape = (len(groups), len(used))
    sums, sizes = np.zeros(shape), np.zeros(shape)
    np.add.at(sums, (groups.member, member), happened)
    np.add.at(sizes, (groups.member, member), 1.0)
    factors = np.array(list(used.values())) / sum(used.values())
    found = []
    for drawn in groups.resamples():
        counts = sizes[drawn].sum(axis=1)
        whole = (counts > 0.0).all(axis=1)
        found.append((sums[drawn].sum(axis=1)[whole] / counts[whole]) @ factors)
    whole_ones = np.concatenate(found)
    low, high = np.quantile(whole_ones, (0.025, 0.975)) if len(whole_ones) else (math.nan, math.nan)
    value = (sums.sum(axis=0) / sizes.sum(axis=0)) @ factors
    return Estimate(float(value), float(low), float(high), len(happened))


def outcomes(results: pd.DataFrame) -> pd.DataFrame:
    """Verdicts as a table of numbers: rows (layout, scenario), a column per method.

    A value is the failing step, the number of items for a stable layout (so that equal values mean
    equal verdicts), and missing where a method has no verdict. Of several repetitions the first
    counts.
    """
    first = results[results["repetition"] == 0]
    placed = items_placed_by_case(first["failing_step"], first["item_count"])
    table = first.assign(said=placed.where(first["status"] == "done")).pivot(
        index=["layout", "scenario"], columns="method", values="said"
    )
    return table.astype("Int32")


def agreement(said: pd.DataFrame, first: str, second: str, clusters: Labels = None) -> Estimate:
    """Share of cases with the same failing step; a missing verdict agrees with nothing.

    Args:
        said: as :func:`outcomes` gives it.
        first: one of its columns.
        second: another.
        clusters: a label for each case; None takes the layouts.
    """
    together = said.index.get_level_values("layout") if clusters is None else clusters
    return share(same(said, first, second), together)


def same(said: pd.DataFrame, first: str, second: str) -> NDArray[np.bool_]:
    """Case by case: both methods have a verdict, and it is the same."""
    return (said[first] == said[second]).fillna(False).to_numpy(bool)


def effective_size(hits: ArrayLike, clusters: Labels) -> float:
    """Effective sample size of a proportion: the number of independent cases, see :func:`share`.

    Args:
        hits: what happened in each case, as booleans.
        clusters: a label for each case; cases with equal labels belong together.
    """
    happened = np.asarray(hits, dtype=float)
    n, p = len(happened), float(happened.mean())
    groups = Clusters.of(clusters, n)
    sums, sizes = groups.sums(happened), groups.sizes
    count = len(groups)
    if count == n:
        return n
    alike = n * n / float((sizes * sizes).sum())  # clusters of equal cases
    if count == 1 or p in (0.0, 1.0):
        return alike
    spread = groups.squared_spread(sums - p * sizes) / (n * n)
    return float(np.clip(p * (1 - p) / max(spread, 1e-300), alike, n))


def _size_without_hits(groups: Clusters) -> float:
    """Effective sample size where nothing happened, see :func:`share`."""
    if len(groups) == 1:
        return 1.0
    n, own_cluster = groups.sizes.sum(), (groups.sizes**2).sum() / groups.sizes.sum()
    return float(n / (1.0 + (own_cluster - 1.0) * RARE_CORRELATION))


def _wilson(p: float, n: float) -> tuple[float, float]:
    z2 = _Z * _Z
    middle = (p + z2 / (2 * n)) / (1 + z2 / n)
    half = _Z / (1 + z2 / n) * math.sqrt(p * (1 - p) / n + z2 / (4 * n * n))
    # At p = 0 and p = 1 the formula's own end is exact; floating point may miss it by an ulp.
    low = 0.0 if p == 0.0 else max(0.0, middle - half)
    high = 1.0 if p == 1.0 else min(1.0, middle + half)
    return low, high

"""Shares of several factors in the differences between answers to the same cases.

Each case is answered once for every combination of the factors' levels. The differences between
the answers to one case fall apart, without a rest, into those that each factor makes by itself and
those that several make together; and each of these into a part that is the same on all cases and a
part that hangs on the case (analysis of variance of a full factorial design with one observation a
cell; see for example Montgomery, Design and Analysis of Experiments, chapter 5).

A share of squares depends on how many levels a factor has, and includes a part of the differences
that the factor makes together with others. A variance component depends on neither: it is the
variance of a source over levels that are drawn at random, solved from mean squares, which allow for
the degrees of freedom (chapter 13 there). A negative one counts as 0.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from steadyload.statistics.clusters import Clusters, Labels
from steadyload.statistics.estimate import NOTHING, Estimate


@dataclass(frozen=True, slots=True)
class SourceShare:
    """Share of one factor, or of several together, in all differences between answers.

    Attributes:
        factors: names.
        whole: the share.
        always: the part of it that is the same on all cases.
        by_case: the rest of it, which differs from case to case.
        component: its share in the sum of all variance components.
    """

    factors: tuple[str, ...]
    whole: Estimate
    always: Estimate
    by_case: Estimate
    component: Estimate


def source_shares(
    answers: NDArray[np.float64], factors: Sequence[str], clusters: Labels = None
) -> list[SourceShare]:
    """Shares of all factors and of all their combinations, with 95 % bootstrap intervals.

    Args:
        answers: numbers, shape (cases, levels of the first factor, levels of the second, ...).
        factors: a name for each axis but the first.
        clusters: a label for each case; cases with equal labels are drawn together.

    Returns:
        Single factors first. Shares from 0 to 1, which add up to 1; not a number where all answers
        to each case are the same.
    """
    sets = [
        chosen
        for size in range(1, len(factors) + 1)
        for chosen in combinations(range(len(factors)), size)
    ]
    flat = answers.reshape(len(answers), int(np.prod(answers.shape[1:])))
    if not (flat != flat[:, :1]).any():
        return [_share_of(factors, chosen, (NOTHING,) * 4) for chosen in sets]
    groups = Clusters.of(clusters, len(answers))
    effects = [_effect(answers, chosen).reshape(len(answers), -1) for chosen in sets]
    squares = np.array([groups.sums((e * e).sum(axis=1)) for e in effects])
    sums = [np.array([groups.sums(column) for column in e.T]) for e in effects]
    sizes = groups.sizes
    components = _components_of_squares(answers.shape[1:], sets)

    def shares(drawn: NDArray[np.intp]) -> NDArray[np.float64]:
        return _shares(squares, sums, sizes, components, drawn)

    found = shares(np.arange(len(sizes))[None])[..., 0]
    drawn = np.concatenate([shares(block) for block in groups.resamples()], axis=-1)
    differing = np.isfinite(drawn).all(axis=(0, 1))
    low, high = np.quantile(drawn[..., differing], (0.025, 0.975), axis=-1)
    estimates = [
        [
            Estimate(float(found[k, s]), float(low[k, s]), float(high[k, s]), len(answers))
            for k in range(4)
        ]
        for s in range(len(sets))
    ]
    return [_share_of(factors, chosen, own) for chosen, own in zip(sets, estimates, strict=True)]


def _share_of(
    factors: Sequence[str], chosen: Sequence[int], shares: Sequence[Estimate]
) -> SourceShare:
    return SourceShare(tuple(factors[k] for k in chosen), *shares)


def _components_of_squares(
    levels: Sequence[int], sets: Sequence[tuple[int, ...]]
) -> NDArray[np.float64]:
    """Matrix that makes variance components of sums of squares, both by set of factors.

    The expected mean square of a set of factors is the sum of the components of all sets that
    contain it, each times the number of cells that share its levels.
    """
    expected = [
        [
            math.prod(levels[k] for k in range(len(levels)) if k not in other)
            if set(own) <= set(other)
            else 0.0
            for other in sets
        ]
        for own in sets
    ]
    freedom = np.array([math.prod(levels[k] - 1 for k in own) for own in sets], dtype=float)
    found: NDArray[np.float64] = np.linalg.inv(np.array(expected, dtype=float)) / freedom
    return found


def _effect(answers: NDArray[np.float64], chosen: Sequence[int]) -> NDArray[np.float64]:
    """By case, what some factors together add to the effects of fewer of them."""
    left = answers
    for axis in range(1, answers.ndim):
        mean = left.mean(axis=axis, keepdims=True)
        left = left - mean if axis - 1 in chosen else mean
    return np.broadcast_to(left, answers.shape)


def _shares(
    squares: NDArray[np.float64],
    sums: Sequence[NDArray[np.float64]],
    sizes: NDArray[np.float64],
    components: NDArray[np.float64],
    drawn: NDArray[np.intp],
) -> NDArray[np.float64]:
    """Shares (whole, always, by case, component) x (set of factors) x (resample)."""
    counts = sizes[drawn].sum(axis=1)
    whole = squares[:, drawn].sum(axis=2)
    always = np.array([(own[:, drawn].sum(axis=2) ** 2).sum(axis=0) / counts for own in sums])
    with np.errstate(invalid="ignore", divide="ignore"):
        parts = np.maximum(components @ whole, 0.0)
        shares = np.stack([whole, always, whole - always]) / whole.sum(axis=0)
        return np.concatenate([shares, (parts / parts.sum(axis=0))[None]])

"""Significant differences of methods: a paired test by item lists, corrected for many pairs.

Layouts packed from one item list are alike, so the item list counts as one observation. Under the
null hypothesis two methods are equally good on every list, and the sign of their difference there
is arbitrary. The p-value is the share of all sign assignments to the lists' differences that give a
sum at least as large as the observed one. The test is exact and assumes no normal law, which a few
lists of very different size do not follow. McNemar's test would count every case as an observation
of its own.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence, Set
from statistics import NormalDist

import numpy as np
from numpy.typing import ArrayLike

from steadyload.statistics.clusters import Clusters, Labels
from steadyload.statistics.estimate import Estimate

LEVEL = 0.05
"""Level of significance: two methods differ significantly if the corrected p is below this."""

POWER = 0.8
"""Probability with which a set shows a difference that it is said to show."""


def sign_flip(differences: ArrayLike, clusters: Labels) -> float:
    """The exact two-sided p of the sign-flip test, over all 2^lists ways to turn signs.

    Args:
        differences: by case, a whole number: 1 where only the first method is right, -1 where only
            the second is, 0 where they are alike.
        clusters: the item list of each case; signs turn list by list.

    Returns:
        The share of all ways in which the sum is at least as far from 0 as the one found, the one
        found among them. 1 without a case.
    """
    whole = np.asarray(differences, dtype=np.int64)
    if not len(whole):
        return 1.0
    groups = Clusters.of(clusters, len(whole))
    sums = np.zeros(len(groups), dtype=np.int64)
    np.add.at(sums, groups.member, whole)
    found, sizes = abs(int(sums.sum())), np.abs(sums[sums != 0])
    # The law of the sum, built list by list: exact, and as quick for 50 lists as for 5.
    law = np.ones(1)
    for size in sizes.tolist():
        wider = np.zeros(len(law) + 2 * size)
        wider[2 * size :] += 0.5 * law
        wider[: len(law)] += 0.5 * law
        law = wider
    reach = len(law) // 2
    return float(law[np.abs(np.arange(-reach, reach + 1)) >= found].sum())


def detectable(difference: Estimate, clusters: int, tests: int = 1) -> float:
    """The true difference that a set shows, which is found significant in four of five such sets.

    The probability is :data:`POWER`, by the normal law with the standard error that the interval
    of the difference stands for. The sign-flip test takes the squares of all differences for
    variance, also what is due to the difference itself: for z of the normal law a sum has to be
    z / sqrt(1 - z^2 / clusters) standard errors from 0.

    Args:
        difference: that was found between two methods on the set.
        clusters: number of item lists.
        tests: of the family; the level of each is :data:`LEVEL` over their number, which is that
            of the smallest p by Holm.
    """
    normal = NormalDist()
    error = (difference.high - difference.low) / (2.0 * normal.inv_cdf(0.975))
    z = normal.inv_cdf(1.0 - LEVEL / (2.0 * tests))
    if z * z >= clusters:
        return math.inf
    return error * (z / math.sqrt(1.0 - z * z / clusters) + normal.inv_cdf(POWER))


def holm(p_values: Sequence[float]) -> list[float]:
    """P-values corrected by Holm (1979): the chance that any of them is a false alarm is kept.

    The k-th smallest of m, k from 0, becomes (m - k) times itself, at least what the one before it
    became, at most 1.
    """
    corrected, so_far = [1.0] * len(p_values), 0.0
    for rank, place in enumerate(sorted(range(len(p_values)), key=lambda k: p_values[k])):
        so_far = max(so_far, min(1.0, (len(p_values) - rank) * p_values[place]))
        corrected[place] = so_far
    return corrected


def letters(order: Sequence[str], apart: Set[tuple[str, str]]) -> dict[str, str]:
    """A compact display of pairs: two names share a letter if they do not differ significantly.

    Args:
        order: all names, the best first: it has the letter a.
        apart: pairs that differ significantly, in either order.

    Returns:
        The letters of every name, such as ``ab``; beyond z come aa, ab, ... with a dot between.
    """
    place = {name: number for number, name in enumerate(order)}
    alike = {name: set(order) - {name} for name in order}
    for first, second in apart:
        alike[first].discard(second)
        alike[second].discard(first)
    groups = sorted(sorted(place[n] for n in group) for group in _cliques(alike))
    signs = [_letter(number) for number in range(len(groups))]
    between = "." if any(len(sign) > 1 for sign in signs) else ""
    return {
        name: between.join(s for s, g in zip(signs, groups, strict=True) if place[name] in g)
        for name in order
    }


def _cliques(alike: Mapping[str, Set[str]]) -> Iterator[set[str]]:
    """Largest groups of which all are alike (Bron and Kerbosch 1973, with a pivot)."""

    def grow(group: set[str], open_: set[str], done: set[str]) -> Iterator[set[str]]:
        if not open_ and not done:
            yield group
            return
        pivot = max(sorted(open_ | done), key=lambda name: len(open_ & alike[name]))
        for name in sorted(open_ - alike[pivot]):
            yield from grow(group | {name}, open_ & alike[name], done & alike[name])
            open_ = open_ - {name}
            done = done | {name}

    yield from grow(set(), set(alike), set())


def _letter(number: int) -> str:
    alphabet = "abcdefghijklmnopqrstuvwxyz"
    if number < len(alphabet):
        return alphabet[number]
    return _letter(number // len(alphabet) - 1) + alphabet[number % len(alphabet)]

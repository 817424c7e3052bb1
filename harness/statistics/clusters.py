"""Cases that belong together, and the resamples that draw them together.

Cases that share a layout (the same geometry in several scenarios), or an item list that several
layouts were packed from, are not independent: they are a *cluster*. Clusters of one *stratum*, such
as the item lists of one class of items, take each other's place in a resample, and only they: how
many of each stratum there are was fixed when the cases were chosen, and is no matter of chance.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike, NDArray

RESAMPLES = 2000
_SEED = 0
FEWEST = 10
"""Clusters of a stratum. Resamples within a smaller one vary too little, by a share of one over
their number, so that strata with fewer are put together."""

_BLOCK = 4_000_000
"""Numbers that are drawn at once."""


Labels: TypeAlias = "Clusters | ArrayLike | pd.Series | None"
"""What says which cases belong together; see :meth:`Clusters.of`."""


@dataclass(frozen=True, eq=False)
class Clusters:
    """The cluster of each of some cases.

    Attributes:
        member: number of the cluster of every case, shape (cases,).
        strata: numbers of the clusters of every stratum, those with fewer than :data:`FEWEST` put
            together, and with the smallest other one where they are too few even so.
    """

    member: NDArray[np.intp]
    strata: tuple[NDArray[np.intp], ...]

    @staticmethod
    def of(labels: Labels, count: int) -> Clusters:
        """The clusters of ``count`` cases.

        Args:
            labels: a label for each case; cases with equal labels belong together. A label that is
                a pair is of a cluster and its stratum, the stratum first. None: every case is a
                cluster of its own.
            count: number of cases.
        """
        if isinstance(labels, Clusters):
            return labels
        if labels is None:
            everyone = np.arange(count)
            return Clusters(everyone, (everyone,))
        member, names = pd.factorize(pd.Series(labels).to_numpy(), sort=True)
        found: tuple[NDArray[np.intp], ...] = (np.arange(len(names)),)
        if len(names) and isinstance(names[0], tuple):
            of, strata = pd.factorize(np.array([stratum for stratum, _ in names]))
            found = tuple(np.flatnonzero(of == number) for number in range(len(strata)))
        return Clusters(member, _large_enough(found))

    def __len__(self) -> int:
        """Number of clusters."""
        return sum(map(len, self.strata))

    def sums(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """The sum of some values over every cluster, of a value for each case."""
        return np.bincount(self.member, weights=values, minlength=len(self)).astype(float)

    @property
    def sizes(self) -> NDArray[np.float64]:
        """Number of cases of every cluster."""
        return np.bincount(self.member, minlength=len(self)).astype(float)

    def squared_spread(self, found: NDArray[np.float64]) -> float:
        """Variance of a sum over clusters, estimated from that between clusters of a stratum.

        Args:
            found: a number for each cluster; two clusters or more.
        """
        return sum(
            float(((found[own] - found[own].mean()) ** 2).sum()) * len(own) / (len(own) - 1)
            for own in self.strata
        )

    def resamples(self) -> Iterator[NDArray[np.intp]]:
        """The clusters that every resample draws, the same at every call.

        Yields:
            Blocks that fit in memory, shape (resamples, clusters).
        """
        random = np.random.default_rng(_SEED)
        block = max(1, _BLOCK // len(self))
        for start in range(0, RESAMPLES, block):
            rows = min(block, RESAMPLES - start)
            drawn = [own[random.integers(0, len(own), (rows, len(own)))] for own in self.strata]
            yield np.concatenate(drawn, axis=1)


def _large_enough(strata: tuple[NDArray[np.intp], ...]) -> tuple[NDArray[np.intp], ...]:
    """Strata of :data:`FEWEST` clusters or more, as far as there are so many."""
    ordered = sorted(strata, key=len)
    kept = [own for own in ordered if len(own) >= FEWEST]
    few = [own for own in ordered if len(own) < FEWEST]
    if few and kept and sum(map(len, few)) < FEWEST:
        few.append(kept.pop(0))
    return (*([np.sort(np.concatenate(few))] if few else []), *kept)

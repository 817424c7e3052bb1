"""Methods compared on the cases of a run: with one of them, two by two, and by slices of the cases.

Frames of verdicts are compared by :mod:`steadyload.runs.frames`, with the same tests.

All numbers are of methods on the same cases. Intervals and tests count *clusters* of cases, such as
those of one item list, see :mod:`steadyload.statistics.clusters`. A p-value is that of the exact
sign-flip test (:mod:`steadyload.statistics.paired`), corrected by Holm over its *family*: the tests
that support one statement together.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import combinations
from operator import attrgetter
from typing import Any, Generic, TypeAlias, TypeVar

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike, NDArray

from steadyload.methods.naming import MethodKey
from steadyload.reports.columns import column, compact, percent, row
from steadyload.runs.accuracy import accuracy, verdicts_against_labels
from steadyload.runs.judged import JudgedCases
from steadyload.statistics.clusters import Clusters, Labels
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.metrics import mean, share
from steadyload.statistics.paired import LEVEL, holm, letters, sign_flip
from steadyload.statistics.paired import detectable as detectable

M = TypeVar("M", bound=Hashable)
"""What names a method."""

BoolArray: TypeAlias = NDArray[np.bool_]


@row
class PairTest(Generic[M]):
    """Two methods on the cases that both have.

    Attributes:
        first, second: the methods.
        difference: accuracy of the first minus that of the second, -1 to 1.
        only_first, only_second: share of the cases on which the one is right and the other wrong.
        p: of the sign-flip test over clusters; 1 where there is no case.
        corrected: that p, corrected for the tests of its family.
    """

    first: M = column(form=attrgetter("title"), left=True)
    second: M = column(form=attrgetter("title"), left=True)
    difference: Estimate = column(form=percent)
    only_first: Estimate
    only_second: Estimate
    p: float = column(form=compact)
    corrected: float = column("corrected p", compact)

    @property
    def n(self) -> int:
        """Number of cases."""
        return self.difference.n

    @property
    def distance(self) -> float:
        """The difference without its sign."""
        return abs(self.difference.value)

    @property
    def significant(self) -> bool:
        """Whether the two differ significantly, at the level :data:`LEVEL` for the family."""
        return self.corrected < LEVEL

    @property
    def turned(self) -> PairTest[M]:
        """The same test with its methods in reverse order."""
        d = self.difference
        difference = Estimate(-d.value, -d.high, -d.low, d.n)
        return PairTest(self.second, self.first, difference, self.only_second, self.only_first,
                        self.p, self.corrected)  # fmt: skip


@dataclass(frozen=True, slots=True)
class Family(Generic[M]):
    """Tests that support one statement together, their p-values corrected for their number.

    Attributes:
        tests: of which no two are of the same methods.
        sizes: number of cases of every cluster, the largest first.
        against: the second method of every test; None where there is no such one.
        letters: by method; two that share a letter do not differ significantly, and the most
            accurate method has the letter a. Empty where not all pairs were tested.
    """

    tests: tuple[PairTest[M], ...]
    sizes: tuple[int, ...]
    against: M | None = None
    letters: Mapping[M, str] = field(default_factory=dict)

    @property
    def least(self) -> float:
        """The smallest corrected p that is possible with so many clusters and tests."""
        return min(1.0, len(self.tests) * 2.0 ** (1 - len(self.sizes)))

    @property
    def alike(self) -> Alike[M]:
        """The tests that find no significant difference, and what they could have found."""
        tests = [test for test in self.tests if not test.significant]
        shown = [detectable(test.difference, len(self.sizes), len(self.tests)) for test in tests]
        some = [least for least in shown if 0.0 < least < math.inf]
        return Alike(tests, len(self.tests), (min(some), max(some)) if some else ())

    def of(self, first: M, second: M) -> PairTest[M]:
        """The test of two methods, turned where they were tested in reverse order.

        Raises:
            KeyError: these two were not tested.
        """
        for test in self.tests:
            if (test.first, test.second) == (first, second):
                return test
            if (test.first, test.second) == (second, first):
                return test.turned
        raise KeyError(first, second)

    def only(self, asked: Callable[[PairTest[M]], bool]) -> Family[M]:
        """Some of the tests, as a family of their own.

        Args:
            asked: whether a test belongs to the family.
        """
        return replace(self, tests=_corrected(filter(asked, self.tests)), letters={})

    def versus(self, against: M) -> Family[M]:
        """Of all pairs those with one method: each of the others minus it, a family of their own.

        It says which methods differ from this one; pairs among the others do not.
        """
        others = dict.fromkeys(m for test in self.tests for m in (test.first, test.second))
        tests = _corrected(self.of(method, against) for method in others if method != against)
        return Family(tests, self.sizes, against)


@dataclass(frozen=True, slots=True)
class Alike(Generic[M]):
    """Tests of a family that find no significant difference.

    Attributes:
        tests: the tests.
        others: number of all tests of the family.
        shown: least and largest difference of accuracies that the set shows of these pairs, see
            :func:`steadyload.statistics.paired.detectable`; empty where it shows none.
    """

    tests: Sequence[PairTest[M]]
    others: int
    shown: tuple[float, float] | tuple[()]


@dataclass(frozen=True, slots=True)
class Slice(Generic[M]):
    """Cases that have something in common.

    Attributes:
        name: what they have in common.
        cases, clusters: how many there are.
        accuracy: by method.
    """

    name: Any
    cases: int
    clusters: int
    accuracy: Mapping[M, Estimate]


@dataclass(frozen=True, eq=False)
class Compared(Generic[M]):
    """Methods on the same cases, by whether each is right.

    Attributes:
        right: by method, a value for each case in one order: true where it is right, false where it
            is wrong or has no verdict. Not a number (NaN) where it has no such case; it is compared
            with another method on the cases that both have.
        clusters: the label of the cluster of each case, as
            :meth:`steadyload.statistics.clusters.Clusters.of` takes it.
    """

    right: Mapping[M, ArrayLike]
    clusters: ArrayLike | pd.Series

    @property
    def best(self) -> M:
        """The most accurate method; of equal ones the first."""
        return max(self.right, key=self._mean)

    def only(self, cases: BoolArray) -> Compared[M]:
        """Some of the cases.

        Args:
            cases: mask of them, shape (cases,).
        """
        right = {method: np.asarray(own)[cases] for method, own in self.right.items()}
        return Compared(right, self._labels[cases])

    def versus(self, against: M) -> Family[M]:
        """Each of the other methods minus one of them, in their order."""
        return self._family([(m, against) for m in self.right if m != against], against)

    def pairs(self) -> Family[M]:
        """All pairs of methods, each minus a later one."""
        found = self._family(list(combinations(self.right, 2)))
        order = sorted(self.right, key=lambda method: -self._mean(method))
        place = {method: str(number) for number, method in enumerate(order)}
        apart = {(place[t.first], place[t.second]) for t in found.tests if t.significant}
        signs = letters(list(place.values()), apart)
        return replace(found, letters={method: signs[place[method]] for method in order})

    def slices(self, by: ArrayLike | pd.Series) -> tuple[Slice[M], ...]:
        """Accuracy of every method by slice of the cases, by rising name.

        Args:
            by: the name of the slice of each case; names can be sorted. A case with a missing name
                is in no slice.
        """
        place, names = pd.factorize(pd.Series(by).to_numpy(), sort=True)
        return tuple(self._slice(name, place == number) for number, name in enumerate(names))

    def _slice(self, name: Any, here: BoolArray) -> Slice[M]:
        labels = self._labels[here]
        shares = {}
        for method in self.right:
            own = self._right(method)[here]
            known = ~np.isnan(own)
            shares[method] = accuracy(own[known], labels[known])
        return Slice(name, len(labels), len(Clusters.of(labels, len(labels))), shares)

    def _family(self, pairs: Iterable[tuple[M, M]], against: M | None = None) -> Family[M]:
        right = {method: self._right(method) for method in self.right}
        whole = Clusters.of(self._labels, len(self._labels))
        tests = []
        for first, second in pairs:
            one, other, groups = right[first], right[second], whole
            both = ~np.isnan(one - other)
            if not both.all():
                one, other = one[both], other[both]
                groups = Clusters.of(self._labels[both], len(one))
            tests.append(
                PairTest(
                    first,
                    second,
                    difference(one, other, groups),
                    share(one > other, groups),
                    share(other > one, groups),
                    p := sign_flip(one - other, groups),
                    p,
                )
            )
        sizes = sorted(whole.sizes.astype(int).tolist(), reverse=True)
        return Family(_corrected(tests), tuple(sizes), against)

    def _right(self, method: M) -> NDArray[np.float64]:
        return np.asarray(self.right[method], dtype=float)

    def _mean(self, method: M) -> float:
        right = self._right(method)
        known = right[~np.isnan(right)]
        return float(known.mean()) if len(known) else math.nan

    @cached_property
    def _labels(self) -> NDArray[Any]:
        return pd.Series(self.clusters).to_numpy()


def difference(first: ArrayLike, second: ArrayLike, clusters: Labels) -> Estimate:
    """Accuracy of a method, or another share, minus that of another method, case by case.

    Args:
        first: whether the first is right, shape (cases,); or (seeds, cases) of a training, which
            counts with the mean over its seeds.
        second: the same of the second; shares, where it stands for several methods.
        clusters: the label of the cluster of each case.
    """
    one, other = (np.atleast_2d(np.asarray(right, dtype=float)) for right in (first, second))
    return mean(one.mean(axis=0) - other.mean(axis=0), clusters)


def compared(judged: JudgedCases) -> Compared[MethodKey]:
    """The methods of a run on a labelled set: right are those whose failing step is the label's."""
    labels = judged.labels
    assert labels is not None, "the run is on a labelled set"
    right = {
        key: verdicts_against_labels(judged.said[spec], labels)["right"].to_numpy(bool)
        for spec, key in judged.keys.items()
    }
    return Compared(right, judged.clusters)


def _corrected(tests: Iterable[PairTest[M]]) -> tuple[PairTest[M], ...]:
    """Tests with p-values corrected for their number alone."""
    own = tuple(tests)
    corrected = holm([test.p for test in own])
    return tuple(replace(test, corrected=p) for test, p in zip(own, corrected, strict=True))

"""Methods two by two on the same cases: differences of accuracy, and their significance."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from steadyload.methods.naming import MethodKey
from steadyload.statistics.clusters import Clusters
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.metrics import mean
from steadyload.statistics.paired import LEVEL, holm, letters, sign_flip


@dataclass(frozen=True, slots=True)
class PairTest:
    """Two methods on the same cases: accuracy of the first minus that of the second.

    ``p``: of the sign-flip test over item lists; ``corrected``: by Holm, over the family of tests
    that answer one question: all pairs of a group, or those of :func:`one_family`.
    """

    first: MethodKey
    second: MethodKey
    difference: Estimate
    p: float
    corrected: float


@dataclass(frozen=True, slots=True)
class PairTests:
    """Pairs of methods in a group: all of them, or each with ``against``.

    ``letters``: by spec; methods that share one are not significantly different at ``level``; empty
    where not all pairs were tested. ``sizes``: cases of every item list, the largest first.
    ``least``: the smallest corrected p that is possible with this number of lists and pairs.
    """

    pairs: tuple[PairTest, ...]
    letters: Mapping[str, str]
    sizes: tuple[int, ...]
    level: float
    least: float
    against: MethodKey | None = None

    def with_each(self, held: MethodKey) -> tuple[PairTest, ...]:
        """Every other method compared with one: each minus it, corrected as a family of its own.

        That is the family of "which methods differ from this one?"; the pairs among the others
        answer another question.
        """
        others = dict.fromkeys(m for test in self.pairs for m in (test.first, test.second))
        return one_family(self.of(method, held) for method in others if method != held)

    def of(self, first: MethodKey, second: MethodKey) -> PairTest:
        """The test of two methods, with the sign reversed where they were tested in reverse order.

        Raises:
            KeyError: these two were not tested.
        """
        for test in self.pairs:
            if (test.first, test.second) == (first, second):
                return test
            if (test.first, test.second) == (second, first):
                d = test.difference
                turned = Estimate(-d.value, -d.high, -d.low, d.n)
                return PairTest(first, second, turned, test.p, test.corrected)
        raise KeyError(first.spec, second.spec)


def one_family(tests: Iterable[PairTest]) -> tuple[PairTest, ...]:
    """Tests that answer one question together, their p-values corrected for their number alone."""
    own = tuple(tests)
    corrected = holm([test.p for test in own])
    return tuple(replace(test, corrected=p) for test, p in zip(own, corrected, strict=True))


def pair_tests(
    methods: Sequence[MethodKey],
    right: pd.DataFrame,
    lists: NDArray[np.object_],
    *,
    against: MethodKey | None = None,
) -> PairTests:
    """Methods two by two on the same cases, corrected for the number of pairs.

    Args:
        methods: to compare.
        right: mask of the cases on which a method is right, cases x specs.
        lists: the item list of each case, as :meth:`Clusters.of` takes it.
        against: the method to compare each of the others with; None tests all pairs.
    """
    of = {m: right[m.spec].to_numpy(int) for m in methods}
    pairs = list(combinations(methods, 2))
    if against is not None:
        pairs = [(m, against) for m in methods if m != against]
    groups = Clusters.of(lists, len(right))
    raw = [sign_flip(of[a] - of[b], groups) for a, b in pairs]
    corrected = holm(raw)
    order = sorted(methods, key=lambda m: -of[m].mean())
    apart = {(a.spec, b.spec) for (a, b), p in zip(pairs, corrected, strict=True) if p < LEVEL}
    sizes = sorted(groups.sizes.astype(int).tolist(), reverse=True)
    return PairTests(
        pairs=tuple(
            PairTest(a, b, mean(of[a] - of[b], groups), p, q)
            for (a, b), p, q in zip(pairs, raw, corrected, strict=True)
        ),
        letters=letters([m.spec for m in order], apart) if against is None else {},
        sizes=tuple(sizes),
        level=LEVEL,
        least=min(1.0, len(pairs) * 2.0 ** (1 - len(sizes))),
        against=against,
    )

"""Names of any number of layouts, which must differ."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

_RECENT = 10_000
"""Names that are held as they are."""


class DistinctNames:
    """Names that have been seen, of which all but the last are held as 16 bytes each.

    These are two hashes of 64 bits: of 10^9 names two different ones are taken for equal with a
    probability below 10^-20.
    """

    def __init__(self) -> None:
        self._recent: set[str] = set()
        self._runs: list[NDArray[np.int64]] = []
        """Pairs of hashes, ordered by the first, shape (2, n) each; from long to short."""

    def __bool__(self) -> bool:
        """Whether there are any."""
        return bool(self._recent or self._runs)

    def add(self, names: Sequence[str]) -> str | None:
        """Take in some names; returns the first of them that was there already, None for none."""
        many = len(names) >= _RECENT
        pairs = _hashed(names) if self._runs or many else _NONE
        own = set(names)
        apart = len(own) == len(names) and own.isdisjoint(self._recent) and not self._holds(pairs)
        repeated = None if apart else self._first_repeated(names)
        if many:
            self._keep(pairs)
        else:
            self._recent |= own
            if len(self._recent) >= _RECENT:
                self._keep(_hashed(self._recent))
                self._recent = set()
        return repeated

    def _first_repeated(self, names: Sequence[str]) -> str | None:
        seen = set(self._recent)
        for name in names:
            if name in seen or self._holds(_hashed([name])):
                return name
            seen.add(name)
        return None

    def _keep(self, pairs: NDArray[np.int64]) -> None:
        self._runs.append(pairs)
        while len(self._runs) > 1 and 2 * self._runs[-1].shape[1] > self._runs[-2].shape[1]:
            self._runs[-2:] = [_ordered(np.concatenate(self._runs[-2:], axis=1))]

    def _holds(self, pairs: NDArray[np.int64]) -> bool:
        """Whether one of some names is in a run."""
        first, second = pairs
        for known, apart in self._runs:
            low = np.searchsorted(known, first)
            at = np.minimum(low, len(known) - 1)
            for k in np.flatnonzero(known[at] == first).tolist():
                high = np.searchsorted(known, first[k], "right")
                if second[k] in apart[low[k] : high]:
                    return True
        return False


_NONE = np.empty((2, 0), dtype=np.int64)


def _hashed(names: Collection[str]) -> NDArray[np.int64]:
    each = [
        np.fromiter(map(hash, texts), np.int64, len(names)) for texts in (names, _longer(names))
    ]
    return _ordered(np.array(each))


def _longer(names: Iterable[str]) -> Iterator[str]:
    """Names of which hashes are others."""
    return (name + "\0" for name in names)


def _ordered(pairs: NDArray[np.int64]) -> NDArray[np.int64]:
    return pairs[:, np.argsort(pairs[0], kind="stable")]

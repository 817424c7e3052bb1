"""Training, validation and test: by file, by geometry and by item list, with the same test files.

Test and validation files are drawn once, by scenario and half of them stable, as in Table 2 of the
paper. A split says which of the other files may be learnt from: a method that is tested under all
splits meets the same files, and what changes is what it has seen.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from enum import StrEnum
from typing import NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from steadyload.errors import UserError

Mask = NDArray[np.bool_]
Rights = NDArray[np.bool_]
"""Mask of the test files on which a seed of a method is right, (seeds, files)."""

TEST, VALIDATION = "test", "validation"

Sizes = Mapping[str, Mapping[str, tuple[int, int]]]
"""By scenario and part, the stable and the unstable files that are held out."""

TABLE_2: Sizes = {
    "S1": {TEST: (150, 150), VALIDATION: (44, 44)},
    "S2a": {TEST: (150, 150), VALIDATION: (50, 49)},
    "S2b": {TEST: (150, 150), VALIDATION: (56, 57)},
}
"""As in Table 2 of the paper."""


class SplitKind(StrEnum):
    """Rule for leaving files out of a training because of a held-out one.

    ``file``: the file itself, in its scenario; its twins stay. ``fewer``: likewise, and of the
    others so many are left out at random that as many stay as with ``geometry``: all files with its
    geometry, in all scenarios. ``list``: all files of its item list, in all scenarios; every list
    of a class is held out once, so there are as many trainings.
    """

    FILE = "file"
    FEWER = "fewer"
    GEOMETRY = "geometry"
    LIST = "list"

    @property
    def words(self) -> str:
        """As the page names it."""
        return {"fewer": "file, fewer", "list": "item list"}.get(self, self.value)


class SplitError(UserError):
    """Too few labelled files for the parts of a split."""


class Fold(NamedTuple):
    """A training of a split: masks over the rows of a table of cases.

    ``test`` holds the cases that its networks are tested on; over all folds of a split that is
    every case of the test.
    """

    kind: SplitKind
    number: int
    train: Mask
    validation: Mask
    test: Mask


def draw_parts(cases: pd.DataFrame, *, seed: int, sizes: Sizes = TABLE_2) -> pd.Series:
    """The part of every case, ``test``, ``validation`` or empty, drawn by scenario.

    Raises:
        SplitError: a scenario has too few stable or unstable files.
    """
    part = pd.Series("", cases.index, dtype=object)
    for place, (scenario, size) in enumerate(sizes.items()):
        random = np.random.default_rng(np.random.SeedSequence([seed, place]))
        own = cases[cases["scenario"] == scenario]
        for which, word in enumerate(("stable", "unstable")):
            index = own.index[own["failing_step"].isna() == (word == "stable")].to_numpy()
            test, both = size[TEST][which], size[TEST][which] + size[VALIDATION][which]
            if len(index) < both:
                raise SplitError(f"{scenario}: {len(index)} labelled {word} files; needed: {both}")
            drawn = random.permutation(index)
            part[drawn[:test]], part[drawn[test:both]] = TEST, VALIDATION
    return part


def folds(cases: pd.DataFrame, kind: SplitKind) -> tuple[Fold, ...]:
    """The trainings of a split.

    Args:
        cases: of :func:`steadyload.labelling.paper_labels.labelled_cases`, with the column
            ``part`` of :func:`draw_parts`.
        kind: of the split.
    """
    test, validation = ((cases["part"] == name).to_numpy(bool) for name in (TEST, VALIDATION))
    free = ~test & ~validation
    geometry, number = cases["geometry"], cases["number"].to_numpy(int)
    if kind is SplitKind.FILE:
        return (Fold(kind, 0, free, validation, test),)
    if kind in (SplitKind.GEOMETRY, SplitKind.FEWER):
        kept = free & ~geometry.isin(set(geometry[test | validation])).to_numpy(bool)
        if kind is SplitKind.FEWER:
            random = np.random.default_rng(np.random.SeedSequence([int(kept.sum()), len(kept)]))
            drawn = random.permutation(np.flatnonzero(free))[: kept.sum()]
            kept = np.isin(np.arange(len(kept)), drawn)
        return (Fold(kind, 0, kept, validation, test),)
    found = []
    for own in sorted(set(number.tolist())):
        here = number == own
        stopping, asked = validation & ~here, test & here
        # Few boxes on a bare floor may come up in two lists.
        apart = ~geometry.isin(set(geometry[asked | stopping])).to_numpy(bool)
        found.append(Fold(kind, own, free & ~here & apart, stopping, asked))
    return tuple(found)


def with_twin(cases: pd.DataFrame, parts: Iterable[Fold]) -> Mask:
    """Mask of the tested cases whose geometry is in the training part in the same scenario."""
    key, found = cases["geometry"] + "\n" + cases["scenario"], np.zeros(len(cases), dtype=bool)
    for fold in parts:
        found |= fold.test & key.isin(set(key[fold.train])).to_numpy(bool)
    return found

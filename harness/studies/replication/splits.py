"""Training, validation and test: by file, by geometry and by item list, with the same test files.

Test and validation files are drawn once, by scenario and half of them stable, as in Table 2 of the
paper. A split says which of the other files may be learnt from: a method that is tested under all
splits meets the same files, and what changes is what it has seen.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from steadyload.errors import UserError
from steadyload.labelling.paper_labels import Labels, content_of
from steadyload.layouts.benchmark.paper_files import PaperFiles
from steadyload.layouts.model.scenarios import Scenario
from steadyload.statistics.placed import items_placed_by_case

Mask = NDArray[np.bool_]

TEST, VALIDATION = "test", "validation"


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


@dataclass(frozen=True, slots=True)
class PartSizes:
    """Stable and unstable files of a scenario that are held out."""

    test: tuple[int, int] = (150, 150)
    validation: tuple[int, int] = (44, 44)


TABLE_2: Mapping[str, PartSizes] = {
    str(Scenario.S1): PartSizes(validation=(44, 44)),
    str(Scenario.S2A): PartSizes(validation=(50, 49)),
    str(Scenario.S2B): PartSizes(validation=(56, 57)),
}
"""Held-out files by scenario, stable and unstable, in Table 2 of the paper."""


@dataclass(frozen=True, slots=True)
class Fold:
    """A training of a split: masks over the rows of a table of cases.

    ``test`` holds the cases that its networks are tested on; over all folds of a split that is
    every case of the test.
    """

    kind: SplitKind
    number: int
    train: Mask
    validation: Mask
    test: Mask


def labelled_cases(files: PaperFiles, labels: Labels) -> pd.DataFrame:
    """A row a file and scenario that is labelled, twins included.

    Columns: ``row``, the file's number; ``scenario``; ``file``, ``instance``, ``number``,
    ``geometry``, ``item_class`` and ``item_count`` of the file; ``name``, of the layout of the
    case; ``content``, of it; ``failing_step``, the label. Twins share name and content in S1.
    """
    parts = []
    for scenario in map(str, Scenario):
        rows = files.table.index
        first = files.distinct(scenario, rows)
        contents = {row: content_of(files.case(row, scenario)) for row in first}
        if scenario == Scenario.S1:
            of = dict(zip(files.table.loc[first, "geometry"], contents.values(), strict=True))
            content, name = files.table["geometry"].map(of), files.table["geometry"]
        else:
            content, name = pd.Series(contents), files.table["file"]
        known = content.isin(list(labels))
        steps = [labels[int(value)] for value in content[known]]
        parts.append(
            files.table[known].assign(
                row=rows[known],
                scenario=scenario,
                name=name[known],
                content=content[known],
                failing_step=pd.array(steps, dtype="Int16"),
            )
        )
    return pd.concat(parts, ignore_index=True)


def steps_safe(cases: pd.DataFrame) -> NDArray[np.int64]:
    """Items placed safely by the label of every case, all of them for a stable one."""
    return items_placed_by_case(cases["failing_step"], cases["item_count"]).to_numpy()


def draw_parts(
    cases: pd.DataFrame, *, seed: int, sizes: Mapping[str, PartSizes] = TABLE_2
) -> pd.Series:
    """The part of every case, ``test``, ``validation`` or empty, drawn by scenario.

    Args:
        cases: of :func:`labelled_cases`.
        seed: of the draws, 0 or more.
        sizes: by scenario; others have no held-out cases.

    Raises:
        SplitError: a scenario has too few stable or unstable files.
    """
    part = pd.Series("", cases.index, dtype=object)
    for place, (scenario, size) in enumerate(sizes.items()):
        random = np.random.default_rng(np.random.SeedSequence([seed, place]))
        own = cases[cases["scenario"] == scenario]
        for which, stable in enumerate((True, False)):
            index = own.index[own["failing_step"].isna() == stable].to_numpy()
            wanted = {TEST: size.test[which], VALIDATION: size.validation[which]}
            if len(index) < sum(wanted.values()):
                raise SplitError(
                    f"{scenario}: {len(index)} labelled {'stable' if stable else 'unstable'} "
                    f"files; needed: {sum(wanted.values())}"
                )
            drawn = random.permutation(index)
            part[drawn[: wanted[TEST]]] = TEST
            part[drawn[wanted[TEST] : sum(wanted.values())]] = VALIDATION
    return part


def folds(cases: pd.DataFrame, part: pd.Series, kind: SplitKind) -> tuple[Fold, ...]:
    """The trainings of a split.

    Args:
        cases: of :func:`labelled_cases`.
        part: of :func:`draw_parts`.
        kind: of the split.
    """
    test, validation = ((part == name).to_numpy(bool) for name in (TEST, VALIDATION))
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


def share_with_twin(cases: pd.DataFrame, fold: Fold) -> Mask:
    """Mask of the cases whose geometry is in the training part in the same scenario."""
    key = cases["geometry"] + "\n" + cases["scenario"]
    found: Mask = key.isin(set(key[fold.train])).to_numpy(bool)
    return found

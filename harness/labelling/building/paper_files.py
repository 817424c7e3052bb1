"""The files of a data set made by the paper's protocol, each geometry as often as it came up.

The authors' file names show a file for every heuristic, item list and bin, and many heuristics pack
a bin alike. Files with one geometry are *twins*. Their centres of mass were drawn file by file, so
twins are the same case in S1 and differ in S2a and S2b.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

import pandas as pd

from steadyload.layouts.model.layout import Layout
from steadyload.layouts.model.scenarios import Scenario, draw_case
from steadyload.layouts.packing.heuristics import HEURISTICS, Heuristic
from steadyload.layouts.packing.packing import ITEM_CLASSES, WeightRule, generate, make_instance
from steadyload.progress import Progress, silent

FIRST = 3
"""Labels of every file of this number are made first."""

Case = tuple[str, Layout]
"""A scenario, and a layout with its centres of mass."""


@dataclass(frozen=True, slots=True)
class FileOptions:
    """Options of the data set; with the same ones it is remade exactly.

    Args:
        seed: of item lists and centres of mass. With that of the package come 9,414 files of 4,436
            geometries; the paper has 9,689 files. It is another one than that of the labelled sets,
            so that no shipped network has learnt from these item lists.
        lists: item lists of every class; the authors' file names show four.
        weights: how heavy items are.
        item_counts: items of a list by class, where they are not the class's own.
        heuristics: that pack every list.
    """

    seed: int = 1
    lists: int = 4
    weights: WeightRule = WeightRule.PAPER
    item_counts: Mapping[int, int] = field(default_factory=dict)
    heuristics: tuple[Heuristic, ...] = HEURISTICS


@dataclass(frozen=True)
class PaperFiles:
    """The files, in the order of item lists, geometries and names.

    Attributes:
        options: that they were made with.
        table: a row a file, numbered from 0: ``file``, its name; ``instance``, its item list;
            ``item_class``; ``number``, of the list within its class; ``geometry``, the name of the
            first file with its geometry; ``item_count``; ``first``, whether its labels are made
            first.
        geometries: layouts by the name of the geometry, centres of mass in the middle.
    """

    options: FileOptions
    table: pd.DataFrame
    geometries: Mapping[str, Layout]

    def case(self, row: int, scenario: str) -> Layout:
        """The layout of a file in a scenario, named after its file; in S1 after its geometry."""
        geometry = self.geometries[self._geometry[row]]
        if scenario == Scenario.S1:
            return draw_case(geometry, Scenario.S1, 0)
        name = self._names[row]
        seed = int.from_bytes(hashlib.sha256(f"{self.options.seed}/{name}".encode()).digest()[:8])
        return draw_case(geometry, Scenario(scenario), seed).renamed(name)

    def distinct(self, scenario: str, rows: pd.Index) -> pd.Index:
        """Those of some files that are needed for every case to be there once, in their order."""
        if scenario != Scenario.S1:
            return rows
        geometry = self.table["geometry"].loc[rows]
        return rows[~geometry.duplicated().to_numpy()]

    def in_turns(self) -> Iterator[tuple[str, pd.Index]]:
        """Scenarios and files whose cases differ, in the order in which labels are made.

        Those of every third file come first, and in both halves S1 does.
        """
        table = self.table
        first = table.index[table["first"]]
        for scenario in map(str, Scenario):
            yield scenario, self.distinct(scenario, first)
        known = set(table.loc[first, "geometry"])
        for scenario in map(str, Scenario):
            rest = self.distinct(scenario, table.index[~table["first"]])
            if scenario == Scenario.S1:
                rest = rest[~table.loc[rest, "geometry"].isin(known).to_numpy()]
            yield scenario, rest

    def some(self, count: int) -> PaperFiles:
        """So many of the files, evenly drawn; all where there are no more."""
        every = len(self.table)
        rows = [k * every // count for k in range(count)] if count < every else slice(None)
        return replace(self, table=self.table.iloc[rows])

    @cached_property
    def _geometry(self) -> Mapping[int, str]:
        return dict(self.table["geometry"])

    @cached_property
    def _names(self) -> Mapping[int, str]:
        return dict(self.table["file"])


def make_files(options: FileOptions, progress: Progress = silent) -> PaperFiles:
    """Pack all item lists with all heuristics.

    Args:
        options: what to draw from.
        progress: called with item lists packed and item lists in all.

    Raises:
        PackingError: an option that cannot be.
    """
    rows: list[tuple[str, str, int, int, str, int]] = []
    geometries: dict[str, Layout] = {}
    known: dict[str, str] = {}
    wanted = [(which, number) for which in range(options.lists) for number in ITEM_CLASSES]
    for done, (which, number) in enumerate(wanted, start=1):
        count = options.item_counts.get(number)
        instance = make_instance(number, which, seed=options.seed, item_count=count)
        for packed in generate([instance], heuristics=options.heuristics, weights=options.weights):
            layout = packed.layout
            name = known.setdefault(layout.geometry_hash(), layout.name)
            geometries.setdefault(name, layout)
            rows += [
                (file, instance.name, number, which, name, len(layout)) for file in packed.sources
            ]
        progress(done, len(wanted))
    columns = ["file", "instance", "item_class", "number", "geometry", "item_count"]
    table = pd.DataFrame(rows, columns=columns)
    return PaperFiles(options, table.assign(first=table.index % FIRST == 0), geometries)

"""Loads that are moved and scaled, and verdicts of engines on them.

In exact mechanics neither changes a verdict.

A layout that is moved over the floor behaves as before. Only numbers of few digits notice: far from
the origin of a world the same digits have to tell a larger coordinate. A layout whose lengths are
multiplied by a factor behaves as before where times are multiplied by its square root, under the
same gravity and at any density (Froude's law of similitude). There all numbers keep their digits;
what notices are lengths, speeds and times that are fixed within an engine. So the first change
shows what precision costs, the second what a contact model does.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from steadyload.atomic import without_link
from steadyload.layouts.benchmark.parts import LISTS, set_named
from steadyload.layouts.formats import Format, write_layouts
from steadyload.layouts.model.floor import FloorKind
from steadyload.layouts.model.item import Item
from steadyload.layouts.model.layout import Layout
from steadyload.runs.definition import StudyDefinition
from steadyload.runs.judged import load_judged
from steadyload.runs.labels import item_lists, labelled_cases, labelled_material
from steadyload.runs.runner import run_study
from steadyload.statistics.clusters import Clusters
from steadyload.statistics.placed import items_placed_by_case
from steadyload.studies.kit import Lab

PART = "test"
"""Part of the set of many lists; nothing was tuned on it."""

_SHARD = 25

_TIME, _FREQUENCY, _DISTANCE = 0.3, 480.0, 10.0
"""Of the label: seconds a placement, substeps a second, threshold [cm]."""


@dataclass(frozen=True, slots=True)
class Change:
    """A change of layouts, and of the methods that judge them.

    Attributes:
        moved: metres along both sides of the pallet.
        scale: factor of all lengths.
    """

    moved: float = 0.0
    scale: float = 1.0

    @property
    def name(self) -> str:
        """Name for folders and tables."""
        if self.moved:
            return f"moved {self.moved:g} m"
        if self.scale == 1.0:
            return "as it is"
        if self.scale > 1.0:
            return f"{self.scale:g} times larger"
        return f"{1.0 / self.scale:g} times smaller"

    def __str__(self) -> str:
        return self.name

    def of(self, layout: Layout) -> Layout:
        """The changed layout, on a pallet that holds it, on an infinite floor."""
        way, s = 100.0 * self.moved, self.scale
        pallet = replace(
            layout.pallet,
            width=s * layout.pallet.width + way,
            height=s * layout.pallet.height,
            depth=s * layout.pallet.depth + way,
            floor=FloorKind.INFINITE,
        )
        return Layout(layout.name, pallet, tuple(self._item(item, way) for item in layout.items))

    def _item(self, item: Item, way: float) -> Item:
        s, (x, y, z) = self.scale, item.position
        (width, height, depth), (p, q, r) = item.size, item.mass_offset
        return replace(
            item,
            position=(s * x + way, s * y, s * z + way),
            size=(s * width, s * height, s * depth),
            mass_offset=(s * p, s * q, s * r),
        )

    def method(self, engine: str) -> str:
        """The method that asks the label's question of a changed layout."""
        if self.scale == 1.0:
            return f"label@{engine}"
        pace = math.sqrt(self.scale)
        return (
            f"label@{engine}:t_max={_TIME * pace:.10g},frequency={_FREQUENCY / pace:.10g},"
            f"eps_t={_DISTANCE * self.scale:.10g}"
        )


AS_IT_IS = Change()
DISTANCES = tuple(Change(moved=metres) for metres in (1.0, 5.0, 20.0))
"""Within 20 m of its origin a world has the origin that it has for a layout at the corner."""

SCALES = tuple(Change(scale=factor) for factor in (1 / 16, 1 / 4, 4.0, 16.0))
"""Squares of powers of two: their roots are exact, and so are all lengths."""


@dataclass(frozen=True)
class Answers:
    """Verdicts of engines on the same cases, under some changes.

    Attributes:
        engines: names.
        said: by change, items placed safely: rows are cases, a column an engine; missing where
            there is no verdict.
        cases: a row a case: ``safe``, the label's items placed safely; ``items``; ``height`` of the
            load [cm]; ``mass_ratio``, the heaviest item over the lightest.
        clusters: of the cases.
    """

    engines: tuple[str, ...]
    said: dict[Change, pd.DataFrame]
    cases: pd.DataFrame
    clusters: Clusters

    def right(self, engine: str) -> np.ndarray:
        """Mask of the unchanged cases whose verdict is the label."""
        return self.said[AS_IT_IS][engine].eq(self.cases["safe"]).fillna(False).to_numpy(bool)

    def changed(self, change: Change, engine: str) -> np.ndarray:
        """Mask of the cases whose verdict is another than without the change, or is none."""
        before, after = (self.said[c][engine] for c in (AS_IT_IS, change))
        return ~(before.eq(after).fillna(False).to_numpy(bool))


def judge_changed(
    lab: Lab, engines: Sequence[str], limit: int, changes: Sequence[Change], folder: str
) -> Answers:
    """Judge cases of the set of many lists with the label's own protocol, where that is missing.

    Args:
        lab: where it runs.
        engines: names.
        limit: cases a scenario, those of the first ranks.
        changes: under which all cases are judged.
        folder: of the layout files and of the run folders, one a change, in the work folder.
    """
    of_labels = StudyDefinition(
        "cases", (), benchmark=PART, benchmark_directory=set_named(LISTS), limit=limit
    )
    labels = labelled_material(of_labels).labels
    assert labels is not None
    layouts = [
        layout.renamed(f"{layout.name} {scenario}")
        for scenario, layout in labelled_cases(of_labels)
    ]
    order = pd.Index([layout.name for layout in layouts], name="case")
    placed = items_placed_by_case(labels["failing_step"], labels["item_count"])
    cases = pd.DataFrame(
        {
            "safe": placed.to_numpy(),
            "items": labels["item_count"].to_numpy(int),
            "height": [float(layout.upper[:, 1].max()) for layout in layouts],
            "mass_ratio": [np.exp(np.ptp(np.log(layout.weights))) for layout in layouts],
        },
        index=order,
    )
    work, said = lab.work / folder, {}
    work.mkdir(parents=True, exist_ok=True)
    for change in changes:
        file = work / f"{change.name}.layouts"
        write_layouts(without_link(file), map(change.of, layouts), Format.NATIVE)
        definition = StudyDefinition(
            f"precision, {change.name}",  # as the manifests of kept rows name it
            tuple(change.method(name) for name in engines),
            files=(file.resolve(),),
            shard_size=_SHARD,
        )
        run_study(
            definition, work / change.name, workers=lab.workers,
            progress=lambda *of, change=change: lab.progress(change.name, *of),
        )  # fmt: skip
        found = load_judged(work / change.name).said.droplevel("scenario")
        found.columns = pd.Index(engines)
        said[change] = found.loc[order]
    return Answers(tuple(engines), said, cases, Clusters.of(item_lists(labels), len(cases)))

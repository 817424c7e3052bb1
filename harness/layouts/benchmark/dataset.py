"""The labelled set as studies, learners and pages read it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from functools import cached_property
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from steadyload.layouts.benchmark.confidence import confidence
from steadyload.layouts.benchmark.tables import BenchmarkError, read_tables
from steadyload.layouts.model import Item, Layout, LayoutError, Pallet
from steadyload.layouts.record import shown
from steadyload.layouts.scenarios import Scenario

KEYS = ["layout", "scenario"]
"""What names a case."""

PAPER_SIZE = 300
"""Cases a scenario in the paper's test set; the first ranks of ``test`` are such a set."""

_PACKAGE = Path(str(resources.files("steadyload.layouts.benchmark")))

SHIPPED = _PACKAGE / "data"
"""The folder of the set that comes with the package."""

PLANAR = "planar"
"""Name of the small set of planar layouts that comes with the package, too."""

SETS: Mapping[str, Path] = {PLANAR: _PACKAGE / "data_planar"}
"""Names of further sets of the package, and their folders."""


class Part(StrEnum):
    """A part of the labelled set.

    ``train``: everything of the training instances. ``validation``, ``test``: half stable, half
    unstable by scenario. ``test-300``: 300 cases a scenario of ``test``, the paper's size.
    ``all``: every labelled case, also those in no split.
    """

    TRAIN = "train"
    VALIDATION = "validation"
    TEST = "test"
    TEST_300 = "test-300"
    ALL = "all"


UNLEARNT = (Part.VALIDATION, Part.TEST, Part.TEST_300)
"""Held-out parts: nothing is trained on their item lists."""


@dataclass(frozen=True)
class Benchmark:
    """A labelled set.

    Attributes:
        layouts: a row a geometry, :data:`steadyload.layouts.benchmark.tables.LAYOUTS`, indexed by
            ``layout``.
        cases: a row a layout and scenario, :data:`steadyload.layouts.benchmark.tables.CASES`, and
            the column ``instance``.
        opinions: verdicts of further methods on some cases,
            :data:`steadyload.layouts.benchmark.tables.OPINIONS`.
        manifest: what it was made with.
        notes: what people found when they looked at its disputed labels, as Markdown; its folder
            may hold them as ``notes.md``.
    """

    layouts: pd.DataFrame
    cases: pd.DataFrame
    opinions: pd.DataFrame
    manifest: dict[str, Any]
    notes: str = ""

    @cached_property
    def confidence(self) -> pd.DataFrame:
        """Confidence of labels, a row a case that the ensemble judged; see :func:`confidence`."""
        return confidence(self.cases, self.opinions)

    @cached_property
    def natural_stable(self) -> dict[str, float]:
        """Share of stable cases by scenario, over all cases, whether in a split or not."""
        done = self.cases[self.cases["status"] == "done"]
        stable = done["failing_step"].isna().groupby(done["scenario"], sort=False).mean()
        return {str(scenario): float(value) for scenario, value in stable.items()}

    def select(
        self,
        part: Part | str = Part.ALL,
        *,
        scenarios: tuple[str, ...] = (),
        limit: int | None = None,
    ) -> pd.DataFrame:
        """The labelled cases of a part, in order of scenario and rank.

        Args:
            part: which; see :class:`Part`.
            scenarios: only these; empty for all.
            limit: at most this many a scenario, those of the first ranks. In ``validation`` and
                ``test`` any even number of first ranks is half stable, half unstable.

        Raises:
            BenchmarkError: no such part or scenario, or no such case.
        """
        if part not in list(Part):
            raise BenchmarkError(f"part is {part!r}; allowed: {', '.join(Part)}")
        known = [str(s) for s in Scenario]
        for scenario in scenarios:
            if scenario not in known:
                raise BenchmarkError(f"scenario is {scenario!r}; allowed: {', '.join(known)}")
        cases = self.cases[self.cases["status"] == "done"]
        if part != Part.ALL:
            split = Part.TEST if part == Part.TEST_300 else part
            cases = cases[cases["split"] == str(split)]
        if part == Part.TEST_300:
            cases = cases[cases["rank"] < PAPER_SIZE]
        if scenarios:
            cases = cases[cases["scenario"].isin(scenarios)]
        order = cases["scenario"].map(known.index)
        cases = cases.assign(_order=order).sort_values(["_order", "rank"], kind="stable")
        cases = cases.drop(columns="_order")
        if limit is not None:
            cases = cases[cases.groupby("scenario").cumcount() < limit]
        if cases.empty:
            raise BenchmarkError(
                f"holds no labelled case of {part!s} {' '.join(scenarios)}".strip()
            )
        return cases.reset_index(drop=True)

    def layout(self, name: str, scenario: str) -> Layout:
        """A case's layout with its centres of mass.

        Raises:
            BenchmarkError: no such case, or its row is damaged.
            LayoutError: its row is no valid layout.
        """
        try:
            row, offsets = self.layouts.loc[name], self._offsets[name, scenario]
        except KeyError:
            raise BenchmarkError(f"no case of layout {name!r} in scenario {scenario!r}") from None
        try:
            return layout_of(name, row, offsets)
        except LayoutError:
            raise
        except (TypeError, ValueError):
            raise BenchmarkError(
                f"layout {shown(name)} in scenario {shown(scenario)}: its lists of numbers do not "
                "fit together, the labelled set is damaged"
            ) from None

    @cached_property
    def _offsets(self) -> dict[tuple[str, str], Any]:
        return dict(
            zip(zip(self.cases["layout"], self.cases["scenario"], strict=True),
                self.cases["offsets"], strict=True)
        )  # fmt: skip


def load_benchmark(directory: str | Path | None = None) -> Benchmark:
    """Read a labelled set.

    Args:
        directory: its folder, or as a text a word of :data:`SETS` (a folder of that name in the
            working directory is ``./planar``); None reads the large set of the package.

    Raises:
        BenchmarkError: not such a folder, or a damaged one.
    """
    known = SETS.get(directory) if isinstance(directory, str) else None
    folder = known or Path(directory or SHIPPED)
    layouts, cases, opinions, manifest = read_tables(folder)
    layouts = layouts.set_index("layout")
    try:
        instance = layouts["instance"].reindex(cases["layout"])
    except ValueError:
        raise BenchmarkError(f"{folder}: a layout stands there twice") from None
    if instance.isna().any():
        missing = cases["layout"][instance.isna().to_numpy()].iloc[0]
        raise BenchmarkError(f"{folder}: layout {shown(missing)} is missing")
    unknown = cases["scenario"][~cases["scenario"].isin(list(Scenario))]
    if len(unknown):
        raise BenchmarkError(
            f"{folder}: scenario of a case is {shown(unknown.iloc[0])}; "
            f"allowed: {', '.join(Scenario)}"
        )
    cases = cases.assign(instance=instance.to_numpy())
    written = folder / "notes.md"
    notes = written.read_text() if written.exists() else ""
    return Benchmark(layouts, cases, opinions, manifest, notes)


def layout_of(name: str, row: Any, offsets: Any) -> Layout:
    """A layout from a row of the table of layouts and a list of offsets (None: all zero).

    Raises:
        LayoutError: the values are no valid layout.
    """
    positions = np.reshape(row["positions"], (-1, 3)).tolist()
    sizes = np.reshape(row["sizes"], (-1, 3)).tolist()
    weights = np.asarray(row["weights"]).tolist()
    shifts = np.zeros((len(sizes), 3)) if offsets is None else np.reshape(offsets, (-1, 3))
    items = tuple(
        Item(k, tuple(position), tuple(size), weight, tuple(shift))
        for k, (position, size, weight, shift) in enumerate(
            zip(positions, sizes, weights, shifts.tolist(), strict=True)
        )
    )
    return Layout(name, Pallet(*np.asarray(row["pallet"]).tolist()), items)


def row_of(
    layout: Layout, instance: str, item_class: int, sources: tuple[str, ...]
) -> dict[str, Any]:
    """The row of the table of layouts for a layout; the inverse of :func:`layout_of`."""
    return {
        "layout": layout.name,
        "instance": instance,
        "item_class": item_class,
        "sources": list(sources),
        "pallet": list(layout.pallet.size),
        "positions": layout.lower.ravel().tolist(),
        "sizes": [side for item in layout.items for side in item.size],
        "weights": layout.weights.tolist(),
    }

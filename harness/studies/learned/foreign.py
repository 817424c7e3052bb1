"""Learned methods on layouts of another kind than those of their training."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from steadyload.layouts.model.layout import Layout
from steadyload.learners.methods import LearnedMethod
from steadyload.learners.plans.plan import ForeignPlan
from steadyload.learners.ranges import QUANTITIES, SLACK, extent_of
from steadyload.methods.naming import MethodKey, method_key
from steadyload.methods.registry import make_method
from steadyload.progress import Progress, silent
from steadyload.runs.definition import StudyDefinition
from steadyload.runs.results import load_results
from steadyload.runs.runner import run_study
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.metrics import agreement, outcomes, share

_ACCEPT = "outside=accept"
_SHARD_SIZE = 60


@dataclass(frozen=True, slots=True)
class ForeignRow:
    """A learned method on layouts of another kind.

    Attributes:
        method: the method, which refuses layouts outside of its training range.
        refused: share of layouts that it refuses.
        reasons: layouts by the quantity that is outside, with the training range and the range of
            these layouts; a layout may have several.
        agreement: by other method, share of equal failing steps with refusals switched off.
        inside: the same, on the layouts that it does not refuse.
        stable: share of all layouts that it judges to be stable, with refusals switched off.
    """

    method: MethodKey
    refused: Estimate
    reasons: tuple[tuple[str, int, tuple[float, float], tuple[float, float]], ...]
    agreement: Mapping[str, Estimate]
    inside: Mapping[str, Estimate]
    stable: Estimate


@dataclass(frozen=True, slots=True)
class Foreign:
    """Learned methods on layouts of another kind.

    ``others``: share of layouts that other methods judge to be stable. ``among``: by pair of them,
    share of equal failing steps.
    """

    files: int
    layouts: int
    max_items: int
    rows: tuple[ForeignRow, ...]
    others: Mapping[str, Estimate]
    among: Mapping[tuple[str, str], Estimate]


def foreign_layouts(
    plan: ForeignPlan,
    files: Sequence[Path],
    folder: Path,
    *,
    limit: int | None = None,
    workers: int,
    progress: Progress = silent,
) -> Foreign:
    """Share of layouts that learned methods refuse, and their agreement with other methods.

    Args:
        plan: the methods.
        files: of layouts.
        folder: of the run; an interrupted run is resumed.
        limit: largest number of layouts; None for all.
        workers: processes beside this one.
        progress: called with rows done and rows in all.

    Raises:
        LayoutError: a file is invalid.
        as :func:`steadyload.runs.runner.run_study`.
    """
    accepting = {spec: _accepting(spec) for spec in plan.judges}
    study = StudyDefinition(
        name="learned foreign",
        methods=(*plan.others, *accepting.values()),
        files=tuple(file.resolve() for file in files),
        max_items=plan.max_items,
        limit=limit,
        shard_size=_SHARD_SIZE,
    )
    run_study(study, folder, workers=workers, progress=progress)
    said = outcomes(load_results(folder))
    counts = {layout.name: min(len(layout), plan.max_items) for layout in study.layouts()}
    items = said.index.get_level_values("layout").map(counts).to_numpy()
    by_name = {layout.name: layout.first(counts[layout.name]) for layout in study.layouts()}
    layouts = [by_name[name] for name in said.index.get_level_values("layout")]
    others = [str(make_method(spec).spec) for spec in plan.others]
    titles = {spec: method_key(make_method(spec)).title for spec in others}
    return Foreign(
        files=len(study.files),
        layouts=len(layouts),
        max_items=plan.max_items,
        rows=tuple(
            _row(spec, accepting[spec], layouts, said, titles, items) for spec in plan.judges
        ),
        others={titles[spec]: _stable(said[spec], items) for spec in others},
        among={
            (titles[a], titles[b]): agreement(said, a, b)
            for k, a in enumerate(others)
            for b in others[k + 1 :]
        },
    )


def _accepting(spec: str) -> str:
    """The canonical spec of the same method without refusals."""
    plain = str(make_method(spec).spec)
    return str(make_method(f"{plain}{',' if ':' in plain else ':'}{_ACCEPT}").spec)


def _row(
    spec: str,
    accepting: str,
    layouts: Sequence[Layout],
    said: pd.DataFrame,
    titles: dict[str, str],
    items: np.ndarray,
) -> ForeignRow:
    judge = make_method(spec)
    assert isinstance(judge, LearnedMethod)
    ranges = judge.weights.ranges.ranges
    trained = np.array([ranges[name] for name in QUANTITIES])
    found = np.array([_extent(layout) for layout in layouts])
    outside = (found[:, 0] < trained[:, 0] * (1.0 - SLACK)) | (
        found[:, 1] > trained[:, 1] * (1.0 + SLACK)
    )
    refused = outside.any(axis=1)
    reasons = [
        (
            name,
            int(outside[:, k].sum()),
            (float(trained[k, 0]), float(trained[k, 1])),
            (float(found[:, 0, k].min()), float(found[:, 1, k].max())),
        )
        for k, name in enumerate(QUANTITIES)
        if outside[:, k].any()
    ]
    return ForeignRow(
        method=method_key(judge),
        refused=share(refused),
        reasons=tuple(sorted(reasons, key=lambda reason: -reason[1])),
        agreement={titles[o]: agreement(said, accepting, o) for o in titles},
        inside={titles[o]: agreement(said[~refused], accepting, o) for o in titles},
        stable=_stable(said[accepting], items),
    )


def _extent(layout: Layout) -> np.ndarray:
    longest = max(layout.pallet.size)
    arrays = (layout.lower, layout.upper, layout.weights, layout.mass_offsets)
    return extent_of(*arrays, layout.floor.corners, longest)


def _stable(said: pd.Series, items: np.ndarray) -> Estimate:
    return share(said.fillna(-1).astype(int).to_numpy() == items)

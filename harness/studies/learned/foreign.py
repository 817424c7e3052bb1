"""Learned judges on layouts of another kind than those that they were trained on."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from steadyload.layouts.model import Layout
from steadyload.learners.methods import LearnedMethod
from steadyload.learners.ranges import QUANTITIES, SLACK, extent_of
from steadyload.methods.naming import method_key
from steadyload.methods.registry import make_method
from steadyload.runs.definition import StudyDefinition
from steadyload.runs.results import load_results
from steadyload.runs.runner import run_study
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.metrics import agreement, outcomes, share
from steadyload.studies.learned.plan import ForeignPlan
from steadyload.studies.learned.records import Foreign, ForeignRow

_ACCEPT = "outside=accept"
_SHARD_SIZE = 60


def foreign_layouts(
    plan: ForeignPlan,
    files: Sequence[Path],
    folder: Path,
    *,
    limit: int | None = None,
    workers: int,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> Foreign:
    """What learned judges refuse of layouts, and how often they agree with other methods.

    Args:
        plan: who judges.
        files: of layouts.
        folder: of what is judged; an interrupted run goes on.
        limit: only so many layouts.
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
    """The canonical spec of a judge that refuses nothing."""
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
    return extent_of(layout.lower, layout.upper, layout.weights, layout.mass_offsets, longest)


def _stable(said: pd.Series, items: np.ndarray) -> Estimate:
    return share(said.fillna(-1).astype(int).to_numpy() == items)

"""The same cases, as they are and changed, judged on engines of single and of double precision."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from steadyload.atomic import without_link
from steadyload.layouts.benchmark.dataset import set_named
from steadyload.layouts.formats import Format, write_layouts
from steadyload.progress import NamedProgress, silent
from steadyload.runs.able import fixed_step_engines
from steadyload.runs.definition import StudyDefinition
from steadyload.runs.judged import load_judged
from steadyload.runs.labels import item_lists, labelled_material
from steadyload.runs.runner import run_study
from steadyload.statistics.clusters import Clusters
from steadyload.statistics.placed import items_placed_by_case
from steadyload.studies.precision.changes import AS_IT_IS, CHANGES, Change

PART = "test"
"""Part of the labelled set; nothing was tuned on it."""

_SHARD = 25


@dataclass(frozen=True)
class Answers:
    """Verdicts of all engines on all cases, under every change.

    Attributes:
        engines: names, in the order of the registry.
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


def judge_changed(
    directory: str,
    limit: int,
    work: Path,
    *,
    only: Sequence[str] = (),
    workers: int = 1,
    progress: NamedProgress = silent,
) -> Answers:
    """Judge all cases under every change, as far as that is missing.

    Args:
        directory: a labelled set, see
            :func:`steadyload.layouts.benchmark.dataset.set_named`.
        limit: cases a scenario, those of the first ranks.
        work: folder of the layout files and of the run folders, one a change.
        only: engines; empty for all.
        workers: see :func:`steadyload.runs.runner.run_study`.
        progress: called with what is done, rows done and rows in all.

    Raises:
        StudyError: see :func:`steadyload.runs.able.fixed_step_engines`.
        BenchmarkError: no such labelled set.
        ResultsError: a folder holds another study.
    """
    names = fixed_step_engines(only)
    of_labels = StudyDefinition(
        "cases", (), benchmark=PART, benchmark_directory=set_named(directory), limit=limit
    )
    material = labelled_material(of_labels)
    labels = material.labels
    assert labels is not None
    layouts = [layout.renamed(f"{layout.name} {scenario}") for scenario, layout in material.cases]
    order = [layout.name for layout in layouts]
    placed = items_placed_by_case(labels["failing_step"], labels["item_count"])
    cases = pd.DataFrame(
        {
            "safe": placed.to_numpy(),
            "items": labels["item_count"].to_numpy(int),
            "height": [float(lay.upper[:, 1].max()) for lay in layouts],
            "mass_ratio": [float(np.ptp(np.log(lay.weights))) for lay in layouts],
        },
        index=pd.Index(order, name="case"),
    )
    cases["mass_ratio"] = np.exp(cases["mass_ratio"])
    said = {}
    for change in CHANGES:
        file, folder = work / f"{change.name}.layouts", work / change.name
        work.mkdir(parents=True, exist_ok=True)
        write_layouts(without_link(file), map(change.of, layouts), Format.NATIVE)
        definition = StudyDefinition(
            f"precision, {change.name}",
            tuple(change.method(name) for name in names),
            files=(file.resolve(),),
            shard_size=_SHARD,
        )
        run_study(
            definition, folder, workers=workers,
            progress=lambda *of, change=change: progress(change.name, *of),
        )  # fmt: skip
        found = load_judged(folder).said.droplevel("scenario")
        found.columns = pd.Index(names)
        said[change] = found.loc[order]
    return Answers(names, said, cases, Clusters.of(item_lists(labels), len(cases)))


def turned(answers: Answers, change: Change, engine: str) -> np.ndarray:
    """Mask of the cases whose verdict is another than without the change, or is none."""
    before, after = (answers.said[c][engine] for c in (AS_IT_IS, change))
    return ~(before.eq(after).fillna(False).to_numpy(bool))

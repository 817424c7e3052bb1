"""Labels of some cases of a set for the question whether a load stands."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import pandas as pd

from steadyload.labelling.label_rows import LABEL
from steadyload.labelling.labelling import judged
from steadyload.layouts.benchmark.dataset import load_benchmark
from steadyload.layouts.benchmark.parts import HELD_OUT, Part
from steadyload.layouts.benchmark.tables import LABELS, BenchmarkError, write_further
from steadyload.layouts.model.question import Question
from steadyload.layouts.model.scenarios import Scenario
from steadyload.methods.registry import make_method
from steadyload.progress import NamedProgress, silent
from steadyload.runs.definition import StudyDefinition
from steadyload.runs.pool import IN_THIS_PROCESS
from steadyload.runs.provenance import provenance
from steadyload.runs.store import locked

SPEC = f"{LABEL}:question={Question.STANDS}"
"""The method whose verdicts are the labels."""

TRAINING_CASES = 5000
"""Cases of the training part that are labelled, those of the first ranks of every scenario."""


def label_stands(
    directory: Path,
    *,
    training_cases: int = TRAINING_CASES,
    workers: int = IN_THIS_PROCESS,
    progress: NamedProgress = silent,
) -> int:
    """Label all held-out and some training cases of a labelled set; returns their number.

    What was labelled before is not labelled again.

    Args:
        directory: of the set; the labels are written beside its tables.
        training_cases: at least so many, the same number of every scenario; 0 for none.
        workers: see :func:`steadyload.runs.runner.run_study`.
        progress: called with the current part, cases done and cases in all.

    Raises:
        BenchmarkError: no labelled set, or it has no splits.
        ResultsError: another run is at work in the folder.
        WorkerDiedError: see :func:`steadyload.runs.pool.run_units`.
    """
    benchmark = load_benchmark(directory)
    known = benchmark.cases["split"].dropna().unique()
    parts = [part for part in (*HELD_OUT, Part.TRAIN) if part in known]
    if not parts:
        raise BenchmarkError(f"{directory}: no case is in a split; label the set first")
    make_method(SPEC).prepare()
    limits = {Part.TRAIN: -(-training_cases // len(Scenario))}
    with locked(directory):
        found = [
            _labels_of(directory, part, limits.get(part), workers, progress)
            for part in parts
            if limits.get(part) != 0
        ]
        labels = pd.concat(found, ignore_index=True)
        made = {str(Question.STANDS): {"label": SPEC, "labelled_with": provenance()}}
        write_further(directory, "labels", labels, made)
    return len(labels)


def _labels_of(
    directory: Path, part: Part, limit: int | None, workers: int, progress: NamedProgress
) -> pd.DataFrame:
    """Labels of the first cases of a part."""
    study = StudyDefinition(
        name=f"whether {part} stands",
        methods=(SPEC,),
        benchmark=part,
        benchmark_directory=directory,
        limit=limit,
        shard_size=50,
    )
    folder = directory / "stands" / part
    found = judged(study, folder, workers, partial(progress, str(part)))
    return found.assign(question=str(Question.STANDS))[LABELS.names]

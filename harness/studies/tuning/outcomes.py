"""What parameter sets come to on cases that they were not tuned on: one study, many readings."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path

import pandas as pd

from steadyload.methods.naming import MethodKey, method_key
from steadyload.methods.registry import make_method
from steadyload.runs.definition import StudyDefinition
from steadyload.runs.evaluation import verdicts_against_labels
from steadyload.runs.labels import load_labels
from steadyload.runs.results import load_results
from steadyload.runs.runner import run_study
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.metrics import mean, outcomes, ratio, share
from steadyload.studies.tuning.records import Outcome

PART = "test"
"""Judged once, never tuned on."""

_SHARD_SIZE = 60


class Outcomes:
    """Verdicts of several methods on the same cases, and the labels.

    Args:
        directory: run folder of a study on a labelled set.

    Raises:
        ResultsError: no such folder, or a damaged one.
    """

    def __init__(self, directory: Path) -> None:
        results = load_results(directory)
        said = outcomes(results)
        labels = load_labels(directory).loc[said.index]
        times = results.pivot(index=["layout", "scenario"], columns="method", values="cpu_total")
        self._said, self._labels = said, labels
        self._milliseconds = 1e3 * times.loc[said.index]
        self._instances = labels["instance"].to_numpy()
        self._robust = labels["robust"].fillna(False).to_numpy(bool)
        self._against: dict[str, pd.DataFrame] = {}

    def of(
        self, spec: str, held_against: str | None = None, key: MethodKey | None = None
    ) -> Outcome:
        """What a method came to.

        Args:
            spec: of the method, canonical.
            held_against: a spec; the outcome's difference is its accuracy minus that of ``spec``.
            key: how to name the method; None names it as elsewhere.
        """
        verdicts, instances, robust = self._verdicts(spec), self._instances, self._robust
        right = verdicts["right"].to_numpy(bool)
        return Outcome(
            method=key or method_key(make_method(spec)),
            accuracy=share(right, instances),
            over=share(verdicts["over"].to_numpy(bool), instances),
            under=share(verdicts["under"].to_numpy(bool), instances),
            cpu=mean(self._milliseconds[spec], instances),
            difference=None if held_against is None else self.difference(held_against, spec),
            robust=share(right[robust], instances[robust]) if robust.any() else None,
        )

    def difference(self, spec: str, other: str) -> Estimate:
        """The accuracy of ``spec`` minus that of ``other``, case by case."""
        mine, others = (self._verdicts(s)["right"].to_numpy(float) for s in (spec, other))
        return mean(mine - others, self._instances)

    def cpu_ratio(self, spec: str, other: str) -> Estimate:
        """The CPU time of ``spec`` over that of ``other``, on the same cases."""
        return ratio(self._milliseconds[spec], self._milliseconds[other], self._instances)

    def _verdicts(self, spec: str) -> pd.DataFrame:
        if spec not in self._against:
            self._against[spec] = verdicts_against_labels(self._said[spec], self._labels)
        return self._against[spec]


def judge_all(
    specs: Iterable[str],
    directory: Path,
    *,
    benchmark: str | None,
    workers: int,
    limit: int | None = None,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> Outcomes:
    """Judge the test part of a labelled set with all of these; goes on where it was interrupted.

    Args:
        specs: of the methods; equal ones are judged once.
        directory: run folder.
        benchmark: the labelled set; None for the one that comes with the package.
        workers: processes beside this one.
        limit: only so many cases a scenario.
        progress: called with rows done and rows in all.

    Raises:
        as :func:`steadyload.runs.runner.run_study`.
    """
    study = StudyDefinition(
        name="tuning",
        methods=tuple(dict.fromkeys(specs)),
        benchmark=PART,
        benchmark_directory=benchmark,
        limit=limit,
        shard_size=_SHARD_SIZE,
    )
    run_study(study, directory, workers=workers, progress=progress)
    return Outcomes(directory)


def canonical_spec(spec: str) -> str:
    """As a study's rows name it."""
    return str(make_method(spec).spec)

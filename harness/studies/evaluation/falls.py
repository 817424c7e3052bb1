"""Falls that methods find, and false alarms: what a judge of a loading is asked for first."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from steadyload.layouts.benchmark import Benchmark
from steadyload.layouts.model.question import Question
from steadyload.methods.naming import MethodKey
from steadyload.reports.columns import column, percent, row
from steadyload.runs.evaluation import Evaluation
from steadyload.runs.judged import JudgedCases
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.metrics import share
from steadyload.studies.evaluation.parts import origin_masks

ROBUST = "robust falls"
"""Title of the falls of all origins whose label holds with the other contacts that were tried."""


@row
class FallsFound:
    """How many of the loads that fall a method says to fail, at whichever step.

    ``accuracy``: on all cases. ``found``: by origin, and of robust labels alone; a load without a
    verdict is not found.
    ``alarms``: by origin, the loads that stand and are said to fail, and all that stand.
    """

    method: MethodKey = column(form=lambda key: key.title, left=True)
    question: Question = column()
    accuracy: Estimate = column("accuracy %", percent)
    found: Mapping[str, Estimate] = column("found of {} %", percent)
    alarms: Mapping[str, str] = column("false alarms, {}")


def falls_found(
    evaluation: Evaluation, benchmark: Benchmark, question: Question
) -> Sequence[FallsFound]:
    """A row a method; empty where no customer's pallet is.

    Args:
        evaluation: of all methods, with labels of the question.
        benchmark: the labelled set.
        question: of the labels.
    """
    judged = evaluation.judged
    assert judged.labels is not None, "the study is on a labelled set"
    masks = origin_masks(judged, benchmark.layouts)
    if not masks:
        return []
    falls = judged.labels["failing_step"].notna().to_numpy()
    robust = benchmark.confidence_on(question)["robust"].reindex(judged.said.index)
    firm = robust.fillna(False).to_numpy(bool)
    found = []
    for spec, key in judged.keys.items():
        said = _said_to_fail(judged, spec)
        chosen = {name: here & falls for name, here in masks.items()}
        if firm.any():
            chosen[ROBUST] = firm & falls
        shares = {
            name: share(said[here], judged.clusters[here])
            for name, here in chosen.items()
            if here.any()
        }
        alarms = {
            name: f"{int((said & here & ~falls).sum())} of {int((here & ~falls).sum())}"
            for name, here in masks.items()
        }
        found.append(FallsFound(key, question, evaluation.row(spec).accuracy, shares, alarms))
    return found


def _said_to_fail(judged: JudgedCases, spec: str) -> NDArray[np.bool_]:
    """The cases at which a method names a failing step."""
    own = judged.results[judged.results["method"] == spec].set_index(["layout", "scenario"])
    steps: pd.Series = own["failing_step"].reindex(judged.said.index)
    return steps.notna().to_numpy(bool)

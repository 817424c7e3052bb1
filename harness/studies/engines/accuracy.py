"""Accuracy of engines on ordinary loads, by the kind of load."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd

from steadyload.engines.registry import capabilities
from steadyload.reports import frames
from steadyload.runs import frames as v
from steadyload.runs.able import fixed_step_engines
from steadyload.studies.changed_loads import AS_IT_IS, Answers, judge_changed
from steadyload.studies.kit import Lab

KINDS = {
    "items": ("items", (10, 15), "items"),
    "height": ("height", (30.0, 80.0), "cm"),
    "masses": ("mass_ratio", (10.0, 100.0), "to 1"),
}
"""Kind of group -> column of the cases, bounds between the groups, and their unit."""


def accuracy_by_load(lab: Lab, limit: int) -> dict[str, Any]:
    """Judge ordinary loads with the label's own protocol on engines of fixed steps."""
    return summarised(judge_changed(lab, fixed_step_engines(), limit, (AS_IT_IS,), "accuracy"))


def summarised(answers: Answers) -> dict[str, Any]:
    """The accuracies of verdicts on unchanged loads: of all cases, and by kind of group."""
    engines = pd.DataFrame({"engine": answers.engines}, index=list(answers.engines))
    single = [capabilities(engine).single_precision for engine in answers.engines]
    engines["single"] = np.where(single, "single", "double")
    frame = pd.concat(
        answers.cases.assign(
            engine=engine, right=answers.right(engine), cluster=answers.clusters.member
        )
        for engine in answers.engines
    )
    groups = {}
    for kind, (of, (low, high), unit) in KINDS.items():
        names = [
            f"up to {low:g} {unit}", f"above {low:g}, to {high:g} {unit}", f"above {high:g} {unit}"
        ]  # fmt: skip
        number = np.digitize(frame[of], (low, high), right=True)
        binned = frame.assign(group=np.array(names)[number]).iloc[np.argsort(number, kind="stable")]
        right = v.share(binned, "right", ["engine", "group"])
        groups[kind] = engines.join(frames.across(right, "group", "engine_right"))
    return {
        "cases": len(answers.cases),
        "item_lists": len(answers.clusters),
        "whole": engines.assign(right=v.share(frame, "right", ["engine"])),
        "groups": groups,
        "single": list(engines.index[single]),
    }

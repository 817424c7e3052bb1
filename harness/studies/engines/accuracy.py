"""Accuracy of engines on ordinary loads, by the kind of load."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from steadyload.engines.registry import capabilities
from steadyload.reports.columns import column, percent, row
from steadyload.runs.able import fixed_step_engines
from steadyload.runs.comparison import Compared
from steadyload.statistics.estimate import NOTHING, Estimate
from steadyload.studies.changed_loads import AS_IT_IS, Answers, judge_changed
from steadyload.studies.kit import Lab

ALL = "all"

KINDS = {
    "items": ("items", (10, 15), "items"),
    "height": ("height", (30.0, 80.0), "cm"),
    "masses": ("mass_ratio", (10.0, 100.0), "to 1"),
}
"""Kind of group -> column of the cases, bounds between the groups, and their unit."""


@row
class Group:
    """An engine, and by group of cases the share whose failing step is the label's."""

    engine: str = column()
    single: bool = column("precision", lambda single: "single" if single else "double", left=True)
    accuracy: Mapping[str, Estimate] = column("{} %", percent)


@row
class Accuracy:
    """Accuracy of all engines, by kind of group of the cases."""

    cases: int
    item_lists: int
    groups: Mapping[str, Sequence[Group]]

    @property
    def whole(self) -> Sequence[Group]:
        """Of all cases."""
        return self.groups[ALL]

    @property
    def single(self) -> list[str]:
        """Engines of single precision."""
        return [own.engine for own in self.whole if own.single]


def accuracy_by_load(lab: Lab, limit: int) -> Accuracy:
    """Judge ordinary loads with the label's own protocol on engines of fixed steps.

    Args:
        lab: where it runs.
        limit: cases a scenario of the set of many lists.
    """
    return summarised(judge_changed(lab, fixed_step_engines(), limit, (AS_IT_IS,), "accuracy"))


def summarised(answers: Answers) -> Accuracy:
    """The accuracies of verdicts on unchanged loads."""
    cases, clusters = answers.cases, answers.clusters
    right = {engine: answers.right(engine) for engine in answers.engines}
    compared = Compared(right, clusters.member)

    def groups(names: Sequence[str], number: np.ndarray) -> list[Group]:
        found = {names[of.name]: of.accuracy for of in compared.slices(number)}
        return [
            Group(
                engine,
                capabilities(engine).single_precision,
                {name: found[name][engine] if name in found else NOTHING for name in names},
            )
            for engine in answers.engines
        ]

    kinds = {ALL: groups([ALL], np.zeros(len(cases), dtype=int))}
    for kind, (of, (low, high), unit) in KINDS.items():
        above = f"above {low:g}, to {high:g} {unit}", f"above {high:g} {unit}"
        number = np.digitize(cases[of], (low, high), right=True)
        kinds[kind] = groups([f"up to {low:g} {unit}", *above], number)
    return Accuracy(len(cases), len(clusters), kinds)

"""Accuracy of engines on ordinary loads, by the kind of load."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from steadyload.engines.registry import capabilities
from steadyload.reports.columns import column, percent, row
from steadyload.runs.able import fixed_step_engines
from steadyload.statistics.estimate import NOTHING, Estimate
from steadyload.statistics.metrics import share
from steadyload.studies.changed_loads import AS_IT_IS, Answers, judge_changed
from steadyload.studies.kit import Lab

_ITEMS = (10, 15)
_HEIGHTS = (30.0, 80.0)
_RATIOS = (10.0, 100.0)
"""Bounds between the groups of cases; heights in cm."""

ALL = "all"


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
    kinds = {
        ALL: {ALL: np.ones(len(cases), dtype=bool)},
        "items": _between(cases["items"].to_numpy(), _ITEMS, "items"),
        "height": _between(cases["height"].to_numpy(), _HEIGHTS, "cm"),
        "masses": _between(cases["mass_ratio"].to_numpy(), _RATIOS, "to 1"),
    }

    def accuracy(engine: str, own: NDArray[np.bool_]) -> Estimate:
        right = answers.right(engine)
        return share(right[own], clusters.member[own]) if own.any() else NOTHING

    return Accuracy(
        len(cases),
        len(clusters),
        {
            kind: [
                Group(
                    engine,
                    capabilities(engine).single_precision,
                    {name: accuracy(engine, own) for name, own in groups.items()},
                )
                for engine in answers.engines
            ]
            for kind, groups in kinds.items()
        },
    )


def _between(
    values: NDArray[np.float64], bounds: tuple[float, float], unit: str
) -> dict[str, NDArray[np.bool_]]:
    low, high = bounds
    return {
        f"up to {low:g} {unit}": values <= low,
        f"above {low:g}, to {high:g} {unit}": (values > low) & (values <= high),
        f"above {high:g} {unit}": values > high,
    }

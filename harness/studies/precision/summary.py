"""Shares of verdicts that a change turns, and accuracy by the kind of load, an engine a row."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from steadyload.engines.registry import capabilities
from steadyload.runs.comparison import difference
from steadyload.statistics.clusters import Clusters
from steadyload.statistics.estimate import NOTHING, Estimate
from steadyload.statistics.metrics import share
from steadyload.studies.precision.changes import AS_IT_IS, CHANGES, Change
from steadyload.studies.precision.judging import Answers, turned

_ITEMS = (10, 15)
_HEIGHTS = (30.0, 80.0)
_RATIOS = (10.0, 100.0)
"""Bounds between the groups of cases; heights in cm."""

ALL = "all"


@dataclass(frozen=True, slots=True)
class EngineRow:
    """An engine: its precision, its accuracy by group, and the verdicts that changes turn.

    Attributes:
        engine: name.
        single: whether its numbers are of single precision.
        accuracy: by kind of group and by group of cases, share whose failing step is the label's.
        turned: by change, share whose verdict is another than that of the case as it is.
        excess: by change, that share less the mean of those of all engines of double precision, on
            the same cases; no number where there is none of these.
    """

    engine: str
    single: bool
    accuracy: dict[str, dict[str, Estimate]]
    turned: dict[Change, Estimate]
    excess: dict[Change, Estimate]


def summarise(answers: Answers) -> list[EngineRow]:
    """A row an engine, in the order of the registry."""
    groups = _groups(answers)
    changes = [change for change in CHANGES if change != AS_IT_IS]
    double = [name for name in answers.engines if not capabilities(name).single_precision]
    usual = {
        change: np.mean([turned(answers, change, name) for name in double], axis=0)
        for change in changes
        if double
    }
    rows = []
    for engine in answers.engines:
        said = answers.said[AS_IT_IS][engine]
        right = said.eq(answers.cases["safe"]).fillna(False).to_numpy(bool)
        rows.append(
            EngineRow(
                engine,
                capabilities(engine).single_precision,
                {
                    kind: {
                        name: _share_in(right, own, answers.clusters) for name, own in of.items()
                    }
                    for kind, of in groups.items()
                },
                {
                    change: share(turned(answers, change, engine), answers.clusters)
                    for change in changes
                },
                {
                    change: difference(turned(answers, change, engine), own, answers.clusters)
                    for change, own in usual.items()
                },
            )
        )
    return rows


def _groups(answers: Answers) -> dict[str, dict[str, NDArray[np.bool_]]]:
    """Masks of the cases of every group, by kind of group."""
    cases = answers.cases
    return {
        ALL: {ALL: np.ones(len(cases), dtype=bool)},
        "items": _between(cases["items"].to_numpy(), _ITEMS, "items"),
        "height": _between(cases["height"].to_numpy(), _HEIGHTS, "cm"),
        "masses": _between(cases["mass_ratio"].to_numpy(), _RATIOS, "to 1"),
    }


def _between(
    values: NDArray[np.float64], bounds: tuple[float, float], unit: str
) -> dict[str, NDArray[np.bool_]]:
    low, high = bounds
    return {
        f"up to {low:g} {unit}": values <= low,
        f"above {low:g}, to {high:g} {unit}": (values > low) & (values <= high),
        f"above {high:g} {unit}": values > high,
    }


def _share_in(hits: NDArray[np.bool_], own: NDArray[np.bool_], clusters: Clusters) -> Estimate:
    return share(hits[own], clusters.member[own]) if own.any() else NOTHING

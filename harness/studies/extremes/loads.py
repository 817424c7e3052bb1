"""Shares of verdicts that change when a load is moved or scaled, an engine a row."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from steadyload.engines.registry import capabilities
from steadyload.reports.columns import column, percent, row
from steadyload.runs.able import fixed_step_engines
from steadyload.runs.comparison import difference
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.metrics import share
from steadyload.studies.changed_loads import (
    AS_IT_IS,
    DISTANCES,
    SCALES,
    Answers,
    Change,
    judge_changed,
)
from steadyload.studies.extremes.sizes import FREQUENCY, SizeRow, closed_forms_by_size
from steadyload.studies.kit import Lab

CASES = 100
"""Cases a scenario of the set of many lists."""

FOLDER = "loads"
"""Folder of what is judged and measured, in the work folder."""


@row
class Engine:
    """An engine: its precision, and the verdicts that changes of loads change.

    Attributes:
        distances, sizes: by change, share whose verdict is another than that of the case as it is.
        excess: by change, that share less the mean of those of all engines of double precision, on
            the same cases; no number where there is none of these.
    """

    engine: str = column()
    single: bool = column("precision", lambda single: "single" if single else "double", left=True)
    distances: Mapping[Change, Estimate] = column("{} %", percent)
    sizes: Mapping[Change, Estimate] = column("{} %", percent)
    excess: Mapping[Change, Estimate] = column("{}, more", percent)

    @property
    def has_cost(self) -> bool:
        """Whether the excess is above 0 at some distance."""
        return any(self.excess[change].low > 0.0 for change in DISTANCES)

    @property
    def grows(self) -> bool:
        """Whether the excess is larger far away than nearby."""
        return self.excess[DISTANCES[-1]].low > self.excess[DISTANCES[0]].value


@row
class Loads:
    """Engines on loads that are moved and scaled, and errors of closed forms at several sizes."""

    rows: Sequence[Engine]
    cases: int
    item_lists: int
    sizes: Sequence[SizeRow]
    frequency: int = FREQUENCY
    near: Change = DISTANCES[0]
    far: Change = DISTANCES[-1]

    @property
    def single(self) -> list[Engine]:
        """Engines of single precision, where there are others to compare them with."""
        return [own for own in self.rows if own.single and own.excess]

    @property
    def dearest(self) -> Change:
        """The size at which most verdicts of an engine of single precision change."""
        return max(SCALES, key=lambda change: max(own.excess[change].value for own in self.single))

    @property
    def points(self) -> list[Mapping[str, Any]]:
        """Points of the chart."""
        return [
            {
                "title": f"{own.engine} ({'single' if own.single else 'double'})",
                "engine": own.engine,
                "is_double": not own.single,
                "change": what,
                "place": getattr(change, field),
                "changed": changed,
            }
            for own in self.rows
            for what, field, found in (
                ("moved away from the origin (m)", "moved", own.distances),
                ("times as large", "scale", own.sizes),
            )
            for change, changed in found.items()
        ]


def loads_moved_and_scaled(lab: Lab, limit: int) -> Loads:
    """Judge so many cases a scenario under every change; closed forms at several sizes."""
    able = fixed_step_engines()
    answers = judge_changed(lab, able, limit, (AS_IT_IS, *DISTANCES, *SCALES), FOLDER)
    sizes = closed_forms_by_size(lab, able, f"{FOLDER}/sizes")
    return Loads(summarise(answers), len(answers.cases), len(answers.clusters), sizes)


def summarise(answers: Answers) -> list[Engine]:
    """A row an engine."""
    single = {name: capabilities(name).single_precision for name in answers.engines}
    hits = {
        change: {engine: answers.changed(change, engine) for engine in answers.engines}
        for change in (*DISTANCES, *SCALES)
    }

    def shares(engine: str, changes: Sequence[Change]) -> dict[Change, Estimate]:
        return {change: share(hits[change][engine], answers.clusters) for change in changes}

    def excess(engine: str) -> dict[Change, Estimate]:
        double = [name for name in answers.engines if not single[name]]
        return {
            change: difference(
                own[engine], np.mean([own[name] for name in double], axis=0), answers.clusters
            )
            for change, own in hits.items()
            if double
        }

    return [
        Engine(name, single[name], shares(name, DISTANCES), shares(name, SCALES), excess(name))
        for name in answers.engines
    ]

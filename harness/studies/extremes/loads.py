"""Shares of verdicts that change when a load is moved or scaled, an engine a row."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import chain
from typing import NamedTuple

import numpy as np

from steadyload.engines.registry import capabilities
from steadyload.properties.closed_form_tests import ClosedFormResult, closed_form_tests
from steadyload.reports.columns import cell, column, compact, general, percent, row
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
from steadyload.studies.extremes.sizes import EDGES, FREQUENCY, TESTS, closed_forms_by_size
from steadyload.studies.kit import Lab

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
    def far(self) -> Estimate:
        """Excess where a load is farthest from the origin."""
        return self.excess[DISTANCES[-1]]

    @property
    def near(self) -> Estimate:
        """Excess where it is nearest."""
        return self.excess[DISTANCES[0]]

    @property
    def has_cost(self) -> bool:
        """Whether the excess is above 0 at some distance."""
        return any(self.excess[change].low > 0.0 for change in DISTANCES)

    @property
    def grows(self) -> bool:
        """Whether the excess is larger far away than nearby."""
        return self.far.low > self.near.value


@row
class SizeRow:
    """Errors of a closed form at a size, by engine."""

    test: str = column()
    unit: str = column("in")
    edge: float = column("edge, m", general)
    errors: Mapping[str, str] = column("{}")


class Point(NamedTuple):
    """A share of changed verdicts at its place in a chart."""

    title: str
    engine: str
    is_double: bool
    change: str
    place: float
    changed: Estimate


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
    def points(self) -> list[Point]:
        """Points of the chart."""
        return [
            Point(
                f"{own.engine} ({'single' if own.single else 'double'})", own.engine,
                not own.single, what, place, changed,
            )
            for own in self.rows
            for change, changed in chain(own.distances.items(), own.sizes.items())
            for what, place in [
                ("moved away from the origin (m)", change.moved)
                if change.moved
                else ("times as large", change.scale)
            ]
        ]  # fmt: skip


def loads_moved_and_scaled(lab: Lab, engines: Sequence[str], limit: int) -> Loads:
    """Judge cases under every change, and measure closed forms at several sizes.

    Args:
        lab: where it runs.
        engines: names; others than those of three dimensions and fixed steps are left out.
        limit: cases a scenario of the set of many lists.
    """
    able = [name for name in fixed_step_engines() if not engines or name in engines]
    answers = judge_changed(lab, able, limit, (AS_IT_IS, *DISTANCES, *SCALES), FOLDER)
    sizes = size_rows(closed_forms_by_size(lab, able, f"{FOLDER}/sizes"))
    return Loads(summarise(answers), len(answers.cases), len(answers.clusters), sizes)


def size_rows(found: Mapping[tuple[str, str, float], ClosedFormResult]) -> list[SizeRow]:
    """Rows of the results by test, engine and edge."""
    units = {test.name: test.error_unit for test in closed_form_tests()}
    engines = dict.fromkeys(engine for _, engine, _ in found)

    def error(result: ClosedFormResult) -> str:
        return result.note or cell(None) if result.error is None else compact(result.error)

    return [
        SizeRow(test, units[test], edge, {own: error(found[test, own, edge]) for own in engines})
        for test in TESTS
        for edge in EDGES
    ]


def summarise(answers: Answers) -> list[Engine]:
    """A row an engine."""
    double = [name for name in answers.engines if not capabilities(name).single_precision]
    hits = {
        engine: {change: answers.changed(change, engine) for change in (*DISTANCES, *SCALES)}
        for engine in answers.engines
    }
    rows = []
    for engine, own in hits.items():
        shares = {change: share(hit, answers.clusters) for change, hit in own.items()}
        rows.append(
            Engine(
                engine=engine,
                single=capabilities(engine).single_precision,
                distances={change: shares[change] for change in DISTANCES},
                sizes={change: shares[change] for change in SCALES},
                excess={
                    change: difference(
                        hit, np.mean([hits[name][change] for name in double], axis=0),
                        answers.clusters,
                    )
                    for change, hit in own.items()
                    if double
                },
            )
        )  # fmt: skip
    return rows

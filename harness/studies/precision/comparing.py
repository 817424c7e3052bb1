"""Shares of verdicts that a change turns, and accuracy by the kind of load, an engine a row."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import chain
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from steadyload.engines.registry import capabilities
from steadyload.properties.closed_form_tests import ClosedFormResult, closed_form_tests
from steadyload.reports.columns import cell, column, compact, general, percent, row
from steadyload.runs.able import fixed_step_engines
from steadyload.runs.comparison import difference
from steadyload.runs.provenance import provenance_lines
from steadyload.statistics.clusters import Clusters
from steadyload.statistics.estimate import NOTHING, Estimate
from steadyload.statistics.metrics import share
from steadyload.studies.kit import Lab
from steadyload.studies.precision.changes import AS_IT_IS, DISTANCES, SCALES, Change
from steadyload.studies.precision.judging import Answers, judge_changed, turned
from steadyload.studies.precision.sizes import EDGES, FREQUENCY, TESTS, closed_forms_by_size

_ITEMS = (10, 15)
_HEIGHTS = (30.0, 80.0)
_RATIOS = (10.0, 100.0)
"""Bounds between the groups of cases; heights in cm."""

ALL = "all"


@row
class Engine:
    """An engine: its precision, its accuracy by group, and the verdicts that changes turn.

    Attributes:
        accuracy: by kind of group and by group of cases, share whose failing step is the label's.
        distances, sizes: by change, share whose verdict is another than that of the case as it is.
        excess: by change, that share less the mean of those of all engines of double precision, on
            the same cases; no number where there is none of these.
    """

    engine: str = column()
    single: bool = column("precision", lambda single: "single" if single else "double", left=True)
    accuracy: Mapping[str, Mapping[str, Estimate]]
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
class Group:
    """Accuracy of an engine by group of cases."""

    engine: str = column()
    groups: Mapping[str, Estimate] = column("{} %", percent)


@row
class SizeRow:
    """Errors of a closed form at a size, by engine."""

    test: str = column()
    unit: str = column("in")
    edge: float = column("edge, m", general)
    errors: Mapping[str, str] = column("{}")


class Point(NamedTuple):
    """A share of turned verdicts at its place in a chart."""

    title: str
    engine: str
    is_double: bool
    change: str
    place: float
    turned: Estimate


@row
class Found:
    """Everything the page shows."""

    rows: Sequence[Engine]
    cases: int
    item_lists: int
    sizes: Sequence[SizeRow]
    made_with: Mapping[str, str]
    frequency: int = FREQUENCY
    near: Change = DISTANCES[0]
    far: Change = DISTANCES[-1]

    @property
    def single(self) -> list[Engine]:
        """Engines of single precision, where there are others to compare them with."""
        return [own for own in self.rows if own.single and own.excess]

    @property
    def dearest(self) -> Change:
        """The size at which an engine of single precision turns most verdicts."""
        return max(SCALES, key=lambda change: max(own.excess[change].value for own in self.single))

    @property
    def points(self) -> list[Point]:
        """Points of the chart."""
        return [
            Point(
                f"{own.engine} ({'single' if own.single else 'double'})", own.engine,
                not own.single, what, place, turned,
            )
            for own in self.rows
            for change, turned in chain(own.distances.items(), own.sizes.items())
            for what, place in [
                ("moved away from the origin (m)", change.moved)
                if change.moved
                else ("times as large", change.scale)
            ]
        ]  # fmt: skip

    @property
    def accuracies(self) -> dict[str, list[Group]]:
        """Rows of the tables of accuracy, by kind of group."""
        return {
            kind: [Group(own.engine, own.accuracy[kind]) for own in self.rows]
            for kind in self.rows[0].accuracy
        }


def compare(lab: Lab, directory: str, limit: int, only: Sequence[str] = ()) -> Found:
    """Judge cases under every change, and measure closed forms at several sizes.

    Args:
        lab: where it runs.
        directory: of the labelled set, see :func:`steadyload.layouts.benchmark.dataset.set_named`.
        limit: cases a scenario, those of the first ranks.
        only: engines; empty for all.

    Raises:
        as :func:`steadyload.studies.precision.judging.judge_changed`.
    """
    made_with = provenance_lines()
    where: dict[str, Any] = {"workers": lab.workers, "progress": lab.progress}
    answers = judge_changed(directory, limit, lab.work, only=only, **where)
    sizes = closed_forms_by_size(fixed_step_engines(only), lab.work, **where)
    return Found(
        summarise(answers), len(answers.cases), len(answers.clusters), size_rows(sizes), made_with
    )


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
    """A row an engine, in the order of the registry."""
    groups = _groups(answers)
    double = [name for name in answers.engines if not capabilities(name).single_precision]
    usual = {
        change: np.mean([turned(answers, change, name) for name in double], axis=0)
        for change in (*DISTANCES, *SCALES)
        if double
    }
    rows = []
    for engine in answers.engines:
        said = answers.said[AS_IT_IS][engine]
        right = said.eq(answers.cases["safe"]).fillna(False).to_numpy(bool)
        hits = {change: turned(answers, change, engine) for change in (*DISTANCES, *SCALES)}
        shares = {change: share(hit, answers.clusters) for change, hit in hits.items()}
        rows.append(
            Engine(
                engine=engine,
                single=capabilities(engine).single_precision,
                accuracy={
                    kind: {
                        name: _share_in(right, own, answers.clusters) for name, own in of.items()
                    }
                    for kind, of in groups.items()
                },
                distances={change: shares[change] for change in DISTANCES},
                sizes={change: shares[change] for change in SCALES},
                excess={
                    change: difference(hits[change], own, answers.clusters)
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

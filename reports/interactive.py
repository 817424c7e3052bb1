"""Charts that a reader can ask, in pages that are looked at in a browser."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from steadyload.reports.charts.drawing import CostPoint
from steadyload.reports.style import colour, face, marker
from steadyload.reports.table import milliseconds, percent
from steadyload.statistics.estimate import Estimate

STABLE = -1
"""In the place of a failing step, where the whole layout is stable."""


@dataclass(frozen=True, slots=True)
class CostChart:
    """Accuracy against cost: names when pointed at, the front labelled, a group at a time.

    Attributes:
        groups: methods by group of cases, such as a scenario.
        fronts: by group, specs of the methods than which no cheaper one is as accurate.
        quantity: name of the share that is drawn.
    """

    groups: Mapping[str, Sequence[CostPoint]]
    fronts: Mapping[str, Collection[str]]
    quantity: str = "accuracy"

    kind = "cost"
    players = ()
    caption = ""

    def data(self) -> dict[str, Any]:
        """The chart as plain values; points without a share or a cost are left out."""
        return {
            "kind": self.kind,
            "quantity": self.quantity,
            "groups": [
                {"title": title, "points": _points(points, self.fronts[title])}
                for title, points in self.groups.items()
            ],
        }


@dataclass(frozen=True, slots=True)
class AnsweredCase:
    """A case, and the failing step that each method names, counted from 0.

    Attributes:
        layout, scenario: of the case.
        said: a failing step, :data:`STABLE`, or None without a verdict; in the order of methods.
        player: page of :func:`steadyload.reports.viewer.page.player_html` with the marks of
            :data:`steadyload.reports.viewer.page.MARKS`; empty where nothing can be played.
    """

    layout: str
    scenario: str
    said: tuple[int | None, ...]
    player: str = ""


@dataclass(frozen=True, slots=True)
class AnswerChart:
    """How often every two methods differ, and on which cases.

    Attributes:
        methods: titles; what a label says may stand among them.
        cases: all cases that were judged.
        caption: what its cells are, in the place of the picture's caption.
    """

    methods: tuple[str, ...]
    cases: tuple[AnsweredCase, ...]
    caption: str

    kind = "answers"

    def data(self) -> dict[str, Any]:
        """The chart as plain values, without players."""
        return {
            "kind": self.kind,
            "methods": self.methods,
            "cases": [[case.layout, case.scenario, *case.said] for case in self.cases],
            "played": [number for number, case in enumerate(self.cases) if case.player],
        }

    @property
    def players(self) -> tuple[str, ...]:
        """Pages of the cases that can be played, in their order."""
        return tuple(case.player for case in self.cases if case.player)


Interactive = CostChart | AnswerChart


def _points(points: Sequence[CostPoint], front: Collection[str]) -> list[dict[str, Any]]:
    shown = [point for point in points if point.share.n and point.cost.n and point.cost.value > 0.0]
    return [
        {
            "title": point.method.title,
            "engine": point.method.engine or "no engine",
            "colour": colour(point.method),
            "face": face(point.method),
            "marker": marker(point.method),
            "share": _numbers(point.share, lambda value: 100.0 * value),
            "cost": _numbers(point.cost, float),
            "told": f"{percent(point.share)} %, {milliseconds(point.cost)} ms",
            "n": point.share.n,
            "front": point.method.spec in front,
        }
        for point in shown
    ]


def _numbers(found: Estimate, form: Callable[[float], float]) -> list[float]:
    return [round(form(value), 6) for value in (found.value, found.low, found.high)]

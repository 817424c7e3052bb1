"""Charts that a reader can ask, in pages that are looked at in a browser."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from steadyload.reports.style import Identified, colour, face, marker
from steadyload.reports.table import milliseconds, percent
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.front import undominated

STABLE = -1
"""In the place of a failing step, where the whole layout is stable."""


@dataclass(frozen=True, slots=True)
class CostPoint:
    """A method's cost of a layout [ms], and a share such as its accuracy [0 to 1].

    ``more``: text on the cost that is shown beside it; empty for none.
    """

    method: Identified
    share: Estimate
    cost: Estimate
    more: str = ""


@dataclass(frozen=True, slots=True)
class CostChart:
    """Accuracy against cost: names when pointed at, the front labelled, a group at a time.

    Attributes:
        groups: methods by group of cases, such as a scenario.
        quantity: name of the share that is drawn.
    """

    groups: Mapping[str, Sequence[CostPoint]]
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
                {"title": title, "points": _points(points)} for title, points in self.groups.items()
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


def _points(points: Sequence[CostPoint]) -> list[dict[str, Any]]:
    judged = [point for point in points if point.share.n and point.cost.n]
    best = undominated(judged, lambda p: p.cost.value, lambda p: -p.share.value)
    front = {point.method.spec for point in best}
    shown = [point for point in judged if point.cost.value > 0.0]
    return [
        {
            "title": point.method.title,
            "engine": point.method.engine or "no engine",
            "colour": colour(point.method),
            "face": face(point.method),
            "marker": marker(point.method),
            "share": _numbers(point.share, lambda value: 100.0 * value),
            "cost": _numbers(point.cost, float),
            "told": f"{percent(point.share)} %, {milliseconds(point.cost)} ms"
            + (f" ({point.more})" if point.more else ""),
            "n": point.share.n,
            "front": point.method.spec in front,
        }
        for point in shown
    ]


def _numbers(found: Estimate, form: Callable[[float], float]) -> list[float]:
    return [round(form(value), 6) for value in (found.value, found.low, found.high)]

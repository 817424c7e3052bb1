"""Everything that the page of loading sessions shows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from steadyload.methods.naming import MethodKey
from steadyload.reports.columns import row
from steadyload.runs.costs import CostKind, CostSource
from steadyload.studies.session.packing_gains import PackingTask
from steadyload.studies.session.placing import SCENES, Scene, SessionCurve


@row
class Cost:
    """CPU time of a placement at a number of loaded items [ms]."""

    items: int
    ms: float


@row
class Line:
    """A line of the chart: placements in a session, or by judging the whole layout."""

    method: MethodKey
    scene: str
    way: str
    points: Sequence[Cost]


@row
class Found:
    """Costs of placements, and gains of packing heuristics; what was not measured is empty."""

    curves: Sequence[SessionCurve]
    tasks: Sequence[PackingTask]
    made_with: Mapping[str, str]
    scenes: Sequence[Scene] = SCENES

    @property
    def costs(self) -> str:
        """The sentence on the source of times."""
        return CostSource(CostKind.ONE_PROCESS).explained()

    @property
    def lines(self) -> list[Line]:
        """The lines of the chart."""
        ways = {"in a session": "placement", "the whole layout": "whole"}
        return [
            Line(curve.method, curve.scene, way, points)
            for way, name in ways.items()
            for curve in self.curves
            if (points := _costs(curve, name))
        ]


def _costs(curve: SessionCurve, name: str) -> list[Cost]:
    found = [(point.items, getattr(point, name)) for point in curve.points]
    return [Cost(items, ms) for items, ms in found if ms is not None]

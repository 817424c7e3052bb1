"""Everything that the page of loading sessions shows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from steadyload.methods.naming import MethodKey
from steadyload.reports.columns import row
from steadyload.runs.costs import CostKind, CostSource
from steadyload.studies.session.packing_gains import PackingTask
from steadyload.studies.session.placing import SCENES, Scene, SessionCurve


@row
class Shown:
    """A point of the chart: a placement in a session, or judging the whole layout [ms]."""

    method: MethodKey
    scene: str
    way: str
    items: int
    ms: float | None


@row
class Found:
    """Costs of placements, and gains of packing heuristics."""

    curves: Sequence[SessionCurve]
    tasks: Sequence[PackingTask]
    made_with: Mapping[str, str]
    scenes: Sequence[Scene] = SCENES

    @property
    def costs(self) -> str:
        """The sentence on the source of times."""
        return CostSource(CostKind.ONE_PROCESS).explained()

    @property
    def shown(self) -> list[Shown]:
        """The points of the chart."""
        ways = {"in a session": "placement", "the whole layout": "whole"}
        return [
            Shown(curve.method, curve.scene, way, point.items, getattr(point, name))
            for way, name in ways.items()
            for curve in self.curves
            for point in curve.points
        ]

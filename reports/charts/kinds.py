"""The kinds of charts, by the names under which a page's template calls them."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from steadyload.reports.charts.bars import bars
from steadyload.reports.charts.change import change
from steadyload.reports.charts.columns import columns
from steadyload.reports.charts.curves import curves
from steadyload.reports.charts.drawing import Chart
from steadyload.reports.charts.ecdf import ecdf
from steadyload.reports.charts.forest import forest
from steadyload.reports.charts.front import front
from steadyload.reports.charts.heat import heat
from steadyload.reports.charts.outcomes import outcomes
from steadyload.reports.charts.scene import scene

KINDS: Mapping[str, Callable[..., Chart]] = {
    kind.__name__: kind
    for kind in (front, change, curves, forest, bars, columns, heat, outcomes, ecdf, scene)
}
"""All kinds. Each takes rows and names of their fields; the documentation of a kind says which."""

"""Figure of the benchmark: cost of a judgement against the number of items."""

from __future__ import annotations

import math
from collections.abc import Sequence

from steadyload.methods.naming import method_key
from steadyload.methods.registry import make_method
from steadyload.reports.charts.curves import curves
from steadyload.reports.charts.drawing import Chart
from steadyload.studies.speed.records import GrowthCurve


def plot_growth(measured: Sequence[GrowthCurve]) -> Chart:
    """CPU time against the number of items, both on log axes; a line style a scene."""
    rows = [
        {
            "key": (key := method_key(make_method(curve.method))),
            "scene": curve.scene,
            "title": f"{key.title}, {curve.scene}"
            + (f": J^{curve.exponent.value:.2f}" if math.isfinite(curve.exponent.value) else ""),
            "points": curve.points,
        }
        for curve in measured
    ]
    return curves(
        rows, "items", "microseconds", within="points", look="method", of="key", dash="scene",
        log="xy", ticks="all", x_label="items in the layout, J",
        y_label="CPU time a judgement (us)",
    )  # fmt: skip

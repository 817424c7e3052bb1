"""Figure of the benchmark: cost of a judgement against the number of items."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from steadyload.methods.naming import method_key
from steadyload.methods.registry import make_method
from steadyload.reports.charts.drawing import finish_growth, reach
from steadyload.reports.style import colour, face, marker
from steadyload.studies.speed.records import GrowthCurve

_LINES = ("-", "--", ":", "-.")
"""Lines of the scenes, in turn."""


def plot_growth(curves: Sequence[GrowthCurve]) -> Figure:
    """CPU time against the number of items, both on log axes; a line style a scene."""
    figure = Figure(figsize=(7.6, 4.8))
    axes = figure.add_subplot()
    scenes = list(dict.fromkeys(curve.scene for curve in curves))
    for curve in curves:
        if not curve.points:
            continue
        key = method_key(make_method(curve.method))
        label = f"{key.title}, {curve.scene}"
        if math.isfinite(curve.exponent.value):
            label += f": J^{curve.exponent.value:.2f}"
        axes.errorbar(
            [p.items for p in curve.points],
            [p.microseconds.value for p in curve.points],
            yerr=np.hstack([reach(p.microseconds) for p in curve.points]),
            linestyle=_LINES[scenes.index(curve.scene) % len(_LINES)],
            linewidth=1.1,
            elinewidth=0.6,
            capsize=2,
            marker=marker(key),
            markersize=5,
            markerfacecolor=face(key),
            color=colour(key),
            label=label,
        )
    finish_growth(axes, {p.items for c in curves for p in c.points}, "CPU time a judgement (us)")
    return figure

"""Figure of the benchmark: cost of a judgement against the number of items."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from steadyload.methods.naming import method_key
from steadyload.methods.registry import make_method
from steadyload.reports.charts import PLAIN_TICKS, reach
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
    axes.set(xscale="log", yscale="log")
    axes.yaxis.set_major_formatter(PLAIN_TICKS)
    axes.set_xlabel("items in the layout, J")
    axes.set_ylabel("CPU time a judgement (us)")
    counts = sorted({p.items for c in curves for p in c.points})
    axes.set_xticks(counts, [str(n) for n in counts])
    axes.minorticks_off()
    axes.grid(visible=True, linewidth=0.4, alpha=0.6)
    axes.legend(loc="center left", bbox_to_anchor=(1.01, 0.5), frameon=False)
    return figure

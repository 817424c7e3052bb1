"""Figure of the study of precision: verdicts that are turned, by distance and by size."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from steadyload.reports.charts.drawing import PLAIN_TICKS, reach
from steadyload.reports.style import engine_colour, engine_marker
from steadyload.studies.precision.changes import DISTANCES, SCALES
from steadyload.studies.precision.summary import EngineRow


def plot_turned(rows: Sequence[EngineRow]) -> Figure:
    """Shares of turned verdicts; solid: single precision, dashed: double."""
    figure = Figure(figsize=(7.6, 3.6))
    left, right = figure.subplots(1, 2, sharey=True)
    for number, row in enumerate(rows):
        style = {
            "color": engine_colour(row.engine),
            "marker": engine_marker(row.engine),
            "linestyle": "-" if row.single else "--",
            "linewidth": 1.2,
            "markersize": 5,
            "elinewidth": 0.7,
            "capsize": 2,
        }
        aside = 1.0 + 0.04 * (number - 0.5 * len(rows))  # else intervals hide each other
        for axes, changes, places in (
            (left, DISTANCES, [change.moved for change in DISTANCES]),
            (right, SCALES, [change.scale for change in SCALES]),
        ):
            found = [row.turned[change] for change in changes]
            axes.errorbar(
                [aside * place for place in places],
                [100.0 * share.value for share in found],
                yerr=np.hstack([reach(share, 100.0) for share in found]),
                label=f"{row.engine} ({'single' if row.single else 'double'})",
                **style,
            )
    for axes, ticks, label in (
        (left, [c.moved for c in DISTANCES], "moved away from the origin (m)"),
        (right, [c.scale for c in SCALES], "times as large"),
    ):
        axes.set_xscale("log")
        axes.set_xticks(ticks, [f"{place:g}" for place in ticks])
        axes.minorticks_off()
        axes.set_xlabel(label)
        axes.yaxis.set_major_formatter(PLAIN_TICKS)
    left.set_ylabel("verdicts turned (%)")
    left.set_ylim(bottom=0.0)
    left.legend(fontsize=8)
    figure.tight_layout()
    return figure

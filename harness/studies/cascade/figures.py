"""Pictures of a cascade."""

from __future__ import annotations

from matplotlib.figure import Figure

from steadyload.reports.charts import (
    ACCURACY_LABEL,
    CostPoint,
    draw_cost_point,
    reach,
    set_cost_axis,
    spread_the_top,
)
from steadyload.reports.style import colour, marker
from steadyload.studies.cascade.summary import CascadeStudy


def plot_sweep(study: CascadeStudy) -> Figure:
    """Accuracy over CPU time: methods as points, and a line through a cascade's budgets."""
    figure = Figure(figsize=(7.6, 4.6))
    axes = figure.add_subplot()
    methods, swept = study.methods, study.swept
    for row in methods:
        if row not in swept:
            point = CostPoint(row.method, row.accuracy, row.cpu)
            draw_cost_point(axes, point, linestyle="none", label=row.method.title)
    if swept:
        axes.errorbar(
            [row.cpu.value for row in swept],
            [100 * row.accuracy.value for row in swept],
            yerr=[[reach(row.accuracy, 100.0)[side][0] for row in swept] for side in (0, 1)],
            marker=marker(swept[0].method),
            color=colour(swept[0].method),
            markersize=6,
            linewidth=1.0,
            elinewidth=0.8,
            label="Cascade, by budget",
        )
        for number, row in enumerate(swept):
            axes.annotate(
                f"{study.budgets[row.method.spec]:g}",
                (row.cpu.value, 100 * row.accuracy.value),
                xytext=(-4, -11 if number % 2 else 5),
                textcoords="offset points",
                ha="right",
                fontsize=8,
            )
    set_cost_axis(axes)
    spread_the_top(axes, min(100 * row.accuracy.low for row in methods))
    axes.set_ylabel(ACCURACY_LABEL)
    axes.legend(loc="center left", bbox_to_anchor=(1.01, 0.5), frameon=False)
    return figure

"""Pictures of a cascade."""

from __future__ import annotations

from matplotlib.figure import Figure

from steadyload.reports.charts.drawing import CostPoint, plot_cost_accuracy, reach, spread_the_top
from steadyload.reports.style import colour, marker
from steadyload.studies.cascade.summary import CascadeStudy


def plot_sweep(study: CascadeStudy) -> Figure:
    """Accuracy over CPU time: methods as points, and a line through a cascade's budgets."""
    swept = study.swept
    others = [row for row in study.methods if row not in swept]
    figure = plot_cost_accuracy([CostPoint(row.method, row.accuracy, row.cpu) for row in others])
    [axes] = figure.axes
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
    spread_the_top(axes, min(100 * row.accuracy.low for row in study.methods))
    axes.legend(loc="center left", bbox_to_anchor=(1.01, 0.5), frameon=False)
    return figure

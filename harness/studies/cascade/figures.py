"""Pictures of a cascade."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, NullFormatter

from steadyload.reports.style import colour, face, marker
from steadyload.statistics.estimate import Estimate
from steadyload.studies.cascade.summary import CascadeStudy

_TOP = 100.5
_TICKS = (0.0, 20.0, 40.0, 60.0, 80.0, 90.0, 95.0, 98.0, 99.0, 99.5, 100.0)

_PLAIN = FuncFormatter(lambda value, _: f"{value:g}")


def plot_sweep(study: CascadeStudy) -> Figure:
    """Accuracy over CPU time: methods as points, and a line through a cascade's budgets."""
    figure = Figure(figsize=(7.6, 4.6))
    axes = figure.add_subplot()
    methods, swept = study.methods, study.swept
    for row in methods:
        if row not in swept:
            axes.errorbar(
                row.cpu.value,
                100 * row.accuracy.value,
                xerr=_reach(row.cpu, 1.0),
                yerr=_reach(row.accuracy, 100.0),
                fmt=marker(row.method),
                color=colour(row.method),
                markerfacecolor=face(row.method),
                markersize=8,
                elinewidth=0.8,
                linestyle="none",
                label=row.method.title,
            )
    if swept:
        axes.errorbar(
            [row.cpu.value for row in swept],
            [100 * row.accuracy.value for row in swept],
            yerr=[[_reach(row.accuracy, 100.0)[side][0] for row in swept] for side in (0, 1)],
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
    axes.set_xscale("log")
    spread_the_top(axes, min(100 * row.accuracy.low for row in methods))
    axes.xaxis.set_major_formatter(_PLAIN)
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.set_xlabel("CPU time a layout (ms)")
    axes.set_ylabel("accuracy (% of cases with the label's failing step)")
    axes.grid(visible=True, which="major", linewidth=0.4, alpha=0.6)
    axes.legend(loc="center left", bbox_to_anchor=(1.01, 0.5), frameon=False)
    return figure


def spread_the_top(axes: Axes, least: float) -> None:
    """Accuracies [%] by their distance from a little above 100, on a logarithmic scale."""
    axes.set_yscale(
        "function",
        functions=(
            lambda y: -np.log10(np.maximum(_TOP - np.asarray(y, dtype=float), 1e-3)),
            lambda t: _TOP - 10.0 ** -np.asarray(t, dtype=float),
        ),
    )
    axes.set_ylim(max(0.0, least - 5.0), 100.0)
    axes.set_yticks([tick for tick in _TICKS if tick > least - 5.0])
    axes.yaxis.set_major_formatter(_PLAIN)
    axes.yaxis.set_minor_formatter(NullFormatter())


def _reach(estimate: Estimate, scale: float) -> list[list[float]]:
    """How far the interval reaches to both sides."""
    return [
        [scale * max(0.0, estimate.value - estimate.low)],
        [scale * max(0.0, estimate.high - estimate.value)],
    ]

"""Figure of the costs of errors."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from steadyload.reports.charts.drawing import PLAIN_TICKS
from steadyload.reports.style import colour, face, marker
from steadyload.statistics.error_costs import LEAST, MOST
from steadyload.studies.table5.summary import ErrorCosts

_POINTS = 41
"""Ratios at which a line is drawn, ten a decade and both ends."""


def plot_error_costs(costs: ErrorCosts) -> Figure:
    """Expected cost over the ratio of costs, both logarithmic: a line a method, with its interval.

    Costs of 0 have no place on a logarithmic axis and are left out.
    """
    ratios = np.geomspace(LEAST, MOST, _POINTS)
    figure = Figure(figsize=(7.6, 4.8))
    axes = figure.add_subplot()
    for row in costs.methods:
        if row.errors is None:
            continue
        found = [row.errors.cost(float(ratio)) for ratio in ratios]
        value, low, high = (
            np.array([getattr(each, name) for each in found]) for name in ("value", "low", "high")
        )
        shown = value > 0.0
        axes.fill_between(
            ratios, np.maximum(low, 1e-6), high, where=shown, color=colour(row.method), alpha=0.08
        )
        axes.plot(
            ratios[shown],
            value[shown],
            color=colour(row.method),
            marker=marker(row.method),
            markerfacecolor=face(row.method),
            markevery=10,
            markersize=5.5,
            label=row.method.title,
        )
    for each in costs.cheapest[1:]:
        axes.axvline(each.least, color="black", linewidth=0.8, linestyle=":")
    axes.set_xscale("log")
    axes.set_yscale("log")
    values = [row.errors.cost(ratio).value for row in costs.methods if row.errors is not None
              for ratio in (LEAST, MOST)]  # fmt: skip
    lowest = min((value for value in values if value > 0.0), default=1e-3)
    axes.set_ylim(bottom=0.5 * lowest)
    axes.xaxis.set_major_formatter(PLAIN_TICKS)
    axes.yaxis.set_major_formatter(PLAIN_TICKS)
    axes.set_xlabel("cost of an overestimation / cost of an underestimation")
    axes.set_ylabel("expected cost a layout")
    axes.grid(visible=True, which="major", linewidth=0.4, alpha=0.6)
    axes.legend(loc="center left", bbox_to_anchor=(1.01, 0.5), frameon=False)
    return figure

"""The kind ``change``: what options change over what they cost in proportion."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from matplotlib.figure import Figure

from steadyload.reports.charts.drawing import PLAIN_TICKS, Chart, legend
from steadyload.reports.charts.rows import Field, along, flat, grouped, method_of, value
from steadyload.reports.style import marker

_TICKS = (0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0)
_BELOW, _ABOVE = 1.6, 2.2
"""Factors by which the axis of cost goes on below and above what it shows."""


def change(
    rows: Sequence[Any],
    x: Field,
    y: Field,
    *,
    title: Field = "title",
    method: Field = "method",
    within: Field = "",
    panel: Field = "",
    panel_title: str = "{}",
    x_label: str,
    y_label: str,
) -> Chart:
    """Changes [%] against cost in proportion, an option a point: good ones stand lower left.

    The dashed line is the cost of that which options are compared with. Colours are those of
    titles, markers those of methods.

    Args:
        rows: one a point, or records of points.
        x: field of the cost in proportion, an estimate.
        y: field of the share that changes, an estimate.
        title: field of the option's title, which may be Markdown.
        method: field of its method.
        within: field of a row that holds its points.
        panel: field of what a panel shows.
        panel_title: title of a panel, with ``{}`` for the value.
        x_label: label of x.
        y_label: label of y.

    Raises:
        ChartError: rows have no field of such a name, or it holds something else.
    """
    points = flat(rows, within)
    panels = grouped(points, panel)
    options = list(grouped(points, title))
    figure = Figure(figsize=(3.8 * len(panels) + 2.2, 4.2), layout="constrained")
    drawn = figure.subplots(1, len(panels), sharey=True, squeeze=False)[0]
    costs = along(points, x).values
    low, high = min([*costs, 0.5]) / _BELOW, max([*costs, 1.0]) * _ABOVE
    for axes, (of, members) in zip(drawn, panels.items(), strict=True):
        for row in members:
            cost, share = along([row], x), along([row], y, 100.0)
            axes.errorbar(
                cost.values, share.values, xerr=cost.reaches, yerr=share.reaches,
                fmt=marker(method_of(row, method)),
                color=f"C{options.index(value(row, title)) % 10}",
                label=value(row, title).replace("`", ""), markersize=6.0, elinewidth=0.8,
            )  # fmt: skip
        axes.axvline(1.0, linestyle="--", linewidth=0.8, color="#7f7f7f")
        axes.set(xscale="log", xlim=(low, high), xlabel=x_label)
        axes.set_xticks([tick for tick in _TICKS if low <= tick <= high])
        axes.xaxis.set_major_formatter(PLAIN_TICKS)
        axes.set_xticks([], minor=True)
        axes.set_title(panel_title.format(of), fontsize=9.0)
        axes.grid(visible=True, which="major", linewidth=0.4, alpha=0.6)
    legend(figure, "right")
    drawn[0].set_ylabel(y_label)
    drawn[0].set_ylim(bottom=-0.5)
    return Chart(figure)

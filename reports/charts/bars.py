"""The kind ``bars``: shares or amounts that add up, by their length."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from steadyload.reports.charts.drawing import Chart
from steadyload.reports.charts.rows import Field, along, grouped, value

_SHADES = ("#08519c", "#9ecae1", "#3182bd", "#c7c7c7")
"""Colours of parts that add up, in turn."""


def bars(
    rows: Sequence[Any],
    parts: Mapping[Field, str],
    *,
    title: Field = "title",
    whole: Field = "",
    panel: Field = "",
    percent: bool = True,
    x_label: str,
) -> Chart:
    """Shares or amounts that add up: a bar a row, from left to right its parts.

    Args:
        rows: one a bar, from above.
        parts: by field of a share [0 to 1] or an amount, a number or an estimate, its title.
        title: field of the bar's title.
        whole: field of the sum, an estimate whose interval is drawn.
        panel: field of what a panel shows, which is its title; panels lie above each other.
        percent: whether parts are shares, shown in per cent; else the sum stands at a bar's end.
        x_label: label of x.

    Raises:
        ChartError: rows have no field of such a name, or it is no number.
    """
    panels, scale = grouped(rows, panel), 100.0 if percent else 1.0
    heights = [len(members) + 1 for members in panels.values()]
    figure = Figure(figsize=(7.6, 1.0 + 0.32 * sum(heights)))
    drawn = figure.subplots(len(panels), squeeze=False, sharex=True, height_ratios=heights)[:, 0]
    for axes, (shown, members) in zip(drawn, panels.items(), strict=True):
        places, left = np.arange(len(members)), np.zeros(len(members))
        for (name, part), shade in zip(parts.items(), _SHADES, strict=False):
            widths = along(members, name, scale).values
            axes.barh(places, widths, left=left, color=shade, label=part)
            left = left + widths
        if whole:
            ends = along(members, whole, scale)
            axes.errorbar(
                ends.values, places, xerr=ends.reaches, fmt="none", ecolor="#333333",
                elinewidth=0.8, capsize=2,
            )  # fmt: skip
        axes.set_yticks(places, [value(row, title) for row in members])
        axes.invert_yaxis()
        if percent:
            axes.set_xlim(0.0, 100.0)
        else:
            axes.bar_label(axes.containers[-1], [f" {end:.3g}" for end in left], fontsize=8)
        axes.set_title(str(shown), fontsize=9, loc="left")
    drawn[-1].set_xlabel(x_label)
    drawn[0].legend(fontsize=8, loc="lower right")
    figure.tight_layout()
    return Chart(figure)

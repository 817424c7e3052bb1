"""The kind ``bars``: quantities by their length, stacked on their sides or upright in groups."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from steadyload.reports.charts.drawing import Chart, legend
from steadyload.reports.charts.rows import Field, along, grouped, value

_INK = "#08519c"
_SHADES = ("#9ecae1", "#4292c6", "#08519c", "#7f7f7f")
"""Colours of groups beside each other, in turn."""

_STACKED = ("#08519c", "#9ecae1", "#3182bd", "#c7c7c7")
"""Colours of parts that add up, in turn."""


def bars(
    rows: Sequence[Any],
    parts: Mapping[Field, str],
    *,
    title: Field = "title",
    whole: Field = "",
    panel: Field = "",
    x_label: str,
) -> Chart:
    """Shares [%] that add up to a share of a whole: a bar a row, from left to right its parts.

    Args:
        rows: one a bar, from above.
        parts: by field of a share [0 to 1], a number or an estimate, its title.
        title: field of the bar's title.
        whole: field of the sum, an estimate whose interval is drawn.
        panel: field of what a panel shows, which is its title; panels lie above each other.
        x_label: label of x.

    Raises:
        FieldError: rows have no field of such a name, or it is no number.
    """
    panels = grouped(rows, panel)
    heights = [len(members) + 1 for members in panels.values()]
    figure = Figure(figsize=(7.6, 1.0 + 0.32 * sum(heights)))
    drawn = figure.subplots(len(panels), squeeze=False, sharex=True, height_ratios=heights)[:, 0]
    for axes, (shown, members) in zip(drawn, panels.items(), strict=True):
        places, left = np.arange(len(members)), np.zeros(len(members))
        for (name, part), shade in zip(parts.items(), _STACKED, strict=False):
            widths = along(members, name, 100.0).values
            axes.barh(places, widths, left=left, color=shade, label=part)
            left = left + widths
        if whole:
            ends = along(members, whole, 100.0)
            axes.errorbar(
                ends.values, places, xerr=ends.reaches, fmt="none", ecolor="#333333",
                elinewidth=0.8, capsize=2,
            )  # fmt: skip
        axes.set_yticks(places, [value(row, title) for row in members])
        axes.invert_yaxis()
        axes.set_xlim(0.0, 100.0)
        axes.set_title(str(shown), fontsize=9, loc="left")
    drawn[-1].set_xlabel(x_label)
    drawn[0].legend(fontsize=8, loc="lower right")
    figure.tight_layout()
    return Chart(figure)


def columns(
    rows: Sequence[Any],
    heights: Mapping[Field, str],
    *,
    title: Field = "title",
    percent: bool = False,
    last_apart: bool = False,
    x_label: str,
    y_label: str,
    size: tuple[float, float] = (7.0, 3.2),
) -> Chart:
    """Numbers by height: of one field at the places of numbers, of several in groups.

    Args:
        rows: one a group of columns beside each other.
        heights: by field of a height, the title of that column.
        title: field of what stands below: a number, which has its place, or a text.
        percent: whether heights are shares [0 to 1] that are shown in per cent.
        last_apart: whether the last group stands apart.
        x_label: label of x.
        y_label: label of y.
        size: width and height [inch].

    Raises:
        FieldError: rows have no field of such a name, or it is no number.
    """
    figure = Figure(figsize=size, layout="constrained")
    axes = figure.subplots()
    scale = 100.0 if percent else 1.0
    names = [value(row, title) for row in rows]
    if all(isinstance(name, int | float) for name in names):
        for field in heights:
            axes.bar(names, along(rows, field, scale).values, color=_INK)
        axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    else:
        width = 0.8 / len(heights)
        places = np.arange(len(rows), dtype=float)
        places[-1] += 0.5 * last_apart
        for index, (field, name) in enumerate(heights.items()):
            shift = (index - 0.5 * (len(heights) - 1)) * width
            axes.bar(
                places + shift, along(rows, field, scale).values, width,
                color=_SHADES[index % len(_SHADES)], label=name,
            )  # fmt: skip
        axes.set_xticks(places, names, fontsize=7)
        legend(figure, "best")
    axes.set_xlabel(x_label)
    axes.set_ylabel(y_label)
    return Chart(figure)

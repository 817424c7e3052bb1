"""The kind ``columns``: numbers by height, side by side."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from steadyload.reports.charts.drawing import Chart, legend
from steadyload.reports.charts.rows import Field, along, value

_INK = "#08519c"
_SHADES = ("#9ecae1", "#4292c6", "#08519c", "#7f7f7f")
"""Colours of the columns of a group, in turn."""


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
        ChartError: rows have no field of such a name, or it is no number.
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

"""The kind ``heat``: a quantity of every two of several things, as colours and numbers."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from steadyload.reports.charts.drawing import Chart
from steadyload.reports.charts.rows import Field, along, grouped, value
from steadyload.reports.interactive import Interactive
from steadyload.reports.table import MISSING


def heat(
    rows: Sequence[Any],
    x: Field,
    y: Field,
    shade: Field,
    *,
    pale: Field = "",
    differences: bool = False,
    label: str,
    interactive: Interactive | None = None,
) -> Chart:
    """Shares [%] or differences of shares [points], a cell a row.

    Rows and columns stand in the order in which they come; where they are the same things, columns
    in the order of rows.

    Args:
        rows: one a cell; a share or difference that is not a number is a dash.
        x: field of the title of the cell's column.
        y: field of that of its row.
        shade: field of the share [0 to 1] or difference [-1 to 1], a number or an estimate.
        pale: field of whether a cell has no colour, and its number is pale.
        differences: whether colours have their middle at 0.
        label: what colours show.
        interactive: the chart that stands in its place in the HTML page.

    Raises:
        ChartError: rows have no field of such a name, or it is no number.
    """
    columns, lines = list(grouped(rows, x)), list(grouped(rows, y))
    if set(columns) == set(lines):
        columns = lines
    cells = [(lines.index(value(row, y)), columns.index(value(row, x))) for row in rows]
    numbers = dict(zip(cells, along(rows, shade, 100.0).values, strict=True))
    coloured = np.full((len(lines), len(columns)), math.nan)
    for cell, row in zip(cells, rows, strict=True):
        coloured[cell] = math.nan if pale and value(row, pale) else numbers[cell]
    known = np.array([number for number in numbers.values() if not math.isnan(number)])
    draw = _differences if differences else _shares
    return Chart(draw(lines, columns, numbers, coloured, known, label), interactive)


_Numbers = dict[tuple[int, int], float]
_Array = NDArray[np.float64]


def _shares(
    lines: Sequence[str], columns: Sequence[str], numbers: _Numbers, coloured: _Array,
    known: _Array, label: str,
) -> Figure:  # fmt: skip
    least = 10.0 * math.floor(float(known.min()) / 10.0) if known.size else 0.0
    lowest = min(least, 90.0)
    dark = lowest + 0.65 * (100.0 - lowest)
    side = 1.8 + 0.5 * len(lines)
    figure = Figure(figsize=(side + 0.6, side))
    axes = figure.add_subplot()
    shown = axes.imshow(coloured, vmin=lowest, vmax=100, cmap="viridis")
    axes.set_xticks(range(len(columns)), columns, rotation=45, ha="right")
    axes.set_yticks(range(len(lines)), lines)
    axes.spines[:].set_visible(False)
    for (line, column), number in numbers.items():
        axes.text(
            column, line, MISSING if math.isnan(number) else f"{number:.0f}", ha="center",
            va="center", fontsize=8, color="white" if number < dark else "black",
        )  # fmt: skip
    figure.colorbar(shown, ax=axes, fraction=0.046, pad=0.03).set_label(label)
    return figure


def _differences(
    lines: Sequence[str], columns: Sequence[str], numbers: _Numbers, coloured: _Array,
    known: _Array, label: str,
) -> Figure:  # fmt: skip
    most = max([1.0, *np.abs(known)])
    side = 2.0 + 0.42 * len(lines)
    figure = Figure(figsize=(side + 1.6, side))
    axes = figure.add_subplot()
    shown = axes.imshow(coloured, cmap="RdBu", vmin=-most, vmax=most)
    figure.colorbar(shown, ax=axes, fraction=0.046, pad=0.03).set_label(label)
    for (line, column), number in numbers.items():
        ink = "white" if abs(number) > 0.6 * most else "black"
        if math.isnan(coloured[line, column]):
            ink = "#a0a0a0"
        axes.text(
            column, line, _points(number), ha="center", va="center", fontsize=7, color=ink
        )  # fmt: skip
    axes.set_xticks(
        range(len(columns)), columns, rotation=50, ha="right", rotation_mode="anchor"
    )  # fmt: skip
    axes.set_yticks(range(len(lines)), lines)
    axes.spines[:].set_visible(False)
    axes.tick_params(length=0)
    return figure


def _points(number: float) -> str:
    """A difference in points, short, and never minus zero."""
    if math.isnan(number):
        return MISSING
    return f"{number:.0f}" if abs(number) >= 9.95 else f"{round(number, 1) + 0.0:.1f}"

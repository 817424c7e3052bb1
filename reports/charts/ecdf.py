"""The kind ``ecdf``: how many of something have come to a value or lie below it, a step a value."""

from __future__ import annotations

import itertools
from collections.abc import Collection, Sequence
from typing import Any

from matplotlib.figure import Figure

from steadyload.reports.charts.drawing import Chart, legend
from steadyload.reports.charts.rows import Field, grouped, value

_LINES = (
    ("#1f77b4", "-"), ("#d62728", "-"), ("#ff9896", "--"), ("#2ca02c", "-"), ("#7f7f7f", ":"),
)  # fmt: skip


def ecdf(
    rows: Sequence[Any],
    x: Field,
    *,
    title: Field = "title",
    of: Field,
    among: Collection[str] = (),
    x_label: str,
    y_label: str,
) -> Chart:
    """Share of a group [%] that has ended by a share of its way [%]: a line of steps a group.

    The number of members stands behind a group's title.

    Args:
        rows: one a group.
        x: field of the shares [0 to 1] at which members end, ascending; others do not end.
        title: field of the group's title.
        of: field of the number of all its members.
        among: titles of all groups there may be: then a group has the same line on every page.
        x_label: label of x.
        y_label: label of y.

    Raises:
        ChartError: rows have no field of such a name.
    """
    figure = Figure(figsize=(6.4, 4.2))
    axes = figure.add_subplot()
    lines = dict(zip(among or grouped(rows, title), itertools.cycle(_LINES), strict=False))
    for row in rows:
        ends, count, name = value(row, x), value(row, of), value(row, title)
        shade, line = lines[name]
        across = [0.0, *(100.0 * end for end in ends), 100.0]
        up = [100.0 * k / count for k in range(len(ends) + 1)]
        axes.step(
            across, [*up, up[-1]], line, where="post", color=shade, linewidth=1.6,
            label=f"{name} ({count})",
        )  # fmt: skip
    axes.set(xlim=(0.0, 100.0), ylim=(-1.0, 100.0), xlabel=x_label, ylabel=y_label)
    axes.grid(visible=True, linewidth=0.4, alpha=0.6)
    legend(figure, "upper left")
    return Chart(figure)

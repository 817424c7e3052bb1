"""The kind ``ecdf``: how many of something have come to a value or lie below it, a step a value."""

from __future__ import annotations

import itertools
from collections.abc import Collection, Sequence
from typing import Any

from matplotlib.figure import Figure

from steadyload.reports.charts.drawing import Chart, legend
from steadyload.reports.charts.rows import Field, chosen, grouped, value
from steadyload.reports.style import DASHES, LOOKS

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
    look: str = "",
    by: Field = "",
    dash: Field = "",
    span: tuple[float, float] | None = None,
    x_label: str,
    y_label: str,
) -> Chart:
    """Share of a group [%] that has ended by a share of its way [%]: a line of steps a group.

    The number of members stands behind a group's title.

    Args:
        rows: one a group.
        x: field of the shares [0 to 1], or with a span of the values, at which members end,
            ascending; others do not end.
        title: field of the group's title.
        of: field of the number of all its members.
        among: titles of all groups there may be: then a group has the same line on every page.
        look: what fixes colours, one of :data:`steadyload.reports.style.LOOKS`; else they are those
            of titles, in turn.
        by: field of the method or engine that has this look; else it is of the title.
        dash: field of what the line's dashes show, with a look.
        span: where x begins and ends, of values that are no shares; 0 is marked.
        x_label: label of x.
        y_label: label of y.

    Raises:
        ChartError: rows have no field of such a name.
    """
    figure = Figure(figsize=(6.4, 4.2))
    axes = figure.add_subplot()
    lines = dict(zip(among or grouped(rows, title), itertools.cycle(_LINES), strict=False))
    if look:
        lines = _looks(rows, title, look, by, dash)
    scale, (first, last) = (1.0, span) if span else (100.0, (0.0, 100.0))
    for row in rows:
        ends = [scale * end for end in value(row, x)]
        count, name = value(row, of), value(row, title)
        shade, line = lines[name]
        across = [min([first, *ends]), *ends, max([last, *ends])]
        up = [100.0 * k / count for k in range(len(ends) + 1)]
        axes.step(
            across, [*up, up[-1]], line, where="post", color=shade, linewidth=1.6,
            label=f"{name} ({count})",
        )  # fmt: skip
    if span:
        axes.axvline(0.0, color="#999999", linewidth=0.6)
    axes.set(xlim=(first, last), ylim=(-1.0, 100.0), xlabel=x_label, ylabel=y_label)
    axes.grid(visible=True, linewidth=0.4, alpha=0.6)
    legend(figure, "beside" if span else "upper left")
    return Chart(figure)


def _looks(
    rows: Sequence[Any], title: str, look: str, by: str, dash: str
) -> dict[str, tuple[str, str]]:
    """Colour and dashes by title."""
    look_of = LOOKS[chosen(look, LOOKS, "look")]
    dashes = list(grouped(rows, dash))
    return {
        value(row, title): (
            look_of(value(row, by or title), place).colour,
            DASHES[dashes.index(value(row, dash) if dash else "") % len(DASHES)],
        )
        for place, row in enumerate(rows)
    }

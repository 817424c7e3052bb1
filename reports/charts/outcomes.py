"""The kind ``outcomes``: what came out at every two values, as colours and signs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch, Rectangle

from steadyload.reports.charts.drawing import Chart
from steadyload.reports.charts.rows import Field, chosen, grouped, value

_LOOKS = (("#08519c", ""), ("#9ecae1", ""), ("#f16913", "×"), ("#d9d9d9", "?"), ("white", "–"))
"""Colours and signs in turn: distinct in every kind of colour vision, and as greys."""

_BLANK = "#f7f7f7"


def outcomes(
    rows: Sequence[Any],
    x: Field,
    y: Field,
    outcome: Field,
    *,
    titles: Mapping[Any, str],
    panel: Field = "",
    x_label: str,
    y_label: str,
) -> Chart:
    """Outcomes by two values, a cell a row; a cell without a row stays blank.

    Args:
        rows: one a cell.
        x: field of what stands across; its values stand in the order in which they come.
        y: field of a number that rises.
        outcome: field of the outcome.
        titles: of at most five outcomes in the legend, the best one first.
        panel: field of what a panel shows, which is its title.
        x_label: label of x.
        y_label: label of y.

    Raises:
        ChartError: rows have no field of such a name, or an outcome that has no title.
    """
    panels = grouped(rows, panel)
    across = [list(grouped(own, x)) for own in panels.values()]
    levels = sorted(grouped(rows, y))
    figure = Figure(figsize=(10.0, 1.6 + 0.2 * len(levels)))
    widths = {"width_ratios": [max(2.0, float(len(columns))) for columns in across]}
    drawn = figure.subplots(1, len(panels), sharey=True, squeeze=False, gridspec_kw=widths)[0]
    looks = dict(zip(titles, _LOOKS, strict=False))
    for axes, (title, own), columns in zip(drawn, panels.items(), across, strict=True):
        for row in own:
            seen = chosen(value(row, outcome), titles, "outcome")
            place = columns.index(value(row, x)), levels.index(value(row, y))
            _cell(axes, *place, *looks[seen])
        axes.set(xlim=(-0.5, len(columns) - 0.5), ylim=(-0.5, len(levels) - 0.5))
        axes.set_xticks(range(len(columns)), columns, rotation=90, fontsize=8.0)
        axes.tick_params(length=0.0)
        axes.set_title(title, fontsize=9.0)
        axes.spines[:].set_visible(False)
        axes.set_facecolor(_BLANK)
    drawn[0].set_yticks(range(len(levels)), list(map(_short, levels)), fontsize=8.0)
    drawn[0].set_ylabel(y_label)
    height = figure.get_figheight()
    figure.text(0.5, 0.3 / height, x_label, fontsize=9.0, ha="center")
    shown = [one for one in titles if one in grouped(rows, outcome)]
    named = {f"{looks[one][1]} {titles[one]}".strip(): looks[one][0] for one in shown}
    if len(rows) < len(levels) * sum(map(len, across)):
        named["not measured"] = _BLANK
    figure.legend(
        handles=[
            Patch(facecolor=shade, edgecolor="#7f7f7f", linewidth=0.5, label=title)
            for title, shade in named.items()
        ],
        loc="lower center", ncols=len(named), frameon=False, fontsize=8.0,
    )  # fmt: skip
    figure.tight_layout(rect=(0.0, 0.4 / height, 1.0, 1.0), w_pad=0.4)
    return Chart(figure)


def _cell(axes: Axes, x: int, y: int, shade: str, sign: str) -> None:
    corner = (x - 0.5, y - 0.5)
    axes.add_patch(Rectangle(corner, 1.0, 1.0, facecolor=shade, edgecolor="white"))
    axes.text(x, y - 0.05, sign, fontsize=7, ha="center", va="center")


def _short(number: float) -> str:
    return f"{number:g}" if number < 1e4 else f"{number:.0e}".replace("e+0", "e")

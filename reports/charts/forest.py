"""The kind ``forest``: estimates with their intervals on one scale, a row each."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from matplotlib.figure import Figure

from steadyload.reports.charts.drawing import Chart, legend
from steadyload.reports.charts.rows import Field, along, chosen, grouped, value
from steadyload.reports.style import LOOKS


def forest(
    rows: Sequence[Any],
    x: Field,
    *,
    title: Field = "title",
    panel: Field = "",
    look: str = "place",
    of: Field = "",
    dots: Field = "",
    zero: bool = False,
    marks: Mapping[str, float] | None = None,
    x_label: str,
) -> Chart:
    """Shares or differences [%] with their intervals, one below the other.

    Args:
        rows: one a row of the chart and a panel.
        x: field of the share [0 to 1] or difference, an estimate or a number.
        title: field of the row's title.
        panel: field of what a panel shows, which is its title; panels stand beside each other.
        look: what fixes colour and marker, one of :data:`steadyload.reports.style.LOOKS`.
        of: field of the method, engine or group that has this look; else it is of the title.
        dots: field of single values [0 to 1] that are drawn below the estimate.
        zero: whether a line marks 0.
        marks: by its title in the legend, a share [0 to 1] that a dotted line marks.
        x_label: label of x.

    Raises:
        ChartError: rows have no field of such a name, or it is no number.
    """
    look_of = LOOKS[chosen(look, LOOKS, "look")]
    panels, titles = grouped(rows, panel), list(grouped(rows, title))
    looks = list(grouped(rows, of or title))
    figure = Figure(figsize=(2.2 + 2.2 * len(panels), 0.9 + 0.32 * len(titles)))
    drawn = figure.subplots(1, len(panels), sharey=True, squeeze=False)[0]
    for axes, (shown, members) in zip(drawn, panels.items(), strict=True):
        for row in members:
            level = titles.index(value(row, title))
            like = value(row, of or title)
            seen = look_of(like, looks.index(like))
            found = along([row], x, 100.0)
            axes.errorbar(
                found.values, [-level], xerr=found.reaches, fmt=seen.marker, color=seen.colour,
                markersize=6.0, elinewidth=1.0,
            )  # fmt: skip
            if dots:
                single = [100.0 * each for each in value(row, dots)]
                axes.plot(
                    single, [-level - 0.25] * len(single), ".", color=seen.colour, markersize=4.0
                )
        if zero:
            axes.axvline(0.0, color="black", linewidth=0.8)
        for mark, share in (marks or {}).items():
            axes.axvline(100.0 * share, color="#222222", linestyle=":", linewidth=1.0, label=mark)
        if panel:
            axes.set_title(str(shown), fontsize=9.0)
        axes.set_xlabel(x_label)
        axes.grid(visible=True, linewidth=0.4, alpha=0.6)
    drawn[0].set_yticks([-level for level in range(len(titles))], titles)
    legend(figure, "beside")
    return Chart(figure)

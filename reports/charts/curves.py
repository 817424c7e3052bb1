"""The kind ``curves``: quantities over a number, a line a thing, in one panel or several."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from steadyload.reports.charts.drawing import PLAIN_TICKS, Chart, legend
from steadyload.reports.charts.rows import Along, Field, along, chosen, flat, grouped, value
from steadyload.reports.style import LOOKS

_LINES = ("-", "--", ":", "-.")
_STYLE = {"linewidth": 1.1, "markersize": 5.0}
_ENDS = {"elinewidth": 0.6, "capsize": 2.0}
_THIN = {"linewidth": 0.7, "markersize": 3.0}
_ROOM = 1.2
"""Smallest factor between ticks of a log axis that do not overlap."""


def curves(
    rows: Sequence[Any],
    x: Field | Sequence[Field],
    y: Field,
    *,
    title: Field = "title",
    within: Field = "",
    look: str = "place",
    of: Field = "",
    dash: Field = "",
    thin: Field = "",
    panel: Field = "",
    percent: str = "",
    log: str = "",
    ticks: str = "",
    diagonal: bool = False,
    x_label: str | Sequence[str] = "",
    y_label: str = "",
    y_from: float | None = None,
    size: tuple[float, float] = (7.6, 4.8),
    **style: Any,
) -> Chart:
    """Values with their intervals over a number, as lines.

    Args:
        rows: one a point, or records of points; of those without a value there is none.
        x: field of the number; of several, each has a panel of its own.
        y: field of the value, a number or an estimate.
        title: field of the line's title: rows of one title are one line.
        within: field of a row that holds its points.
        look: what fixes colour and marker, one of :data:`steadyload.reports.style.LOOKS`.
        of: field of the method or engine that has this look; else it is of the title.
        dash: field of what the line's dashes show.
        thin: field of whether the line is drawn thin.
        panel: field of what a panel shows, which is its title.
        percent: axes of shares that are shown in per cent: "x", "y" or "xy".
        log: axes that are logarithmic, likewise.
        ticks: numbers of the rows that x has its ticks at: "all", or those "apart" that upright
            labels have room for; else as they come.
        diagonal: whether a dotted line shows where both are equal.
        x_label: label of x, or of each panel.
        y_label: label of y.
        y_from: where y begins.
        size: width and height [inch].
        style: of lines, in the place of the usual one, as of Matplotlib's ``errorbar``.

    Raises:
        ChartError: rows have no field of such a name, or it is no number; or an option is not
            allowed.
    """
    look_of = LOOKS[chosen(look, LOOKS, "look")]
    points = flat(rows, within)
    lines, dashes = list(grouped(points, title)), list(grouped(points, dash))
    across = [x] if isinstance(x, str) else list(x)
    panels = [(name, shown, members) for name in across
              for shown, members in grouped(points, panel).items()]  # fmt: skip
    labels = [x_label] * len(panels) if isinstance(x_label, str) else list(x_label)
    figure = Figure(figsize=size)
    drawn = figure.subplots(1, len(panels), sharey=True, squeeze=False)[0]
    for axes, (name, shown, members), label in zip(drawn, panels, labels, strict=True):
        if diagonal:
            axes.plot([0, 100], [0, 100], color="#7f7f7f", linewidth=0.8, linestyle=":")
        for line, own in grouped(members, title).items():
            own = [row for row in own if value(row, y) is not None]
            own.sort(key=lambda row: value(row, name))
            if not own:
                continue
            seen = look_of(value(own[0], of or title), lines.index(line))
            dashed = dashes.index(value(own[0], dash)) if dash else 0
            drawn_as = _THIN if thin and value(own[0], thin) else {}
            _draw(
                axes, along(own, name, _scale("x", percent)), along(own, y, _scale("y", percent)),
                marker=seen.marker, color=seen.colour, markerfacecolor=seen.face,
                linestyle=_LINES[dashed % len(_LINES)], label=line,
                **{**_STYLE, **style, **drawn_as},
            )  # fmt: skip
        axes.set(xscale="log" if "x" in log else "linear", yscale="log" if "y" in log else "linear")
        axes.yaxis.set_major_formatter(PLAIN_TICKS)
        if chosen(ticks, ("", "all", "apart"), "ticks"):
            _tick(axes, {value(row, name) for row in points}, ticks)
        axes.set_xlabel(label)
        if shown:
            axes.set_title(str(shown), fontsize=9.0)
        axes.grid(visible=True, linewidth=0.4, alpha=0.6)
    drawn[0].set_ylabel(y_label)
    if y_from is not None:
        drawn[0].set_ylim(bottom=y_from)
    legend(figure, "beside")
    return Chart(figure)


def _draw(axes: Axes, places: Along, values: Along, **style: Any) -> None:
    if values.reaches is None:
        style = {key: one for key, one in style.items() if key not in _ENDS}
        axes.plot(places.values, values.values, **style)
    else:
        axes.errorbar(places.values, values.values, yerr=values.reaches, **{**_ENDS, **style})


def _scale(axis: str, percent: str) -> float:
    return 100.0 if axis in percent else 1.0


def _tick(axes: Axes, numbers: Iterable[float], which: str) -> None:
    places = sorted(numbers) if which == "all" else _apart(numbers)
    rotation = 0 if which == "all" else 90
    axes.set_xticks(places, [f"{place:g}" for place in places], rotation=rotation)
    axes.minorticks_off()


def _apart(numbers: Iterable[float]) -> list[float]:
    """Numbers that have room beside each other on a log axis, from the largest down."""
    kept: list[float] = []
    for number in sorted(numbers, reverse=True):
        if not kept or number * _ROOM < kept[-1]:
            kept.append(number)
    return kept

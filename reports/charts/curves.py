"""The kind ``curves``: quantities over a number, a line a thing, in one panel or several."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from steadyload.reports.charts.drawing import PLAIN_TICKS, Chart, legend, set_log_axis
from steadyload.reports.charts.rows import Along, Field, along, chosen, flat, grouped, value
from steadyload.reports.style import DASHES, LOOKS

_STYLE = {"linewidth": 1.1, "markersize": 5.0}
_ENDS = {"elinewidth": 0.6, "capsize": 2.0}
_LINE = 11.0
"""Height of a line of text [points]."""

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
    hollow: Field = "",
    limit: Field = "",
    panel: Field = "",
    above: Field = "",
    ends: bool = False,
    across: int = 0,
    own_y: bool = False,
    apart: float = 1.0,
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
        x: field of the number, or of a text that has its place in the order of the rows; of
            several fields, each has a panel of its own.
        y: field of the value, a number or an estimate.
        title: field of the line's title: rows of one title are one line.
        within: field of a row that holds its points.
        look: what fixes colour and marker, one of :data:`steadyload.reports.style.LOOKS`.
        of: field of the method or engine that has this look; else it is of the title.
        dash: field of what the line's dashes show; of a truth value, that it is true.
        hollow: field of whether a point's marker is hollow.
        limit: field of a number of y at which the panel has a dotted line; None for none.
        panel: field of what a panel shows, which is its title.
        above: field of what the panels of one line show; lines of panels stand above each other.
        ends: whether a line's title stands at its end, in the last panel, and not in a legend.
        across: panels beside each other; 0 for all of them.
        own_y: whether every panel has a y of its own, of two decades or more where it is
            logarithmic, so that a flat line looks flat; else they share one.
        apart: factor in x from one line to the next, so that none hides the intervals of another.
        percent: axes of shares that are shown in per cent: "x", "y" or "xy".
        log: axes that are logarithmic, likewise.
        ticks: numbers of a panel that x has its ticks at: "all", or those "apart" that upright
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
    names = [x] if isinstance(x, str) else list(x)
    beside = [(name, shown) for name in names for shown in grouped(points, panel)]
    labels = [x_label] * len(beside) if isinstance(x_label, str) else list(x_label)
    panels = [
        (floor, name, shown, grouped(own, panel).get(shown, []), label)
        for floor, own in grouped(points, above).items()
        for (name, shown), label in zip(beside, labels, strict=True)
    ]
    across = across or len(beside)
    lines_of_panels = math.ceil(len(panels) / across)
    wrapped = lines_of_panels > 1 and not above
    figure = Figure(figsize=size, layout="constrained" if wrapped or own_y else None)
    drawn = figure.subplots(lines_of_panels, across, sharey=not own_y, squeeze=False).ravel()
    for axes in drawn[len(panels) :]:
        axes.remove()
    for axes, (floor, name, shown, members, label) in zip(drawn, panels, strict=False):
        if diagonal:
            axes.plot([0, 100], [0, 100], color="#7f7f7f", linewidth=0.8, linestyle=":")
        if not members:
            axes.set_axis_off()
            continue
        texts = _texts(members, name)
        for line, own in grouped(members, title).items():
            own = [row for row in own if value(row, y) is not None]
            if not own:
                continue
            own.sort(key=lambda row: _place(value(row, name), texts))
            seen = look_of(value(own[0], of) if of else line, lines.index(line))
            dashed = _dashes(value(own[0], dash), dashes) if dash else 0
            aside = apart ** (lines.index(line) - 0.5 * (len(lines) - 1))
            places = _across(own, name, texts, aside * _scale("x", percent))
            values = along(own, y, _scale("y", percent))
            _draw(
                axes, places, values,
                marker=seen.marker, color=seen.colour, markerfacecolor=seen.face,
                linestyle=DASHES[dashed % len(DASHES)], label=line,
                **{**_STYLE, **style},
            )  # fmt: skip
            if hollow:
                empty = [k for k, row in enumerate(own) if value(row, hollow)]
                axes.plot(
                    [places.values[k] for k in empty], [values.values[k] for k in empty],
                    seen.marker, color=seen.colour, markerfacecolor="white",
                    markersize=_STYLE["markersize"],
                )  # fmt: skip
        if "x" in log:
            set_log_axis(axes)
        axes.set_yscale("log" if "y" in log else "linear")
        for at in {value(row, limit) for row in members} - {None} if limit else ():
            axes.axhline(at, color="#7f7f7f", linewidth=0.8, linestyle=":")
        if own_y and "y" in log:
            _show_two_decades(axes)
        axes.yaxis.set_major_formatter(PLAIN_TICKS)
        if texts:
            axes.set_xticks(range(len(texts)), texts, rotation=30)
        elif chosen(ticks, ("", "all", "apart"), "ticks"):
            _tick(axes, {value(row, name) for row in members}, ticks)
        axes.set_xlabel(label)
        if shown or floor:
            axes.set_title(": ".join(filter(None, map(str, (floor, shown)))), fontsize=9.0)
        axes.grid(visible=True, linewidth=0.4, alpha=0.6)
        if ends and shown == beside[-1][1]:
            _name_ends(axes)
    for axes in drawn[::across]:
        axes.set_ylabel(y_label)
    if y_from is not None:
        drawn[0].set_ylim(bottom=y_from)
    if above:
        figure.tight_layout()
    if not ends:
        has_room = len(panels) < len(drawn)
        legend(figure, ("corner" if has_room else "right") if wrapped else "beside")
    return Chart(figure)


def _texts(rows: Sequence[Any], name: str) -> list[str]:
    """Texts that stand at x, in the order of the rows; none where x is a number."""
    found = list(grouped(rows, name))
    return found if all(isinstance(one, str) for one in found) else []


def _place(x: Any, texts: Sequence[str]) -> Any:
    return texts.index(x) if texts else x


def _across(rows: Sequence[Any], name: str, texts: Sequence[str], scale: float) -> Along:
    if texts:
        return Along([float(texts.index(value(row, name))) for row in rows], None)
    return along(rows, name, scale)


def _show_two_decades(axes: Axes) -> None:
    low, high = axes.get_ylim()
    if high < 100.0 * low:
        middle = math.sqrt(low * high)
        axes.set_ylim(middle / 10.0, middle * 10.0)


def _name_ends(axes: Axes) -> None:
    """Titles of lines at their ends, none over another: those that have no room move down."""
    ends = []
    for handle, title in zip(*axes.get_legend_handles_labels(), strict=True):
        line: Any = getattr(handle, "lines", (handle,))[0]
        ends.append((*map(float, line.get_xydata()[-1]), line, title))
    points = 72.0 / axes.figure.dpi
    free = math.inf
    for x, y, line, title in sorted(ends, key=lambda end: -end[1]):
        end = points * float(axes.transData.transform((x, y))[1])
        place = min(end, free)
        free = place - _LINE
        axes.annotate(
            title, (x, y), xytext=(8.0, place - end), textcoords="offset points", va="center",
            fontsize=8, color=line.get_color(), annotation_clip=False,
        )  # fmt: skip


def _draw(axes: Axes, places: Along, values: Along, **style: Any) -> None:
    if values.reaches is None:
        style = {key: one for key, one in style.items() if key not in _ENDS}
        axes.plot(places.values, values.values, **style)
    else:
        axes.errorbar(places.values, values.values, yerr=values.reaches, **{**_ENDS, **style})


def _dashes(shown: Any, among: Sequence[Any]) -> int:
    """The place of a line's dashes; what is true is dashed, whatever comes first."""
    return int(shown) if isinstance(shown, bool) else among.index(shown)


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

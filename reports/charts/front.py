"""The kind ``front``: a share over cost, a point a row, and lines that join some of them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import chain
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from steadyload.reports.charts.drawing import (
    ACCURACY_LABEL,
    COST_LABEL,
    Chart,
    draw_cost_point,
    legend,
    set_cost_axis,
    spread_the_top,
)
from steadyload.reports.charts.rows import Field, along, chosen, estimate_of, method_of, value
from steadyload.reports.interactive import CostChart, CostPoint
from steadyload.reports.style import LOOKS, Look, colour, face, marker
from steadyload.statistics.front import undominated


def front(
    rows: Sequence[Any],
    x: Field = "cpu",
    y: Field = "accuracy",
    *,
    method: Field = "method",
    lines: Mapping[str, Sequence[Any]] | None = None,
    look: str = "method",
    of: Field = "",
    note: Field = "",
    spread: bool = False,
    best: bool = False,
    groups: Mapping[str, Sequence[Any]] | None = None,
    more: Mapping[Field, str] | None = None,
    beside_cost: Field = "",
    x_label: str = COST_LABEL,
    y_label: str = ACCURACY_LABEL,
) -> Chart:
    """Share [%] against cost [ms] of methods, with intervals: good ones stand at the upper left.

    Rows without a share are left out. Colours and markers are those of methods.

    Args:
        rows: one a point that stands alone.
        x: field of the cost, an estimate.
        y: field of the share, an estimate.
        method: field of the :class:`steadyload.reports.style.Identified` that is shown.
        lines: by title, rows whose points a line joins, in their order.
        look: what fixes colour and marker of lines, one of :data:`steadyload.reports.style.LOOKS`.
        of: field of the method or engine that has this look; else it is of the method.
        note: field of the text at points of lines.
        spread: whether shares near 100 % are drawn apart.
        best: whether a dashed line joins the points than which no cheaper one is as good.
        groups: rows by title of a group of cases: then the HTML page shows one at a time.
        more: of these, further fields of shares, and what is added to the title for each.
        beside_cost: field of a text on the cost that the HTML page shows beside it.
        x_label: label of x.
        y_label: label of y.

    Raises:
        ChartError: rows have no field of such a name, or it holds something else.
    """
    figure = Figure(figsize=(7.6, 4.6))
    axes = figure.add_subplot()
    points = _points(rows, x, y, method, beside_cost)
    lines = lines or {}
    for point in points:
        draw_cost_point(axes, point)
        key = point.method
        axes.plot(
            [], [], marker(key), color=colour(key), markerfacecolor=face(key), markersize=7,
            label=key.title,
        )  # fmt: skip
    drawn = list(chain(rows, *lines.values()))
    if any(value(row, x).value > 0.0 for row in drawn):
        set_cost_axis(axes)
    axes.set_xlabel(x_label)
    axes.set_ylabel(y_label)
    for title, members in lines.items():
        seen = LOOKS[chosen(look, LOOKS, "look")](_identified(members[0], method, of), 0)
        _join(axes, title, members, (x, y), seen, note)
    if best:
        leading = undominated(
            [point for point in points if point.cost.n],
            lambda point: point.cost.value, lambda point: -point.share.value,
        )  # fmt: skip
        axes.plot(
            [point.cost.value for point in leading], [100 * point.share.value for point in leading],
            color="black", linewidth=1.0, linestyle="--", drawstyle="steps-post", zorder=1,
            label="front",
        )  # fmt: skip
    if spread:
        spread_the_top(axes, min(100 * value(row, y).low for row in drawn))
    legend(figure, "beside")
    if not groups:
        return Chart(figure)
    shares = {y: "", **(more or {})}
    points_of = {
        title + added: _points(members, x, share, method, beside_cost)
        for share, added in shares.items()
        for title, members in groups.items()
    }
    return Chart(figure, CostChart(points_of))


def _points(rows: Sequence[Any], x: str, y: str, method: str, beside_cost: str) -> list[CostPoint]:
    found = [
        CostPoint(
            method_of(row, method), estimate_of(row, y), estimate_of(row, x),
            str(value(row, beside_cost)) if beside_cost else "",
        )
        for row in rows
    ]  # fmt: skip
    return [point for point in found if not math.isnan(point.share.value)]


def _identified(row: Any, method: str, of: str) -> Any:
    return value(row, of) if of else method_of(row, method)


def _join(
    axes: Axes, title: str, rows: Sequence[Any], fields: tuple[str, str], look: Look, note: str
) -> None:
    """A line through points, with a text at each."""
    x, y = fields
    costs, shares = along(rows, x), along(rows, y, 100.0)
    axes.errorbar(
        costs.values, shares.values, yerr=shares.reaches, marker=look.marker, color=look.colour,
        markersize=6, linewidth=1.0, elinewidth=0.8, label=title,
    )  # fmt: skip
    for number, place in enumerate(zip(costs.values, shares.values, strict=True)):
        axes.annotate(
            str(value(rows[number], note)) if note else "",
            place,
            xytext=(-4, -11 if number % 2 else 5),
            textcoords="offset points",
            ha="right",
            fontsize=8,
            color=look.colour,
        )

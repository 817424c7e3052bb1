"""Figures of tuning: the cost of accuracy, changes, and transfer between engines."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from steadyload.reports.charts.drawing import draw_cost_point, reach
from steadyload.reports.interactive import CostPoint
from steadyload.reports.style import engine_colour, engine_marker
from steadyload.reports.table import compact, significant
from steadyload.runs.evaluation import MethodEvaluation
from steadyload.studies.tuning.search_figures import (
    USUAL_ACCURACIES,
    draw_front,
    set_accuracy_against_cost,
)
from steadyload.studies.tuning.summary import TransferTable, Tuning, VariantTable

_GREY = "#7f7f7f"
_FILLS = ("none", "bottom", "left", "top", "right")
"""Fill styles of the markers of methods that a tuned method is compared with."""

_TUNED = {"markersize": 10.0, "markeredgecolor": "black"}
_BOUGHT = {"markersize": 6.0, "markeredgecolor": "white"}

_DARK = 0.7
"""Share of the colour scale above which black text is not legible."""

_FAR = 10.0
"""Change [points] above which an axis is partly logarithmic, to show small changes, too."""


def plot_price(tuning: Tuning) -> Figure:
    """Accuracy against CPU time: fronts as steps, and measurements on the test part as points."""
    figure = Figure(figsize=(7.6, 5.0))
    axes = figure.add_subplot()
    priced = [*(p.engine for p in tuning.prices), *(t.engine for t in tuning.tests)]
    engines = list(dict.fromkeys([*(s.engine for s in tuning.searches), *priced]))
    for engine in engines:
        judged = [p for s in tuning.searches if s.engine == engine for p in s.judged]
        draw_front(axes, judged, engine_colour(engine), linewidth=1.2, alpha=0.8)
    # One entry of the legend for a family on all engines: its title without the engine.
    others = [(t.engine, other) for t in tuning.tests for other in t.others]
    titles = {o.method.family: o.method.title.partition(" @ ")[0] for _, o in others}
    fills = {family: _filled(_FILLS[k % len(_FILLS)]) for k, family in enumerate(titles)}
    points: list[tuple[str, MethodEvaluation, dict[str, Any]]] = [
        *((p.engine, p.test, _BOUGHT) for p in tuning.prices if p.test is not None),
        *((engine, other, fills[other.method.family]) for engine, other in others),
        *((t.engine, t.tuned, _TUNED) for t in tuning.tests),
    ]
    for engine, row, style in points:
        _draw_point(axes, engine, row, style)
    set_accuracy_against_cost(
        axes,
        [*USUAL_ACCURACIES, *(100.0 * row.accuracy.value for _, row, _ in points)],
        [row.cpu.value for _, row, _ in points],
    )
    for budget in dict.fromkeys(p.budget for p in tuning.prices):
        axes.axvline(budget, color=_GREY, linewidth=0.8, linestyle=":", zorder=0)
    handles = [
        Line2D([], [], color=engine_colour(e), marker=engine_marker(e), linewidth=1.2, label=e)
        for e in engines
    ]
    roles: list[tuple[str, dict[str, Any]]] = []
    if tuning.searches:
        roles.append(("front of the searches", {"linestyle": "-", "linewidth": 1.2}))
    if any(style is _BOUGHT for _, _, style in points):
        roles.append(("bought by a budget", _spot(_BOUGHT)))
    if tuning.tests:
        roles.append(("tuned", _spot(_TUNED)))
    roles += [(titles[family], _spot(fill)) for family, fill in fills.items()]
    handles += [Line2D([], [], color=_GREY, label=label, **style) for label, style in roles]
    axes.legend(handles=handles, loc="center left", bbox_to_anchor=(1.01, 0.5), frameon=False)
    return figure


def _spot(style: dict[str, Any]) -> dict[str, Any]:
    return {"marker": "o", "linestyle": "", **style}


def _filled(fill: str) -> dict[str, Any]:
    return {"fillstyle": fill, "markerfacecoloralt": "white", "markersize": 8.0}


def _draw_point(axes: Axes, engine: str, row: MethodEvaluation, style: dict[str, Any]) -> None:
    """A point in its engine's colour, since the figure compares engines."""
    shade = engine_colour(engine)
    own = {"fmt": engine_marker(engine), "color": shade, "markerfacecolor": shade}
    draw_cost_point(
        axes,
        CostPoint(row.method, row.accuracy, row.cpu),
        **{**own, "markeredgecolor": shade, "markeredgewidth": 1.0, **style},
    )


def plot_changes(tables: Sequence[VariantTable]) -> Figure:
    """Change of accuracy for each change of the tuned parameters, with the factor of the cost.

    A panel a table; rows are those of all tables.
    """
    changes = list(dict.fromkeys(row.change for t in tables for row in t.rows))
    level = {change: -k for k, change in enumerate(changes)}
    across = min(2, len(tables))
    down = math.ceil(len(tables) / across)
    figure = Figure(figsize=(2.6 + 3.6 * across, (0.8 + 0.22 * len(changes)) * down + 0.2))
    grid = figure.subplots(down, across, sharex=True, sharey=True, squeeze=False)
    parts = {t.part for t in tables}
    for axes, table in zip(grid.flat, tables, strict=False):
        shade, sign = engine_colour(table.engine), engine_marker(table.engine)
        for row in table.rows:
            change = row.accuracy_change
            axes.errorbar(
                100.0 * change.value,
                level[row.change],
                xerr=reach(change, 100.0),
                fmt=sign,
                color=shade,
                markersize=5.0,
                elinewidth=1.0,
            )
            axes.text(
                1.02,
                level[row.change],
                f"×{compact(row.cost_change)}",
                transform=axes.get_yaxis_transform(),
                fontsize=7.5,
                va="center",
            )
        axes.text(
            1.02, 1.02, "cost", transform=axes.transAxes, fontsize=7.5, va="bottom", color=_GREY
        )
        axes.axvline(0.0, color="black", linewidth=0.8)
        axes.grid(visible=True, linewidth=0.4, alpha=0.6)
        title = table.engine if len(parts) == 1 else f"{table.engine}, {table.part}"
        axes.set_title(title, fontsize=9.0)
        axes.tick_params(labelbottom=True)
    for axes in grid.flat[len(tables) :]:
        axes.set_axis_off()
    for axes in grid.flat[max(0, len(tables) - across) : len(tables)]:
        axes.set_xlabel("change of accuracy (percentage points)")
    first = grid[0, 0]
    first.set_yticks(list(level.values()), changes)
    first.set_ylim(-len(changes) + 0.4, 0.6)
    _set_points(first, [100.0 * v for t in tables for v in _ends(t)])
    figure.tight_layout(w_pad=1.5)
    return figure


def _ends(table: VariantTable) -> list[float]:
    return [v for r in table.rows for v in (r.accuracy_change.low, r.accuracy_change.high)]


def _set_points(axes: Axes, ends: Sequence[float]) -> None:
    """A linear axis, or one that is logarithmic beyond a point where some changes are large."""
    if max(map(abs, ends), default=0.0) <= _FAR:
        return
    axes.set_xscale("symlog", linthresh=1.0)
    ticks = [s * t for t in (1, 3, 10, 30, 100) for s in (-1, 1)] + [0]
    low, high = 1.3 * min(*ends, -1.0), 1.3 * max(*ends, 1.0)
    axes.set_xlim(low, high)
    shown = sorted(t for t in ticks if low <= t <= high)
    axes.set_xticks(shown, [f"{t:g}" for t in shown])
    axes.minorticks_off()


def plot_transfer(table: TransferTable) -> Figure:
    """Accuracy and CPU time of parameters tuned on one engine (rows) on another (columns).

    Colour is the difference of accuracy to the parameters tuned on the engine of the column, since
    engines differ by more than their tunings do.
    """
    size = len(table.engines)
    place = {engine: k for k, engine in enumerate(table.engines)}
    values = np.full((size, size), np.nan)
    figure = Figure(figsize=(2.4 + 0.95 * size, 1.4 + 0.75 * size))
    axes = figure.add_subplot()
    for cell in table.cells:
        values[place[cell.tuned_on], place[cell.judged_on]] = 100.0 * cell.found.accuracy.value
    ahead = values - np.diag(values)
    most = max([1.0, *np.abs(ahead[np.isfinite(ahead)])])
    shades = matplotlib.colormaps["RdBu"].with_extremes(bad="#f0f0f0")
    image = axes.imshow(
        np.ma.masked_invalid(ahead), cmap=shades, norm=Normalize(-most, most), aspect="auto"
    )
    for cell in table.cells:
        row, column = place[cell.tuned_on], place[cell.judged_on]
        axes.text(
            column,
            row,
            f"{values[row, column]:.1f}\n{significant(cell.found.cpu.value)} ms",
            ha="center",
            va="center",
            fontsize=8.0,
            fontweight="bold" if row == column else "normal",
            color="white" if abs(ahead[row, column]) > _DARK * most else "black",
        )
    axes.set_xticks(range(size), table.engines)
    axes.set_yticks(range(size), table.engines)
    axes.set_xlabel("judged on")
    axes.set_ylabel("tuned on")
    axes.spines[:].set_visible(False)
    axes.tick_params(length=0.0)
    figure.colorbar(image, ax=axes, pad=0.03).set_label("ahead of the own parameters (points)")
    return figure

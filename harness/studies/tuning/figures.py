"""Pictures of what tuning found: the price of accuracy, changes, and transfer between engines."""

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

from steadyload.reports.charts import reach
from steadyload.reports.style import engine_colour, engine_marker
from steadyload.reports.table import compact, significant
from steadyload.runs.evaluation import MethodEvaluation
from steadyload.studies.tuning.records import (
    TransferTable,
    Tuning,
    VariantTable,
)
from steadyload.studies.tuning.search_figures import (
    USUAL_ACCURACIES,
    draw_front,
    set_accuracy_against_cost,
)

_GREY = "#7f7f7f"
_FILLS = ("none", "bottom", "left", "top", "right")
"""How the markers are filled of what a tuned method is held against."""

_DARK = 0.7
"""Beyond this share of the scale of colours, black does not read."""

_FAR = 10.0
"""Changes of more than so many points need an axis that also shows the small ones."""


def plot_price(tuning: Tuning) -> Figure:
    """Accuracy against CPU time: fronts as steps, and what was measured on test as points."""
    named = [
        *(s.engine for s in tuning.searches),
        *(p.engine for p in tuning.prices),
        *(t.engine for t in tuning.tests),
    ]
    engines = list(dict.fromkeys(named))
    figure = Figure(figsize=(7.6, 5.0))
    axes = figure.add_subplot()
    for engine in engines:
        judged = [p for s in tuning.searches if s.engine == engine for p in s.judged]
        draw_front(axes, judged, engine_colour(engine), linewidth=1.2, alpha=0.8)
    families = list(dict.fromkeys(o.method.family for t in tuning.tests for o in t.others))
    titles = _family_titles(tuning)
    bought = [(p.engine, p.test) for p in tuning.prices if p.test is not None]
    shown = [o for _, o in bought]
    for engine, outcome in bought:
        _point(axes, engine, outcome, markersize=6.0, markeredgecolor="white")
    for table in tuning.tests:
        for other in table.others:
            fill = _FILLS[families.index(other.method.family) % len(_FILLS)]
            _point(axes, table.engine, other, **_filled(fill), markersize=8.0)
        _point(axes, table.engine, table.tuned, markersize=10.0, markeredgecolor="black")
        shown += [table.tuned, *table.others]
    set_accuracy_against_cost(
        axes,
        [*USUAL_ACCURACIES, *(100.0 * o.accuracy.value for o in shown)],
        [o.cpu.value for o in shown],
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
    if bought:
        roles.append(("bought by a budget", _spot(markersize=6.0)))
    if tuning.tests:
        roles.append(("tuned", _spot(markersize=10.0, markeredgecolor="black")))
    for family in families:
        fill = _FILLS[families.index(family) % len(_FILLS)]
        roles.append((titles[family], _spot(**_filled(fill), markersize=8.0)))
    handles += [Line2D([], [], color=_GREY, label=label, **style) for label, style in roles]
    axes.legend(handles=handles, loc="center left", bbox_to_anchor=(1.01, 0.5), frameon=False)
    return figure


def _spot(**style: Any) -> dict[str, Any]:
    return {"marker": "o", "linestyle": "", **style}


def _filled(fill: str) -> dict[str, Any]:
    return {"fillstyle": fill, "markerfacecoloralt": "white"}


def _family_titles(tuning: Tuning) -> dict[str, str]:
    """Titles of methods without their engine: one entry of the legend speaks for all engines."""
    return {
        o.method.family: o.method.title.partition(" @ ")[0] for t in tuning.tests for o in t.others
    }


def _point(axes: Axes, engine: str, outcome: MethodEvaluation, **style: Any) -> None:
    shade = engine_colour(engine)
    x, y = outcome.cpu, outcome.accuracy
    axes.errorbar(
        x.value,
        100.0 * y.value,
        xerr=reach(x, 1.0),
        yerr=reach(y, 100.0),
        fmt=engine_marker(engine),
        color=shade,
        elinewidth=0.8,
        **style,
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

    Colour tells how far they are ahead of those tuned on the engine that they are judged on:
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

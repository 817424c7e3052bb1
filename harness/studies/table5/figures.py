"""Figures of Table 5: accuracy against cost, beside the paper, by size; significant differences."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import permutations
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter

from steadyload.methods.naming import MethodKey
from steadyload.reports.charts.drawing import draw_cost_point, reach, set_cost_axis, spread_the_top
from steadyload.reports.charts.heat import heat
from steadyload.reports.interactive import CostPoint
from steadyload.reports.style import colour, engine_colour, engine_marker, face, marker
from steadyload.reports.table import compact
from steadyload.runs.comparison import Family
from steadyload.runs.evaluation import ALL
from steadyload.runs.paper import Paper
from steadyload.studies.table5.error_places import SizeBin
from steadyload.studies.table5.label_ceiling import Ceiling
from steadyload.studies.table5.summary import JudgedSet

_GREY = "#7f7f7f"
_FRONT: dict[str, Any] = {"color": "black", "linewidth": 1.0, "linestyle": "--"}
_CEILING: dict[str, Any] = {"color": _GREY, "linewidth": 0.9, "linestyle": ":"}
_PANEL = 6
"""Largest number of curves in a panel of methods that are not one tuning on several engines."""


def without_engine(method: MethodKey) -> str:
    """A method's title without its engine."""
    return method.title.replace(f" @ {method.engine}", "")


def group_title(judged: JudgedSet, group: str) -> str:
    """Title of a group, with its number of cases."""
    cases = judged.evaluation.rows[group][0].accuracy.n
    return f"{'all scenarios' if group == ALL else group}, n = {cases}"


def plot_fronts(judged: JudgedSet, ceiling: Ceiling | None) -> Figure:
    """Accuracy against CPU time, a panel a group, and the front: Fig. 3 of the paper."""
    groups = judged.groups
    across = 2 if len(groups) > 1 else 1
    down = math.ceil(len(groups) / across)
    figure = Figure(figsize=(5.4 * across, 4.2 * down))
    grid = figure.subplots(down, across, squeeze=False)
    for axes in grid.flat[len(groups) :]:
        axes.set_axis_off()
    for axes, group in zip(grid.flat, groups, strict=False):
        _front(axes, judged, group)
        if ceiling is not None and group in ceiling.by_group:
            twin = ceiling.by_group[group][-1].twin
            if twin is not None:
                axes.axhline(100 * twin.value, **_CEILING)
        axes.set_title(group_title(judged, group), fontsize=9.0)
    for axes in grid[:, 0]:
        axes.set_ylabel("accuracy (%)")
    for axes in grid[:-1].flat:
        axes.set_xlabel("")
    figure.tight_layout(rect=(0.0, 0.24 / down, 1.0, 1.0))
    _legend(figure, [m.method for m in judged.evaluation.methods], ceiling is not None)
    return figure


def _front(axes: Axes, judged: JudgedSet, group: str) -> None:
    shown = [row for row in judged.evaluation.rows[group] if row.cpu.n]
    for row in shown:
        draw_cost_point(axes, CostPoint(row.method, row.accuracy, row.cpu), markersize=7.5)
    front = [judged.evaluation.row(spec, group) for spec in judged.fronts[group]]
    axes.plot(
        [row.cpu.value for row in front],
        [100 * row.accuracy.value for row in front],
        drawstyle="steps-post",
        zorder=1,
        **_FRONT,
    )
    if shown:
        set_cost_axis(axes)
        spread_the_top(axes, min(100 * row.accuracy.low for row in shown))


def _legend(figure: Figure, methods: Sequence[MethodKey], ceiling: bool) -> None:
    """Below all panels: colours of methods, markers of engines, what lines are."""
    named = {without_engine(m): m for m in methods}
    shades = [_sample("o", colour(m), title, face(m)) for title, m in named.items()]
    figure.legend(
        handles=shades, loc="lower left", bbox_to_anchor=(0.03, 0.0), ncols=4, frameon=False,
        fontsize=8.5,
    )  # fmt: skip
    engines = dict.fromkeys(m.engine for m in methods if m.engine)
    handles = [_sample(engine_marker(e), "black", f"on {e}") for e in engines]
    handles.append(Line2D([], [], label="front", **_FRONT))
    if ceiling:
        handles.append(Line2D([], [], label="two answers to a label's question", **_CEILING))
    figure.legend(
        handles=handles, loc="lower right", bbox_to_anchor=(0.99, 0.0), ncols=2, frameon=False,
        fontsize=8.5,
    )  # fmt: skip


def _sample(sign: str, shade: str, label: str, inside: str | None = None) -> Line2D:
    line = Line2D([], [], marker=sign, color=shade, linestyle="none", markersize=7, label=label)
    line.set_markerfacecolor(inside or shade)
    return line


_LEGEND_COLUMNS = 6


def plot_beside_paper(judged: JudgedSet, paper: Paper) -> Figure:
    """Accuracies beside the paper's, a panel a group, a row a column of the paper's table."""
    groups = paper.among(judged.groups)
    of = {m.method: paper.row_of(m.method) for m in judged.evaluation.methods}
    rows = [printed for printed in paper.rows if printed in of.values()]
    figure = Figure(figsize=(2.6 * max(2, len(groups)) + 1.2, 0.52 * len(rows) + 1.7))
    panels = figure.subplots(1, len(groups), sharey=True, squeeze=False)[0]
    for axes, group in zip(panels, groups, strict=True):
        for place, printed in enumerate(reversed(rows)):
            axes.axhspan(place - 0.5, place + 0.5, color="#f2f2f2" if place % 2 else "white")
            value = 100 * printed.accuracy[group]
            axes.plot([value, value], [place - 0.42, place + 0.42], color="black", linewidth=2.2)
            ours = [m for m in judged.evaluation.rows[group] if of[m.method] == printed]
            for number, row in enumerate(ours):
                apart = 0.0 if len(ours) == 1 else 0.36 - 0.72 * number / (len(ours) - 1)
                axes.errorbar(
                    100 * row.accuracy.value,
                    place + apart,
                    xerr=reach(row.accuracy, 100.0),
                    fmt=marker(row.method),
                    color=colour(row.method),
                    markersize=5.0,
                    elinewidth=0.8,
                )
        axes.set_title(group_title(judged, group), fontsize=9.0)
        axes.set_ylim(-0.5, len(rows) - 0.5)
        axes.set_xlabel("accuracy (%)")
        axes.grid(visible=True, axis="x", linewidth=0.4, alpha=0.6)
    panels[0].set_yticks(range(len(rows)), [p.title for p in reversed(rows)])
    handles = [Line2D([], [], color="black", linewidth=2.2, label="the paper")]
    shown = [method for method, printed in of.items() if printed is not None]
    for engine in dict.fromkeys(m.engine for m in shown):
        label = f"ours, {engine}" if engine else "ours, no engine"
        handles.append(_sample(marker(MethodKey("", "", "", engine)), _GREY, label))
    for printed in rows:
        families = {m.family: m for m in shown if of[m] == printed}
        if len(families) > 1:  # one column of the paper, two of ours
            handles += [_sample("o", colour(m), without_engine(m)) for m in families.values()]
    figure.tight_layout(rect=(0.0, 0.6 / figure.get_figheight(), 1.0, 1.0))
    columns = min(len(handles), _LEGEND_COLUMNS)
    figure.legend(handles=handles, loc="lower center", ncols=columns, frameon=False)
    return figure


def plot_sizes(judged: JudgedSet) -> Figure:
    """Accuracy against the number of items: a panel a tuning, and panels of the other methods."""
    panels = _panels([m.method for m in judged.evaluation.methods])
    least = min(100 * e.value for bin_ in judged.sizes for e in bin_.accuracy.values())
    across = min(3, len(panels))
    down = math.ceil(len(panels) / across)
    figure = Figure(figsize=(3.9 * across, 3.7 * down))
    grid = figure.subplots(down, across, sharex=True, sharey=True, squeeze=False)
    for axes in grid.flat[len(panels) :]:
        axes.set_axis_off()
    for axes, (title, methods) in zip(grid.flat, panels.items(), strict=False):
        by_engine = len({m.engine for m in methods}) == len(methods) > 1
        for number, method in enumerate(methods):
            shade = engine_colour(str(method.engine)) if by_engine else colour(method)
            place = number - 0.5 * (len(methods) - 1)
            label = str(method.engine) if by_engine else method.title
            _curve(axes, judged.sizes, method, shade, place, label)
        axes.set_title(title, fontsize=9.0)
        spread_the_top(axes, least)
        axes.set_xticks(range(len(judged.sizes)), [_size_name(b) for b in judged.sizes])
        axes.set_xlabel("items in the layout", labelpad=1.0)
        axes.tick_params(labelbottom=True, labelsize=7.5)
        axes.grid(visible=True, linewidth=0.4, alpha=0.6)
        axes.legend(
            frameon=False,
            fontsize=7.5,
            loc="upper center",
            bbox_to_anchor=(0.5, -0.15),
            ncols=3 if by_engine else 2,
            columnspacing=1.0,
            handlelength=1.6,
        )
    for axes in grid[:, 0]:
        axes.set_ylabel("accuracy (%)")
    figure.tight_layout()
    return figure


def _size_name(bin_: SizeBin) -> str:
    return f"{bin_.fewest}" if bin_.fewest == bin_.most else f"{bin_.fewest}-{bin_.most}"


def _panels(methods: Sequence[MethodKey]) -> dict[str, list[MethodKey]]:
    """Methods that share a panel: one tuning on its engines, the others as they come."""
    tunings: dict[str, list[MethodKey]] = {}
    for method in methods:
        if method.engine:
            tunings.setdefault(without_engine(method), []).append(method)
    shared = {title: own for title, own in tunings.items() if len(own) > 1}
    alone = [m for m in methods if without_engine(m) not in shared]
    count = max(1, math.ceil(len(alone) / _PANEL))
    parts = [part.tolist() for part in np.array_split(np.arange(len(alone)), count)]
    named = {}
    for part in filter(None, parts):
        own = [alone[k] for k in part]
        named[f"{own[0].title} to {own[-1].title}" if len(own) > 1 else own[0].title] = own
    return named | {f"{title}, by engine": own for title, own in shared.items()}


def _curve(
    axes: Axes, sizes: Sequence[SizeBin], method: MethodKey, shade: str, place: float, label: str
) -> None:
    found = [bin_.accuracy[method.spec] for bin_ in sizes]
    reaches = [reach(e, 100.0) if 0.0 < e.value < 1.0 else [[0.0], [0.0]] for e in found]
    axes.errorbar(
        np.arange(len(sizes)) + 0.08 * place,
        [100 * e.value for e in found],
        yerr=[[reach[side][0] for reach in reaches] for side in (0, 1)],
        marker=marker(method),
        color=shade,
        markerfacecolor="white" if ":" in method.spec else shade,
        markersize=4.5,
        linewidth=1.1,
        elinewidth=0.5,
        label=label,
        clip_on=False,
    )


def plot_differences(tests: Family[MethodKey], methods: Sequence[MethodKey]) -> Figure:
    """Accuracy of the row minus that of the column, in points; pale where not significant.

    Args:
        tests: all pairs of the methods.
        methods: the most accurate first.
    """
    cells = [
        {
            "of": first.title,
            "minus": second.title,
            "difference": test.difference,
            "open": not test.significant,
        }
        for first, second in permutations(methods, 2)
        if (test := tests.of(first, second))
    ]
    label = "row minus column, where significant (points)"
    return heat(
        cells, "minus", "of", "difference", pale="open", differences=True, label=label
    ).figure


def plot_errors(judged: JudgedSet) -> Figure:
    """Shares of cases that are underestimated (left) and overestimated (right), by method.

    Bars are all cases, marks are scenarios.
    """
    rows = list(reversed(judged.evaluation.methods))
    figure = Figure(figsize=(7.6, 0.27 * len(rows) + 1.3))
    axes = figure.add_subplot()
    for place, row in enumerate(rows):
        shade = colour(row.method)
        under, over = 100 * row.under.value, 100 * row.over.value
        axes.barh(place, -under, height=0.62, color=shade, alpha=0.75)
        axes.barh(place, over, height=0.62, color=shade, alpha=0.75)
        axes.text(over + 0.8, place, f"{over:.1f}", va="center", fontsize=7)
        axes.text(-under - 0.8, place, f"{under:.1f}", va="center", ha="right", fontsize=7)
    limit = max(100 * max(r.under.value, r.over.value) for r in rows) + 8.0
    axes.axvline(0.0, color="black", linewidth=0.8)
    axes.set_xlim(-limit, max(0.45 * limit, max(100 * r.over.value for r in rows) + 8.0))
    axes.set_yticks(range(len(rows)), [r.method.title for r in rows])
    axes.set_ylim(-0.6, len(rows) - 0.4)
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{abs(value):g}"))
    axes.set_xlabel(f"underestimated | overestimated (% of {rows[0].under.n} cases)")
    return figure


def plot_margins(judged: JudgedSet) -> Figure:
    """False alarms and misses (%) by the margin of the step, a row a method."""
    methods = [m.method for m in judged.evaluation.methods]
    figure = Figure(figsize=(13.0, 0.27 * len(methods) + 1.8))
    panels = figure.subplots(1, 2, sharey=True)
    for axes, title in zip(panels, ("false alarms", "misses"), strict=True):
        alarms = title == "false alarms"
        bins = [b for b in judged.margins if (b.holding if alarms else b.failing)]
        found = [[(b.false_alarms if alarms else b.misses)[m.spec] for b in bins] for m in methods]
        values = np.array([[100 * e.value for e in row] for row in found]).reshape(-1, len(bins))
        axes.imshow(values, cmap="Reds", vmin=0.0, vmax=100.0, aspect="auto")
        for (i, j), value in np.ndenumerate(values):
            if not math.isnan(value):
                text = f"{value:.0f}" if value >= 9.95 else compact(value) if value else "0"
                shade = "white" if value > 60 else "black" if value else "#b0b0b0"
                axes.text(j, i, text, ha="center", va="center", fontsize=7, color=shade)
        counts = [b.holding if alarms else b.failing for b in bins]
        names = [f"{_margin_name(b.low, b.high)}\nn {n}" for b, n in zip(bins, counts, strict=True)]
        axes.set_xticks(range(len(bins)), names, fontsize=7.5)
        what = "steps that hold, called failing" if alarms else "failing steps, called holding"
        axes.set_title(f"{title}: {what} (%)", fontsize=9.0)
        axes.set_xlabel("margin of balance at the step (cm)")
        axes.spines[:].set_visible(False)
        axes.tick_params(length=0)
    panels[0].set_yticks(range(len(methods)), [m.title for m in methods])
    figure.tight_layout()
    return figure


def _margin_name(low: float, high: float) -> str:
    if math.isinf(low):
        return f"< {high:g}"
    return f"≥ {low:g}" if math.isinf(high) else f"{low:g}…{high:g}"

"""Figures of searches: their fitness by generation, and their fronts."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from steadyload.reports.charts.drawing import set_cost_axis, spread_the_top
from steadyload.reports.style import algorithm_colour
from steadyload.studies.tuning.summary import JudgedGenotype, SearchRow

_USUAL_COSTS = (0.3, 100.0)
USUAL_ACCURACIES = (82.5, 99.2)
"""Range of accuracies [%] in figures that compare engines."""

_CHEAP = 1.0
"""Fronts are shown whole from this cost on [ms]; cheaper points may be too low to be shown."""

_HANDLE, _LETTER = 0.5, 0.07
"""Width of an entry of a legend: without its text, and of a letter [inch]."""

_SPACE_LINES: tuple[Literal["-", "--", ":", "-."], ...] = ("-", "--", ":", "-.")


def front(judged: Iterable[JudgedGenotype]) -> list[JudgedGenotype]:
    """The points of one or several fronts than which no cheaper one is as accurate.

    Returns:
        The points by rising cost, and so by rising accuracy.
    """
    found: list[JudgedGenotype] = []
    for point in sorted(judged, key=lambda p: (p.cost, -p.accuracy)):
        if point.on_front and (not found or point.accuracy > found[-1].accuracy):
            found.append(point)
    return found


def draw_front(axes: Axes, judged: Iterable[JudgedGenotype], colour: str, **style: float) -> None:
    """Draw the front as steps: at a cost it has the accuracy of the next cheaper point."""
    points = front(judged)
    axes.step(
        [p.cost for p in points],
        [100.0 * p.accuracy for p in points],
        where="post",
        color=colour,
        **style,  # type: ignore[arg-type]
    )


def set_accuracy_against_cost(
    axes: Axes, accuracies: Sequence[float], costs: Sequence[float]
) -> None:
    """Set axes of accuracy and cost.

    Args:
        axes: to be set.
        accuracies: visible values in per cent, one at least; fronts may begin below them.
        costs: visible values in ms.
    """
    set_cost_axis(axes)
    axes.set_xlim(
        min([*(0.8 * c for c in costs), _USUAL_COSTS[0]]),
        max([*(1.25 * c for c in costs), _USUAL_COSTS[1]]),
    )
    spread_the_top(axes, min(accuracies))
    axes.set_ylabel("accuracy (%)")


def plot_histories(searches: Sequence[SearchRow]) -> Figure:
    """Best (thick) and median (thin) fitness over genotypes judged, a panel an engine."""
    engines = list(dict.fromkeys(s.engine for s in searches))
    across = min(2, len(engines))
    down = math.ceil(len(engines) / across)
    figure = Figure(figsize=(0.8 + 4.4 * across, 1.0 + 2.7 * down))
    grid = figure.subplots(down, across, squeeze=False)
    spaces = list(dict.fromkeys(s.space for s in searches))
    for axes, engine in zip(grid.flat, engines, strict=False):
        mine = [s for s in searches if s.engine == engine]
        for search in mine:
            line = _SPACE_LINES[spaces.index(search.space) % len(_SPACE_LINES)]
            shade = algorithm_colour(search.algorithm)
            judged = [g.judged for g in search.history]
            best = [g.best for g in search.history]
            point = "o" if len(best) == 1 else None  # a line needs two points
            axes.plot(judged, best, line, color=shade, linewidth=1.4, marker=point)
            medians = [g.median for g in search.history]
            axes.plot(judged, medians, line, color=shade, linewidth=0.7, alpha=0.5)
        _set_fitness(axes, mine)
        axes.set_title(engine, fontsize=9.0)
    for axes in grid.flat[len(engines) :]:
        axes.set_axis_off()
    for axes in grid[:, 0]:
        axes.set_ylabel("fitness")
    _legend_below(figure, searches, spaces)
    return figure


def _set_fitness(axes: Axes, searches: Sequence[SearchRow]) -> None:
    """Set limits that show all best values and three quarters of the medians; others are lower."""
    best = [g.best for s in searches for g in s.history if math.isfinite(g.best)]
    medians = [g.median for s in searches for g in s.history if math.isfinite(g.median)]
    if best:
        low = min(best)
        if medians:
            low = min(low, float(np.quantile(medians, 0.25)))
        span = max(max(best) - low, 1e-3)
        axes.set_ylim(low - 0.05 * span, max(best) + 0.05 * span)
    axes.set_xlim(left=0.0)
    axes.set_xlabel("genotypes judged")
    axes.grid(visible=True, linewidth=0.4, alpha=0.6)


def _legend_below(figure: Figure, searches: Sequence[SearchRow], spaces: Sequence[str]) -> None:
    kinds = dict.fromkeys((s.algorithm, s.space) for s in searches)
    handles = [
        Line2D(
            [],
            [],
            color=algorithm_colour(algorithm),
            linestyle=_SPACE_LINES[spaces.index(space) % len(_SPACE_LINES)],
            label=f"{algorithm}, {space}" if len(spaces) > 1 else algorithm,
        )
        for algorithm, space in kinds
    ]
    handles += [
        Line2D([], [], color="#7f7f7f", linewidth=1.4, label="best so far"),
        Line2D([], [], color="#7f7f7f", linewidth=0.7, label="median"),
    ]
    _finish_below(figure, handles)


def _finish_below(figure: Figure, handles: list[Line2D]) -> None:
    width, height = figure.get_size_inches()
    needed = sum(_HANDLE + _LETTER * len(str(handle.get_label())) for handle in handles)
    across = math.ceil(len(handles) / math.ceil(needed / width))
    figure.legend(handles=handles, loc="lower center", ncols=across, frameon=False)
    room = 0.1 + 0.22 * math.ceil(len(handles) / across)
    figure.tight_layout(rect=(0.0, room / height, 1.0, 1.0))


def plot_algorithms(groups: Mapping[str, Sequence[SearchRow]]) -> Figure:
    """Comparison of algorithms: hypervolume over genotypes judged, and the fronts.

    Args:
        groups: by title, the searches that can be compared; a row of panels each.
    """
    figure = Figure(figsize=(9.6, 0.6 + 2.7 * len(groups)))
    grid = figure.subplots(len(groups), 2, squeeze=False)
    for (volumes, fronts), (title, searches) in zip(grid, groups.items(), strict=True):
        for search in searches:
            shade = algorithm_colour(search.algorithm)
            volumes.plot(
                [g.judged for g in search.history],
                [g.hypervolume for g in search.history],
                color=shade,
                linewidth=1.2,
            )
            draw_front(fronts, search.judged, shade, linewidth=1.2, alpha=0.85)
        points = [p for s in searches for p in front(s.judged)]
        whole = [100.0 * p.accuracy for p in points if p.cost >= _CHEAP]
        set_accuracy_against_cost(fronts, whole or USUAL_ACCURACIES, [])
        volumes.set_title(f"{title}: hypervolume", fontsize=9.0)
        fronts.set_title(f"{title}: fronts", fontsize=9.0)
        volumes.set_xlabel("genotypes judged")
        volumes.set_ylabel("hypervolume")
        volumes.set_xlim(left=0.0)
        volumes.grid(visible=True, linewidth=0.4, alpha=0.6)
        fronts.set_xlabel("modelled CPU time a layout (ms)")
    algorithms = dict.fromkeys(s.algorithm for searches in groups.values() for s in searches)
    handles = [Line2D([], [], color=algorithm_colour(a), label=a) for a in algorithms]
    _finish_below(figure, handles)
    return figure

"""Figures of learned methods: size of the training set, remedies."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter

from steadyload.reports.reliability_figures import LINES, MARKS, draw_curve, reach
from steadyload.runs.evaluation import ALL
from steadyload.studies.learned.summary import SizeCurve, TrainedRow

_ROOM = 1.2
"""Smallest factor between ticks of a log axis that do not overlap."""


def plot_size(curves: Sequence[SizeCurve]) -> Figure:
    """Accuracy against cases and against item lists, on log axes."""
    figure = Figure(figsize=(9.0, 3.8))
    panels: tuple[tuple[str, Callable[[TrainedRow], int]], ...] = (
        ("cases learnt from", lambda row: row.cases),
        ("item lists learnt from", lambda row: row.item_lists),
    )
    row = figure.subplots(1, len(panels), sharey=True)
    for axes, (label, of) in zip(row, panels, strict=True):
        for number, curve in enumerate(curves):
            points = sorted(curve.rows, key=lambda row: (of(row), row.cases))
            draw_curve(axes, number, curve.title, [of(p) for p in points],
                       [p.accuracy[ALL] for p in points])  # fmt: skip
        axes.set_xscale("log")
        places = _apart({of(p) for curve in curves for p in curve.rows})
        axes.set_xticks(places, [str(place) for place in places], rotation=90)
        axes.xaxis.set_minor_formatter(NullFormatter())
        axes.minorticks_off()
        axes.set_xlabel(label)
        axes.grid(visible=True, linewidth=0.4, alpha=0.6)
    row[0].set_ylabel("accuracy (%)")
    row[-1].legend(loc="center left", bbox_to_anchor=(1.01, 0.5), frameon=False)
    return figure


def plot_remedies(rows: Sequence[TrainedRow]) -> Figure:
    """Accuracy by scenario of every training, with its seeds as dots."""
    scenarios = [group for group in rows[0].accuracy if group != ALL]
    figure = Figure(figsize=(2.2 + 2.2 * len(scenarios), 0.9 + 0.32 * len(rows)))
    panels = figure.subplots(1, len(scenarios), sharey=True, squeeze=False)[0]
    for axes, scenario in zip(panels, scenarios, strict=True):
        for level, row in enumerate(rows):
            found, shade = row.accuracy[scenario], LINES[level % len(LINES)]
            axes.errorbar(
                100 * found.value, -level, xerr=reach(found), fmt=MARKS[level % len(MARKS)],
                color=shade, markersize=6.0, elinewidth=1.0,
            )  # fmt: skip
            seeds = [100 * value for value in row.seeds[scenario]]
            axes.plot(seeds, [-level - 0.25] * len(seeds), ".", color=shade, markersize=4.0)
        axes.set_title(scenario, fontsize=9.0)
        axes.set_xlabel("accuracy (%)")
        axes.grid(visible=True, linewidth=0.4, alpha=0.6)
    panels[0].set_yticks([-k for k in range(len(rows))], [row.title for row in rows])
    return figure


def _apart(places: Iterable[int]) -> list[int]:
    """Ticks that have room beside each other on a log axis, from the largest down."""
    kept: list[int] = []
    for place in sorted(places, reverse=True):
        if not kept or place * _ROOM < kept[-1]:
            kept.append(place)
    return kept

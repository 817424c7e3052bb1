"""Pictures of learned judges: size of the training set, remedies, reliability, risk."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, NullFormatter

from reports.learned_records import ALL, JudgeCalibration, Reliability, SizeCurve, TrainedRow
from reports.records import Estimate

_LINES = ("#08519c", "#e6550d", "#2ca02c", "#9467bd", "#7f7f7f", "#8c6d31")
_MARKS = ("o", "s", "^", "D", "v", "P")
_ROOM = 1.2
"""Ticks of a log axis by less than this factor apart run into each other."""

_PLAIN = FuncFormatter(lambda value, _: f"{value:g}")


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
            _curve(axes, number, curve.title, [of(p) for p in points],
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


def plot_remedies(rows: Sequence[TrainedRow], scenarios: Sequence[str]) -> Figure:
    """Accuracy by scenario of every training, with its seeds as dots."""
    figure = Figure(figsize=(2.2 + 2.2 * len(scenarios), 0.9 + 0.32 * len(rows)))
    panels = figure.subplots(1, len(scenarios), sharey=True, squeeze=False)[0]
    for axes, scenario in zip(panels, scenarios, strict=True):
        for level, row in enumerate(rows):
            found, shade = row.accuracy[scenario], _LINES[level % len(_LINES)]
            axes.errorbar(
                100 * found.value, -level, xerr=_reach(found), fmt=_MARKS[level % len(_MARKS)],
                color=shade, markersize=6.0, elinewidth=1.0,
            )  # fmt: skip
            seeds = [100 * value for value in row.seeds[scenario]]
            axes.plot(seeds, [-level - 0.25] * len(seeds), ".", color=shade, markersize=4.0)
        axes.set_title(scenario, fontsize=9.0)
        axes.set_xlabel("accuracy (%)")
        axes.grid(visible=True, linewidth=0.4, alpha=0.6)
    panels[0].set_yticks([-k for k in range(len(rows))], [row.title for row in rows])
    return figure


def plot_reliability(judges: Sequence[JudgeCalibration]) -> Figure:
    """How often it happened against the probability that was given; a panel for each kind."""
    figure = Figure(figsize=(9.0, 4.2))
    kinds: tuple[tuple[str, Callable[[JudgeCalibration], Reliability]], ...] = (
        ("a step is unstable", lambda judge: judge.steps),
        ("a score is right", lambda judge: judge.layouts),
    )
    panels = figure.subplots(1, len(kinds), sharey=True)
    for axes, (title, of) in zip(panels, kinds, strict=True):
        axes.plot([0, 100], [0, 100], color="#7f7f7f", linewidth=0.8, linestyle=":")
        for number, judge in enumerate(judges):
            bins = of(judge).bins
            _curve(axes, number, judge.title, [100 * b.mean for b in bins],
                   [b.happened for b in bins])  # fmt: skip
        axes.set_title(title, fontsize=9.0)
        axes.set_xlabel("probability given (%)")
        axes.grid(visible=True, linewidth=0.4, alpha=0.6)
    panels[0].set_ylabel("happened (%)")
    panels[-1].legend(loc="center left", bbox_to_anchor=(1.01, 0.5), frameon=False)
    return figure


def plot_risk(judges: Sequence[JudgeCalibration]) -> Figure:
    """Share of wrong scores against the share of cases that are judged."""
    figure = Figure(figsize=(6.4, 3.6))
    axes = figure.add_subplot()
    for number, judge in enumerate(judges):
        curve = judge.abstention.curve
        axes.plot(
            [100 * covered for covered, _ in curve],
            [100 * wrong for _, wrong in curve],
            marker=_MARKS[number % len(_MARKS)],
            color=_LINES[number % len(_LINES)],
            markersize=3.5,
            linewidth=1.0,
            label=judge.title,
        )
    axes.set_xlabel("cases judged, the surest first (%)")
    axes.set_ylabel("of these wrong (%)")
    axes.set_ylim(bottom=0.0)
    axes.yaxis.set_major_formatter(_PLAIN)
    axes.grid(visible=True, linewidth=0.4, alpha=0.6)
    axes.legend(loc="center left", bbox_to_anchor=(1.01, 0.5), frameon=False)
    return figure


def _curve(
    axes: Axes, number: int, title: str, places: Sequence[float], found: Sequence[Estimate]
) -> None:
    axes.errorbar(
        places,
        [100 * e.value for e in found],
        yerr=[[_reach(e)[side][0] for e in found] for side in (0, 1)],
        marker=_MARKS[number % len(_MARKS)],
        color=_LINES[number % len(_LINES)],
        markersize=5.0,
        linewidth=1.0,
        capsize=2,
        label=title,
    )


def _apart(places: Iterable[int]) -> list[int]:
    """Those that have room beside each other on a log axis, from the greatest down."""
    kept: list[int] = []
    for place in sorted(places, reverse=True):
        if not kept or place * _ROOM < kept[-1]:
            kept.append(place)
    return kept


def _reach(estimate: Estimate) -> list[list[float]]:
    """How far the interval reaches to both sides, in per cent."""
    return [
        [100 * max(0.0, estimate.value - estimate.low)],
        [100 * max(0.0, estimate.high - estimate.value)],
    ]

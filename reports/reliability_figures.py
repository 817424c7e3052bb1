"""Figures of calibration and abstention."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from steadyload.reports.charts.drawing import PLAIN_TICKS
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.reliability import Abstention, Reliability

LINES = ("#08519c", "#e6550d", "#2ca02c", "#9467bd", "#7f7f7f", "#8c6d31")
MARKS = ("o", "s", "^", "D", "v", "P")


def plot_reliability(kinds: Mapping[str, Mapping[str, Reliability]]) -> Figure:
    """Reliability diagram: observed frequency against predicted probability.

    Args:
        kinds: a panel a kind of probability, in it a curve a method.
    """
    figure = Figure(figsize=(9.0, 4.2))
    panels = figure.subplots(1, len(kinds), sharey=True, squeeze=False)[0]
    for axes, (title, judges) in zip(panels, kinds.items(), strict=True):
        axes.plot([0, 100], [0, 100], color="#7f7f7f", linewidth=0.8, linestyle=":")
        for number, (judge, found) in enumerate(judges.items()):
            draw_curve(axes, number, judge, [100 * b.mean for b in found.bins],
                       [b.happened for b in found.bins])  # fmt: skip
        axes.set_title(title, fontsize=9.0)
        axes.set_xlabel("probability given (%)")
        axes.grid(visible=True, linewidth=0.4, alpha=0.6)
    panels[0].set_ylabel("happened (%)")
    panels[-1].legend(loc="center left", bbox_to_anchor=(1.01, 0.5), frameon=False)
    return figure


def plot_risk(judges: Mapping[str, Abstention]) -> Figure:
    """Share of wrong scores against the share of cases that are judged."""
    figure = Figure(figsize=(6.4, 3.6))
    axes = figure.add_subplot()
    for number, (title, found) in enumerate(judges.items()):
        axes.plot(
            [100 * covered for covered, _ in found.curve],
            [100 * wrong for _, wrong in found.curve],
            marker=MARKS[number % len(MARKS)],
            color=LINES[number % len(LINES)],
            markersize=3.5,
            linewidth=1.0,
            label=title,
        )
    axes.set_xlabel("cases judged, the surest first (%)")
    axes.set_ylabel("of these wrong (%)")
    axes.set_ylim(bottom=0.0)
    axes.yaxis.set_major_formatter(PLAIN_TICKS)
    axes.grid(visible=True, linewidth=0.4, alpha=0.6)
    axes.legend(loc="center left", bbox_to_anchor=(1.01, 0.5), frameon=False)
    return figure


def draw_curve(
    axes: Axes, number: int, title: str, places: Sequence[float], found: Sequence[Estimate]
) -> None:
    """Shares in per cent with their intervals against places, in the colour of a number."""
    axes.errorbar(
        places,
        [100 * e.value for e in found],
        yerr=[[reach(e)[side][0] for e in found] for side in (0, 1)],
        marker=MARKS[number % len(MARKS)],
        color=LINES[number % len(LINES)],
        markersize=5.0,
        linewidth=1.0,
        capsize=2,
        label=title,
    )


def reach(estimate: Estimate) -> list[list[float]]:
    """Half-widths of the interval to both sides, in per cent."""
    return [
        [100 * max(0.0, estimate.value - estimate.low)],
        [100 * max(0.0, estimate.high - estimate.value)],
    ]

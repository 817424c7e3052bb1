"""Figures of a labelled set: item counts and scores of its layouts, agreement of labels."""

from __future__ import annotations

from collections.abc import Mapping

from matplotlib.figure import Figure

from steadyload.reports.charts.columns import columns
from steadyload.studies.benchmark.summary import MethodAgreement

_INK = "#08519c"
_REASON_COLOURS = {
    "numerical": "#4292c6",
    "model": "#e6550d",
    "limits": "#74a33c",
    "loading": "#756bb1",
    "engine": "#333333",
}


def plot_item_counts(counts: Mapping[int, int]) -> Figure:
    """Layouts by number of items."""
    rows = [{"items": items, "layouts": layouts} for items, layouts in counts.items()]
    return columns(
        rows, {"layouts": "layouts"}, title="items", x_label="items", y_label="layouts",
        size=(6.0, 2.8),
    ).figure  # fmt: skip


def plot_scores(scores: Mapping[str, tuple[int, ...]]) -> Figure:
    """Share of cases by loading stability, a bar a scenario; stable layouts have their own bin."""
    bins = len(next(iter(scores.values()))) - 1
    titles = [*(f"{k / bins:.1f}-{(k + 1) / bins:.1f}" for k in range(bins)), "stable"]
    rows = [
        {
            "title": title,
            **{name: 100.0 * found[k] / max(1, sum(found)) for name, found in scores.items()},
        }
        for k, title in enumerate(titles)
    ]
    return columns(
        rows,
        {name: name for name in scores},
        last_apart=True,
        x_label="share of items loaded before the first failure",
        y_label="cases (%)",
    ).figure


def plot_agreement(judges: tuple[MethodAgreement, ...]) -> Figure:
    """Agreement of every further method with the labels, coloured by the reason of doubt."""
    figure = Figure(figsize=(7.0, 0.32 * len(judges) + 0.9), layout="constrained")
    axes = figure.subplots()
    for place, judge in enumerate(judges):
        value, low, high = (
            100.0 * v for v in (judge.pooled.value, judge.pooled.low, judge.pooled.high)
        )
        axes.errorbar(
            value, place, xerr=([value - low], [high - value]), fmt="o", capsize=2,
            color=_REASON_COLOURS.get(judge.reason, _INK),
        )  # fmt: skip
    axes.set_yticks(range(len(judges)), [f"{j.judge} ({j.reason})" for j in judges], fontsize=7)
    axes.invert_yaxis()
    axes.grid(axis="x", color="#dddddd", lw=0.6)
    axes.set_axisbelow(True)
    axes.set_xlabel("equal failing step (%)")
    return figure

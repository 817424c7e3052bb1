"""Figures of a labelled set: item counts and scores of its layouts, agreement of labels."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from steadyload.studies.benchmark.summary import MethodAgreement

_INK = "#08519c"
_SCENARIO_COLOURS = ("#9ecae1", "#4292c6", "#08519c", "#7f7f7f")
_REASON_COLOURS = {
    "numerical": "#4292c6",
    "model": "#e6550d",
    "limits": "#74a33c",
    "loading": "#756bb1",
    "engine": "#333333",
}


def plot_item_counts(counts: Mapping[int, int]) -> Figure:
    """Layouts by number of items."""
    figure = Figure(figsize=(6.0, 2.8), layout="constrained")
    axes = figure.subplots()
    axes.bar(list(counts), list(counts.values()), color=_INK)
    axes.set_xlabel("items")
    axes.set_ylabel("layouts")
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    return figure


def plot_scores(scores: Mapping[str, tuple[int, ...]]) -> Figure:
    """Share of cases by loading stability, a bar a scenario; stable layouts have their own bin."""
    figure = Figure(figsize=(7.0, 3.2), layout="constrained")
    axes = figure.subplots()
    bins = len(next(iter(scores.values()))) - 1
    width = 0.8 / len(scores)
    places = np.arange(bins + 1, dtype=float)
    places[-1] += 0.5
    for index, (scenario, counts) in enumerate(scores.items()):
        shares = 100.0 * np.array(counts) / max(1, sum(counts))
        shift = (index - 0.5 * (len(scores) - 1)) * width
        ink = _SCENARIO_COLOURS[index % len(_SCENARIO_COLOURS)]
        axes.bar(places + shift, shares, width, color=ink, label=scenario)
    labels = [f"{k / bins:.1f}-{(k + 1) / bins:.1f}" for k in range(bins)]
    axes.set_xticks(places, [*labels, "stable"], fontsize=7)
    axes.set_xlabel("share of items loaded before the first failure")
    axes.set_ylabel("cases (%)")
    axes.legend(frameon=False)
    return figure


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

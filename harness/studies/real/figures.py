"""Figures of accuracy and cost by number of boxes."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from steadyload.layouts.model.question import Question
from steadyload.reports.charts.drawing import PLAIN_TICKS, reach
from steadyload.reports.style import colour, face, marker
from steadyload.studies.real.summary import CONSTANT, Growth, SizeGroup

_LINES = ("-", "--", ":", "-.")
"""Lines of methods with one colour and marker, in turn."""


_APART = 1.005
"""Factor in x between one method and the next, so that their intervals do not hide each other."""


def plot_accuracy(groups: Sequence[SizeGroup]) -> Figure:
    """Accuracy against boxes, a panel a question, of the methods that are asked it."""
    figure = Figure(figsize=(8.6, 4.6))
    panels = figure.subplots(1, 2, sharey=True)
    styles = _styles(groups)
    shown: dict[str, Any] = {}
    for question, axes in zip(Question, panels, strict=True):
        for number, result in enumerate(groups[0].methods):
            if result.asked not in (None, question):
                continue
            spec = result.method.spec
            found = [(g.middle, g.of(spec).accuracy[question].overall) for g in groups]
            found = [(boxes, share) for boxes, share in found if share.n]
            if found:
                drawn = axes.errorbar(
                    [boxes * _APART**number for boxes, _ in found],
                    [100.0 * share.value for _, share in found],
                    yerr=np.hstack([reach(share, 100.0) for _, share in found]),
                    **styles[spec],
                )
                shown.setdefault(result.method.title, drawn)
        axes.set_title(f"label: {question}", fontsize=9)
        _boxes_axis(axes, groups)
    panels[0].set_ylabel("accuracy (% of cases with the label's failing step)")
    figure.legend(
        list(shown.values()), list(shown), loc="center left", bbox_to_anchor=(0.92, 0.5),
        frameon=False,
    )  # fmt: skip
    return figure


def plot_cost(groups: Sequence[SizeGroup], growth: Mapping[str, Growth]) -> Figure:
    """Median CPU time against boxes, both on log axes, with the exponents in the legend."""
    figure = Figure(figsize=(7.6, 4.8))
    axes = figure.add_subplot()
    styles = _styles(groups)
    for result in groups[0].methods:
        spec = result.method.spec
        found = [(g.middle, cost.median) for g in groups if (cost := g.of(spec).cost)]
        if found:
            power = growth[spec].everything.value
            label = result.method.title + (f": n^{power:.2f}" if math.isfinite(power) else "")
            style = {k: v for k, v in styles[spec].items() if k not in ("elinewidth", "capsize")}
            axes.plot(*zip(*found, strict=True), **style, label=label)
    _boxes_axis(axes, groups)
    axes.set_yscale("log")
    axes.yaxis.set_major_formatter(PLAIN_TICKS)
    axes.set_ylabel("CPU time a layout (ms), median")
    axes.legend(loc="center left", bbox_to_anchor=(1.01, 0.5), frameon=False)
    return figure


def _boxes_axis(axes: Axes, groups: Sequence[SizeGroup]) -> None:
    """Let x show numbers of boxes, logarithmically, with a tick a group."""
    axes.set_xscale("log")
    axes.set_xticks([g.middle for g in groups], [f"{g.middle:g}" for g in groups])
    axes.minorticks_off()
    axes.set_xlabel("boxes, median of the bin")
    axes.grid(visible=True, linewidth=0.4, alpha=0.6)


def _styles(groups: Sequence[SizeGroup]) -> dict[str, dict[str, Any]]:
    """Colour, marker and line by spec; methods with equal markers have lines of their own."""
    seen: Counter[tuple[str, str]] = Counter()
    found = {}
    for result in groups[0].methods:
        key = result.method
        alike = (colour(key), marker(key))
        found[key.spec] = {
            "color": "#444444" if key is CONSTANT else colour(key),
            "marker": "" if key is CONSTANT else marker(key),
            "markerfacecolor": face(key),
            "markersize": 5,
            "linestyle": ":" if key is CONSTANT else _LINES[seen[alike] % len(_LINES)],
            "linewidth": 1.1,
            "elinewidth": 0.6,
            "capsize": 2,
        }
        seen[alike] += 1
    return found

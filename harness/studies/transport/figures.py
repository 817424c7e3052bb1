"""Figures of the study of transport: limits around loads, and how far they are from others."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from steadyload.methods.naming import MethodKey
from steadyload.reports.style import engine_colour, marker
from steadyload.studies.transport.study import RUBBING, WHOLE
from steadyload.studies.transport.summary import Distance, Drawn
from steadyload.transport.limits import EXACT

_NEAR = 0.25
"""Differences that are drawn; beyond it curves only go on to 0 or 100 % [g]."""


def plot_limits(drawn: Sequence[Drawn]) -> Figure:
    """Limits of loads by direction of the force, a polar chart a load."""
    figure = Figure(figsize=(3.1 * len(drawn), 3.7))
    charts = figure.subplots(1, len(drawn), subplot_kw={"projection": "polar"}, squeeze=False)[0]
    for axes, one in zip(charts, drawn, strict=True):
        around = np.radians([*one.directions, one.directions[0]])
        for method, limits in one.limits.items():
            axes.plot(around, [*limits, limits[0]], label=method.title, **_style(method))
        axes.set_title(f"{one.load.name}\n{len(one.load.layout)} boxes", fontsize=8)
        axes.set_rlim(0.0, 0.55)
        axes.set_rticks([0.1, 0.2, 0.3, 0.4, 0.5])
        axes.tick_params(labelsize=7)
    handles, labels = charts[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="lower center", ncols=len(labels), frameon=False, fontsize=8)
    figure.tight_layout(rect=(0, 0.06, 1, 1))
    return figure


def plot_differences(found: Sequence[Distance]) -> Figure:
    """Share of limits whose difference is at most that on x, a curve a method."""
    figure = Figure(figsize=(7.2, 3.8))
    axes = figure.add_subplot()
    for one in found:
        style = {**_style(one.method), "marker": ""}
        shares = 100.0 * np.arange(1, len(one.differences) + 1) / len(one.differences)
        axes.step(one.differences, shares, where="post", label=one.method.title, **style)
    axes.set_xlim(-_NEAR, _NEAR)
    axes.set_ylim(0.0, 100.0)
    axes.axvline(0.0, color="#999999", linewidth=0.6)
    axes.set_xlabel("limit less the reference's (g); right of 0 more is promised than held")
    axes.set_ylabel("limits (%)")
    axes.legend(loc="center left", bbox_to_anchor=(1.01, 0.5), frameon=False)
    figure.tight_layout()
    return figure


_LINES = {EXACT: ("#000000", "--"), RUBBING: ("#000000", "-."), WHOLE: ("#7f7f7f", ":")}


def _style(method: MethodKey) -> dict[str, Any]:
    shade, line = _LINES.get(method.spec, (engine_colour(method.engine or ""), "-"))
    return {
        "color": shade,
        "marker": marker(method),
        "markersize": 3.5,
        "linewidth": 1.2,
        "linestyle": line,
    }

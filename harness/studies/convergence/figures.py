"""Figures of the convergence of the reference's labels."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter

from steadyload.reports.charts.drawing import PLAIN_TICKS, reach
from steadyload.reports.style import engine_colour
from steadyload.studies.convergence.summary import ConvergenceRow

_COLUMNS = 4
_INK = "#08519c"
_TICKS = (5, 10, 20, 50, 100, 200, 500, 1000)


def plot_sweeps(rows: Sequence[ConvergenceRow]) -> Figure:
    """Share of changed labels against each parameter that was swept, one panel a parameter."""
    groups: dict[str, list[ConvergenceRow]] = {}
    for row in rows:
        if row.value is not None:
            groups.setdefault(row.group, []).append(row)
    groups = {group: members for group, members in groups.items() if len(members) > 1}
    lines = math.ceil(len(groups) / _COLUMNS)
    figure = Figure(figsize=(2.6 * _COLUMNS, 2.3 * lines), layout="constrained")
    panels = figure.subplots(lines, _COLUMNS, sharey=True, squeeze=False).ravel()
    for axes, (group, members) in zip(panels, groups.items(), strict=False):
        _sweep(axes, group, sorted(members, key=lambda r: r.value or 0.0))
    for axes in panels[len(groups) :]:
        axes.set_axis_off()
    for axes in panels[::_COLUMNS]:
        axes.set_ylabel("changed labels (%)")
    highest = max((m.changed.high for members in groups.values() for m in members), default=0.01)
    panels[0].set_ylim(-0.5, 105.0 * highest)
    return figure


def _sweep(axes: Axes, group: str, members: Sequence[ConvergenceRow]) -> None:
    values = [m.value or 0.0 for m in members]
    shares = [100.0 * m.changed.value for m in members]
    ends = np.hstack([reach(m.changed, 100.0) for m in members])
    axes.errorbar(values, shares, ends, fmt="o-", color=_INK, ms=4, lw=1, capsize=2)
    if max(values) > 3.5 * min(values):
        axes.set_xscale("log")
        axes.xaxis.set_major_formatter(PLAIN_TICKS)
        axes.xaxis.set_minor_formatter(NullFormatter())
    axes.set_xlabel(group)


def plot_engines_against_reference(rows: Sequence[ConvergenceRow]) -> Figure:
    """Agreement with the reference against CPU time: a line an engine, a point a frequency."""
    figure = Figure(figsize=(6.4, 4.2), layout="constrained")
    axes = figure.subplots()
    for engine in dict.fromkeys(row.group for row in rows):
        own = [row for row in rows if row.group == engine]
        times = [row.cpu.value for row in own]
        shares = [100.0 * (1.0 - row.changed.value) for row in own]
        # Agreement is one minus the share of changes, so the ends of the interval change places.
        ends = np.hstack([reach(row.changed, 100.0)[::-1] for row in own])
        ink = engine_colour(engine)
        axes.errorbar(times, shares, ends, fmt="o-", color=ink, capsize=2, label=engine)
        for row, x, y in zip(own, times, shares, strict=True):
            axes.annotate(f" {row.value:g}", (x, y), fontsize=7, va="top", color=ink)
    axes.set_xscale("log")
    low, high = min(r.cpu.value for r in rows), max(r.cpu.value for r in rows)
    axes.set_xticks([t for t in _TICKS if 0.7 * low <= t <= 1.4 * high])
    axes.xaxis.set_major_formatter(PLAIN_TICKS)
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.set_xlabel("CPU time a layout (ms); numbers: substeps a second")
    axes.set_ylabel("equal failing step (%)")
    axes.legend(frameon=False)
    return figure

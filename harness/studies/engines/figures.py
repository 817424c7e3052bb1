"""Figures of the engine study: sources of differences, growth with items, agreement."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from steadyload.reports.charts.drawing import COST_LABEL, engine_legend, finish_growth, reach
from steadyload.reports.style import engine_colour, engine_marker
from steadyload.studies.engines.sources import SourceTable
from steadyload.studies.engines.speed import SpeedCurve
from steadyload.studies.engines.study import EngineAgreement


def plot_growth(curves: Sequence[SpeedCurve]) -> Figure:
    """CPU time against the number of items, both on log axes; solid all items, dashed local."""
    figure = Figure(figsize=(7.6, 4.8))
    axes = figure.add_subplot()
    for curve in curves:
        label = f"{curve.engine}, {curve.scene}, {curve.scope}"
        if math.isfinite(curve.exponent):
            label += f": J^{curve.exponent:.2f}"
        axes.plot(
            [p.item_count for p in curve.points],
            [p.total for p in curve.points],
            linestyle={"all": "-", "local": "--"}[curve.scope],
            linewidth=1.2 if curve.scene == "pile" else 0.7,
            marker=engine_marker(curve.engine),
            markersize=6 if curve.scene == "pile" else 3,
            color=engine_colour(curve.engine),
            label=label,
        )
    finish_growth(axes, {p.item_count for c in curves for p in c.points}, COST_LABEL)
    return figure


def plot_convergence(rows: Sequence[EngineAgreement]) -> Figure:
    """Agreement with every other engine against frequency, a panel an engine."""
    engines = list(dict.fromkeys(engine for pair in rows[0].agreement for engine in pair))
    across = min(3, len(engines))
    down = math.ceil(len(engines) / across)
    figure = Figure(figsize=(7.6, 0.8 + 2.1 * down))
    grid = figure.subplots(down, across, squeeze=False, sharex=True, sharey=True)
    spread = np.geomspace(0.94, 1.06, len(engines))
    for axes, engine in zip(grid.flat, engines, strict=False):
        for pair in rows[0].agreement:
            if engine not in pair:
                continue
            (other,) = {*pair} - {engine}
            axes.errorbar(
                [row.frequency * spread[engines.index(other)] for row in rows],
                [100 * row.agreement[pair].value for row in rows],
                yerr=np.hstack([reach(row.agreement[pair], 100.0) for row in rows]),
                marker=engine_marker(other),
                color=engine_colour(other),
                markersize=4,
                elinewidth=0.6,
                capsize=1.5,
                linewidth=1.0,
            )
        axes.set_title(engine)
        axes.set_xscale("log")
        axes.set_xticks([row.frequency for row in rows], [str(row.frequency) for row in rows])
        axes.minorticks_off()
        axes.grid(visible=True, linewidth=0.4, alpha=0.6)
    for axes in grid.flat[len(engines) :]:
        axes.remove()
    for axes in grid[-1]:
        axes.set_xlabel("substeps a second (Hz)")
    for axes in grid[:, 0]:
        axes.set_ylabel("same failing step (%)")
    engine_legend(figure, {engine: engine for engine in engines})
    figure.tight_layout(rect=(0.0, 0.3 / figure.get_figheight(), 1.0, 1.0))
    return figure


_ALWAYS, _BY_CASE = "#08519c", "#9ecae1"


def plot_sources(tables: Sequence[SourceTable]) -> Figure:
    """Shares of every source in the differences between verdicts, a panel a design."""
    figure = Figure(figsize=(7.6, 1.0 + 0.32 * sum(len(t.shares) + 1 for t in tables)))
    heights = [len(table.shares) + 1 for table in tables]
    panels = figure.subplots(len(tables), squeeze=False, sharex=True, height_ratios=heights)[:, 0]
    for axes, table in zip(panels, tables, strict=True):
        places = np.arange(len(table.shares))
        always = [100.0 * share.always.value for share in table.shares]
        by_case = [100.0 * share.by_case.value for share in table.shares]
        axes.barh(places, always, color=_ALWAYS, label="the same on all cases")
        axes.barh(places, by_case, left=always, color=_BY_CASE, label="from case to case")
        axes.errorbar(
            [100.0 * share.whole.value for share in table.shares],
            places,
            xerr=np.hstack([reach(share.whole, 100.0) for share in table.shares]),
            fmt="none",
            ecolor="#333333",
            elinewidth=0.8,
            capsize=2,
        )
        axes.set_yticks(places, [" with ".join(share.factors) for share in table.shares])
        axes.invert_yaxis()
        axes.set_xlim(0.0, 100.0)
        asked = " and ".join(map(str, table.design.questions))
        parameters = ", ".join(table.design.parameters)
        axes.set_title(
            f"{table.design.labelled_set} (n = {table.cases}): {parameters}; {asked}",
            fontsize=9,
            loc="left",
        )
    panels[-1].set_xlabel("share of the differences between verdicts on one case (%)")
    panels[0].legend(fontsize=8, loc="lower right")
    figure.tight_layout()
    return figure

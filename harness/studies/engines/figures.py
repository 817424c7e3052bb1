"""Figures of the engine study: sources of differences, growth with items, agreement."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from steadyload.reports.charts.bars import bars
from steadyload.reports.charts.curves import curves
from steadyload.reports.charts.drawing import COST_LABEL, engine_legend, reach
from steadyload.reports.style import engine_colour, engine_marker
from steadyload.studies.engines.sources import SourceTable
from steadyload.studies.engines.speed import SpeedCurve
from steadyload.studies.engines.study import EngineAgreement


def plot_growth(measured: Sequence[SpeedCurve]) -> Figure:
    """CPU time against the number of items, both on log axes; solid all items, dashed local."""
    rows = [
        {
            "engine": curve.engine,
            "scope": curve.scope,
            "title": f"{curve.engine}, {curve.scene}, {curve.scope}"
            + (f": J^{curve.exponent:.2f}" if math.isfinite(curve.exponent) else ""),
            "is_regular": curve.scene != "pile",
            "points": curve.points,
        }
        for curve in measured
    ]
    return curves(
        rows, "item_count", "total", within="points", look="engine", of="engine", dash="scope",
        thin="is_regular", log="xy", ticks="all", x_label="items in the layout, J",
        y_label=COST_LABEL, linewidth=1.2, markersize=6.0,
    ).figure  # fmt: skip


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


def plot_sources(tables: Sequence[SourceTable]) -> Figure:
    """Shares of every source in the differences between verdicts, a panel a design."""
    rows = [
        {
            "design": f"{table.design.labelled_set} (n = {table.cases}): "
            f"{', '.join(table.design.parameters)}; "
            f"{' and '.join(map(str, table.design.questions))}",
            "source": " with ".join(share.factors),
            "share": share,
        }
        for table in tables
        for share in table.shares
    ]
    return bars(
        rows,
        {"share.always": "the same on all cases", "share.by_case": "from case to case"},
        title="source",
        whole="share.whole",
        panel="design",
        x_label="share of the differences between verdicts on one case (%)",
    ).figure

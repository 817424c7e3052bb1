"""Figures of the engine study: growth with the number of items, agreement by frequency."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from steadyload.reports.charts import PLAIN_TICKS, reach
from steadyload.reports.style import engine_colour, engine_marker
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
    axes.set(xscale="log", yscale="log")
    axes.yaxis.set_major_formatter(PLAIN_TICKS)
    axes.set_xlabel("items in the layout, J")
    axes.set_ylabel("CPU time a layout (ms)")
    counts = sorted({p.item_count for c in curves for p in c.points})
    axes.set_xticks(counts, [str(n) for n in counts])
    axes.minorticks_off()
    axes.grid(visible=True, linewidth=0.4, alpha=0.6)
    axes.legend(loc="center left", bbox_to_anchor=(1.01, 0.5), frameon=False)
    return figure


def plot_convergence(rows: Sequence[EngineAgreement]) -> Figure:
    """Agreement between every two engines against frequency."""
    figure = Figure(figsize=(6.4, 3.8))
    axes = figure.add_subplot()
    for pair in rows[0].agreement:
        found = [100 * row.agreement[pair].value for row in rows]
        ends = np.hstack([reach(row.agreement[pair], 100.0) for row in rows])
        axes.errorbar(
            [row.frequency for row in rows],
            found,
            yerr=ends,
            marker="o",
            capsize=2,
            linewidth=1.0,
            label=" and ".join(pair),
        )
    axes.set_xscale("log")
    axes.set_xticks([row.frequency for row in rows], [str(row.frequency) for row in rows])
    axes.minorticks_off()
    axes.set_xlabel("substeps a second (Hz)")
    axes.set_ylabel("same failing step (%)")
    axes.grid(visible=True, linewidth=0.4, alpha=0.6)
    axes.legend(frameon=False)
    return figure

"""Figures of loading sessions: cost of a placement by the number of items loaded."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from steadyload.reports.charts.drawing import PLAIN_TICKS
from steadyload.reports.style import colour, face, marker
from steadyload.studies.session.study import SessionCurve


def plot_placement_costs(curves: Sequence[SessionCurve]) -> Figure:
    """CPU time of a placement (log axis) against the items loaded, a panel a scene.

    Solid with markers: in a session; dotted: by judging the whole layout.
    """
    scenes = list(dict.fromkeys(curve.scene for curve in curves))
    figure = Figure(figsize=(3.4 * len(scenes) + 0.6, 4.4))
    panels = figure.subplots(1, len(scenes), sharey=True, squeeze=False)[0]
    for axes, scene in zip(panels, scenes, strict=True):
        for curve in curves:
            if curve.scene != scene:
                continue
            shade = colour(curve.method)
            axes.plot(
                [p.items for p in curve.points], [p.placement for p in curve.points],
                linewidth=1.2, marker=marker(curve.method), markersize=4.5, color=shade,
                markerfacecolor=face(curve.method),
            )  # fmt: skip
            whole = [(p.items, p.whole) for p in curve.points if p.whole is not None]
            axes.plot(
                [n for n, _ in whole], [cost for _, cost in whole], ":", linewidth=0.9, color=shade
            )
        axes.set(yscale="log", xlim=(0, None), xlabel="items loaded")
        axes.yaxis.set_major_formatter(PLAIN_TICKS)
        axes.set_title(scene, fontsize=9.0)
        axes.grid(visible=True, linewidth=0.4, alpha=0.6)
    panels[0].set_ylabel("CPU time a placement (ms)")
    methods = dict.fromkeys(curve.method for curve in curves)
    handles = [
        Line2D(
            [], [], marker=marker(m), color=colour(m), markerfacecolor=face(m), markersize=4.5,
            label=m.title,
        )
        for m in methods
    ]  # fmt: skip
    handles.append(Line2D([], [], linestyle=":", color="#7f7f7f", label="the whole layout"))
    panels[-1].legend(handles=handles, loc="center left", bbox_to_anchor=(1.02, 0.5), frameon=False)
    figure.tight_layout()
    return figure

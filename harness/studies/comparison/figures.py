"""Pictures of a comparison of methods."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.figure import Figure

from steadyload.runs.evaluation import MethodEvaluation

_PHASE_COLOURS = {"build": "#9ecae1", "step": "#3182bd", "read": "#08519c", "other": "#c7c7c7"}


def plot_phases(methods: Sequence[MethodEvaluation]) -> Figure:
    """Mean CPU time a layout by phase, for methods that have phases."""
    shown = [(m, m.phases) for m in methods if m.phases is not None and m.phases.step > 0.0]
    figure = Figure(figsize=(7.6, 0.8 + 0.36 * max(1, len(shown))))
    axes = figure.add_subplot()
    for row, (_, phases) in enumerate(reversed(shown)):
        left = 0.0
        for phase, shade in _PHASE_COLOURS.items():
            width = getattr(phases, phase)
            axes.barh(row, width, left=left, color=shade, label=phase if row == 0 else None)
            left += width
        axes.text(left, row, f" {left:.3g}", va="center", fontsize=8)
    axes.set_yticks(range(len(shown)), [m.method.title for m, _ in reversed(shown)])
    axes.set_xlabel("mean CPU time a layout (ms)")
    if shown:
        axes.legend(frameon=False, ncols=4, loc="lower center", bbox_to_anchor=(0.5, 1.0))
    return figure

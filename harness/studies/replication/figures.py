"""Figures of the paper's experiment: from its set-up to ours, a factor at a time."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from steadyload.reports.charts.drawing import PLAIN_TICKS, reach
from steadyload.studies.replication.summary import Change

_UP, _DOWN, _WHOLE = "#2a7f4f", "#b5473c", "#5b6b7a"


def plot_steps(panels: Sequence[tuple[str, Sequence[Change], float]]) -> Figure:
    """Waterfalls, one above the other: a bar reaches from the accuracy before a step to that after.

    Args:
        panels: title, steps, and the paper's accuracy as a share.
    """
    counts = [len(steps) for _, steps, _ in panels]
    figure = Figure(figsize=(7.6, 1.3 + 0.36 * (sum(counts) + 1.5 * len(panels))))
    ratios = {"height_ratios": [count + 1.0 for count in counts], "hspace": 0.55}
    drawn = figure.subplots(len(panels), 1, squeeze=False, gridspec_kw=ratios)[:, 0]
    for axes, (title, steps, printed) in zip(drawn, panels, strict=True):
        _draw(axes, steps, printed)
        axes.set_title(title, fontsize=9, loc="left")
    drawn[-1].set_xlabel("accuracy (% of test files with the label's failing step)")
    return figure


def _draw(axes: Axes, steps: Sequence[Change], printed: float) -> None:
    before: float | None = None
    for place, step in enumerate(steps):
        after = 100.0 * step.accuracy.value
        start = after if before is None else before
        shade = _WHOLE if before is None else _UP if after >= start else _DOWN
        axes.barh(place, after - start, left=start, height=0.62, color=shade, alpha=0.75)
        axes.errorbar(
            after, place, xerr=reach(step.accuracy, 100.0), fmt="|", color="#222222",
            elinewidth=0.9, capsize=2.5, markersize=9,
        )  # fmt: skip
        if before is not None:
            axes.plot([start, start], [place - 1, place], color="#999999", linewidth=0.7)
        before = after
    axes.axvline(
        100.0 * printed, color="#222222", linestyle=":", linewidth=1.0, label="the paper's figure"
    )
    axes.set_yticks(range(len(steps)), [step.title for step in steps])
    axes.set_ylim(len(steps) - 0.4, -0.6)
    axes.xaxis.set_major_formatter(PLAIN_TICKS)
    axes.grid(visible=True, axis="x", linewidth=0.4, alpha=0.6)
    axes.legend(loc="upper left", bbox_to_anchor=(1.01, 1.0), frameon=False)

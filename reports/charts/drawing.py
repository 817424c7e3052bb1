"""Kinds of charts that pages share, and how a figure becomes a file.

A chart shows what it is given and computes nothing. Cost stands on x (logarithmic), accuracy on y.
"""

from __future__ import annotations

import io
import itertools
import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, LogFormatter, NullFormatter

from steadyload.reports.style import (
    Identified,
    colour,
    engine_colour,
    engine_marker,
    face,
    marker,
)
from steadyload.reports.table import MISSING
from steadyload.statistics.estimate import Estimate

matplotlib.rcParams.update(
    {
        "text.parse_math": False,  # a dollar sign in a name is a dollar sign
        "font.size": 9.0,
        "axes.spines.top": False,
        "axes.spines.right": False,
        "svg.hashsalt": "steadyload",  # the same figure gives the same bytes
    }
)

LARGEST_SVG = 300_000
"""Bytes beyond which a figure is kept as PNG."""

PLAIN_TICKS = FuncFormatter(lambda value, _: f"{value:g}")
"""Ticks of a log axis as plain numbers."""

COST_LABEL = "CPU time a layout (ms)"
ACCURACY_LABEL = "accuracy (% of cases with the label's failing step)"

_STEPS = (
    ("#1f77b4", "-"), ("#d62728", "-"), ("#ff9896", "--"), ("#2ca02c", "-"), ("#7f7f7f", ":"),
)  # fmt: skip
_DPI = 150
_TOP = 100.5
_TICKS = (0.0, 20.0, 40.0, 60.0, 80.0, 90.0, 95.0, 98.0, 99.0, 99.5, 100.0)


class _PlainBetween(LogFormatter):
    """Ticks between the decades of a log axis as plain numbers, where there is room for them."""

    def __call__(self, x: float, pos: int | None = None) -> str:
        return f"{x:g}" if super().__call__(x, pos) else ""


@dataclass(frozen=True, slots=True)
class CostPoint:
    """A method's cost of a layout [ms], and a share such as its accuracy [0 to 1]."""

    method: Identified
    share: Estimate
    cost: Estimate


def image(figure: Figure) -> tuple[str, bytes]:
    """The ending and the bytes of a figure's file: SVG, or PNG where that would be too large.

    The same figure gives the same bytes: there is no date in them, and ids are salted alike.
    """
    drawn = _saved(figure, "svg", {"Date": None, "Creator": None})
    if len(drawn) <= LARGEST_SVG:
        return ".svg", drawn
    return ".png", _saved(figure, "png", {"Software": None})


def _saved(figure: Figure, kind: str, metadata: dict[str, None]) -> bytes:
    sink = io.BytesIO()
    figure.savefig(sink, format=kind, dpi=_DPI, bbox_inches="tight", metadata=metadata)
    return sink.getvalue()


def reach(estimate: Estimate, scale: float = 1.0) -> list[list[float]]:
    """Half-widths of the interval to both sides, in the form of error bars, shape (2, 1)."""
    return [
        [scale * max(0.0, estimate.value - estimate.low)],
        [scale * max(0.0, estimate.high - estimate.value)],
    ]


def spread_the_top(axes: Axes, least: float) -> None:
    """Let y show accuracies [%] by their distance from a little above 100, logarithmically.

    Args:
        axes: what is drawn on.
        least: the least accuracy to be shown [%].
    """
    axes.set_yscale(
        "function",
        functions=(
            lambda y: -np.log10(np.maximum(_TOP - np.asarray(y, dtype=float), 1e-3)),
            lambda t: _TOP - 10.0 ** -np.asarray(t, dtype=float),
        ),
    )
    axes.set_ylim(max(0.0, least - 5.0), 100.0)
    axes.set_yticks([tick for tick in _TICKS if tick > least - 5.0])
    axes.yaxis.set_major_formatter(PLAIN_TICKS)
    axes.yaxis.set_minor_formatter(NullFormatter())


def draw_cost_point(axes: Axes, point: CostPoint, **style: Any) -> None:
    """A method's marker with both intervals; ``style`` as of matplotlib's ``errorbar``."""
    shade, inside = colour(point.method), face(point.method)
    filled = inside == shade
    usual = {
        "fmt": marker(point.method),
        "color": shade,
        "markerfacecolor": inside,
        "markeredgecolor": "white" if filled else shade,
        "markeredgewidth": 0.6 if filled else 1.4,
        "markersize": 8.0,
        "elinewidth": 0.8,
    }
    axes.errorbar(
        point.cost.value,
        100.0 * point.share.value,
        xerr=reach(point.cost),
        yerr=reach(point.share, 100.0),
        **{**usual, **style},
    )


def set_cost_axis(axes: Axes) -> None:
    """Let x show costs [ms], logarithmically, with plain numbers."""
    axes.set_xscale("log")
    # Says something only where the costs span less than a decade.
    axes.xaxis.set_minor_formatter(_PlainBetween())
    axes.xaxis.set_major_formatter(PLAIN_TICKS)
    axes.set_xlabel(COST_LABEL)
    axes.grid(visible=True, which="major", linewidth=0.4, alpha=0.6)


def finish_growth(axes: Axes, counts: Collection[int], cost_label: str) -> None:
    """Axes of cost against the number of items, both logarithmic, with the legend beside them."""
    axes.set(xscale="log", yscale="log")
    axes.yaxis.set_major_formatter(PLAIN_TICKS)
    axes.set_xlabel("items in the layout, J")
    axes.set_ylabel(cost_label)
    axes.set_xticks(sorted(counts), [str(n) for n in sorted(counts)])
    axes.minorticks_off()
    axes.grid(visible=True, linewidth=0.4, alpha=0.6)
    axes.legend(loc="center left", bbox_to_anchor=(1.01, 0.5), frameon=False)


def engine_legend(figure: Figure, labels: Mapping[str, str], dashed: Collection[str] = ()) -> None:
    """One legend below all panels: the label of every engine; dashed lines for some."""
    handles = []
    for engine, label in labels.items():
        line = Line2D(
            [], [], marker=engine_marker(engine), color=engine_colour(engine), label=label
        )
        line.set_linestyle("--" if engine in dashed else "-")
        handles.append(line)
    figure.legend(handles=handles, loc="lower center", ncols=max(1, len(handles)), frameon=False)


def plot_cost_accuracy(points: Sequence[CostPoint], *, y_label: str = ACCURACY_LABEL) -> Figure:
    """Share in per cent against cost (log axis), with intervals: Fig. 3 of the paper.

    Good methods stand at the upper left. Methods without a share are left out.
    """
    figure = Figure(figsize=(7.6, 4.6))
    axes = figure.add_subplot()
    shown = [point for point in points if not math.isnan(point.share.value)]
    for point in shown:
        draw_cost_point(axes, point)
        axes.plot(
            [],
            [],
            marker(point.method),
            color=colour(point.method),
            markerfacecolor=face(point.method),
            markersize=7,
            label=point.method.title,
        )
    if any(point.cost.value > 0.0 for point in shown):
        set_cost_axis(axes)
    axes.set_xlabel(COST_LABEL)
    axes.set_ylabel(y_label)
    axes.legend(loc="center left", bbox_to_anchor=(1.01, 0.5), frameon=False)
    return figure


def ecdf(
    groups: Mapping[str, tuple[Sequence[float], int]],
    *,
    x: str,
    y: str,
    among: Collection[str] = (),
) -> Figure:
    """Share of a group [%] that has come to an end by a share [%]: a step curve a group.

    Args:
        groups: by title the shares at which members end, ascending, and the number of members.
        x: label of the axis.
        y: label of the axis.
        among: titles of all groups there may be, so that one has the same line on every page.
    """
    figure = Figure(figsize=(6.4, 4.2))
    axes = figure.add_subplot()
    styles = dict(zip(among or groups, itertools.cycle(_STEPS), strict=False))
    for title, (ends, count) in groups.items():
        shade, line = styles[title]
        across = [0.0, *(100.0 * end for end in ends), 100.0]
        up = [100.0 * k / count for k in range(len(ends) + 1)]
        label = f"{title} ({count})"
        axes.step(
            across, [*up, up[-1]], line, where="post", color=shade, linewidth=1.6, label=label
        )
    axes.set(xlim=(0.0, 100.0), ylim=(-1.0, 100.0), xlabel=x, ylabel=y)
    axes.grid(visible=True, linewidth=0.4, alpha=0.6)
    axes.legend(loc="upper left", frameon=False)
    return figure


def plot_matrix(
    titles: Sequence[str], shares: Sequence[Sequence[Estimate]], *, label: str
) -> Figure:
    """Share between every two of several things, in per cent, as colours and numbers.

    Args:
        titles: of rows and columns.
        shares: a row each; one that is not a number, as on the diagonal, is a dash.
        label: what the colours show.
    """
    values = 100.0 * np.array([[e.value for e in row] for row in shares])
    known = values[~np.isnan(values)]
    least = 10.0 * math.floor(float(known.min()) / 10.0) if known.size else 0.0
    side = 1.8 + 0.5 * len(titles)
    figure = Figure(figsize=(side + 0.6, side))
    axes = figure.add_subplot()
    lowest = min(least, 90.0)
    dark = lowest + 0.65 * (100.0 - lowest)
    shown = axes.imshow(values, vmin=lowest, vmax=100, cmap="viridis")
    axes.set_xticks(range(len(titles)), titles, rotation=45, ha="right")
    axes.set_yticks(range(len(titles)), titles)
    axes.spines[:].set_visible(False)
    for row in range(len(titles)):
        for column in range(len(titles)):
            value = values[row, column]
            axes.text(
                column,
                row,
                MISSING if math.isnan(value) else f"{value:.0f}",
                ha="center",
                va="center",
                fontsize=8,
                color="white" if value < dark else "black",
            )
    bar = figure.colorbar(shown, ax=axes, fraction=0.046, pad=0.03)
    bar.set_label(label)
    return figure

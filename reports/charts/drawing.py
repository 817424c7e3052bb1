"""Kinds of charts that pages share, and how a figure becomes a file.

A chart shows what it is given and computes nothing. Cost stands on x (logarithmic), accuracy on y.
"""

from __future__ import annotations

import io
from typing import Any, Literal, NamedTuple

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogFormatter, NullFormatter

from steadyload.reports.interactive import CostPoint, Interactive
from steadyload.reports.style import (
    colour,
    face,
    marker,
)
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

_DPI = 150
_TOP = 100.5
_TICKS = (0.0, 20.0, 40.0, 60.0, 80.0, 90.0, 95.0, 98.0, 99.0, 99.5, 100.0)


class _PlainBetween(LogFormatter):
    """Ticks between the decades of a log axis as plain numbers, where there is room for them."""

    def __call__(self, x: float, pos: int | None = None) -> str:
        return f"{x:g}" if super().__call__(x, pos) else ""


class Chart(NamedTuple):
    """A figure, and the chart that stands in its place in the HTML page, if any."""

    figure: Figure
    interactive: Interactive | None = None


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


def set_log_axis(axes: Axes) -> None:
    """Let x be logarithmic, with plain numbers."""
    axes.set_xscale("log")
    # Says something only where x spans less than a decade.
    axes.xaxis.set_minor_formatter(_PlainBetween())
    axes.xaxis.set_major_formatter(PLAIN_TICKS)


def set_cost_axis(axes: Axes) -> None:
    """Let x show costs [ms], logarithmically, with plain numbers."""
    set_log_axis(axes)
    axes.set_xlabel(COST_LABEL)
    axes.grid(visible=True, which="major", linewidth=0.4, alpha=0.6)


def legend(
    figure: Figure, place: Literal["beside", "right", "corner", "upper left", "best"]
) -> None:
    """The legend of a figure without a frame; none where nothing is named.

    Args:
        figure: its panels are drawn.
        place: "beside" the last panel, "right" of all panels, or in the lower right "corner", for
            what any of them shows; else a place within the last one, as of Matplotlib, for what
            that shows.
    """
    last = figure.axes[-1]
    shown: dict[str, Any] = {}
    for axes in figure.axes if place in ("right", "beside", "corner") else (last,):
        handles, labels = axes.get_legend_handles_labels()
        shown |= dict(zip(labels, handles, strict=True))
    if not shown:
        return
    named: Any = (list(shown.values()), list(shown))
    if place == "right":
        figure.legend(*named, loc="outside right upper", frameon=False)
    elif place == "corner":
        figure.legend(*named, loc="lower right", frameon=False)
    elif place == "beside":
        last.legend(*named, loc="center left", bbox_to_anchor=(1.01, 0.5), frameon=False)
    else:
        last.legend(*named, loc=place, frameon=False)

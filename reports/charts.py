"""Pictures of records. A figure shows what its record holds and computes nothing.

Pictures are PNG without date or software stamps: the same record gives the same bytes.
"""

from __future__ import annotations

import io
import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import matplotlib
import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogFormatter
from mpl_toolkits.mplot3d.art3d import Poly3DCollection
from numpy.typing import NDArray

from steadyload.reports.style import Identified, colour, face, marker
from steadyload.statistics.estimate import Estimate


@dataclass(frozen=True, slots=True)
class TradeOff:
    """A method's place between a share [0 to 1] and CPU time a layout [ms]."""

    method: Identified
    share: Estimate
    cpu: Estimate


matplotlib.rcParams.update(
    {
        "text.parse_math": False,  # a dollar sign in a name is a dollar sign
        "font.size": 9.0,
        "axes.spines.top": False,
        "axes.spines.right": False,
    }
)

FloatArray = NDArray[np.float64]

_DPI = 150
PLAIN_TICKS = FuncFormatter(lambda value, _: f"{value:g}")
"""Ticks of a log axis as plain numbers."""

_SHORT = 0.1
"""An axis below this share of the longest one has a single tick."""


class _PlainBetween(LogFormatter):
    """Ticks between the decades of a log axis as plain numbers, where there is room for them."""

    def __call__(self, x: float, pos: int | None = None) -> str:
        return f"{x:g}" if super().__call__(x, pos) else ""


def png(figure: Figure) -> bytes:
    """A figure as PNG, reproducible to the byte."""
    sink = io.BytesIO()
    figure.savefig(sink, format="png", dpi=_DPI, bbox_inches="tight", metadata={"Software": None})
    return sink.getvalue()


def plot_trade_off(points: Sequence[TradeOff], *, x_label: str) -> Figure:
    """Runtime (log axis) against a share in per cent, with intervals: Fig. 3 of the paper.

    Good methods stand at the lower right. Methods without a share are left out.
    """
    figure = Figure(figsize=(7.6, 4.6))
    axes = figure.add_subplot()
    shown = [point for point in points if not math.isnan(point.share.value)]
    for point in shown:
        x, y = point.share, point.cpu
        filled = face(point.method) == colour(point.method)
        axes.errorbar(
            100 * x.value,
            y.value,
            xerr=[[100 * (x.value - x.low)], [100 * (x.high - x.value)]],
            yerr=[[y.value - y.low], [y.high - y.value]],
            fmt=marker(point.method),
            color=colour(point.method),
            markersize=8,
            markerfacecolor=face(point.method),
            markeredgecolor="white" if filled else colour(point.method),
            elinewidth=0.8,
        )
        axes.plot(
            [],
            [],
            marker(point.method),
            color=colour(point.method),
            markerfacecolor=face(point.method),
            markersize=7,
            label=point.method.title,
        )
    if any(point.cpu.value > 0.0 for point in shown):
        axes.set_yscale("log")
        # Says something only where the times span less than a decade.
        axes.yaxis.set_minor_formatter(_PlainBetween())
    axes.yaxis.set_major_formatter(PLAIN_TICKS)
    axes.set_xlabel(x_label)
    axes.set_ylabel("CPU time a layout (ms)")
    axes.grid(visible=True, which="major", linewidth=0.4, alpha=0.6)
    axes.legend(loc="center left", bbox_to_anchor=(1.01, 0.5), frameon=False)
    return figure


def plot_agreement_matrix(titles: Sequence[str], shares: Sequence[Sequence[Estimate]]) -> Figure:
    """Share of equal failing steps between every two methods, in per cent."""
    values = np.array([[e.value for e in row] for row in shares]) * 100
    side = 1.8 + 0.5 * len(titles)
    figure = Figure(figsize=(side + 0.6, side))
    axes = figure.add_subplot()
    image = axes.imshow(values, vmin=0, vmax=100, cmap="viridis")
    axes.set_xticks(range(len(titles)), titles, rotation=45, ha="right")
    axes.set_yticks(range(len(titles)), titles)
    axes.spines[:].set_visible(False)
    for row in range(len(titles)):
        for column in range(len(titles)):
            value = values[row, column]
            axes.text(
                column,
                row,
                f"{value:.0f}",
                ha="center",
                va="center",
                fontsize=8,
                color="white" if value < 65 else "black",
            )
    bar = figure.colorbar(image, ax=axes, fraction=0.046, pad=0.03)
    bar.set_label("same failing step (%)")
    return figure


class Drawable(Protocol):
    """Boxes that a scene is drawn of, such as a layout: corners (n, 3) [cm], y up, in order."""

    @property
    def pallet(self) -> Any:
        """Has ``size``: width, height and depth [cm]."""

    @property
    def lower(self) -> FloatArray:
        """Lower corners."""

    @property
    def upper(self) -> FloatArray:
        """Upper corners."""

    @property
    def mass_offsets(self) -> FloatArray:
        """Centres of mass minus geometric centres."""


def plot_scene(scene: Drawable, *, title: str = "", marked: Collection[int] = ()) -> Figure:
    """A layout in 3-D: items with their sequence numbers, centres of mass, marked items in red."""
    figure = Figure(figsize=(5.6, 5.2))
    axes = figure.add_subplot(projection="3d")
    count = len(scene.lower)
    mass_centres = 0.5 * (scene.lower + scene.upper) + scene.mass_offsets
    shades = matplotlib.colormaps["viridis"](np.linspace(0.15, 0.95, max(count, 2)))
    for index in range(count):
        # Matplotlib draws z up: (x, y, z) of the layout becomes (z, x, y).
        low, high = scene.lower[index, [2, 0, 1]], scene.upper[index, [2, 0, 1]]
        is_marked = index in marked
        faces = Poly3DCollection(
            _faces(low, high),
            facecolor="#e31a1c" if is_marked else shades[index],
            edgecolor="black",
            linewidths=0.5,
            alpha=0.85 if is_marked else 0.35,
        )
        axes.add_collection3d(faces)
        centre, mass = 0.5 * (low + high), mass_centres[index, [2, 0, 1]]
        axes.text(*centre, str(index), fontsize=7, ha="center", zorder=1000)
        axes.scatter(*mass, s=6, color="black", depthshade=False)
    width, height, depth = scene.pallet.size
    top = min(height, float(scene.upper[:, 1].max()) * 1.05)
    axes.set(xlim=(0, depth), ylim=(0, width), zlim=(0, top))
    axes.set(xlabel="z, depth (cm)", ylabel="x, width (cm)", zlabel="y, height (cm)")
    axes.set_box_aspect((depth, width, top))
    axes.locator_params(nbins=4)
    for axis, side in ((axes.xaxis, depth), (axes.yaxis, width), (axes.zaxis, top)):
        if side < _SHORT * max(depth, width, top):  # no room for more than one number
            axis.set_ticks([side])
    axes.set_title(title)
    return figure


def _faces(low: np.ndarray, high: np.ndarray) -> list[list[tuple[float, float, float]]]:
    (x0, y0, z0), (x1, y1, z1) = low.tolist(), high.tolist()
    bottom = [(x0, y0), (x1, y0), (x1, y1), (x0, y1)]
    sides = [
        [(*a, z0), (*b, z0), (*b, z1), (*a, z1)]
        for a, b in zip(bottom, bottom[1:] + bottom[:1], strict=True)
    ]
    return [[(x, y, z0) for x, y in bottom], [(x, y, z1) for x, y in bottom], *sides]

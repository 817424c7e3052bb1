"""The kind ``scene``: a layout drawn in 3-D."""

from __future__ import annotations

from collections.abc import Collection
from typing import Any, Protocol

import matplotlib
import numpy as np
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d.art3d import Poly3DCollection
from numpy.typing import NDArray

from steadyload.escaping import printable
from steadyload.reports.charts.drawing import Chart

FloatArray = NDArray[np.float64]

_SHORT = 0.2
"""An axis below this share of the longest one has a single tick."""

_FAR = 1000.0
"""A deck is sorted as if it lay so many times lower than it does."""


class Drawable(Protocol):
    """Boxes that a scene is drawn of, such as a layout: corners (n, 3) [cm], y up, in order."""

    @property
    def pallet(self) -> Any:
        """Has ``size``: width, height and depth [cm]."""

    @property
    def floor(self) -> Any:
        """Has ``has_edges``, and then ``low``, ``high`` and ``height`` [cm]."""

    @property
    def lower(self) -> FloatArray:
        """Lower corners."""

    @property
    def upper(self) -> FloatArray:
        """Upper corners."""

    @property
    def mass_offsets(self) -> FloatArray:
        """Centres of mass minus geometric centres."""


def scene(load: Drawable, *, title: str = "", marked: Collection[int] = ()) -> Chart:
    """A layout in 3-D: items with their sequence numbers, centres of mass, marked items in red.

    Args:
        load: the layout.
        title: stands above it.
        marked: numbers of items, from 0.
    """
    figure = Figure(figsize=(5.6, 5.2))
    axes = figure.add_subplot(projection="3d")
    count = len(load.lower)
    mass_centres = 0.5 * (load.lower + load.upper) + load.mass_offsets
    shades = matplotlib.colormaps["viridis"](np.linspace(0.15, 0.95, max(count, 2)))
    for index in range(count):
        # Matplotlib draws z up: (x, y, z) of the layout becomes (z, x, y).
        low, high = load.lower[index, [2, 0, 1]], load.upper[index, [2, 0, 1]]
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
    width, height, depth = load.pallet.size
    top = min(height, float(load.upper[:, 1].max()) * 1.05)
    low, high = np.zeros(3), np.array((depth, width, top))
    if load.floor.has_edges:
        low = np.minimum(_add_deck(axes, load.floor), load.lower.min(axis=0)[[2, 0, 1]])
        high = np.maximum(high, load.upper.max(axis=0)[[2, 0, 1]])
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
    axes.set(xlabel="z, depth (cm)", ylabel="x, width (cm)", zlabel="y, height (cm)")
    axes.set_box_aspect(tuple(high - low))
    axes.locator_params(nbins=4)
    for axis, side in ((axes.xaxis, depth), (axes.yaxis, width), (axes.zaxis, top)):
        if side < _SHORT * max(depth, width, top):  # no room for more than one number
            axis.set_ticks([side])
    axes.set_title(printable(title), parse_math=False)
    return Chart(figure)


def _add_deck(axes: Any, floor: Any) -> np.ndarray:
    """Draw a deck; its lower corner, as it is drawn."""
    (x0, z0), (x1, z1) = floor.low, floor.high
    low, high = np.array((z0, x0, -floor.height)), np.array((z1, x1, 0.0))
    wood = {"facecolor": "#c8a97e", "edgecolor": "#6b4f2a", "linewidths": 0.5, "alpha": 0.5}
    slab = Poly3DCollection(_faces(low, high), **wood)
    slab.set_sort_zpos(-_FAR * floor.height)  # drawn first: everything stands on it
    axes.add_collection3d(slab)
    return low


def _faces(low: np.ndarray, high: np.ndarray) -> list[list[tuple[float, float, float]]]:
    (x0, y0, z0), (x1, y1, z1) = low.tolist(), high.tolist()
    bottom = [(x0, y0), (x1, y0), (x1, y1), (x0, y1)]
    sides = [
        [(*a, z0), (*b, z0), (*b, z1), (*a, z1)]
        for a, b in zip(bottom, bottom[1:] + bottom[:1], strict=True)
    ]
    return [[(x, y, z0) for x, y in bottom], [(x, y, z1) for x, y in bottom], *sides]

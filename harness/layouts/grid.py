"""Boxes found by where they are: the cost depends on what is near, not on their number.

A hash grid with cells of several sizes. A box lies in one cell only, that of its lower corner, on
the level whose cells it does not exceed: so it reaches into the next cell at most, and a search
looks one cell further down.
"""

from __future__ import annotations

import math

from steadyload.layouts.model import Vector

_BASE = 3.0
"""Cells grow by this from level to level: few levels to search, few boxes in a cell."""

_Level = tuple[float, float]
"""Sides of cells [cm], horizontal and vertical: flat boxes, which pile up, have flat cells."""

_Cell = tuple[int, int, int]

_Entry = tuple[int, float, float, float, float, float, float]
"""A box: its number, its lower corner, its upper corner."""


class BoxGrid:
    """Numbered boxes by place."""

    def __init__(self) -> None:
        self._levels: dict[_Level, dict[_Cell, tuple[_Entry, ...]]] = {}

    def add(self, number: int, low: Vector, high: Vector) -> None:
        """Put in a box with these corners (x, y, z) [cm]."""
        level, cell = _place(low, high)
        cells = self._levels.setdefault(level, {})
        cells[cell] = (*cells.get(cell, ()), (number, *low, *high))

    def remove(self, number: int, low: Vector, high: Vector) -> None:
        """Take out a box that was put in with these corners."""
        level, cell = _place(low, high)
        cells = self._levels[level]
        left = tuple(entry for entry in cells[cell] if entry[0] != number)
        if left:
            cells[cell] = left
        else:
            del cells[cell]

    def meeting(self, low: Vector, high: Vector) -> list[int]:
        """Numbers of all boxes that share a point with a region, in no order."""
        found: list[int] = []
        (x0, y0, z0), (x1, y1, z1) = low, high
        # Written out: this is where loading spends its time.
        for (across, up), cells in self._levels.items():
            xs = range(math.floor(x0 / across) - 1, math.floor(x1 / across) + 1)
            ys = range(math.floor(y0 / up) - 1, math.floor(y1 / up) + 1)
            zs = range(math.floor(z0 / across) - 1, math.floor(z1 / across) + 1)
            if len(xs) * len(ys) * len(zs) < len(cells):
                near = [cells.get((i, j, k)) for i in xs for j in ys for k in zs]
            else:
                near = [
                    boxes for (i, j, k), boxes in cells.items() if i in xs and j in ys and k in zs
                ]
            for boxes in near:
                for number, ax, ay, az, bx, by, bz in boxes or ():
                    if ax <= x1 and bx >= x0 and ay <= y1 and by >= y0 and az <= z1 and bz >= z0:
                        found.append(number)
        return found

    def copy(self) -> BoxGrid:
        """Another grid with the same boxes."""
        other = BoxGrid()
        other._levels = {level: dict(cells) for level, cells in self._levels.items()}
        return other


def _place(low: Vector, high: Vector) -> tuple[_Level, _Cell]:
    width, height, depth = high[0] - low[0], high[1] - low[1], high[2] - low[2]
    across, up = _side(max(width, depth)), _side(height)
    cell = (math.floor(low[0] / across), math.floor(low[1] / up), math.floor(low[2] / across))
    return (across, up), cell


def _side(length: float) -> float:
    """The least power of :data:`_BASE` that is not below a length."""
    side = _BASE ** math.ceil(math.log(length, _BASE))
    return side if side >= length else side * _BASE  # the logarithm is rounded

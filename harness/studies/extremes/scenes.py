"""Boxes for the sweeps of the extremes, at their planned poses, in SI."""

from __future__ import annotations

import math

from steadyload.engines.world import Box
from steadyload.properties.closed_forms import CUBE, SIDE, stacked

DENSITY = 1000.0
"""Density of all boxes [kg/m3]: a cube of 10 cm weighs 1 kg."""

PLATE, TABLE = (1.0, 1.0, 0.01), (1.0, 1.0, 0.5)
PLATE_MASS = DENSITY * math.prod(PLATE)


def tower(count: int, side: float = SIDE) -> list[Box]:
    """Equal cubes on top of each other."""
    return stacked((side, side, side), [DENSITY * side**3] * count)


def pile(count: int, dimensions: int) -> list[Box]:
    """Cubes without gaps, layer by layer, as nearly a cube (or a square wall, 2-D) as can be."""
    across = math.ceil(round(count ** (1.0 / dimensions), 9))
    deep = across if dimensions == 3 else 1
    layer = across * deep
    places = (((k % across) * SIDE, (k // across % deep) * SIDE, k // layer) for k in range(count))
    return [Box(CUBE, 1.0, (x, y, SIDE * (level + 0.5))) for x, y, level in places]


def plate_on_table(past_edge: float) -> list[Box]:
    """A plate on a fixed table; its centre of mass is ``past_edge`` [m] beyond the edge."""
    table = Box(TABLE, 1.0, (0.0, 0.0, 0.5 * TABLE[2]), fixed=True)
    centre = (0.5 * TABLE[0] + past_edge, 0.0, TABLE[2] + 0.5 * PLATE[2])
    return [table, Box(PLATE, PLATE_MASS, centre)]

"""Boxes for the sweeps of the extremes, at their planned poses, in SI."""

from __future__ import annotations

import math

from steadyload.engines.world import Box

SIDE = 0.1
"""Edge of a cube in sweeps of other quantities than size [m]."""

DENSITY = 1000.0
"""Density of all boxes [kg/m3]: a cube of 10 cm weighs 1 kg."""

PLATE = (1.0, 1.0, 0.01)
TABLE = (1.0, 1.0, 0.5)


def tower(count: int, side: float = SIDE) -> list[Box]:
    """Equal cubes on top of each other."""
    return [_cube(DENSITY * side**3, (0.0, 0.0, side * (k + 0.5)), side) for k in range(count)]


def loaded(masses: tuple[float, ...]) -> list[Box]:
    """Cubes of 10 cm on top of each other, with these masses [kg], the lowest first."""
    return [_cube(mass, (0.0, 0.0, SIDE * (k + 0.5)), SIDE) for k, mass in enumerate(masses)]


def pile(count: int, dimensions: int) -> list[Box]:
    """Cubes without gaps, layer by layer, as nearly a cube (or a square wall, 2-D) as can be."""
    across = math.ceil(round(count ** (1.0 / dimensions), 9))
    deep = across if dimensions == 3 else 1
    layer = across * deep
    places = (((k % across) * SIDE, (k // across % deep) * SIDE, k // layer) for k in range(count))
    return [_cube(1.0, (x, y, SIDE * (level + 0.5)), SIDE) for x, y, level in places]


def plates(count: int) -> list[Box]:
    """Thin plates on top of each other."""
    mass, thick = DENSITY * math.prod(PLATE), PLATE[2]
    return [Box(PLATE, mass, (0.0, 0.0, thick * (k + 0.5))) for k in range(count)]


def plate_on_table(past_edge: float) -> list[Box]:
    """A plate on a fixed table; its centre of mass is ``past_edge`` [m] beyond the edge."""
    table = Box(TABLE, 1.0, (0.0, 0.0, 0.5 * TABLE[2]), fixed=True)
    centre = (0.5 * TABLE[0] + past_edge, 0.0, TABLE[2] + 0.5 * PLATE[2])
    return [table, Box(PLATE, DENSITY * math.prod(PLATE), centre)]


def _cube(mass: float, centre: tuple[float, float, float], side: float) -> Box:
    return Box((side, side, side), mass, centre)

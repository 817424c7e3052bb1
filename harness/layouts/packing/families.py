"""Families of layouts that lie outside the distribution of the labelled sets.

Boxes are lowered onto a height map: each is offered places at random, and comes down at the one
where the map rises least, as by heightmap minimization (Wang and Hauser 2019, "Stable bin packing
of non-convex 3D objects with a robot manipulator", ICRA). So every box can be loaded from above, a
part of its base may hang in the air, and no heuristic of the labelled sets takes part. A family is
one entry of :data:`FAMILIES`: how large, how heavy and how evenly filled its boxes are.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from steadyload.layouts.model.item import Item, Vector
from steadyload.layouts.model.layout import Layout
from steadyload.layouts.model.pallet import Pallet
from steadyload.layouts.packing.packing import PackingError

DECK = Pallet(120.0, 200.0, 80.0)
"""Contour of every layout: a Euro pallet's plan."""

FEWEST, MOST = 16, 20
"""Boxes of a layout: the most that the layouts of the labelled sets hold."""

_PLACES = 48
"""Places that a box is offered, a half of them beside edges of boxes that stand there."""

_CELL, _MM = 0.5, 0.1
"""Lengths [cm] of which sides along the floor, and heights, are multiples."""

_UNITS = np.array((_CELL, _MM, _CELL))

_GRAMS, _HUNDREDTHS = 3, 2
"""Decimals of weights [kg] and of centres of mass [cm]."""

_CUBIC_METRES = 1e-6
"""In a cubic centimetre."""

_Whole = NDArray[np.int64]


class Range(NamedTuple):
    """The least and the greatest of some numbers."""

    low: float
    high: float


_MIDDLE = Range(0.0, 0.0)


@dataclass(frozen=True, slots=True)
class Family:
    """How the boxes of a family are drawn, each by itself.

    Attributes:
        about: its boxes, in words.
        width, height, depth: log-uniform sides [cm]; half of the boxes are turned about the
            vertical.
        density: log-uniform [kg/m3].
        aside_x, aside_y, aside_z: the centre of mass minus the geometric centre, uniform, in sides
            of the box as it stands, -0.5 to 0.5.
    """

    about: str
    width: Range
    height: Range
    depth: Range
    density: Range
    aside_x: Range = _MIDDLE
    aside_y: Range = _MIDDLE
    aside_z: Range = _MIDDLE


_ANY_SIDE, _ANY_DENSITY = Range(8.0, 60.0), Range(50.0, 1500.0)
_CARTON = {
    "width": Range(30.0, 60.0),
    "height": Range(12.0, 40.0),
    "depth": Range(20.0, 40.0),
    "density": Range(100.0, 500.0),
}

FAMILIES: Mapping[str, Family] = {
    "mixed": Family(
        "sides of 8 to 60 cm, 50 to 1500 kg/m3, centred",
        _ANY_SIDE, _ANY_SIDE, _ANY_SIDE, _ANY_DENSITY,
    ),
    "off-centre": Family(
        "the same, centres of mass anywhere within 0.48 of a side",
        _ANY_SIDE, _ANY_SIDE, _ANY_SIDE, _ANY_DENSITY,
        *(Range(-0.48, 0.48),) * 3,
    ),
    "one-sided": Family(
        "cartons, all centres of mass 0.45 of the width to one side",
        **_CARTON, aside_x=Range(0.45, 0.45),
    ),
    "slabs": Family(
        "2 to 8 cm thick, flat, 30 to 80 by 20 to 60 cm, 200 to 1500 kg/m3, centred",
        Range(30.0, 80.0), Range(2.0, 8.0), Range(20.0, 60.0), Range(200.0, 1500.0),
    ),
    "cartons": Family(
        "30 to 60 by 20 to 40 cm, 12 to 40 cm high, 100 to 500 kg/m3, centred", **_CARTON
    ),
}  # fmt: skip
"""Families by name, in the order of pages."""


def family_layouts(name: str, count: int, seed: int) -> list[Layout]:
    """Layouts of a family, named by it and their number: ``slabs-0007``.

    A layout depends on the seed, the name of the family and its number alone, so that a larger
    count begins with the same ones, and a further family changes no other.

    Args:
        name: a key of :data:`FAMILIES`.
        count: 1 or more.
        seed: 0 or more.

    Returns:
        Layouts on :data:`DECK` of :data:`FEWEST` to :data:`MOST` boxes, loaded from above.

    Raises:
        PackingError: no such family, count or seed.
    """
    if name not in FAMILIES:
        raise PackingError(f"family is {name!r}; allowed: {', '.join(FAMILIES)}")
    for what, value, least in (("count", count, 1), ("seed", seed, 0)):
        if value < least:
            raise PackingError(f"{what} is {value!r}; allowed: {least} or more")
    return [_drawn(name, number, seed) for number in range(count)]


def _drawn(name: str, number: int, seed: int) -> Layout:
    sequence = np.random.SeedSequence(seed, spawn_key=(number, *name.encode()))
    random = np.random.default_rng(sequence)
    wanted = int(random.integers(FEWEST, MOST + 1))
    family, heights = FAMILIES[name], _HeightMap()
    items: list[Item] = []
    while len(items) < wanted:
        size = _size(family, random)
        corner = heights.place(size, random)
        if corner is not None:  # else there is no room for the box, which is left out
            items.append(_item(len(items), corner, size, family, random))
    return Layout(f"{name}-{number:04d}", DECK, tuple(items))


def _size(family: Family, random: np.random.Generator) -> _Whole:
    """Width, height and depth of a box as it stands, in :data:`_UNITS`."""
    sides = [_log_uniform(own, random) for own in (family.width, family.height, family.depth)]
    turned = sides[::-1] if random.random() < 0.5 else sides
    return _whole(turned)


def _whole(lengths: Sequence[float]) -> _Whole:
    """Lengths [cm] along x, y, z in :data:`_UNITS`."""
    return np.rint(np.array(lengths) / _UNITS).astype(np.int64)


def _item(
    sequence: int, corner: _Whole, size: _Whole, family: Family, random: np.random.Generator
) -> Item:
    sides = size * _UNITS
    weight = _log_uniform(family.density, random) * _CUBIC_METRES * float(np.prod(sides))
    aside = [random.uniform(*own) for own in (family.aside_x, family.aside_y, family.aside_z)]
    return Item(
        sequence,
        _vector(corner * _UNITS),
        _vector(sides),
        round(weight, _GRAMS),
        _vector(aside * sides + 0.0),
    )


def _log_uniform(own: Range, random: np.random.Generator) -> float:
    return math.exp(random.uniform(math.log(own.low), math.log(own.high)))


def _vector(values: NDArray[np.float64]) -> Vector:
    x, y, z = np.round(values, _HUNDREDTHS).tolist()
    return x, y, z


class _HeightMap:
    """How high boxes reach in every cell of the deck, in :data:`_UNITS`."""

    def __init__(self) -> None:
        width, self.most, depth = _whole(DECK.size).tolist()
        self.heights = np.zeros((width, depth), dtype=np.int64)
        self.edges: tuple[list[int], list[int]] = ([0, width], [0, depth])

    def place(self, size: _Whole, random: np.random.Generator) -> _Whole | None:
        """Lower a box at the place, of those that it is offered, above which least room is lost.

        Of several such places it takes the lowest, and of these the one with the least x, then z.

        Returns:
            Its corner; None where it has no room within the contour, and the map is as before.
        """
        width, height, depth = size.tolist()
        rooms = (self.heights.shape[0] - width, self.heights.shape[1] - depth)
        if min(rooms) < 0:
            return None
        half = _PLACES // 2
        along_x = [*self._beside(0, width, random), *random.integers(0, rooms[0] + 1, half)]
        along_z = [*self._beside(1, depth, random), *random.integers(0, rooms[1] + 1, half)]
        _, rest, x, z = min(
            (*self._below(x, z, width, depth), int(x), int(z))
            for x, z in zip(along_x, along_z, strict=True)
        )
        if rest + height > self.most:
            return None
        self.heights[x : x + width, z : z + depth] = rest + height
        self.edges[0].extend((x, x + width))
        self.edges[1].extend((z, z + depth))
        return np.array((x, rest, z))

    def _below(self, x: int, z: int, width: int, depth: int) -> tuple[int, int]:
        """Room that is lost below a box, and the height at which it rests."""
        covered = self.heights[x : x + width, z : z + depth]
        rest = int(covered.max())
        return rest * covered.size - int(covered.sum()), rest

    def _beside(self, axis: int, side: int, random: np.random.Generator) -> _Whole:
        """Places along an axis at which a side begins or ends where an edge is."""
        edges = np.array(self.edges[axis])
        places = np.unique(np.concatenate((edges, edges - side)))
        inside = places[(places >= 0) & (places <= self.heights.shape[axis] - side)]
        return random.choice(inside, _PLACES // 2)

"""Hypothesis strategies that build layouts by construction: whatever they draw can be loaded into.

Sides and shifts are whole centimetres where not said otherwise, so that positions add up exactly.
Everything shrinks: to fewer, smaller, centred items. ``planar`` layouts move in one vertical plane
only, as 2-D engines ask: all items share their depth, and no centre of mass leaves its middle.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from hypothesis import strategies as st
from hypothesis.strategies import DrawFn, SearchStrategy

from steadyload.layouts.model.layout import Item, Layout, Pallet, Vector
from steadyload.layouts.model.scenarios import Scenario, apply_scenario
from steadyload.layouts.packing.packing import DENSITY, ITEM_CLASSES, SPACE_RULES, pack

_DEPTH = 20
"""Shared depth of planar layouts [cm]."""

_PERCENT = 40
"""A centre of mass stays within this share of a side of its middle, as in S2b."""


@dataclass(frozen=True, slots=True)
class Placed:
    """A box to be placed: left-bottom-back corner and size [cm], weight [kg], offset [cm]."""

    position: Vector
    size: Vector
    weight: float
    mass_offset: Vector = (0.0, 0.0, 0.0)

    @property
    def top(self) -> float:
        """Height of the upper face [cm]."""
        return self.position[1] + self.size[1]


def built(name: str, boxes: Sequence[Placed]) -> Layout:
    """A layout of boxes in loading order, on a pallet that just holds them.

    Args:
        name: of the layout.
        boxes: one or more; positions may be negative along x and z.

    Raises:
        LayoutError: boxes that overlap or float below the floor.
    """
    shift = [-min(box.position[axis] for box in boxes) for axis in (0, 2)]
    items = []
    for sequence, box in enumerate(boxes):
        x, y, z = box.position
        position = (x + shift[0], y, z + shift[1])
        items.append(Item(sequence, position, box.size, box.weight, box.mass_offset))
    ends = [max(i.position[axis] + i.size[axis] for i in items) for axis in range(3)]
    return Layout(name, Pallet(*ends), tuple(items))


def density_weight(size: Vector) -> float:
    """Weight at the paper's density [kg]."""
    return DENSITY * 1e-6 * size[0] * size[1] * size[2]


def sides(least: int = 2, most: int = 40) -> SearchStrategy[float]:
    """Lengths in whole centimetres."""
    return st.integers(least, most).map(float)


def _depths(planar: bool, least: int = 2, most: int = 40) -> SearchStrategy[float]:
    return st.just(float(_DEPTH)) if planar else sides(least, most)


@st.composite
def single_items(draw: DrawFn, *, planar: bool = False) -> Layout:
    """One item on the floor."""
    size = (draw(sides(1, 100)), draw(sides(1, 100)), draw(_depths(planar, 1, 100)))
    return built("single", [Placed((0.0, 0.0, 0.0), size, density_weight(size))])


@st.composite
def towers(draw: DrawFn, *, most: int = 8, planar: bool = False) -> Layout:
    """Items standing on each other, each in the middle of the one below and not larger; S1.

    No item is higher than its base is wide. Equal and unequal ones.

    Args:
        draw: given by hypothesis.
        most: items at most.
        planar: see the module.
    """
    count = draw(st.integers(1, most))
    equal = draw(st.booleans())
    width, depth = draw(sides()), draw(_depths(planar))
    height = draw(sides(1, int(min(width, depth))))
    boxes: list[Placed] = []
    top = 0.0
    for level in range(count):
        if level and not equal:
            width = draw(sides(1, int(width)))
            depth = depth if planar else draw(sides(1, int(depth)))
            height = draw(sides(1, max(1, int(min(width, depth)))))
        size = (width, height, depth)
        boxes.append(Placed((-0.5 * width, top, -0.5 * depth), size, density_weight(size)))
        top += height
    return built("tower", boxes)


@st.composite
def carton_towers(draw: DrawFn, *, most: int = 20, planar: bool = False) -> Layout:
    """Cartons of 20 to 60 cm on each other, each in the middle of the one below and not larger.

    No carton is higher than its base is wide.
    """
    width, depth = draw(sides(20, 60)), draw(_depths(planar, 20, 60))
    boxes: list[Placed] = []
    top = 0.0
    for _ in range(draw(st.integers(1, most))):
        width = draw(sides(20, int(width)))
        depth = depth if planar else draw(sides(20, int(depth)))
        size = (width, draw(sides(20, int(min(width, depth)))), depth)
        boxes.append(Placed((-0.5 * width, top, -0.5 * depth), size, density_weight(size)))
        top = boxes[-1].top
    return built("cartons", boxes)


@st.composite
def columns(draw: DrawFn, *, most: int = 4) -> Layout:
    """Boxes of 20 to 60 cm on each other, each with all of its base on the one below; one density.

    Heights are 5 to 60 cm; centres of mass lie up to a tenth of a side aside from the middle.
    """
    shares = st.integers(-10, 10).map(lambda percent: percent / 100.0)
    (x, y, z), (width, depth) = (0.0, 0.0, 0.0), (60.0, 60.0)
    boxes: list[Placed] = []
    for _ in range(draw(st.integers(1, most))):
        size = (draw(sides(20, int(width))), draw(sides(5, 60)), draw(sides(20, int(depth))))
        x += draw(st.integers(0, int(width - size[0])))
        z += draw(st.integers(0, int(depth - size[2])))
        offset = (draw(shares) * size[0], 0.0, draw(shares) * size[2])
        boxes.append(Placed((x, y, z), size, density_weight(size), offset))
        y, width, depth = boxes[-1].top, size[0], size[2]
    return built("column", boxes)


@st.composite
def overhanging_stacks(draw: DrawFn, *, most: int = 5, planar: bool = False) -> Layout:
    """Items standing on each other, each shifted so that it still touches the one below."""
    boxes: list[Placed] = []
    for level in range(draw(st.integers(2, most))):
        size = (draw(sides()), draw(sides(2, 30)), draw(_depths(planar)))
        position = (0.0, 0.0, 0.0)
        if level:
            below = boxes[-1]
            x, z = below.position[0], below.position[2]
            shift_x = draw(_shift(size[0], below.size[0]))
            shift_z = 0.0 if planar else draw(_shift(size[2], below.size[2]))
            position = (x + shift_x, below.top, z + shift_z)
        boxes.append(Placed(position, size, density_weight(size)))
    return built("overhanging", boxes)


def _shift(side: float, below: float) -> SearchStrategy[float]:
    """Shifts that leave 1 cm or more of contact."""
    return st.integers(1 - int(side), int(below) - 1).map(float)


@st.composite
def walls(draw: DrawFn, *, planar: bool = False) -> Layout:
    """Courses of equal bricks without gaps, the upper ones perhaps shifted by half a brick.

    Of a single column nothing is left of a shifted course, and the brick above it hovers.
    """
    columns, courses = draw(st.integers(1, 3)), draw(st.integers(1, 3))
    half = draw(st.booleans())
    width, height, depth = draw(sides(2, 20)) * 2.0, draw(sides(2, 20)), draw(_depths(planar))
    size = (width, height, depth)
    boxes = []
    for course in range(courses):
        shifted = half and course % 2 == 1
        for column in range(columns - shifted):
            x = width * (column + 0.5 * shifted)
            boxes.append(Placed((x, height * course, 0.0), size, density_weight(size)))
    return built("wall", boxes)


@st.composite
def bridges(draw: DrawFn, *, planar: bool = False) -> Layout:
    """A beam over two supports of equal height, and perhaps an item on the beam."""
    height, depth = draw(sides(2, 30)), draw(_depths(planar))
    left, right, gap = draw(sides(2, 20)), draw(sides(2, 20)), draw(sides(1, 30))
    supports = [
        Placed((x, 0.0, 0.0), (width, height, depth), density_weight((width, height, depth)))
        for x, width in ((0.0, left), (left + gap, right))
    ]
    start = draw(st.integers(0, int(left) - 1).map(float))
    rests = draw(st.integers(1, int(right)).map(float))
    size = (left + gap + rests - start, draw(sides(1, 20)), depth)
    boxes = [*supports, Placed((start, height, 0.0), size, density_weight(size))]
    if draw(st.booleans()):
        load = (draw(sides(1, 20)), draw(sides(1, 20)), depth)
        x = start + draw(st.integers(0, int(size[0]) - 1))
        boxes.append(Placed((x, boxes[-1].top, 0.0), load, density_weight(load)))
    return built("bridge", boxes)


@st.composite
def packings(draw: DrawFn, *, most: int = 6) -> Layout:
    """Layouts that the project's packer makes of drawn items; never planar."""
    item_class = ITEM_CLASSES[draw(st.sampled_from(sorted(ITEM_CLASSES)))]
    side = sides(1, item_class.longest_side)
    sizes = draw(st.lists(st.tuples(side, side, side), min_size=1, max_size=most))
    rule = draw(st.sampled_from(sorted(SPACE_RULES)))
    layout = pack("packing", item_class.pallet, sizes, rule, most_items=most)
    assert layout is not None, "the first item fits an empty pallet"
    return layout


@st.composite
def extreme_sizes(draw: DrawFn, *, planar: bool = False) -> Layout:
    """One to three cubes of equal size on each other, from 0.1 cm to 10 m."""
    side = draw(st.sampled_from((1.0, 10.0, 0.1, 100.0, 1000.0)))
    count = draw(st.integers(1, 3))
    size = (side, side, float(_DEPTH) if planar else side)
    boxes = [Placed((0.0, level * side, 0.0), size, density_weight(size)) for level in range(count)]
    return built("extreme", boxes)


@st.composite
def thin_plates(draw: DrawFn, *, planar: bool = False) -> Layout:
    """Plates of 1 cm on each other, each shifted against the one below."""
    side = float(draw(st.integers(20, 100)))
    depth = float(_DEPTH) if planar else side
    size = (side, 1.0, depth)
    x, boxes = 0.0, []
    for level in range(draw(st.integers(1, 4))):
        if level:
            x += draw(st.integers(1 - int(side), int(side) - 1))
        boxes.append(Placed((x, float(level), 0.0), size, density_weight(size)))
    return built("plates", boxes)


@st.composite
def mass_ratios(draw: DrawFn, *, most: float = 1e6, planar: bool = False) -> Layout:
    """A cube on a cube of another weight, up to ``most`` times as heavy or as light."""
    exponents = st.integers(0, 6).filter(lambda exponent: 10.0**exponent <= most)
    ratio = 10.0 ** draw(exponents)
    heavy_on_light = draw(st.booleans())
    side = draw(sides(2, 40))
    size = (side, side, float(_DEPTH) if planar else side)
    # Both away from what such a size weighs, so that neither is out of this world by itself.
    light, heavy = (density_weight(size) * ratio**power for power in (-0.5, 0.5))
    lower, upper = (light, heavy) if heavy_on_light else (heavy, light)
    return built(
        "masses",
        [Placed((0.0, 0.0, 0.0), size, lower), Placed((0.0, side, 0.0), size, upper)],
    )


@st.composite
def with_offsets(
    draw: DrawFn,
    layouts: SearchStrategy[Layout],
    *,
    scenario: Scenario = Scenario.S2B,
    planar: bool = False,
) -> Layout:
    """Layouts with centres of mass as a scenario has them.

    S2b draws every share of a side, in per cent, and so shrinks towards the middle; S2a draws the
    scenario's seed.
    """
    layout = draw(layouts)
    if scenario is Scenario.S2B:
        shares = st.integers(-_PERCENT, _PERCENT).map(lambda percent: percent / 100.0)
        drawn = [[draw(shares) * side for side in item.size] for item in layout.items]
        layout = layout.with_mass_offsets(np.array(drawn))
    else:
        layout = apply_scenario(layout, scenario, draw(st.integers(0, 10_000)))
    if planar:
        offsets = layout.mass_offsets.copy()
        offsets[:, 2] = 0.0
        layout = layout.with_mass_offsets(offsets)
    return layout


def ordinary_layouts(*, planar: bool = False) -> SearchStrategy[Layout]:
    """Towers, overhanging stacks, walls, bridges and packings, in all scenarios."""
    shapes = [
        towers(planar=planar),
        overhanging_stacks(planar=planar),
        walls(planar=planar),
        bridges(planar=planar),
    ]
    if not planar:
        shapes.append(packings())
    plain = st.one_of(shapes)
    return st.one_of(
        plain,
        with_offsets(plain, scenario=Scenario.S2A, planar=planar),
        with_offsets(plain, scenario=Scenario.S2B, planar=planar),
    )


def layouts(*, planar: bool = False) -> SearchStrategy[Layout]:
    """Everything: ordinary layouts, extreme sizes, thin plates and mass ratios."""
    return st.one_of(
        single_items(planar=planar),
        ordinary_layouts(planar=planar),
        thin_plates(planar=planar),
        mass_ratios(planar=planar),
        extreme_sizes(planar=planar),
    )

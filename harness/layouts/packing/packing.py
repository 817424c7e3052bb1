"""Packing boxes into empty maximal spaces, without any stability rule.

An item stands in the corner of the space it is given, overhanging or even unsupported, as in the
paper's sub-dataset 2: layouts made with a stability rule would favour methods that resemble it.

:func:`pack_instance` and :func:`generate` pack with the 160 heuristics of the labelled
data set, several bins an instance. :func:`pack` is a simpler rule for one bin, and
:func:`random_layouts` draws layouts from it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from itertools import islice, permutations

import numpy as np

from steadyload.errors import UserError
from steadyload.layouts.model.layout import Item, Layout, Pallet, Vector
from steadyload.layouts.model.scenarios import Scenario, apply_scenario
from steadyload.layouts.packing.heuristics import (
    HEURISTICS,
    BinRule,
    Heuristic,
    Packer,
    layout_corners,
    pack_bins,
)
from steadyload.layouts.packing.spaces import Space, volume, without

DENSITY = 250.0
"""kg/m3. The paper's weights are proportional to volume; it names no density."""

MOST_ITEMS = 20
"""A layout of the data set holds at most the first 20 items of a bin."""


class PackingError(UserError):
    """An invalid instance: quotes the value and says what is allowed."""


class WeightRule(StrEnum):
    """Rule for the weights of items.

    ``PAPER``: proportional to its volume, :data:`DENSITY`. ``AUTHORS``: as in the authors' code,
    the square root of the volume [cm3], rounded to hundredths, then up to the next 10 kg.
    """

    PAPER = "paper"
    AUTHORS = "authors"


def weigh(size: Vector, rule: WeightRule) -> float:
    """Weight [kg] of an item of a size [cm]."""
    cubic = size[0] * size[1] * size[2]
    if rule is WeightRule.PAPER:
        return DENSITY * 1e-6 * cubic
    return 10.0 * math.ceil(round(math.sqrt(cubic), 2) / 10.0)


@dataclass(frozen=True, slots=True)
class ItemClass:
    """A class of items of the paper (Section 5.1).

    Args:
        pallet: the bin.
        longest_side: sides are whole numbers from 1 to this [cm].
        item_count: items of an instance. The paper does not say how many; the file names of the
            published data set show one bin an instance, rarely two, in classes 1 and 2, and 9 to 19
            in class 3. These counts give about as many.
    """

    pallet: Pallet
    longest_side: int
    item_count: int


ITEM_CLASSES: Mapping[int, ItemClass] = {
    1: ItemClass(Pallet(30.0, 30.0, 30.0), 10, 115),
    2: ItemClass(Pallet(100.0, 100.0, 100.0), 35, 105),
    3: ItemClass(Pallet(100.0, 100.0, 100.0), 100, 64),
}

_FEWEST, _MOST, _OFFERED = 3, 20, 40
_FROM_THE_BOTTOM = 0.75

SPACE_RULES: Mapping[str, Callable[[Space], tuple[float, ...]]] = {
    "back-bottom-left": lambda s: (s[2], s[1], s[0]),
    "left-back-bottom": lambda s: (s[0], s[2], s[1]),
    "bottom-back-left": lambda s: (s[1], s[2], s[0]),
    "smallest-volume": lambda s: (volume(s), s[2], s[1], s[0]),
}
"""Which space an item of :func:`pack` tries first: the one with the smallest key."""


@dataclass(frozen=True, slots=True)
class Instance:
    """Items to be packed, in the order in which they come.

    Args:
        class_number: a key of :data:`ITEM_CLASSES`.
        number: which instance of the class, 0 or more.
        sizes: width, height, depth of every item [cm].
        planar: items span the bins' full depth and are turned in the plane of width and height
            alone, so that every layout is a planar scene.
    """

    class_number: int
    number: int
    sizes: tuple[Vector, ...]
    planar: bool = False

    @property
    def name(self) -> str:
        """Names the item list: ``Class_3_Instance_0``, ``Planar_Class_3_Instance_0``."""
        kind = "Planar_" if self.planar else ""
        return f"{kind}Class_{self.class_number}_Instance_{self.number}"

    @property
    def pallet(self) -> Pallet:
        """The bins' size."""
        return ITEM_CLASSES[self.class_number].pallet


@dataclass(frozen=True, slots=True)
class PackedLayout:
    """A layout and everything that packs it.

    Args:
        layout: named by the first of ``sources``.
        sources: names as of :func:`pack_instance`, of all heuristics, bins and instances that give
            this geometry.
    """

    layout: Layout
    sources: tuple[str, ...]


def make_instance(
    class_number: int,
    number: int,
    *,
    seed: int,
    item_count: int | None = None,
    planar: bool = False,
) -> Instance:
    """Draw an instance. It depends on these arguments alone, not on what else is drawn.

    Args:
        class_number: a key of :data:`ITEM_CLASSES`.
        number: which instance of the class, 0 or more.
        seed: root of all instances, 0 or more.
        item_count: None takes the class's; more items begin with the same ones.
        planar: the same widths and heights, every item stretched to the bins' full depth; see
            :class:`Instance`.

    Raises:
        PackingError: no such class, number or seed, or no item.
    """
    if class_number not in ITEM_CLASSES:
        allowed = ", ".join(map(str, ITEM_CLASSES))
        raise PackingError(f"item class is {class_number!r}; allowed: {allowed}")
    item_class = ITEM_CLASSES[class_number]
    count = item_class.item_count if item_count is None else item_count
    for what, value, least in (("number", number, 0), ("seed", seed, 0), ("item count", count, 1)):
        if value < least:
            raise PackingError(f"{what} is {value!r}; allowed: {least} or more")
    sequence = np.random.SeedSequence(seed, spawn_key=(class_number, number))
    sizes = random_item_list(item_class, count, np.random.default_rng(sequence))
    if planar:
        sizes = [(width, height, item_class.pallet.depth) for width, height, _ in sizes]
    return Instance(class_number, number, tuple(sizes), planar)


def pack_instance(
    instance: Instance, heuristic: Heuristic, *, weights: WeightRule = WeightRule.PAPER
) -> list[Layout]:
    """Pack an instance into as many bins as it takes.

    Returns:
        A layout a bin, in the order of opening, each cut after its first :data:`MOST_ITEMS` items;
        named as the files of the published data set are, bins counted from 0:
        ``H1_Class_3_Instance_0_ULD_0``.
    """
    bins = pack_bins(instance.pallet.size, instance.sizes, heuristic, planar=instance.planar)
    return [
        _layout(source_name(heuristic, instance, which), instance, boxes, weights)
        for which, boxes in enumerate(bins)
    ]


def source_name(heuristic: Heuristic, instance: Instance, which: int) -> str:
    """The name of a bin's layout; see :func:`pack_instance`."""
    return f"H{heuristic.number}_{instance.name}_ULD_{which}"


def generate(
    instances: Iterable[Instance],
    *,
    heuristics: Sequence[Heuristic] = HEURISTICS,
    weights: WeightRule = WeightRule.PAPER,
) -> list[PackedLayout]:
    """Pack instances with many heuristics and keep every geometry once.

    The result is that of :func:`pack_instance` for all of them, with less work: heuristics that
    differ in the bin rule alone agree until there are two bins to choose from.

    Args:
        instances: in the order wanted.
        heuristics: in the order wanted; each once.
        weights: how heavy items are.

    Returns:
        In the order in which the geometries first come up: by instance, heuristic, bin.
    """
    made: dict[str, Layout] = {}
    sources: dict[str, list[str]] = {}
    for instance in instances:
        hashes: dict[tuple[Space, ...], str] = {}
        packed = _packed(instance, heuristics)
        for heuristic in heuristics:
            for which, boxes in enumerate(packed[heuristic]):
                name, key = source_name(heuristic, instance, which), tuple(boxes[:MOST_ITEMS])
                if key not in hashes:
                    layout = _layout(name, instance, boxes, weights)
                    hashes[key] = layout.geometry_hash()
                    made.setdefault(hashes[key], layout)
                sources.setdefault(hashes[key], []).append(name)
    return [PackedLayout(layout, tuple(sources[key])) for key, layout in made.items()]


def _packed(
    instance: Instance, heuristics: Sequence[Heuristic]
) -> dict[Heuristic, list[list[Space]]]:
    """The bins of every heuristic."""
    packed: dict[Heuristic, list[list[Space]]] = {}
    for space, placement in dict.fromkeys((h.space, h.placement) for h in heuristics):
        first = Heuristic(BinRule.FIRST, space, placement)
        packer = Packer(instance.pallet.size, first, planar=instance.planar)
        ahead = iter(instance.sizes)
        for size in ahead:
            packer.add(size)
            if len(packer.bins) > 1:
                break
        rest = list(ahead)
        for heuristic in heuristics:
            if (heuristic.space, heuristic.placement) == (space, placement):
                copy = packer.forked(heuristic.bins)
                for size in rest:
                    copy.add(size)
                packed[heuristic] = copy.bins
    return packed


def _layout(name: str, instance: Instance, boxes: Sequence[Space], weights: WeightRule) -> Layout:
    items = [packed_item(k, box, weights) for k, box in enumerate(boxes[:MOST_ITEMS])]
    return Layout(name, instance.pallet, tuple(items))


def packed_item(sequence: int, box: Space, weights: WeightRule = WeightRule.PAPER) -> Item:
    """A box along the rule axes as an item."""
    position, size = layout_corners(box)
    return Item(sequence, position, size, weigh(size, weights))


def random_item_list(
    item_class: ItemClass, count: int, random: np.random.Generator
) -> list[Vector]:
    """Sizes of ``count`` items [cm], every side uniform on 1 to the class's longest side."""
    sides = random.integers(1, item_class.longest_side + 1, (count, 3))
    return [(float(a), float(b), float(c)) for a, b, c in sides.tolist()]


def pack(
    name: str,
    pallet: Pallet,
    sizes: Sequence[Vector],
    rule: str,
    *,
    most_items: int = 20,
    least_support: float = 0.0,
    accept: Callable[[Item], bool] | None = None,
) -> Layout | None:
    """Pack items in the given order; what fits nowhere is left out.

    An item goes into the first space, in the order of ``rule``, that holds it in one of its six
    orientations; there it takes the orientation that leaves the smallest margin along one axis.

    Args:
        name: the layout's name.
        pallet: the contour.
        sizes: width, height, depth of every item [cm].
        rule: a key of :data:`SPACE_RULES`.
        most_items: stop at this many.
        least_support: leave out spaces in which less than this share of the base would rest on
            something; 0, the default, asks for nothing.
        accept: called for every item at the place it would get: may it stand there? None
            accepts all.

    Returns:
        The layout, or None when no item fits.
    """
    key = SPACE_RULES[rule]
    spaces: list[Space] = [(0.0, 0.0, 0.0, *pallet.size)]
    items: list[Item] = []

    def accepted(corner: Vector, oriented: Vector) -> bool:
        if least_support and _support(items, corner, oriented) < least_support:
            return False
        # In this order of the factors: published layouts hold the last bit it gives.
        weight = DENSITY * 1e-6 * oriented[0] * oriented[1] * oriented[2]
        item = Item(len(items), corner, oriented, weight)
        if accept is not None and not accept(item):
            return False
        items.append(item)
        return True

    for size in sizes:
        if len(items) == most_items:
            break
        # Ties go to the space that sorts first, so that a layout does not depend on hashing.
        ordered = sorted(spaces, key=lambda s: (key(s), s))
        placed = _first_fit(ordered, size, accepted)
        if placed is None:
            continue
        corner, oriented = placed
        x, y, z = (corner[axis] + oriented[axis] for axis in range(3))
        spaces = without((*corner, x, y, z), spaces)
    return Layout(name, pallet, tuple(items)) if items else None


def random_layouts(count: int, seed: int, *, scenario: Scenario | None = None) -> list[Layout]:
    """The first ``count`` of :func:`drawn_layouts`."""
    return list(islice(drawn_layouts(seed, scenario=scenario), count))


def drawn_layouts(seed: int, *, scenario: Scenario | None = None) -> Iterator[Layout]:
    """Layouts to compare methods on, without end: 3 to 20 items, the three classes in turn.

    Three of four are packed from the bottom up, the fourth by one of the other rules; about three
    quarters of them can be loaded, as in the paper's natural set. No two are equal.

    Args:
        seed: the same seed gives the same layouts.
        scenario: where the centres of mass lie; None takes the three scenarios in turn.
    """
    random = np.random.default_rng(np.random.SeedSequence(seed))
    number = 0
    hashes: set[str] = set()
    while True:
        item_class = ITEM_CLASSES[1 + number % len(ITEM_CLASSES)]
        sizes = random_item_list(item_class, _OFFERED, random)
        most = int(random.integers(_FEWEST, _MOST + 1))
        upright = "bottom-back-left" if random.random() < _FROM_THE_BOTTOM else None
        rule = upright or list(SPACE_RULES)[random.integers(len(SPACE_RULES))]
        layout = pack(f"layout-{number:04d}", item_class.pallet, sizes, rule, most_items=most)
        if layout is None or len(layout) < _FEWEST or layout.geometry_hash() in hashes:
            continue
        hashes.add(layout.geometry_hash())
        which = scenario or list(Scenario)[number // len(ITEM_CLASSES) % len(Scenario)]
        yield apply_scenario(layout, which, seed)
        number += 1


def _first_fit(
    spaces: Sequence[Space], size: Vector, accept: Callable[[Vector, Vector], bool]
) -> tuple[Vector, Vector] | None:
    orientations = [(a, b, c) for a, b, c in sorted(set(permutations(size)))]
    for space in spaces:
        low, high = space[:3], space[3:]
        room = [high[axis] - low[axis] for axis in range(3)]
        fitting = [o for o in orientations if all(o[a] <= room[a] for a in range(3))]
        if fitting:
            best = min(fitting, key=lambda o: (min(room[a] - o[a] for a in range(3)), o))
            if accept(low, best):
                return low, best
    return None


def _support(items: Sequence[Item], corner: Vector, size: Vector) -> float:
    """Share of a base that rests on the floor or on tops of items."""
    x, y, z = corner
    if y == 0.0:
        return 1.0
    area = 0.0
    for item in items:
        (a, b, c), (width, height, depth) = item.position, item.size
        if b + height == y:
            along_x = min(a + width, x + size[0]) - max(a, x)
            along_z = min(c + depth, z + size[2]) - max(c, z)
            area += max(0.0, along_x) * max(0.0, along_z)
    return area / (size[0] * size[2])


def random_boxes(
    name: str, count: int, pallet: Pallet, rule: str, *, seed: int, support: float
) -> Layout:
    """Boxes with sides of 5 to 25 cm, packed by a rule.

    Args:
        name: of the layout.
        count: number of boxes; a larger number starts with the same boxes.
        pallet: holds them all.
        rule: a key of :data:`steadyload.layouts.packing.packing.SPACE_RULES`.
        seed: of their sizes.
        support: share of every base that is supported, 0 to 1.
    """
    random = np.random.default_rng(np.random.SeedSequence(seed))
    sides = random.integers(5, 26, (20 * count, 3)).tolist()
    sizes = [(float(a), float(b), float(c)) for a, b, c in sides]
    layout = pack(name, pallet, sizes, rule, most_items=count, least_support=support)
    assert layout is not None
    assert len(layout) == count, "the pallet holds all"
    return layout

"""Packing boxes into empty maximal spaces, without any stability rule.

An item stands in the corner of the space it is given, overhanging or even unsupported, as in the
paper's sub-dataset 2: layouts made with a stability rule would favour methods that resemble it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import permutations

import numpy as np

from harness.layouts.model import Item, Layout, Pallet, Vector
from harness.layouts.scenarios import Scenario, apply_scenario

DENSITY = 250.0
"""kg/m3. The paper's weights are proportional to volume; it names no density."""


@dataclass(frozen=True, slots=True)
class ItemClass:
    """A class of items of the paper (Section 5.1): whole-number sides [cm] and their pallet."""

    pallet: Pallet
    longest_side: int


ITEM_CLASSES: Mapping[int, ItemClass] = {
    1: ItemClass(Pallet(30.0, 30.0, 30.0), 10),
    2: ItemClass(Pallet(100.0, 100.0, 100.0), 35),
    3: ItemClass(Pallet(100.0, 100.0, 100.0), 100),
}

_FEWEST, _MOST, _OFFERED = 3, 20, 40
_FROM_THE_BOTTOM = 0.75

_Space = tuple[Vector, Vector]
"""Lower and upper corner of an empty space (x, y, z) [cm]."""

SPACE_RULES: Mapping[str, Callable[[_Space], tuple[float, ...]]] = {
    "back-bottom-left": lambda s: (s[0][2], s[0][1], s[0][0]),
    "left-back-bottom": lambda s: (s[0][0], s[0][2], s[0][1]),
    "bottom-back-left": lambda s: (s[0][1], s[0][2], s[0][0]),
    "smallest-volume": lambda s: (_volume(s), s[0][2], s[0][1], s[0][0]),
}
"""Which space an item tries first: the one with the smallest key."""


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

    Returns:
        The layout, or None when no item fits.
    """
    key = SPACE_RULES[rule]
    spaces: list[_Space] = [((0.0, 0.0, 0.0), pallet.size)]
    items: list[Item] = []

    def rests(corner: Vector, oriented: Vector) -> bool:
        return not least_support or _support(items, corner, oriented) >= least_support

    for size in sizes:
        if len(items) == most_items:
            break
        # Ties go to the space that sorts first, so that a layout does not depend on hashing.
        ordered = sorted(spaces, key=lambda s: (key(s), s))
        placed = _first_fit(ordered, size, rests)
        if placed is None:
            continue
        corner, oriented = placed
        weight = DENSITY * 1e-6 * oriented[0] * oriented[1] * oriented[2]
        items.append(Item(len(items), corner, oriented, weight))
        x, y, z = (corner[axis] + oriented[axis] for axis in range(3))
        spaces = _without((corner, (x, y, z)), spaces)
    return Layout(name, pallet, tuple(items)) if items else None


def random_layouts(count: int, seed: int, *, scenario: Scenario | None = None) -> list[Layout]:
    """Layouts to compare methods on: 3 to 20 items, the three classes in turn.

    Three of four are packed from the bottom up, the fourth by one of the other rules; about three
    quarters of them can be loaded, as in the paper's natural set.

    Args:
        count: how many; no two are equal.
        seed: the same seed gives the same layouts, and more of them start with fewer.
        scenario: where the centres of mass lie; None takes the three scenarios in turn.
    """
    random = np.random.default_rng(np.random.SeedSequence(seed))
    layouts: list[Layout] = []
    hashes: set[str] = set()
    while len(layouts) < count:
        number = len(layouts)
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
        layouts.append(apply_scenario(layout, which, seed))
    return layouts


def _first_fit(
    spaces: Sequence[_Space], size: Vector, accept: Callable[[Vector, Vector], bool]
) -> tuple[Vector, Vector] | None:
    orientations = [(a, b, c) for a, b, c in sorted(set(permutations(size)))]
    for low, high in spaces:
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


def _without(box: _Space, spaces: Sequence[_Space]) -> list[_Space]:
    """Cut a box out of all spaces (difference) and drop those inside another (elimination).

    Only what was cut can lie inside another: the spaces that the box does not touch were maximal
    before, and a part of a space contains none of them.
    """
    whole: list[_Space] = []
    parts: set[_Space] = set()
    for space in spaces:
        cut = _difference(space, box)
        if cut is None:
            whole.append(space)
        else:
            parts.update(cut)
    if not parts:
        return whole
    new = sorted(parts)
    corners = np.array(whole + new)
    low, high = corners[:, 0], corners[:, 1]
    start = len(whole)
    inside = (low[None] <= low[start:, None]).all(axis=2)
    inside &= (high[start:, None] <= high[None]).all(axis=2)
    maximal = inside.sum(axis=1) == 1  # itself
    return whole + [space for space, keep in zip(new, maximal, strict=True) if keep]


def _difference(space: _Space, box: _Space) -> list[_Space] | None:
    """What a box leaves of a space, as maximal parts; None when it does not reach into it."""
    (low, high), (box_low, box_high) = space, box
    if any(box_high[a] <= low[a] or box_low[a] >= high[a] for a in range(3)):
        return None
    parts: list[_Space] = []
    for axis in range(3):
        if box_low[axis] > low[axis]:
            parts.append((low, _replaced(high, axis, box_low[axis])))
        if box_high[axis] < high[axis]:
            parts.append((_replaced(low, axis, box_high[axis]), high))
    return parts


def _replaced(point: Vector, axis: int, value: float) -> Vector:
    values = list(point)
    values[axis] = value
    return (values[0], values[1], values[2])


def _volume(space: _Space) -> float:
    (x0, y0, z0), (x1, y1, z1) = space
    return (x1 - x0) * (y1 - y0) * (z1 - z0)

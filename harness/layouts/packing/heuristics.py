"""The 160 online packing heuristics: 4 bin rules x 8 space rules x 5 placement rules.

After Ali, Ramos, Carravilla and Oliveira (Applied Soft Computing 151, 2024, 111168), as the paper
uses them for its sub-dataset 2: items come one by one, are never moved again, and no stability rule
takes part. The rules were not at hand in their original wording; the docstrings below say how each
is read.

Rule axes: x is the depth from the back, y the width from the left, z is up, and a space's corner
(x1, y1, z1) is its back-left-bottom one. :func:`sizes_by_rule_axes` and :func:`layout_corners` are
the only places that change axes.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from enum import IntEnum, StrEnum
from itertools import permutations

from steadyload.errors import UserError
from steadyload.layouts.model.layout import Vector
from steadyload.layouts.packing.spaces import Space, volume, without

SPACES_COMPARED = 3
"""How many spaces the placement rules 4 and 5 look at: the first that hold the item."""


class HeuristicError(UserError):
    """A heuristic that does not exist."""


class BinRule(StrEnum):
    """Rule for the open bin an item goes to; when none holds it, a new one opens.

    The first three rules try the bins one after the other, in an order, until one holds the item:
    as they were opened (``FIRST``), the largest packed volume first (``BEST``), the smallest first
    (``WORST``); ties go to the bin opened first. ``ALL`` looks at the spaces of all open bins at
    once, so that the space rule and the placement rule choose the bin.
    """

    FIRST = "F"
    WORST = "W"
    BEST = "B"
    ALL = "A"


class SpaceRule(IntEnum):
    """Rule for the space tried first; ties go to the bin, then to the space, that was made first.

    1. smallest x1, then z1, then y1;
    2. smallest coordinates of the corner, sorted, compared one by one;
    3. smallest z1, then the smaller of x1 and y1, then the larger;
    4. smallest volume;
    5. smallest x1, then z1, then the distance to the nearest corner;
    6. smallest distance to the nearest corner, then the largest volume;
    7. smallest distance to the nearest corner, then the smallest volume;
    8. largest distance of (x1, y1, z1) from the bin's front-right-top corner.

    The corners of rules 5 to 7 are the bin's back-left-bottom and back-right-bottom one, each
    measured from the space's own corner of that name. Where the right one is nearer, the item
    stands in the space's back-right-bottom corner; everywhere else in the back-left-bottom one.
    """

    BACK = 1
    NEAR_ORIGIN = 2
    BOTTOM = 3
    SMALLEST = 4
    BACK_CORNER = 5
    CORNER_LARGEST = 6
    CORNER_SMALLEST = 7
    FAR_FROM_FRONT = 8


class PlacementRule(IntEnum):
    """Rule for the orientation of an item, and for the space it goes to.

    Rules 1 to 3 take the first space that holds the item, and there:

    1. the orientation with the smallest margin between a face of the item and the space's; ties are
       broken by the second smallest, then by the third (the sum of the three is always the same);
    2. the largest base, then the smallest extent along x;
    3. the largest base, then the largest extent along x.

    Rules 4 and 5 compare the first :data:`SPACES_COMPARED` spaces that hold the item:

    4. in each the orientation of rule 1; of these the space that the item fills best;
    5. the space and orientation with the largest distance between the item's front-right-top corner
       and the bin's.

    Remaining ties go to the earlier space, then to the smaller extents along x, y, z.
    """

    SMALLEST_MARGIN = 1
    BASE_THEN_SHALLOW = 2
    BASE_THEN_DEEP = 3
    BEST_FILL = 4
    FAR_FROM_FRONT = 5


@dataclass(frozen=True, slots=True)
class Heuristic:
    """One of the 160.

    ``number`` counts from 1: 40 for each bin rule, in the order first, worst, best, all; in it 8
    for each placement rule; in it the space rules. The order is read off the number of bins by
    heuristic in the file names of the published data set: periods of 8 in blocks of 40, of which
    the second needs the most bins, as worst fit does. It is likely, not known; whether first or
    best fit comes first is open.
    """

    bins: BinRule
    space: SpaceRule
    placement: PlacementRule

    @classmethod
    def numbered(cls, number: int) -> Heuristic:
        """The heuristic with a number.

        Raises:
            HeuristicError: no whole number from 1 to 160.
        """
        if type(number) is not int or not 1 <= number <= 160:
            raise HeuristicError(f"heuristic {number!r}; allowed: 1 to 160")
        block, rest = divmod(number - 1, 40)
        return cls(list(BinRule)[block], SpaceRule(rest % 8 + 1), PlacementRule(rest // 8 + 1))

    @property
    def number(self) -> int:
        """1 to 160."""
        return 40 * list(BinRule).index(self.bins) + 8 * (self.placement - 1) + self.space

    @property
    def name(self) -> str:
        """Letter of the bin rule, number of the space rule, number of the placement rule: F13."""
        return f"{self.bins}{self.space:d}{self.placement:d}"


HEURISTICS = tuple(map(Heuristic.numbered, range(1, 161)))

_Size = tuple[float, float, float]
"""Extents along the rule axes [cm]."""

_Preference = Callable[[Space], tuple[float, ...]]
"""Of a box in a space: the orientation with the smallest value is taken."""

Accept = Callable[[int, Space], bool]
"""Whether a box may be packed: the number of its bin, counted from 0, and the box along the rule
axes. What is accepted is packed."""

_Entry = tuple[tuple[float, ...], int, int, Space]
"""A space as it is sorted: key, bin, number of creation, the space."""


def sizes_by_rule_axes(size: Vector) -> _Size:
    """Depth, width, height of a layout's width, height, depth."""
    width, height, depth = size
    return (depth, width, height)


def layout_corners(box: Space) -> tuple[Vector, Vector]:
    """A box along the rule axes as a layout's position and size (x width, y up, z depth)."""
    x0, y0, z0, x1, y1, z1 = box
    return (y0, z0, x0), (y1 - y0, z1 - z0, x1 - x0)


def orientations(item: Vector, *, planar: bool = False) -> list[_Size]:
    """Orientations of an item of a width, height, depth [cm], as extents along the rule axes.

    Args:
        item: its sides.
        planar: its depth stays the depth: it is turned in the plane of width and height alone.
    """
    if not planar:
        return sorted({(a, b, c) for a, b, c in permutations(item)})
    width, height, depth = item
    return sorted({(depth, width, height), (depth, height, width)})


def pack_bins(
    size: Vector,
    items: Iterable[Vector],
    heuristic: Heuristic,
    *,
    planar: bool = False,
    accept: Accept | None = None,
) -> list[list[Space]]:
    """Pack items in their order into as many bins as it takes.

    A place is refused where the item would come to carry one that was packed before it, its top
    face against the other's underside: items are loaded in this order, and a supporter comes first.

    Args:
        size: width, height, depth of a bin [cm].
        items: width, height, depth [cm]; each fits into an empty bin.
        heuristic: the rules.
        planar: as in :func:`orientations`.
        accept: called for every place before it is taken, the one that the rules want first, then
            what they want without that; an item without a place even in an empty bin is left out.

    Returns:
        By bin, in the order of opening, its items as boxes along the rule axes, in packing order.
    """
    packer = Packer(size, heuristic, planar=planar, accept=accept)
    for item in items:
        packer.add(item)
    return packer.bins


class Packer:
    """Bins while one heuristic fills them; see :func:`pack_bins`."""

    def __init__(
        self,
        size: Vector,
        heuristic: Heuristic,
        *,
        planar: bool = False,
        accept: Accept | None = None,
    ) -> None:
        self.heuristic = heuristic
        self._planar, self._accept = planar, accept
        self.bins: list[list[Space]] = []
        self._size = sizes_by_rule_axes(size)
        self._key = space_key(heuristic.space, self._size)
        self._spaces: list[list[Space]] = []
        self._ordered: list[list[_Entry]] = []
        self._undersides: list[set[float]] = []
        self._packed: list[float] = []
        self._created = 0

    def forked(self, bins: BinRule) -> Packer:
        """A copy that continues with another bin rule."""
        other = Packer.__new__(Packer)
        other.__dict__.update(self.__dict__)
        other.heuristic = Heuristic(bins, self.heuristic.space, self.heuristic.placement)
        other.bins = [list(boxes) for boxes in self.bins]
        other._undersides = [set(heights) for heights in self._undersides]
        # The spaces of a bin are replaced as a whole, never edited.
        other._spaces, other._ordered = list(self._spaces), list(self._ordered)
        other._packed = list(self._packed)
        return other

    def add(self, item: Vector) -> None:
        """Pack the next item: width, height, depth [cm], turned as the rules want it.

        Raises:
            HeuristicError: it does not even fit into an empty bin.
        """
        turned = orientations(item, planar=self._planar)
        for spaces in self._offers():
            if self._take(spaces, turned):
                return
        self._open()
        if self._take(self._ordered[-1], turned):
            return
        if next(self._places(self._ordered[-1], turned), None) is None:
            raise HeuristicError(f"an item of {item} cm; allowed: what fits a bin of {self._size}")
        self._shut()

    def _offers(self) -> Iterable[Sequence[_Entry]]:
        """Spaces to choose from, one list after the other."""
        if len(self._ordered) < 2 or self.heuristic.bins is BinRule.FIRST:
            return self._ordered
        if self.heuristic.bins is BinRule.ALL:
            return (sorted(entry for entries in self._ordered for entry in entries),)
        sign = -1.0 if self.heuristic.bins is BinRule.BEST else 1.0
        order = sorted(range(len(self.bins)), key=lambda which: sign * self._packed[which])
        return (self._ordered[which] for which in order)

    def _open(self) -> None:
        space = (0.0, 0.0, 0.0, *self._size)
        entry = (self._key(space), len(self.bins), self._created, space)
        self._created += 1
        self.bins.append([])
        self._spaces.append([space])
        self._ordered.append([entry])
        self._undersides.append(set())
        self._packed.append(0.0)

    def _shut(self) -> None:
        """Take back the bin that was opened last, and is empty."""
        for values in (self.bins, self._spaces, self._ordered, self._undersides, self._packed):
            values.pop()

    def _take(self, spaces: Iterable[_Entry], turned: Sequence[_Size]) -> bool:
        """Pack a box in the first place that is accepted; whether there was one."""
        for which, box in self._places(spaces, turned):
            if self._accept is None or self._accept(which, box):
                self._put(which, box)
                return True
        return False

    def _put(self, which: int, box: Space) -> None:
        self.bins[which].append(box)
        self._packed[which] += volume(box)
        if box[2] > 0.0:
            self._undersides[which].add(box[2])
        old = self._spaces[which]
        left = without(box, old)
        gone, fresh = set(old).difference(left), []
        # New spaces follow the ones that stay.
        for space in left[len(old) - len(gone) :]:
            fresh.append((self._key(space), which, self._created, space))
            self._created += 1
        entries = [entry for entry in self._ordered[which] if entry[3] not in gone]
        self._spaces[which] = left
        self._ordered[which] = sorted(entries + fresh)

    def _places(
        self, spaces: Iterable[_Entry], turned: Sequence[_Size]
    ) -> Iterator[tuple[int, Space]]:
        """Bins and boxes, the one that the placement rule takes first, then the next best."""
        rule = self.heuristic.placement
        several = rule in (PlacementRule.BEST_FILL, PlacementRule.FAR_FROM_FRONT)
        compared: list[tuple[float, int, Space]] = []
        seen = 0
        for _, which, _, space in spaces:
            x0, y0, z0, x1, y1, z1 = space
            deep, wide, high = x1 - x0, y1 - y0, z1 - z0
            fitting = [o for o in turned if o[0] <= deep and o[1] <= wide and o[2] <= high]
            if not fitting:
                continue
            boxes = self._boxes(which, space, fitting)
            if not boxes:
                continue
            if len(boxes) > 1:
                boxes.sort(key=_PREFERENCE[rule](space, self))
            if not several:
                for box in boxes:
                    yield which, box
                continue
            for box in boxes:
                fill = rule is PlacementRule.BEST_FILL
                compared.append((volume(space) if fill else -self.distance(box), which, box))
            seen += 1
            if seen % SPACES_COMPARED == 0:
                yield from _best_first(compared)
                compared.clear()
        yield from _best_first(compared)

    def _boxes(self, which: int, space: Space, fitting: Sequence[_Size]) -> list[Space]:
        """Boxes that the item would fill in a space, by orientation; refused ones left out."""
        x0, y0, z0, _, y1, _ = space
        right = self.heuristic.space in _CORNER_RULES and self._size[1] - y1 < y0
        boxes: list[Space] = []
        for deep, wide, high in fitting:
            left = y1 - wide if right else y0
            box = (x0, left, z0, x0 + deep, left + wide, z0 + high)
            if box[5] not in self._undersides[which] or not self._carries(which, box):
                boxes.append(box)
        return boxes

    def _carries(self, which: int, box: Space) -> bool:
        x0, y0, _, x1, y1, top = box
        return any(
            other[2] == top and other[0] < x1 and other[3] > x0 and other[1] < y1 and other[4] > y0
            for other in self.bins[which]
        )

    def distance(self, box: Space) -> float:
        """Squared distance of a box's front-right-top corner from the bin's [cm2]."""
        return sum((self._size[axis] - box[3 + axis]) ** 2 for axis in range(3))


def _best_first(places: list[tuple[float, int, Space]]) -> Iterator[tuple[int, Space]]:
    """Places by score, the smallest first; equal ones in their order."""
    for _, which, box in sorted(places, key=lambda place: place[0]):
        yield which, box


def _margins(space: Space, _: Packer) -> _Preference:
    deep, wide, high = space[3] - space[0], space[4] - space[1], space[5] - space[2]
    return lambda b: tuple(sorted((deep - b[3] + b[0], wide - b[4] + b[1], high - b[5] + b[2])))


def _base(sign: float) -> Callable[[Space, Packer], _Preference]:
    return lambda space, packer: (
        lambda b: (
            -(b[3] - b[0]) * (b[4] - b[1]),
            sign * (b[3] - b[0]),
        )
    )


_PREFERENCE: dict[PlacementRule, Callable[[Space, Packer], _Preference]] = {
    PlacementRule.SMALLEST_MARGIN: _margins,
    PlacementRule.BASE_THEN_SHALLOW: _base(1.0),
    PlacementRule.BASE_THEN_DEEP: _base(-1.0),
    PlacementRule.BEST_FILL: _margins,
    PlacementRule.FAR_FROM_FRONT: lambda space, packer: lambda b: (-packer.distance(b),),
}
"""What makes one orientation better than another in a space: the smallest value."""

_CORNER_RULES = frozenset(
    {SpaceRule.BACK_CORNER, SpaceRule.CORNER_LARGEST, SpaceRule.CORNER_SMALLEST}
)


def space_key(rule: SpaceRule, size: _Size) -> Callable[[Space], tuple[float, ...]]:
    """Sorting key of a rule for spaces: the space with the smallest value is tried first."""

    def corner(s: Space) -> float:
        # Both bin corners lie at the back and at the bottom: they differ along y alone.
        return s[0] ** 2 + s[2] ** 2 + min(s[1], size[1] - s[4]) ** 2

    keys: dict[SpaceRule, Callable[[Space], tuple[float, ...]]] = {
        SpaceRule.BACK: lambda s: (s[0], s[2], s[1]),
        SpaceRule.NEAR_ORIGIN: lambda s: tuple(sorted(s[:3])),
        SpaceRule.BOTTOM: lambda s: (s[2], min(s[0], s[1]), max(s[0], s[1])),
        SpaceRule.SMALLEST: lambda s: (volume(s),),
        SpaceRule.BACK_CORNER: lambda s: (s[0], s[2], corner(s)),
        SpaceRule.CORNER_LARGEST: lambda s: (corner(s), -volume(s)),
        SpaceRule.CORNER_SMALLEST: lambda s: (corner(s), volume(s)),
        SpaceRule.FAR_FROM_FRONT: lambda s: (-sum((size[a] - s[a]) ** 2 for a in range(3)),),
    }
    return keys[rule]

"""The packing heuristics by hand, and the spaces they choose from against brute force."""

import itertools

import numpy as np
import pytest

from steadyload.layouts.packing.heuristics import (
    HEURISTICS,
    BinRule,
    Heuristic,
    HeuristicError,
    PlacementRule,
    SpaceRule,
    layout_corners,
    pack_bins,
    sizes_by_rule_axes,
    space_key,
)
from steadyload.layouts.packing.spaces import without


def heuristic(*, bins=BinRule.FIRST, space=1, placement=1):
    return Heuristic(bins, SpaceRule(space), PlacementRule(placement))


def cubes(*sides):
    return [(float(s), float(s), float(s)) for s in sides]


# --- spaces ------------------------------------------------------------------------------------


def overlap(a, b):
    return all(a[k] < b[k + 3] and b[k] < a[k + 3] for k in range(3))


def contains(a, b):
    return all(a[k] <= b[k] and a[k + 3] >= b[k + 3] for k in range(3))


@pytest.mark.parametrize("seed", range(6))
def test_spaces_are_all_the_maximal_ones(seed):
    # Every box of whole numbers in a bin of 4 cm that holds no item and can grow to no side.
    random = np.random.default_rng(seed)
    spans = list(itertools.combinations(range(5), 2))
    boxes = [(x[0], y[0], z[0], x[1], y[1], z[1]) for x in spans for y in spans for z in spans]
    spaces, items = [(0, 0, 0, 4, 4, 4)], []
    for index in random.permutation(len(boxes)):
        box = boxes[index]
        if len(items) < 7 and not any(overlap(box, other) for other in items):
            items.append(box)
            spaces = without(box, spaces)
            empty = [b for b in boxes if not any(overlap(b, other) for other in items)]
            maximal = [b for b in empty if not any(b != c and contains(c, b) for c in empty)]
            assert len(set(spaces)) == len(spaces)
            assert set(spaces) == set(maximal)
    assert len(items) > 2


def test_spaces_keep_their_order_of_creation():
    first = without((0, 0, 0, 2, 2, 2), [(0, 0, 0, 9, 9, 9)])
    assert first == [(2, 0, 0, 9, 9, 9), (0, 2, 0, 9, 9, 9), (0, 0, 2, 9, 9, 9)]
    # The first is cut. The others, of which the last begins where the box ends, stay where they
    # were; the parts follow, without the one upon the box: it lies inside the last.
    second = without((2, 0, 0, 4, 1, 2), first)
    assert second == [
        (0, 2, 0, 9, 9, 9), (0, 0, 2, 9, 9, 9), (4, 0, 0, 9, 9, 9), (2, 1, 0, 9, 9, 9),
    ]  # fmt: skip


# --- numbers -----------------------------------------------------------------------------------


def test_numbers_and_names_belong_to_one_heuristic_each():
    assert [h.number for h in HEURISTICS] == list(range(1, 161))
    assert len({h.name for h in HEURISTICS}) == len(set(HEURISTICS)) == 160
    assert Heuristic.numbered(1).name == "F11"
    assert Heuristic.numbered(8).name == "F81"
    assert Heuristic.numbered(9).name == "F12"
    assert Heuristic.numbered(41).name == "W11"
    assert Heuristic.numbered(160).name == "A85"


@pytest.mark.parametrize("number", [0, 161, 1.0, True])
def test_other_numbers_are_refused(number):
    with pytest.raises(HeuristicError, match="allowed: 1 to 160"):
        Heuristic.numbered(number)


def test_axes_change_there_and_back():
    # Width 2, height 3, depth 4 at the left, bottom, back corner (20, 30, 40).
    deep, wide, high = sizes_by_rule_axes((2.0, 3.0, 4.0))
    box = (40.0, 20.0, 30.0, 40.0 + deep, 20.0 + wide, 30.0 + high)
    assert layout_corners(box) == ((20.0, 30.0, 40.0), (2.0, 3.0, 4.0))


# --- space rules -------------------------------------------------------------------------------

# In a bin of 20 x 20 x 20; (x1, y1, z1, x2, y2, z2), in order of creation.
SPACES = {
    "right corner, middling": (0, 15, 0, 9, 20, 15),  # 675 cm3
    "right corner, large": (0, 14, 0, 20, 20, 20),  # 2400 cm3
    "right corner, small": (0, 16, 0, 5, 20, 9),  # 180 cm3
    "on the back edge": (0, 9, 0, 20, 12, 20),  # 8 from the right corner: the nearer one
    "above the corner": (0, 0, 5, 20, 3, 20),
    "before the corner": (7, 0, 0, 20, 4, 20),
    "near the corner": (1, 1, 1, 20, 20, 18),
    "tiny": (6, 6, 6, 8, 8, 8),
}


@pytest.mark.parametrize(
    ("rule", "expected"),
    [
        (1, "on the back edge"),  # x1 = z1 = 0 four times; 9 is the smallest y1
        (2, "above the corner"),  # (0, 0, 5) before (0, 0, 7) and (0, 0, 9)
        (3, "before the corner"),  # z1 = 0, then (0, 7) before (0, 9)
        (4, "tiny"),  # 8 cm3
        (5, "right corner, middling"),  # x1 = z1 = 0, no distance; the earliest of three
        (6, "right corner, large"),  # no distance; 2400 cm3
        (7, "right corner, small"),  # no distance; 180 cm3
        (8, "near the corner"),  # 3 x 19^2 = 1083; above the corner: 400 + 400 + 225 = 1025
    ],
)
def test_space_rules_by_hand(rule, expected):
    key = space_key(SpaceRule(rule), (20.0, 20.0, 20.0))
    assert min(SPACES, key=lambda name: key(SPACES[name])) == expected


# A bin 12 deep, 11 wide, 10 high with a cube of 6 in its corner leaves, in this order, a space in
# front (660 cm3), one at the right (600 cm3) and one on top (528 cm3). Where does a cube of 4 go?
FRONT, RIGHT, FAR_RIGHT, TOP = (6, 0, 0), (0, 6, 0), (0, 7, 0), (0, 0, 6)


@pytest.mark.parametrize(
    ("rule", "expected"),
    [
        (1, RIGHT),  # x1 = 0 at the right and on top; z1 = 0 at the right
        (2, FRONT),  # (0, 0, 6) three times; the earliest
        (3, FRONT),  # (0, 0, 6) in front and at the right; the earlier
        (4, TOP),  # 528 cm3
        (5, FAR_RIGHT),  # as rule 1; its right corner is the bin's, so the item ends at y = 11
        (6, FAR_RIGHT),  # no distance there, 6 elsewhere
        (7, FAR_RIGHT),
        (8, TOP),  # 144 + 121 + 16 = 281; right 269, front 257
    ],
)
@pytest.mark.parametrize("placement", [1, 2, 3])
def test_items_stand_in_the_corner_of_their_space(rule, expected, placement):
    chosen = heuristic(space=rule, placement=placement)
    (boxes,) = pack_bins((11.0, 10.0, 12.0), cubes(6, 4), chosen)
    assert boxes[1] == (*expected, *(e + 4 for e in expected))


# --- placement rules ---------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("rule", "expected"),
    [
        # Margins: 9 in the height leaves 1; then 6 in the width 6 and 2 in the depth 18.
        (1, (2, 6, 9)),
        (2, (6, 9, 2)),  # the base is 6 x 9, the depth the smaller of them
        (3, (9, 6, 2)),
        (4, (2, 6, 9)),  # one space: as rule 1
        (5, (2, 6, 9)),  # 18^2 + 6^2 + 1^2 = 361; the next, (2, 9, 6): 349
    ],
)
def test_placement_rules_by_hand(rule, expected):
    # A bin 20 deep, 12 wide, 10 high; the item comes as width 9, height 2, depth 6.
    (boxes,) = pack_bins((12.0, 10.0, 20.0), [(9.0, 2.0, 6.0)], heuristic(placement=rule))
    assert boxes == [(0, 0, 0, *expected)]


@pytest.mark.parametrize(
    ("rule", "expected"),
    [
        (1, (0, 5, 0)),  # the first space
        (4, (5, 3, 0)),  # 144 cm3; the others have 256 and 216
        (5, (0, 0, 5)),  # 25 + 36 + 0 = 61; at the right 51, in front 34
    ],
)
def test_rules_over_several_spaces_look_at_three(rule, expected):
    # A bin 8 deep, 9 wide, 8 high, a cube of 5 in the corner and one of 3 before it, by space rule
    # 2. Of the spaces, in this order: at the right (0, 5, 0), on top (0, 0, 5), before the first
    # cube beside the second (5, 3, 0), upon the second (5, 0, 3). The last has but 135 cm3, and is
    # not looked at.
    (boxes,) = pack_bins((9.0, 8.0, 8.0), cubes(5, 3, 3), heuristic(space=2, placement=rule))
    assert boxes[:2] == [(0, 0, 0, 5, 5, 5), (5, 0, 0, 8, 3, 3)]
    assert boxes[2] == (*expected, *(e + 3 for e in expected))


def test_an_item_does_not_slide_below_what_it_would_carry():
    # The plate is too large to stand, lies on the first cube and reaches over 7 cm of floor, where
    # a second cube would fit exactly.
    items = [*cubes(4), (11.0, 1.0, 11.0), *cubes(4, 3)]
    (boxes,) = pack_bins((12.0, 10.0, 12.0), items, heuristic(space=3))
    assert boxes[1] == (0, 0, 4, 11, 11, 5)
    assert boxes[2] == (0, 0, 5, 4, 4, 9)  # on the plate
    assert boxes[3] == (4, 0, 0, 7, 3, 3)  # lower than the plate: allowed


# --- bin rules ---------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("bins", "placement", "expected"),
    [
        (BinRule.FIRST, 1, 0),
        (BinRule.WORST, 1, 0),
        (BinRule.BEST, 1, 1),
        (BinRule.ALL, 1, 0),  # x1 = 5 comes before x1 = 6
        (BinRule.ALL, 4, 1),  # fills 400 of 400 cm3 there, of 500 cm3 here
    ],
)
def test_bin_rules_differ_where_the_second_bin_is_fuller(bins, placement, expected):
    # Plates through the whole bin, 5 and 6 thick, do not fit into one; then one of 4.
    plates = [(10.0, 10.0, 5.0), (10.0, 10.0, 6.0), (10.0, 10.0, 4.0)]
    packed = pack_bins((10.0, 10.0, 10.0), plates, heuristic(bins=bins, placement=placement))
    assert [len(boxes) for boxes in packed] == ([2, 1] if expected == 0 else [1, 2])


@pytest.mark.parametrize(
    ("bins", "expected"), [(BinRule.FIRST, 0), (BinRule.WORST, 1), (BinRule.BEST, 0)]
)
def test_bin_rules_differ_where_the_first_bin_is_fuller(bins, expected):
    plates = [(10.0, 10.0, 6.0), (10.0, 10.0, 5.0), (10.0, 10.0, 4.0)]
    packed = pack_bins((10.0, 10.0, 10.0), plates, heuristic(bins=bins))
    assert len(packed[expected]) == 2


def test_the_next_bin_is_tried_before_one_opens():
    # 3 fits into neither the fullest nor the first bin, but into the second: nothing opens.
    plates = [(10.0, 10.0, 8.0), (10.0, 10.0, 7.0), (10.0, 10.0, 3.0)]
    for bins in BinRule:
        assert len(pack_bins((10.0, 10.0, 10.0), plates, heuristic(bins=bins))) == 2


def test_an_item_larger_than_a_bin_is_refused():
    with pytest.raises(HeuristicError, match=r"allowed: what fits"):
        pack_bins((10.0, 10.0, 10.0), [(11.0, 1.0, 1.0)], heuristic())

"""Layouts refuse what cannot be, and say where and what is allowed."""

import math
from dataclasses import FrozenInstanceError, replace

import numpy as np
import pytest

from steadyload.layouts import Item, Layout, LayoutError, Pallet
from steadyload.layouts.model.floor import INFINITE, Floor, FloorError
from steadyload.layouts.model.layout import TOLERANCE, replace_items

PALLET = Pallet(100.0, 50.0, 100.0)


def item(sequence=0, position=(0.0, 0.0, 0.0), size=(10.0, 10.0, 10.0), weight=1.0, **more):
    return Item(sequence, position, size, weight, **more)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"sequence": -1}, "sequence is -1"),
        ({"sequence": True}, "sequence is True"),
        ({"position": (0, 0)}, "position is (0, 0); allowed: three numbers"),
        ({"weight": "3"}, "weight is '3'; allowed: a number"),
        ({"position": (math.nan, 0.0, 0.0)}, "position x is nan"),
        ({"position": (0.0, math.inf, 0.0)}, "position y is inf"),
        ({"size": (0.0, 10.0, 10.0)}, "width is 0 cm"),
        (
            {"size": (1e-200, 10.0, 10.0)},
            "width is 1e-200 cm; allowed: a positive",
        ),
        ({"size": (1e308, 10.0, 10.0)}, "width is 1e+308 cm"),
        ({"weight": 1e-300}, "weight is 1e-300 kg"),
        ({"name": "a\nb"}, "name is 'a\\nb'"),
        ({"name": "\ud800"}, "name is '\\ud800'"),
        ({"size": (10.0, -5.0, 10.0)}, "height is -5 cm"),
        ({"size": (10.0, 10.0, math.nan)}, "depth is nan cm"),
        ({"weight": 0.0}, "weight is 0 kg"),
        ({"weight": math.inf}, "weight is inf kg"),
        ({"mass_offset": (5.1, 0.0, 0.0)}, "offset x is 5.1 cm; allowed: inside the item, -5 to 5"),
        ({"mass_offset": (0.0, 0.0, math.nan)}, "offset z is nan"),
    ],
)
def test_an_impossible_item_is_refused(values, message):
    with pytest.raises(LayoutError, match="allowed") as caught:
        item(**values)
    assert message in str(caught.value)


@pytest.mark.parametrize("side", [0.0, -1.0, math.nan, math.inf])
def test_an_impossible_pallet_is_refused(side):
    with pytest.raises(LayoutError, match="pallet height"):
        Pallet(10.0, side, 10.0)


@pytest.mark.parametrize("name", ["", "a\tb", "\x1b[31m", "\ud800"])
def test_a_layout_needs_a_printable_name(name):
    with pytest.raises(LayoutError, match="allowed: one or more printable characters"):
        Layout(name, PALLET, (item(0),))


@pytest.mark.parametrize(
    ("sequences", "message"),
    [
        ((), 'layout "a": has no items'),
        ((0, 1, 1), "sequence 1 stands there twice"),
        ((0, 2), "sequence 1 is missing before 2"),
    ],
    ids=["no items", "twice", "a gap"],
)
def test_a_sequence_that_cannot_be_is_refused(sequences, message):
    items = (item(number, (20.0 * k, 0.0, 0.0)) for k, number in enumerate(sequences))
    with pytest.raises(LayoutError, match=message):
        Layout("a", PALLET, tuple(items))


def test_overlap_is_refused_only_beyond_the_tolerance():
    # Overlap along x by 0.02 cm, then by 0.005 cm; the stated tolerance is 0.01 cm.
    with pytest.raises(LayoutError, match=r"item 1: overlaps item 0 by 0.02 cm"):
        Layout("a", PALLET, (item(0), item(1, (9.98, 0.0, 0.0))))
    Layout("a", PALLET, (item(0), item(1, (9.995, 0.0, 0.0))))


def test_overlap_is_found_between_far_blocks():
    # More items than the block in which pairs are compared; only the first and last overlap.
    row = [item(k, (float(k), 0.0, 0.0), (1.0, 1.0, 1.0)) for k in range(300)]
    last = item(300, (0.5, 0.0, 0.0), (0.5, 1.0, 1.0))
    with pytest.raises(LayoutError, match="item 300: overlaps item 0"):
        Layout("a", Pallet(300.0, 10.0, 10.0), (*row, last))


@pytest.mark.parametrize(
    ("position", "message"),
    [
        ((91.0, 0.0, 0.0), "x = 91 to 101 cm; allowed: inside the pallet's contour, 0 to 100"),
        ((0.0, 41.0, 0.0), "y = 41 to 51 cm"),
        ((0.0, 0.0, -0.5), "z = -0.5 to 9.5 cm"),
    ],
)
def test_an_item_outside_the_contour_is_refused(position, message):
    with pytest.raises(LayoutError) as caught:
        Layout("a", replace(PALLET, overhang=0.0), (item(0, position),))
    assert message in str(caught.value)


@pytest.mark.parametrize(
    ("position", "message"),
    [
        (
            (100.5, 0.0, 0.0),
            "x = 100.5 to 110.5 cm; allowed: inside the pallet's contour, -10 to 110 cm (+-0.01): "
            "up to 10 cm over the edge of the deck",
        ),
        ((0.0, 0.0, -10.5), "z = -10.5 to -0.5 cm"),
        ((0.0, -0.5, 0.0), "y = -0.5 to 9.5 cm; allowed: inside the pallet's contour, 0 to 50 cm"),
    ],
)
def test_an_item_may_overhang_the_deck_up_to_a_limit(position, message):
    x, y, z = position
    Layout("a", PALLET, (item(0, (min(x, 100.0), max(y, 0.0), max(z, -10.0))),))
    with pytest.raises(LayoutError) as caught:
        Layout("a", PALLET, (item(0, position),))
    assert message in str(caught.value)
    Layout("a", replace(PALLET, overhang=11.0), (item(0, (x, max(y, 0.0), z)),))


def test_a_floor_has_edges_where_an_item_overhangs_them():
    inside = Layout("a", PALLET, (item(0),))
    over = Layout("a", PALLET, (item(0, (-4.0, 0.0, 0.0)), item(1, (20.0, 0.0, 0.0))))
    assert not inside.floor.has_edges
    # As far as lengths count as equal, nothing overhangs.
    assert not Layout("a", PALLET, (item(0, (-TOLERANCE, 0.0, 0.0)),)).floor.has_edges
    assert over.floor == Floor((0.0, 0.0), (100.0, 100.0), 14.4)
    assert inside.on("deck").floor == over.floor
    assert not over.on("infinite").floor.has_edges
    assert over.on("auto") is over
    with pytest.raises(FloorError, match="floor is 'table'; allowed: auto, deck, infinite"):
        over.on("table")


@pytest.mark.parametrize("place", [(-5, 0), (0, -5), (95, 0), (0, 95)])
def test_a_floor_has_edges_whichever_side_an_item_overhangs(place):
    x, z = map(float, place)
    boxes = (item(0, (x, 0.0, z)), item(1, (40.0, 0.0, 40.0)))
    assert Layout("a", PALLET, boxes).floor.has_edges


def test_what_is_left_of_a_layout_stands_on_the_same_floor():
    items = (item(0, (20.0, 0.0, 0.0)), item(1, (-4.0, 0.0, 0.0)))
    over = Layout("a", PALLET, items)
    assert over.first(1).floor == over.floor
    assert Layout("a", PALLET, items[:1]).first(1).floor == INFINITE


def test_only_a_deck_changes_the_hash_of_a_layout():
    inside, low = Layout("a", PALLET, (item(0),)), replace(PALLET, deck_height=5.0)
    # As it was before pallets had decks.
    assert inside.content_hash()[:16] == "a524c17828dc6ef9"
    assert inside.on("infinite").content_hash() == inside.content_hash()
    assert replace_items(inside, inside.items).content_hash() == inside.content_hash()
    hashes = {
        inside.content_hash(),
        inside.on("deck").content_hash(),
        Layout("a", low, inside.items).on("deck").content_hash(),
    }
    assert len(hashes) == 3


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"overhang": -1.0}, "pallet overhang is -1 cm; allowed: a number, 0 to 100000"),
        ({"overhang": "wide"}, "pallet overhang is 'wide'; allowed: a number"),
        ({"overhang": math.nan}, "pallet overhang is nan cm"),
        ({"deck_height": 0.0}, "pallet deck_height is 0 cm; allowed: a positive finite number"),
        ({"floor": "dekc"}, "pallet floor is 'dekc'; did you mean 'deck'?"),
    ],
)
def test_a_pallet_that_cannot_be_is_refused(values, message):
    with pytest.raises(LayoutError) as caught:
        replace(PALLET, **values)
    assert message in str(caught.value)


def test_items_come_in_loading_order_and_nothing_can_be_changed():
    layout = Layout("a", PALLET, (item(1, (20.0, 0.0, 0.0)), item(0)))
    assert [i.sequence for i in layout.items] == [0, 1]
    with pytest.raises(FrozenInstanceError):
        layout.name = "b"  # type: ignore[misc]
    with pytest.raises(ValueError, match="read-only"):
        layout.lower[0, 0] = 1.0
    assert layout.first(1).items == layout.items[:1]


def test_the_content_hash_sees_everything_but_names():
    base = Layout("a", PALLET, (item(0),))
    assert base.content_hash() == Layout("b", PALLET, (item(0, name="x"),)).content_hash()
    others = [
        Layout("a", Pallet(100.0, 50.0, 99.0), (item(0),)),
        Layout("a", PALLET, (item(0, weight=2.0),)),
        Layout("a", PALLET, (item(0, position=(1.0, 0.0, 0.0)),)),
        Layout("a", PALLET, (item(0, size=(10.0, 10.0, 9.0)),)),
        base.with_mass_offsets(np.array([[1.0, 0.0, 0.0]])),
    ]
    assert len({lay.content_hash() for lay in [base, *others]}) == len(others) + 1

"""Lengths that differ by exactly 0.01 cm count as equal, whatever rounding does to them."""

import re

import numpy as np
import pytest

from steadyload.layouts import Item, Layout, LayoutError, Pallet
from steadyload.layouts.model.batch import LayoutBatch
from steadyload.layouts.model.contacts import FLOOR
from steadyload.layouts.model.growing import GrowingLayout
from steadyload.layouts.model.snapping import snap
from steadyload.layouts.packers.plan import Bin, Placed, plan
from steadyload.methods.simulation.scene import planar_scene
from steadyload.statics.touching import touching_points

PLACES = [k / 10 for k in range(100, 400)] + [k / 10 for k in range(99_000, 99_100)]
"""Lengths of whole millimetres, short and long [cm]; 0.01 cm more or less is rounded each time."""

VAST = 100_000.0


def box(sequence, position, size, weight=5.0):
    return Item(sequence, tuple(position), tuple(size), weight)


def doors(pallet, items):
    """What takes in items and checks them: a layout, a batch, a growing layout, by name."""

    def grow():
        growing = GrowingLayout(pallet, "layout")
        for item in items:
            growing.put(item)
        return growing

    def batch():
        places, sizes = [i.position for i in items], [i.size for i in items]
        weights, starts = [i.weight for i in items], [0, len(items)]
        return LayoutBatch.from_arrays(
            starts, places, sizes, weights, pallets=[pallet], names=["layout"]
        )

    return {"layout": lambda: Layout("layout", pallet, tuple(items)), "batch": batch, "grow": grow}


def taken(pallet, items):
    """The same items through every door."""
    return {name: make() for name, make in doors(pallet, items).items()}


def refusals(pallet, items):
    """What every door says of items that are not allowed, without the name of the layout."""
    said = set()
    for make in doors(pallet, items).values():
        with pytest.raises(LayoutError) as caught:
            make()
        said.add(caught.value.message)
    return said


# --- the contour ----------------------------------------------------------------------------------


@pytest.mark.parametrize("overhang", [0.0, 0.3, 10.0])
@pytest.mark.parametrize("axis", [0, 1, 2])
def test_an_item_may_stand_out_of_the_contour_by_exactly_the_tolerance(axis, overhang):
    for length in PLACES:
        sides = [length if a == axis else 50.0 for a in range(3)]
        pallet = Pallet(*sides, overhang=overhang)
        limit = length + (0.0 if axis == 1 else overhang)
        for excess, allowed in ((0.01, True), (0.0101, False)):
            size, position = [10.0, 10.0, 10.0], [0.0, 0.0, 0.0]
            size[axis] = round(limit + excess, 4)
            if allowed:
                taken(pallet, [box(0, position, size)])
            else:
                refusals(pallet, [box(0, position, size)])
            size[axis], position[axis] = 10.0, -round(limit - length + excess, 4)
            if allowed:
                taken(pallet, [box(0, position, size)])


def test_the_smallest_coordinates_may_be_below_the_contour_by_exactly_the_tolerance():
    for overhang in PLACES:
        pallet = Pallet(50.0, 50.0, 50.0, overhang=overhang)
        place = -round(overhang + 0.01, 2)
        taken(pallet, [box(0, (place, -0.01, place), (10.0, 10.0, 10.0))])
        refusals(pallet, [box(0, (place - 0.0001, 0.0, 0.0), (10.0, 10.0, 10.0))])


def test_a_plan_may_stand_out_of_its_bin_by_exactly_the_tolerance():
    for length in PLACES:
        loaded = Placed("box", (0.0, 0.0, 0.0), (round(length + 0.01, 2), 5.0, 5.0), 1.0)
        plan([Bin("bin", (length, 50.0, 50.0), [loaded])], (), "height")
        loaded = Placed("box", (0.0, 0.0, 0.0), (round(length + 0.0101, 4), 5.0, 5.0), 1.0)
        with pytest.raises(LayoutError, match="spans z = 0 to"):
            plan([Bin("bin", (length, 50.0, 50.0), [loaded])], (), "height")


# --- overlaps -------------------------------------------------------------------------------------


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_items_may_overlap_by_exactly_the_tolerance(axis):
    pallet = Pallet(VAST, VAST, VAST)
    for length in PLACES:
        size, position = [20.0, 20.0, 20.0], [0.0, 0.0, 0.0]
        size[axis] = length
        for depth in (0.01, 0.0101):
            position[axis] = round(length - depth, 4)
            items = [box(0, (0.0, 0.0, 0.0), size), box(1, position, (20.0, 20.0, 20.0))]
            if depth == 0.01:
                taken(pallet, items)
            else:
                refusals(pallet, items)


def test_layouts_of_any_size_overlap_by_the_tolerance_alike():
    # Up to 64 items are compared pair by pair, more in blocks of 256.
    for count in (2, 70, 300):
        place, positions = 0.0, []
        for k in range(count):
            positions.append((round(place, 2), 0.0, 0.0))
            place += 1.09 + 0.1 * (k % 7)
        sizes = [(1.1 + 0.1 * (k % 7), 1.0, 1.0) for k in range(count)]
        items = [box(k, *each) for k, each in enumerate(zip(positions, sizes, strict=True))]
        taken(Pallet(1000.0, 10.0, 10.0), items)


# --- contacts and the floor -----------------------------------------------------------------------


@pytest.mark.parametrize("miss", [0.01, -0.01])
def test_a_top_that_misses_a_base_by_exactly_the_tolerance_carries_it(miss):
    pallet = Pallet(200.0, VAST, 200.0)
    for height in PLACES:
        items = [
            box(0, (0.0, 0.0, 0.0), (40.0, height, 40.0)),
            box(1, (0.0, round(height + miss, 2), 0.0), (40.0, 10.0, 40.0)),
        ]
        found = taken(pallet, items)
        assert found["layout"].contacts.carries[0, 1]
        assert found["layout"].supports.carriers(1) == [0]
        assert found["grow"].supports.carriers(1) == [0]
        points = touching_points(found["layout"], [1], [0])
        assert len(points) == 4
        assert points.gaps == pytest.approx(max(miss, 0.0))


def test_the_lower_of_two_is_found_below_the_upper_that_was_loaded_before():
    pallet = Pallet(200.0, VAST, 200.0)
    for height in PLACES:
        upper = box(0, (0.0, round(height + 0.01, 2), 0.0), (40.0, 10.0, 40.0))
        lower = box(1, (0.0, 0.0, 0.0), (40.0, height, 40.0))
        found = taken(pallet, [upper, lower])
        assert found["layout"].supports.carriers(0) == [1]
        assert found["grow"].supports.carriers(0) == [1]


def test_the_many_items_of_a_large_layout_touch_alike():
    # Of more than 48 items, those whose heights meet are looked for.
    top, items = 0.0, []
    for k in range(60):
        height = round(2.0 + 0.1 * (k % 9), 1)
        items.append(box(k, (0.0, round(top, 2), 0.0), (40.0, height, 40.0)))
        top += height + (0.01 if k % 2 else -0.01)
    found = taken(Pallet(40.0, 400.0, 40.0), items)
    expected = [[], *([k] for k in range(59))]
    for supports in (found["layout"].supports, found["grow"].supports):
        assert [supports.carriers(k) for k in range(60)] == expected
    assert (np.argwhere(found["layout"].contacts.carries) == np.argwhere(np.eye(60, k=1))).all()


def test_what_shares_a_strip_of_exactly_the_tolerance_does_not_touch():
    pallet = Pallet(VAST, 200.0, 200.0)
    for width in PLACES:
        items = [
            box(0, (0.0, 0.0, 0.0), (width, 30.0, 40.0)),
            box(1, (round(width - 0.01, 2), 30.0, 0.0), (40.0, 10.0, 40.0)),
        ]
        found = taken(pallet, items)
        assert not found["layout"].contacts.carries.any()
        assert not found["layout"].supports.below[1]
        assert not found["grow"].supports.below[1]
        assert not len(touching_points(found["layout"], [1], [0]))


def test_what_overhangs_the_deck_by_exactly_the_tolerance_overhangs_no_edge():
    for width in PLACES:
        for floor in ("auto", "deck"):
            pallet = Pallet(width, 50.0, 50.0, floor=floor)
            over = box(0, (round(width - 9.99, 2), 0.01, -0.01), (10.0, 10.0, 10.0))
            found = taken(pallet, [over])
            layout, growing = found["layout"], found["grow"]
            assert layout.floor.has_edges == growing.floor.has_edges == (floor == "deck")
            assert (found["batch"].floors[0] == layout.floor.corners).all()
            contacts = layout.contacts
            assert contacts.on_floor.all()
            assert not len(contacts.above)
            for supports in (layout.supports, growing.supports):
                assert supports.on_floor == [True]
                assert supports.below == [[]]
            further = box(0, (round(width - 9.9899, 4), 0.0, 0.0), (10.0, 10.0, 10.0))
            found = taken(pallet, [further])
            assert found["layout"].floor.has_edges
            assert found["grow"].floor.has_edges
            assert found["layout"].supports.below[0][0].below == FLOOR
            assert found["grow"].supports.below[0][0].below == FLOOR


def test_a_wall_that_is_even_to_within_the_tolerance_is_planar():
    for depth in PLACES:
        items = (
            box(0, (0.0, 0.0, 0.0), (10.0, 10.0, depth)),
            box(1, (10.0, 0.0, 0.0), (10.0, 10.0, round(depth + 0.01, 2))),
        )
        wide = Pallet(50.0, 50.0, VAST)
        assert planar_scene(Layout("wall", wide, items)).across == "depth"


def test_an_item_pressed_into_another_by_exactly_the_tolerance_is_snapped_out_of_no_other():
    pallet = Pallet(200.0, VAST, 200.0)
    for height in PLACES:
        items = (
            box(0, (0.0, 0.0, 0.0), (40.0, height, 40.0)),
            box(1, (0.0, round(height - 0.01, 2), 0.0), (40.0, 10.0, 40.0)),
            box(2, (0.0, round(height + 10.19, 2), 0.0), (40.0, 10.0, 40.0)),
        )
        snapped = snap(Layout("pressed in", pallet, items))
        assert snapped.items[1].position[1] == items[1].position[1]
        assert snapped.items[2].position[1] == pytest.approx(height + 9.99)


# --- sentences ------------------------------------------------------------------------------------

NUMBER = r"(-?[\d.]+)"


@pytest.mark.parametrize("depth", [0.010001001, 0.0100012, 0.010002, 0.011, 0.02, 3.5])
def test_a_refused_overlap_is_stated_as_more_than_is_allowed(depth):
    items = [box(0, (0.0, 0.0, 0.0), (10.0,) * 3), box(1, (10.0 - depth, 0.0, 0.0), (10.0,) * 3)]
    (said,) = refusals(Pallet(100.0, 50.0, 50.0), items)
    stated, allowed = re.fullmatch(
        rf"overlaps item 0 by {NUMBER} cm or more along every axis; allowed: at most {NUMBER} cm",
        said,
    ).groups()
    assert float(stated) > float(allowed) == 0.01
    assert float(stated) == pytest.approx(depth, abs=1e-6)


@pytest.mark.parametrize("width", [10.0, 12.3456, 1234.567, 1234.5678, 99_999.9])
@pytest.mark.parametrize("excess", [0.010001001, 0.0100012, 0.0101, 0.011, 4.5])
def test_a_refused_overhang_is_stated_as_more_than_is_allowed(width, excess):
    pallet = Pallet(width, 50.0, 50.0, overhang=0.0)
    (said,) = refusals(pallet, [box(0, (width + excess - 10.0, 0.0, 0.0), (10.0,) * 3)])
    low, high, least, most, tolerance = map(
        float,
        re.fullmatch(
            rf"spans x = {NUMBER} to {NUMBER} cm; allowed: inside the pallet's contour, {NUMBER} "
            rf"to {NUMBER} cm \(\+-{NUMBER}\)",
            said,
        ).groups(),
    )
    assert tolerance == 0.01
    assert least == 0.0
    assert round(high - most, 6) > 0.01
    assert (high, most) == (pytest.approx(width + excess), pytest.approx(width))
    assert low == pytest.approx(high - 10.0)
    loaded = Placed("box", (0.0, 0.0, 0.0), (width + excess, 5.0, 5.0), 1.0)
    with pytest.raises(LayoutError) as caught:
        plan([Bin("bin", (width, 50.0, 50.0), [loaded])], (), "height")
    high, most, tolerance = map(
        float,
        re.search(
            rf"0 to {NUMBER} cm; .* 0 to {NUMBER} cm \(\+-{NUMBER}\)", str(caught.value)
        ).groups(),
    )
    assert round(high - most, 6) > tolerance == 0.01

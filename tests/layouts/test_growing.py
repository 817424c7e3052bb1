"""A growing layout is at any time what the layout of its items is."""

import copy
import pickle
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from steadyload.core.constants import CARRIED, STANDS
from steadyload.core.session import Session
from steadyload.layouts import Item, Layout, LayoutError, Pallet
from steadyload.layouts.model.contacts import FLOOR
from steadyload.layouts.model.frame import Frame
from steadyload.layouts.model.growing import GrowingLayout
from steadyload.layouts.model.layout import ARRAYS
from steadyload.layouts.packing.packing import random_layouts
from steadyload.methods.simulation.scene import neighbourhood
from steadyload.properties.strategies import layouts, packings

FEW = settings(max_examples=60, derandomize=True)


def assert_equal(growing, items):
    """The growing layout holds these items, and knows of them what can be known."""
    whole = Layout("growing", growing.pallet, tuple(items))
    made = growing.layout()
    assert (made.items, made.floor) == (whole.items, whole.floor)
    for name in ARRAYS:
        assert (getattr(made, name) == getattr(whole, name)).all()
        assert not getattr(made, name).flags.writeable
    for name in set(ARRAYS) - {"sizes"}:
        assert (getattr(growing, name) == getattr(whole, name)).all()
    assert growing.floor == whole.floor
    assert growing.supports == whole.supports == growing.supports
    assert growing.given.judge(CARRIED, 0.0) == whole.given.judge(CARRIED, 0.0)


def pushed_over_the_edge(layout, by):
    """The layout with all items further back and to the left by this, as far as it takes."""
    items = tuple(
        replace(item, position=(item.position[0] - by, item.position[1], item.position[2] - by))
        for item in layout.items
    )
    return Layout(layout.name, replace(layout.pallet, overhang=by), items)


def test_it_knows_of_a_deck_what_a_layout_knows():
    kinds, edges = set(), 0
    for by in (0.005, 3.0, 40.0):
        for layout in random_layouts(8, seed=5):
            over = pushed_over_the_edge(layout, by)
            growing = GrowingLayout(over.pallet, "growing")
            for count, item in enumerate(over.items, start=1):
                growing.put(item)
                assert_equal(growing, over.items[:count])
                kinds.add(growing.floor.kind)
            edges += sum(patch.below == FLOOR for p in growing.supports.below for patch in p)
            for count in range(len(over) - 1, 0, -1):
                growing.take_off()
                assert_equal(growing, over.items[:count])
    assert kinds == {"deck", "infinite"}
    assert edges > 20


@FEW
@given(data=st.data(), layout=layouts() | packings(most=15))
def test_it_grows_and_shrinks_in_any_order(data, layout):
    left = list(data.draw(st.permutations(layout.items)))
    growing, items = GrowingLayout(layout.pallet, "growing"), []
    while left:
        items.append(replace(left.pop(0), sequence=len(items)))
        growing.put(items[-1])
        assert_equal(growing, items)
        for _ in range(data.draw(st.sampled_from((0, 0, 1, 2)))):
            if items[1:] and left:
                left.append(items.pop())
                assert growing.take_off() == left[-1]
                assert_equal(growing, items)
    copy = growing.copy()
    for item in reversed(items[1:]):
        assert growing.take_off() == item
    assert_equal(copy, items)


def test_what_is_beside_some_items_is_what_all_items_tell():
    for layout in random_layouts(12, seed=3):
        growing = GrowingLayout(layout.pallet, "growing")
        for item in layout.items:
            growing.put(item)
        for reach in (0.0, 1.0, 7.5, 60.0):
            # The neighbourhood of a group ends with its last item.
            group = np.array([0, len(layout) - 1])
            fixed = neighbourhood(layout, group, reach).fixed
            assert growing.beside(group.tolist(), reach) == fixed.tolist()


@pytest.mark.parametrize(
    ("position", "size"),
    [
        ((105.0, 0.0, 0.0), (10.0, 10.0, 10.0)),
        ((0.0, 95.0, 0.0), (10.0, 10.0, 10.0)),
        ((0.0, 0.0, -10.02), (10.0, 10.0, 10.0)),
        ((25.0, 5.0, 25.0), (10.0, 10.0, 10.0)),
        ((10.0, 0.0, 10.0), (5.0, 5.0, 5.0)),  # inside
        ((0.0, 0.0, 0.0), (60.0, 60.0, 60.0)),  # around two, deeper into the second
    ],
)
def test_an_item_that_cannot_be_is_refused_as_a_layout_refuses_it(position, size):
    items = [
        Item(0, (0.0, 0.0, 0.0), (30.0, 20.0, 30.0), 1.0, name="a"),
        Item(1, (31.0, 0.0, 0.0), (29.0, 30.0, 30.0), 1.0, name="b"),
    ]
    growing = GrowingLayout(Pallet(100.0, 100.0, 100.0), "growing")
    for item in items:
        growing.put(item)
    wrong = Item(2, position, size, 1.0, name="c")
    with pytest.raises(LayoutError) as whole:
        Layout("growing", growing.pallet, (*items, wrong))
    with pytest.raises(LayoutError) as found:
        growing.put(wrong)
    growing.cut(1)  # what is wrong is read later, and from another process
    for told in (found.value, pickle.loads(pickle.dumps(found.value))):
        assert (told.message, told.item) == (whole.value.message, whole.value.item)
        assert str(told.located(layout="growing")) == str(whole.value)
        inches = Frame(unit="in")
        assert told.framed(inches).message == whole.value.framed(inches).message
    assert_equal(growing, items[:1])


def test_a_layout_stays_as_it_was_when_the_growing_one_goes_on():
    growing = GrowingLayout(Pallet(100.0, 100.0, 100.0), "growing")
    growing.put(Item(0, (0.0, 0.0, 0.0), (30.0, 20.0, 30.0), 1.0))
    made, before = growing.layout("made"), Layout("made", growing.pallet, tuple(growing.items))
    growing.take_off()
    growing.put(Item(0, (50.0, 0.0, 50.0), (10.0, 10.0, 10.0), 7.0))
    assert made.content_hash() == before.content_hash()
    assert (made.name, made.items) == ("made", before.items)
    for name in ("", "a\nb"):
        with pytest.raises(LayoutError, match="name is"):
            growing.layout(name)


def test_faces_within_the_tolerance_touch_and_do_not_overlap():
    growing = GrowingLayout(Pallet(100.0, 100.0, 100.0), "growing")
    items = [
        Item(0, (0.0, 0.0, 0.0), (10.0, 10.0, 10.0), 1.0),
        Item(1, (0.0, 9.995, 0.0), (10.0, 10.0, 10.0), 1.0),
        Item(2, (9.992, 0.009, 0.0), (10.0, 19.993, 10.0), 1.0),
    ]
    for item in items:
        growing.put(item)
    assert_equal(growing, items)


sides = st.sampled_from((0.05, 1.0, 3.0, 9.0, 10.0, 27.0, 80.0, 1e5)) | st.floats(0.05, 300.0)
small = st.sampled_from((0.05, 1.0, 3.0, 9.0, 10.0, 27.0, 80.0)) | st.floats(0.05, 60.0)
boxes = st.lists(st.tuples(*[st.floats(-10.0, 300.0)] * 3, *[small] * 3), min_size=1, max_size=60)


@FEW
@given(boxes=boxes, region=st.tuples(*[st.floats(-50.0, 500.0)] * 3, *[sides] * 3))
def test_items_near_are_those_that_a_look_at_all_finds(boxes, region):
    # Some regions reach beyond the contour, where the outermost slabs count.
    session = Session((-10.0, -10.0, -10.0, 310.0, 300.0, 310.0, *[0.0] * 5))
    boxes = [box for box in boxes if session.put((*box, *[0.0] * 3, 1.0)) == STANDS]
    lower = np.array([box[:3] for box in boxes]).reshape(-1, 3)
    upper = lower + np.array([box[3:] for box in boxes]).reshape(-1, 3)
    low = np.array(region[:3])
    high = low + np.array(region[3:])
    for count in range(len(boxes), 0, -3):
        session.cut(count)
        meeting = ((lower <= high + 0.5) & (upper >= low - 0.5))[:count].all(axis=1)
        assert session.near(low, high, 0.5).tolist() == np.flatnonzero(meeting).tolist()


def test_a_copy_and_what_grew_beyond_its_room_know_the_same():
    items = [
        Item(k, (5.0 * (k % 20), 4.0 * (k // 400), 5.0 * (k // 20 % 20)), (5.0, 4.0, 5.0), 1.0)
        for k in range(900)
    ]
    growing = GrowingLayout(Pallet(100.0, 100.0, 100.0), "growing")
    for item in items[:-100]:
        growing.put(item)
    both = growing.copy(), copy.deepcopy(growing)
    for item in items[-100:]:
        for each in (growing, *both):
            each.put(item)
    for each in (growing, *both):
        assert_equal(each, items)


def test_items_that_are_pushed_below_others_again_and_again_leave_nothing():
    # A board over a row of gaps: what is pushed under it makes its block of patches move.
    pallet = Pallet(100.0, 100.0, 20.0)
    board = Item(1, (0.0, 10.0, 0.0), (100.0, 5.0, 20.0), 1.0)
    posts = [Item(0, (5.0 * k, 0.0, 0.0), (4.0, 10.0, 20.0), 1.0) for k in range(20)]
    items = [posts[0], board, *(replace(p, sequence=k + 1) for k, p in enumerate(posts[1:], 1))]
    growing = GrowingLayout(pallet, "growing")
    for item in items[:2]:
        growing.put(item)
    for _ in range(3):
        for count, item in enumerate(items[2:], start=3):
            growing.put(item)
            assert_equal(growing, items[:count])
        for count in range(len(items) - 1, 1, -1):
            assert growing.take_off() == items[count]
            assert_equal(growing, items[:count])

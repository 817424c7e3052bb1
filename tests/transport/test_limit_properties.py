"""What must hold of limits whatever the load: friction, mirror, masses, turns, fixed columns."""

import math
from dataclasses import replace

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from steadyload.layouts.model.layout import Item, Layout, Pallet
from steadyload.properties.strategies import ordinary_layouts, single_items
from steadyload.properties.transforms import mirrored, quarter_turned
from steadyload.transport.balance import BalanceProgramme
from steadyload.transport.errors import UnsolvedError
from steadyload.transport.limits import RESOLUTION, limits

_SAME = 1e-5
"""Of two programmes that are one in exact numbers [g]; the solver stops at 1e-8 of a load."""

DIRECTIONS = st.floats(0.0, 359.0)
FRICTIONS = st.floats(0.05, 1.5)


def limit(layout, friction, direction):
    """The exact limit [g]; a load that the solver cannot decide is no example."""
    try:
        return BalanceProgramme(layout, friction).limit(direction % 360.0).limit_g
    except UnsolvedError:
        assume(False)


@given(single_items(), FRICTIONS, FRICTIONS, DIRECTIONS)
def test_a_single_box_holds_no_less_on_a_rougher_deck(layout, one, other, direction):
    rough, smooth = max(one, other), min(one, other)
    assert limit(layout, rough, direction) >= limit(layout, smooth, direction) - _SAME


@given(ordinary_layouts(), DIRECTIONS)
def test_a_mirrored_load_holds_as_much_in_the_mirrored_direction(layout, direction):
    held = limit(layout, 0.5, direction)
    assert limit(mirrored(layout), 0.5, 180.0 - direction) == pytest.approx(held, abs=_SAME)


@given(ordinary_layouts(), DIRECTIONS)
def test_a_turned_load_holds_as_much_in_the_turned_direction(layout, direction):
    """z becomes x, and x becomes -z."""
    held = limit(layout, 0.5, direction)
    assert limit(quarter_turned(layout), 0.5, direction - 90.0) == pytest.approx(held, abs=_SAME)


@given(ordinary_layouts(), st.floats(1e-3, 1e3), DIRECTIONS)
def test_a_load_of_other_weight_holds_as_much(layout, factor, direction):
    items = tuple(replace(item, weight=factor * item.weight) for item in layout.items)
    held = limit(layout, 0.5, direction)
    assert limit(replace(layout, items=items), 0.5, direction) == pytest.approx(held, abs=_SAME)


@given(
    st.lists(st.tuples(st.floats(2.0, 30.0), st.floats(0.5, 50.0)), min_size=1, max_size=8),
    st.floats(5.0, 30.0),
    FRICTIONS,
)
def test_a_column_tips_over_the_edge_where_its_upper_part_tips_first(boxes, side, friction):
    """Boxes of one base, other heights and weights: the least b / h of those from any box up."""
    items, at = [], 0.0
    for number, (height, weight) in enumerate(boxes):
        items.append(Item(number, (40.0, at, 30.0), (side, height, side), weight))
        at += height
    tips = []
    for bottom in range(len(items)):
        above = items[bottom:]
        weight = math.fsum(item.weight for item in above)
        moment = math.fsum(
            item.weight * (item.position[1] + 0.5 * item.size[1] - above[0].position[1])
            for item in above
        )
        tips.append(0.5 * side * weight / moment)
    column = Layout("column", Pallet(120.0, 500.0, 80.0), tuple(items))
    assert limit(column, friction, 0.0) == pytest.approx(min(friction, *tips), abs=_SAME)


@pytest.mark.parametrize("engine", ["mujoco", "dart"])
def test_an_engine_holds_a_mirrored_or_heavier_load_alike(engine):
    """To the width of the intervals in which two limits are known."""
    low = Item(0, (30.0, 0.0, 20.0), (40.0, 15.0, 30.0), 9.0)
    high = Item(1, (45.0, 15.0, 25.0), (20.0, 40.0, 20.0), 4.0, (2.0, 1.0, 0.0))
    load = Layout("two", Pallet(120.0, 200.0, 80.0), (low, high))
    heavier = replace(
        load, items=tuple(replace(one, weight=8.0 * one.weight) for one in (low, high))
    )
    method = f"label@{engine}:frequency=240"
    found = [
        limits(layout, method, directions=(direction,))[0].limit_g
        for layout, direction in ((load, 0.0), (mirrored(load), 180.0), (heavier, 0.0))
    ]
    assert found == pytest.approx([found[0]] * 3, abs=4.0 * RESOLUTION)
    assert found[0] == pytest.approx(limit(load, 0.5, 0.0), abs=0.03)

"""The smallest change by which a failing step would stand, against closed forms and equilibrium."""

from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from plans import random_plan

from steadyload.layouts import Item, Layout, Pallet
from steadyload.layouts.model.frame import Frame
from steadyload.layouts.model.layout import replace_items
from steadyload.methods import make_method
from steadyload.repairing.remedy import Remedy, remedy

PALLET = Pallet(120.0, 150.0, 80.0, overhang=0.0)
BLOCK = Item(0, (40.0, 0.0, 20.0), (20.0, 20.0, 20.0), 10.0)
MARGIN = 0.5


def plan(*items):
    numbered = (replace(item, sequence=step) for step, item in enumerate(items))
    return Layout("plan", PALLET, tuple(numbered))


@pytest.mark.parametrize("beyond", [0.2, 3.0, 9.0])
@pytest.mark.parametrize("axis", [0, 2])
@pytest.mark.parametrize("sign", [1, -1])
def test_a_box_past_an_edge_would_stand_further_back(beyond, axis, sign):
    position = [40.0, 20.0, 20.0]
    position[axis] += sign * (10.0 + beyond)
    found = remedy(plan(BLOCK, replace(BLOCK, position=tuple(position))), 1)
    assert found.way[axis] == pytest.approx(-sign * (beyond + MARGIN))
    assert [found.way[other] for other in (0, 1, 2) if other != axis] == [0.0, 0.0]
    assert found.missing_cm == pytest.approx(beyond + MARGIN)
    assert found.side.way(Frame()) == f"{'+' if sign > 0 else '-'}{'xyz'[axis]}"
    assert (found.after, found.gives_way) == (None, None)


@pytest.mark.parametrize("gap", [2.5, 40.0])
def test_a_box_in_the_air_would_stand_lower(gap):
    found = remedy(plan(BLOCK, replace(BLOCK, position=(40.0, 20.0 + gap, 20.0))), 1)
    assert found == Remedy(1, way=(0.0, -gap, 0.0))


def test_a_box_that_comes_too_early_would_stand_after_the_one_that_carries_it():
    upper = replace(BLOCK, position=(55.0, 20.0, 20.0))
    right = replace(BLOCK, position=(65.0, 0.0, 20.0))
    found = remedy(plan(BLOCK, upper, right), 1)
    assert found.after == 2
    assert found.sentence(plan(BLOCK, upper, right)).startswith(
        "box 2 of 3 would stand if it were loaded after box 3 of 3, or if it lay 5.5 cm towards -x"
    )


def test_a_box_below_that_gives_way_is_named():
    """A plank that stands by itself, and a load on its free end that nothing can hold there."""
    plank = Item(0, (42.0, 20.0, 20.0), (30.0, 2.0, 20.0), 1.0)
    load = Item(0, (62.0, 22.0, 20.0), (10.0, 20.0, 20.0), 50.0)
    found = remedy(plan(BLOCK, plank, load), 2)
    assert found.gives_way == 1
    assert found.way[0] < 0.0
    assert found.sentence(plan(BLOCK, plank, load)).endswith("; box 2 of 3 gives way below it")


def test_a_box_that_stands_needs_nothing():
    assert remedy(plan(BLOCK, replace(BLOCK, position=(45.0, 20.0, 20.0))), 1) is None


def test_a_box_without_room_stands_nowhere():
    walls = [
        Item(0, (x, 0.0, 0.0), (40.0, 60.0, 80.0), 10.0) for x in (0.0, 80.0)
    ]  # between them a shaft that the box fills, with a box on a peg in it
    peg = Item(0, (40.0, 0.0, 0.0), (5.0, 30.0, 5.0), 1.0)
    lid = Item(0, (40.0, 30.0, 0.0), (40.0, 30.0, 80.0), 10.0)
    found = remedy(plan(*walls, peg, lid), 3)
    assert found.way is None
    said = found.sentence(plan(*walls, peg, lid), Frame(unit="mm"))
    assert said == "box 4 of 4 would stand if its support reached 355 mm further to +z"


@settings(max_examples=60, derandomize=True)
@given(seed=st.integers(0, 10**6), boxes=st.integers(2, 9))
def test_a_step_stands_at_the_place_that_is_named(seed, boxes):
    failing, judge = random_plan(seed, boxes), make_method("equilibrium")
    step = judge.judge(failing).failing_step
    found = None if step is None else remedy(failing, step)
    if found is None or found.way is None:
        return
    items = list(failing.items)
    place = tuple(a + b for a, b in zip(items[step].position, found.way, strict=True))
    items[step] = replace(items[step], position=place)
    verdict = judge.judge(replace_items(failing, tuple(items)))
    assert verdict.failing_step is None or verdict.failing_step > step

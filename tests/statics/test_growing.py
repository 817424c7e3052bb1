"""What boxes bear while a load is built up, against a solution of every step on its own."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from piles import wall

from steadyload.layouts.model.layout import Item, Layout, Pallet
from steadyload.layouts.packing.packing import random_layouts
from steadyload.statics.bearing import looks
from steadyload.statics.bearing.crushing import first_crushed
from steadyload.statics.bearing.forces import Rectangles, Statics
from steadyload.statics.bearing.growing import GrowingStatics


def limited(layout, limits):
    """The layout, with limits of some boxes [kg]."""
    items = (replace(k, max_load=limits.get(k.sequence)) for k in layout.items)
    return replace(layout, items=tuple(items))


def borne_at(layout, step):
    """What boxes bear after a step: all that are joined to its box are solved for [kg], by box."""
    group = layout.supports.joined(step)
    statics = Statics(layout, group)
    forces = statics.least_energy()
    forces = statics.nearest() if forces is None else forces
    return dict(zip(group, (statics.tops() @ forces).tolist(), strict=True))


def crushed_first(layout):
    """The step, the box and its load that the definition gives."""
    for step in range(len(layout)):
        over = {
            box: (load - layout.items[box].max_load, load)
            for box, load in borne_at(layout, step).items()
            if (most := layout.items[box].max_load) is not None
            and load > most * (1.0 + 1e-6) + 1e-9
        }
        if over:
            box = max(over, key=over.get)
            return step, box, over[box][1]
    return None


def assert_as_defined(layout):
    found, expected = first_crushed(layout), crushed_first(layout)
    assert (found is None) == (expected is None)
    if found is not None:
        assert (found.step, found.item) == expected[:2]
        assert found.bears_kg == pytest.approx(expected[2], rel=1e-7)


@given(
    rows=st.integers(2, 7),
    width=st.integers(2, 8),
    weights=st.lists(st.floats(0.1, 20.0), min_size=1, max_size=9),
    limits=st.dictionaries(st.integers(0, 40), st.floats(0.5, 1.3), min_size=1, max_size=5),
)
def test_a_wall_is_crushed_where_the_solution_of_every_step_says(rows, width, weights, limits):
    layout = wall(rows, width, weights)
    borne = borne_at(layout, len(layout) - 1)
    near = {box: borne[box] * share for box, share in limits.items() if box in borne}
    assert_as_defined(limited(layout, near))


@pytest.mark.parametrize("seed", range(8))
def test_packed_loads_are_crushed_where_the_solution_of_every_step_says(seed):
    draw = np.random.default_rng(seed)
    for layout in random_layouts(4, seed):
        borne = borne_at(layout, len(layout) - 1)
        near = {box: load * float(draw.uniform(0.5, 1.3)) for box, load in borne.items() if load}
        assert_as_defined(limited(layout, near))


@pytest.mark.parametrize("seed", range(12))
def test_loads_in_any_order_are_crushed_where_the_solution_of_every_step_says(seed):
    """Where a box is put below others, nothing balances these before it."""
    draw = np.random.default_rng(seed)
    layout = wall(4, 5)
    boxes = [layout.items[k] for k in draw.permutation(len(layout))]
    limits = {k: float(draw.uniform(0.0, 6.0)) for k in range(len(boxes)) if draw.random() < 0.4}
    items = tuple(replace(box, sequence=k) for k, box in enumerate(boxes))
    assert_as_defined(limited(replace(layout, items=items), limits))


def test_loads_found_in_passing_are_those_of_every_step():
    layout = wall(8, 9, (1.0, 7.0, 0.3, 2.0, 11.0))
    supports = layout.supports
    contacts = Rectangles(layout, supports)

    def begun():
        return GrowingStatics(layout, contacts, np.ones((len(contacts.pairs), 4), dtype=bool))

    growing, unfound = begun(), 0
    for step in range(len(layout)):
        found = growing.borne(np.array(supports.joined(step)))
        if found is None:  # on a narrow edge
            unfound += 1
            growing = begun()
            continue
        for box, load in borne_at(layout, step).items():
            assert found[box] == pytest.approx(load, rel=1e-5, abs=1e-5)
    assert unfound <= 3


def counted(monkeypatch, name):
    """How often a class is made by the module."""
    made, real = [], getattr(looks, name)
    monkeypatch.setattr(looks, name, lambda *all_of: made.append(name) or real(*all_of))
    return made


def test_no_step_of_a_wall_that_bears_all_is_solved_on_its_own(monkeypatch):
    solved = counted(monkeypatch, "Statics")
    assert first_crushed(limited(wall(14, 36), {18: 19.5})) is None
    assert solved == []
    found = first_crushed(limited(wall(14, 36), {18: 11.5}))
    assert found.item == 18
    assert len(solved) == 1


def test_a_load_that_nothing_balances_is_solved_step_by_step(monkeypatch):
    layout = replace(wall(6, 6), pallet=Pallet(160.0, 60.0, 20.0))
    tips = Item(6, (115.0, 10.0, 0.0), (40.0, 10.0, 20.0), 1.0)
    boxes = (*layout.items[:6], tips, *layout.items[6:])
    layout = replace(layout, items=tuple(replace(k, sequence=n) for n, k in enumerate(boxes)))
    growing, solved = counted(monkeypatch, "GrowingStatics"), counted(monkeypatch, "Statics")
    assert_as_defined(limited(layout, {2: 7.0}))
    assert_as_defined(limited(layout, {2: 4.0}))
    assert len(growing) <= 4 < len(solved)


def test_light_boxes_beside_heavy_ones_are_looked_at_one_by_one():
    weights = (
        2.137820869334076, 94891.09687662344, 0.0033086262441150405, 1119.340965130997,
        0.014558235975946257, 0.029171600215470495, 5449.734403731475, 0.0001407309072523698,
        10700.13648857403, 0.03515893686106794, 1364.0033574754304, 49.958505277356025,
    )  # fmt: skip
    items = [
        Item(n, (5.0 + 20.0 * (n % 4) + 10.0 * (n // 4 % 2), 10.0 * (n // 4), 5.0),
             (20.0, 10.0, 20.0), weight)
        for n, weight in enumerate(weights)
    ]  # fmt: skip
    layout = Layout("half bricks", Pallet(200.0, 40.0, 200.0), tuple(items))
    limits = {3: 2915.5, 6: 619.296737781721, 7: 15.908184018163489, 8: 0.001, 11: 0.0}
    assert_as_defined(limited(layout, limits))

"""Layouts off their plans: where centres of mass, places and weights come to lie."""

import numpy as np
import pytest
from scipy.stats import kstest, lognorm, norm, truncnorm

from steadyload.layouts import Item, Layout, Pallet
from steadyload.layouts.model.deviations import (
    CENTRE,
    NUMBERS_AN_ITEM,
    PLACE,
    deviated,
    made_room,
)
from steadyload.layouts.model.layout import TOLERANCE
from steadyload.layouts.packing.packing import random_layouts

PALLET = Pallet(100.0, 100.0, 100.0)


def cubes(*places, pallet=PALLET, offset=(0.0, 0.0, 0.0), side=10.0):
    items = [Item(k, at, (side,) * 3, 2.0, offset) for k, at in enumerate(places)]
    return Layout("cubes", pallet, tuple(items))


def uniforms(count, layout, seed=0):
    return np.random.default_rng(seed).random((count, len(layout), NUMBERS_AN_ITEM))


def meant(layout, *shifts):
    """Places in one sample; shifts along x and z, an item each."""
    at = layout.lower.copy()
    at[:, (0, 2)] += shifts
    return at[None]


def test_a_centre_of_mass_is_normal_within_its_item():
    # 4 cm off the middle of a cube of 10 cm, so that a deviation of 2 cm is often cut off at 5 cm.
    layout = cubes((0.0, 0.0, 0.0), offset=(4.0, 0.0, -1.0))
    found = np.array(
        [d.mass_offsets[0] for d in deviated(layout, uniforms(2000, layout), centre=2)]
    )
    for axis, middle in enumerate((4.0, 0.0, -1.0)):
        law = truncnorm((-5 - middle) / 2, (5 - middle) / 2, loc=middle, scale=2)
        assert kstest(found[:, axis], law.cdf).pvalue > 0.01


def test_a_place_is_normal_where_there_is_room_and_heights_stay():
    layout = cubes((45.0, 0.0, 45.0))
    found = np.array([d.lower[0] for d in deviated(layout, uniforms(2000, layout), place=0.3)])
    assert (found[:, 1] == 0.0).all()
    for axis in (0, 2):
        assert kstest(found[:, axis], norm(45.0, 0.3).cdf).pvalue > 0.01


def test_a_weight_is_multiplied_and_stays_positive():
    layout = cubes((45.0, 0.0, 45.0))
    found = [d.weights[0] for d in deviated(layout, uniforms(2000, layout), weight=0.5)]
    assert kstest(found, lognorm(0.5, scale=2.0).cdf).pvalue > 0.01


def test_what_does_not_deviate_is_as_planned():
    layout = random_layouts(1, seed=3)[0]
    numbers = uniforms(5, layout)
    for kind, same in (
        ({}, ("lower", "weights", "mass_offsets")),
        ({"centre": 0.5}, ("lower", "weights")),
        ({"place": 0.5}, ("weights", "mass_offsets")),
        ({"weight": 0.5}, ("lower", "mass_offsets")),
    ):
        for found in deviated(layout, numbers, **kind):
            assert found.name == layout.name
            for name in same:
                assert (getattr(found, name) == getattr(layout, name)).all()
    for found in deviated(layout, numbers, centre=0.5, place=0.5, still=2):
        assert (found.lower[:, 2] == layout.lower[:, 2]).all()
        assert (found.mass_offsets[:, 2] == layout.mass_offsets[:, 2]).all()
        assert (found.mass_offsets[:, 0] != layout.mass_offsets[:, 0]).all()


def test_an_item_hangs_on_its_own_numbers():
    layout = cubes((10.0, 0.0, 10.0), (40.0, 0.0, 10.0), (70.0, 0.0, 10.0))
    numbers = uniforms(4, layout)
    other = numbers.copy()
    other[:, 2] = 0.5
    amounts = {"centre": 0.4, "place": 0.2, "weight": 0.1}
    first, again = (deviated(layout, each, **amounts) for each in (numbers, other))
    fewer = deviated(layout.first(2), numbers, **amounts)
    for a, b, c in zip(first, again, fewer, strict=True):
        assert a.items[:2] == b.items[:2] == c.items
        assert a.items[2] != b.items[2]


def test_two_in_each_others_way_give_half_each():
    layout = cubes((40.0, 0.0, 40.0), (51.0, 0.0, 40.0))  # a gap of 1 cm
    found = made_room(layout, meant(layout, (0.8, 0.1), (-0.6, -0.3)))[0]
    # 0.4 cm are missing along x; along z nobody is in the way.
    assert found[:, 0] == pytest.approx([40.6, 50.6])
    assert found[:, 2] == pytest.approx([40.1, 39.7])


def test_who_stands_at_the_end_of_the_contour_stays():
    layout = cubes((0.0, 0.0, 40.0), (10.0, 0.0, 40.0), (20.5, 0.0, 40.0))
    found = made_room(layout, meant(layout, (-1.0, 0.0), (-0.4, 0.0), (-1.5, 0.0)))[0]
    # Pushed up: 0, 10, 20; pushed down from the clipped places 0, 10, 20: the same.
    assert found[:, 0] == pytest.approx([0.0, 10.0, 20.0])


def test_a_push_is_handed_on():
    layout = cubes((20.0, 0.0, 40.0), (30.0, 0.0, 40.0), (40.0, 0.0, 40.0))
    found = made_room(layout, meant(layout, (0.6, 0.0), (0.0, 0.0), (0.0, 0.0)))[0]
    # Up: 20.6, 30.6, 40.6. Down: 20, 30, 40. All three move by half.
    assert found[:, 0] == pytest.approx([20.3, 30.3, 40.3])


def test_items_that_share_no_height_are_not_in_each_others_way():
    layout = cubes((40.0, 0.0, 40.0), (40.0, 10.0, 40.0), (60.0, 10.0, 40.0))
    shifts = ((5.0, 1.0), (-5.0, -1.0), (1.0, 0.0))
    assert (made_room(layout, meant(layout, *shifts)) == meant(layout, *shifts)).all()


@pytest.mark.parametrize("spread", [0.3, 5.0])
def test_no_deviation_makes_items_overlap_or_leave_the_contour(spread):
    # A layout refuses both; besides, the order along each axis is that of the plan.
    for layout in random_layouts(12, seed=5):
        for found in deviated(layout, uniforms(16, layout), place=spread, centre=spread):
            before = layout.upper[:, None] <= layout.lower[None] + TOLERANCE
            facing = ~(before | before.transpose(1, 0, 2))
            level = facing[..., 1]
            for axis, other in ((0, 2), (2, 0)):
                kept = before[..., axis] & level & facing[..., other]
                now = found.upper[:, None, axis] <= found.lower[None, :, axis] + TOLERANCE
                assert now[kept].all()


def test_making_room_knows_no_side():
    for layout in random_layouts(6, seed=9):
        width = layout.pallet.width
        items = [
            Item(i.sequence, (width - i.position[0] - i.size[0], *i.position[1:]), i.size, i.weight)
            for i in layout.items
        ]
        mirrored = Layout("mirrored", layout.pallet, tuple(items))
        shifts = np.random.default_rng(1).normal(0.0, 2.0, (8, len(layout), 3)) * (1, 0, 1)
        there = made_room(layout, layout.lower + shifts)
        back = made_room(mirrored, mirrored.lower + shifts * (-1, 0, 1))
        sizes = layout.upper - layout.lower
        assert width - back[..., 0] - sizes[:, 0] == pytest.approx(there[..., 0])
        assert back[..., 2] == pytest.approx(there[..., 2])


def test_a_plan_that_overlaps_as_far_as_it_may_can_still_deviate():
    # 0.01 cm, as near as numbers come: rounding must not make it more.
    layout = cubes(*((1.01 + 9.99 * k, 0.0, 0.0) for k in range(3)))
    for found in deviated(layout, uniforms(64, layout), place=3.0):
        assert len(found) == 3


def test_numbers_of_places_and_centres_are_apart():
    layout = cubes((45.0, 0.0, 45.0))
    numbers = uniforms(1, layout)
    other = numbers.copy()
    other[..., PLACE] = 0.9
    a, b = (deviated(layout, n, centre=0.5, place=0.5)[0] for n in (numbers, other))
    assert (a.mass_offsets == b.mass_offsets).all()
    assert norm.ppf(0.9) * 0.5 == pytest.approx(b.lower[0, 0] - 45.0)
    other[..., CENTRE] = 0.5
    assert deviated(layout, other, centre=0.5)[0].mass_offsets == pytest.approx(np.zeros((1, 3)))

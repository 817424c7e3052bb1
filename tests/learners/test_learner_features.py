"""What a learner is told: scenes worked by hand, nothing of later items, and symmetries."""

import dataclasses
import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from steadyload.core.learned import support
from steadyload.layouts import Item, Layout, Pallet
from steadyload.layouts.packing.packing import random_layouts
from steadyload.learners.features import (
    SUPPORT,
    SYMMETRIES,
    FeatureKind,
    features,
    names,
    symmetry_matrices,
    turned,
)
from steadyload.methods.registry import make_method

PALLET = Pallet(100.0, 100.0, 100.0)
SECONDS, GRAVITY = 0.3, 980.0
"""Time [s] and acceleration [cm/s2] that a label gives an item to fall."""
LAYOUTS = random_layouts(120, seed=11)


def layout(*boxes, pallet=PALLET):
    """Boxes as (x, y, z, width, height, depth[, weight[, offset x]])."""
    items = [
        Item(
            step, box[:3], box[3:6], box[6] if len(box) > 6 else 1.0,
            (box[7] if len(box) > 7 else 0.0, 0.0, 0.0),
        )
        for step, box in enumerate(boxes)
    ]  # fmt: skip
    return Layout("hand", pallet, tuple(items))


def table(lay):
    """The support table by column, a list of rows each."""
    found, _ = support(lay.given)
    assert found.shape == (len(lay), len(SUPPORT))
    return {name: found[:, k].tolist() for k, name in enumerate(SUPPORT)}


FLOOR = (0.0, 0.0, 0.0, 10.0, 10.0, 10.0)


def test_plain_features_are_those_of_figure_2():
    lay = layout((10.0, 0.0, 5.0, 20.0, 8.0, 4.0, 2.5, 3.0), pallet=Pallet(100.0, 50.0, 200.0))
    row = dict(zip(names(FeatureKind.PLAIN), features(lay, FeatureKind.PLAIN)[0], strict=True))
    expected = {
        "x": 0.05, "y": 0.0, "z": 0.025, "width": 0.1, "height": 0.04, "depth": 0.02,
        "mass x": 0.015, "mass y": 0.0, "mass z": 0.0, "pallet width": 0.5,
        "pallet height": 0.25, "pallet depth": 1.0, "scale": math.log(2.0),
        # At the same density on a pallet of 1 m instead of 2 m it weighs an eighth.
        "weight": math.log(2.5 / 8.0),
    }  # fmt: skip
    assert row == pytest.approx(expected, abs=1e-6)


def test_an_item_past_the_edge():
    found = table(layout(FLOOR, (6.0, 10.0, 0.0, 10.0, 10.0, 10.0)))
    assert found["on the floor"] == [1.0, 0.0]
    assert found["supported share"][1] == pytest.approx(0.4)
    assert found["supporters"] == [0.0, 1.0]
    assert found["margin"][1] == pytest.approx(-1.0)  # its middle, x = 11, from the edge, x = 10
    assert found["relative margin"][1] == pytest.approx(-0.1)
    # Its far lower edge, 6 cm out, meets the floor 10 cm below, which holds it.
    for column in ("touch angle", "catch angle", "angle"):
        assert found[column][1] == pytest.approx(math.degrees(math.atan2(10.0, 6.0)))
    assert found["height"] == [0.0, 10.0]


def test_an_item_well_inside_has_the_distance_to_the_nearest_edge():
    found = table(layout(FLOOR, (1.0, 10.0, 2.0, 10.0, 10.0, 10.0)))
    assert found["margin"][1] == pytest.approx(3.0)  # z: its middle at 7, the support ends at 10
    assert (found["free angle"][1], found["angle"][1], found["way"][1]) == (0.0, 0.0, 0.0)


def test_a_centre_of_mass_moves_the_margin():
    found = table(layout(FLOOR, (0.0, 10.0, 0.0, 10.0, 10.0, 10.0, 1.0, 4.0)))
    assert found["margin"][1] == pytest.approx(1.0)


def test_a_load_moves_the_resultant_of_what_carries_it():
    lay = layout(FLOOR, (2.0, 10.0, 0.0, 10.0, 10.0, 10.0), (6.5, 20.0, 0.0, 10.0, 10.0, 10.0, 3.0))
    found = table(lay)
    assert found["margin"][1:] == pytest.approx([3.0, 0.5])
    # Of the second: (1 * 7 + 3 * 11.5) / 4 = 10.375, past its edge at 10.
    assert found["worst margin"][2] == pytest.approx(-0.375, abs=1e-5)
    assert found["worst load"][2] == pytest.approx(3.0)
    assert found["items below"][2] == 2.0


def test_a_bridge_leans_on_the_hull_of_both_banks():
    banks = (FLOOR, (20.0, 0.0, 0.0, 10.0, 10.0, 10.0))
    found = table(layout(*banks, (8.0, 10.0, 0.0, 14.0, 5.0, 10.0)))
    assert found["supporters"][2] == 2.0
    assert found["margin"][2] == pytest.approx(5.0)  # the middle of its depth
    assert found["supported share"][2] == pytest.approx(4.0 / 14.0)


def test_weight_is_shared_by_the_lever():
    # A plank on two posts; each post stands with its middle 1 cm inside the edge of a block.
    blocks = ((0.0, 0.0, 0.0, 6.0, 10.0, 10.0), (40.0, 0.0, 0.0, 6.0, 10.0, 10.0))
    posts = ((0.0, 10.0, 0.0, 10.0, 5.0, 10.0, 1.0), (40.0, 10.0, 0.0, 10.0, 5.0, 10.0, 1.0))
    plank = (8.0, 15.0, 0.0, 34.0, 2.0, 10.0, 8.0)
    found = table(layout(*blocks, *posts, plank))
    assert found["margin"][2:4] == pytest.approx([1.0, 1.0])
    # The plank lies on x = 8..10 and 40..42: half of 8 kg each, about x = 9 for the first post.
    assert found["worst margin"][4] == pytest.approx(6.0 - (5.0 + 4.0 * 9.0) / 5.0, abs=0.3)


def test_the_free_angle_is_that_of_the_pendulum():
    lay = layout((0.0, 0.0, 0.0, 40.0, 20.0, 80.0), (22.0, 20.0, 0.0, 40.0, 60.0, 80.0))
    lever, high = 2.0, 30.0
    inertia = (40.0**2 + 60.0**2) / 12.0 + lever**2 + high**2
    way = solve_ivp(
        lambda _, y: [y[1], GRAVITY * (lever + high * y[0]) / inertia],
        (0.0, SECONDS), [0.0, 0.0], rtol=1e-9, atol=1e-12,
    )  # fmt: skip
    assert table(lay)["free angle"][1] == pytest.approx(math.degrees(way.y[0, -1]), rel=1e-5)


@pytest.mark.parametrize(("gap", "limit"), [(0.0, 0.0), (2.0, math.degrees(math.atan2(2.0, 8.0)))])
def test_a_neighbour_stops_what_tips_towards_it(gap, limit):
    neighbour = (16.0 + gap, 0.0, 0.0, 10.0, 18.0, 10.0)
    found = table(layout(FLOOR, neighbour, (6.0, 10.0, 0.0, 10.0, 10.0, 10.0)))
    assert found["side angle"][2] == pytest.approx(limit)
    away = table(
        layout(FLOOR, (40.0, 0.0, 20.0, 10.0, 18.0, 10.0), (6.0, 10.0, 0.0, 10.0, 10.0, 10.0))
    )
    assert away["side angle"][2] == 90.0


@pytest.mark.parametrize(
    ("edges", "touch", "catch"),
    [
        # Of what lies 2 cm below, the far edge is 8 cm out: the resultant, at 2 cm, is over both.
        ((12.0, 20.0, 8.0), (2.0, 8.0), (2.0, 8.0)),
        # It ends before the resultant: the item tips on, to the floor 10 cm below.
        ((10.5, 11.5, 9.5), (0.5, 1.5), (10.0, 8.0)),
    ],
)
def test_what_lies_below_holds_an_item_whose_resultant_is_over_it(edges, touch, catch):
    second = (edges[0], 0.0, 0.0, edges[1] - edges[0], edges[2], 10.0)
    found = table(layout(FLOOR, second, (6.0, 10.0, 0.0, 12.0, 10.0, 10.0)))
    assert found["margin"][2] == pytest.approx(-2.0)
    assert found["touch angle"][2] == pytest.approx(math.degrees(math.atan2(*touch)))
    assert found["catch angle"][2] == pytest.approx(math.degrees(math.atan2(*catch)))


def test_what_floats_falls_to_the_next_top():
    found = table(layout(FLOOR, (4.0, 13.0, 0.0, 10.0, 10.0, 10.0)))
    assert (found["drop"][1], found["way"][1]) == (3.0, 3.0)
    assert found["margin"][1] == pytest.approx(1.0)  # of where it lands
    high = table(layout((50.0, 60.0, 50.0, 10.0, 10.0, 10.0)))
    assert high["way"] == pytest.approx([0.5 * 980.0 * 0.3**2])


def test_an_edge_of_the_deck_is_that_of_a_support():
    def over(out):
        return table(layout((-out, 0.0, 0.0, 10.0, 20.0, 10.0), pallet=Pallet(50.0, 90.0, 50.0)))

    assert [over(3.0)[c][0] for c in ("supported share", "supporters")] == [0.7, 1.0]
    assert over(3.0)["margin"][0] == pytest.approx(2.0)
    assert over(3.0)["free angle"][0] == 0.0
    assert over(7.0)["margin"][0] == pytest.approx(-2.0)
    assert over(7.0)["free angle"][0] > 0.0
    # Its outer lower edge, 7 cm out, meets the ground, 14.4 cm below the deck.
    assert over(7.0)["catch angle"][0] == pytest.approx(math.degrees(math.atan2(14.4, 7.0)))
    # Beyond the edge nothing carries; within it a deck is a plane.
    assert over(10.0)["drop"][0] == pytest.approx(14.4)
    within = layout(FLOOR, (6.0, 10.0, 0.0, 10.0, 10.0, 10.0))
    assert table(within.on("deck")) == table(within)


def test_of_weights_only_their_ratios_count_and_of_the_pallet_nothing():
    lay = layout(FLOOR, (2.0, 10.0, 0.0, 10.0, 10.0, 10.0, 3.0))
    wide = Layout("wide", Pallet(300.0, 200.0, 400.0), lay.items)
    heavy = [dataclasses.replace(i, weight=8.0 * i.weight) for i in lay.items]
    assert table(lay)["weight"] == [1.0, 3.0]
    for other in (wide, Layout("heavy", lay.pallet, tuple(heavy))):
        expected = features(lay, FeatureKind.SUPPORT)
        np.testing.assert_array_equal(features(other, FeatureKind.SUPPORT), expected)


def test_the_excess_is_fine_about_the_threshold():
    for height, expected in ((9.9, -0.2), (10.5, 1.0), (30.0, 3.0)):
        assert table(layout((0.0, height, 0.0, 5.0, 5.0, 5.0)))["excess"] == pytest.approx(
            [expected]
        )


def test_balance_is_lost_where_the_exact_method_says():
    """Passing weight down one way is no proof, but nearly always right."""
    exact = make_method("equilibrium")
    agree = []
    for lay in LAYOUTS:
        lost = np.flatnonzero(np.array(table(lay)["least margin"]) < -1e-4)
        agree.append((int(lost[0]) if len(lost) else None) == exact.judge(lay).failing_step)
    assert np.mean(agree) > 0.97


@pytest.mark.parametrize("kind", FeatureKind)
def test_a_step_hangs_on_the_items_placed_by_then_alone(kind):
    for lay in LAYOUTS[:40]:
        whole = features(lay, kind)
        for count in range(1, len(lay)):
            np.testing.assert_array_equal(features(lay.first(count), kind), whole[:count])


@pytest.mark.parametrize("kind", FeatureKind)
@pytest.mark.parametrize("symmetry", range(SYMMETRIES))
def test_features_of_a_turned_layout_are_the_turned_features(kind, symmetry):
    matrix = symmetry_matrices(kind)[symmetry]
    for lay in LAYOUTS[:40]:
        expected = features(turned(lay, symmetry), kind)
        np.testing.assert_allclose(features(lay, kind) @ matrix, expected, atol=1e-4)


def test_symmetries_are_eight_and_keep_the_label():
    exact = make_method("equilibrium")
    lopsided = next(lay for lay in LAYOUTS if lay.mass_offsets.any() and len(lay) > 5)
    assert len({turned(lopsided, k).content_hash() for k in range(SYMMETRIES)}) == SYMMETRIES
    failing = [lay for lay in LAYOUTS if exact.judge(lay).failing_step is not None][:12]
    assert len(failing) == 12
    for lay in [*failing, lopsided]:
        verdicts = {exact.judge(turned(lay, k)).failing_step for k in range(SYMMETRIES)}
        assert len(verdicts) == 1

"""What the strategies build, and that it shrinks."""

import hypothesis
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from steadyload.layouts.contacts import find_contacts
from steadyload.layouts.scenarios import Scenario
from steadyload.methods import make_method
from steadyload.methods.scene import planar_scene
from steadyload.properties import strategies as s
from steadyload.properties.transforms import mirrored, quarter_turned, translated

FEW = settings(
    max_examples=60, deadline=None, derandomize=True, database=None,
    suppress_health_check=[HealthCheck.too_slow],
)  # fmt: skip


def smallest(strategy, condition):
    return hypothesis.find(
        strategy,
        condition,
        settings=settings(
            max_examples=2000, derandomize=True, database=None,
            suppress_health_check=list(HealthCheck), deadline=None,
        ),
    )  # fmt: skip


def test_layouts_shrink_to_few_small_centred_items():
    layout = smallest(s.layouts(), lambda layout: len(layout) >= 3)
    assert len(layout) == 3
    assert (layout.upper - layout.lower).max() <= 4.0
    assert not layout.mass_offsets.any()


def test_offsets_shrink_towards_the_middle():
    layout = smallest(s.with_offsets(s.towers()), lambda layout: layout.mass_offsets.max() > 0.0)
    assert len(layout) == 1
    assert np.count_nonzero(layout.mass_offsets) == 1


@FEW
@given(s.towers())
def test_towers_rest_fully_and_centred(layout):
    contacts = find_contacts(layout)
    assert contacts.on_floor.tolist() == [True] + [False] * (len(layout) - 1)
    centres = 0.5 * (layout.lower + layout.upper)[:, ::2]
    assert (centres == centres[0]).all()
    assert make_method("fbs").judge(layout).stable


@FEW
@given(s.overhanging_stacks())
def test_stacked_items_touch_the_one_below(layout):
    carries = find_contacts(layout).carries
    assert all(carries[i, i + 1] for i in range(len(layout) - 1))


@FEW
@given(s.walls())
def test_walls_have_no_gaps(layout):
    # A brick's neighbour in its course begins where it ends.
    for course in np.unique(layout.lower[:, 1]):
        level = layout.lower[:, 1] == course
        assert np.array_equal(layout.upper[level, 0][:-1], layout.lower[level, 0][1:])


@FEW
@given(s.bridges())
def test_bridges_rest_on_both_supports(layout):
    carries = find_contacts(layout).carries
    assert carries[0, 2]
    assert carries[1, 2]


@FEW
@given(s.mass_ratios(most=1e3))
def test_mass_ratios_are_powers_of_ten_in_both_orders(layout):
    lower, upper = layout.weights
    exponent = np.log10(max(lower, upper) / min(lower, upper))
    assert exponent == pytest.approx(round(exponent))
    assert exponent <= 3.0 + 1e-9


@FEW
@given(st.sampled_from(Scenario).flatmap(lambda k: s.with_offsets(s.packings(), scenario=k)))
def test_centres_of_mass_stay_within_the_scenarios_reach(layout):
    sides = layout.upper - layout.lower
    assert (np.abs(layout.mass_offsets) <= 0.4 * sides + 1e-9).all()


@FEW
@given(s.layouts(planar=True))
def test_planar_layouts_are_planar(layout):
    assert planar_scene(layout).across is not None


@FEW
@given(s.ordinary_layouts(), st.integers(0, 50), st.integers(0, 50))
def test_moves_keep_sizes_weights_and_contacts(layout, along_x, along_z):
    before = find_contacts(layout)
    for moved in (translated(layout, along_x, along_z), quarter_turned(layout), mirrored(layout)):
        after = find_contacts(moved)
        assert np.array_equal(before.carries, after.carries)
        assert np.allclose(before.areas(), after.areas())
        assert np.array_equal(layout.weights, moved.weights)


@FEW
@given(s.ordinary_layouts())
def test_four_quarter_turns_and_two_mirrors_lead_back(layout):
    turned = quarter_turned(quarter_turned(quarter_turned(quarter_turned(layout))))
    for back in (turned, mirrored(mirrored(layout))):
        assert np.allclose(back.lower, layout.lower)
        assert np.allclose(back.mass_offsets, layout.mass_offsets)

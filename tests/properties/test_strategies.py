"""What the strategies build, and that it shrinks."""

import hypothesis
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from steadyload.layouts.model.scenarios import Scenario
from steadyload.methods import make_method
from steadyload.methods.contract.declared import EVERY_LAYOUT, LABEL_LIMITS, LayoutRange
from steadyload.methods.simulation.scene import planar_scene
from steadyload.properties import strategies as s
from steadyload.properties.mechanics import column_limit
from steadyload.properties.property import Case, MethodUnderTest
from steadyload.properties.registry import PROPERTIES
from steadyload.properties.search import search
from steadyload.properties.transforms import brought_within, mirrored, quarter_turned, translated
from steadyload.transport.limits import limits

FEW = settings(max_examples=25, derandomize=True)


def smallest(strategy, condition):
    return hypothesis.find(
        strategy,
        condition,
        settings=settings(
            max_examples=2000, derandomize=True, suppress_health_check=[*HealthCheck]
        ),
    )


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
    contacts = layout.contacts
    assert contacts.on_floor.tolist() == [True] + [False] * (len(layout) - 1)
    centres = 0.5 * (layout.lower + layout.upper)[:, ::2]
    assert (centres == centres[0]).all()
    assert make_method("fbs").judge(layout).stable


@FEW
@given(s.carton_towers())
def test_towers_of_cartons_rest_fully_and_centred(layout):
    assert len(layout) <= 20
    sizes = layout.upper - layout.lower
    assert (sizes >= 20.0).all()
    assert (sizes <= 60.0).all()
    assert (sizes[:, 1] <= sizes[:, ::2].min(axis=1)).all()
    centres = 0.5 * (layout.lower + layout.upper)[:, ::2]
    assert (centres == centres[0]).all()
    assert make_method("fbs").judge(layout).stable


@FEW
@given(s.columns())
def test_columns_rest_fully_on_the_box_below(layout):
    assert layout.contacts.on_floor.tolist() == [True] + [False] * (len(layout) - 1)
    assert make_method("fbs").judge(layout).stable
    density = layout.weights / (layout.upper - layout.lower).prod(axis=1)
    assert density == pytest.approx(density[0])
    assert (np.abs(layout.mass_offsets) <= 0.1 * (layout.upper - layout.lower) + 1e-12).all()


@FEW
@given(s.columns(), st.sampled_from((0.0, 90.0, 180.0, 270.0)), st.sampled_from((0.3, 0.5, 0.9)))
def test_the_closed_form_of_a_column_is_what_contact_forces_balance(layout, direction, friction):
    expected = column_limit(layout, friction, direction)
    spec = f"equilibrium:sides=frictionless,friction={friction}"
    (found,) = limits(layout, spec, directions=(direction,))
    assert found.limit_g == pytest.approx(expected, abs=1e-6)


def test_a_column_tips_by_the_lever_of_its_weakest_face():
    """By hand: a cube of 20 cm slides at 0.5; with one on top, 40 cm high, it tips at 10 / 20."""
    cube = (20.0, 20.0, 20.0)
    one = s.built("one", [s.Placed((0.0, 0.0, 0.0), cube, 2.0)])
    two = s.built("two", [s.Placed((0.0, 20.0 * k, 0.0), cube, 2.0) for k in range(2)])
    aside = s.built("aside", [s.Placed((0.0, 0.0, 0.0), cube, 2.0, (5.0, 0.0, 0.0))])
    past = s.built(
        "past",
        [s.Placed((0.0, 0.0, 0.0), cube, 2.0), s.Placed((15.0, 20.0, 0.0), cube, 20.0)],
    )
    assert column_limit(one, 0.6, 0.0) == pytest.approx(0.6)
    assert column_limit(one, 2.0, 0.0) == pytest.approx(1.0)
    assert column_limit(two, 0.6, 90.0) == pytest.approx(0.5)
    assert column_limit(aside, 2.0, 0.0) == pytest.approx(0.5)
    assert column_limit(aside, 2.0, 180.0) == pytest.approx(1.5)
    assert column_limit(past, 0.6, 0.0) == 0.0


@FEW
@given(s.overhanging_stacks())
def test_stacked_items_touch_the_one_below(layout):
    carries = layout.contacts.carries
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
    carries = layout.contacts.carries
    assert carries[0, 2]
    assert carries[1, 2]


def test_a_bridge_may_cover_its_left_support_whole():
    assert smallest(s.bridges(), lambda layout: layout.items[2].position[0] == 0.0)


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
    before = layout.contacts
    for moved in (translated(layout, along_x, along_z), quarter_turned(layout), mirrored(layout)):
        after = moved.contacts
        assert np.array_equal(before.carries, after.carries)
        assert np.allclose(before.areas, after.areas)
        assert np.array_equal(layout.weights, moved.weights)


TRANSLATED = PROPERTIES["translation"].cases(MethodUnderTest("lstm_1"))


def test_the_law_of_translation_moves_loads_along_both_sides():
    assert smallest(TRANSLATED, lambda case: min(case.change.values()) > 1.0)


@FEW
@given(TRANSLATED)
def test_the_law_of_translation_keeps_loads_on_pallets_that_the_method_judges(case):
    moved = translated(case.layout, case.change["along x"], case.change["along z"])
    widest = make_method("lstm_1").layout_range.pallet_side[1]
    assert max(moved.pallet.width, moved.pallet.depth) <= widest


@FEW
@given(s.ordinary_layouts())
def test_four_quarter_turns_and_two_mirrors_lead_back(layout):
    turned = quarter_turned(quarter_turned(quarter_turned(quarter_turned(layout))))
    for back in (turned, mirrored(mirrored(layout))):
        assert np.allclose(back.lower, layout.lower)
        assert np.allclose(back.mass_offsets, layout.mass_offsets)


NARROW = LayoutRange(
    pallet_side=(30.0, 90.0), shortest_side=(2.0, 30.0), longest_side=(4.0, 60.0),
    weight=(0.001, 50.0), weight_ratio=100.0, mass_offset=0.2,
)  # fmt: skip


@FEW
@given(s.layouts())
def test_what_is_brought_within_a_range_is_valid_and_inside(layout):
    sizes = layout.upper - layout.lower
    found = brought_within(layout, NARROW)
    assert len(found) == len(layout)
    ratio = found.weights.max() / found.weights.min()
    assert ratio <= 100.0
    assert (np.abs(found.mass_offsets) <= 0.2 * (found.upper - found.lower) + 1e-12).all()
    # One factor for all lengths; where one can do it, every side is inside then.
    sides = found.upper - found.lower
    factor = sides[0, 0] / sizes[0, 0]
    np.testing.assert_allclose(sides, sizes * factor, rtol=1e-12)
    np.testing.assert_allclose(found.lower, layout.lower * factor, atol=1e-9)
    low = max(2.0 / sizes.min(), 4.0 / sizes.max(axis=1).min())
    high = min(
        30.0 / sizes.min(axis=1).max(),
        60.0 / sizes.max(),
        90.0 / max(layout.pallet.size),
    )
    if low <= high:
        assert low * (1 - 1e-12) <= factor <= high * (1 + 1e-12)
        assert found.weights.min() >= 0.001
        assert found.weights.max() <= 50.0
        assert max(found.pallet.size) >= 30.0
    assert (found.floor.corners == brought_within(found, NARROW).floor.corners).all()


@FEW
@given(s.layouts())
def test_a_method_without_a_range_is_asked_about_layouts_as_they_are(layout):
    assert brought_within(layout, EVERY_LAYOUT).content_hash() == layout.content_hash()


@pytest.mark.parametrize("name", ["lstm_1", "lstm_e", "lstm_e:question=stands"])
def test_a_learner_judges_all_that_is_drawn_for_it(name):
    tested = MethodUnderTest(name)
    for asked in ("score", "far item", "tower", "floor", "translation"):
        outcome = search(PROPERTIES[asked], tested, examples=60, seed=2)
        assert (outcome.refused, outcome.counterexample) == (0, None), asked
        assert outcome.asked == outcome.examples


def test_a_learner_that_accepts_all_and_a_cascade_are_asked_about_every_layout():
    for name in ("lstm_1:outside=accept", "cascade@mujoco", "ps_opt@mujoco", "fbs"):
        assert make_method(name).layout_range == EVERY_LAYOUT, name


def test_the_limits_of_labels_are_those_of_the_preset_that_labels():
    for question, own_limits in LABEL_LIMITS.items():
        own = make_method(f"label@mujoco:question={question}").parameters
        expected = own.t_max, own.eps_t, own.eps_r, own.gravity
        assert expected == (
            own_limits.time, own_limits.displacement, own_limits.rotation, own_limits.gravity
        )  # fmt: skip


def test_a_box_that_tips_slowly_is_asked_only_of_those_who_wait():
    """10 cm wide, 33 cm high, 1 cm past the edge: it turns by 9.3 degrees in 0.3 s."""
    boxes = [
        s.Placed((0.0, 0.0, 0.0), (20.0, 5.0, 20.0), 0.5),
        s.Placed((16.0, 5.0, 0.0), (10.0, 33.0, 20.0), 1.65),
    ]
    change = {"past the edge [cm]": 1.0, "offset [cm]": 0.0, "width [cm]": 10.0}
    case = Case(s.built("edge", boxes), change)
    falls = PROPERTIES["past the edge"].check
    for waits in ("equilibrium", "settling", "lstm_e:question=stands", "label@mujoco:t_max=3"):
        assert falls(MethodUnderTest(waits), case), waits
    for name in ("lstm_1", "cascade@mujoco", "equilibrium:time=0.3", "label@mujoco"):
        assert not falls(MethodUnderTest(name), case), name

"""FBS, PBS and SME on examples worked by hand, and on all real schedules."""

import pytest
from hand_layouts import failing_step, layout

from steadyload.layouts.formats import read_layouts
from steadyload.layouts.model.scenarios import Scenario, apply_scenario
from steadyload.methods import make_method

FLOOR = (0.0, 0.0, 0.0, 10.0, 10.0, 10.0)


@pytest.mark.parametrize(
    ("shift", "fails"),
    # The upper box rests on (10 - shift) / 10 of its base.
    [
        (0.0, {"fbs": None, "pbs0.9": None, "pbs0.7": None, "pbs0.5": None}),
        (1.0, {"fbs": 1, "pbs0.9": None, "pbs0.7": None, "pbs0.5": None}),
        (2.0, {"fbs": 1, "pbs0.9": 1, "pbs0.7": None, "pbs0.5": None}),
        (4.0, {"fbs": 1, "pbs0.9": 1, "pbs0.7": 1, "pbs0.5": None}),
        (6.0, {"fbs": 1, "pbs0.9": 1, "pbs0.7": 1, "pbs0.5": 1}),
    ],
)
def test_base_support_of_two_boxes(shift, fails):
    lay = layout(FLOOR, (shift, 10.0, 0.0, 10.0, 10.0, 10.0))
    assert {spec: failing_step(spec, lay) for spec in fails} == fails


def test_base_support_adds_over_supporters_and_ignores_other_levels():
    # A bridge of 12 over a gap of 4 between two boxes of 10: (4 + 4) / 12 = 2/3 of its base rests.
    bridge = layout(
        FLOOR,
        (14.0, 0.0, 0.0, 10.0, 10.0, 10.0),
        (6.0, 10.0, 0.0, 12.0, 5.0, 10.0),
    )
    assert failing_step("pbs:alpha=0.66", bridge) is None
    assert failing_step("pbs:alpha=0.67", bridge) == 2
    # One support is 1 cm too low: only 4 / 12 is left.
    low = layout(FLOOR, (14.0, 0.0, 0.0, 10.0, 9.0, 10.0), (6.0, 10.0, 0.0, 12.0, 5.0, 10.0))
    assert failing_step("pbs:alpha=0.34", low) == 2
    assert failing_step("pbs:alpha=0.33", low) is None


def test_slivers_from_rounding_count_as_supported():
    # The base misses its support by 0.005 cm at one edge; two supporters stand 0.005 cm apart.
    assert failing_step("fbs", layout(FLOOR, (0.005, 10.0, 0.0, 10.0, 10.0, 10.0))) is None
    apart = (10.005, 0.0, 0.0, 10.0, 10.0, 10.0)
    assert failing_step("fbs", layout(FLOOR, apart, (5.0, 10.0, 0.0, 10.0, 5.0, 10.0))) is None
    # 0.02 cm is beyond the tolerance; and so is a missing corner of 1 cm2 under a base of 1 m2.
    assert failing_step("fbs", layout(FLOOR, (0.02, 10.0, 0.0, 10.0, 10.0, 10.0))) == 1
    slab = [(0.0, 0.0, 0.0, 99.0, 10.0, 100.0), (99.0, 0.0, 1.0, 1.0, 10.0, 99.0)]
    assert failing_step("fbs", layout(*slab, (0.0, 10.0, 0.0, 100.0, 5.0, 100.0))) == 2
    assert (
        failing_step("pbs:alpha=0.999", layout(*slab, (0.0, 10.0, 0.0, 100.0, 5.0, 100.0))) is None
    )


def test_only_items_placed_before_support():
    # The carrier comes after what it should carry.
    late = layout((0.0, 10.0, 0.0, 10.0, 10.0, 10.0), FLOOR)
    for spec in ("fbs", "pbs0.5", "sme"):
        assert failing_step(spec, late) == 0


def test_the_score_is_the_share_placed_safely():
    lay = layout(
        FLOOR,
        (20.0, 0.0, 0.0, 10.0, 10.0, 10.0),
        (40.0, 50.0, 0.0, 10.0, 10.0, 10.0),
        (60.0, 0.0, 0.0, 10.0, 10.0, 10.0),
    )
    verdict = make_method("fbs").judge(lay)
    assert (verdict.failing_step, verdict.score, verdict.moved_item) == (2, 0.5, 2)
    assert make_method("fbs").judge(lay.first(2)).score == 1.0


@pytest.mark.parametrize(
    ("shift", "offset", "fails"),
    [
        (5.0, 0.0, None),  # the centre of mass exactly above the edge: edges are included
        (5.001, 0.0, 1),
        (4.0, 1.5, 1),  # the centre of mass 0.5 cm outside although 60 % of the base rests
        (8.0, -4.0, None),  # 20 % of the base rests, the centre of mass is above it
    ],
)
def test_sme_asks_where_the_centre_of_mass_lies(shift, offset, fails):
    lay = layout(FLOOR, (shift, 10.0, 0.0, 10.0, 10.0, 10.0, 1.0, offset))
    assert failing_step("sme", lay) == fails


def test_sme_accepts_a_bridge_whose_centre_lies_over_the_gap():
    # Over no supporter's top, but strictly inside the hull of the contact rectangles.
    bridge = layout(FLOOR, (20.0, 0.0, 0.0, 10.0, 10.0, 10.0), (5.0, 10.0, 0.0, 20.0, 5.0, 10.0))
    assert failing_step("sme", bridge) is None
    # The contacts (7, 10) and (20, 21) x (0, 10); centre of mass at 14 - 7.5 = 6.5 < 7: outside
    # the hull, and over the lower box's top only down to x = 0: inside its rectangle.
    shifted = layout(
        FLOOR,
        (20.0, 0.0, 0.0, 10.0, 10.0, 10.0),
        (7.0, 10.0, 0.0, 14.0, 5.0, 10.0, 1.0, 6.5),
    )
    # centre 14 + 6.5 = 20.5: over the second box, whose top rectangle counts as a whole.
    assert failing_step("sme", shifted) is None


def test_sme_hull_is_strict(plate):
    assert failing_step("sme", plate(0.499)) is None
    assert failing_step("sme", plate(0.5)) == 2
    assert failing_step("sme", plate(0.501)) == 2


def test_sme_loads_the_items_below():
    # A 1 kg shelf stands 4 of 10 cm out; a heavy box on its outer end moves the resultant out.
    # Shelf: centre 9. Load of 3 kg at centre 12: (9 + 3 * 12) / 4 = 11.25 > 10.
    def loaded(weight):
        return layout(
            FLOOR,
            (4.0, 10.0, 0.0, 10.0, 2.0, 10.0),
            (10.0, 12.0, 0.0, 4.0, 4.0, 10.0, weight),
        )

    verdict = make_method("sme").judge(loaded(3.0))
    assert (verdict.failing_step, verdict.moved_item) == (2, 1)
    # Of 0.3 kg: (9 + 0.3 * 12) / 1.3 = 9.69 < 10.
    assert failing_step("sme", loaded(0.3)) is None


def test_sme_counts_only_what_lies_directly_on_top():
    # As above with 0.3 kg; then 100 kg on top of the load: the shelf does not feel it (a rule of
    # thumb, not physics), the load itself stands.
    lay = layout(
        FLOOR,
        (4.0, 10.0, 0.0, 10.0, 2.0, 10.0),
        (10.0, 12.0, 0.0, 4.0, 4.0, 10.0, 0.3),
        (10.0, 16.0, 0.0, 4.0, 4.0, 10.0, 100.0),
    )
    assert failing_step("sme", lay) is None


def test_shares_of_stable_real_layouts(aclpp_files):
    """An independent statement of the authors' rules gave .350, .939, .954 and .934."""
    read = [layout for file in aclpp_files for layout in read_layouts(file)]
    assert len(read) == len({layout.name for layout in read}) == 700
    layouts = [apply_scenario(layout.first(20), Scenario.S1, 0) for layout in read]
    for spec, expected in {"fbs": 0.350, "pbs0.7": 0.939, "pbs0.5": 0.954, "sme": 0.934}.items():
        verdicts = make_method(spec).judge_many(layouts)
        assert sum(v.stable for v in verdicts) / len(verdicts) == pytest.approx(expected, abs=0.01)

"""Heuristics that ask before they take a place, and what that gains and costs."""

import math

import pytest

from steadyload.layouts.packing.heuristics import HEURISTICS, pack_bins
from steadyload.layouts.packing.packing import ITEM_CLASSES, SPACE_RULES, make_instance, pack
from steadyload.methods import make_method
from steadyload.methods.contract import stopwatch
from steadyload.methods.session.stable_packing import pack_stably
from steadyload.reports.table import percent, plain_percent
from steadyload.studies.kit import Lab
from steadyload.studies.session import placing
from steadyload.studies.session.packing_gains import PACKED_BY, packing_gains
from steadyload.studies.session.placing import SCENES, session_curves
from steadyload.studies.session.showing import shown
from steadyload.studies.session.study import Session


@pytest.mark.parametrize("rule", SPACE_RULES)
def test_who_accepts_everything_changes_nothing(rule):
    instance = make_instance(2, 3, seed=4, item_count=30)
    plain = pack("a", instance.pallet, instance.sizes, rule)
    assert pack("a", instance.pallet, instance.sizes, rule, accept=lambda _: True).items == (
        plain.items
    )


def test_a_packed_item_is_asked_about_where_it_would_stand():
    instance = make_instance(2, 3, seed=4, item_count=30)
    asked = []

    def accept(item):
        asked.append(item)
        return item.position[1] == 0.0

    layout = pack("a", instance.pallet, instance.sizes, "back-bottom-left", accept=accept)
    assert layout.items == tuple(item for item in asked if item.position[1] == 0.0)
    assert len(asked) > len(layout)


@pytest.mark.parametrize("heuristic", HEURISTICS[3::13], ids=lambda h: h.name)
def test_heuristics_go_on_to_the_next_place_where_one_is_rejected(heuristic):
    instance = make_instance(3, 1, seed=4, item_count=12)

    def packed(rejected):
        """All items at their first place, but the last, whose first places are rejected."""
        asked = []

        def accept(which, box):
            asked.append((which, box))
            return len(asked) < 12 or len(asked) > 11 + rejected

        bins = pack_bins(instance.pallet.size, instance.sizes, heuristic, accept=accept)
        return bins, asked[11:]

    plain = pack_bins(instance.pallet.size, instance.sizes, heuristic)
    without, places = packed(10**6)
    assert len(set(places)) > 2
    assert sum(map(len, without)) == 11
    assert all(without), "a bin was opened for an item that stands nowhere"
    for rejected in range(min(len(places), 8)):
        bins, asked = packed(rejected)
        assert asked == places[: rejected + 1]
        which, box = asked[-1]
        assert bins[which][-1] == box
        assert rejected or bins == plain


@pytest.mark.parametrize("spec", ["fbs", "equilibrium", "ps_opt@mujoco"])
def test_bins_that_are_packed_stably_can_be_loaded(spec):
    instance, method = make_instance(2, 0, seed=4, item_count=15), make_method(spec)
    packing = pack_stably(instance, HEURISTICS[0], method)
    assert all(verdict.stable for verdict in method.judge_many(packing.layouts))
    assert sum(map(len, packing.layouts)) + packing.left_out == 15
    assert packing.placements - packing.rejected == 15 - packing.left_out
    assert packing.rejected > 0
    assert 0.0 < packing.judging < packing.seconds
    plain = pack_stably(instance, HEURISTICS[0], None)
    assert plain.placements == 0
    assert not all(verdict.stable for verdict in method.judge_many(plain.layouts))


@pytest.fixture(scope="module")
def gains(tmp_path_factory):
    lab = Lab(tmp_path_factory.mktemp("gains"))
    asked = {"judge": "equilibrium", "instances": 1, "heuristics": PACKED_BY[:2]}
    found = packing_gains(lab, ["fbs"], **asked)
    assert packing_gains(lab, ["fbs"], **asked).equals(found)
    return found


@pytest.fixture(scope="module")
def curves(tmp_path_factory):
    lab, specs = Lab(tmp_path_factory.mktemp("costs")), ["pbs0.7", "equilibrium"]
    found = session_curves(lab, specs, count=40)
    assert session_curves(lab, specs, count=40) == found
    return found[0]


@pytest.fixture(scope="module")
def found(gains, curves):
    return shown(curves, gains, {})


def test_a_method_that_rejects_gains_stable_bins(found):
    assert len(found.tasks) == len(ITEM_CLASSES)
    assert [one["title"] for one in found.first] == ["nobody", "FBS"]
    assert (found.nobody.title, found.best.title) == ("nobody", "FBS")
    assert math.isnan(found.nobody.rejected)
    assert found.best.stable.value == 1.0  # full support is balance
    assert found.nobody.stable.value < 1.0


def test_costs_are_measured_in_every_scene(curves):
    assert [curve.scene for curve in curves] == [scene.name for scene in SCENES for _ in range(2)]
    assert [[p[0] for p in curve.points] for curve in curves] == [[20, 40]] * 6
    assert all(min(p[1:]) > 0.0 for curve in curves for p in curve.points)


def test_the_page_shows_what_was_found(found, assert_shown):
    assert_shown(
        Session(),
        found,
        answer=[percent(found.best.stable), plain_percent(found.nobody.stable.value)],
        charts=["placements", "stable"],
    )


def test_a_placement_costs_its_own_box_and_substeps(told_time, tmp_path):
    told_time("mujoco", placing, stopwatch)
    spec = "simulation@mujoco:t_max=0.1,frequency=60,between_steps=reseat,samples=1"
    each = 20.0 + 6 * 1.0  # milliseconds of adding a box and of 0.1 s at 60 Hz
    curves, _ = session_curves(Lab(tmp_path), [spec], count=40)
    for curve in curves:
        assert [tuple(point) for point in curve.points] == [
            (20, pytest.approx(each), pytest.approx(20 * each)),
            (40, pytest.approx(each), pytest.approx(40 * each)),
        ]

"""Repairs: what is refused, what stays, what may change, and what is said of it."""

import dataclasses
import json
import math
import runpy
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import norm

import steadyload as sl
from steadyload.app import repair_options, repairs
from steadyload.app.checking import Answer, check
from steadyload.app.repair_results import Outcome, counted_repairs, repair_fields
from steadyload.app.repaired_files import write_repaired
from steadyload.app.repairs import RepairOptions, repair, repair_all, repair_each
from steadyload.errors import UserError
from steadyload.layouts.files.record import Refused
from steadyload.layouts.files.sources import Content
from steadyload.layouts.formats import Format, write_layouts
from steadyload.layouts.model.frame import Frame
from steadyload.layouts.model.layout import TOLERANCE, LayoutError
from steadyload.methods import make_method
from steadyload.repairing.confirmed import ConfirmedSearch, Stopped
from steadyload.repairing.search import Search
from steadyload.runs.scoring import read_entries
from steadyload.statics.bearing.crushing import first_crushed

PALLET = sl.Pallet(120, 160, 80)
PICTURES = runpy.run_path(str(Path(__file__).parents[2] / "docs" / "repair_pictures.py"))


def boxes(*told):
    """A layout of boxes of 40 x 30 x 40 cm, each (name, x, y, z)."""
    items = tuple(
        sl.Item(n, (x, y, z), (40, 30, 40), 12.0 - n, name=name)
        for n, (name, x, y, z) in enumerate(told)
    )
    return sl.Layout("plan", PALLET, items)


STANDS = boxes(("A", 0, 0, 0), ("B", 10, 30, 0))
LEANS = boxes(("A", 0, 0, 0), ("B", 25, 30, 0))
EARLY = boxes(("A", 0, 0, 0), ("TOP", 25, 30, 0), ("B", 40, 0, 0))
HOVERS = boxes(("A", 0, 0, 0), ("B", 0, 36, 0))


def turned_about_the_vertical(was, now):
    """Whether a box is the same but for where it is and a quarter about the vertical."""
    (w, h, d), (x, y, z) = was.size, was.mass_offset
    ways = [(was.size, (x, y, z)), ((d, h, w), (z, y, -x))]
    same = dataclasses.replace(
        now, sequence=was.sequence, position=was.position, size=was.size,
        mass_offset=was.mass_offset,
    ) == was  # fmt: skip
    return same and any(
        np.allclose(now.size, size) and np.allclose(now.mass_offset, offset)
        for size, offset in ways
    )


@pytest.mark.parametrize(
    ("options", "told"),
    [
        ({"allow": ["order", "mve"]}, "allow has 'mve'; did you mean 'move'?"),
        ({"allow": []}, "allow is []; allowed: one or more of order, drop, shift, turn"),
        ({"allow": "order"}, "allow is 'order'; allowed: one or more of order"),
        ({"allow": 7}, "allow is 7; allowed: one or more of order"),
        ({"allow": [None]}, "allow has missing; allowed: drop, leave"),
        ({"shift_cm": -1}, "shift_cm is -1; allowed: "),
        ({"margin_cm": -1}, "margin_cm is -1; allowed: "),
        ({"margin_cm": 11}, "margin_cm is 11; allowed: "),
        ({"margin_cm": math.nan}, "margin_cm is nan; allowed: "),
        ({"shift_cm": math.nan}, "shift_cm is nan; allowed: "),
        ({"seconds": 0}, "seconds is 0; allowed: a number of seconds above 0"),
        ({"seconds": None}, "seconds is missing; allowed: a number of seconds above 0"),
        ({"seconds": math.inf}, "seconds is inf; allowed: a number of seconds above 0"),
        ({"seed": -1}, "seed is -1; allowed: 0, 1, 2, ..."),
        ({"seed": 1.0}, "seed is 1.0; allowed: 0, 1, 2, ..."),
        ({"gaps_cm": -0.1}, "gaps_cm is -0.1; allowed: "),
        ({"method": "smee"}, "'smee'"),
    ],
    ids=str,
)
def test_an_option_that_is_not_allowed_is_told_with_what_is(options, told):
    with pytest.raises(UserError) as caught:
        repair(LEANS, **options)
    assert told in str(caught.value)
    with pytest.raises(LayoutError):
        repair("plan")


@pytest.mark.parametrize("gaps_cm", [2.0, 10.0])
def test_a_plan_that_stands_comes_back_as_the_same_object(gaps_cm):
    for plan in (STANDS, HOVERS):
        found = repair(plan, gaps_cm=gaps_cm)
        if plan is HOVERS and gaps_cm < 6.0:
            assert found.outcome is Outcome.REPAIRED
            assert [change.way for change in found.changes] == [(0.0, -6.0, 0.0)]
            continue
        assert found.layout is plan
        assert (found.outcome, found.stands) == (Outcome.UNCHANGED, True)
        assert (found.changes, found.origins) == ((), (0, 1))
        assert found.sentence == "stands as it is"
        assert found.after is found.before


@pytest.mark.parametrize("margin", [0.5, 2.0, 7.0, 10.0])
def test_a_repaired_plan_has_the_margin_that_is_asked_for(margin):
    found = repair(LEANS, ["shift"], margin_cm=margin)
    assert found.margin.cm == pytest.approx(margin, abs=2e-3)
    assert found.layout.items[1].position[0] == pytest.approx(20.0 - margin, abs=1e-3)
    assert make_method(f"equilibrium:margin={margin - 0.01}").judge(found.layout).stable
    assert found.to_dict()["margin_cm"] == round(found.margin.cm, 3)
    # Only the upper box can fall, and only along x: past the edge by 20 cm less its place.
    assert found.chance == pytest.approx(norm.cdf(margin / 0.5), abs=0.02)
    assert found.to_dict()["chance_5mm"] == found.chance


def test_where_no_plan_has_the_margin_half_of_it_is_looked_for():
    """At 23 cm the upper box leans still; it may be shifted by 6 cm, to a margin of 1 cm."""
    assert list(RepairOptions(margin_cm=2.0).margins_cm) == [2.0, 1.0, 0.5, 0.25, 0.0]
    assert list(RepairOptions(margin_cm=0.0).margins_cm) == [0.0]
    found = repair(LEANS, ["shift"], shift_cm=6.0)
    assert found.margin.cm == pytest.approx(1.0, abs=2e-3)
    assert found.layout.items[1].position[0] == pytest.approx(19.0, abs=1e-3)


@pytest.mark.parametrize(
    ("margin_cm", "firm", "asked"),
    [
        (2.0, 1.0, [0.0, 2.0, 1.0]),
        (4.0, 4.0, [0.0, 4.0]),
        (2.0, None, [0.0, 2.0, 1.0, 0.5, 0.25, 0.0]),
        (0.0, None, [0.0]),
    ],
)
def test_what_a_search_for_a_margin_does_not_find_stays_as_it_was_found_without(
    monkeypatch, margin_cm, firm, asked
):
    """After the first search, plans of the margin ``firm`` alone are confirmed."""
    margins = []

    class Search(ConfirmedSearch):
        def __init__(self, *rest):
            margins.append(rest[6])
            super().__init__(*rest)

        def run(self):
            found = super().run()
            is_kept = len(margins) == 1 or margins[-1] == firm
            return found if is_kept else dataclasses.replace(found, attempt=None)

    monkeypatch.setattr(repairs, "ConfirmedSearch", Search)
    repaired = repair(LEANS, ["shift"], margin_cm=margin_cm)
    assert repaired.outcome is Outcome.REPAIRED
    assert repaired.margin.cm == pytest.approx(firm or 0.5, abs=0.02)  # a box that moves has 0.5
    assert margins == asked


def test_a_narrow_box_has_the_margin_that_its_base_allows():
    plan = sl.Layout("pole", PALLET, (
        sl.Item(0, (0, 0, 0), (40, 30, 40), 12.0), sl.Item(1, (39, 30, 10), (3, 30, 3), 1.0),
    ))  # fmt: skip
    found = repair(plan, ["shift"])
    assert found.outcome == "repaired"
    assert found.margin.cm == pytest.approx(0.99 * 1.5, abs=0.01)


def test_another_order_alone_is_named_and_moves_nothing():
    found = repair(EARLY)
    assert found.by_order_alone
    assert found.sentence == "stands, by 7.5 cm, by another order of loading alone"
    assert found.origins == (0, 2, 1)
    assert [item.position for item in found.layout.items] == [
        EARLY.items[step].position for step in found.origins
    ]
    [change] = found.changes
    assert change.sentence() == "box B (3rd of 3) is loaded before box TOP (2nd of 3)"
    assert str(found).startswith("plan: stands, by 7.5 cm, by another order of loading alone [")
    assert str(found).endswith("]; box B (3rd of 3) is loaded before box TOP (2nd of 3)")


@pytest.mark.parametrize("method", ["equilibrium", "sme"])
def test_the_order_is_kept_where_it_may_not_change(method):
    found = repair(EARLY, ["drop", "shift", "turn", "move"], method=method)
    assert found.stands
    assert found.judged_by == str(sl.make_method(method).spec)
    assert found.origins == (0, 1, 2)
    assert found.moved > 0
    assert not found.by_order_alone
    assert not any(change.before or change.after for change in found.changes)


def test_a_plan_for_which_there_is_nothing_says_why_in_a_sentence():
    """One box too many for a deck of two, and nothing may stand on these."""
    low = sl.Pallet(80, 40, 40)
    base = [sl.Item(n, (40.0 * n, 0, 0), (40, 30, 40), 9.0, name=f"B{n}") for n in (0, 1)]
    plan = sl.Layout("full", low, (sl.Item(0, (20, 10, 0), (40, 30, 40), 9.0, name="AIR"),))
    assert repair(plan).stands  # it may come down
    assert not repair(plan, ["order"]).stands
    hopeless = sl.Layout(
        "hopeless",
        sl.Pallet(80, 70, 40, overhang=0.0),
        (*base, sl.Item(2, (0, 31, 0), (10, 39, 10), 2.0, (0, 0, 0), "TALL"),
         sl.Item(3, (70, 38, 30), (10, 30, 10), 2.0, (4.9, 0, 4.9), "FLOATS")),
    )  # fmt: skip
    for plan, kinds, box in ((LEANS, ["order"], "B"), (hopeless, ["order", "turn"], "TALL")):
        found = repair(plan, kinds, seconds=1.0)
        assert (found.outcome, found.stands) == (Outcome.NOT_REPAIRED, False)
        assert found.layout is plan
        assert (found.changes, found.left_out) == ((), ())
        assert found.reason.startswith(f"box {box} (")
        assert f"(allowed changes: {', '.join(kinds)})" in found.reason
        assert "\n" not in found.reason
        assert found.sentence == f"not repaired: {found.reason}"


@pytest.mark.parametrize("order", [True, False])
def test_what_is_left_out_is_said_and_only_where_that_is_allowed(order):
    kinds = ["order"] * order
    found = repair(LEANS, [*kinds, "leave"])
    assert found.stands
    assert [item.name for item in found.left_out] == ["B"]
    assert found.left_out[0] is LEANS.items[1]
    assert found.sentence == "stands, by 10 cm or more: 1 box left out"
    assert found.origins == (0,)
    assert [change.sentence() for change in found.changes] == ["box B (2nd of 2) is left out"]
    record = found.to_dict()
    assert (record["boxes_left_out"], record["steps_left_out"]) == (1, [1])
    kept = repair(LEANS, [*kinds, "shift"])
    assert len(kept.layout) == 2
    assert kept.left_out == ()


@pytest.mark.parametrize("count", [1, 2])
@pytest.mark.parametrize("kinds", [["leave"], ["drop", "leave"], ["drop"]])
def test_a_plan_of_which_every_box_would_be_left_out_is_not_repaired(count, kinds):
    """Their centres of mass lie beyond the deck."""
    over = tuple(
        sl.Item(n, (-9, 0, 40 * n), (10, 30, 40), 12.0, name="AB"[n]) for n in range(count)
    )
    plan = sl.Layout("plan", PALLET, over)
    found = repair(plan, kinds, seconds=1.0)
    others = ", nor has 1 other" * (count - 1)
    assert (found.outcome, found.layout, found.left_out) == (Outcome.NOT_REPAIRED, plan, ())
    assert found.reason == (
        f"box A (1st of {count}) has no free place where it stands{others} "
        f"(allowed changes: {', '.join(kinds)})"
    )


def test_a_plan_that_is_not_judged_stays_as_it_is_and_says_why():
    plan = boxes(("A", -9, 0, 0), ("B", 0, 30, 0))
    before = check(plan, "lstm_e:question=stands")
    assert before.answer is Answer.NOT_JUDGED
    found = repair(plan, method="lstm_e:question=stands")
    assert (found.outcome, found.layout, found.changes) == (Outcome.NOT_REPAIRED, plan, ())
    assert found.reason == f"not judged: {before.reason}"
    assert found.to_dict()["answer_before"] == "not judged"


@pytest.mark.parametrize(("plan", "outcome"), [(HOVERS, "unchanged"), (LEANS, "repaired")])
def test_without_a_limit_on_gaps_boxes_may_hover(plan, outcome):
    found = repair(plan, gaps_cm=None)
    assert (found.outcome, found.stands) == (outcome, True)


@pytest.mark.parametrize("allowed", [10.0, 20.0])
def test_no_box_bears_more_than_it_may(allowed):
    crushed = PICTURES["CRUSHED"]
    items = (dataclasses.replace(crushed.items[0], max_load=allowed), *crushed.items[1:])
    plan = dataclasses.replace(crushed, items=items)
    assert (first_crushed(plan) is None) == (allowed > 18.0)
    found = repair(plan)
    assert found.stands
    assert first_crushed(found.layout) is None
    assert (found.layout is plan) == (allowed > 18.0)
    limits = {item.name: item.max_load for item in found.layout.items}
    assert limits == {"EGGS": allowed, "CANS": None, "SKU-2003": None, "SKU-2004": None}


@pytest.mark.parametrize("seed", [0, 3])
@pytest.mark.parametrize("name", ["order", "crushed", "packed"])
def test_boxes_stay_upright_within_the_contour_and_apart(name, seed):
    [plan] = [plan for plan in PICTURES["plans"]() if plan.name == name]
    found = repair(plan, seed=seed)
    assert found.stands
    assert sorted(found.origins) == list(range(len(plan)))
    for step, now in zip(found.origins, found.layout.items, strict=True):
        assert turned_about_the_vertical(plan.items[step], now)
    low, high = plan.pallet.contour
    assert (found.layout.lower >= np.array(low) - TOLERANCE).all()
    assert (found.layout.upper <= np.array(high) + TOLERANCE).all()
    for one in range(len(plan)):
        for other in range(one):
            shared = np.minimum(found.layout.upper[one], found.layout.upper[other]) - np.maximum(
                found.layout.lower[one], found.layout.lower[other]
            )
            assert shared.min() <= TOLERANCE
    assert sl.check(found.layout, "equilibrium").stands


def test_the_same_seed_finds_the_same_plan():
    plan = [*PICTURES["plans"]()][-1]
    first, again = repair(plan, seed=5), repair(plan, seed=5)
    assert first.stopped is again.stopped is Stopped.DONE
    assert (first.layout.items, first.origins) == (again.layout.items, again.origins)
    assert first.changes == again.changes


def test_sentences_are_in_the_axes_and_the_unit_of_the_file():
    frame = Frame.of(sl.Dialect(units="mm", up="z"))
    [change] = repair(LEANS, frame=frame).changes
    centimetres = -change.way[0]
    assert 5.0 < centimetres < 10.0
    [told] = repair(LEANS, frame=frame).sentences
    assert told == f"box B (2nd of 2) moves {10 * centimetres:g} mm towards -y"


def test_a_record_holds_what_was_done_in_values_of_json():
    for plan, kinds in ((STANDS, ["order"]), (EARLY, ["order"]), (LEANS, ["shift"]),
                        (LEANS, ["order"]), (LEANS, ["leave"])):  # fmt: skip
        found = repair(plan, kinds)
        record = json.loads(json.dumps(found.to_dict(), allow_nan=False))
        assert record["layout"] == "plan"
        assert record["outcome"] == str(found.outcome)
        assert record["items"] == len(plan)
        assert record["answer_before"] == ("stands" if plan is STANDS else "fails")
        assert (record["answer_after"] == "stands") == found.stands
        assert record["failing_step_before"] == (None if plan is STANDS else 1)
        assert [change["sentence"] for change in record["changes"]] == found.sentences
        fields = repair_fields(found)
        assert fields["repair_changes"] == found.sentences
        done = found.outcome is Outcome.REPAIRED
        assert (fields["repair_boxes_moved"] is None) == (not done)
        assert repair_fields(None).keys() == fields.keys()
    moved = repair(LEANS, ["shift"]).to_dict()
    [change] = moved["changes"]
    assert moved["distance_cm"] == pytest.approx(abs(change["x_cm"]))
    assert (moved["boxes_moved"], change["turned"], change["new_step"]) == (1, False, 1)


def test_several_plans_keep_their_order_and_one_that_is_not_valid_is_an_outcome():
    bad = Refused("bad", LayoutError("has no boxes"))
    entries = [("a.json", LEANS), ("a.json", bad), ("b.json", STANDS)]
    found = repair_all(entries, RepairOptions(method="equilibrium"), workers=0)
    assert [one.outcome for one in found] == [
        Outcome.REPAIRED, Outcome.BAD_INPUT, Outcome.UNCHANGED,
    ]  # fmt: skip
    assert [one.file for one in found] == ["a.json", "a.json", "b.json"]
    assert (found[1].layout, found[1].reason) == (None, "has no boxes")
    assert {one.judged_by for one in found} == {"equilibrium", ""}
    assert counted_repairs(found) == "1 stands as it is, 1 repaired, 1 bad input"
    assert found[1].to_dict()["items"] is None


def test_an_interrupt_ends_a_search_with_the_best_plan_so_far(monkeypatch):
    """It comes when the first plan was confirmed: the next search of a neighbour sends it."""

    def interrupted(search, best):
        raise KeyboardInterrupt

    monkeypatch.setattr(Search, "neighbour", interrupted)
    found = repair(LEANS)
    assert (found.stands, found.stopped) == (True, Stopped.INTERRUPTED)
    told = []
    with pytest.raises(KeyboardInterrupt):
        told.extend(
            repair_each([("", STANDS), ("", LEANS), ("", EARLY)], RepairOptions(), workers=0)
        )
    assert [(place, one.stands) for place, one in told] == [(0, True), (1, True)]


def test_the_pictures_of_the_docs_are_those_that_are_made_now():
    """``python docs/repair_pictures.py`` makes them anew."""
    kept = {file.name: file.read_text() for file in sorted(PICTURES["FOLDER"].glob("*"))}
    assert kept == {name: f"{svg}\n" for name, svg in PICTURES["pictures"]()}


def test_a_file_is_written_from_the_content_that_was_read_and_from_no_path(tmp_path):
    file, target = tmp_path / "in.csv", tmp_path / "out.csv"
    write_layouts(file, [dataclasses.replace(LEANS, name="leans"), STANDS], Format.CSV)
    content = Content.of(file)
    found = repair_all(read_entries([content]), RepairOptions(method="sme"), workers=0)
    assert [one.file for one in found] == [str(file)] * 2
    file.unlink()
    write_repaired(content, target, found)
    for one, read in zip(found, sl.read(Content.of(target)), strict=True):
        assert read.items == one.layout.items
    with pytest.raises(LayoutError, match="is no content of a file; allowed: Content"):
        write_repaired(target, file, found)
    assert not file.exists()


def test_the_docs_name_the_margin_that_is_asked_for_unless_another_is_given():
    text = (Path(__file__).parents[2] / "docs" / "repair.md").read_text()
    assert f"with a margin of {repair_options.MARGIN_CM:g} cm, or `--margin CM`" in text
    assert f"{repair_options.SECONDS:g} s" in text

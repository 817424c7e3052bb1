"""The study of repairs: which plans fail, ways of changing them, labels so far, and its page."""

import csv
import io
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from steadyload.app.checking import check
from steadyload.app.repairs import Outcome
from steadyload.layouts import Item, Layout, Pallet
from steadyload.layouts.benchmark import load_benchmark
from steadyload.layouts.benchmark.parts import REAL
from steadyload.layouts.model.question import Question
from steadyload.layouts.packers.packed import PackerNotInstalledError
from steadyload.methods import make_method
from steadyload.reports.table import percent, plain_percent
from steadyload.runs.kept_only import kept_only
from steadyload.studies.kit import Lab
from steadyload.studies.repair import confirming, plans
from steadyload.studies.repair.counting import as_csv, summarise
from steadyload.studies.repair.one_pass import one_pass
from steadyload.studies.repair.packing_again import packed_again
from steadyload.studies.repair.plans import Plan, controls, plans_by_label, try_all
from steadyload.studies.repair.study import FILE, RepairStudy
from steadyload.studies.repair.ways import ALLOWED_BY, Way, changed_by, in_its_bin

JUDGE = "equilibrium"
BIN = Pallet(30.0, 60.0, 20.0, overhang=0.0)
CUBE = (10.0, 10.0, 10.0)


def loaded(name, *boxes, pallet=BIN):
    """A plan of boxes: lower corner, and sides where they are not those of a cube [cm]."""
    items = [
        Item(step, tuple(map(float, low)), tuple(map(float, *size)) if size else CUBE, 4.0 + step)
        for step, (low, *size) in enumerate(boxes)
    ]
    return Layout(name, pallet, tuple(items))


STANDS = loaded("stands", ((0, 0, 0),), ((0, 10, 0),), ((10, 0, 0),))
TOO_EARLY = loaded("too early", ((0, 10, 0),), ((0, 0, 0),))
HANGS_OVER = loaded("hangs over", ((0, 0, 0),), ((8, 10, 0),))
FULL = loaded(  # the last one hangs over; it stands nowhere unless the others move
    "full",
    ((0, 0, 0), (10, 60, 20)),
    ((10, 0, 0), (10, 50, 20)),
    ((10, 50, 0), (30, 10, 20)),
    pallet=Pallet(40.0, 60.0, 20.0, overhang=0.0),
)


@pytest.fixture(scope="module")
def real():
    return load_benchmark(REAL)


@pytest.fixture(scope="module")
def failing(real):
    return plans_by_label(real)[0]


def test_plans_that_fail_are_those_of_the_labels(real, failing):
    keys = ["layout", "scenario"]
    labels = [real.labels_on(question).set_index(keys) for question in Question]
    sources = real.layouts.set_index("layout")["sources"] if "layout" in real.layouts else None
    sources = real.layouts["sources"] if sources is None else sources
    fails = {
        layout
        for table in labels
        for (layout, scenario), row in table.iterrows()
        if scenario == "S1" and row["status"] == "done" and not pd.isna(row["failing_step"])
        and len(sources[layout])
    }  # fmt: skip
    assert sorted(one.layout.name for one in failing) == sorted(fails)
    sizes = [len(one.layout) for one in failing]
    assert sizes == sorted(sizes)
    assert all(one.packers and one.layout.mass_offsets.any() == 0 for one in failing)


def plan_row(layout, scenario="S1", packer="py3dbp", **label):
    usual = {
        "is_known": True, "settled": True, "stands": True, "labelled": True, "within": True,
        "items": 3, "instance": "i",
    }  # fmt: skip
    return {"layout": layout, "scenario": scenario, "packer": packer, **usual, **label}


@pytest.mark.parametrize(
    ("row", "fails"),
    [
        (plan_row("a"), False),
        (plan_row("a", stands=False), True),
        (plan_row("a", within=False), True),
        (plan_row("a", settled=False, stands=False), False),
        (plan_row("a", settled=False, stands=False, within=False), True),
        (plan_row("a", labelled=False, within=False), False),
        (plan_row("a", scenario="S2b", stands=False), False),
        (plan_row("a", is_known=False, stands=False), False),
    ],
)
def test_a_plan_fails_by_the_label_of_either_question(row, fails, monkeypatch):
    table = pd.DataFrame([row, plan_row("b", stands=False), plan_row("c")])
    monkeypatch.setattr(plans, "plans_of", lambda _: table)
    set_ = SimpleNamespace(layout=lambda name, _: STANDS.renamed(name))
    found, standing, labelled = plans_by_label(set_)
    assert [one.layout.name for one in found] == (["a", "b"] if fails else ["b"])
    assert [one.layout.name for one in standing] == (["a", "c"] if row == plan_row("a") else ["c"])
    known = row["is_known"] and row["scenario"] == "S1"
    assert labelled == (3 if known else 2)


def test_a_plan_of_two_packers_is_one_plan(monkeypatch):
    rows = [plan_row("a", packer=packer, stands=False) for packer in ("Packvium", "py3dbp")]
    monkeypatch.setattr(plans, "plans_of", lambda _: pd.DataFrame(rows))
    (one,), _, labelled = plans_by_label(SimpleNamespace(layout=lambda *_: STANDS))
    assert (one.packers, labelled) == (("Packvium", "py3dbp"), 1)


@pytest.mark.parametrize("plan", [STANDS, TOO_EARLY, HANGS_OVER, FULL], ids=lambda one: one.name)
def test_one_pass_leaves_only_what_is_balanced(plan):
    changed, origins = one_pass(plan)
    assert make_method("equilibrium").judge(changed).stable
    assert [item.weight for item in changed.items] == [plan.items[k].weight for k in origins]
    assert [sorted(item.size) for item in changed.items] == [
        sorted(plan.items[k].size) for k in origins
    ]
    kept = {"full": (0, 1)}.get(plan.name, tuple(range(len(plan))))
    assert origins == kept
    if plan is STANDS:
        assert [item.position for item in changed.items] == [i.position for i in plan.items]


@pytest.mark.parametrize(
    ("corner", "sides", "found", "turned"),
    [
        ((3, 10, 0), CUBE, (3, 10, 0), False),  # balanced with 2 cm to spare
        ((4.7, 10, 0), CUBE, (0, 10, 0), False),  # balanced by 0.3 cm alone
        ((8, 10, 0), CUBE, (0, 10, 0), False),  # down beside the other: 2 + 2 * 10 cm
        ((8, 10, 0), (12, 10, 6), (4, 10, 0), True),  # 8 cm if it is not turned
        ((12, 4, 0), (3, 3, 3), (12, 0, 0), False),  # in the air
    ],
)
def test_one_pass_takes_the_nearest_place_where_a_box_stands(corner, sides, found, turned):
    changed, _ = one_pass(loaded("p", ((0, 0, 0),), (corner, sides)))
    width, height, depth = map(float, sides)
    assert changed.items[1].size == ((depth, height, width) if turned else (width, height, depth))
    assert changed.items[1].position == tuple(map(float, found))


def support_of(layout, step):
    """Share of the base of a box that lies on others or on the floor."""
    low, high = layout.lower[step], layout.upper[step]
    if low[1] < 1e-6:
        return 1.0
    shared = np.minimum(layout.upper, high) - np.maximum(layout.lower, low)
    below = np.abs(layout.upper[:, 1] - low[1]) < 1e-6
    below[step] = False
    on = (np.maximum(shared[:, 0], 0.0) * np.maximum(shared[:, 2], 0.0))[below].sum()
    return on / ((high - low)[0] * (high - low)[2])


def kinds(items):
    return sorted((*sorted(round(side, 3) for side in item.size), item.weight) for item in items)


@pytest.mark.parametrize("place", [0, 1, 12, 40])
def test_what_is_packed_again_are_boxes_of_the_plan_with_their_bases_supported(failing, place):
    pytest.importorskip("packvium")
    plan = failing[place].layout
    changed, origins = packed_again(plan)
    assert changed.pallet == plan.pallet
    assert len(set(origins)) == len(changed)
    assert kinds(changed.items) == kinds(plan.items[step] for step in origins)
    for item, step in zip(changed.items, origins, strict=True):
        assert kinds([item]) == kinds([plan.items[step]])
    assert min(support_of(changed, step) for step in range(len(changed))) >= 0.75 - 1e-6
    assert min(support_of(plan, step) for step in range(len(plan))) < 0.75


def test_boxes_stand_out_over_a_deck_no_further_than_in_the_plan(failing):
    """Plans of software that lets boxes stand out over a pallet, among those that fail."""
    plan = next(each.layout for each in failing if each.layout.name == "0615614.order-4")
    bin_ = in_its_bin(plan)
    assert bin_.items == plan.items
    deck = (plan.pallet.width, plan.pallet.depth)
    out = [*-plan.lower[:, ::2].min(axis=0), *(plan.upper[:, ::2].max(axis=0) - deck)]
    assert max(out) > 0.0
    assert bin_.pallet.overhang == pytest.approx(max(out))


@pytest.mark.parametrize("place", [0, 40])
def test_walls_stand_where_no_box_of_a_plan_stands_out(failing, place):
    assert in_its_bin(failing[place].layout).pallet.overhang == 0.0


def centre(item):
    return np.array(item.position) + 0.5 * np.array(item.size)


@pytest.mark.parametrize("way", [way for way in Way if way is not Way.AGAIN])
@pytest.mark.parametrize("plan", [STANDS, TOO_EARLY, HANGS_OVER, FULL], ids=lambda one: one.name)
def test_a_row_says_what_differs(plan, way):
    row = changed_by(way, plan, JUDGE, 5.0)
    assert (row.plan, row.way, row.judge) == (plan.name, way, JUDGE)
    assert row.step_before == {"stands": None, "too early": 0, "full": 2}.get(plan.name, 1)
    assert row.seconds > 0.0
    if not row.stands:
        assert (row.boxes, row.moved, row.left_out) == ([], None, 0)
        assert way in (ALLOWED_BY if plan is STANDS else (Way.ORDER,))
        assert (row.outcome == Outcome.UNCHANGED) == (plan is STANDS)
        return
    changed = row.layout(plan.pallet)
    assert check(changed, JUDGE).stands
    assert len(changed) + row.left_out == len(plan)
    volumes = {item.weight: np.prod(item.size) for item in plan.items}
    lost = 1.0 - sum(volumes[item.weight] for item in changed.items) / sum(volumes.values())
    assert row.volume_left_out == pytest.approx(lost)
    was = {item.weight: centre(item) for item in plan.items}
    far = [np.linalg.norm(centre(item) - was[item.weight]) for item in changed.items]
    assert row.moved == sum(one > 0.0 for one in far)
    assert row.distance_cm == pytest.approx(sum(far))
    in_order = [item.weight for item in changed.items]
    assert row.retimed == (in_order != sorted(in_order))
    assert row.by_order_alone == (row.moved == 0 and row.left_out == 0)
    assert row.by_order_alone or way is not Way.ORDER


@pytest.fixture(scope="module")
def lab(tmp_path_factory):
    return Lab(tmp_path_factory.mktemp("repair"), 0)


@pytest.fixture(scope="module")
def tried(lab, real):
    return try_all(lab, real, limit=2)


def test_every_plan_is_changed_in_all_ways_and_judged_by_engines(tried, failing, real):
    names = [one.layout.name for one in failing[:2]]
    found = [(one.plan.layout.name, one.way) for one in tried.tried]
    assert found == [(name, way) for name in names for way in Way]
    assert tried.not_installed == ""
    repaired = [one for one in tried.tried if one.way is Way.LEAVE and one.changed.stands]
    [*own, control] = tried.answers
    assert [one.plan.layout.name for one in own] == [one.changed.plan for one in repaired] == names
    layouts = [one.changed.layout(one.plan.layout.pallet) for one in repaired]
    assert not control.repaired
    assert abs(len(control.plan.layout) - len(failing[0].layout)) <= 1
    for one, changed in zip(
        tried.answers, [*layouts, real.layout(control.plan.layout.name, "S1")], strict=True
    ):
        assert (changed.lower >= -1e-6).all()
        assert (changed.upper <= np.add(changed.pallet.size, 1e-6)).all(), "out of the bin"
        for title, said in one.engines.items():
            spec = f"ps_opt@{title.lower()}:question=stands"
            verdict = make_method(spec).judge(changed)
            assert (said.failing_step, said.stands) == (verdict.failing_step, verdict.stable)
        assert make_method("equilibrium").judge(changed).stable
        assert one.firmness.as_planned
        margin = one.firmness.margin_cm
        assert make_method(f"equilibrium:margin={margin - 0.01}").judge(changed).stable
        assert (
            margin == 10.0
            or not make_method(f"equilibrium:margin={margin + 0.01}").judge(changed).stable
        )
        assert not one.references
    assert all(one.firmness.chance > 0.99 for one in own)


def test_the_reference_goes_on_where_it_was_and_what_is_missing_is_counted(
    lab, real, tried, monkeypatch
):
    own, count = confirming.CloseSteps.measure, len(tried.answers)

    def limited(unit):
        if not told.left:
            raise KeyboardInterrupt
        told.left -= 1
        assert max(unit.steps) == len(unit.layout) - 1
        assert len(unit.steps) in (4, 5)
        return own(unit)

    def by_reference():
        with kept_only("none is measured"):
            again = try_all(lab, real, limit=2)
        assert [one.changed for one in again.tried] == [one.changed for one in tried.tried]
        found = summarise(real, again)
        rows = found.independent.set_index("judge").loc
        stiff, soft = rows[confirming.STIFF], rows[confirming.SOFT]
        cases = stiff["cases:repaired"], stiff["cases:control"], soft["cases:repaired"]
        return found.unfinished, *cases, stiff["stands:repaired"]

    told = SimpleNamespace(left=1)
    monkeypatch.setattr(confirming.CloseSteps, "measure", limited)
    assert by_reference()[:4] == (count, 0, 0, 0)
    with pytest.raises(KeyboardInterrupt):
        try_all(lab, real, limit=2, reference=True)
    assert by_reference()[:4] == (count, 1, 0, 0)
    told.left = 10**6
    try_all(lab, real, limit=2, reference=True)
    *counts, stands = by_reference()
    assert counts == [0, count - 1, 1, count - 1]
    assert (stands.value, stands.n) == (1.0, count - 1)


def planned(count, *, packers=("py3dbp",)):
    cubes = [((10 * k, 0, 0),) for k in range(count)]
    name = f"{count} of {packers[0]}"
    return Plan(loaded(name, *cubes, pallet=Pallet(200.0, 10.0, 10.0)), "i", packers)


def test_controls_are_the_nearest_in_size_of_the_same_packers_each_once():
    failing = [planned(count) for count in (2, 2, 2, 4, 5, 6, 7)]
    standing = [planned(count) for count in (1, 5, 9)] + [planned(7, packers=("other",))]
    sizes = [len(one.layout) for one in controls(failing, standing)]
    assert sizes == [1, 5, 9]
    assert [len(one.layout) for one in controls(failing[:4], standing[:1])] == [1]


def test_without_the_packer_the_other_ways_remain(lab, real, monkeypatch, assert_shown):
    def missing():
        raise PackerNotInstalledError("packing needs its package")

    monkeypatch.setattr("steadyload.studies.repair.ways.packer_versions", missing)
    found = summarise(real, try_all(lab, real, limit=2))
    assert {*found.all["way"]} == {*Way} - {Way.AGAIN}
    text = assert_shown(RepairStudy(), found, charts=["left_out", "moved"], drawn=False)
    assert "packing needs its package" in text


def test_the_page_shows_what_was_found(real, tried, tmp_path, assert_shown):
    found = summarise(real, tried)
    leave = found.leave
    answer = [percent(leave.stands), plain_percent(found.keep.stands.value)]
    assert_shown(RepairStudy(), found, answer=answer, charts=["left_out", "moved"])
    study = RepairStudy()
    study.beside(found, tmp_path)
    lines = list(csv.DictReader(io.StringIO((tmp_path / FILE).read_text())))
    assert len(lines) == len(tried.tried)
    for line, one in zip(lines, tried.tried, strict=True):
        assert (line["plan"], line["way"]) == (one.plan.layout.name, one.way)
        expected = str(one.changed.left_out) if one.changed.stands else ""
        assert line["boxes_left_out"] == expected


def test_a_set_of_which_nothing_is_repaired_has_a_page(real, tried, assert_shown):
    nothing = {"outcome": "not repaired", "boxes": [], "moved": None, "left_out": 0}
    failed = [replace(one, changed=replace(one.changed, **nothing)) for one in tried.tried]
    found = summarise(real, replace(tried, tried=failed, answers=[]))
    assert (len(found.firm), found.unfinished) == (0, 0)
    assert_shown(
        RepairStudy(), found, answer=[percent(found.leave.stands)], charts=["left_out", "moved"],
        drawn=False,
    )  # fmt: skip


def test_plans_that_stand_against_their_label_are_counted_on_the_page(real, tried, assert_shown):
    sentence = "stand by that judge, stay as they are and count as not repaired; "
    assert all(one.changed.outcome != Outcome.UNCHANGED for one in tried.tried)
    for count in (0, 1, 2):
        names = sorted({one.plan.layout.name for one in tried.tried})[:count]
        unchanged = {"outcome": Outcome.UNCHANGED, "boxes": [], "moved": None, "left_out": 0}
        rows = [
            replace(one, changed=replace(one.changed, **unchanged))
            if one.way is Way.LEAVE and one.plan.layout.name in names else one
            for one in tried.tried
        ]  # fmt: skip
        found = summarise(real, replace(tried, tried=rows))
        text = assert_shown(RepairStudy(), found, charts=["left_out", "moved"], drawn=False)
        left, kept = found.leave, found.keep
        assert left.failed == len({one.plan.layout.name for one in tried.tried}) - count
        assert left.repaired == sum(o.changed.stands for o in rows if o.way is Way.LEAVE)
        mended = f"of the {left.failed} that it sees fail {left.repaired} are repaired if boxes "
        mended += f"may be left out, {kept.repaired} if all are kept."
        assert (sentence in text) == (f"{count} {sentence}{mended}" in text) == bool(count)


def changed_plan(packers, boxes, *, instance, way=Way.LEAVE, **outcome):
    """A plan of cubes, with what a way made of it."""
    cubes = [((10 * k, 0, 0),) for k in range(boxes)]
    plan = loaded("p", *cubes, pallet=Pallet(200.0, 10.0, 10.0))
    usual = {"way": way, "plan": "p", "outcome": "repaired", "judge": JUDGE, "step_before": 1,
             "left_out": 0, "volume_left_out": 0.0, "moved": 0, "distance_cm": 0.0, "retimed": 0,
             "seconds": 1.0, "stopped": "done", "boxes": []}  # fmt: skip
    return plans.Tried(Plan(plan, instance, packers), way, plans.Changed(**usual | outcome))


def test_amounts_are_of_plans_that_stand_and_shares_of_all(real, assert_shown):
    own = [
        changed_plan(("A", "py3dbp"), 10, instance="i", left_out=2, volume_left_out=0.2, moved=3,
                     distance_cm=30.0, seconds=2.0),
        changed_plan(("py3dbp",), 6, instance="j", moved=1, distance_cm=50.0, retimed=2),
        changed_plan(("py3dbp",), 4, instance="k", retimed=1),
        changed_plan(("py3dbp",), 20, instance="k", moved=2, distance_cm=0.0),
        changed_plan(("Packvium",), 20, instance="l", outcome="not repaired", moved=None,
                     distance_cm=None, retimed=None, seconds=9.0, stopped="time"),
    ]  # fmt: skip
    others = [
        changed_plan(("py3dbp",), 5, instance="i", way=way) for way in Way if way is not Way.LEAVE
    ]
    found = summarise(real, plans.AllTried(9, [*own, *others], [], "", {}))
    assert_shown(
        RepairStudy(), found, answer=[percent(found.leave.stands)], charts=["left_out", "moved"],
        drawn=False,
    )  # fmt: skip
    row = found.leave
    assert (row.stands.n, row.timeouts, row.unchanged) == (5, 1, 0)
    assert (row.stands.value, row.none_out.value) == (0.8, 0.6)
    assert row.boxes_out.value == pytest.approx(2 / 40)
    assert row.volume_out.value == pytest.approx(2 / 40)
    assert (row.moved_median, row.moved.value) == (1.5, 1.5)
    assert row.moved_by.value == pytest.approx(80 / 6)
    assert row.retimed.value == pytest.approx(0.75)
    packers = found.by_packer[found.by_packer["way"] == Way.LEAVE].set_index("packer")["stands"]
    assert packers.map(lambda own: (own.value, own.n)).to_dict() == {
        "Packvium": (0.0, 1), "py3dbp": (1.0, 4),
    }  # fmt: skip
    cost = found.costs.iloc[0]
    assert (cost.boxes, cost.way, cost.cases) == ("all", Way.LEAVE, 5)
    assert (cost["median"], cost.worst) == (1.0, 9.0)
    until = found.until[0]
    assert (until["way"], until["out"], until["plans"]) == (Way.LEAVE, [0.0, 0.0, 0.0, 20.0], 5)
    assert until["moved"] == pytest.approx([0.0, 10.0, 100 / 6, 30.0])
    assert as_csv(own).count("\n") == 1 + len(own)


def answered(repaired, engine, stiff, soft, *, margin=3.0, chance=1.0, as_planned=True):
    """Answers on a plan: None for one that has not come yet."""
    firmness = confirming.Firmness(margin, as_planned, 1, chance, 0.1)
    said = {confirming.STIFF: stiff, confirming.SOFT: soft}
    return plans.Answers(
        planned(9), repaired, firmness, dict.fromkeys(confirming.ENGINES, engine),
        {title: one for title, one in said.items() if one is not None},
    )  # fmt: skip


def test_no_answer_is_no_yes_and_falls_by_soft_contacts_are_of_plans_that_stood(real):
    yes, no = confirming.Judged("done", None), confirming.Judged("done", 3)
    none = confirming.Judged("timeout", None)
    answers = [
        answered(True, yes, yes, no, margin=0.9, chance=0.94),
        answered(True, none, yes, yes),
        answered(True, no, no, no, margin=10.0, chance=0.95),
        answered(True, yes, yes, none, margin=0.1, as_planned=False, chance=0.0),
        answered(True, yes, yes, None, margin=None, as_planned=False),
        answered(False, yes, yes, yes),
    ]
    one = changed_plan(("py3dbp",), 10, instance="i")
    tried = [replace(one, way=way) for way in Way]
    found = summarise(real, plans.AllTried(1, tried, answers, "", {}))
    rows = found.independent.set_index("judge").loc
    dart, stiff, soft = (rows[name] for name in ("DART", confirming.STIFF, confirming.SOFT))
    for judge, *expected in ((dart, 5, 1, 0.6), (stiff, 5, 0, 0.8), (soft, 4, 1, 0.25)):
        counted = [judge[f"{name}:repaired"] for name in ("cases", "unknown")]
        assert [*counted, judge["stands:repaired"].value] == expected
    assert (soft["cases:control"], soft["stands:control"].value) == (1, 1.0)
    assert found.unfinished == 1
    assert (found.soft.value, found.soft.n) == (pytest.approx(2 / 3), 3)
    assert (found.soft_controls.value, found.soft_controls.n) == (0.0, 1)
    repaired, control = found.firm.itertuples()
    assert (repaired.cases, repaired.as_planned, repaired.margin_median) == (5, 3, 3.0)
    assert repaired.close.value == pytest.approx(1 / 3)
    assert repaired.firm.value == pytest.approx(2 / 3)
    assert repaired.p_stands.value == pytest.approx((0.94 + 1 + 0.95) / 3)
    assert (control.cases, control.firm.value) == (1, 1.0)

"""Packers' plans are counted by what the labels of a set say, and by why they fail."""

import math

import pandas as pd
import pytest

from steadyload.labelling.building.item_lists import CONTAINER
from steadyload.layouts import Item, Layout, Pallet
from steadyload.layouts.benchmark import BenchmarkError, load_benchmark
from steadyload.layouts.benchmark.dataset import row_of
from steadyload.layouts.benchmark.parts import PALLET_SOFTWARE
from steadyload.layouts.benchmark.tables import (
    CASES,
    LABELS,
    OPINIONS,
    UNLABELLED,
    write_further,
    write_tables,
)
from steadyload.reports.table import percent
from steadyload.studies.packed_plans import CONTAINERS, CUSTOMERS, EURO_PALLETS, OTHERS, plans_of
from steadyload.studies.packers.causes import Cause, cause_of, widest_gap
from steadyload.studies.packers.counting import PACKERS as ALL_PACKERS
from steadyload.studies.packers.counting import summarise
from steadyload.studies.packers.study import Packers

EURO = Pallet(80.0, 130.0, 120.0)
BOX = Pallet(*(float(CONTAINER[k]) for k in (1, 2, 0)))
CUBE = (10.0, 10.0, 10.0)

# Corner and sides of three boxes [cm]; what the last one does is in the name.
STACK = (((0, 0, 0), CUBE), ((0, 10, 0), CUBE), ((0, 20, 0), CUBE))
IN_THE_AIR = (((0, 0, 0), CUBE), ((20, 0, 0), CUBE), ((0, 30, 0), CUBE))
A_LITTLE_IN_THE_AIR = (((0, 0, 0), CUBE), ((20, 0, 0), CUBE), ((0, 12, 0), CUBE))
OUT = (((0, 0, 0), CUBE), ((6, 10, 0), CUBE), ((40, 0, 0), CUBE))
TIPPED = (((10, 0, 0), CUBE), ((0, 10, 0), (34, 5, 10)), ((24, 15, 0), CUBE))
BALANCED = (((10, 0, 0), CUBE), ((0, 10, 0), (34, 5, 10)), ((12, 15, 0), CUBE))


def loaded(name, boxes, pallet=EURO):
    items = [
        Item(k, tuple(map(float, low)), tuple(map(float, size)), 5.0)
        for k, (low, size) in enumerate(boxes)
    ]
    return Layout(name, pallet, tuple(items))


def plan(name, boxes, instance, *sources, pallet=EURO, **label):
    """A layout with its row of labels; without a word on it, it stands by both questions."""
    stable = {"status": "done", "failing_step": None, "stands": "done", "stands_step": None}
    return loaded(name, boxes, pallet), instance, sources, stable | {"moved_item": None} | label


def fails(step, moved, *, within=True):
    return {"failing_step": step if within else None, "stands_step": step, "moved_item": moved}


IN_ALL_SCENARIOS = ("A packvium 1", "A py3dbp 1")
PLANS = {
    each[0].name: each
    for each in (
        plan("A packvium 1", STACK, "i1", "packvium"),
        plan("A py3dbp 1", IN_THE_AIR, "i1", "py3dbp", **fails(2, 2)),
        plan("A packingsolver3d 1", OUT, "i1", "packingsolver3d", **fails(1, 1, within=False)),
        plan("B packvium 1", A_LITTLE_IN_THE_AIR, "i1", "packvium", "packvium-support-75"),
        plan("B py3dbp 1", TIPPED, "i1", "py3dbp", **fails(2, 1)),
        plan("C packvium 2", STACK, "i2", "packvium", pallet=BOX, stands="unsettled"),
        plan(
            *("C py3dbp 1", STACK, "i2", "py3dbp"),
            pallet=Pallet(50.0, 50.0, 50.0),
            status=UNLABELLED,
            stands="",
        ),
        plan("D py3dbp 1", BALANCED, "i3", "py3dbp", pallet=BOX, **fails(1, 1)),
        plan(
            *("E packingsolver3d 1", OUT, "i4", "packingsolver3d"),
            pallet=BOX,
            status="timeout",
            stands="timeout",
        ),
        plan("o.order-0", STACK, "o", PALLET_SOFTWARE, pallet=Pallet(80.0, 200.0, 120.0)),
    )
}
MANIFEST = {
    "origin": "real",
    "packers": {"names": ["py3dbp"], "versions": {"py3dbp": "1.1.2"}},
    "loading_order": "by height",
    "turning": "in any way",
}


def labelled(folder, plans, *, with_stands=True):
    """A set of plans; those of two lists are cases in all scenarios."""
    layouts = pd.DataFrame([row_of(layout, own, 0, tuple(by)) for layout, own, by, _ in plans])
    cases, stands = [], []
    for layout, _, _, label in plans:
        scenarios = ("S1", "S2a", "S2b") if layout.name in IN_ALL_SCENARIOS else ("S1",)
        for scenario in scenarios:
            own = {"layout": layout.name, "scenario": scenario}
            seen = {"corner_most": [0.0, 0.3, 10.8], "angle_most": [0.0, 1.7, 0.0]}
            seen["margin"] = [5.0, 0.05 if layout.name == "B packvium 1" else 5.0, 5.0]
            case = {"item_count": len(layout), "status": label["status"]}
            case |= {"failing_step": label["failing_step"]}
            cases.append(own | case | (seen if label["status"] == "done" else {}))
            falls = scenario == "S2b" and layout.name == "A packvium 1"
            step = 1 if falls else label["stands_step"]
            found = {"status": label["stands"], "failing_step": step}
            if label["stands"]:
                found |= {"question": "stands", "moved_item": label["moved_item"]}
                stands.append(own | found)
    frame = pd.DataFrame(cases).reindex(columns=CASES.names)
    write_tables(folder, layouts, frame, pd.DataFrame(columns=OPINIONS.names), MANIFEST)
    if with_stands:
        table = pd.DataFrame(stands).reindex(columns=LABELS.names)
        write_further(folder, "labels", table, {})
    return load_benchmark(folder)


@pytest.fixture(scope="module")
def real(tmp_path_factory):
    """A set of ten layouts of three boxes."""
    return labelled(tmp_path_factory.mktemp("packers") / "set", PLANS.values())


@pytest.fixture(scope="module")
def found(real):
    return summarise(real)


def one(rows, packer):
    (found,) = rows[rows["packer"] == packer].itertuples()
    return found


def shares(row):
    return row.within.value, row.stands.value, row.stands.n, row.unsettled


def test_plans_of_each_packer_are_counted_for_each_question(found):
    assert [*found.packers["packer"]] == [
        "PackingSolver", "Packvium", "Packvium (75 % supported)", "py3dbp", "palletising software"
    ]  # fmt: skip
    packvium, py3dbp = one(found.packers, "Packvium"), one(found.packers, "py3dbp")
    assert (packvium.lists, packvium.plans, packvium.plan_boxes) == (3, 3, 3.0)
    assert shares(packvium) == (1.0, 1.0, 2, 1)  # C is unsettled: stable within 0.3 s alone
    assert (py3dbp.lists, py3dbp.plans) == (3, 3)
    assert shares(py3dbp) == (0.0, 0.0, 3, 0)
    assert py3dbp.score.value == pytest.approx((2 / 3 + 2 / 3 + 1 / 3) / 3)
    assert shares(one(found.packers, "PackingSolver")) == (1.0, 0.0, 1, 0)
    assert shares(one(found.packers, "Packvium (75 % supported)")) == (1.0, 1.0, 1, 0)


def test_plans_are_counted_by_kind_of_list_and_by_scenario(found, real):
    assert [*map(tuple, found.kinds[["kind", "packer", "plans"]].values)] == [
        (CONTAINERS, "Packvium", 1), (CONTAINERS, "py3dbp", 1),
        (EURO_PALLETS, "PackingSolver", 1), (EURO_PALLETS, "Packvium", 2),
        (EURO_PALLETS, "Packvium (75 % supported)", 1), (EURO_PALLETS, "py3dbp", 2),
        (CUSTOMERS, "palletising software", 1),
    ]  # fmt: skip
    packvium, _ = found.scenarios.to_dict("records")
    assert [*found.scenarios["packer"]] == ["Packvium", "py3dbp"]
    stands = {s: packvium[f"stands_in:{s}"] for s in ("S1", "S2a", "S2b")}
    assert {s: (e.value, e.n) for s, e in stands.items()} == {
        "S1": (1.0, 1), "S2a": (1.0, 1), "S2b": (0.0, 1),
    }  # fmt: skip
    plans = plans_of(real).set_index("layout")
    assert (plans.loc["C py3dbp 1", "kind"], plans.loc["C py3dbp 1", "list"]) == (OTHERS, "C")
    assert plans.loc["o.order-0", "list"] == "o"


def test_plans_are_counted_by_size_and_customers_pallets_apart(tmp_path):
    """Boxes beside each other on the floor; labels say at which of them a plan fails."""

    def wall(name, count, source, **label):
        spots = [((10 * (k % 8), 0, 10 * (k // 8)), CUBE) for k in range(count)]
        return plan(name, spots, name[0], source, **label)

    plans = [
        wall("A py3dbp 1", 30, "py3dbp"),
        wall("B py3dbp 1", 61, "py3dbp", **fails(2, 2)),
        wall("C packvium 1", 62, "packvium"),
        wall("D py3dbp 1", 62, "py3dbp", **fails(2, 2)),
        wall("o.order-0", 61, PALLET_SOFTWARE),
        wall("p.order-0", 90, PALLET_SOFTWARE, status=UNLABELLED, stands=""),
    ]
    found = summarise(labelled(tmp_path / "set", plans))
    assert [
        (r.boxes, r.packer, r.stands.value, r.stands.n) for r in found.sizes.itertuples()
    ] == [
        ("25 to 61", ALL_PACKERS, 0.5, 2), ("25 to 61", "py3dbp", 0.5, 2),
        ("25 to 61", "palletising software", 1.0, 1),
        ("62 to 100", ALL_PACKERS, 0.5, 2), ("62 to 100", "Packvium", 1.0, 1),
        ("62 to 100", "py3dbp", 0.0, 1),
    ]  # fmt: skip
    assert [row["packer"] for row in found.of_packers] == ["py3dbp", "Packvium"]
    assert [row["packer"] for row in found.of_customers] == ["palletising software"]


def test_packers_are_compared_on_lists_of_which_both_have_a_plan(found):
    assert {
        (pair.first, pair.second): (pair.lists, pair.only_it.value, pair.only_other.value)
        for pair in found.pairs.itertuples()
    } == {
        ("PackingSolver", "Packvium"): (1, 0.0, 1.0),
        ("PackingSolver", "py3dbp"): (1, 0.0, 0.0),
        ("Packvium", "Packvium (75 % supported)"): (1, 0.0, 0.0),
        ("Packvium", "py3dbp"): (2, 1.0, 0.0),
        ("Packvium (75 % supported)", "py3dbp"): (1, 1.0, 0.0),
    }
    assert (found.pairs["p_shown"] == 1.0).all()  # one instance says nothing


def test_causes_of_failures(found):
    causes = found.causes.set_index("packer")
    py3dbp = causes.loc["py3dbp"]
    assert {cause: py3dbp[f"cause:{cause}"].value for cause in Cause} == {
        Cause.NOTHING: pytest.approx(1 / 3), Cause.OUT: 0.0,
        Cause.BELOW: pytest.approx(1 / 3), Cause.BALANCED: pytest.approx(1 / 3),
    }  # fmt: skip
    assert py3dbp.own.value == pytest.approx(2 / 3)  # of B box 1 moves, and box 2 was placed
    assert causes.loc["PackingSolver", f"cause:{Cause.OUT}"].value == 1.0
    assert (causes.index[-1], causes.loc["all", "plans"]) == ("all", 4)
    assert {*found.commonest} == {*Cause}
    [failed] = (row for row in found.failed_by if row["packer"] == "py3dbp")
    assert (failed["shares"], failed["plans"]) == (pytest.approx([1 / 3, 2 / 3, 2 / 3]), 3)


@pytest.mark.parametrize(
    ("boxes", "step", "cause"),
    [
        (STACK, 0, Cause.BALANCED),
        (STACK, 2, Cause.BALANCED),
        (IN_THE_AIR, 2, Cause.NOTHING),
        (OUT, 1, Cause.OUT),
        (OUT, 2, Cause.BALANCED),  # it stands on the floor, whatever fell before it
        (TIPPED, 1, Cause.BALANCED),
        (TIPPED, 2, Cause.BELOW),
        (BALANCED, 2, Cause.BALANCED),
        (STACK[::2], 1, Cause.NOTHING),  # what would carry it is never placed
    ],
)
def test_a_cause_is_that_of_the_box_just_placed(boxes, step, cause):
    assert cause_of(loaded("one", boxes), step) is cause


def test_gaps_below_boxes():
    assert widest_gap(loaded("none", STACK)) == 0.0
    assert widest_gap(loaded("small", A_LITTLE_IN_THE_AIR)) == 2.0
    assert widest_gap(loaded("large", IN_THE_AIR)) == 20.0
    assert widest_gap(loaded("over the floor", (((0, 7, 0), CUBE),))) == 7.0


def test_the_worst_plan_is_drawn_at_its_failing_step(found):
    packing, py3dbp = found.worst
    seen = [py3dbp[name] for name in ("layout", "step", "boxes", "moved_item", "is_late")]
    assert seen == ["D py3dbp 1", 1, 3, 1, False]
    assert len(py3dbp["drawn"]) == 2
    assert packing["is_late"]
    assert (packing["displacement_cm"], packing["rotation_deg"]) == pytest.approx((0.3, 1.7))


def test_of_equally_bad_plans_the_largest_is_the_worst(tmp_path):
    more = [*IN_THE_AIR, *(((40, 0, 20 * k), CUBE) for k in range(3))]
    small = plan("A py3dbp 1", OUT, "i1", "py3dbp", **fails(1, 1))
    large = plan("B py3dbp 1", more, "i1", "py3dbp", **fails(2, None))
    plans = [small, large]
    (worst,) = summarise(labelled(tmp_path / "set", plans)).worst
    assert (worst["layout"], worst["moved_item"]) == ("B py3dbp 1", None)


def test_plans_without_a_label_are_counted_apart(found):
    py3dbp, packing = one(found.coverage, "py3dbp"), one(found.coverage, "PackingSolver")
    assert (py3dbp.plans, py3dbp.known, py3dbp.new, py3dbp.failed) == (4, 3, 1, 0)
    assert (packing.plans, packing.known, packing.new, packing.failed) == (2, 1, 0, 1)
    assert math.isnan(packing.boxes_new)
    packvium = one(found.coverage, "Packvium")
    assert (packvium.narrow.value, packvium.in_air.value, packvium.widest_gap) == (0.5, 0.5, 2.0)


def test_the_page_shows_what_was_found(found, assert_shown):
    assert_shown(
        Packers(),
        found,
        answer=[percent(found.of_packers[0]["stands"]), "100.0"],
        charts=["stands", "failed_by", "worst_0", "worst_1"],
    )
    assert found.spared == ["Packvium", "Packvium (75 % supported)", "palletising software"]
    assert found.made_with["packers"] == "py3dbp 1.1.2"


def test_a_set_whose_plans_all_stand_has_a_page(tmp_path, assert_shown):
    benchmark = labelled(tmp_path / "set", [PLANS["A packvium 1"], PLANS["o.order-0"]])
    found = summarise(benchmark)
    assert (found.worst, len(found.causes), found.commonest, found.missing) == ([], 0, [], 0)
    assert_shown(Packers(), found, charts=["stands", "failed_by"], drawn=False)


@pytest.mark.parametrize("with_stands", [True, False])
def test_a_set_without_labels_of_packers_is_refused(tmp_path, with_stands):
    unlabelled = [PLANS["C packvium 2"], PLANS["C py3dbp 1"]]
    with pytest.raises(BenchmarkError, match=r"no plan of a packer .* has a label of whether"):
        summarise(labelled(tmp_path / "set", unlabelled, with_stands=with_stands))

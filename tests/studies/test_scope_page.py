"""The study of scopes: what it counts is what is counted by hand."""

import dataclasses

import numpy as np
import pandas as pd
import pytest

from steadyload.labelling.screening import label_screened
from steadyload.layouts import Item, Layout, Pallet
from steadyload.layouts.benchmark import load_benchmark
from steadyload.layouts.benchmark.dataset import KEYS, Benchmark, row_of
from steadyload.layouts.benchmark.tables import CASES, OPINIONS, UNLABELLED, write_tables
from steadyload.layouts.model.question import Question
from steadyload.reports.table import compact
from steadyload.runs.results import load_results
from steadyload.studies.kit import Lab
from steadyload.studies.scope import comparing
from steadyload.studies.scope.balanced_steps import (
    Balance,
    MovedStep,
    balance_of,
    balanced_steps,
    steps_of,
)
from steadyload.studies.scope.comparing import (
    drawn_cases,
    option_title,
    size_groups,
)
from steadyload.studies.scope.study import Scope

MOVING = "label@mujoco:scope=moving"
STANDING = "label@mujoco:question=stands,scope=moving"
SIDE = 20.0


def cubes(name, *corners):
    """Cubes of 20 cm with some left-bottom-back corners."""
    items = tuple(
        Item(k, tuple(map(float, at)), (SIDE, SIDE, SIDE), 5.0) for k, at in enumerate(corners)
    )
    return Layout(name, Pallet(100.0, 200.0, 100.0), items)


TOWER = cubes("tower", (0, 0, 0), (0, 20, 0), (0, 40, 0))
ROW = cubes("row", (0, 0, 0), (30, 0, 0), (60, 0, 0), (0, 20, 0))
EDGE = cubes("edge", (0, 0, 0), (15, 20, 0), (50, 0, 50))
"""The second cube overhangs the first by three quarters of its side, and falls."""


@pytest.fixture(scope="module")
def labelled(tmp_path_factory):
    """A set of three layouts, two in train and one in validation, labelled by screening."""
    folder = tmp_path_factory.mktemp("scope") / "set"
    layouts = pd.DataFrame(
        [
            row_of(TOWER, "A", 0, ("packer one",)),
            row_of(ROW, "B", 0, ("packer two", "packer one")),
            row_of(EDGE, "C", 0, ("packer two",)),
        ]
    )
    cases = pd.DataFrame(
        {
            "layout": ["tower", "row", "edge"],
            "scenario": "S1",
            "item_count": [3, 4, 3],
            "status": UNLABELLED,
        }
    )
    none = pd.DataFrame(columns=OPINIONS.names)
    write_tables(folder, layouts, cases.reindex(columns=CASES.names), none, {"origin": "a test"})
    label_screened(folder)
    found = load_benchmark(folder)
    splits = found.cases.assign(split=["train", "train", "validation"], rank=[0, 1, 0])
    splits = splits.astype({"rank": "Int32"})
    kept = {"keep_further": True}
    layouts = found.layouts.reset_index()
    write_tables(folder, layouts, splits[CASES.names], found.opinions, found.manifest, **kept)
    return folder


def compared(labelled, work, options):
    """The results of all cases of the set."""
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(comparing, "REAL", labelled)
        patched.setattr(comparing, "OPTIONS", options)
        return Scope().run(Lab(work, workers=0))


@pytest.fixture(scope="module")
def result(labelled, tmp_path_factory):
    work = tmp_path_factory.mktemp("scope-work")
    options = {
        Question.WITHIN: ("label@mujoco", MOVING),
        Question.STANDS: ("label@mujoco:question=stands", STANDING),
    }
    return work, compared(labelled, work, options)


def test_the_numbers_of_a_table_are_those_counted_by_hand(result):
    work, found = result
    table, _ = found.tables
    assert (table.cases, table.layouts, table.instances) == (3, 3, 3)
    row = table.named
    assert len(table.options) == 1
    rows = load_results(work / "within").set_index(["method", "layout"])
    whole, own = rows.loc["label@mujoco"], rows.loc[MOVING]
    assert whole["failing_step"].isna().to_dict() == {"edge": False, "row": True, "tower": True}
    assert whole.loc["edge", "failing_step"] == own.loc["edge", "failing_step"] == 1
    assert (row.alike.value, row.alike.n, row.cases) == (1.0, 3, 3)
    assert row.changes == "0 / 0 / 0"
    assert pd.isna(row.without_verdict)
    assert (table.column, row.right.value) == ("right", 1.0)
    assert row.difference.value == 0.0
    assert row.p == 1.0
    assert table.rows.loc["label@mujoco", ["p", "alike"]].isna().all()
    cpu, cpu_whole = own["cpu_total"], whole["cpu_total"]
    assert row.cpu_median == pytest.approx(cpu.median() / cpu_whole.median())
    assert row.cpu_paired.value == pytest.approx((cpu / cpu_whole).median())
    assert row.cost_ratio.value == pytest.approx(cpu.sum() / cpu_whole.sum())
    # Nothing of what balances is simulated: of `edge`, two cubes until the second one falls.
    assert own["body_substeps"].to_dict() == {"edge": own.loc["edge", "body_substeps"]} | {
        "row": 0,
        "tower": 0,
    }
    # 144 substeps a placement, of one cube, then two, ...; the third of `edge` is not placed.
    assert whole.loc["tower", "body_substeps"] == 144 * (1 + 2 + 3)
    assert whole.loc["row", "body_substeps"] == 144 * (1 + 2 + 3 + 4)
    expected = own["body_substeps"].sum() / whole["body_substeps"].sum()
    assert row.body_ratio == pytest.approx(expected)
    assert [row[f"alike_boxes:{boxes}"].n for boxes in (3, 4)] == [2, 1]
    assert row["cpu_boxes:4"] == pytest.approx(cpu["row"] / cpu_whole["row"])
    small = ["edge", "tower"]
    assert row["cpu_boxes:3"] == pytest.approx(cpu[small].median() / cpu_whole[small].median())


def test_an_option_that_fails_elsewhere_is_earlier_or_later(labelled, tmp_path):
    # Beyond 1 um everything has moved too far at once; within 10 m nothing ever does.
    loose, strict = "label@mujoco:eps_t=1000,eps_r=180", "label@mujoco:eps_t=0.0001,eps_r=0.001"
    options = {Question.WITHIN: ("label@mujoco", loose, strict)}
    (table,) = compared(labelled, tmp_path, options).tables
    later, earlier = (row for _, row in table.options.iterrows())
    assert later.changes == "0 / 1 / 0"
    assert later.alike.value == pytest.approx(2 / 3)
    assert later.changed.value == pytest.approx(1 / 3)
    assert earlier.changes == "3 / 0 / 0"
    assert earlier.alike.value == 0.0
    assert earlier.difference.value == -1.0
    assert table.named.equals(later), "none keeps nearly all, and that one keeps most"


def test_the_steps_of_a_set_are_counted_by_balance(labelled):
    benchmark = load_benchmark(labelled)
    steps = steps_of(benchmark).set_index(["layout", "step"])
    found = balanced_steps(benchmark)
    assert (found.steps, found.cases, found.instances) == (len(steps), 3, 3)
    assert set(steps["balance"].loc["tower"]) == {Balance.BALANCES}
    assert steps["balance"].loc["edge"].tolist()[:2] == [Balance.BALANCES, Balance.OUT]
    assert steps["margin"].loc[("tower", 0)] == pytest.approx(10.0)  # half a side
    assert steps["margin"].loc[("edge", 1)] == pytest.approx(-5.0)  # hull ends 5 cm before it
    balanced = found.known
    assert (balanced.steps, balanced.cases, balanced.far.value) == (3 + 4 + 1, 3, 0.0)
    assert balanced.most < 0.05
    (out,) = (row for row in found.first if row.balance is Balance.OUT)
    assert (out.steps, out.too_far.value) == (1, 1.0)
    assert (found.whole, found.failing) == (2, {"within": 0, "stands": 0})
    assert found.exceptions == []
    assert found.again == (0, 0)


def test_what_moves_again_beside_a_step_that_balances_is_counted(labelled):
    benchmark = load_benchmark(labelled)
    margin = np.array([10.0, 10.0, -1.0, 10.0], dtype="float32")
    of_row = benchmark.cases["layout"] == "row"

    def lists(name, values, frame, rows):
        both = zip(rows, frame[name], strict=True)
        return frame.assign(**{name: [values if here else other for here, other in both]})

    cases = lists("margin", margin, benchmark.cases, of_row)
    cases = lists("moved", np.array([0, 1, 1, 1]), cases, of_row)
    of_row = benchmark.screening["layout"] == "row"
    far = np.array([0.0, 0.0, 0.7, 0.8], dtype="float32")
    screening = lists("screen", far, benchmark.screening, of_row)
    found = balanced_steps(dataclasses.replace(benchmark, cases=cases, screening=screening))
    assert found.again == (1, 1)
    assert found.known.steps == 3 + 2 + 1
    assert [
        (row.steps, row.far.value) for row in found.later if row.balance is Balance.BALANCES
    ] == [(1, 1.0)]
    assert found.whole == 1


def test_a_step_that_balances_and_moves_is_named(labelled):
    benchmark = load_benchmark(labelled)
    far = np.array([0.0, 0.8, 0.0, 1.2], dtype="float32")
    seen = zip(benchmark.screening["layout"], benchmark.screening["screen"], strict=True)
    screening = benchmark.screening.assign(
        screen=[far if layout == "row" else screen for layout, screen in seen]
    )
    found = balanced_steps(dataclasses.replace(benchmark, screening=screening))
    assert [(e.layout, e.step) for e in found.exceptions] == [("row", 1), ("row", 3)]
    row = found.known
    assert row.far.value == pytest.approx(2 / 8)
    assert row.too_far.value == pytest.approx(1 / 8)
    assert row.most == pytest.approx(1.2)


@pytest.mark.parametrize(
    ("margin", "balance"),
    [(0.01, "BALANCES"), (0.009, "NARROW"), (-0.009, "NARROW"), (-0.01, "OUT"), (3.0, "BALANCES")],
)
def test_a_margin_of_a_tenth_of_a_millimetre_is_enough(margin, balance):
    stored = round(float(np.float32(margin)), 3)
    assert balance_of(stored) is Balance[balance]


def test_cases_are_drawn_in_turns_over_sources_and_scenarios(labelled):
    benchmark = load_benchmark(labelled)
    chosen = drawn_cases(benchmark, 2)
    assert list(zip(chosen["layout"], chosen["source"], strict=True)) == [
        ("tower", "packer one"),
        ("edge", "packer two"),
    ]
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(comparing, "MOST_ITEMS", 3)
        assert drawn_cases(benchmark, 9)["layout"].tolist() == ["tower", "edge"]


def test_cases_of_the_test_split_are_not_drawn(labelled):
    benchmark = load_benchmark(labelled)
    held_out = benchmark.cases.assign(split=["test", "train", "validation"])
    drawn = drawn_cases(Benchmark(benchmark.layouts, held_out, benchmark.opinions, {}), 9)
    assert set(drawn["layout"]) == {"row", "edge"}


def test_the_set_drawn_has_the_labels_of_both_questions(labelled):
    whole = load_benchmark(labelled)
    chosen = drawn_cases(whole, 2)
    drawn = whole.drawn(chosen)
    assert drawn.select()["layout"].tolist() == chosen["layout"].tolist()
    for question in Question:
        of_drawn, of_whole = (
            b.select(question=question).set_index(KEYS)["failing_step"] for b in (drawn, whole)
        )
        assert of_drawn.sort_index().equals(of_whole.drop(("row", "S1")).sort_index())


def test_the_page_shows_what_was_found(result, assert_shown):
    _, found = result
    named = [own.named for own in found.tables]
    assert [own.title for own in named] == ["`scope=moving`"] * 2
    moved = MovedStep("a|b", "S1", 3, 0.5, 2, 0.75, 0.5)
    steps = dataclasses.replace(found.steps, exceptions=[moved])
    text = assert_shown(
        Scope(),
        comparing.Found(**vars(found) | {"steps": steps}),
        answer=[*(compact(own.cost_ratio.value) for own in named), "100.0"],
        charts=["changed_verdicts"],
    )
    assert "a\\|b" in text


@pytest.mark.parametrize(
    ("counts", "titles", "groups"),
    [
        ([31, 25, 25, 30, 40, 45], ["25", "30 to 31", "40 to 45"], [1, 0, 0, 1, 2, 2]),
        ([25, 25, 25], ["25"], [0, 0, 0]),
        ([30, 25], ["25", "30"], [1, 0]),
    ],
)
def test_sizes_make_groups_of_as_many_cases(counts, titles, groups):
    place, named = size_groups(pd.Series(counts))
    assert (place.tolist(), [*named.values()]) == (groups, titles)


def test_an_option_is_named_by_what_it_changes(result):
    _, found = result
    _, table = found.tables
    row = table.named
    assert row.title == "`scope=moving`"
    whole = table.rows["key"]["label@mujoco:question=stands"]
    assert option_title(whole, whole) == "whole pile"
    bullet = dataclasses.replace(row.key, spec="label@bullet:scope=local", engine="bullet")
    assert option_title(bullet, whole) == "`scope=local` on bullet"
    assert (
        option_title(dataclasses.replace(bullet, spec="label@bullet"), whole)
        == "whole pile on bullet"
    )

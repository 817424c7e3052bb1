"""Labels by screening are those of an ordinary labelling, for both questions."""

import dataclasses
import math
import shutil
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from steadyload.labelling import screened_loading, screening
from steadyload.labelling.label_rows import LABEL
from steadyload.labelling.labelling import label_set
from steadyload.labelling.screened import checked_screening
from steadyload.labelling.screened_loading import SCREEN, SCREENS, ByTwo, affecting
from steadyload.labelling.screening import (
    ScreenedUnit,
    keep_again,
    keep_begun,
    label_again,
    label_screened,
    screened_row,
)
from steadyload.layouts import Item, Layout, Pallet
from steadyload.layouts.benchmark import BenchmarkError, load_benchmark
from steadyload.layouts.benchmark.dataset import KEYS
from steadyload.layouts.benchmark.tables import (
    CASES,
    OPINIONS,
    UNLABELLED,
    read_tables,
    write_tables,
)
from steadyload.layouts.model.question import Question
from steadyload.methods.contract.method import Status
from steadyload.methods.registry import make_method
from steadyload.methods.simulation.step_answers import StepAnswer, StepAnswers


@pytest.fixture(scope="module")
def shipped():
    """Cases of the shipped set that have labels of both questions; of some these differ."""
    benchmark = load_benchmark()
    stands = benchmark.labels_on(Question.STANDS).set_index(KEYS).add_suffix("_stands")
    cases = benchmark.select("validation").join(stands, on=KEYS)
    both = cases[cases["status_stands"] == "done"]
    differ = both["failing_step"].fillna(-1) != both["failing_step_stands"].fillna(-1)
    return benchmark, pd.concat([both[differ].head(8), both[~differ].iloc[::60]])


@pytest.fixture
def unlabelled(shipped, tmp_path):
    """A folder of eight of these cases, without their labels."""
    benchmark, cases = shipped
    cases = cases.head(8)
    frame = cases[["layout", "scenario", "item_count", "offsets"]].assign(status=UNLABELLED)
    layouts = benchmark.layouts.loc[cases["layout"].unique()].reset_index()
    none = pd.DataFrame(columns=OPINIONS.names)
    folder = tmp_path / "set"
    write_tables(folder, layouts, frame.reindex(columns=CASES.names), none, {"origin": "a test"})
    return folder


@pytest.mark.parametrize("most_by_one", [screened_loading.MOST_BY_ONE, 0])
def test_each_question_is_answered_as_by_the_reference_alone(shipped, most_by_one, monkeypatch):
    """By one screen and by two."""
    monkeypatch.setattr(screened_loading, "MOST_BY_ONE", most_by_one)
    benchmark, cases = shipped
    assert len(cases) >= 20
    for case in cases.itertuples():
        row = screened_row(case.scenario, benchmark.layout(case.layout, case.scenario))
        expected = [case.failing_step, case.failing_step_stands]
        expected = [None if pd.isna(step) else int(step) for step in expected]
        assert [row["failing_step"], row["failing_step_stands"]] == expected, case.layout
        assert row["status"] == row["stands"] == "done"
        assert len(row["screen"]) == len(row["why"]) == len(row["corner_last"])


def test_the_reference_is_asked_where_something_fails_or_nearly_does(shipped):
    benchmark, cases = shipped
    reasons = set()
    for case in cases.itertuples():
        row = screened_row(case.scenario, benchmark.layout(case.layout, case.scenario))
        before = []
        for far, by_reference, why in zip(row["screen"], row["reference"], row["why"], strict=True):
            assert math.isnan(by_reference) == (not why)
            if far > screened_loading.NEAR and not why:
                assert any(abs(far - other) < screened_loading.SAME for other in before)
            reasons.add(why)
            before.append(far)
    assert reasons >= {"", "drawn", "fails", "near"}


def test_of_two_screens_the_reference_decides_what_fails(shipped, monkeypatch):
    monkeypatch.setattr(screened_loading, "MOST_BY_ONE", 0)
    benchmark, cases = shipped
    for case in cases.itertuples():
        row = screened_row(case.scenario, benchmark.layout(case.layout, case.scenario))
        assert len(row["second"]) == len(row["screen"]) == len(row["why"])
        for step, (one, two, why) in enumerate(
            zip(row["screen"], row["second"], row["why"], strict=True)
        ):
            if min(one, two) > 1.0 or (one > 1.0) != (two > 1.0):
                assert why in ("fails", "differ"), (case.layout, step)


def leaning(*more: Item) -> Layout:
    """A box of 30 cm whose centre of mass lies past the edge of a block, 2.6 cm above a lower one:
    it tips onto that one, by some 8 degrees, and rests there.
    """
    items = (
        Item(0, (0.0, 0.0, 0.0), (14.0, 10.0, 30.0), 30.0),
        Item(1, (14.2, 0.0, 0.0), (30.0, 7.4, 30.0), 30.0),
        Item(2, (0.0, 10.0, 0.0), (30.0, 20.0, 30.0), 5.0),
        *more,
    )
    return Layout("leaning", Pallet(120.0, 120.0, 120.0), items)


def test_the_reference_answers_once_about_a_box_that_came_to_rest(monkeypatch):
    monkeypatch.setattr(screened_loading, "MOST_BY_ONE", 0)
    monkeypatch.setattr(screened_loading, "share_checked", lambda movement: 0.0)
    far = [Item(k, (60.0 + 12.0 * (k % 4), 0.0, 60.0), (10.0, 10.0, 10.0), 2.0) for k in (3, 4, 5)]
    on_top = Item(6, (10.0, 30.0, 10.0), (10.0, 10.0, 10.0), 0.1)
    row = screened_row("S1", leaning(*far, on_top))
    assert row["failing_step_stands"] is None
    assert screened_loading.NEAR_BY_TWO < row["screen"][2] < 1.0
    assert row["why"][2] == "near"
    # Boxes that stand elsewhere change nothing; one on top of it moves further than it does.
    assert row["why"][3:] == ["", "", "", "near"]
    assert row["screen"][3:6] == pytest.approx([row["screen"][2]] * 3, abs=0.05)


def seen(*beyond, item=2, status=Status.DONE):
    """Answers of screens about an item that moved by so much of a threshold."""
    return [
        StepAnswer(status, "", far > 1.0, far > 1.0, item, far, 0.0, 0.0, 0.0, 0.0)
        for far in beyond
    ]


def test_two_screens_that_disagree_are_asked_about_until_nothing_new_touches_the_box():
    elsewhere = Item(3, (60.0, 0.0, 60.0), (10.0, 10.0, 10.0), 2.0)
    on_top = Item(4, (10.0, 30.0, 10.0), (10.0, 10.0, 10.0), 0.1)
    asks = ByTwo(np.ones(5), leaning(elsewhere, on_top))
    differ, near = seen(0.6, 1.3), seen(0.9, 0.86)
    assert [asks.why(2, own, True) for own in (differ, near)] == ["differ", "near"]
    assert asks.known(2, "differ", differ) is None
    [stays] = seen(0.55)
    asks.note(2, differ, stays)
    assert asks.known(3, "differ", seen(0.65, 1.5)) is stays
    assert asks.known(3, "differ", seen(0.9, 1.5)) is None  # moves further
    assert asks.known(3, "differ", seen(0.6, 1.3, item=1)) is None  # another item
    assert asks.known(4, "differ", differ) is None  # a box stands on it
    assert asks.known(4, "near", near) is None
    asks.note(3, near, seen(0.9)[0])
    assert asks.known(4, "near", near) is not None  # all three agreed on how far


def test_where_one_screen_alone_comes_to_no_end_the_other_answers():
    asks = ByTwo(np.ones(3), leaning())
    restless = dataclasses.replace(seen(0.2)[0], fails_standing=None)
    assert asks.why(2, [restless, *seen(0.2)], True) == ""
    assert asks.why(2, [restless, restless], True) == "no end"
    assert asks.why(2, [restless, restless], False) == ""
    assert asks.why(2, [restless, *seen(1.2)], True) == "differ"
    assert asks.why(2, seen(0.2) + seen(0.2, status=Status.DIVERGED), True) == "no end"


def test_boxes_that_touch_or_are_carried_can_change_how_one_moves():
    items = (
        Item(0, (0.0, 0.0, 0.0), (10.0, 10.0, 10.0), 1.0),
        Item(1, (0.0, 10.0, 0.0), (10.0, 10.0, 10.0), 1.0),
        Item(2, (0.0, 20.0, 0.0), (10.0, 10.0, 10.0), 1.0),
        Item(3, (11.0, 0.0, 0.0), (10.0, 10.0, 10.0), 1.0),
        Item(4, (23.5, 0.0, 0.0), (10.0, 10.0, 10.0), 1.0),
    )
    affects = affecting(Layout("pile", Pallet(100.0, 100.0, 100.0), items))
    assert affects[2, 0]  # carried over another one
    assert not affects[0, 2]
    assert affects[3, 0]
    assert affects[0, 3]  # 1 cm apart
    assert affects[3, 1]  # an edge beside another's
    assert not affects[3, 2]
    assert not affects[4].any() or not affects[4, [0, 1, 2, 3]].any()  # 2.5 cm apart


def test_labels_made_again_are_equal_and_a_changed_one_is_named(unlabelled):
    few = 4
    label_screened(unlabelled)
    found = label_again(unlabelled, few)
    assert len(found.cases) == few
    assert found.differ == ()
    layouts, cases, opinions, manifest = read_tables(unlabelled)
    layout, scenario = found.cases[-1]
    here = (cases["layout"] == layout) & (cases["scenario"] == scenario)
    cases["failing_step"] = cases["failing_step"].astype("Int16")
    cases.loc[here, "failing_step"] = 0
    write_tables(unlabelled, layouts, cases, opinions, manifest, keep_further=True)
    assert label_again(unlabelled, few).differ == ((layout, scenario),)
    with pytest.raises(BenchmarkError, match="no case of 99 or more items"):
        label_again(unlabelled, few, least_items=99)


def test_labels_made_again_that_a_set_keeps_are_not_made_once_more(
    unlabelled, tmp_path, monkeypatch
):
    few = 2
    label_screened(unlabelled)
    own = Path(shutil.copytree(unlabelled, tmp_path / "own"))
    assert keep_again(unlabelled, own) == 0
    assert not (own / "again.parquet").exists()
    found = label_again(unlabelled, few)
    assert keep_again(unlabelled, own) == keep_again(unlabelled, own) == few
    assert load_benchmark(own).manifest["again"] == {"cases": few}
    asked = []
    monkeypatch.setattr(screening, "screened_row", lambda *case: asked.append(case) or lost(*case))
    assert label_again(own, few) == found
    assert asked == []
    monkeypatch.setattr(screening, "VERSION", screening.VERSION + 1)
    assert len(label_again(own, few).differ) == len(asked) == few


def test_what_chance_put_to_the_reference_bounds_the_error_of_screens():
    few, many = 50, 100
    asked = [0.02] * few + [np.nan] * few
    drawn = ["drawn"] * few + [""] * few
    steps = pd.DataFrame(
        {
            "layout": ["a", "b"],
            "scenario": ["S1", "S1"],
            "screen": [[0.0] * many] * 2,
            "second": [None, [0.0] * (many - 1) + [0.5]],
            "reference": [asked, asked],
            "why": [drawn, drawn],
        }
    )
    cases = steps[KEYS].assign(item_count=[60, 100], instance=["one", "two"])
    one, two = checked_screening(steps, cases)
    assert [each.boxes for each in (one, two)] == ["25 to 61", "62 to 100"]
    assert (one.steps, one.alone, one.drawn, one.wrong) == (many, 0.5, few, 0)
    # No wrong one of 50: the bound is that whose 50th power leaves 5 %.
    assert one.most_wrong == pytest.approx(1 - 0.05 ** (1 / few))
    assert one.cases_alone.value == 1.0
    # A stratum of a single step, not drawn, may be wrong.
    assert two.most_wrong == pytest.approx(0.99 * (1 - 0.025 ** (1 / few)) + 0.01)
    found, _ = checked_screening(steps.assign(reference=[[1.5, *asked[1:]], asked]), cases)
    assert found.wrong == 1
    assert found.most_wrong > 0.09


@pytest.mark.parametrize(("side", "patient"), [(10.0, False), (100.0, True)])
def test_what_begins_to_tip_slowly_is_not_at_rest(side, patient):
    """A cube whose centre of mass lies 0.1 mm past the edge of another moves very little at first,
    and falls within 3 s.
    """
    items = (
        Item(0, (0.0, 0.0, 0.0), (side, side, side), 1.0),
        Item(1, (side / 2 + 0.01, side, 0.0), (side, side, side), 1.0),
    )
    layout = Layout("edge", Pallet(3 * side, 3 * side, 3 * side), items)
    for spec in (SCREEN, *SCREENS, LABEL):
        both = StepAnswers(layout, make_method(spec))
        assert both.ask(0).beyond < 0.01
        answer = both.ask(1, patient=patient)
        both.close()
        assert (answer.fails_within, answer.fails_standing, answer.item) == (False, True, 1), spec


def test_a_step_about_which_less_is_asked_is_simulated_no_longer(shipped):
    benchmark, cases = shipped
    case = cases[cases["failing_step"].isna() & cases["failing_step_stands"].notna()].iloc[0]
    both = StepAnswers(benchmark.layout(case["layout"], case["scenario"]), make_method(SCREEN))
    answer = both.ask(int(case["failing_step_stands"]), standing=False)
    both.close()
    assert (answer.fails_within, answer.fails_standing) == (False, None)


def test_a_method_that_looks_at_something_else_is_refused(shipped):
    benchmark, cases = shipped
    layout = benchmark.layout(cases.iloc[0]["layout"], "S1")
    for spec in ("ps3@mujoco", "label@mujoco:between_steps=carry"):
        with pytest.raises(ValueError, match=r"between_steps=reseat and criterion=adams"):
            StepAnswers(layout, make_method(spec))


def test_what_is_done_is_kept_and_not_done_again(unlabelled, shipped):
    _, cases = shipped
    expected = cases.head(8).set_index(KEYS)
    few = int(expected["item_count"].sort_values().iloc[3])
    first = label_screened(unlabelled, most_items=few)
    assert 0 < first < 8
    half = load_benchmark(unlabelled)
    assert len(half.further_labels) == len(half.screening) == first
    # What is in the tables is not looked for among the shards.
    shutil.rmtree(unlabelled / "screening")
    said = []
    assert label_screened(unlabelled, progress=lambda *where: said.append(where)) == 8
    assert said[-1] == (8 - first, 8 - first)
    found = load_benchmark(unlabelled)
    assert (found.cases["status"] == "done").all()
    for name, question in zip(("failing_step", "failing_step_stands"), Question, strict=True):
        own = found.labels_on(question).set_index(KEYS)["failing_step"].loc[expected.index]
        assert own.fillna(-1).tolist() == expected[name].fillna(-1).tolist()
    assert {"label", "screen", "labelled_with"} <= set(found.manifest)
    assert read_tables(unlabelled)[3]["labels"]["stands"]["screen"] == SCREEN
    steps = found.screening.set_index(KEYS)
    counts = steps["screen"].map(len)
    assert (steps["reference"].map(len) == counts).all()
    asked = np.concatenate([np.isfinite(values) for values in steps["reference"]])
    assert asked.any()
    assert not asked.all()


def lost(scenario, layout):
    """A row of a case that gives no label."""
    return screening._lost_row(Status.ERROR, ScreenedUnit(((scenario, layout),), {}), 0, "lost")


@pytest.mark.parametrize("older", [False, True])
def test_rows_that_a_set_keeps_are_not_made_again(
    older, unlabelled, shipped, tmp_path, monkeypatch
):
    """Unless code or packages are others by then; the set itself stays as it is."""
    few = int(shipped[1].head(8)["item_count"].sort_values().iloc[3])
    own = Path(shutil.copytree(unlabelled, tmp_path / "own"))
    first = label_screened(unlabelled, most_items=few)
    made = {path.name for path in (unlabelled / "screening").iterdir()}
    before = load_benchmark(own)
    assert keep_begun(unlabelled, own) == keep_begun(unlabelled, own) == first
    after = load_benchmark(own)
    for name in ("layouts", "cases", "opinions", "further_labels", "screening"):
        pd.testing.assert_frame_equal(getattr(after, name), getattr(before, name))
    assert after.manifest == before.manifest | {"begun": {"cases": first}}

    copy = Path(shutil.copytree(own, tmp_path / "copy"))
    asked = []
    monkeypatch.setattr(screening, "screened_row", lambda *case: asked.append(case) or lost(*case))
    monkeypatch.setattr(screening, "VERSION", screening.VERSION + older)
    assert label_screened(copy, most_items=few) == first
    assert len(asked) == first * older
    if not older:
        assert {path.name for path in (copy / "screening").iterdir()} == made
        for one, two in zip(read_tables(copy)[:3], read_tables(unlabelled)[:3], strict=True):
            pd.testing.assert_frame_equal(one, two)
        pd.testing.assert_frame_equal(
            load_benchmark(copy).further_labels, load_benchmark(unlabelled).further_labels
        )
    assert keep_begun(unlabelled, copy) == 0, "nothing is left of cases that have labels"


def test_rows_are_kept_in_another_set(unlabelled, tmp_path):
    for folder, why in ((unlabelled, "allowed: another folder"), (tmp_path, r"no manifest\.json")):
        for keep in (keep_begun, keep_again):
            with pytest.raises(BenchmarkError, match=why):
                keep(unlabelled, folder)


def test_an_interruption_between_two_tables_leaves_a_set_that_goes_on(
    unlabelled, shipped, monkeypatch
):
    few = int(shipped[1].head(8)["item_count"].sort_values().iloc[1])

    def stopped(*arguments, **options):
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(screening, "write_tables", stopped)
        with pytest.raises(KeyboardInterrupt):
            label_screened(unlabelled, most_items=few)
    half = load_benchmark(unlabelled)
    assert (half.cases["status"] == UNLABELLED).all()
    assert len(half.further_labels)
    assert label_screened(unlabelled, most_items=few) == len(half.further_labels)
    found = load_benchmark(unlabelled)
    for table in (found.further_labels, found.screening):
        assert not table.duplicated(KEYS).any()
        assert len(table) == len(half.further_labels)


def test_a_set_is_labelled_by_the_command_that_is_made_for_it(unlabelled, tmp_path):
    layouts, cases, opinions, manifest = read_tables(unlabelled)
    for own, label, other in (
        ({"splits": {}}, label_screened, "benchmark label"),
        ({"origin": "real"}, label_set, "benchmark screen"),
    ):
        write_tables(tmp_path / other, layouts, cases, opinions, manifest | own)
        with pytest.raises(BenchmarkError, match=f"run steadyload {other}"):
            label(tmp_path / other)


def test_a_folder_without_a_set_is_told(tmp_path):
    with pytest.raises(BenchmarkError, match=r"no manifest\.json"):
        label_screened(tmp_path)

"""Labels by screening are those of an ordinary labelling, for both questions."""

import math
import shutil

import numpy as np
import pandas as pd
import pytest

from steadyload.labelling import screening
from steadyload.labelling.label_rows import LABEL
from steadyload.labelling.labelling import label_set
from steadyload.labelling.screening import SCREEN, label_screened, screened_row
from steadyload.layouts import Item, Layout, Pallet
from steadyload.layouts.benchmark import BenchmarkError, load_benchmark
from steadyload.layouts.benchmark.dataset import KEYS
from steadyload.layouts.benchmark.tables import CASES, UNLABELLED, read_tables, write_tables
from steadyload.methods.registry import make_method
from steadyload.methods.simulation.step_answers import StepAnswers


@pytest.fixture(scope="module")
def shipped():
    """Cases of the shipped set that have labels of both questions; of some these differ."""
    benchmark = load_benchmark()
    stands = benchmark.stands.set_index(KEYS).add_suffix("_stands")
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
    none = pd.DataFrame(columns=["layout", "scenario", "reason", "judge", "status", "failing_step"])
    folder = tmp_path / "set"
    write_tables(folder, layouts, frame.reindex(columns=CASES.names), none, {"origin": "a test"})
    return folder


def test_each_question_is_answered_as_by_the_reference_alone(shipped):
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
            if far > screening.NEAR and not why:
                assert any(abs(far - other) < screening.SAME for other in before)
            reasons.add(why)
            before.append(far)
    assert reasons >= {"", "drawn", "fails", "near"}


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
    for spec in (SCREEN, LABEL):
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
    assert len(half.stands) == len(half.screening) == first
    # What is in the tables is not looked for among the shards.
    shutil.rmtree(unlabelled / "screening")
    said = []
    assert label_screened(unlabelled, progress=lambda *where: said.append(where)) == 8
    assert said[-1] == (8 - first, 8 - first)
    found = load_benchmark(unlabelled)
    assert (found.cases["status"] == "done").all()
    for name, table in (("failing_step", found.cases), ("failing_step_stands", found.stands)):
        own = table.set_index(KEYS)["failing_step"].loc[expected.index]
        assert own.fillna(-1).tolist() == expected[name].fillna(-1).tolist()
    assert {"label", "screen", "labelled_with"} <= set(found.manifest)
    assert read_tables(unlabelled)[3]["stands"]["screen"] == SCREEN
    steps = found.screening.set_index(KEYS)
    counts = steps["screen"].map(len)
    assert (steps["reference"].map(len) == counts).all()
    asked = np.concatenate([np.isfinite(values) for values in steps["reference"]])
    assert asked.any()
    assert not asked.all()


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
    assert len(half.stands)
    assert label_screened(unlabelled, most_items=few) == len(half.stands)
    found = load_benchmark(unlabelled)
    for table in (found.stands, found.screening):
        assert not table.duplicated(KEYS).any()
        assert len(table) == len(half.stands)


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

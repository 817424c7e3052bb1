"""The paper's experiment from end to end, on a data set of a hundred files."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

pytest.importorskip("torch")

from steadyload.labelling.building.paper_files import FileOptions, make_files
from steadyload.labelling.paper_labels import case_layouts, label_files, labelled_cases
from steadyload.layouts import Item, Layout, Pallet
from steadyload.layouts.packing.heuristics import Heuristic
from steadyload.methods.registry import make_method
from steadyload.reports.pages.writing import write_page
from steadyload.runs.evaluation import ALL
from steadyload.runs.paper import paper
from steadyload.studies.kit import Lab
from steadyload.studies.replication.comparing import fall, paper_of, replicate
from steadyload.studies.replication.learning import TABLE_4, Memoriser, paper_options
from steadyload.studies.replication.methods import METHODS, PAPER, Extent
from steadyload.studies.replication.splits import (
    TABLE_2,
    TEST,
    VALIDATION,
    SplitKind,
    draw_parts,
    folds,
)
from steadyload.studies.replication.study import Replication

FILES = FileOptions(
    seed=5,
    lists=3,
    item_counts={1: 4, 2: 4, 3: 6},
    heuristics=tuple(map(Heuristic.numbered, (1, 2, 41, 42))),
)
SIZES = {name: {TEST: (4, 2), VALIDATION: (2, 1)} for name in TABLE_2}


@pytest.fixture(scope="module")
def work(tmp_path_factory):
    return tmp_path_factory.mktemp("replication")


@pytest.fixture(scope="module")
def files():
    return make_files(FILES)


@pytest.fixture(scope="module")
def labels(files, work):
    return label_files(files, work, workers=0)


@pytest.fixture(scope="module")
def run(files, labels, work):
    def run():
        return replicate(
            Lab(work, 0), files, labels, Extent(2, 2, ensemble=True), methods=("fbs", "sme"),
            sizes=SIZES,
        )  # fmt: skip

    return run


@pytest.fixture(scope="module")
def found(run):
    return run()


@pytest.fixture(scope="module")
def cases(files, labels):
    made = labelled_cases(files, labels)
    return made.assign(part=draw_parts(made, seed=0, sizes=SIZES))


@pytest.fixture(scope="module")
def layouts(files, cases):
    return case_layouts(files, cases)


@pytest.fixture(scope="module")
def steps(cases):
    return [None if pd.isna(step) else int(step) for step in cases["failing_step"]]


@pytest.mark.parametrize(("spec", "title"), [("fbs", "FBS"), ("sme", "SME")])
def test_rules_are_judged_on_every_test_file(found, cases, layouts, steps, spec, title):
    tests = np.flatnonzero(cases["part"] == TEST)
    right = [make_method(spec).judge(layouts[k]).failing_step == steps[k] for k in tests]
    [(row,)] = found.together(title)
    assert row.accuracy[ALL].value == pytest.approx(np.mean(right))
    assert (row.test_files, row.without_verdict) == (18, 0)
    assert row.paper == paper_of(title)[ALL]
    assert not row.is_reading
    assert row.off == pytest.approx(abs(np.mean(right) - row.paper))


@pytest.mark.parametrize("kind", SplitKind)
def test_the_memoriser_is_tested_on_what_it_has_not_learnt(found, cases, layouts, steps, kind):
    right = {}
    for fold in folds(cases, kind):
        known = Memoriser((layouts[k], steps[k]) for k in np.flatnonzero(fold.train))
        for k in np.flatnonzero(fold.test):
            right[k] = known.failing_step(layouts[k]) == steps[k]
    row = found.learned["memoriser", kind.words]
    assert row.accuracy[ALL].value == pytest.approx(np.mean(list(right.values())))
    assert row.with_twin.n + row.without_twin.n == len(right) == 18


def pile(*corners, shift=0.0):
    """Cubes of 10 cm with some left-bottom-back corners, all centres of mass shifted along x."""
    items = tuple(
        Item(k, tuple(map(float, at)), (10.0, 10.0, 10.0), 1.0, (shift, 0.0, 0.0))
        for k, at in enumerate(corners)
    )
    return Layout("pile", Pallet(30.0, 30.0, 30.0), items)


A, B, C, D = (0, 0, 0), (10, 0, 0), (0, 10, 0), (20, 0, 0)


def test_the_memoriser_repeats_its_twin():
    known = Memoriser([(pile(A, B, C), 2), (pile(A, C, B), 1), (pile(B, A, C), None)])
    assert known.failing_step(pile(A, B, C)) == 2
    assert known.failing_step(pile(A, C, B)) == 1
    assert known.failing_step(pile(B, A, C)) is None


def test_of_several_twins_the_nearest_centres_of_mass_count():
    known = Memoriser([(pile(A, C, shift=0.0), None), (pile(A, C, shift=3.0), 1)])
    assert known.failing_step(pile(A, C, shift=1.4)) is None
    assert known.failing_step(pile(A, C, shift=1.6)) == 1


def test_without_a_twin_the_longest_common_beginning_counts():
    known = Memoriser([(pile(A, D), 1), (pile(A, B, C), 2), (pile(D, A), 0)])
    assert known.failing_step(pile(A, B, C, D)) == 2
    assert known.failing_step(pile(A, B)) is None  # its most alike fails beyond the last item
    assert known.failing_step(pile(A, C)) == 1  # begins like both; the first one counts
    assert known.failing_step(pile(C, A)) is None  # nothing begins like it
    higher = replace(pile(D, A), pallet=Pallet(30.0, 40.0, 30.0))
    assert known.failing_step(higher) is None  # on another pallet


def test_all_learn_on_all_splits(found):
    trained = {key: row.trainings for key, row in found.learned.items()}
    assert trained == {
        ("memoriser", "file"): "0, 0 cut off", ("LSTM_1", "file"): "2, 0 cut off",
        ("memoriser", "file, fewer"): "0, 0 cut off", ("LSTM_1", "file, fewer"): "2, 0 cut off",
        ("memoriser", "geometry"): "0, 0 cut off", ("LSTM_1", "geometry"): "2, 0 cut off",
        ("memoriser", "item list"): "0, 0 cut off", ("LSTM_1", "item list"): "6, 0 cut off",
        ("LSTM_e", "file"): "5, 0 cut off", ("LSTM_e", "geometry"): "5, 0 cut off",
        ("LSTM_e", "item list"): "15, 0 cut off", ("support", "item list"): "3, 0 cut off",
    }  # fmt: skip
    assert all({*row.epochs} <= {2} for row in found.learned.values())
    assert [row.trainings for row in found.splits] == [1, 1, 1, 3]


def test_networks_are_those_of_table_4():
    assert [own["hidden"] for own in TABLE_4.networks] == [125, 175, 150, 150, 200]
    rates = [own["learning_rate"] for own in TABLE_4.networks]
    assert rates == [0.35e-3, 0.15e-3, 0.67e-3, 0.19e-3, 0.71e-3]
    options = paper_options(1, 4)
    assert (options.hidden, options.layers, options.learning_rate) == (175, 2, 0.15e-3)
    assert (str(options.features), options.symmetries, options.epochs) == ("plain", 1, 700)


def test_a_second_run_judges_and_trains_nothing(found, run, work, monkeypatch):
    def written():
        return {path: path.stat().st_mtime_ns for path in work.rglob("*.p*") if path.is_file()}

    before = written()
    monkeypatch.setattr("steadyload.runs.provenance.machine_kind", lambda: "another")
    assert run() == found, "also in its provenance, which is that of the times"
    assert written() == before


def test_steps_are_compared_with_the_one_before(found):
    assert [row.test for row in found.counts] == [6, 6, 6]
    assert [row.validation for row in found.counts] == [3, 3, 3]
    first, second, *_ = found.changes
    file, fewer = (
        found.learned["LSTM_1", split].accuracy[ALL] for split in ("file", "file, fewer")
    )
    assert (first.accuracy, first.change, first.paper) == (file, None, paper_of("LSTM_1")[ALL])
    assert second.change.value == pytest.approx(fewer.value - file.value)
    lost = found.answers["LSTM_1 in S1, what is lost by fewer training files"]
    ends = (
        found.learned["LSTM_1", split].accuracy["S1"].value for split in ("file", "file, fewer")
    )
    assert lost.found.value == pytest.approx(-np.diff([*ends])[0])


def test_a_fall_is_the_difference_of_two_accuracies(cases):
    tests = cases[cases["part"] == TEST]
    right = np.zeros((1, len(tests)), bool)
    s1 = (tests["scenario"] == "S1").to_numpy()
    right[0, np.flatnonzero(s1)[:5]] = True
    right[0, np.flatnonzero(~s1)[:3]] = True
    assert fall(right, tests).value == pytest.approx(5 / 6 - 3 / 12)


def test_the_paper_is_quoted():
    assert paper_of("LSTM_e")["S1"] == pytest.approx(0.9867)
    assert paper_of("no such method") == {}
    assert PAPER.keys() <= METHODS.keys()
    assert {*PAPER.values()} == {row.title for row in paper().rows} - {"LSTM_1", "LSTM_e"}


def details(page):
    [beside] = page.parent.glob("report-details.*.md")
    return beside.read_text()


def test_the_page_answers(found, tmp_path):
    page = write_page(Replication().page(found), tmp_path)
    text = page.read_text()
    _, answer, _, _, data, *_ = text.split("\n\n")
    assert answer.startswith("The paper's LSTM_e, trained here, is right on 66.7 [30.0, 90.3] %")
    assert "; the paper has 98.7 %." in answer
    text += details(page)
    assert data.startswith("The test files are the same under every split, 6 a scenario")
    assert "Not all readings of PS_3 and PS_5 were judged" in text
    assert "under-trained" not in text


def test_the_page_of_few_files_marks_it_and_compares_readings(found, tmp_path):
    [(sme,)] = found.together("SME")
    own = dict.fromkeys(("PS_3, converted", "PS_5, literal"), sme.accuracy[ALL].value)
    methods = [replace(sme, title=title, paper=own.get(title, 0.0)) for title in METHODS]
    more = {"unlabelled": 1, "left_out": {"label@bullet": "none is *here*"}}
    every = replace(found, methods=methods, **more)
    page = write_page(Replication(limit=3000).page(every), tmp_path)
    text = page.read_text() + details(page)
    assert text.split("##")[0].count("under-trained") == 1
    assert text.count("nearer to the literal reading") == 1
    assert text.count("nearer to the converted reading") == 1
    assert "`label@bullet`: none is \\*here\\*." in text
    assert "Labels are missing for 1 cases" in text

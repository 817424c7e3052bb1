"""The paper's experiment from end to end, on a data set of a hundred files."""

import io
import shutil

import numpy as np
import pandas as pd
import pytest

pytest.importorskip("torch")

import torch

from steadyload.atomic import CHECKSUM_DIGITS
from steadyload.labelling.paper_labels import Labelling, label_files
from steadyload.layouts.benchmark.paper_files import FileOptions, make_files
from steadyload.layouts.packing.heuristics import Heuristic
from steadyload.learners.network import LstmNetwork
from steadyload.learners.scoring import items_safe
from steadyload.methods.registry import make_method
from steadyload.reports.pages.writing import write_page
from steadyload.runs.evaluation import ALL
from steadyload.runs.store import CHECKPOINTS
from steadyload.studies.kit import Lab
from steadyload.studies.replication.comparing import Found, fall, paper_of, summarise
from steadyload.studies.replication.judging import case_layouts, replicate
from steadyload.studies.replication.methods import ALL_LINES, LSTM_1, LSTM_E, MEMORISER, SUPPORT
from steadyload.studies.replication.networks import (
    NETWORKS,
    Material,
    items_safe_by,
    networks_on_folds,
    paper_options,
)
from steadyload.studies.replication.splits import PartSizes, SplitKind, folds
from steadyload.studies.replication.study import Replication

FILES = FileOptions(
    seed=5,
    lists=3,
    item_counts={1: 4, 2: 4, 3: 6},
    heuristics=tuple(map(Heuristic.numbered, (1, 2, 41, 42))),
)
METHODS = ("fbs", "sme")


def replicated(work):
    files = make_files(FILES)
    labels = label_files(files, work, workers=0).labels
    sizes = dict.fromkeys(("S1", "S2a", "S2b"), PartSizes(test=(4, 2), validation=(2, 1)))
    return replicate(
        Lab(work, 0), files, labels, seed=0, epochs=2, budget=3600.0, seeds=2, ensemble=True,
        methods=METHODS, sizes=sizes,
    )  # fmt: skip


@pytest.fixture(scope="module")
def work(tmp_path_factory):
    return tmp_path_factory.mktemp("replication")


@pytest.fixture(scope="module")
def done(work):
    return replicated(work)


@pytest.fixture(scope="module")
def found(done):
    return summarise(done)


def test_rules_are_judged_on_every_test_file(done):
    tests = done.tests
    assert len(tests) == 18
    layouts = case_layouts(done.files, tests)
    for spec in METHODS:
        steps = [make_method(spec).judge(layout).failing_step for layout in layouts]
        labels = [None if pd.isna(step) else int(step) for step in tests["failing_step"]]
        right = [a == b for a, b in zip(steps, labels, strict=True)]
        assert done.rights[spec].tolist() == [right]


def test_processes_train_what_one_process_does(done, tmp_path):
    material = Material(done.cases, case_layouts(done.files, done.cases))
    (fold,) = folds(done.cases, done.part, SplitKind.GEOMETRY)
    wanted = [(fold, paper_options(0, seed, epochs=1)) for seed in (0, 1)]
    here, beside = (
        list(networks_on_folds(material, wanted, tmp_path / str(n), 60.0, workers=n))
        for n in (0, 2)
    )
    for one, other in zip(here, beside, strict=True):
        assert (one.probabilities == other.probabilities).all()
    assert (here[0].probabilities != here[1].probabilities).any()


def test_what_a_network_says_is_what_its_weights_say(done, tmp_path):
    """Held against torch, of the checkpoint that the training left."""
    material = Material(done.cases, case_layouts(done.files, done.cases))
    (fold,) = folds(done.cases, done.part, SplitKind.GEOMETRY)
    options = paper_options(0, 0, epochs=1)
    (tested,) = networks_on_folds(material, [(fold, options)], tmp_path, 60.0)
    (checkpoint,) = (tmp_path / CHECKPOINTS).glob("*/checkpoint.pt")
    stored = torch.load(io.BytesIO(checkpoint.read_bytes()[CHECKSUM_DIGITS:]), weights_only=True)
    asked = material.sequences(options.features).chosen(fold.test)
    network = LstmNetwork(asked.rows.shape[1], options.hidden, options.layers)
    network.load_state_dict(stored["best"])
    with torch.inference_mode():
        told = torch.sigmoid(network(torch.from_numpy(asked.padded()))).numpy()
    within = np.arange(told.shape[1]) < asked.counts[:, None]
    assert tested.probabilities[within] == pytest.approx(told[within], abs=1e-5)
    safe = items_safe_by([tested], fold, done.cases)
    assert (safe == items_safe(told, asked.counts)).mean() > 0.99


def test_without_checkpoints_nothing_is_trained_again(done, tmp_path):
    material = Material(done.cases, case_layouts(done.files, done.cases))
    (fold,) = folds(done.cases, done.part, SplitKind.GEOMETRY)
    wanted = [(fold, paper_options(0, 0, epochs=1))]
    (before,) = networks_on_folds(material, wanted, tmp_path, 60.0)
    shutil.rmtree(tmp_path / CHECKPOINTS)
    (after,) = networks_on_folds(material, wanted, tmp_path, 60.0)
    assert after.effort == before.effort
    assert (after.probabilities == before.probabilities).all()
    assert not (tmp_path / CHECKPOINTS).exists()


def test_all_learn_on_all_splits(done):
    for kind, split in done.splits.items():
        expected = {MEMORISER, LSTM_1}
        expected |= set() if kind is SplitKind.FEWER else {LSTM_E}
        expected |= {SUPPORT} if kind is SplitKind.LIST else set()
        assert set(split.rights) == expected
        assert split.rights[MEMORISER].shape == (1, 18)
        assert split.rights[LSTM_1].shape == (2, 18)
        assert len(split.folds) == (3 if kind is SplitKind.LIST else 1)
        assert len(split.efforts[LSTM_1]) == 2 * len(split.folds)
        assert all(effort.epochs == 2 for effort in split.efforts[LSTM_1])


def test_networks_are_those_of_table_4():
    assert [own["hidden"] for own in NETWORKS] == [125, 175, 150, 150, 200]
    rates = [own["learning_rate"] for own in NETWORKS]
    assert rates == [0.35e-3, 0.15e-3, 0.67e-3, 0.19e-3, 0.71e-3]
    options = paper_options(1, 4)
    assert (options.hidden, options.layers, options.learning_rate) == (175, 2, 0.15e-3)
    assert (str(options.features), options.symmetries, options.epochs) == ("plain", 1, 700)


def test_a_second_run_judges_and_trains_nothing(done, work):
    def files():
        return {path: path.stat().st_mtime_ns for path in work.rglob("*.p*") if path.is_file()}

    judged = files()
    again = replicated(work)
    assert files() == judged
    for kind, split in done.splits.items():
        for name, right in split.rights.items():
            assert (again.splits[kind].rights[name] == right).all()


def test_the_summary_counts_what_was_judged(done, found):
    tests = done.tests
    [(row,)] = found.together("SME")
    assert row.accuracy[ALL].value == pytest.approx(done.rights["sme"].mean())
    assert row.paper == pytest.approx(0.8356)
    s1 = (tests["scenario"] == "S1").to_numpy()
    split = done.splits[SplitKind.FILE]
    learnt = found.learnt(LSTM_1, SplitKind.FILE.words)
    assert learnt.accuracy["S1"].value == pytest.approx(split.rights[LSTM_1][:, s1].mean())
    assert learnt.with_twin.n + learnt.without_twin.n == 18
    assert [count.test for count in found.counts] == [6, 6, 6]
    first, second = found.steps[0].changes[:2]
    fewer = done.splits[SplitKind.FEWER].rights[LSTM_1].mean()
    assert first.change is None
    assert second.change.value == pytest.approx(fewer - split.rights[LSTM_1].mean())


def test_a_fall_is_the_difference_of_two_accuracies(done):
    tests = done.tests
    right = np.zeros((1, len(tests)), bool)
    s1 = (tests["scenario"] == "S1").to_numpy()
    right[0, np.flatnonzero(s1)[:5]] = True
    right[0, np.flatnonzero(~s1)[:3]] = True
    assert fall(right, tests).value == pytest.approx(5 / 6 - 3 / 12)


def test_the_paper_is_quoted():
    assert paper_of("LSTM_e")["S1"] == pytest.approx(0.9867)
    assert paper_of("no such method") == {}
    assert {line.paper for line in ALL_LINES} - {""} <= {
        "FBS", "PBS 0.9", "PBS 0.7", "PBS 0.5", "SME", "PS_3", "PS_5", "PS_opt"
    }  # fmt: skip
    for line in ALL_LINES:
        assert not line.paper or paper_of(line.paper)


def test_the_page_answers_and_marks_a_quick_run(found, tmp_path):
    page = Replication().page(Found(found))
    text = write_page(page, tmp_path / "full").read_text()
    answer = text.split("\n\n")[1]
    assert answer.startswith("A memoriser, which only repeats the label of the training file")
    assert "The paper's LSTM_e is right on 98.7 %; trained here" in answer
    assert "when whole item lists are held out" in answer
    assert len(answer) < 700
    assert "under-trained" not in text
    assert "Not all readings of PS_3 and PS_5 were judged" in text
    page = Replication(quick=True).page(Found(found))
    text = write_page(page, tmp_path / "quick").read_text()
    assert "under-trained" in text.split("##")[0]
    assert text.count("under-trained") >= 3


def test_labels_alone_have_a_page(tmp_path):
    page = Replication().page(Found(labelling=Labelling({1: None, 2: 0}, 5, {"crashed": 1})))
    text = write_page(page, tmp_path).read_text()
    assert "2 labels are known; the files have 5 distinct cases" in text
    assert "1 crashed" in text

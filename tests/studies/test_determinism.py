"""Verdicts judged again: what was changed by hand is found and named, nothing else."""

import dataclasses
import re
import shutil
from contextlib import nullcontext
from pathlib import Path

import pandas as pd
import pytest

from steadyload.layouts.benchmark import load_benchmark
from steadyload.layouts.benchmark.dataset import KEYS
from steadyload.runs.definition import StudyDefinition, StudyError
from steadyload.runs.kept_only import NotKeptError, kept_only
from steadyload.runs.labels import load_labels
from steadyload.runs.results import load_manifest, load_results, result_store
from steadyload.runs.runner import run_study
from steadyload.studies import published
from steadyload.studies.determinism import comparing
from steadyload.studies.determinism.comparing import JUDGED, LABELS, usual_methods
from steadyload.studies.determinism.study import Determinism
from steadyload.studies.kept_rows import RowsError, unpack
from steadyload.studies.kit import Lab

ROOT = Path(__file__).parents[2]
METHODS = ("fbs", "sme", "equilibrium:time=0.3")
MINE = StudyDefinition("mine", METHODS, benchmark="test", benchmark_directory="lists", limit=4)
CASES = 12


@pytest.fixture(scope="module")
def rows(tmp_path_factory):
    """Rows of three methods on twelve cases, three of which have a wrong label."""
    labelled = load_benchmark("lists")
    chosen = labelled.select("test", limit=4)[KEYS]
    there = pd.MultiIndex.from_frame(labelled.cases[KEYS]).isin(
        pd.MultiIndex.from_frame(chosen.iloc[[0, 5, 11]])
    )
    steps = labelled.cases["failing_step"]
    wrong = dataclasses.replace(
        labelled, cases=labelled.cases.assign(failing_step=steps.mask(there, steps.fillna(0) + 1))
    )
    folder = tmp_path_factory.mktemp("determinism") / "rows"
    run_study(MINE, folder, benchmark=wrong)
    return folder


def changed(rows, folder, change):
    """A copy of rows, of which ``change`` changed some: it is given each, as in its shard."""
    shutil.copytree(rows, folder)
    store = result_store(folder)
    for key in load_manifest(folder)["shards"]:
        found = store.read(key).to_pylist()
        for one in found:
            change(one)
        store.write(key, found)
    return folder


@pytest.fixture
def again(rows, monkeypatch):
    """Results of judging rows again: of three methods, and with no more than two labels."""

    def judged(work, folder=rows, **values):
        known = {"CASES": CASES, "MADE_AGAIN": 2, "usual_methods": lambda: METHODS}
        for name, value in {**known, **values}.items():
            monkeypatch.setattr(comparing, name, value)
        monkeypatch.setattr(comparing, "_folder", lambda: nullcontext(folder))
        return Determinism().run(Lab(work, workers=0))

    return judged


def test_rows_that_nobody_changed_are_equal(rows, again, tmp_path, assert_shown):
    found = again(tmp_path, MADE_AGAIN=CASES)
    assert (found.cases, found.of, found.number, found.every.n) == (CASES, CASES, 0, 3 * CASES)
    assert found.then == found.now == load_manifest(rows)["machine"]
    assert found.packages == {}
    assert [(own.method.spec, own.n, own.differ) for own in found.methods] == [
        (spec, CASES, 0) for spec in METHODS
    ]
    *rules, balance = found.methods
    assert [(own.numbers, own.equal, own.apart_cm) for own in rules] == [(0, None, None)] * 2
    told = load_results(rows).set_index("method").loc["equilibrium:time=0.3", "displacement_cm"]
    assert balance.numbers == told.notna().sum() > 2
    assert (balance.equal.value, balance.apart_cm) == (1.0, 0.0)
    # The three labels that were changed beforehand are those that differ.
    truth = load_benchmark("lists").cases.set_index(KEYS)["failing_step"]
    known = load_labels(rows)["failing_step"]
    wrong = {case for case in known.index if _told(known[case]) != _told(truth[case])}
    assert len(wrong) == 3
    assert found.labels.differ == 3
    assert {(one.layout, one.scenario) for one in found.differences} == wrong
    for one in found.differences:
        case = (one.layout, one.scenario)
        assert (one.then, one.now) == (_told(known[case]), _told(truth[case]))
        assert (one.method, one.label) == ("label @ reference", one.then)
    tables = [found.methods, [found.labels], found.differences]
    text = assert_shown(
        Determinism(), found, answer=(3 * CASES, CASES, 3), tables=tables, charts=["differing"]
    )
    assert "drawn at random" in text


def _told(step):
    return "stable" if pd.isna(step) else f"step {step}"


@pytest.mark.parametrize(
    ("method", "is_stable", "planted", "told"),
    [
        ("fbs", False, {"failing_step": None}, "stable"),
        ("sme", True, {"failing_step": 1}, "step 1"),
        ("sme", False, {"status": "timeout", "failing_step": None}, "timeout"),
        ("equilibrium:time=0.3", False, {"failing_step": 99}, "step 99"),
    ],
)
def test_a_verdict_that_was_changed_is_named(
    rows, again, tmp_path, method, is_stable, planted, told, assert_shown
):
    first = load_results(rows)
    first = first[(first["method"] == method) & (first["failing_step"].isna() == is_stable)]
    name, scenario, before = first.iloc[0][[*KEYS, "failing_step"]]

    def plant(one):
        if (one["method"], one["layout"], one["scenario"]) == (method, name, scenario):
            one.update(planted)

    found = again(tmp_path / "work", changed(rows, tmp_path / "rows", plant))
    assert found.number == 1
    assert [own.method.spec for own in found.methods if own.differ] == [method]
    assert found.every.value == pytest.approx(1 / (3 * CASES))
    (one,) = (own for own in found.differences if own.method != found.labels.method.title)
    assert (one.layout, one.scenario, one.then, one.now) == (name, scenario, told, _told(before))
    assert one.label == _told(load_labels(rows)["failing_step"][name, scenario])
    assert_shown(
        Determinism(),
        found,
        answer=(1,),
        tables=[found.methods, [found.labels], found.differences],
        charts=["differing"],
    )


@pytest.mark.parametrize("what", ["displacement", "rotation"])
def test_numbers_of_equal_verdicts_are_compared_to_the_last_bit(rows, again, tmp_path, what):
    done = []

    def plant(one):
        if one[what] is not None and not done:
            one[what] += 0.25
            done.append(one)

    found = again(tmp_path / "work", changed(rows, tmp_path / "rows", plant))
    balance = found.methods[-1]
    assert (found.number, len(done)) == (0, 1)
    assert balance.equal.value == pytest.approx((balance.numbers - 1) / balance.numbers)
    apart = (0.25, 0.0) if what == "displacement" else (0.0, 0.25)
    assert (balance.apart_cm, balance.apart_deg) == pytest.approx(apart)


def test_cases_are_drawn_by_the_seed_and_labels_of_the_same_ones(again, tmp_path):
    def drawn(folder, seed):
        found = again(tmp_path / folder, CASES=5, _SEED=seed)
        assert (found.cases, found.of, found.labels.n, found.every.n) == (5, CASES, 2, 15)
        cases, labels = (
            set(map(tuple, load_results(tmp_path / folder / run)[KEYS].to_numpy()))
            for run in (JUDGED, LABELS)
        )
        assert len(labels) == 2
        assert labels < cases
        return cases

    assert drawn("one", 1) == drawn("again", 1) != drawn("other", 2)


def test_a_folder_has_verdicts_of_one_machine(again, tmp_path, monkeypatch):
    found = again(tmp_path, CASES=3)
    monkeypatch.setattr(comparing, "provenance", lambda: {"machine": "another"})
    assert again(tmp_path, CASES=3) == found
    with pytest.raises(NotKeptError, match=r"and this is another: name .* --work"):
        again(tmp_path, CASES=4)


def test_what_is_there_is_not_judged_again(again, tmp_path):
    found = again(tmp_path, CASES=3)
    with kept_only("nothing"):
        assert again(tmp_path, CASES=3) == found


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"parameters": "{}"}, r"parameters of the rows is \{\}, here"),
        ({"layout_hash": "0"}, "layout_hash of the rows is 0, here"),
    ],
)
def test_rows_of_something_else_are_refused(rows, again, tmp_path, change, said):
    folder = changed(rows, tmp_path / "rows", lambda one: one.update(change))
    with pytest.raises(StudyError, match=said):
        again(tmp_path / "work", folder)


def test_without_the_packed_rows_nothing_is_judged(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(RowsError, match=r"evaluation\.parquet: does not exist"):
        Determinism().run(Lab(tmp_path / "work", workers=0))


@pytest.fixture(scope="module")
def kept(tmp_path_factory):
    """The rows behind the published page, and those that they were compared with."""
    found = {}
    for name in ("determinism", "evaluation"):
        (entry,) = published.named((name,))
        work = tmp_path_factory.mktemp("kept") / entry.work.name
        found[name] = unpack(dataclasses.replace(entry, work=work), ROOT / published.ROWS)
    return found


def test_the_published_figures_are_those_of_the_rows(kept):
    text = (ROOT / published.FOLDER / "determinism" / "report.md").read_text()
    columns = ["method", *KEYS, "status", "failing_step"]
    now = load_results(kept["determinism"] / JUDGED, columns)
    then = load_results(kept["evaluation"] / "spatial", columns)
    both = now.merge(then, on=["method", *KEYS], suffixes=("", "_then"))
    assert len(both) == len(now)
    assert set(now["method"]) == set(usual_methods())
    moved = both["failing_step"].fillna(-1) != both["failing_step_then"].fillna(-1)
    differ = moved | (both["status"] != both["status_then"])
    labels = load_results(kept["determinism"] / LABELS, columns)
    known = load_labels(kept["evaluation"] / "spatial")["failing_step"]
    said = known.loc[pd.MultiIndex.from_frame(labels[KEYS])].fillna(-1).to_numpy()
    wrong = int((labels["failing_step"].fillna(-1).to_numpy() != said).sum())
    answer, data = text.split("\n\n")[1], text.partition("The verdicts, given on")[2]
    assert f"Of {len(both):,} published verdicts {differ.sum()} (" in answer
    assert answer.endswith(f" and of {len(labels)} labels {wrong or 'none'}.")
    for run in (JUDGED, LABELS):
        assert load_manifest(kept["determinism"] / run)["machine"] in answer
    machine = load_manifest(kept["evaluation"] / "spatial")["machine"]
    assert machine in data.partition(", are those")[0]
    listed = re.findall(r"^\|(.+)\|$", text.partition("## What differs")[2], re.MULTILINE)[2:]
    assert len(listed) == differ.sum() + wrong
    for layout in both.loc[differ, "layout"]:
        assert any(layout in line.replace("\\", "") for line in listed)

"""Verdicts of further methods on cases of a set that has its labels."""

import shutil

import pandas as pd
import pytest

from steadyload.cli import main
from steadyload.labelling import labelling
from steadyload.labelling.further_verdicts import add_further_verdicts, asked_to_stand
from steadyload.labelling.labelling import FurtherMethod
from steadyload.layouts.benchmark import BenchmarkError, load_benchmark
from steadyload.layouts.benchmark.confidence import Reason
from steadyload.layouts.benchmark.dataset import KEYS
from steadyload.layouts.benchmark.parts import SETS
from steadyload.layouts.benchmark.tables import read_tables
from steadyload.layouts.model.question import Question
from steadyload.methods.registry import make_method

JUDGES = (
    FurtherMethod(Reason.ENGINE, "label@mujoco:frequency=240"),
    FurtherMethod(Reason.MODEL, "label@mujoco:friction=0.4,frequency=240"),
)
SPECS = [str(make_method(judge.spec).spec) for judge in JUDGES]


@pytest.fixture
def folder(tmp_path):
    """A copy of a set whose labels have no traces beside them."""
    return shutil.copytree(SETS["lists"], tmp_path / "lists")


def keys_of(rows):
    return set(rows[KEYS].itertuples(index=False, name=None))


def said_by(directory, specs=SPECS):
    opinions = load_benchmark(directory).opinions
    return opinions[opinions["judge"].isin(specs)]


def test_the_first_cases_are_judged_and_nothing_else_changes(folder):
    before = read_tables(folder)
    assert add_further_verdicts(folder, limit=2, judges=JUDGES) == 6
    layouts, cases, opinions, manifest = read_tables(folder)
    pd.testing.assert_frame_equal(layouts, before[0])
    pd.testing.assert_frame_equal(cases, before[1])
    pd.testing.assert_frame_equal(opinions.head(len(before[2])), before[2])
    same = ("label", "labelled_with", "built_with", "splits", "labels", "cases")
    assert {key: manifest[key] for key in same} == {key: before[3][key] for key in same}
    benchmark = load_benchmark(folder)
    shipped = load_benchmark("lists")
    pd.testing.assert_frame_equal(benchmark.further_labels, shipped.further_labels)
    said = said_by(folder)
    assert keys_of(said) == keys_of(benchmark.select("test-300", limit=2))
    assert set(said.groupby(KEYS).size()) == {2}
    assert dict(zip(said["judge"], said["reason"], strict=True)) == dict(
        zip(SPECS, ["engine", "model"], strict=True)
    )
    for row in said.itertuples():
        verdict = make_method(row.judge).judge(benchmark.layout(row.layout, row.scenario))
        assert verdict.failing_step == (None if pd.isna(row.failing_step) else row.failing_step)


def test_it_goes_on_from_the_tables_alone(folder, tmp_path):
    add_further_verdicts(folder, limit=1, judges=JUDGES)
    shutil.rmtree(folder / "opinions")  # as on another machine
    assert add_further_verdicts(folder, limit=2, judges=JUDGES) == 3
    assert add_further_verdicts(folder, limit=2, judges=JUDGES) == 0
    whole = shutil.copytree(SETS["lists"], tmp_path / "whole")
    add_further_verdicts(whole, limit=2, judges=JUDGES)
    order = [*KEYS, "judge"]
    found, expected = (said_by(at).sort_values(order, ignore_index=True) for at in (folder, whole))
    pd.testing.assert_frame_equal(found, expected)


def test_a_case_that_one_of_the_methods_has_not_judged_is_judged_once_more_by_all(folder):
    add_further_verdicts(folder, limit=1, judges=JUDGES[:1])
    assert add_further_verdicts(folder, limit=1, judges=JUDGES) == 3
    assert not said_by(folder).duplicated([*KEYS, "judge"]).any()


@pytest.mark.parametrize(("done", "complete"), [(0, 0), (4, 0), (8, 5)])
def test_an_interrupted_run_keeps_the_cases_that_are_complete(folder, done, complete):
    before = read_tables(folder)[2]

    def interrupt(at, _):
        if at >= done:
            raise KeyboardInterrupt

    judges = (FurtherMethod(Reason.ENGINE, "sme"), FurtherMethod(Reason.MODEL, "fbs"))
    with pytest.raises(KeyboardInterrupt):
        add_further_verdicts(folder, limit=2, judges=judges, progress=interrupt)
    said = said_by(folder, ["sme", "fbs"])
    assert len(read_tables(folder)[2]) == len(before) + len(said)
    assert len(said) == 2 * complete  # of five cases, which both methods judge before the next
    assert add_further_verdicts(folder, limit=2, judges=judges) == 6 - complete
    assert len(said_by(folder, ["sme", "fbs"])) == 12


def test_labels_of_the_question_stands_are_judged_again_and_the_others_stay(folder):
    before = read_tables(folder)
    judges = (FurtherMethod(Reason.ENGINE, "label@mujoco:frequency=240"),)
    asked = {"part": "test", "limit": 1, "question": Question.STANDS, "judges": judges}
    assert add_further_verdicts(folder, **asked) == 3
    assert add_further_verdicts(folder, **asked) == 0
    after, benchmark = read_tables(folder), load_benchmark(folder)
    for one, other in zip(after[:2], before[:2], strict=True):
        pd.testing.assert_frame_equal(one, other)
    opinions = (each[2][each[2]["question"] == Question.WITHIN] for each in (after, before))
    pd.testing.assert_frame_equal(*opinions)
    engine, *limits = (str(make_method(own.spec).spec) for own in asked_to_stand(judges))
    said = benchmark.further_verdicts_on(Question.STANDS)
    own = said[said["judge"] == engine]
    assert keys_of(own) == keys_of(benchmark.select("test", limit=1, question=Question.STANDS))
    assert set(own["reason"]) == {"engine"}
    for row in own.itertuples():
        verdict = make_method(row.judge).judge(benchmark.layout(row.layout, row.scenario))
        assert verdict.failing_step == (None if pd.isna(row.failing_step) else row.failing_step)
    of_limits = said[said["judge"].isin(limits)]
    assert set(of_limits["reason"]) == {"limits"}
    assert keys_of(own) <= keys_of(of_limits)
    assert not said.duplicated([*KEYS, "judge"]).any()
    was, now = before[3]["judged_with"], after[3]["judged_with"]
    assert now["within"] == was["within"]
    assert now["stands"] != was["stands"]
    assert main(["benchmark", "info", str(folder)]) == 0


def test_all_methods_of_a_panel_are_asked_and_thresholds_besides():
    asked = [make_method(own.spec).spec for own in asked_to_stand(labelling.JUDGES)]
    assert len({str(spec) for spec in asked}) == len(labelling.JUDGES) + 2
    for spec in asked:
        assert dict(spec.values)["question"] == "stands"
    limits = [own for own in asked_to_stand(()) if own.reason is Reason.LIMITS]
    assert [own.spec.split(":")[1] for own in limits] == [
        "eps_t=9,eps_r=9,question=stands", "eps_t=11,eps_r=11,question=stands",
    ]  # fmt: skip


def test_what_is_no_labelled_set_is_refused(tmp_path):
    with pytest.raises(BenchmarkError, match="manifest"):
        add_further_verdicts(tmp_path, judges=JUDGES)


def test_the_command_names_the_cases_that_it_judged(folder, capsys, monkeypatch):
    monkeypatch.setattr("steadyload.labelling.labelling.PANELS", {"few": JUDGES})
    command = ["benchmark", "judge", str(folder), "--limit", "1", "--judges", "few", "-j", "1"]
    assert main(command) == 0
    assert "3 cases judged by further methods" in capsys.readouterr().out
    assert main([*command[:2], str(folder / "nothing"), *command[3:]]) == 2
    assert "nothing" in capsys.readouterr().err

"""Verdicts with changed contacts at the close steps of cases of real size."""

import shutil

import numpy as np
import pandas as pd
import pytest

from steadyload.cli import main
from steadyload.labelling import close_steps
from steadyload.labelling.close_steps import close_cases, judge_close_steps
from steadyload.labelling.labelling import FurtherMethod
from steadyload.layouts.benchmark import BenchmarkError, load_benchmark
from steadyload.layouts.benchmark.confidence import Reason
from steadyload.layouts.benchmark.dataset import KEYS
from steadyload.layouts.benchmark.parts import SETS
from steadyload.layouts.model.question import Question
from steadyload.methods.registry import make_method

CONTACTS = (
    FurtherMethod(Reason.MODEL, "label@mujoco:friction=0.6,frequency=240"),
    FurtherMethod(Reason.NUMERICAL, "label@mujoco:frequency=240"),
)


@pytest.fixture(scope="module")
def shipped():
    return load_benchmark("real")


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A copy of the set of real size, of which three cases are asked about, by quick methods."""
    monkeypatch.setattr(close_steps, "CONTACTS", CONTACTS)
    monkeypatch.setattr(close_steps, "close_cases", lambda *asked: close_cases(*asked)[:3])
    return shutil.copytree(SETS["real"], tmp_path / "real")


def judged_here(opinions):
    """Those of the quick methods; others are shipped with the set."""
    return opinions[opinions["judge"].str.startswith("label@mujoco")]


def test_all_that_fail_are_asked_about_and_as_many_that_stand_as_are_wanted(shipped):
    found = close_cases(shipped, "test", 8)
    stands = shipped.labels_on(Question.STANDS)
    cases = shipped.select("test").merge(stands, on=KEYS, suffixes=("", "_stands"))
    cases = cases.set_index(KEYS)
    fails = cases[["failing_step", "failing_step_stands"]].notna().any(axis=1)
    names = [(case.layout.name, case.scenario) for case in found]
    assert len(set(names)) == len(names) == fails.sum() + 8
    assert set(names[: fails.sum()]) == set(fails[fails].index)
    for case, name in zip(found, names, strict=True):
        steps = cases.loc[name, ["failing_step", "failing_step_stands"]].dropna()
        assert {int(s) for s in steps} <= set(case.steps)
        assert {int(s) - 1 for s in steps if s} <= set(case.steps)
        assert list(case.steps) == sorted(set(case.steps))
        last = max(map(int, steps)) if len(steps) else len(case.layout) - 1
        assert case.steps[-1] == last
        assert len(steps) or len(case.steps) >= 4


def test_a_step_is_close_where_something_new_moves_far_or_balance_is_narrow():
    far = np.array([0.1, 0.8, 0.81, 0.8, 0.3, 0.9])
    moved, margins = [0, 1, 1, 2, 2, 1], [5.0, 5.0, 0.05, 0.05, -0.02, 5.0]
    assert close_steps._close(far, moved, margins) == {1, 2, 3, 4, 5}
    assert close_steps._close(far[:3], moved, [5.0] * 3) == {1}


def test_verdicts_are_opinions_on_both_questions(folder):
    assert judge_close_steps(folder) == 3
    benchmark = load_benchmark(folder)
    for question in Question:
        opinions = judged_here(benchmark.further_verdicts_on(question))
        assert len(opinions) == 6
        assert set(opinions["reason"]) == {"model", "numerical"}
        for row in opinions.itertuples():
            verdict = make_method(row.judge).judge(benchmark.layout(row.layout, row.scenario))
            assert verdict.failing_step == (None if pd.isna(row.failing_step) else row.failing_step)
        robust = benchmark.confidence_on(question)["robust"]
        own = pd.MultiIndex.from_frame(opinions[KEYS].drop_duplicates())
        assert len(own) == 3
        assert robust.loc[own].notna().all()
    pd.testing.assert_frame_equal(benchmark.cases, load_benchmark("real").cases)


def test_an_interrupted_run_keeps_complete_cases_and_goes_on(folder, monkeypatch):
    measure, measured = close_steps.CloseSteps.measure, []

    def ended(unit):
        if len(measured) == 3:
            raise KeyboardInterrupt
        measured.append(unit)
        return measure(unit)

    monkeypatch.setattr(close_steps.CloseSteps, "measure", ended)
    with pytest.raises(KeyboardInterrupt):
        judge_close_steps(folder)
    opinions = load_benchmark(folder).further_verdicts_on(Question.WITHIN)
    assert len(judged_here(opinions)) == 2  # one case by both
    measured.clear()
    judge_close_steps(folder)
    assert len(measured) == 3
    assert len(judged_here(load_benchmark(folder).further_verdicts_on(Question.WITHIN))) == 6


def test_the_command_judges_close_steps(folder, capsys):
    assert main(["benchmark", "judge", str(folder), "--part", "test", "--close-steps", "0"]) == 0
    assert "3 cases judged at their close steps" in capsys.readouterr().out
    assert main(["benchmark", "judge", str(folder), "--close-steps", "0", "--limit", "2"]) == 2
    assert "--close-steps: not allowed with --limit" in capsys.readouterr().err


def test_a_set_without_screened_labels_is_refused():
    with pytest.raises(BenchmarkError, match="allowed: a set that steadyload benchmark screen"):
        close_cases(load_benchmark("lists"), "test-300", 3)

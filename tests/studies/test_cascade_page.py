"""The study of a cascade: who decided what, beside other methods, and which aims are reached."""

import dataclasses
import math
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from steadyload.layouts.benchmark import load_benchmark
from steadyload.methods.cascade.thresholds import (
    Ladder,
    Larger,
    Stage,
    Thresholds,
    ThresholdsError,
    fingerprint,
    write_thresholds,
)
from steadyload.methods.registry import make_method
from steadyload.reports.table import percent
from steadyload.runs.comparison import detectable
from steadyload.runs.results import load_results
from steadyload.statistics.estimate import Estimate
from steadyload.studies.cascade.comparing import aims, compare
from steadyload.studies.cascade.study import Cascade
from steadyload.studies.kit import Lab
from steadyload.tuning import TuningError

FOUND = {
    "cases": 900, "item_lists": 6, "independent": 450.0, "allowed": 3, "lost": 2, "gained": 1,
    "bound": 0.004, "sure_bound": 0.0123, "left_out": {"lost": 5, "cases": 900},
    "left_out_by_size": [{"above": 20, "lost": 5, "cases": 900}], "accuracy": 0.98,
    "alone": 0.981, "milliseconds": 1.0, "milliseconds_alone": 2.5,
    "decided": [{"method": "equilibrium", "steps": 10, "wrong": 0, "lost": 0}],
    "elsewhere": [
        {"method": "equilibrium", "cases": 600, "item_lists": 30, "steps": 3327, "decided": 2872,
         "wrong": 0}
    ],
}  # fmt: skip
LAST = "simulation@mujoco:t_max=0.1,frequency=60,between_steps=reseat"


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    """On eighteen cases, with thresholds that are made up."""
    folder = tmp_path_factory.mktemp("cascade")
    stages = (Stage("equilibrium", 0.7, None, None, (Larger(4, 0.6, None),)),)
    made_of = {s: fingerprint(make_method(s)) for s in ("equilibrium", LAST)}
    made_by = {"confidence": 0.5, "git": "0123456789ab", "code": "c", "cases": "d", "data": []}
    ladders = {0.5: Ladder(stages, LAST, FOUND), 2.0: Ladder((), LAST, FOUND)}
    file = folder / "t.json"
    write_thresholds("mujoco", Thresholds(0.5, ladders, made_of, made_by), file)
    return found_in(folder), folder


def found_in(folder):
    return compare(
        Lab(folder, 0), "mujoco", part="validation", limit=6, thresholds=folder / "t.json",
        beside=("fbs", LAST),
    )  # fmt: skip


def test_shares_of_stages_add_up_and_tell_who_was_right(study):
    record, _ = study
    titles = ["Equilibrium", "Equilibrium above 4 items", record.best.title]
    assert [s.stage for s in record.stages] == titles
    assert sum(s.steps.value for s in record.stages) == pytest.approx(1.0)
    assert sum(s.layouts.value for s in record.stages) == pytest.approx(1.0)
    right = sum(s.layouts.value * s.layouts_right.value for s in record.stages)
    assert right == pytest.approx(record.cascade.accuracy.value)
    assert [(s.low, s.high) for s in record.stages] == [(0.7, None), (0.6, None), (None, None)]


def test_decisions_are_those_of_the_cascade(study):
    """A layout belongs to the last stage that it needed; steps after the label's are not right."""
    record, folder = study
    cascade = make_method(f"cascade@mujoco:thresholds={folder / 't.json'}")
    benchmark = load_benchmark()
    stages, right, above = [], [], []
    for case in benchmark.select("validation", limit=6).itertuples():
        decisions = cascade.decisions(benchmark.layout(case.layout, case.scenario))
        stages.append([own.stage for own in decisions])
        above += [own.stage == "equilibrium" and own.step >= 4 for own in decisions]
        label = math.inf if case.failing_step is pd.NA else case.failing_step
        right += [own.unstable == (own.step == label) for own in decisions if own.step <= label]
    assert record.stages[1].steps.value == pytest.approx(np.mean(above)) != 0.0
    assert record.stages[-1].layouts.value == pytest.approx(np.mean([LAST in s for s in stages]))
    # Of some an earlier stage decided the last step.
    assert any(LAST in own[:-1] and own[-1] != LAST for own in stages)
    shares = [(own.right.value, own.right.n) for own in record.stages]
    assert sum(n for _, n in shares) == len(right)
    assert sum(share * n for share, n in shares) == pytest.approx(sum(right))
    assert not all(right)


def test_all_are_judged_on_the_same_cases_and_held_against_the_cascade(study):
    record, folder = study
    assert record.cases == 18
    assert record.fitted_there
    assert [m.budget for m in record.swept] == ["0.5", "2"]
    fbs, last = record.others
    assert (fbs.method.spec, last.method.spec) == ("fbs", LAST)
    assert fbs.ahead.value == pytest.approx(record.cascade.accuracy.value - fbs.accuracy.value)
    assert fbs.shown == detectable(fbs.ahead, record.item_lists)
    assert record.best == last
    assert record.cascade == record.swept[0]
    assert (record.cascade.ahead, record.cascade.cost_ratio) == (None, None)
    # With no stage before it, the last method is asked of every step: the same substeps.
    assert record.swept[1].substeps == last.substeps > record.cascade.substeps > 0.0
    rows = load_results(folder / "run")
    assert set(rows.groupby("method").size()) == {18}


def test_an_interrupted_study_goes_on(study, monkeypatch):
    record, folder = study
    monkeypatch.setattr("steadyload.runs.provenance.machine_kind", lambda: "another")
    again = found_in(folder)
    assert [m.cpu for m in again.swept + again.others] == [
        m.cpu for m in record.swept + record.others
    ]
    assert again.cost_source == record.cost_source
    assert again.made_with == record.made_with, "that of the times"


def test_thresholds_are_as_their_file_describes_them(study):
    record, _ = study
    first, second = record.ladders
    assert (first.budget, second.stages) == ("0.5", "-")
    assert first.stages == "equilibrium (other thresholds above 4 items)"
    assert (first.last, first.cases, first.independent) == (LAST, 900, 450.0)
    assert (first.losses, first.gained, first.left_out) == ((2, 3), 1, FOUND["left_out"])
    assert (first.bound, first.sure_bound) == (0.004, 0.0123)
    assert (first.accuracy, first.alone) == (0.98, 0.981)
    assert [(row.method, row.steps, row.lost) for row in first.decided] == [("equilibrium", 10, 0)]
    assert first.elsewhere[0].decided == 2872
    assert [(row.above, row.lost, row.cases) for row in first.left_out_by_size] == [(20, 5, 900)]


def test_what_made_thresholds_is_told(study):
    made = study[0].made_with
    assert made["thresholds fitted by"] == "git 0123456789ab"
    assert made["thresholds fitted on"] == "the large set; cases d"
    assert "machine" in made


def test_the_page_shows_what_was_found(study, assert_shown):
    record, _ = study
    own, first = record.cascade, record.ladders[0]
    assert_shown(
        Cascade(),
        record,
        answer=[percent(own.accuracy), record.cases],
        tables=[
            *(record.aims, [own, *record.others], record.stages, record.swept, record.ladders),
            *(first.left_out_by_size, first.decided, first.elsewhere),
        ],
        charts=["cascade-sweep"],
    )


def about(value):
    return Estimate(value, value, value, 18)


def reached(record, accuracy, cpu, ahead, cost):
    """Whether aims are reached by a cascade beside one simulation of these numbers."""
    cascade = dataclasses.replace(record.cascade, accuracy=about(accuracy), cpu=about(cpu))
    simulation = dataclasses.replace(
        record.best, accuracy=about(accuracy - ahead.value), ahead=ahead, cpu=about(cpu / cost),
        cost_ratio=about(cost),
    )  # fmt: skip
    return [aim.reached for aim in aims(cascade, [simulation])]


@pytest.mark.parametrize(
    ("accuracy", "cpu", "ahead", "cost", "answers"),
    [
        (0.985, 0.2, -0.005, 0.09, ["yes", "yes", "yes"]),
        (0.980, 0.9, -0.006, 0.2, ["no", "yes", "no"]),
        (0.990, 1.2, 0.001, 0.1, ["yes", "no", "yes"]),
    ],
)
def test_whether_an_aim_is_reached_is_said(accuracy, cpu, ahead, cost, answers, study):
    assert reached(study[0], accuracy, cpu, about(ahead), cost) == answers


@pytest.mark.parametrize(
    ("ahead", "answer"),
    # Of no more than 0.5 points behind: what the whole interval meets, misses, or neither.
    [((-0.001, -0.009, 0.007), "open"), ((-0.001, -0.005, 0.002), "yes"),
     ((-0.009, -0.014, -0.0051), "no"), ((-0.009, -0.014, -0.004), "open")],
)  # fmt: skip
def test_an_aim_is_decided_by_the_interval(ahead, answer, study):
    found = reached(study[0], 0.985, 0.2, Estimate(*ahead, 18), 0.09)
    assert found == [answer, "yes", "yes"]


@pytest.mark.parametrize(
    ("wrong", "error", "message"),
    [
        (
            {"judge_on": "train"},
            TuningError,
            "part is 'train'; allowed: fitting, search, test, test-300, validation",
        ),
        ({"judge_on": "all"}, TuningError, "part is 'all'"),
        ({"judge_on": "tset"}, TuningError, "did you mean 'test'"),
        (
            {"thresholds": Path("none.json")},
            ThresholdsError,
            r"none.json: no such file .*fit --engine mujoco -o none",
        ),
    ],
)
def test_what_stages_learnt_from_and_what_is_not_there_is_no_page(wrong, error, message, tmp_path):
    with pytest.raises(error, match=message):
        Cascade(limit=2, **wrong).run(Lab(tmp_path / "work", 0))
    assert not (tmp_path / "work").exists()


def test_the_package_s_cascade_is_judged_on_a_set_of_its_own(tmp_path):
    """Its thresholds are fitted on a set that has no test part."""
    record = compare(
        Lab(tmp_path, 0), "mujoco", directory="lists", limit=2, beside=("fbs", "ps_opt@mujoco")
    )
    assert (record.part, record.cases, record.fitted_there) == ("lists test", 6, False)
    assert record.made_with["thresholds fitted on"].startswith("choosing, real; cases ")

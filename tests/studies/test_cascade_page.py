"""The page of a cascade: what its study found, and nothing that it did not."""

import dataclasses
import re

import numpy as np
import pytest

from steadyload.layouts.benchmark import load_benchmark
from steadyload.methods.registry import make_method
from steadyload.methods.thresholds import (
    Ladder,
    Stage,
    Thresholds,
    ThresholdsError,
    fingerprint,
    write_thresholds,
)
from steadyload.reports.writing import write_page
from steadyload.runs.evaluation import MethodEvaluation
from steadyload.runs.results import load_results
from steadyload.statistics.estimate import Estimate
from steadyload.studies.cascade.page import cascade_page
from steadyload.studies.cascade.study import cascade_study
from steadyload.tuning import TuningError

FOUND = {
    "cases": 900, "item_lists": 6, "independent": 450.0, "allowed": 3, "lost": 2, "gained": 1,
    "bound": 0.004, "sure_bound": 0.0123, "left_out": {"lost": 5, "cases": 900}, "accuracy": 0.98,
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
    stages = (Stage("equilibrium", 0.7, None),)
    made_of = {s: fingerprint(make_method(s)) for s in ("equilibrium", LAST)}
    made_by = {"confidence": 0.5, "git": "0123456789ab", "code": "c", "cases": "d", "data": []}
    ladders = {0.5: Ladder(stages, LAST, FOUND), 2.0: Ladder((), LAST, FOUND)}
    file = folder / "t.json"
    write_thresholds("mujoco", Thresholds(0.5, ladders, made_of, made_by), file)
    return cascade_study(
        "mujoco", folder, part="validation", limit=6, thresholds=str(file), workers=0,
        beside=("fbs", LAST),
    ), folder  # fmt: skip


def test_shares_of_stages_add_up_and_tell_who_was_right(study):
    record, _ = study
    assert [s.method.spec for s in record.stages] == ["equilibrium", LAST]
    assert sum(s.steps.value for s in record.stages) == pytest.approx(1.0)
    assert sum(s.layouts.value for s in record.stages) == pytest.approx(1.0)
    right = sum(s.layouts.value * s.layouts_right.value for s in record.stages)
    assert right == pytest.approx(record.cascade.accuracy.value)
    assert (record.stages[0].low, record.stages[0].high) == (0.7, None)


def test_a_layout_belongs_to_the_last_stage_that_it_needed(study):
    record, folder = study
    cascade = make_method(f"cascade@mujoco:thresholds={folder / 't.json'}")
    benchmark = load_benchmark()
    cases = benchmark.select("validation", limit=6)
    asked = [
        [d.stage for d in cascade.decisions(benchmark.layout(name, scenario))]
        for name, scenario in zip(cases["layout"], cases["scenario"], strict=True)
    ]
    assert record.stages[1].layouts.value == pytest.approx(np.mean([LAST in s for s in asked]))
    # Of some an earlier stage decided the last step.
    assert any(LAST in stages[:-1] and stages[-1] != LAST for stages in asked)


def test_all_are_judged_on_the_same_cases_and_held_against_the_cascade(study):
    record, folder = study
    assert record.cases == 18
    assert record.fitted_there
    assert [record.budgets.get(m.method.spec) for m in record.methods] == [0.5, 2.0, None, None]
    by_title = {m.method.spec: m for m in record.methods}
    fbs = by_title["fbs"]
    assert fbs.ahead.value == pytest.approx(record.cascade.accuracy.value - fbs.accuracy.value)
    assert record.simulations == [by_title[LAST]]
    assert record.swept == list(record.methods[:2])
    assert (record.cascade.ahead, record.cascade.cost_ratio) == (None, None)
    # With no stage before it, the last method is asked of every step: the same substeps.
    assert record.methods[1].substeps == by_title[LAST].substeps > record.cascade.substeps > 0.0
    rows = load_results(folder / "run")
    assert set(rows.groupby("method").size()) == {18}


def test_an_interrupted_study_goes_on(study):
    record, folder = study
    times = {m.method.spec: m.cpu for m in record.methods}
    again = cascade_study(
        "mujoco", folder, part="validation", limit=6, thresholds=str(folder / "t.json"), workers=0,
        beside=("fbs", LAST),
    )  # fmt: skip
    assert {m.method.spec: m.cpu for m in again.methods} == times
    assert again.cost_source == record.cost_source


def text_of(record, folder):
    path = write_page(cascade_page(record, {"source": "here"}), folder)
    [details] = folder.glob("report-details.*.md")
    return path.read_text() + details.read_text()


def test_the_page_shows_what_was_found(study, tmp_path):
    record, _ = study
    text = text_of(record, tmp_path)
    assert "18 cases of part `validation`" in text
    assert "on which thresholds were fitted" in text
    assert re.search(r"\| Equilibrium +\| +0\.700 \| +- \|", text)
    assert "5 of 900" in text
    assert "2 (3)" in text
    assert "1.23" in text
    assert "- thresholds fitted by: git 0123456789ab" in text
    [sweep] = (tmp_path / "figures").glob("cascade-sweep.*.svg")
    assert sweep.stat().st_size > 10_000


def aimed(record, accuracy, cpu, ahead, cost):
    """The record with a cascade and one simulation of these numbers."""

    def about(value):
        return Estimate(value, value, value, 18)

    cascade = dataclasses.replace(record.cascade, accuracy=about(accuracy), cpu=about(cpu))
    simulation = MethodEvaluation(
        record.methods[-1].method, accuracy=about(accuracy - ahead), over=about(0.0),
        under=about(0.0), cpu=about(cpu / cost), ahead=about(ahead), cost_ratio=about(cost),
        substeps=50.0,
    )  # fmt: skip
    return dataclasses.replace(record, methods=(cascade, simulation))


@pytest.mark.parametrize(
    ("numbers", "reached"),
    [
        ((0.985, 0.2, -0.005, 0.09), ["yes", "yes", "yes"]),
        ((0.980, 0.9, -0.006, 0.2), ["no", "yes", "no"]),
        ((0.990, 1.2, 0.001, 0.1), ["yes", "no", "yes"]),
    ],
)
def test_whether_an_aim_is_reached_is_said(numbers, reached, study, tmp_path, undrawn):
    text = text_of(aimed(study[0], *numbers), tmp_path)
    assert re.findall(r"\| (yes|no) +\|", text) == reached


@pytest.mark.parametrize(
    ("ahead", "answer"),
    # Of no more than 0.5 points behind: what the whole interval meets, misses, or neither.
    [((-0.001, -0.009, 0.007), "open"), ((-0.001, -0.005, 0.002), "yes"),
     ((-0.009, -0.014, -0.0051), "no"), ((-0.009, -0.014, -0.004), "open")],
)  # fmt: skip
def test_an_aim_is_decided_by_the_interval(ahead, answer, study, tmp_path, undrawn):
    record = aimed(study[0], 0.985, 0.2, -0.005, 0.09)
    cascade, simulation = record.methods
    simulation = dataclasses.replace(simulation, ahead=Estimate(*ahead, 18))
    text = text_of(dataclasses.replace(record, methods=(cascade, simulation)), tmp_path)
    assert re.findall(r"\| (yes|no|open) +\|", text) == [answer, "yes", "yes"]


def test_a_busy_machine_is_told(study, tmp_path, undrawn):
    record, _ = study
    busy = "The machine was busy"
    for load, told in ((5.0, True), (1.1, False), (None, False)):
        source = dataclasses.replace(record.cost_source, load=load)
        text = text_of(dataclasses.replace(record, cost_source=source), tmp_path)
        assert (busy in text) == told
        assert "in one process and one thread, methods in turns of many cases" in text


@pytest.mark.parametrize(
    ("wrong", "error", "message"),
    [
        (
            {"part": "train"},
            TuningError,
            "part is 'train'; allowed: fitting, search, test, test-300, validation",
        ),
        ({"part": "all"}, TuningError, "part is 'all'"),
        ({"part": "tset"}, TuningError, "did you mean 'test'"),
        (
            {"thresholds": "none.json"},
            ThresholdsError,
            r"none.json: no such file .*fit --engine mujoco -o none",
        ),
    ],
)
def test_what_stages_learnt_from_and_what_is_not_there_is_no_page(wrong, error, message, tmp_path):
    with pytest.raises(error, match=message):
        cascade_study("mujoco", tmp_path / "work", limit=2, workers=0, **wrong)
    assert not (tmp_path / "work").exists()


def test_on_test_nothing_was_fitted(study, tmp_path, undrawn):
    text = text_of(dataclasses.replace(study[0], part="test", fitted_there=False), tmp_path)
    assert "nothing was fitted on them" in text


def test_the_package_s_cascade_is_judged_on_a_set_of_its_own(tmp_path):
    """Its thresholds are fitted on a set that has no test part."""
    record = cascade_study(
        "mujoco", tmp_path, directory="lists", limit=2, beside=("fbs", "ps_opt@mujoco"), workers=0
    )
    assert (record.part, record.cases, record.fitted_there) == ("lists test", 6, False)
    assert record.made_by["thresholds fitted on"].startswith("choosing, real; cases ")

"""The study of a cascade: who decided what, beside other methods, and which aims are reached."""

import math

import numpy as np
import pandas as pd
import pytest

from steadyload.layouts.benchmark import load_benchmark
from steadyload.layouts.benchmark.parts import Part
from steadyload.methods.cascade.thresholds import (
    Ladder,
    Larger,
    Stage,
    Thresholds,
    fingerprint,
    write_thresholds,
)
from steadyload.methods.registry import make_method
from steadyload.reports.table import percent
from steadyload.runs.frames import values
from steadyload.runs.results import load_results
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.paired import detectable
from steadyload.studies.cascade import comparing
from steadyload.studies.cascade.comparing import aims, compare
from steadyload.studies.cascade.study import Cascade
from steadyload.studies.kit import Lab

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
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(comparing, "CASCADE", f"cascade@mujoco:thresholds={file}")
        patch.setattr(comparing, "BESIDE", ("fbs", LAST))
        patch.setattr(comparing, "DIRECTORY", "")
        patch.setattr(comparing, "PART", "validation")
        yield compare(Lab(folder, 0), 6), folder


def test_shares_of_stages_add_up_and_tell_who_was_right(study):
    record, _ = study
    titles = ["Equilibrium", "Equilibrium above 4 items", record.best["title"]]
    found = record.stages
    assert list(found["stage"]) == titles
    assert values(found["stage_steps"]).sum() == pytest.approx(1.0)
    assert values(found["stage_layouts"]).sum() == pytest.approx(1.0)
    right = (values(found["stage_layouts"]) * values(found["layouts_right"])).sum()
    assert right == pytest.approx(record.cascade["right"].value)
    assert found[["low", "high"]].fillna(-1).to_numpy().tolist() == [[0.7, -1], [0.6, -1], [-1, -1]]


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
    assert record.stages["stage_steps"][1].value == pytest.approx(np.mean(above)) != 0.0
    assert record.stages["stage_layouts"].iloc[-1].value == pytest.approx(
        np.mean([LAST in s for s in stages])
    )
    # Of some an earlier stage decided the last step.
    assert any(LAST in own[:-1] and own[-1] != LAST for own in stages)
    shares = [(own.value, own.n) for own in record.stages["steps_right"]]
    assert sum(n for _, n in shares) == len(right)
    assert sum(share * n for share, n in shares) == pytest.approx(sum(right))
    assert not all(right)


def test_all_are_judged_on_the_same_cases_and_held_against_the_cascade(study):
    record, folder = study
    assert record.cases == 18
    assert list(record.swept["budget"]) == ["0.5", "2"]
    assert list(record.others.index) == ["fbs", LAST]
    (_, fbs), (_, last) = record.others.iterrows()
    assert fbs["ahead"].value == pytest.approx(record.cascade["right"].value - fbs["right"].value)
    assert fbs["shown"] == detectable(fbs["ahead"], record.item_lists)
    assert record.best.name == LAST
    assert record.cascade.name == record.swept.index[0] == record.beside.index[0]
    assert record.cascade[["ahead", "cost_ratio"]].isna().all()
    # With no stage before it, the last method is asked of every step: the same substeps.
    assert record.swept["substeps"].iloc[1] == last["substeps"] > record.cascade["substeps"] > 0.0
    rows = load_results(folder / "run")
    assert set(rows.groupby("method").size()) == {18}
    taken = rows.pivot(index=["layout", "scenario"], columns="method", values="cpu_total").mean()
    ratio = taken[record.cascade.name] / taken[LAST]
    assert last["cost_ratio"].value == pytest.approx(ratio)


def test_an_interrupted_study_goes_on(study, monkeypatch):
    record, folder = study
    monkeypatch.setattr("steadyload.runs.provenance.machine_kind", lambda: "another")
    again = compare(Lab(folder, 0), 6)
    assert list(again.others["cpu"]) == list(record.others["cpu"])
    assert again.costs == record.costs
    assert again.made_with == record.made_with, "that of the times"


def test_thresholds_are_as_their_file_describes_them(study):
    record, _ = study
    ladders, first = record.ladders, record.first
    assert (ladders["budget"][0], ladders["before_last"][1]) == ("0.5", "-")
    assert ladders["before_last"][0] == "equilibrium (other thresholds above 4 items)"
    assert (first["last"], first["cases"], first["independent"]) == (LAST, 900, 450.0)
    assert (ladders["losses"][0], ladders["left_out"][0]) == ("2 (3)", "5 of 900")
    assert (ladders["bound"][0], ladders["sure_bound"][0]) == (0.004, 0.0123)
    assert (ladders["together"][0], ladders["alone"][0]) == (0.98, 0.981)
    assert record.decided.to_numpy().tolist() == [["equilibrium", 10, 0, 0]]
    assert record.elsewhere["decided"][0] == 2872
    assert record.left_out_by_size.to_numpy().tolist() == [[20, 5, 900]]


def test_what_made_thresholds_is_told(study):
    made = study[0].made_with
    assert made["thresholds fitted by"] == "git 0123456789ab"
    assert made["thresholds fitted on"] == "the large set; cases d"
    assert "machine" in made


def test_the_page_shows_what_was_found(study, assert_shown):
    record, _ = study
    assert_shown(
        Cascade(),
        record,
        answer=[percent(record.cascade["right"]), record.cases],
        charts=["cascade-sweep"],
    )


def about(value):
    return Estimate(value, value, value, 18)


def reached(record, accuracy, cpu, ahead, cost):
    """Whether aims are reached by a cascade beside one simulation of these numbers."""
    cascade = pd.Series({"right": about(accuracy), "cpu": about(cpu)})
    simulation = record.others.loc[[LAST]].assign(
        right=about(accuracy - ahead.value), ahead=ahead, cpu=about(cpu / cost),
        cost_ratio=about(cost),
    )  # fmt: skip
    return list(aims(cascade, simulation)["reached"])


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


def test_the_package_s_cascade_is_judged_on_a_set_of_its_own(tmp_path, monkeypatch):
    """Its thresholds are fitted on a set that has no test part."""
    published = {"CASCADE": "cascade@mujoco", "DIRECTORY": "lists", "PART": Part.TEST}
    for name, value in published.items():
        monkeypatch.setattr(comparing, name, value)  # those of the other tests go on
    monkeypatch.setattr(comparing, "BESIDE", ("fbs", "ps_opt@mujoco"))
    record = Cascade(limit=2).run(Lab(tmp_path, 0))
    assert (record.part, record.cases) == ("lists test", 6)
    assert record.made_with["thresholds fitted on"].startswith("choosing, real; cases ")

"""Which method to use: the one on the measured front, or a sentence that says why there is none."""

import itertools

import numpy as np
import pytest

from steadyload.cli import main
from steadyload.runs.definition import StudyDefinition
from steadyload.runs.runner import run_study
from steadyload.statistics.estimate import Estimate
from steadyload.studies.table5.front import (
    Front,
    FrontError,
    Measured,
    best,
    load_front,
    measured_in,
    recommend,
    write_front,
)


def measured(method, accuracy, cpu, engine=None):
    share = Estimate(accuracy, accuracy - 0.02, accuracy + 0.01, 300)
    return Measured(method, method.upper(), engine, share, Estimate(cpu, cpu, cpu, 300))


@pytest.fixture
def front():
    return Front(
        (
            measured("rule", 0.80, 0.04),
            measured("slower-rule", 0.79, 0.05),
            measured("learner", 0.93, 0.2),
            measured("cascade@mujoco", 0.985, 1.0, "mujoco"),
            measured("worse@dart", 0.97, 5.0, "dart"),
            measured("ps@mujoco", 0.99, 2.5, "mujoco"),
        ),
        {"measured on": "300 cases", "machine": "Linux"},
    )


def test_no_method_on_the_front_is_beaten_in_both():
    random = np.random.default_rng(2)
    every = [measured(f"m{k}", *random.random(2)) for k in range(40)]
    kept = best(Front(tuple(every), {}))
    for one, other in itertools.product(kept, every):
        assert not (other.accuracy.value > one.accuracy.value and other.cpu.value <= one.cpu.value)
    for out in set(every) - set(kept):
        assert any(
            k.accuracy.value >= out.accuracy.value and k.cpu.value <= out.cpu.value for k in kept
        )
    assert [k.cpu.value for k in kept] == sorted(k.cpu.value for k in kept)


@pytest.mark.parametrize(
    ("asked", "method"),
    [
        ({"budget": 0.1}, "rule"),
        ({"budget": 0.2}, "learner"),
        ({"budget": 2.0}, "cascade@mujoco"),
        ({"budget": 100.0}, "ps@mujoco"),
        ({"accuracy": 0.5}, "rule"),
        ({"accuracy": 0.93}, "learner"),
        ({"accuracy": 0.95}, "cascade@mujoco"),
        ({"accuracy": 0.95, "engine": "dart"}, "worse@dart"),
        ({"budget": 100.0, "engine": "dart"}, "worse@dart"),
        ({"budget": 1.5, "accuracy": 0.9}, "cascade@mujoco"),
        ({}, "ps@mujoco"),
    ],
)
def test_a_method_within_the_time_or_accurate_enough(front, asked, method):
    assert recommend(front, **asked).method == method


@pytest.mark.parametrize(
    ("asked", "message"),
    [
        ({"budget": 0.01}, r"budget is 0\.01 ms a layout; the cheapest measured: rule is right in"),
        ({"accuracy": 0.995}, r"accuracy is 99\.5 %; the most accurate measured: ps@mujoco is ri"),
        (
            {"budget": 0.5, "accuracy": 0.95},
            r"the most accurate measured within 0\.5 ms: learner is right in 93\.0 % of cases "
            r"\[91\.0, 94\.0\] and takes 0\.2 ms",
        ),
        ({"engine": "mojuco"}, "unknown engine 'mojuco'; did you mean 'mujoco'"),
    ],
)
def test_where_nothing_fits_the_closest_is_named(front, asked, message):
    with pytest.raises(FrontError, match=message):
        recommend(front, **asked)


def test_a_front_is_read_as_it_was_written(front, tmp_path):
    file = write_front(front, tmp_path / "front.json")
    assert load_front(file) == front
    with pytest.raises(FrontError, match="holds no measured methods; name the folder of a study"):
        load_front(tmp_path / "none.json")
    for damaged in ("{}", '{"measured": [], "about": {}}', '{"measured": [], "about": 3}'):
        file.write_text(damaged)
        with pytest.raises(FrontError, match="holds no measured methods"):
            load_front(file)
    with pytest.raises(FrontError, match="no such method was measured"):
        best(Front((), {}))


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    folder = tmp_path_factory.mktemp("run")
    study = StudyDefinition(
        "few", ("fbs", "equilibrium"), benchmark="validation", limit=6, shard_size=100
    )
    run_study(study, folder)
    return folder


def test_a_run_on_labels_is_a_front(run):
    front = measured_in(run)
    assert [m.method for m in front.measured] == ["fbs", "equilibrium"]
    assert front.measured[0].accuracy.value < front.measured[1].accuracy.value
    assert front.measured[0].accuracy.n == 18
    assert front.about["measured on"].startswith("18 cases of part validation, ")
    assert {"source", "versions", "machine"} <= set(front.about)


def test_a_run_without_labels_is_none(tmp_path, stack):
    run_study(StudyDefinition("none", ("fbs",), generated=2), tmp_path / "run")
    with pytest.raises(FrontError, match="its layouts have no labels"):
        measured_in(tmp_path / "run")


def test_an_interrupted_table_5_is_none_yet(run, tmp_path):
    (tmp_path / "spatial").symlink_to(run)
    with pytest.raises(
        FrontError, match="not whole there yet; go on with steadyload table5 --work"
    ):
        measured_in(tmp_path)


def test_the_command_names_a_method(run, capsys):
    assert main(["recommend", "--from", str(run), "--accuracy", "20%"]) == 0
    chosen = recommend(measured_in(run), accuracy=0.2)
    printed = capsys.readouterr().out.splitlines()
    assert printed[0].startswith(f"{chosen.method} is right in ")
    assert [line.split()[1] for line in printed if line.startswith("->")] == [chosen.method]
    assert main(["recommend", "--from", str(run), "--budget", "5s"]) == 0
    assert capsys.readouterr().out.startswith("equilibrium is right in ")
    assert main(["recommend", "--from", str(run), "--budget", "1us"]) == 2
    assert "budget is 0.001 ms a layout; the cheapest measured: " in capsys.readouterr().err
    assert main(["recommend", "--write"]) == 2
    assert "--write needs --from RUN" in capsys.readouterr().err


def test_times_that_were_taken_apart_are_told_with_how_many(front, tmp_path, capsys):
    about = {"timed on": "90 cases, 3 times each, one thread", **front.about}
    write_front(Front(front.measured, about), tmp_path / "front.json")
    assert main(["recommend", "--from", str(tmp_path), "--budget", "1ms"]) == 0
    last = capsys.readouterr().out.splitlines()[-1]
    assert last == "300 cases; timed on 90 cases, 3 times each, one thread; Linux"


def test_a_goal_above_the_interval_is_said(run, capsys):
    accuracy = measured_in(run).measured[1].accuracy.value
    assert main(["recommend", "--from", str(run), "--accuracy", f"{accuracy}"]) == 0
    told = capsys.readouterr()
    assert "equilibrium is right" in told.out
    assert "The interval of equilibrium reaches below" in told.err


@pytest.mark.parametrize("wrong", [["--budget", "5"], ["--budget", "0ms"], ["--accuracy", "120%"]])
def test_a_number_that_is_none_is_refused(wrong):
    assert main(["recommend", *wrong]) == 2

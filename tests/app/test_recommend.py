"""Which method to use: the one on the measured front, or a sentence that says why there is none."""

import dataclasses
import itertools
import json
import shutil
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from steadyload.app.recommend import kept
from steadyload.app.recommend.folder import measured_in
from steadyload.app.recommend.front import (
    Front,
    FrontError,
    Measured,
    best,
    front_for,
    recommend,
)
from steadyload.app.recommend.kept import load_fronts, merged, write_fronts
from steadyload.atomic import manifest_text, verified_manifest
from steadyload.cli import main
from steadyload.layouts.benchmark import load_benchmark
from steadyload.layouts.model.question import Question, with_question
from steadyload.learners.weights import SHIPPED as SHIPPED_WEIGHTS
from steadyload.methods.cascade.thresholds import FILE
from steadyload.methods.registry import make_method
from steadyload.runs.definition import StudyDefinition, load_study
from steadyload.runs.results import load_results
from steadyload.runs.runner import run_study
from steadyload.statistics.error_costs import ErrorShares
from steadyload.statistics.estimate import Estimate
from steadyload.studies.evaluation.study import Evaluation
from steadyload.studies.kit import Lab

WITHIN, STANDS = Question.WITHIN, Question.STANDS


def measured(method, accuracy, cpu, engine=None):
    share = Estimate(accuracy, accuracy - 0.02, accuracy + 0.01, 300)
    return Measured(method, method.upper(), engine, share, Estimate(cpu, cpu, cpu, 300))


def front_of(*methods, question=WITHIN, fewest=1, most=20, part="test", cases=300, study="one"):
    return Front(
        methods, question, fewest, most, part, cases, 15, study, "mean of judging",
        {"machine": "Linux", "study": study},
    )  # fmt: skip


@pytest.fixture
def front():
    return front_of(
        measured("rule", 0.80, 0.04),
        measured("slower-rule", 0.79, 0.05),
        measured("learner", 0.93, 0.2),
        measured("cascade@mujoco", 0.985, 1.0, "mujoco"),
        measured("worse@dart", 0.97, 5.0, "dart"),
        measured("ps@mujoco", 0.99, 2.5, "mujoco"),
    )


def test_the_command_recommends_what_is_installed(front, tmp_path, monkeypatch, capsys):
    better = measured("best@dart", 0.995, 0.1, "dart")
    file = write_fronts(
        (dataclasses.replace(front, measured=(*front.measured, better)),), tmp_path / kept.NAME
    )
    asked = ["recommend", "--from", str(file.parent), "--accuracy", "99%"]
    assert main(asked) == 0
    assert capsys.readouterr().out.startswith("best@dart is right in 99.5 %")
    monkeypatch.setattr("steadyload.app.recommend.front.engines_here", lambda: ("bullet", "mujoco"))
    assert main(asked) == 0
    told = capsys.readouterr()
    assert told.out.startswith("ps@mujoco is right in 99.0 %")
    assert "best@dart is left out: engine 'dart' is not installed here." in told.err
    assert main([*asked, "--engine", "dart"]) == 0
    assert capsys.readouterr().out.startswith("best@dart is right in 99.5 %")


def test_no_method_on_the_front_is_beaten_in_both():
    random = np.random.default_rng(2)
    every = [measured(f"m{k}", *random.random(2)) for k in range(40)]
    kept = best(every)
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
            r"\[91\.0, 94\.0\] and takes 0\.2 ms\. Question within, measured on 300 cases of "
            r"1 to 20 boxes: part test, 15 item lists; CPU time: mean of judging; Linux",
        ),
        ({"engine": "mojuco"}, "unknown engine 'mojuco'; did you mean 'mujoco'"),
    ],
)
def test_where_nothing_fits_the_closest_is_named(front, asked, message):
    with pytest.raises(FrontError, match=message):
        recommend(front, **asked)


def erring(method, over, under, cpu, engine=None):
    """A method that over- and underestimates these shares of 300 cases."""
    shares = ErrorShares(*(Estimate(each, each / 2, each * 2, 300) for each in (over, under)))
    entry = measured(method, 1.0 - over - under, cpu, engine)
    return dataclasses.replace(entry, errors=shares)


@pytest.fixture
def errors():
    return front_of(
        erring("strict", 0.001, 0.30, 0.01),
        erring("rule", 0.10, 0.02, 0.04),
        erring("ps@mujoco", 0.02, 0.01, 5.0, "mujoco"),
        erring("lazy", 0.09, 0.001, 0.5),
    )


@pytest.mark.parametrize(
    ("ratio", "asked", "method"),
    [
        # 0.02 r + 0.01 against 0.001 r + 0.3: equal at 15.3; against 0.09 r + 0.001: at 0.129.
        (15.2, {}, "ps@mujoco"),
        (15.4, {}, "strict"),
        (0.13, {}, "ps@mujoco"),
        (0.128, {}, "lazy"),
        (1.0, {"budget": 1.0}, "lazy"),
        # 0.1 r + 0.02 against 0.001 r + 0.3: equal at 2.83.
        (2.82, {"budget": 0.1}, "rule"),
        (2.84, {"budget": 0.1}, "strict"),
        (100.0, {"accuracy": 0.9}, "ps@mujoco"),
        (100.0, {"accuracy": 0.9, "budget": 1.0}, "lazy"),
        (0.01, {"engine": "mujoco"}, "lazy"),
    ],
)
def test_a_method_by_what_its_errors_cost(errors, ratio, asked, method):
    assert recommend(errors, overestimation_costs=ratio, **asked).method == method


def test_errors_that_cost_alike_are_the_share_of_wrong_cases(errors):
    assert best(errors.measured, None, 1.0) == best(errors.measured)
    assert recommend(errors, overestimation_costs=1.0) == recommend(errors)


def test_without_the_directions_of_errors_there_is_a_sentence(front, tmp_path, capsys):
    with pytest.raises(FrontError, match=r"measurement of rule .* does not tell over- from under"):
        recommend(front, overestimation_costs=10.0)
    write_fronts([front], tmp_path / "fronts.json")
    asked = ["recommend", "--from", str(tmp_path), "--budget", "1ms"]
    assert main(asked) == 0
    capsys.readouterr()
    assert main([*asked, "--overestimation-costs", "10"]) == 2
    assert "--overestimation-costs has nothing to go by" in capsys.readouterr().err


def test_the_command_takes_the_cost_of_an_overestimation(errors, tmp_path, capsys):
    write_fronts([errors], tmp_path / "fronts.json")
    assert load_fronts(tmp_path / "fronts.json") == (errors,)
    asked = ["recommend", "--from", str(tmp_path), "--overestimation-costs", "2"]
    assert main([*asked, "--budget", "1ms"]) == 0
    first, *printed = capsys.readouterr().out.splitlines()
    assert first.startswith("lazy is right in 90.9 % of cases ")
    # 2 * 0.09 + 0.001; 2 * 0.045 and 0.0005 below, 2 * 0.09 and 0.001 above.
    assert "its errors cost 0.181 [0.091, 0.361] a layout, where an overestimation costs 2" in first
    assert [line.split()[1:3] for line in printed if line.startswith("->")] == [["lazy", "0.181"]]
    # Nothing is cheaper in both: the front of costs, by rising CPU time.
    names = [line.replace("->", "").split()[0] for line in printed[2:-2] if "to" in line]
    assert names == ["strict", "rule", "lazy", "ps@mujoco"]
    assert main([*asked, "--accuracy", "95%"]) == 0
    assert capsys.readouterr().out.startswith("ps@mujoco is right")


@pytest.fixture
def several():
    """Fronts of two sets, in no order."""
    real = {"part": "test of the set real", "study": "real"}
    return (
        front_of(fewest=38, most=61, cases=115, **real),
        front_of(fewest=25, most=37, cases=95, **real),
        front_of(cases=3000, study="table5"),
        front_of(cases=180, study="real small", question=STANDS),
        front_of(fewest=25, most=36, cases=90, question=STANDS, **real),
        front_of(fewest=30, most=33, cases=12, part="validation of the set real", study="other"),
    )


@pytest.mark.parametrize(
    ("question", "boxes", "fewest", "cases"),
    [
        (WITHIN, None, 1, 3000),
        (STANDS, None, 1, 180),
        (WITHIN, 1, 1, 3000),
        (WITHIN, 20, 1, 3000),
        (WITHIN, 22, 1, 3000),
        (WITHIN, 23, 25, 95),
        (WITHIN, 30, 25, 95),  # two were measured at this size: more cases count
        (WITHIN, 37, 25, 95),
        (WITHIN, 38, 38, 115),
        (WITHIN, 61, 38, 115),
        (STANDS, 36, 25, 90),
    ],
)
def test_the_front_is_of_the_question_and_of_the_nearest_size(
    several, question, boxes, fewest, cases
):
    found = front_for(several, question, boxes)
    assert (found.question, found.fewest, found.cases) == (question, fewest, cases)


@pytest.mark.parametrize(
    ("question", "boxes", "message"),
    [
        (WITHIN, 62, "layouts of 62 boxes for the question within; measured: 1 to 20, 25 to 37, "
                     "30 to 33, 38 to 61 boxes"),
        (STANDS, 37, "layouts of 37 boxes for the question stands; measured: 1 to 20, 25 to 36 "),
    ],
)  # fmt: skip
def test_nothing_is_extrapolated(several, question, boxes, message):
    with pytest.raises(FrontError, match=message):
        front_for(several, question, boxes)
    with pytest.raises(FrontError, match="for the question within; measured: 25 to 37 boxes"):
        front_for(several[1:2], WITHIN, 24)
    with pytest.raises(FrontError, match="measured for the question stands"):
        front_for(several[:3], STANDS, boxes)


def test_a_run_replaces_the_fronts_of_its_own_cases_alone(several):
    kept = merged((), several)
    assert sorted(kept, key=repr) == sorted(several, key=repr)
    again = dataclasses.replace(several[1], fewest=26, cases=40)  # fewer, by the same study
    assert set(map(repr, merged(kept, [again]))) == {
        repr(f) for f in (*several[:1], again, *several[2:])
    }
    few = front_of(cases=180, study="real small")
    assert merged(kept, [few]) == kept  # Table 5 has more cases of this size
    many = dataclasses.replace(few, cases=3000)
    assert many in merged(kept, [many])
    assert len(merged(kept, [many])) == len(kept)
    larger = dataclasses.replace(several[0], fewest=63, most=80)
    assert len(merged(kept, [larger])) == len(kept) + 1
    assert len(merged(kept, [dataclasses.replace(several[0], question=STANDS)])) == len(kept) + 1


def test_fronts_are_read_as_they_were_written(front, several, tmp_path):
    left_out = dataclasses.replace(several[0], left_out={"slow": "not timed"})
    file = write_fronts([front, left_out], tmp_path / "fronts.json")
    assert load_fronts(file) == (front, left_out)
    with pytest.raises(FrontError, match="holds no measured methods; name the folder of a study"):
        load_fronts(tmp_path / "none.json")
    for damaged in ("{}", '{"fronts": [{}]}', '{"fronts": 3}'):
        file.write_text(damaged)
        with pytest.raises(FrontError, match="holds no measured methods"):
            load_fronts(file)
    with pytest.raises(FrontError, match="no such method was measured"):
        best([])


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    folder = tmp_path_factory.mktemp("run")
    study = StudyDefinition(
        "few", ("fbs", "equilibrium"), benchmark="validation", limit=6, shard_size=100
    )
    run_study(study, folder)
    return folder


def test_a_run_on_labels_is_a_front_a_question(run):
    within, stands = measured_in(run)
    assert (within.question, stands.question) == (WITHIN, STANDS)
    assert [m.method for m in within.measured] == ["fbs", "equilibrium"]
    assert within.measured[0].accuracy.value < within.measured[1].accuracy.value
    assert within.measured[0].accuracy.n == within.cases == 18
    assert within.part == "validation"
    assert within.times == "mean of judging"
    rows = load_results(run)
    for entry in within.measured:
        own = rows[rows["method"] == entry.method]
        assert entry.cpu.value == pytest.approx(1e3 * own["cpu_total"].mean())
    assert {"source", "versions", "machine"} <= set(within.about)


@pytest.fixture(scope="module")
def networks(tmp_path_factory):
    """Specs of networks that refuse boxes longer than 27 cm and a tenth, by question."""
    specs = {}
    for question, name in ((WITHIN, "lstm_1"), (STANDS, "lstm_1-stands")):
        folder = tmp_path_factory.mktemp("weights") / name
        shutil.copytree(SHIPPED_WEIGHTS / name, folder)
        manifest = verified_manifest(json.loads((folder / "manifest.json").read_text()))
        manifest["ranges"]["longest side"] = [2.0, 27.0]
        (folder / "manifest.json").write_text(manifest_text(manifest))
        specs[question] = f"lstm_1:weights={folder},question={question}"
    return specs


@pytest.fixture(scope="module")
def real(tmp_path_factory, networks):
    """The work folder of an evaluation on layouts of real size, on a few of them."""
    work = tmp_path_factory.mktemp("real")
    methods = ("fbs", "settling", *networks.values())
    study = Evaluation(methods=methods, directory="real", asked="both", timeout=20.0, limit=4)
    study.run(Lab(work, workers=0))
    return work


@pytest.mark.parametrize(("name", "word"), [(None, "test"), ("real", "test of the set real")])
@pytest.mark.parametrize("question", Question)
def test_real_size_is_measured_by_question_and_boxes(real, networks, name, word, question):
    """Accuracies are those of verdicts that are asked for here, one by one."""
    benchmark = load_benchmark(name)
    cases = benchmark.select("test", limit=4, question=question)
    chosen = benchmark.select("test", limit=4)  # what the study judges, whatever the question
    keys = ["layout", "scenario"]
    cases = cases.merge(chosen[keys], on=keys)
    fronts = [f for f in measured_in(real) if f.part == word and f.question is question]
    assert sum(front.cases for front in fronts) == len(cases) > 8
    rows = load_results(real / ("real" if name else "small"))
    for front in fronts:
        here = cases[cases["item_count"].between(front.fewest, front.most)]
        assert (front.cases, front.item_lists) == (len(here), here["instance"].nunique())
        lstm = str(make_method(networks[question]).spec)
        assert [m.method for m in front.measured] == ["fbs", "settling", *([] if name else [lstm])]
        assert front.left_out == ({lstm: f"no verdict on any of {len(here)} cases"} if name else {})
        for entry in front.measured:
            method, right, lost = make_method(entry.method), 0, 0
            for _, case in here.iterrows():
                verdict = method.judge(benchmark.layout(case["layout"], case["scenario"]))
                label = None if pd.isna(case["failing_step"]) else case["failing_step"]
                lost += verdict.status != "done"
                right += verdict.status == "done" and verdict.failing_step == label
            assert (entry.accuracy.n, entry.without_verdict) == (len(here), lost)
            assert entry.accuracy.value == pytest.approx(right / len(here))
            own = rows[(rows["method"] == entry.method) & (rows["status"] == "done")]
            own = own.merge(here[keys], on=keys)
            if len(here) == len(chosen[chosen["item_count"].between(front.fewest, front.most)]):
                assert entry.cpu.value == pytest.approx(1e3 * own["cpu_total"].median())


def test_a_refused_case_counts_as_wrong_and_is_counted(tmp_path, networks):
    spec = str(make_method(networks[WITHIN]).spec)
    study = StudyDefinition("few", ("fbs", spec), benchmark="test", limit=40)
    run_study(study, tmp_path)
    rows = load_results(tmp_path)
    refused = (rows[rows["method"] == spec]["status"] == "refused").sum()
    assert refused
    entry = measured_in(tmp_path)[0].measured[1]
    # Who refuses does not load: that costs as much as an underestimation.
    wrong = entry.errors.over.value + entry.errors.under.value
    assert wrong == pytest.approx(1.0 - entry.accuracy.value)
    assert entry.errors.under.value >= refused / 120
    assert (entry.method, entry.without_verdict, entry.accuracy.n) == (spec, refused, 120)
    assert entry.accuracy.value <= 1.0 - refused / 120


def test_a_run_without_labels_is_none(tmp_path, stack):
    run_study(StudyDefinition("none", ("fbs",), generated=2), tmp_path / "run")
    with pytest.raises(FrontError, match="its layouts have no labels"):
        measured_in(tmp_path / "run")


def test_an_interrupted_evaluation_is_none_yet(run, tmp_path):
    (tmp_path / "spatial").symlink_to(run)
    with pytest.raises(
        FrontError, match="is not complete there; go on with steadyload study evaluation --work"
    ):
        measured_in(tmp_path)


def test_the_command_names_a_method(run, capsys):
    assert main(["recommend", "--from", str(run), "--accuracy", "20%"]) == 0
    chosen = recommend(measured_in(run)[0], accuracy=0.2)
    printed = capsys.readouterr().out.splitlines()
    assert printed[0].startswith(f"{chosen.method} is right in ")
    assert [line.split()[1] for line in printed if line.startswith("->")] == [chosen.method]
    assert main(["recommend", "--from", str(run), "--budget", "5s"]) == 0
    assert capsys.readouterr().out.startswith("equilibrium is right in ")
    assert main(["recommend", "--budget", "1us"]) == 2
    assert "budget is 0.001 ms a layout; the cheapest measured: " in capsys.readouterr().err
    assert main(["recommend", "--write"]) == 2
    assert "--write needs --from RUN" in capsys.readouterr().err


def test_the_command_asks_for_size_and_question(real, networks, capsys):
    asked = ["recommend", "--from", str(real), "--question", "stands"]
    assert main([*asked, "--boxes", "40"]) == 0
    told = capsys.readouterr()
    assert told.out.splitlines()[-1].startswith("Question stands, measured on ")
    assert "part test of the set real, " in told.out
    spec = make_method(networks[STANDS]).spec
    assert f"{spec} is left out: no verdict on any of " in told.err
    assert main([*asked, "--boxes", "22"]) == 0
    assert "No layout of 22 boxes was measured: those of " in capsys.readouterr().err
    assert main(asked) == 0
    told = capsys.readouterr()
    assert "cases of 1 to 20 boxes: part test, " in told.out.splitlines()[-1]
    assert "Other sizes (--boxes) that were measured: 2" in told.err
    assert main([*asked, "--boxes", "400"]) == 2
    assert "no method was measured on layouts of 400 boxes" in capsys.readouterr().err


def test_the_package_knows_small_layouts(capsys):
    assert main(["recommend", "--budget", "5ms", "--question", "within"]) == 0
    last = capsys.readouterr().out.splitlines()[-1]
    assert last.startswith(
        "Question within, measured on 900 cases of 1 to 20 boxes: part test of the set lists, "
    )
    assert main(["recommend", "--budget", "5ms"]) == 0
    assert capsys.readouterr().out.splitlines()[-1].startswith("Question stands, measured on ")


def test_a_size_that_was_not_measured_is_told_the_nearest_one(capsys):
    assert main(["recommend", "--boxes", "1000"]) == 2
    told = capsys.readouterr().err
    assert "measured on layouts of 1000 boxes for the question stands" in told
    assert "102 to 146 boxes, of which 146 are nearest: --boxes 146." in told


def test_a_run_is_kept_beside_others(real, tmp_path, monkeypatch, capsys):
    file = tmp_path / "fronts.json"
    table5 = front_of(measured("fbs", 0.5, 1.0), cases=3000, study="table5")
    write_fronts([table5], file)
    monkeypatch.setattr(kept, "FILE", file)
    assert main(["recommend", "--from", str(real), "--write"]) == 0
    told = capsys.readouterr()
    assert told.out == f"{file}\n"
    assert "Not kept, since another study has more cases: Question within, measured " in told.err
    small, *others = measured_in(real)
    assert (small.question, small.study) == (WITHIN, "real small")
    assert sorted(load_fronts(file), key=repr) == sorted([table5, *others], key=repr)


def test_times_that_were_taken_apart_are_told_with_how_many(front, tmp_path, capsys):
    timed = dataclasses.replace(front, times="mean of 90 cases, 3 times each, one thread")
    write_fronts([timed], tmp_path / "fronts.json")
    assert main(["recommend", "--from", str(tmp_path), "--budget", "1ms"]) == 0
    last = capsys.readouterr().out.splitlines()[-1]
    assert last.endswith("; CPU time: mean of 90 cases, 3 times each, one thread; Linux")


def test_a_goal_above_the_interval_is_said(run, capsys):
    accuracy = measured_in(run)[0].measured[1].accuracy.value
    assert main(["recommend", "--from", str(run), "--accuracy", f"{accuracy}"]) == 0
    told = capsys.readouterr()
    assert "equilibrium is right" in told.out
    assert "The interval of equilibrium reaches below" in told.err


@pytest.mark.parametrize(
    "wrong",
    [
        ["--budget", "5"], ["--budget", "0ms"], ["--accuracy", "120%"], ["--boxes", "0"],
        ["--question", "falls"], ["--overestimation-costs", "0"],
        ["--overestimation-costs", "inf"], ["--overestimation-costs", "much"],
    ],
)  # fmt: skip
def test_a_number_that_is_none_is_refused(wrong):
    assert main(["recommend", *wrong]) == 2


def test_what_is_known_of_small_layouts_can_be_measured_again():
    study = load_study(Path(kept.__file__).with_name("study.toml"))
    asked = {str(make_method(spec).spec) for spec in study.methods}
    known = [f for f in load_fronts() if f.most <= 20]
    assert {m.method for front in known for m in front.measured} <= asked
    fitted = json.loads(FILE.read_text())["fitted"]
    assert {with_question(f"cascade@{one['engine']}", one["question"]) for one in fitted} <= asked

"""Studies on labelled sets: what is judged, what is kept, and how often methods are right."""

import dataclasses
import json
import math
import re
import shutil
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from steadyload.atomic import checksum, manifest_text
from steadyload.cli import main
from steadyload.labelling.building.build import BuildOptions, build
from steadyload.layouts.benchmark import BenchmarkError, load_benchmark
from steadyload.layouts.benchmark.parts import SHIPPED, Part
from steadyload.layouts.benchmark.tables import (
    CASES,
    LABELS,
    OPINIONS,
    read_tables,
    write_tables,
)
from steadyload.layouts.model.question import Question
from steadyload.methods.naming import MethodKey
from steadyload.methods.registry import make_method
from steadyload.reports.pages.writing import write_page
from steadyload.runs.accuracy import at_natural_prevalence, verdicts_against_labels
from steadyload.runs.costs import CostKind, timed_costs
from steadyload.runs.definition import StudyDefinition, StudyError, load_study
from steadyload.runs.evaluation import ALL, evaluate
from steadyload.runs.judged import load_judged
from steadyload.runs.labels import Cases, as_labels, load_labels
from steadyload.runs.results import ResultsError, load_manifest, load_results
from steadyload.runs.runner import run_study
from steadyload.runs.timing import Times
from steadyload.statistics.metrics import mean, share
from steadyload.studies.kit import Lab
from steadyload.studies.report.comparing import compare
from steadyload.studies.report.study import RunReport

METHODS = ("fbs", "sme", "equilibrium:time=0.3", "simulation@mujoco:t_max=0.1,frequency=60")


@pytest.fixture(scope="module")
def labelled_set(tmp_path_factory):
    """Three item lists; labels are not simulated, a static method stands in for the simulation.

    ``test`` holds stable and unstable cases in turn, by scenario. Of every three cases one has a
    robust label, one a fragile one, and one was asked of nobody.
    """
    layouts, cases = build(BuildOptions(instances=1, item_counts={3: 8}))
    judge, rows, opinions = make_method("equilibrium:time=0.3"), [], []
    for number, (scenario, layout) in enumerate(cases):
        step = judge.judge(layout).failing_step
        case = {"layout": layout.name, "scenario": scenario}
        offsets = None if scenario == "S1" else layout.mass_offsets.ravel().tolist()
        rows.append(
            dict.fromkeys(CASES.names)
            | {**case, "item_count": len(layout), "offsets": offsets, "status": "done"}
            | {"failing_step": step}
        )
        other = step if number % 3 == 0 else 0
        for reason, said in (("numerical", step), ("model", other), ("limits", step)):
            if number % 3 < 2:
                opinion = {"reason": reason, "judge": "made up", "status": "done"}
                opinions.append({**case, "question": "within", **opinion, "failing_step": said})
    table = pd.DataFrame(rows).astype({"failing_step": "Int16", "rank": "Int32"})
    table = table.sample(frac=1.0, random_state=0, ignore_index=True)  # mixes item lists
    answers = table["failing_step"].isna()
    place = table.groupby(["scenario", answers]).cumcount()
    # Stable cases on even ranks, unstable ones on odd: any even number of first ranks is balanced.
    table["rank"] = (2 * place + ~answers).astype("Int32")
    table["split"] = np.where(place < 12, "test", np.where(place < 18, "validation", None))
    # A layout in no scenario's split has no rank.
    table.loc[table["split"].isna(), "rank"] = pd.NA
    table.loc[table["split"] == "validation", "rank"] -= 24
    folder = tmp_path_factory.mktemp("labelled") / "set"
    said = pd.DataFrame(opinions, columns=OPINIONS.names).astype({"failing_step": "Int16"})
    write_tables(folder, layouts, table, said, {})
    return folder


@pytest.fixture(scope="module")
def study(labelled_set):
    return StudyDefinition(
        "labelled", METHODS, benchmark="test", benchmark_directory=labelled_set, limit=16
    )


@pytest.fixture(scope="module")
def run(study, tmp_path_factory):
    folder = tmp_path_factory.mktemp("labelled-run") / "run"
    run_study(study, folder)
    return folder


def test_a_study_judges_the_cases_of_the_set(run, study, labelled_set):
    benchmark, rows = load_benchmark(labelled_set), load_results(run)
    assert len(rows) == 3 * 16 * len(METHODS)
    expected = {
        (name, scenario): benchmark.layout(name, scenario).content_hash()
        for name, scenario in zip(rows["layout"], rows["scenario"], strict=True)
    }
    found = {(r.layout, r.scenario): r.layout_hash for r in rows.itertuples()}
    assert found == expected
    labels = load_labels(run)
    assert labels["failing_step"].isna().groupby("scenario").sum().tolist() == [8, 8, 8]
    truth = benchmark.cases.set_index(["layout", "scenario"]).loc[labels.index]
    pd.testing.assert_series_equal(labels["failing_step"], truth["failing_step"])
    assert labels["instance"].tolist() == truth["instance"].tolist()
    assert labels["robust"].value_counts(dropna=False).to_dict().keys() == {True, False, pd.NA}
    manifest = load_manifest(run)
    assert manifest["study"]["benchmark"] == "test"
    assert manifest["labels"]["natural_stable"] == benchmark.natural_stable
    assert str(labelled_set) not in json.dumps(manifest)


def test_scenarios_and_parts_pick_cases(study, labelled_set, tmp_path):
    (tmp_path / "s.toml").write_text(
        'benchmark = "validation"\nbenchmark_directory = "set"\nscenarios = ["S2b"]\n'
        'methods = ["sme"]\nlimit = 4\n'
    )
    shutil.copytree(labelled_set, tmp_path / "set")
    run_study(load_study(tmp_path / "s.toml"), tmp_path / "run")
    labels = load_labels(tmp_path / "run")
    chosen = load_benchmark(labelled_set).select("validation", scenarios=("S2b",), limit=4)
    assert labels.index.tolist() == list(zip(chosen["layout"], chosen["scenario"], strict=True))
    evaluation = evaluate(tmp_path / "run")
    assert evaluation.groups == (ALL,)
    assert evaluation.methods[0].behind is None


def test_a_second_run_is_finished_and_new_labels_reach_the_folder(
    run, study, labelled_set, tmp_path
):
    mine = shutil.copytree(run, tmp_path / "run")
    made = {
        "git": "0123456789ab", "versions": {"numpy": "1.0"}, "machine": "another",
        "started": "2020-01-01T00:00:00+00:00", "finished": "2020-01-01T00:00:05+00:00",
    }  # fmt: skip
    (mine / "manifest.json").write_text(manifest_text(load_manifest(mine) | made))
    before = (mine / "manifest.json").read_bytes()
    assert run_study(study, mine) == 0
    assert (mine / "manifest.json").read_bytes() == before
    layouts, cases, opinions, _ = read_tables(labelled_set)
    cases["failing_step"] = cases["failing_step"].fillna(0)
    write_tables(tmp_path / "other", layouts, cases, opinions, {})
    changed = dataclasses.replace(study, benchmark_directory=tmp_path / "other")
    assert run_study(changed, mine) == 0  # verdicts do not depend on labels
    assert load_labels(mine)["failing_step"].notna().all()
    again = load_manifest(mine)
    assert again["labels"] != json.loads(before)["labels"]
    assert {name: again[name] for name in made} == made, "all verdicts are kept ones"
    plain = StudyDefinition("labelled", ("fbs",), generated=2)
    assert run_study(plain, mine) == 2
    assert load_manifest(mine)["machine"] != "another"
    assert not (mine / "labels.parquet").exists()
    assert evaluate(mine).labelled is None
    assert evaluate(mine).methods[0].accuracy.n == 0


def test_verdicts_count_as_by_hand():
    labels = pd.DataFrame(
        {"item_count": [5] * 7, "failing_step": [2, 2, 2, None, None, 4, 4]},
    ).astype({"failing_step": "Int16"})
    said = pd.Series([2, 4, 1, 5, 4, 5, None], dtype="Int32")
    found = verdicts_against_labels(said, labels)
    expected = {
        "right": [1, 0, 0, 1, 0, 0, 0],
        "over": [0, 1, 0, 0, 0, 1, 0],
        "under": [0, 0, 1, 0, 1, 0, 0],
        "under_or_none": [0, 0, 1, 0, 1, 0, 1],
        "stable_or_not": [1, 1, 1, 1, 0, 0, 0],
        "within_one": [1, 0, 1, 1, 1, 1, 0],
    }
    assert {name: column.astype(int).tolist() for name, column in found.items()} == expected


def counted(run, labelled_set):
    """Rows joined to labels of the set itself, by pandas alone."""
    layouts = pd.read_parquet(labelled_set / "layouts.parquet")[["layout", "instance"]]
    cases = pd.read_parquet(labelled_set / "cases.parquet")
    cases = cases[["layout", "scenario", "failing_step"]].merge(layouts, on="layout")
    rows = load_results(run)[["method", "layout", "scenario", "item_count", "score", "status"]]
    both = rows.merge(cases, on=["layout", "scenario"])
    both["truth"] = (both["failing_step"] / both["item_count"]).fillna(1.0)
    return both


def test_accuracies_count_as_scores_do(run, labelled_set):
    """Eq. 5 by scores, rounded to three decimals, as the authors' code compares them."""
    both = counted(run, labelled_set)
    both["right"] = both["score"].round(3) == both["truth"].round(3)
    evaluation = evaluate(run)
    about = evaluation.labelled
    assert (about.cases, about.stable, about.item_lists) == (48, 24, 3)
    assert evaluation.methods[2].accuracy.value == 1.0  # it has made the labels
    assert 0.0 < evaluation.methods[1].accuracy.value < 1.0
    for summary in evaluation.methods:
        mine = both[both["method"] == summary.method.spec]
        assert summary.accuracy == share(mine["right"], mine["instance"])
        assert summary.over.value == (mine["score"] > mine["truth"] + 1e-9).mean()
        assert summary.under.value == (mine["score"] < mine["truth"] - 1e-9).mean()
        alike = (mine["score"] == 1.0) == (mine["truth"] == 1.0)
        assert summary.stable_or_not.value == alike.mean()
        assert evaluation.groups == (ALL, "S1", "S2a", "S2b")
        for scenario in evaluation.groups[1:]:
            here = evaluation.row(summary.method.spec, scenario)
            assert (here.method, here.group) == (summary.method, scenario)
            assert here.accuracy.value == mine[mine["scenario"] == scenario]["right"].mean()
    best = evaluation.methods[2]
    assert best.behind is None
    sme = evaluation.methods[1]
    assert sme.behind.value == pytest.approx(sme.accuracy.value - best.accuracy.value)
    assert sme.behind.low <= sme.behind.value <= sme.behind.high


def test_methods_are_compared_on_the_cases_of_a_group(run, labelled_set):
    both = counted(run, labelled_set)
    both["right"] = both["score"].round(3) == both["truth"].round(3)
    evaluation = evaluate(run)
    best, keys = evaluation.methods[2], evaluation.judged.keys
    for group in evaluation.groups:
        here = both if group == ALL else both[both["scenario"] == group]
        shares = here.groupby("method")["right"].mean()
        family = evaluation.versus(best.method.spec, group)
        assert [t.first.spec for t in family.tests] == [s for s in keys if s != best.method.spec]
        assert evaluation.pairs(group).versus(best.method).tests == family.tests
        for test in family.tests:
            apart = shares[test.first.spec] - shares[best.method.spec]
            assert test.difference.value == pytest.approx(apart)
            row = evaluation.row(test.first.spec, group)
            assert test.difference in (row.behind, evaluation.difference(
                test.first.spec, best.method.spec, group))  # fmt: skip
        assert 0.0 < min(test.p for test in family.tests) < 1.0
    scenarios = evaluation.slices(evaluation.judged.said.index.get_level_values("scenario"))
    assert [found.name for found in scenarios] == list(evaluation.groups[1:])
    for found in scenarios:
        rows = evaluation.rows[found.name]
        assert found.accuracy == {row.method: row.accuracy for row in rows}


def test_a_lab_judges_cases_of_a_set_that_is_at_hand(run, study, labelled_set, tmp_path):
    cases = Cases(load_benchmark(labelled_set), Part.TEST, limit=16)
    found = Lab(tmp_path, workers=0).judge(METHODS, cases, name="labelled")
    again = evaluate(run)
    assert found.labelled == again.labelled
    assert [(m.method, m.accuracy) for m in found.methods] == [
        (m.method, m.accuracy) for m in again.methods
    ]
    seen = []
    lab = Lab(tmp_path, workers=0, progress=lambda *at: seen.append(at))
    kept = lab.judge(METHODS, cases, name="labelled", costs=CostKind.ONE_PROCESS)
    assert seen == [("judging judged", 192, 192)]
    assert kept.cost_source.kind is CostKind.ONE_PROCESS
    with pytest.raises(ResultsError, match="holds the study 'labelled'"):
        lab.judge(METHODS, cases, name="another")


def test_a_lab_compares_with_the_labels_of_a_question(labelled_set, tmp_path):
    """By `stands` the first case of a drawn set falls at once, and the second one has no label."""
    benchmark = load_benchmark(labelled_set)
    chosen = benchmark.select(Part.TEST, scenarios=("S1",), limit=2)[benchmark.cases.columns]
    stands = chosen[["layout", "scenario"]].iloc[:1].assign(status="done", failing_step=0)
    stands = stands.assign(question=str(Question.STANDS)).reindex(columns=LABELS.names)
    further = stands.astype({"failing_step": "Int16", "moved_item": "Int16"})
    labelled = dataclasses.replace(benchmark, further_labels=further)
    drawn = labelled.drawn(chosen[::-1])
    assert drawn.select()["layout"].tolist() == chosen["layout"].tolist()[::-1]
    lab = Lab(tmp_path, workers=0)
    judged = {
        question: lab.judge(["fbs", "sme"], Cases(drawn), question=question)
        for question in (None, *Question)
    }
    assert judged[Question.STANDS].judged.said.index.tolist() == [
        (chosen["layout"].iloc[0], "S1")
    ]  # fmt: skip
    assert judged[Question.STANDS].judged.labels["failing_step"].tolist() == [0]
    for question in (None, Question.WITHIN):
        labels = judged[question].judged.labels["failing_step"]
        truth = chosen.set_index(["layout", "scenario"])["failing_step"]
        pd.testing.assert_series_equal(labels, truth.loc[labels.index])


def test_robust_and_fragile_cases_are_told_apart(run):
    labels, evaluation = load_labels(run), evaluate(run)
    sure = labels["robust"].fillna(False).to_numpy(bool)
    unsure = (~labels["robust"]).fillna(False).to_numpy(bool)
    assert (evaluation.labelled.robust, evaluation.labelled.fragile) == (sure.sum(), unsure.sum())
    assert 0 < sure.sum() + unsure.sum() < len(labels)
    rows = load_results(run)
    said = rows[rows["method"] == "sme"].set_index(["layout", "scenario"]).loc[labels.index]
    right = said["failing_step"].fillna(-1) == labels["failing_step"].fillna(-1)
    sme = evaluation.methods[1]
    assert (sme.robust.n, sme.robust.value) == (sure.sum(), right[sure].mean())
    assert (sme.fragile.n, sme.fragile.value) == (unsure.sum(), right[unsure].mean())


def test_natural_prevalence_weighs_stable_cases(run, labelled_set):
    both = counted(run, labelled_set)
    both["right"] = (both["score"] - both["truth"]).abs() < 1e-9
    cases = pd.read_parquet(labelled_set / "cases.parquet")
    shares = cases["failing_step"].isna().groupby(cases["scenario"]).mean()
    for summary in evaluate(run).methods:
        mine = both[both["method"] == summary.method.spec]
        expected = []
        for scenario, rows in mine.groupby("scenario"):
            p, stable = shares[scenario], rows["truth"] == 1.0
            expected.append(
                p * rows[stable]["right"].mean() + (1 - p) * rows[~stable]["right"].mean()
            )
        assert summary.natural.value == pytest.approx(np.mean(expected))
        assert summary.natural.low <= summary.natural.value <= summary.natural.high


def test_what_is_naturally_frequent_needs_no_weights():
    """On cases that are stable as often as the set, it is the mean of the scenarios' accuracies."""
    index = pd.MultiIndex.from_product([["S1", "S2b"], range(10)], names=["scenario", "layout"])
    steps = ([None] * 7 + [1] * 3) + ([None] * 4 + [1] * 6)
    labels = pd.DataFrame(
        {"failing_step": steps, "instance": [*"aabbccddee"] * 2, "item_class": "1"}, index=index
    )
    right = np.random.default_rng(3).random(20) < 0.6
    found = at_natural_prevalence(right, labels, {"S1": 0.7, "S2b": 0.4})
    assert found.value == pytest.approx(right.mean())
    # Nothing is known of unstable cases here, unless none occur naturally.
    stable, known = labels[:7], right[:7]
    assert math.isnan(at_natural_prevalence(known, stable, {"S1": 0.7}).value)
    assert at_natural_prevalence(known, stable, {"S1": 1.0}).value == pytest.approx(known.mean())


def test_intervals_stand_on_item_lists(run, labelled_set):
    both = counted(run, labelled_set)
    for summary in evaluate(run).methods:
        mine = both[both["method"] == summary.method.spec]
        assert summary.score == mean(mine["score"], mine["instance"])
        assert summary.fully_stable == share(mine["score"] == 1.0, mine["instance"])
    # Not the same as by layout: the test could not tell otherwise.
    assert summary.score != mean(mine["score"], mine["layout"])


def test_a_missing_verdict_is_wrong_and_reported_apart(study, tmp_path, monkeypatch):
    method = type(make_method("sme"))
    monkeypatch.setattr(method, "_judge", lambda *_: 1 / 0)
    run_study(dataclasses.replace(study, methods=("sme", "fbs")), tmp_path / "run")
    comparison = compare(tmp_path / "run")
    sme = comparison.rows.loc["sme"]
    shown = ("right", "over", "under", "stable_or_not", "within_one")
    assert [sme[name].value for name in shown] == [0.0] * 5
    assert sme["lost"] == {"error": 48}
    assert (
        "48 error"
        in write_page(RunReport(directory=tmp_path).page(comparison), tmp_path).read_text()
    )


def test_the_page_leads_with_accuracy_and_needs_no_labelled_set(run, study, labelled_set, tmp_path):
    mine = shutil.copytree(run, tmp_path / "run")
    away = shutil.copytree(labelled_set, tmp_path / "set")
    run_study(dataclasses.replace(study, benchmark_directory=away), mine)
    shutil.rmtree(away)
    comparison = compare(mine)
    text = write_page(RunReport(directory=tmp_path).page(comparison), tmp_path / "page").read_text()
    headings = re.findall("^## (.*)", text, re.MULTILINE)
    assert headings[0] == "Accuracy and cost"
    assert "There are no reference labels" not in text
    assert "| Equilibrium (time=0.3) " in text
    [beside] = (tmp_path / "page").glob("report-details.*.md")
    details = beside.read_text()
    assert "*Accuracy*: the share of cases" in details
    assert details.count("natural prevalence %") == 1 + 3
    assert list((tmp_path / "page" / "figures").glob("accuracy.*.svg"))
    lines = [line for line in text.splitlines() if line.startswith("| Equilibrium (time=0.3)")]
    assert " 100.0 [" in lines[0]


def test_disagreements_show_stored_centres_of_mass_and_the_label(run, labelled_set):
    benchmark, labels = load_benchmark(labelled_set), load_labels(run)
    found = compare(run)
    shown = found.disagreements
    assert set(shown["scenario"]) > {"S1"}
    for case, own in zip(found.drawn, shown.to_dict("records"), strict=False):
        layout = benchmark.layout(case.layout, case.scenario)
        centres = 0.5 * (layout.lower + layout.upper) + layout.mass_offsets
        drawn = 0.5 * (case.drawn.lower + case.drawn.upper) + case.drawn.mass_offsets
        np.testing.assert_array_equal(drawn, centres)
        step = labels.loc[(case.layout, case.scenario), "failing_step"]
        assert own["said_of:label"] == ("stable" if pd.isna(step) else str(step))


def test_a_folder_without_its_labels_says_so(run, tmp_path):
    mine = shutil.copytree(run, tmp_path / "run")
    frame = pd.read_parquet(mine / "labels.parquet")
    (mine / "labels.parquet").write_bytes(b"x")
    with pytest.raises(ResultsError, match=r"labels\.parquet: cannot be read"):
        compare(mine)
    (mine / "labels.parquet").unlink()
    with pytest.raises(ResultsError, match=r"labels\.parquet: is missing; run the study again"):
        compare(mine)
    content, manifest = as_labels(frame[1:]), load_manifest(mine)
    (mine / "labels.parquet").write_bytes(content)
    manifest["files"]["labels.parquet"] = checksum(content)
    (mine / "manifest.json").write_text(manifest_text(manifest))
    with pytest.raises(ResultsError, match="has no label in scenario 'S1'"):
        compare(mine)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('benchmark = "tset"', "benchmark is 'tset'; did you mean 'test'?"),
        ("benchmark = 3", "benchmark is 3; allowed: all"),
        ('benchmark = "test"\nmax_items = 5', "max_items cannot stand beside benchmark: labels"),
        ('benchmark = "test"\ngenerated = 5', "generated cannot stand beside benchmark"),
        ('benchmark = "test"\nsnap_gap = 0.1', "snap_gap cannot stand beside benchmark"),
        ('benchmark = "test"\nseed = 3', "seed cannot stand beside benchmark"),
        ('benchmark = "test"\nlayouts = ["s.toml"]', "layouts cannot stand beside benchmark"),
        ('benchmark_directory = "x"', "benchmark_directory needs a part"),
        (
            'benchmark = "test"\nbenchmark_directory = 3',
            "benchmark_directory is 3; allowed: a text",
        ),
    ],
)
def test_what_cannot_stand_beside_a_labelled_set_is_refused(tmp_path, text, message):
    (tmp_path / "s.toml").write_text(f'{text}\nmethods = ["sme"]\n')
    with pytest.raises(StudyError) as caught:
        load_study(tmp_path / "s.toml")
    assert message in str(caught.value)
    assert str(tmp_path / "s.toml") in str(caught.value)


def test_a_folder_that_is_no_labelled_set_is_one_sentence(tmp_path, capsys):
    (tmp_path / "s.toml").write_text(
        'benchmark = "test"\nbenchmark_directory = "nowhere"\nmethods = ["sme"]\n'
    )
    with pytest.raises(BenchmarkError):
        run_study(load_study(tmp_path / "s.toml"), tmp_path / "run")
    assert main(["study", "run", str(tmp_path / "s.toml"), "-o", str(tmp_path / "run")]) == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    (sentence,) = printed.err.splitlines()
    assert sentence.endswith("nowhere: no manifest.json; is it a labelled set?")
    assert not (tmp_path / "run").exists()


def test_the_embedded_study_runs_on_the_shipped_set(tmp_path):
    study = load_study("embedded")
    assert (study.benchmark, study.benchmark_directory) == ("test-300", None)
    if not (SHIPPED / "manifest.json").exists():
        pytest.skip(f"the labelled set is not in {SHIPPED}")
    quick = dataclasses.replace(study, methods=("fbs", "sme"), limit=4)
    assert run_study(quick, tmp_path / "run") == 2 * 3 * 4
    assert evaluate(tmp_path / "run").labelled.stable == 6


def test_a_row_is_compared_with_another_on_the_same_cases(run, labelled_set):
    evaluation, both = evaluate(run), counted(run, labelled_set)
    assert evaluation.cost_source.kind == CostKind.JUDGING
    sme = evaluation.row("sme", "S2b", against="fbs", key=MethodKey("mine", "mine", "mine"))
    here = both[both["scenario"] == "S2b"].set_index(["method", "layout"]).sort_index()
    right = (here["score"] - here["truth"]).abs() < 1e-9
    assert sme.ahead.value == pytest.approx(right["fbs"].mean() - right["sme"].mean())
    cpu = load_results(run).query("scenario == 'S2b'").groupby("method")["cpu_total"].sum()
    assert sme.cost_ratio.value == pytest.approx(cpu["fbs"] / cpu["sme"])
    assert (sme.method.title, sme.accuracy) == ("mine", evaluation.row("sme", "S2b").accuracy)
    own = evaluation.row("sme", against="sme")
    assert (own.ahead, own.cost_ratio) == (None, None)


def test_costs_are_those_of_the_timing_pass_where_there_was_one(run):
    judged = load_judged(run)
    few = judged.said.index[judged.said.index.get_level_values("scenario") != "S2a"][:10]
    cpu = {"sme": np.array([np.arange(10.0), np.full(10, 9.0), np.full(10, 4.0)])}
    times = Times(cpu, {"sme": 2.0 * cpu["sme"]}, 3.0)
    plain, timed = evaluate(judged), evaluate(judged, costs=timed_costs(times, few))
    sme = timed.row("sme")
    assert (sme.cpu.n, sme.cpu.value) == (10, np.median(cpu["sme"], axis=0).mean())
    assert sme.wall.value == 2.0 * sme.cpu.value
    assert sme.phases is None
    assert sme.accuracy == plain.row("sme").accuracy
    # What was not timed has no costs, and no scenario borrows those of another.
    assert (timed.row("fbs").cpu.n, timed.row("sme", "S2a").cpu.n) == (0, 0)
    assert timed.cost_ratio("fbs", "sme").n == 0
    told = timed.cost_source.explained()
    assert "the timing pass, on 10 of the cases" in told
    assert "3.0 processes wanted to run" in told
    assert "The machine was busy" in told
    assert plain.row("fbs").phases.other == pytest.approx(plain.row("fbs").cpu.value)


def test_runs_side_by_side_are_as_one_run_of_all_methods(run, study, tmp_path):
    first, second = METHODS[:2], METHODS[2:]
    for name, methods in (("first", first), ("second", second)):
        limit = 16 if name == "first" else 10
        run_study(replace(study, methods=methods, limit=limit), tmp_path / name)
    found = load_judged(tmp_path / "first").beside(load_judged(tmp_path / "second"))
    whole = load_judged(run)
    cases = whole.said.index.isin(load_judged(tmp_path / "second").said.index)
    expected = whole.only(cases)
    assert len(found.said) == 30
    pd.testing.assert_frame_equal(found.said, expected.said.loc[found.said.index])
    pd.testing.assert_frame_equal(found.labels, expected.labels.loc[found.said.index])
    assert list(found.keys) == list(METHODS)
    assert found.rows == 2 * 48 + 2 * 30


def test_runs_on_other_layouts_are_not_put_side_by_side(run, study, tmp_path):
    run_study(replace(study, methods=("pbs0.5",)), tmp_path / "other")
    other = load_judged(tmp_path / "other")
    changed = other.results.assign(layout_hash=other.results["layout_hash"].str[::-1])
    with pytest.raises(ResultsError, match="48 cases of the same names; required: one or more"):
        load_judged(run).beside(replace(other, results=changed))

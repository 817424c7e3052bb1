"""Table 5: every method on the same cases, judged once, timed apart, and told with its n."""

import dataclasses
import re
import sys
import types
from itertools import combinations

import numpy as np
import pandas as pd
import pytest

from steadyload.app.recommend.folder import measured_in
from steadyload.app.recommend.kept import SPATIAL
from steadyload.cli import main
from steadyload.layouts.benchmark import load_benchmark
from steadyload.layouts.model.question import Question
from steadyload.methods import registry
from steadyload.methods.contract.method import RefusedError, judge
from steadyload.methods.contract.spec import parse_spec
from steadyload.methods.naming import method_key
from steadyload.methods.registry import make_method
from steadyload.methods.rules.base_support import FullBaseSupport
from steadyload.runs import frames
from steadyload.runs.able import asked_question
from steadyload.runs.comparison import Compared
from steadyload.runs.definition import StudyDefinition
from steadyload.runs.evaluation import ALL
from steadyload.runs.labels import load_labels
from steadyload.runs.paper import paper
from steadyload.runs.runner import run_study
from steadyload.statistics.metrics import mean
from steadyload.statistics.paired import detectable, holm
from steadyload.studies.evaluation import judging, methods
from steadyload.studies.evaluation.comparing import compare, unlike_the_paper
from steadyload.studies.evaluation.judging import Options, judged_and_timed, tunings
from steadyload.studies.evaluation.methods import same_order
from steadyload.studies.evaluation.study import Evaluation
from steadyload.studies.kit import Lab

SPECS = ("fbs", "sme", "equilibrium")
FEW = ("--limit", "3", "-j", "1")
pytestmark = pytest.mark.usefixtures("file_in_this_process")
ASKED = ("study", "evaluation", *(word for spec in SPECS for word in ("-m", spec)), *FEW)


@pytest.fixture(scope="module")
def written(tmp_path_factory, file_in_this_process):
    """The folder of a page, and of what it was made from."""
    folder = tmp_path_factory.mktemp("evaluation")
    assert main([*ASKED, "--work", str(folder / "work"), "-o", str(folder / "page")]) == 0
    return folder


def rows(text, heading):
    """Cells of the first table below a heading, header first."""
    table = re.search(r"(?:^\|.*\n)+", text[text.index(heading) :], re.MULTILINE)
    header, _, *lines = table[0].splitlines()
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in (header, *lines)]


def test_accuracies_are_those_of_the_methods_on_the_labels(written):
    text = (written / "page" / "report.md").read_text()
    benchmark = load_benchmark()
    chosen = benchmark.select("test", limit=3)
    assert f"item lists; {chosen['failing_step'].isna().sum()} are stable, on which" in text
    header, *lines = rows(text, "## Accuracy and cost")
    told = {line[0]: dict(zip(header, line, strict=True)) for line in lines}
    for spec, title in zip(SPECS, ("FBS", "SME", "Equilibrium"), strict=True):
        method, right = make_method(spec), 0
        for name, scenario, label in zip(
            chosen["layout"], chosen["scenario"], chosen["failing_step"], strict=True
        ):
            said = method.judge(benchmark.layout(name, scenario)).failing_step
            right += said == (None if pd.isna(label) else label)
        assert told[title]["n"] == "9"
        assert told[title]["accuracy %"].startswith(f"{100 * right / 9:.1f} [")


def details(folder):
    [file] = folder.glob("report-details.*.md")
    return file.read_text()


def test_errors_cost_what_verdicts_and_labels_say(written, assert_drawn):
    text = details(written / "page")
    benchmark = load_benchmark()
    chosen = benchmark.select("test", limit=3)
    lines = {}
    for spec, title in zip(SPECS, ("FBS", "SME", "Equilibrium"), strict=True):
        method, over, under = make_method(spec), 0, 0
        for name, scenario, label in zip(
            chosen["layout"], chosen["scenario"], chosen["failing_step"], strict=True
        ):
            layout = benchmark.layout(name, scenario)
            said = method.judge(layout).failing_step
            placed = [len(layout) if k is None or pd.isna(k) else k for k in (said, label)]
            over, under = over + (placed[0] > placed[1]), under + (placed[0] < placed[1])
        lines[title] = (over / 9, under / 9)
    assert len(set(lines.values())) > 1
    part = text[text.index("## What errors cost") :]
    header, *told = rows(part, "Methods on the front of")
    for line in told:
        over, under = lines[line[0]]
        for name, cell in zip(header, line, strict=True):
            if name.startswith("cost at "):
                cost = float(name.removeprefix("cost at ")) * over + under
                assert float(cell.split()[0]) == pytest.approx(cost, rel=0.051, abs=1e-9)
    _, *ranges = rows(part, "The cheapest of all methods, by ratio:")
    assert [ranges[0][0], ranges[-1][1]] == ["0.010", "100"]
    for least, most, title, *_ in ranges:
        middle = (float(least) * float(most)) ** 0.5
        best = min(middle * over + under for over, under in lines.values())
        assert middle * lines[title][0] + lines[title][1] == pytest.approx(best)
        assert title in {line[0] for line in told}
    [figure] = (written / "page" / "figures").glob("error_costs.*")
    assert_drawn(figure)


def test_times_are_told_as_multiples_of_those_of_sme(written):
    text = (written / "page" / "report.md").read_text()
    header, *lines = rows(text, "## Time a layout")
    told = {line[0]: dict(zip(header, line, strict=True)) for line in lines}
    unit = float(told["SME"]["CPU ms"].split()[0])
    assert told["SME"]["times SME"] == "1.0 [1.0, 1.0]"
    for line in told.values():
        multiple, cpu = (float(line[name].split()[0]) for name in ("times SME", "CPU ms"))
        assert multiple == pytest.approx(cpu / unit, rel=0.06)
        assert float(line["median CPU ms"]) <= float(line["90 % CPU ms"])


def test_body_substeps_are_the_mean_over_cases_of_one_judgement_each():
    steps = {"ps3@mujoco": (100, 300, 500), "fbs": (0, 0, 0)}
    frame = pd.DataFrame(
        [
            {"layout": name, "scenario": "S1", "method": spec, "key": None, "title": spec,
             "body_substeps": step, "status": "done", "cluster": name, "items": 2, "expected": 2,
             "cpu": 1.0, "wall": 1.0, "yardstick": 1.0, "unit": 1.0, "gave_labels": False,
             "brief": True, "long": True, **dict.fromkeys(methods._SHARES, True)}
            for spec, own in steps.items()
            for name, step in zip("abc", own, strict=True)
        ]
    ).assign(key=lambda d: [method_key(make_method(spec)) for spec in d["method"]])  # fmt: skip
    found = methods.every_method(frame, {})["body_substeps"]
    assert found["ps3@mujoco"].value == 300.0
    assert pd.isna(found["fbs"])


def test_all_tables_say_how_many(written):
    text = (written / "page" / "report.md").read_text() + details(written / "page")
    headers = re.findall(r"^\| .*(?=\n\| -)", text, re.MULTILINE)
    assert len(headers) > 8
    for header in headers:
        cells = [cell.strip() for cell in header.strip("|").split("|")]
        # Where a row is a layout, the row is what is counted.
        assert {"n", "cases"} & {*cells} or "(n " in header or cells[0] == "layout"


def test_a_case_to_watch_divides_the_methods_that_it_names(written):
    text = details(written / "page")
    header, *lines = rows(text, "## Cases to watch")
    assert lines
    for line in lines:
        told = dict(zip(header, line, strict=True))
        wrong, step = told["wrong"].rsplit(": ", 1)
        assert step != told["label"]
        assert {told["right"], wrong} <= {"FBS", "SME", "Equilibrium"}
        assert told["right"] != wrong
        assert f"--layout {told['layout']}_{told['scenario']} -m " in text


def test_a_method_is_recommended_by_the_times_of_the_timing_pass(written):
    text = (written / "page" / "report.md").read_text()
    header, *lines = rows(text, "## Accuracy and cost")
    told = {line[0]: dict(zip(header, line, strict=True)) for line in lines}
    [front] = measured_in(written / "work")
    assert [m.title for m in front.measured] == ["FBS", "SME", "Equilibrium"]
    for entry in front.measured:
        shown = told[entry.title]
        assert shown["accuracy %"].startswith(f"{100 * entry.accuracy.value:.1f} [")
        cpu = next(cell for name, cell in shown.items() if name.startswith("CPU"))
        assert float(cpu.split()[0]) == pytest.approx(entry.cpu.value, rel=0.01)
    assert (front.part, front.cases, front.question) == ("test", 9, "within")
    assert front.times.startswith("mean of 9 cases, one thread")


def test_an_interrupted_run_goes_on_to_the_same_page(written, undrawn, undrawn_text):
    again = [*ASKED, "--work", str(written / "work"), "-o", str(written / "again")]
    (written / "again").mkdir()
    shards = sorted((written / "work").rglob("results/*.parquet"))
    shards[0].unlink()
    assert main(again) == 0
    pages = [
        (undrawn_text(text.partition("## Made with")[0]), undrawn_text(details(written / name)))
        for name in ("page", "again")
        for text in [(written / name / "report.md").read_text()]
    ]
    assert pages[1] == pages[0]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("-m", "ps3@chipmunk"), "none judges layouts in space"),
        (("-m", "smee"), "did you mean 'sme'"),
        (("-m", "cascade@dart"), "cascade@dart"),
    ],
)
def test_a_method_that_cannot_judge_is_an_error_where_it_is_named(
    capsys, tmp_path, arguments, message
):
    assert main(["study", "evaluation", *arguments, *FEW, "--work", str(tmp_path / "work")]) == 2
    assert message in capsys.readouterr().err
    assert not (tmp_path / "work").exists()


def test_the_folder_of_another_study_is_left_alone(capsys, tmp_path):
    run_study(StudyDefinition("mine", ("fbs",), generated=1), tmp_path)
    before = sorted(tmp_path.iterdir())
    assert main([*ASKED, "--work", str(tmp_path)]) == 2
    assert "holds the study 'mine'; choose another folder" in capsys.readouterr().err
    assert sorted(tmp_path.iterdir()) == before


def test_a_method_that_cannot_judge_is_left_out_where_nobody_named_it(monkeypatch):
    monkeypatch.setattr(judging, "standard_methods", lambda: ("sme", "cascade@dart"))
    asked = Options()
    assert asked.spatial == ("sme",)
    assert "steadyload cascade fit --engine dart" in asked.left_out["cascade@dart"]


class Choosy(FullBaseSupport):
    """FBS that refuses layouts by name, in this process."""

    refuses: tuple[str, ...] = ()

    def _judge(self, layout, watch):
        if layout.name in self.refuses:
            raise RefusedError("not this one")
        return super()._judge(layout, watch)


@pytest.fixture
def choosy(monkeypatch):
    monkeypatch.setitem(sys.modules, "choosy_judge", types.SimpleNamespace(Choosy=Choosy))
    monkeypatch.setitem(registry.METHODS, "choosy", "choosy_judge:Choosy")
    return Choosy


@pytest.mark.parametrize(("refused", "timed"), [(1, True), (2, False)])
def test_a_few_refused_cases_cost_no_method_its_times(
    choosy, monkeypatch, tmp_path, refused, timed
):
    names = [*dict.fromkeys(load_benchmark().select("test", limit=4)["layout"])]
    assert len(names) == 12  # a layout a case
    monkeypatch.setattr(choosy, "refuses", tuple(names[:refused]))
    asked = Options(methods=("fbs", "choosy"), limit=4)
    spatial = judged_and_timed(Lab(tmp_path, 0), asked)[SPATIAL].timed
    timing = compare(Lab(tmp_path, 0), asked).sets[0]["timing"]
    assert {len(found[0]) for found in spatial.times.cpu.values()} == {len(spatial.cases)}
    assert timing["layouts"] == len(spatial.cases)
    if timed:
        assert list(spatial.times.cpu) == ["fbs", "choosy"]
        assert {name for name, _ in spatial.cases} == set(names[1:])
        assert (timing["untimed"], timing["refused"]) == ({}, {"choosy": 1})
    else:
        assert list(spatial.times.cpu) == ["fbs"]
        assert {name for name, _ in spatial.cases} == set(names)
        assert timing["untimed"] == {"choosy": "of 12 cases to be timed 2 refused"}


def test_a_page_whose_methods_all_refuse_says_that_nothing_was_timed(choosy, monkeypatch, tmp_path):
    names = load_benchmark().select("test", limit=2)["layout"]
    monkeypatch.setattr(choosy, "refuses", tuple(names))
    asked = Options(methods=("choosy",), limit=2)
    found = compare(Lab(tmp_path, 0), asked)
    assert found.sets[0]["timing"]["untimed"] == {"choosy": "of 6 cases to be timed 6 refused"}
    page = Evaluation(methods=asked.methods).page(found)
    [text] = [part.placed[0] for part in page.sections if part.title == "Time a layout"]
    assert "choosy was not timed: of 6 cases to be timed 6 refused" in text


def test_the_table_is_made_on_another_set(tmp_path):
    """Its 3-D methods judge the named set, and the page and its commands say so."""
    lists = load_benchmark("lists").select("test", limit=2)
    words = ["study", "evaluation", "-m", "fbs", "-m", "sme", "--directory", "lists"]
    words += ["--limit", "2", "-j", "1", "--work", str(tmp_path / "work")]
    assert main([*words, "-o", str(tmp_path / "page")]) == 0
    judged = load_labels(tmp_path / "work" / SPATIAL)
    assert judged.index.tolist() == list(zip(lists["layout"], lists["scenario"], strict=True))
    text = (tmp_path / "page" / "report.md").read_text()
    assert "2 methods on 6 cases of part `lists test` of the labelled set" in text


def test_one_run_answers_both_questions(tmp_path, monkeypatch):
    """The second page judges and times nothing anew; it has other labels and other methods."""
    usual = ("sme", "lstm_1", "lstm_1:question=stands")
    monkeypatch.setattr(judging, "standard_methods", lambda: usual)
    monkeypatch.setattr(judging, "TIMED", 1)
    words = ["study", "evaluation", "--directory", "lists", "--limit", "60", "-j", "1"]
    words += ["--work", str(tmp_path / "work")]
    assert main([*words, "-o", str(tmp_path / "within")]) == 0
    kept = {path: path.stat().st_mtime_ns for path in (tmp_path / "work").rglob("*-*.*")}
    assert main([*words, "--question", "stands", "-o", str(tmp_path / "stands")]) == 0
    assert {path: path.stat().st_mtime_ns for path in (tmp_path / "work").rglob("*-*.*")} == kept
    benchmark = load_benchmark("lists")
    shown = {"within": ("lstm_1", "LSTM_1"), "stands": (usual[2], "LSTM_1 (question=stands)")}
    for question, (spec, title) in shown.items():
        text = (tmp_path / question / "report.md").read_text()
        header, *lines = rows(text, "## Accuracy and cost")
        assert [line[0] for line in lines] == ["SME", title]
        assert ("paper %" in header) == (question == "within")
        assert ("natural prevalence %" in details(tmp_path / question)) == (question == "within")
        chosen = benchmark.select("test", limit=60, question=Question(question))
        method = make_method(spec)
        said = [
            judge(method, benchmark.layout(name, scenario))
            for name, scenario in zip(chosen["layout"], chosen["scenario"], strict=True)
        ]
        right = [
            one.status == "done" and one.failing_step == (None if pd.isna(label) else label)
            for one, label in zip(said, chosen["failing_step"], strict=True)
        ]
        told = dict(zip(header, lines[1], strict=True))
        assert told["n"] == str(len(chosen))
        assert told["accuracy %"].startswith(f"{100 * np.mean(right):.1f} [")
    fronts = measured_in(tmp_path / "work")
    assert {front.question: [m.method for m in front.measured] for front in fronts} == {
        "within": ["sme", "lstm_1"],
        "stands": ["sme", "lstm_1:question=stands"],
    }


@pytest.mark.engine("bullet")
def test_methods_made_for_both_questions_are_judged_and_shown_once_a_question():
    judged = {question: Options(questions=(question,)) for question in Question}
    one, other = (asked.spatial for asked in judged.values())
    assert one == other
    for question, asked in judged.items():
        for spec in asked.shown(question):
            name = parse_spec(spec).name
            if name in {"ps_opt", "lstm_1", "lstm_e", "cascade", "label"}:
                assert asked_question(spec) is question
    within, stands = ({s.partition(":question")[0] for s in a.shown(q)} for q, a in judged.items())
    assert within == stands
    assert {"ps_opt@dart", "label@mujoco", "lstm_e", "ps3@bullet"} <= within


SIMULATED = ("ps3@bullet", "ps3@mujoco", "ps_opt@bullet", "ps_opt@mujoco", "cascade@mujoco", "sme")


def test_one_tuning_is_the_same_parameters_and_no_other_name_for_a_search(stated):
    found = tunings(SIMULATED)
    assert list(found) == list(SIMULATED[:4])  # a cascade has an engine, and is no simulation
    for one, other in combinations(found, 2):
        same = {key: stated(one)[key] == stated(other)[key] for key in stated(one)}
        assert (found[one] == found[other]) == all(same.values())


@pytest.fixture
def stated():
    """By spec, what the steps of all engines are told."""
    names = ("t_max", "frequency", "eps_t", "eps_r", "friction", "restitution", "margin")
    return lambda spec: {name: getattr(make_method(spec).parameters, name) for name in names}


def keys_of(*specs):
    return [method_key(make_method(spec)) for spec in specs]


def test_a_page_says_which_rows_are_not_the_papers_own():
    networks = ((80, 154, 700), False)
    assert unlike_the_paper(keys_of("lstm_1")) == networks
    assert unlike_the_paper(keys_of("lstm_e-paper")) == networks
    assert unlike_the_paper(keys_of("ps5@bullet")) == (None, True)
    assert unlike_the_paper(keys_of("lstm_e", "ps3@mujoco")) == (networks[0], True)
    assert unlike_the_paper(keys_of("sme", "ps3-literal@bullet", "ps_opt@bullet")) == (None, False)


def verdicts_of(right, specs=SIMULATED):
    """A frame of verdicts by whether methods are right, a layout a case."""
    return pd.DataFrame(
        [
            {"layout": f"l{k}", "scenario": "S1", "method": spec, "cluster": k, "right": own}
            for spec in specs
            for k, own in enumerate(right[spec])
        ]
    )


def test_what_each_engine_was_tuned_for_is_not_told_as_what_the_engine_changes():
    keys = {spec: method_key(make_method(spec)) for spec in SIMULATED}
    tests = frames.pairs(verdicts_of(dict.fromkeys(SIMULATED, np.arange(8) % 3 == 0)))
    found = methods.engines_and_tunings(tests, keys)
    assert list(found["one_tuning"].index) == [("ps3@bullet", "ps3@mujoco")]
    assert list(found["one_engine"].index) == [
        ("ps3@bullet", "ps_opt@bullet"), ("ps3@mujoco", "ps_opt@mujoco"),
    ]  # fmt: skip


def test_the_page_compares_every_method_with_the_best_alone():
    random = np.random.default_rng(1)
    right = {s: random.random(40) < 0.95 - 0.08 * n for n, s in enumerate(SIMULATED)}
    tests = frames.pairs(verdicts_of(right))
    keys = {spec: method_key(make_method(spec)) for spec in SIMULATED}
    best = max(right, key=lambda spec: right[spec].mean())
    family = Compared({s: own.astype(float) for s, own in right.items()}, np.arange(40))
    mine = family.versus(best).tests
    rows = pd.DataFrame({"title": [keys[s].title for s in SIMULATED]}, list(SIMULATED))
    alike = methods.alike(frames.versus(tests, best), dict(rows["title"]))
    assert alike["titles"] == [keys[t.first].title for t in mine if not t.significant]
    assert 0 < len(alike["titles"]) < alike["others"] == len(mine) == 5
    shown = [detectable(t.difference, 40, 5) for t in mine if not t.significant]
    assert alike["shown"] == sorted({min(shown), max(shown)})
    against = methods.against({ALL: tests}, rows, best)
    assert list(against["corrected"]) == [t.corrected for t in mine]
    found = methods.engines_and_tunings(tests, keys)["one_tuning"]
    assert list(found["corrected"]) == holm(list(found["p"]))


def test_a_pair_that_is_equal_in_the_paper_is_no_order_to_be_kept():
    printed = paper()
    accuracy = {row.title: row.accuracy[ALL] for row in printed.rows}
    assert accuracy["SME"] == accuracy["LSTM_e"] > accuracy["FBS"]
    few = dataclasses.replace(
        printed,
        rows=tuple(
            dataclasses.replace(row, families=row.families or row.namesakes)
            for row in printed.rows
            if row.title in ("FBS", "SME", "LSTM_e")
        ),
    )

    assert same_order(few, accuracies({"fbs": 0.5, "sme": 0.8, "lstm_e-paper": 0.9})) == (2, 2)
    assert same_order(few, accuracies({"fbs": 0.5, "sme": 0.8, "lstm_e-paper": 0.5})) == (1, 2)


def accuracies(of):
    """Rows of methods of which the accuracy alone is looked at."""
    keys = [method_key(make_method(spec)) for spec in of]
    return pd.DataFrame({"key": keys, "right": [mean([own]) for own in of.values()]}, [*of])


def test_only_like_is_compared_with_like():
    """Our PS_3 converted to SI and our networks share a name with the paper's, and no more."""
    printed = paper()
    same = {"ps3-literal@bullet": "PS_3", "ps_opt-paper@mujoco": "PS_opt", "sme": "SME"}
    for spec, title in same.items():
        key = method_key(make_method(spec))
        assert printed.like(key).title == printed.row_of(key).title == title
    other = {"ps3@bullet": "PS_3", "ps_opt@mujoco": "PS_opt", "lstm_e": "LSTM_e"}
    for spec, title in other.items():
        key = method_key(make_method(spec))
        assert printed.like(key) is None
        assert printed.row_of(key).title == title

    # Better than SME by the converted numbers, worse in the reading that the paper prints.
    ours = {"sme": 0.8, "ps3@bullet": 0.9, "ps3-literal@bullet": 0.7}
    assert same_order(printed, accuracies(ours)) == (1, 1)
    assert same_order(printed, accuracies({k: ours[k] for k in ("sme", "ps3@bullet")})) == (0, 0)


def of_heuristics(right, names):
    """Standard errors of a method on cases of layouts with these names."""
    frame = pd.DataFrame({
        "layout": names, "scenario": "S1", "method": "sme", "right": right,
        "cluster": [name.partition("_")[2] for name in names],
    })  # fmt: skip
    rows = pd.DataFrame({"title": ["SME"], "right": [mean(right)]}, ["sme"])
    return methods.crossed(frame, rows, ["sme"])


def test_a_method_that_errs_with_a_heuristic_errs_so_on_other_lists():
    names = [f"H{h}_Class_1_Instance_{k}_ULD_0" for h in range(1, 9) for k in range(30)]
    by_heuristic = [name.startswith(("H1_", "H2_")) for name in names]
    row = of_heuristics(by_heuristic, names).iloc[0]
    assert row.by_list == pytest.approx(0.0)
    assert row.by_both == pytest.approx(100.0 * (0.25 * 0.75 * (1 / 8 - 1 / 240)) ** 0.5)
    by_list = [k % 3 == 0 for _ in range(8) for k in range(30)]
    row = of_heuristics(by_list, names).iloc[0]
    assert row.by_list == pytest.approx(100.0 * (2 / 9 / 30) ** 0.5)
    assert row.ratio == pytest.approx(1.0)
    assert of_heuristics(by_list, [*names[:-1], "BR6-1 packvium 1"]).empty

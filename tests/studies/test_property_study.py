"""The search, its files, findings, and the page."""

import dataclasses
import json
import re
import statistics
import sys
import types

import pytest

from steadyload.cli import main
from steadyload.engines.registry import ENGINES, EngineEntry, world_class
from steadyload.layouts.formats import read_layouts
from steadyload.methods.contract.method import RefusedError
from steadyload.methods.registry import METHODS
from steadyload.methods.rules.base_support import FullBaseSupport
from steadyload.properties import PropertyError, findings, registry
from steadyload.properties.findings import KnownFinding
from steadyload.properties.property import Case, MethodUnderTest, Property, Violation
from steadyload.properties.registry import PROPERTIES, chosen
from steadyload.properties.search import search
from steadyload.properties.strategies import layouts
from steadyload.reports.pages.page import Page
from steadyload.reports.pages.writing import write_page
from steadyload.runs.definition import load_study
from steadyload.runs.pool import IN_THIS_PROCESS
from steadyload.runs.runner import run_study
from steadyload.runs.store import Store
from steadyload.studies.kit import Lab
from steadyload.studies.properties.outcomes import Standing
from steadyload.studies.properties.study import Properties
from steadyload.studies.properties.testing import (
    OUTCOMES,
    PropertyStudy,
    methods_on,
    run_properties,
)
from steadyload.studies.report.comparing import compare
from steadyload.studies.report.study import RunReport
from steadyload.studies.study import silent

pytestmark = pytest.mark.usefixtures("file_in_this_process")


def run(asked, work, progress=silent):
    return run_properties(Lab(work, IN_THIS_PROCESS, progress), asked)


def written(found, folder):
    """The text of the page."""
    study = Properties()
    study.beside(found, folder)
    return write_page(study.page(found), folder).read_text()


def below_three(tested, case):
    if len(case.layout) >= 3:
        raise Violation(f"{len(case.layout)} items")
    return len(case.layout) == 2


FEW_ITEMS = Property(
    "few items", "Layouts have fewer than three items.", lambda _: layouts().map(Case), below_three
)


@pytest.fixture
def few_items(monkeypatch):
    monkeypatch.setitem(registry.PROPERTIES, FEW_ITEMS.name, FEW_ITEMS)


def test_a_violation_is_made_as_small_as_it_gets():
    outcome = search(FEW_ITEMS, MethodUnderTest("fbs"), examples=200, seed=1)
    assert outcome.counterexample.found == "3 items"
    layout = outcome.counterexample.case.layout
    assert len(layout) == 3
    assert (layout.upper - layout.lower).max() <= 4.0
    assert outcome.asked <= outcome.examples <= 200


def test_the_same_seed_draws_the_same_cases():
    def drawn(seed):
        seen = []

        def look(tested, case):
            seen.append(case.layout.content_hash())
            return True

        asked = Property("look", "", lambda _: layouts().map(Case), look)
        search(asked, MethodUnderTest("fbs"), examples=30, seed=seed)
        return seen

    assert drawn(1) == drawn(1)
    assert drawn(1) != drawn(2)


class Fails(FullBaseSupport):
    """Cannot judge."""

    def _judge(self, layout, watch):
        raise ZeroDivisionError("too few")


class RefusesMany(FullBaseSupport):
    """Judges one item or two."""

    def _judge(self, layout, watch):
        if len(layout) > 2:
            raise RefusedError("more than two items")
        return super()._judge(layout, watch)


class RefusesAll(FullBaseSupport):
    """Judges nothing."""

    def _judge(self, layout, watch):
        raise RefusedError("items")


class Halts(world_class("mujoco")):
    """Cannot go on."""

    def _advance(self, substeps, length):
        raise RuntimeError("stuck")


@pytest.fixture
def planted(monkeypatch):
    """Registers a method of a class."""

    def plant(judge):
        monkeypatch.setitem(sys.modules, "planted", types.SimpleNamespace(Judge=judge))
        monkeypatch.setitem(METHODS, "planted", "planted:Judge")
        return "planted"

    return plant


def test_an_exception_of_the_method_is_a_violation(planted):
    tested = MethodUnderTest(planted(Fails))
    outcome = search(PROPERTIES["score"], tested, examples=5, seed=1)
    assert outcome.counterexample.found == "ZeroDivisionError: too few"


@pytest.mark.parametrize("name", ["free fall", "balanced stays"])
def test_an_exception_of_the_engine_is_a_violation(name, monkeypatch):
    monkeypatch.setitem(sys.modules, "planted", types.SimpleNamespace(World=Halts))
    monkeypatch.setitem(ENGINES, "planted", EngineEntry("planted:World", ()))
    outcome = search(PROPERTIES[name], MethodUnderTest("label@planted"), examples=5, seed=1)
    assert outcome.counterexample.found == "RuntimeError: stuck"


def test_an_exception_of_the_property_is_no_violation():
    def fail(tested, case):
        return tested.verdict(case.layout).scor

    asked = Property("x", "", lambda _: layouts().map(Case), fail)
    with pytest.raises(AttributeError, match="scor"):
        search(asked, MethodUnderTest("fbs"), examples=5, seed=1)


def test_what_a_method_refuses_is_not_asked(planted, tmp_path):
    tested = MethodUnderTest(planted(RefusesMany))
    outcome = search(PROPERTIES["score"], tested, examples=40, seed=1)
    assert outcome.counterexample is None
    assert outcome.asked > 0
    assert outcome.refused > 0
    assert outcome.asked + outcome.refused == outcome.examples == 40
    # What cannot be asked of the changed layout is not asked of the layout either.
    assert search(PROPERTIES["far item"], tested, examples=40, seed=1).counterexample is None
    outcome = search(PROPERTIES["score"], MethodUnderTest(planted(RefusesAll)), examples=5, seed=1)
    assert (outcome.examples, outcome.asked, outcome.refused) == (5, 0, 5)


def test_the_page_counts_apart_what_was_refused(planted, tmp_path, undrawn):
    asked = PropertyStudy((planted(RefusesMany), "fbs"), tuple(chosen(["score"])), 40)
    table = run(asked, tmp_path)
    row, other = table.rows
    assert row.standing is Standing.HOLDS
    assert row.refused == 40 - row.asked > 0
    assert other.refused == 0
    page = written(table, tmp_path)
    assert f"| holds {row.asked}/40, {row.refused} refused |" in page
    assert "|             holds 40/40 |" in page
    assert f"| {row.refused} of 40 |" in page
    assert (
        f"{row.refused} cases lay outside the range that a method declares and were refused" in page
    )
    # Kept and read again as it was.
    assert run(asked, tmp_path).rows == table.rows
    table = run(PropertyStudy((planted(RefusesAll),), asked.properties, 7), tmp_path)
    assert table.rows[0].standing is Standing.NOT_ASKED
    page = written(table, tmp_path)
    assert "| -, 7 refused |" in page
    assert "violated: 0," in page


class RefusesNearlyAll(FullBaseSupport):
    """Judges one item of one size."""

    def _judge(self, layout, watch):
        if layout.items[0].size != (1.0, 1.0, 1.0):
            raise RefusedError("another size")
        return super()._judge(layout, watch)


def test_too_few_cases_are_not_said_to_hold(planted, tmp_path, undrawn):
    asked = PropertyStudy((planted(RefusesNearlyAll),), tuple(chosen(["score"])), 60)
    table = run(asked, tmp_path)
    [row] = table.rows
    assert 0 < row.asked < 6
    assert row.standing is Standing.TOO_FEW
    page = written(table, tmp_path)
    assert "pairs that hold: 0," in page
    assert "with too few cases to say: 1," in page
    assert f"| too few {row.asked}/60, {row.refused} refused |" in page


def at_least_three(tested, case):
    if len(case.layout) >= 3:
        raise Violation("three or more", steps=len(case.layout))
    return len(case.layout) == 2


def test_the_frequency_of_violations_is_that_among_all_cases(tmp_path, monkeypatch, undrawn):
    drawn = []

    def look(tested, case):
        drawn.append(len(case.layout))
        return True

    cases = lambda _: layouts().map(Case)  # noqa: E731
    asked = Property("x", "", cases, at_least_three)
    search(Property("x", "", cases, look), MethodUnderTest("fbs"), examples=80, seed=4)
    found = search(asked, MethodUnderTest("fbs"), examples=80, seed=4).frequency
    larger = sorted(count for count in drawn if count >= 3)
    assert len(drawn) == 80
    assert 0 < len(larger) < 80
    assert (found.violated, found.tested) == (len(larger), sum(count >= 2 for count in drawn))
    assert found.steps == pytest.approx(statistics.median(larger))
    assert search(PROPERTIES["score"], MethodUnderTest("fbs"), examples=5, seed=1).frequency is None
    # The page says the same, also of what was kept.
    monkeypatch.setitem(registry.PROPERTIES, "x", asked)
    study = PropertyStudy(("fbs",), (asked,), 80, seed=4)
    for _ in range(2):
        table = run(study, tmp_path)
        [row] = table.rows
        assert row.share.value == found.violated / found.tested
        assert row.share.low < row.share.value < row.share.high
        assert row.steps == found.steps
    page = written(table, tmp_path)
    percentage = f"{100 * found.violated / found.tested:.1f} ["
    shown = rf"\| x +\| FBS +\| violated +\| +{found.tested} \| +{re.escape(percentage)}"
    assert re.search(shown, page)


def test_the_command_says_how_much_was_refused(planted, tmp_path, capsys, undrawn):
    arguments = ["study", "properties", "-m", planted(RefusesAll), "--property", "far item"]
    assert main([*arguments, "--examples", "3", "-j", "1", "--work", str(tmp_path)]) == 0
    said = capsys.readouterr().err
    assert "planted: not asked on 3 of 3 cases, which lie outside its range" in said


def test_learners_and_cascades_are_asked_without_a_refusal(tmp_path, capsys, undrawn):
    arguments = [
        "study",
        "properties",
        "--examples",
        "3",
        "--seed",
        "1",
        "-j",
        "1",
        "--work",
        str(tmp_path),
    ]
    for spec in ("lstm_1", "lstm_e:question=stands", "cascade@bullet", "settling"):
        arguments += ["-m", spec]
    assert main(arguments) in (0, 1)
    told = capsys.readouterr().err
    assert "not asked" not in told
    assert "did you mean" not in told
    page = (tmp_path / "report.md").read_text()
    for title in ("LSTM_1", "LSTM_e (question=stands)", "Cascade @ bullet", "Settling"):
        # A verdict by Bullet on a case at a threshold may depend on rounding.
        violated = "(-|masses)" if title == "Cascade @ bullet" else "-"
        row = rf"\| {re.escape(title)} +\| +1[0-9] \| {violated} +\| - +\| - "
        assert re.search(row, page), title


def test_a_cascade_is_asked_like_any_method(tmp_path, undrawn):
    arguments = ["study", "properties", "-m", "cascade@mujoco", "--examples", "2", "-j", "1"]
    for name in ("score", "past the edge", "free fall", "sliding", "energy"):
        arguments += ["--property", name]
    assert main([*arguments, "--work", str(tmp_path)]) == 0
    page = (tmp_path / "report.md").read_text()
    assert "pairs that hold: 2, declared findings: 0, violated: 0," in page
    assert page.startswith(
        "# Property tests\n\n1 of 1 methods satisfy all properties that apply to them, each tested "
        "on up to 2 cases.\n"
    )


def test_what_is_violated_at_one_time_and_not_at_another_is_a_violation():
    asked_before = set()

    def first_time_only(tested, case):
        if len(case.layout) >= 3 and case.layout.content_hash() not in asked_before:
            asked_before.add(case.layout.content_hash())
            raise Violation("three items or more")
        return True

    asked = Property("x", "", lambda _: layouts().map(Case), first_time_only)
    outcome = search(asked, MethodUnderTest("fbs"), examples=100, seed=1)
    assert "three items or more (not every time" in outcome.counterexample.found
    assert len(outcome.counterexample.case.layout) >= 3
    assert outcome.asked <= outcome.examples


def study(*methods, examples=40):
    return PropertyStudy(methods, tuple(chosen(["score", "few items"])), examples, seed=3)


def test_a_run_keeps_what_is_done_and_gives_the_same_again(tmp_path, few_items, undrawn):
    first = run(study("fbs", "sme"), tmp_path)
    files = {p: p.stat().st_mtime_ns for p in (tmp_path / "results").iterdir()}
    assert len([p for p in files if p.suffix == ".json"]) == 4
    counts = []
    again = run(
        study("fbs", "sme"),
        tmp_path,
        progress=lambda what, done=0, total=0: counts.append((done, total)),
    )
    assert counts == [(4, 4)]
    assert {p: p.stat().st_mtime_ns for p in (tmp_path / "results").iterdir()} == files
    written(first, tmp_path / "a")
    written(again, tmp_path / "b")
    assert (tmp_path / "a/report.md").read_bytes() == (tmp_path / "b/report.md").read_bytes()


def test_a_damaged_result_is_asked_anew(tmp_path):
    asked = PropertyStudy(("fbs",), tuple(chosen(["score"])), 5)
    first = run(asked, tmp_path)
    (file,) = (tmp_path / "results").glob("*.json")
    whole = file.read_bytes()
    for damaged in (b"", whole[:20]):
        file.write_bytes(damaged)
        assert run(asked, tmp_path).rows == first.rows
        assert file.read_bytes() == whole


def test_the_page_shows_a_counterexample_as_table_picture_and_file(tmp_path, few_items):
    asked = study("fbs")
    found = run(asked, tmp_path)
    page = written(found, tmp_path)
    assert "| FBS    | **violated** " in page
    assert "| score     |" in page
    assert (
        page.index("## Methods") < page.index("## Violated: few items") < page.index("**Others**")
    )
    assert "## Violated: few items, FBS" in page
    assert "3 items" in page
    (picture,) = (tmp_path / "figures").glob("counterexample_few_items_fbs_*.svg")
    assert picture.stat().st_size > 5000
    (file,) = (tmp_path / "counterexamples").glob("few-items-fbs-*.json")
    assert f"[counterexamples/{file.name}](counterexamples/{file.name})" in page
    (layout,) = read_layouts(file)
    with pytest.raises(Violation, match="3 items"):
        below_three(None, Case(layout))
    assert "seed 3" in page


def test_a_method_spelt_in_two_ways_is_asked_once(tmp_path):
    asked = PropertyStudy(("pbs:alpha=0.6", "pbs:alpha=0.60"), tuple(chosen(["score"])), 3)
    table = run(asked, tmp_path)
    assert len(table.methods) == len(table.rows) == 1


def test_specs_that_differ_in_punctuation_keep_files_of_their_own(tmp_path, few_items, undrawn):
    specs = [f"label@mujoco:eps_t={value}" for value in ("1e-16", "1e+16")]
    asked = PropertyStudy(tuple(specs), tuple(chosen(["few items"])), 40, seed=3)
    found = run(asked, tmp_path)
    assert len({row.smallest.file for row in found.rows}) == 2
    written(found, tmp_path)
    assert len(list((tmp_path / "counterexamples").iterdir())) == 2
    assert len(list((tmp_path / "figures").iterdir())) == 2


def test_a_run_that_would_ask_nothing_is_an_error(tmp_path):
    asked = PropertyStudy(("fbs", "sme"), tuple(chosen(["energy"])), 3)
    with pytest.raises(PropertyError, match="'energy': asked of none of fbs, sme"):
        run(asked, tmp_path / "runs")
    assert not (tmp_path / "runs").exists()


def test_an_engine_from_elsewhere_is_asked_anew_when_its_code_changes(tmp_path, monkeypatch):
    imported = "from steadyload.engines.with_mujoco import MujocoWorld"
    code = f"{imported}\n\n\nclass World(MujocoWorld):\n    pass\n"
    (tmp_path / "elsewhere.py").write_text(code)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setitem(ENGINES, "elsewhere", EngineEntry("elsewhere:World", ()))
    asked = PropertyStudy(("label@elsewhere",), tuple(chosen(["free fall"])), 2)
    for changed in range(2):
        (tmp_path / "elsewhere.py").write_text(code + "# changed\n" * changed)
        run(asked, tmp_path / "runs")
    assert len(list((tmp_path / "runs/results").glob("*.json"))) == 2


def test_a_declared_finding_is_no_violation_and_shows_even_when_missed(
    tmp_path, few_items, monkeypatch, undrawn
):
    smallest = search(FEW_ITEMS, MethodUnderTest("fbs"), examples=200, seed=1).counterexample
    declared = KnownFinding("few items", "fbs", smallest.found, "They are drawn.", smallest.case)
    monkeypatch.setattr(findings, "known_findings", lambda: (declared,))
    found = run(study("fbs", examples=1), tmp_path)
    (row,) = [row for row in found.rows if row.property == "few items"]
    assert row.standing is Standing.FINDING
    assert row.smallest.found == "3 items"
    page = written(found, tmp_path)
    assert "They are drawn." in page
    assert "violated: 0," in page


def test_properties_static_baselines_and_accuracies_stand_on_one_page(tmp_path, undrawn):
    run(PropertyStudy(("fbs", "sme"), tuple(chosen(["tower", "mirror"])), 10), tmp_path / "p")
    asked = PropertyStudy(("fbs", "sme"), tuple(chosen(["tower", "mirror"])), 10)
    table = run(asked, tmp_path / "p")
    definition = tmp_path / "study.toml"
    definition.write_text(
        'name = "both"\nbenchmark = "test-300"\nlimit = 6\nmethods = ["fbs", "sme"]\n'
    )
    run_study(load_study(definition), tmp_path / "s")
    tested = Properties().page(table)
    accuracies = RunReport(directory=tmp_path / "s").page(compare(tmp_path / "s"))
    page = Page(
        "Baselines", accuracies.summary, [*accuracies.sections, *tested.sections],
        accuracies.manifest | tested.manifest,
    )  # fmt: skip
    text = write_page(page, tmp_path / "page").read_text()
    assert "## Properties and methods" in text
    assert "| SME    | holds 10/10 |" in text
    assert text.index("## Accuracy") < text.index("## Properties and methods")
    assert (tmp_path / "page/figures").is_dir()


def test_names_that_are_not_there_are_named_errors(tmp_path, capsys):
    with pytest.raises(PropertyError, match="did you mean 'mirror'"):
        chosen(["miror"])
    with pytest.raises(PropertyError, match="unknown engine 'bulet'"):
        methods_on(["bulet"])
    assert main(["study", "properties", "--engine", "bulet", "--work", str(tmp_path)]) == 2
    assert "unknown engine 'bulet'" in capsys.readouterr().err
    assert main(["study", "properties", "--method", "fsb", "--work", str(tmp_path)]) == 2
    assert "unknown method 'fsb'" in capsys.readouterr().err


def test_the_command_writes_a_page_and_says_what_is_violated(tmp_path, capsys, undrawn):
    arguments = ["study", "properties", "--examples", "40", "--seed", "1", "-j", "1"]
    arguments += ["--property", "past the edge"]
    assert main([*arguments, "-m", "label@mujoco", "--work", str(tmp_path / "held")]) == 0
    assert "holds" in (tmp_path / "held/report.md").read_text()
    capsys.readouterr()
    damped = "label@bullet:linear_damping=0.999999,angular_damping=0.999999"
    assert main([*arguments, "-m", damped, "--work", str(tmp_path / "not")]) == 1
    assert f"past the edge, {damped}: stable; expected: fails at step 1" in capsys.readouterr().err
    (file,) = (tmp_path / "not/results").glob("*.json")
    assert json.loads(file.read_text())["failure"]["found"].startswith("stable")


def test_an_engine_that_ends_its_process_is_a_violation_with_its_reason(tmp_path, undrawn):
    asked = PropertyStudy(("fbs",), tuple(chosen(["score"])), 5)
    run(asked, tmp_path)
    store = Store(tmp_path / "results", OUTCOMES)
    [key] = store.keys()
    crashed = dataclasses.replace(store.read(key), asked=0, crashed="ended by SIGABRT")
    store.write(key, [crashed])
    (row,) = run(asked, tmp_path).rows
    assert row.standing is Standing.VIOLATED
    page = written(run(asked, tmp_path), tmp_path)
    assert "No answer: ended by SIGABRT." in page

"""The search of counterexamples, its files, findings, and what the study shows of them."""

import dataclasses
import json
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
from steadyload.progress import silent
from steadyload.properties import findings, registry
from steadyload.properties.findings import KnownFinding
from steadyload.properties.property import Case, MethodUnderTest, Property, Violation
from steadyload.properties.registry import PROPERTIES
from steadyload.properties.search import search
from steadyload.properties.strategies import layouts
from steadyload.reports.columns import table
from steadyload.runs.pool import IN_THIS_PROCESS
from steadyload.runs.store import Store
from steadyload.studies.kit import Lab
from steadyload.studies.properties.outcomes import Standing
from steadyload.studies.properties.study import Properties
from steadyload.studies.properties.testing import (
    OUTCOMES,
    run_properties,
)

pytestmark = pytest.mark.usefixtures("file_in_this_process")


def run(asked, work, progress=silent):
    """The results of methods, names of properties, and the number of cases."""
    methods, properties, examples = asked
    return run_properties(
        Lab(work, IN_THIS_PROCESS, progress), methods, examples,
        [registry.PROPERTIES[name] for name in properties],
    )  # fmt: skip


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


def refusing(refuses):
    """A class of methods that refuse some layouts."""

    class Refusing(FullBaseSupport):
        """Judges the others."""

        def _judge(self, layout, watch):
            if refuses(layout):
                raise RefusedError("outside its range")
            return super()._judge(layout, watch)

    return Refusing


MANY = refusing(lambda layout: len(layout) > 2)
ALL = refusing(lambda layout: True)
NEARLY_ALL = refusing(lambda layout: layout.items[0].size != (1.0, 1.0, 1.0))


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
    tested = MethodUnderTest(planted(MANY))
    outcome = search(PROPERTIES["score"], tested, examples=40, seed=1)
    assert outcome.counterexample is None
    assert outcome.asked > 0
    assert outcome.refused > 0
    assert outcome.asked + outcome.refused == outcome.examples == 40
    # What cannot be asked of the changed layout is not asked of the layout either.
    assert search(PROPERTIES["far item"], tested, examples=40, seed=1).counterexample is None
    outcome = search(PROPERTIES["score"], MethodUnderTest(planted(ALL)), examples=5, seed=1)
    assert (outcome.examples, outcome.asked, outcome.refused) == (5, 0, 5)


def test_what_was_refused_is_counted_apart(planted, tmp_path):
    asked = ((planted(MANY), "fbs"), ("score",), 40)
    found = run(asked, tmp_path)
    row, other = found.rows
    assert (row.standing, other.standing) == (Standing.HOLDS, Standing.HOLDS)
    assert row.refused == 40 - row.asked > 0
    assert (other.refused, found.refused) == (0, row.refused)
    assert [method.refused for method in found.methods] == [(row.refused, 40), (0, 40)]
    cells = str(table([pairs for kind in found.pairs.values() for pairs in kind]))
    assert f"| holds {row.asked}/40, {row.refused} refused |" in cells
    assert "|             holds 40/40 |" in cells
    assert list(Properties().remarks(found)) == [
        f"planted: not asked on {row.refused} of 40 cases, which lie outside its range"
    ]
    assert run(asked, tmp_path).rows == found.rows, "kept and read again as it was"
    found = run(((planted(ALL),), ("score",), 7), tmp_path)
    assert found.rows[0].standing is Standing.NOT_ASKED
    assert (found.counts[Standing.VIOLATED], Properties().status(found)) == (0, 0)


def test_too_few_cases_are_not_said_to_hold(planted, tmp_path):
    asked = ((planted(NEARLY_ALL),), ("score",), 60)
    found = run(asked, tmp_path)
    [row] = found.rows
    assert 0 < row.asked < 6
    assert row.standing is Standing.TOO_FEW
    assert (found.counts[Standing.HOLDS], found.counts[Standing.TOO_FEW]) == (0, 1)
    assert found.methods[0].too_few == ["score"]


def at_least_three(tested, case):
    if len(case.layout) >= 3:
        raise Violation("three or more", steps=len(case.layout))
    return len(case.layout) == 2


def test_the_frequency_of_violations_is_that_among_all_cases(tmp_path, monkeypatch):
    drawn = []

    def look(tested, case):
        drawn.append(len(case.layout))
        return True

    cases = lambda _: layouts().map(Case)  # noqa: E731
    asked = Property("x", "", cases, at_least_three)
    search(Property("x", "", cases, look), MethodUnderTest("fbs"), examples=80, seed=1)
    found = search(asked, MethodUnderTest("fbs"), examples=80, seed=1).frequency
    larger = sorted(count for count in drawn if count >= 3)
    assert len(drawn) == 80
    assert 0 < len(larger) < 80
    assert (found.violated, found.tested) == (len(larger), sum(count >= 2 for count in drawn))
    assert found.steps == pytest.approx(statistics.median(larger))
    assert search(PROPERTIES["score"], MethodUnderTest("fbs"), examples=5, seed=1).frequency is None
    # The study says the same, also of what was kept.
    monkeypatch.setitem(registry.PROPERTIES, "x", asked)
    study = (("fbs",), ("x",), 80)
    for _ in range(2):
        [row] = run(study, tmp_path).rows
        assert (row.n, row.share.value) == (found.tested, found.violated / found.tested)
        assert row.share.low < row.share.value < row.share.high
        assert row.steps == found.steps


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
    return (methods, ("score", "few items"), examples)


@pytest.fixture(scope="module")
def violated(tmp_path_factory):
    """A run in which two methods violate one of two properties, and its folder."""
    work = tmp_path_factory.mktemp("violated")
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(registry.PROPERTIES, FEW_ITEMS.name, FEW_ITEMS)
        return run(study("fbs", "sme"), work), work


def test_a_run_keeps_what_is_done_and_gives_the_same_again(violated, few_items):
    def told(found):
        smallest = [row.smallest and row.smallest.layout.content_hash() for row in found.rows]
        return [dataclasses.replace(row, smallest=None) for row in found.rows], smallest

    first, work = violated
    files = {p: p.stat().st_mtime_ns for p in (work / "results").iterdir()}
    assert len([p for p in files if p.suffix == ".json"]) == 4
    counts = []
    again = run(
        study("fbs", "sme"),
        work,
        progress=lambda what, done=0, total=0: counts.append((done, total)),
    )
    assert counts == [(4, 4)]
    assert {p: p.stat().st_mtime_ns for p in (work / "results").iterdir()} == files
    assert told(again) == told(first)


def test_a_damaged_result_is_asked_anew(tmp_path):
    asked = (("fbs",), ("score",), 5)
    first = run(asked, tmp_path)
    (file,) = (tmp_path / "results").glob("*.json")
    whole = file.read_bytes()
    for damaged in (b"", whole[:20]):
        file.write_bytes(damaged)
        assert run(asked, tmp_path).rows == first.rows
        assert file.read_bytes() == whole


def test_the_page_shows_a_counterexample_as_table_picture_and_file(
    violated, tmp_path, assert_shown
):
    found, _ = violated
    row = found.violations[0]
    assert (row.property, row.method.spec, row.smallest.found) == ("few items", "fbs", "3 items")
    assert (found.sound, found.violated) == (0, {"few items": ["FBS", "SME"]})
    text = assert_shown(
        Properties(),
        found,
        answer=[f"{found.sound} of 2"],
        tables=[
            *(found.methods, found.failing, *found.pairs.values(), found.statements),
            *(one.smallest.boxes for one in found.failing),
        ],
        charts=["violated", *(one.smallest.picture for one in found.failing)],
    )
    assert f"[{row.smallest.file}]({row.smallest.file})" in text
    Properties().beside(found, tmp_path)
    (layout,) = read_layouts(tmp_path / row.smallest.file)
    with pytest.raises(Violation, match="3 items"):
        below_three(None, Case(layout))
    assert found.made_with["examples"] == "up to 40 a property and method, seed 1"


def test_a_property_of_many_simulations_is_tested_on_a_tenth_of_the_cases(tmp_path):
    asked = (("equilibrium:sides=friction",), ("score", "accelerated column"), 20)
    found = run(asked, tmp_path)
    assert {row.examples for row in found.rows} == {20, 2}
    assert found.fewer == ["accelerated column"]
    assert {row.standing for row in found.rows} <= {Standing.HOLDS, Standing.NOT_ASKED}


def test_a_method_spelt_in_two_ways_is_asked_once(tmp_path):
    asked = (("pbs:alpha=0.6", "pbs:alpha=0.60"), ("score",), 3)
    table = run(asked, tmp_path)
    assert len(table.methods) == len(table.rows) == 1


def test_specs_that_differ_in_punctuation_keep_files_of_their_own(tmp_path, few_items):
    specs = [f"label@mujoco:eps_t={value}" for value in ("1e-16", "1e+16")]
    asked = (tuple(specs), ("few items",), 40)
    found = run(asked, tmp_path)
    assert len({row.smallest.file for row in found.rows}) == 2
    assert len({row.smallest.picture for row in found.rows}) == 2


def test_an_engine_from_elsewhere_is_asked_anew_when_its_code_changes(tmp_path, monkeypatch):
    imported = "from steadyload.engines.with_mujoco import MujocoWorld"
    code = f"{imported}\n\n\nclass World(MujocoWorld):\n    pass\n"
    (tmp_path / "elsewhere.py").write_text(code)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setitem(ENGINES, "elsewhere", EngineEntry("elsewhere:World", ()))
    asked = (("label@elsewhere",), ("free fall",), 2)
    for changed in range(2):
        (tmp_path / "elsewhere.py").write_text(code + "# changed\n" * changed)
        run(asked, tmp_path / "runs")
    assert len(list((tmp_path / "runs/results").glob("*.json"))) == 2


def test_a_declared_finding_is_no_violation_and_shows_even_when_missed(
    violated, tmp_path, few_items, monkeypatch
):
    smallest = violated[0].violations[0].smallest
    declared = KnownFinding(
        "few items", "fbs", smallest.found, "They are drawn.", Case(smallest.layout)
    )
    monkeypatch.setattr(findings, "known_findings", lambda: (declared,))
    found = run(study("fbs", examples=1), tmp_path)
    (row,) = [row for row in found.rows if row.property == "few items"]
    assert row.standing is Standing.FINDING
    assert (row.smallest.found, row.why) == ("3 items", "They are drawn.")
    assert not found.violations


def test_the_command_fails_and_says_what_is_violated(tmp_path, capsys, undrawn, monkeypatch):
    damped = "label@bullet:linear_damping=0.999999,angular_damping=0.999999"
    for name in PROPERTIES.keys() - {"past the edge"}:
        monkeypatch.delitem(PROPERTIES, name)
    asked = ["--limit", "40", "-j", "1"]
    assert main(["study", "properties", *asked, "-m", damped, "--work", str(tmp_path)]) == 1
    assert f"past the edge, {damped}: stable; expected: fails at step 1" in capsys.readouterr().err
    (file,) = (tmp_path / "results").glob("*.json")
    assert json.loads(file.read_text())["failure"]["found"].startswith("stable")


def test_an_engine_that_ends_its_process_is_a_violation_with_its_reason(tmp_path):
    asked = (("fbs",), ("score",), 5)
    run(asked, tmp_path)
    store = Store(tmp_path / "results", OUTCOMES)
    [key] = store.keys()
    crashed = dataclasses.replace(store.read(key), asked=0, crashed="ended by SIGABRT")
    store.write(key, [crashed])
    (row,) = run(asked, tmp_path).rows
    assert (row.standing, row.why, row.smallest) == (
        Standing.VIOLATED, "ended by SIGABRT", None,
    )  # fmt: skip

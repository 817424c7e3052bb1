"""A study, an engine or a method that is added by a class and one line stands everywhere."""

import re
import shutil
import subprocess
from dataclasses import dataclass, make_dataclass
from pathlib import Path

import pytest

from steadyload.cli import main
from steadyload.cli.commands import commands
from steadyload.cli.flags import _flags
from steadyload.engines import registry as engine_registry
from steadyload.layouts.model.question import Question
from steadyload.methods import registry as method_registry
from steadyload.methods.contract.declared import Trait
from steadyload.methods.contract.method import StepScorer
from steadyload.methods.naming import method_key
from steadyload.methods.registry import each_question, make_method, methods_with
from steadyload.properties.property import MethodUnderTest
from steadyload.properties.registry import PROPERTIES
from steadyload.reports.style import colour, marker
from steadyload.runs.able import asked_question, fixed_step_engines
from steadyload.runs.costs import load_explained
from steadyload.studies import published, registry
from steadyload.studies.engines.settings_page import engine_records, engines_markdown
from steadyload.studies.evaluation.judging import Options, standard_methods
from steadyload.studies.registry import STUDIES, study
from steadyload.studies.speed.running import step_shares
from steadyload.tuning.cascade.step_scores import score_steps
from steadyload.tuning.cases import Case

ROOT = Path(__file__).parents[2]
TOYS = ROOT / "tests" / "outside" / "toys"
LINES = """\
[steadyload.studies]
toy = toy_study.study:Toy
[steadyload.engines]
toyworld = toy_parts:ToyWorld
[steadyload.methods]
optimist = toy_parts:Optimist
"""


@pytest.fixture
def toys(tmp_path, monkeypatch):
    """A distribution with a study, an engine and a method, found by its entry points."""
    site = tmp_path / "site"
    shutil.copytree(TOYS, site)
    about = site / "toys-1.0.dist-info"
    about.mkdir()
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: toys\nVersion: 1.0\n")
    (about / "entry_points.txt").write_text(LINES)
    monkeypatch.syspath_prepend(site)
    caches = [r._from_other_distributions for r in (registry, engine_registry, method_registry)]
    for cache in caches:
        cache.cache_clear()
    yield
    for cache in caches:
        cache.cache_clear()


@pytest.mark.parametrize("name", STUDIES)
def test_a_study_bears_its_name_and_asks_a_question(name):
    one = study(name)
    assert one.name == name
    assert one.answers.endswith("?")
    assert one.command_words in commands()


def test_the_docs_list_the_options_of_every_study():
    text = (ROOT / "docs" / "studies.md").read_text()
    table = text.split("| study | options |\n| --- | --- |\n")[1].split("\n\n")[0]
    rows = re.findall(r"^\| `(\w+)` \| (.*) \|$", table, re.MULTILINE)
    listed = {name: re.findall(r"`(.*?)`", options) for name, options in rows}
    assert listed == {name: [flag.names[0] for flag in _flags(study(name))] for name in STUDIES}


def test_every_published_page_is_one_studys():
    """A new study has none until `steadyload pages remake NAME` has made it."""
    folders = {page.name for page in (ROOT / published.FOLDER).iterdir() if page.is_dir()}
    listed = [entry.name for entry in published.entries()]
    assert len(listed) == len(set(listed))
    assert folders <= set(listed)


def test_the_commands_that_remake_pages_are_taken():
    from steadyload.cli.running import command_of

    for entry in published.entries():
        words = published.remaking(entry, Path("out"))
        command_of([word for word in words if "*" not in word])


def test_a_page_whose_input_is_missing_is_refused_and_not_made_without_it(tmp_path, monkeypatch):
    from steadyload.cli.running import run

    monkeypatch.chdir(tmp_path)
    (entry,) = published.named(("learned",))
    words = published.remaking(entry, Path("out"))
    assert "../shared/data/aclpp/*.yaml" in words
    assert run(words) == 2
    assert not (tmp_path / "out").exists()


def test_the_published_index_is_up_to_date():
    folder = ROOT / published.FOLDER
    assert (folder / published.INDEX).read_text() == published.index(folder)


@pytest.mark.parametrize("said", ["3.71 [2.00, 6.20] ms of CPU", "takes 7.1 us", "right on 97 %"])
def test_the_index_has_no_time_that_was_taken_on_a_busy_machine(said):
    quiet, busy = (
        f"# T\n\nPS_opt: {said}.\n\nMore.{load_explained(load)}\n" for load in (1.2, 3.4)
    )
    assert published.listed_answer(quiet) == f"PS_opt: {said}."
    assert (said in published.listed_answer(busy)) == said.endswith("%")


def test_the_index_shows_the_leading_figure_of_every_page_that_has_one():
    folder = ROOT / published.FOLDER
    shown = re.findall(r'\[<img src="([^"]+)" width="240"', (folder / published.INDEX).read_text())
    leading = []
    for entry in published.entries():
        lines = entry.text(folder).splitlines()
        first = next((line for line in lines if line.startswith("![")), None)
        leading += [f"{entry.name}/{first.rpartition('(')[2][:-1]}"] if first else []
    assert shown == leading
    assert len(shown) > 15
    assert all((folder / path).is_file() for path in shown)


def test_an_unknown_study_is_named_with_the_nearest():
    with pytest.raises(registry.UnknownStudyError, match="did you mean 'evaluation'"):
        study("evaluatoin")


def test_a_study_is_one_folder_and_one_line(toys, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["study"]) == 0
    assert "│ toy " in capsys.readouterr().out
    assert main(["study", "toy", "--help"]) == 0
    told = capsys.readouterr().out
    for words in ("count boxes", "--boxes N", "how many boxes (default: 3)", "--workers", "--work"):
        assert words in told
    assert main(["study", "toy", "--boxes", "5", "-j", "2", "-o", "pages/toy"]) == 0
    assert capsys.readouterr().out == "pages/toy/report.md\n"
    assert Path("pages/toy/report.md").read_text().startswith("# Boxes\n\nThere are 5 boxes. ")
    assert main(["pages", "list", "-o", "pages"]) == 0
    assert any(line.startswith("toy ") for line in capsys.readouterr().out.splitlines())
    assert main(["pages", "index", "-o", "pages"]) == 0
    assert Path("pages/README.md").read_text().splitlines()[-3:] == [
        "## [Boxes](toy/report.md)",
        "",
        "**How many boxes are there?** There are 5 boxes. They were counted by 2.",
    ]
    assert main(["pages", "remake", "toy", "-o", "pages"]) == 0
    assert Path("pages/toy/report.md").read_text().startswith("# Boxes\n\nThere are 3 boxes. ")
    assert "There are 3 boxes." in Path("pages/README.md").read_text()


@pytest.mark.parametrize(
    ("boxes", "message"),
    [
        ("0", "--boxes: '0'; allowed: a whole number, 1 to 9"),
        ("x", "--boxes: 'x'; allowed: a whole number, 1 to 9"),
        ("7", "study toy: boxes is 7; allowed: any but seven"),
    ],
)
def test_what_a_configuration_refuses_is_one_sentence(toys, boxes, message, capsys):
    assert main(["study", "toy", "--boxes", boxes]) == 2
    assert capsys.readouterr().err == f"steadyload: {message}\n"


def test_make_pages_remakes_what_is_registered(toys, capsys):
    done = subprocess.run(
        ["make", "--no-print-directory", "-n", "pages"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout.splitlines()[-1].split() == [
        ".venv/bin/steadyload",
        "pages",
        "remake",
        "--judge",
        "--keep",
    ]
    assert main(["pages", "remake", "--dry-run"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert "steadyload study toy --output reports/published/toy" in lines


def test_an_engine_is_a_class_and_one_line(toys):
    planned = standard_methods()
    assert [spec for spec in planned if spec.endswith("@toyworld")] == [
        f"{name}@toyworld"
        for name in ("ps5-literal", "ps3-literal", "ps5", "ps3", "ps_opt-paper", "ps_opt")
    ]
    assert "toyworld" in fixed_step_engines()
    assert "simulation@toyworld" in methods_with(Trait.MOVEMENT, "toyworld")
    assert "Toy engine" in engines_markdown(engine_records())
    key = method_key(make_method("ps3@toyworld"))
    assert key.title == "PS_3 @ toyworld"
    assert marker(key) != marker(method_key(make_method("ps3@mujoco")))


def test_a_method_is_a_class_and_one_line(toys, tmp_path, monkeypatch):
    assert "optimist" not in standard_methods(), "it joins where it is named"
    assert Options(("optimist",)).spatial == ("optimist",)
    assert colour(method_key(make_method("optimist"))) not in {
        colour(method_key(make_method(spec))) for spec in ("fbs", "sme", "equilibrium")
    }


PLACES = {
    Trait.STEPWISE: {"prefix", "far item", "mirror", "masses"},
    Trait.BASE_SUPPORT: {"full implies partial", "monotone in alpha"},
    Trait.CENTRES_OF_MASS: {"inside the edge"},
    Trait.BALANCE: {"balanced stays"},
    Trait.MOVEMENT: {"shares of steps"},
    Trait.LEARNED: {"learnt from labels"},
}
"""What is said or tested of a method because it declares a trait."""


@dataclass(frozen=True)
class Shared:
    alpha: float = 0.4


class Scorer(StepScorer):
    decision_threshold = 0.5

    def step_score(self, step):
        return 0.0


def places(layout):
    """Where the toy method stands: properties that are tested on it, and facts about it."""
    tested = MethodUnderTest("optimist")
    method = tested.method
    found = {name for name, one in PROPERTIES.items() if one.applies(tested)}
    if step_shares(method, [layout]):
        found.add("shares of steps")
    table = score_steps(["optimist"], [Case(layout, len(layout), "S1", "list", None)])
    if table.step_scores["optimist"].trained:
        found.add("learnt from labels")
    return found


@pytest.mark.parametrize("trait", Trait)
def test_a_method_of_others_stands_wherever_its_trait_says(toys, stack, monkeypatch, trait):
    kind = method_registry.method_class("optimist")
    monkeypatch.setattr(kind, "Parameters", Shared)
    monkeypatch.setattr(kind, "steps", lambda *_: Scorer())
    monkeypatch.setattr(kind, "step_counts", lambda *_: (1, 1, 0), raising=False)
    without = places(stack(0.0))
    assert "optimist" not in methods_with(trait)
    monkeypatch.setattr(kind, "traits", frozenset((trait,)))
    assert "optimist" in methods_with(trait)
    assert PLACES[trait] <= places(stack(0.0)) - without


def test_a_method_of_others_that_can_be_asked_each_question_is_shown_for_its_own(toys, monkeypatch):
    assert not each_question("optimist")
    asking = make_dataclass("Asking", [("question", Question, Question.WITHIN)], frozen=True)
    monkeypatch.setattr(method_registry.method_class("optimist"), "Parameters", asking)
    assert each_question("optimist") == tuple(Question)
    assert asked_question("optimist:question=stands") is Question.STANDS


def test_traits_of_our_own_methods_name_those_that_were_trained():
    assert methods_with(Trait.LEARNED) == ("lstm_1", "lstm_e")
    for spec in methods_with(Trait.STEPWISE, "mujoco"):
        method = make_method(spec)
        assert bool(method.trained) == (Trait.LEARNED in method.traits), spec
    assert {"simulation@mujoco", "cascade@mujoco"} <= {*methods_with(Trait.STEPWISE, "mujoco")}


def test_they_are_judged_timed_and_drawn_like_any_other(toys, tmp_path, capsys):
    work = tmp_path / "work"
    asked = ["-m", "fbs", "-m", "optimist", "-m", "ps3@toyworld", "--limit", "2"]
    assert main(["study", "evaluation", *asked, "-j", "1", "--work", str(work)]) == 0
    text = (work / "report.md").read_text()
    assert re_rows(text) >= {"Optimist", "PS_3 @ toyworld"}


def re_rows(text):
    """First cells of the tables of a page."""
    return {line.split("|")[1].strip() for line in text.splitlines() if line.startswith("|")}

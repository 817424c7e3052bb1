"""Presets that a search has found: before there are any, written, and made again."""

import dataclasses
import json

import pytest

from steadyload.cli import main
from steadyload.layouts.model.question import Question
from steadyload.methods import registry, tuned
from steadyload.methods.contract.spec import SpecError, as_plain
from steadyload.methods.registry import make_method, method_listing
from steadyload.methods.simulation.simulation_parameters import OF_STANDS
from steadyload.methods.tuned import Tuned, write_tuned
from steadyload.studies.kit import Lab
from steadyload.studies.tuning.comparing import compare
from steadyload.studies.tuning.searching import searching
from steadyload.tuning import TuningError, cost
from steadyload.tuning.cases import CaseSource, load_cases
from steadyload.tuning.cost import TERMS, CostModel, kept_model
from steadyload.tuning.options import SearchOptions
from steadyload.tuning.presets import differences, options_of, preset, write_preset
from steadyload.tuning.search import Search
from steadyload.tuning.space import space_on
from steadyload.tuning.trial import fitness

MODEL = CostModel(dict.fromkeys(TERMS, 0.0) | {"layout": 500.0, "substep": 20.0}, 24, 0.9, 0.1)

OPTIONS = SearchOptions(
    "mujoco", population=4, generations=2, seed=1, source=CaseSource(limit=2), model=MODEL
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Of a finished search."""
    folder = tmp_path_factory.mktemp("search")
    Search(folder, OPTIONS).run(workers=0)
    return folder


@pytest.fixture
def search(folder):
    """As if its code were in a commit, whatever this tree is."""
    search = Search.of(folder)
    search.ledger.facts["made_by"] = {**search.made_by, "git": "0123456789ab"}
    return search


@pytest.fixture(autouse=True)
def presets_file(tmp_path, monkeypatch):
    """As before the first search; the file that presets are written to."""
    monkeypatch.setattr(tuned, "FILE", tmp_path / "tuned.json")
    return tuned.FILE


@pytest.mark.parametrize(
    ("spec", "message"),
    [
        ("ps_opt@mujoco", "no engine yet; to tune it run steadyload tune --engine mujoco"),
        ("ps_opt-equal@dart", "dart --population 24 --generations 5 --preset ps_opt-equal --write"),
        ("ps_opt@reference", "reference chooses its own steps, there is nothing to tune"),
        ("ps_opt", "ps_opt needs an engine, for example ps_opt@mujoco"),
        ("ps_opt@mojuco", "unknown engine 'mojuco'; did you mean 'mujoco'?"),
    ],
)
def test_a_preset_that_is_not_there_says_what_to_do(spec, message):
    with pytest.raises(SpecError) as caught:
        make_method(spec)
    assert message in str(caught.value)


def test_before_anything_was_tuned(folder, tmp_path):
    [entry] = [m for m in method_listing("mujoco") if m.name == "ps_opt"]
    assert "none yet: steadyload tune" in entry.about
    assert entry.parameters == ()
    with pytest.raises(TuningError, match="no search found it; allowed: none yet"):
        options_of("ps_opt@mujoco")
    with pytest.raises(TuningError, match="none of these engines has a preset"):
        compare(Lab(tmp_path / "work"), [Search.of(folder)])
    assert not (tmp_path / "work").exists()


def test_a_preset_is_what_was_found(search, presets_file):
    assert write_preset(search) == presets_file
    method = make_method("ps_opt@mujoco")
    best = search.fittest()
    assert method.parameters == search.space.parameters(best.genotype)
    assert str(method.spec) == "ps_opt@mujoco"
    other = make_method("ps_opt@mujoco:eps_t=3").parameters
    assert other == dataclasses.replace(method.parameters, eps_t=3.0)
    with pytest.raises(SpecError, match=r"ps_opt was tuned for mujoco; to tune it run .* bullet "):
        make_method("ps_opt@bullet")
    with pytest.raises(SpecError, match=r"nothing to tune; ps_opt was tuned for mujoco$"):
        make_method("ps_opt@reference")
    listed = {m.name: m for m in method_listing("mujoco")}["ps_opt"]
    shown = {p.name: p.value for p in listed.parameters}
    plain = as_plain(method.parameters)
    for name, value in search.space.values(best.genotype).items():
        assert plain[name] == value
        assert shown[name] == str(value) or float(shown[name]) == value
    assert "ps_opt@mujoco" in {m.name: m for m in method_listing("bullet")}["ps_opt"].about
    assert registry.presets()["ps_opt"].title == "PS_opt"


def test_a_preset_of_another_engine_stays(search, presets_file):
    write_tuned("within", "bullet", Tuned({"eps_t": 12}, {}))
    write_preset(search)
    assert make_method("ps_opt@bullet").parameters.eps_t == 12
    records = json.loads(presets_file.read_text())["tuned"]
    assert [record["engine"] for record in records] == ["bullet", "mujoco"]


def test_a_preset_is_found_again(search, presets_file, tmp_path):
    """From the file alone, in another folder."""
    write_preset(search)
    options = options_of("ps_opt@mujoco")
    assert options == OPTIONS
    again = Search(tmp_path / "again", options)
    again.run(workers=0)
    assert len(again.ledger.entries) == len(search.ledger.entries)
    assert differences("ps_opt@mujoco", preset(again)) == []
    found = preset(search)
    write_tuned("within", "mujoco", dataclasses.replace(
        found, parameters={**found.parameters, "eps_t": 99}))  # fmt: skip
    [unlike] = differences("ps_opt@mujoco", preset(again))
    assert unlike == f"eps_t is {found.parameters['eps_t']!r}, was 99"


def test_a_preset_of_equal_searches_stands_beside_the_best_one(search, presets_file):
    write_tuned("within", "mujoco", Tuned({"eps_t": 12}, {}))
    write_preset(search, "ps_opt-equal")
    own = make_method("ps_opt-equal@mujoco")
    assert own.parameters == search.space.parameters(search.fittest().genotype)
    assert make_method("ps_opt@mujoco").parameters.eps_t == 12
    assert options_of("ps_opt-equal@mujoco") == OPTIONS
    assert differences("ps_opt-equal@mujoco", preset(search)) == []
    with pytest.raises(SpecError, match=r"ps_opt-equal was tuned for mujoco; .*-equal --write"):
        make_method("ps_opt-equal@bullet")
    with pytest.raises(TuningError, match=r"allowed: ps_opt@mujoco, ps_opt-equal@mujoco$"):
        options_of("ps_opt-equal@bullet")


def test_a_preset_has_one_of_the_known_names(search, presets_file, tmp_path, capsys):
    with pytest.raises(TuningError, match="preset is 'best'; allowed: ps_opt, ps_opt-equal"):
        write_preset(search, "best")
    words = ["tune", "--engine", "mujoco", "--generations", "1", "--preset", "ps_opt-eqal"]
    assert main([*words, "-o", str(tmp_path / "search")]) == 2
    assert "did you mean 'ps_opt-equal'?" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_what_a_search_began_with_is_written_down(search, presets_file, tmp_path):
    """As values: the name will stand for something else."""
    found = preset(search)
    write_tuned("within", "mujoco", dataclasses.replace(
        found, parameters={**found.parameters, "eps_t": 11.5, "shrink": 1e-4}))  # fmt: skip
    known = search.space.genotype("ps_opt@mujoco")
    assert known not in search.ledger.entries
    begun = dataclasses.replace(OPTIONS, seed=9, generations=1, begin_with=("ps_opt@mujoco",))
    later = Search(tmp_path / "later", begun)
    best = later.run(workers=0)
    judged = later.ledger.entries[known]
    assert judged.generation == 0
    assert fitness(best.trial, later.goal) >= fitness(judged.trial, later.goal)
    assert Search.of(tmp_path / "later").options.begin_with == (search.space.spec(known),)
    assert searching(later).known == 1
    write_tuned("within", "mujoco", preset(later))
    again = Search(tmp_path / "again", options_of("ps_opt@mujoco"))
    assert again.known == (known,)
    again.run(workers=0)
    assert differences("ps_opt@mujoco", preset(again)) == []


def test_what_nobody_could_make_again_is_no_preset(search, presets_file):
    search.ledger.facts["made_by"] = {**search.made_by, "git": "0123456789ab-dirty"}
    with pytest.raises(TuningError, match="0123456789ab-dirty, which is in no commit"):
        write_preset(search)
    assert not presets_file.exists()


def test_a_preset_of_another_question_has_a_place_of_its_own(search, presets_file):
    write_preset(search)
    own = make_method("ps_opt@mujoco").parameters
    assert make_method("ps_opt@mujoco:question=stands").parameters == dataclasses.replace(
        own, question=Question.STANDS, **OF_STANDS
    )
    found = Tuned({"eps_t": 12, "t_max": 2.0, "question": "stands"}, {})
    write_tuned("stands", "mujoco", found)
    stands = make_method("ps_opt@mujoco:question=stands").parameters
    assert (stands.eps_t, stands.t_max, stands.question) == (12.0, 2.0, Question.STANDS)
    assert make_method("ps_opt@mujoco").parameters == own
    with pytest.raises(TuningError, match=r"allowed: ps_opt@mujoco, ps_opt@mujoco:question=stands"):
        options_of("ps_opt@dart:question=stands")


def test_the_page_leaves_out_searches_for_another_question(folder, tmp_path):
    within, other = Search.of(folder), Search.of(folder)
    asked = dataclasses.replace(other.options.source, question="stands")
    other.options = dataclasses.replace(other.options, source=asked)
    with pytest.raises(TuningError, match="none of the searches is for the question within"):
        compare(Lab(tmp_path / "work"), [other])
    # Of both, the one for the question of the label counts: it has written no preset yet.
    with pytest.raises(TuningError, match="none of these engines has a preset"):
        compare(Lab(tmp_path / "work"), [other, within])


def test_the_space_of_a_question_is_judged_on_its_labels():
    options = SearchOptions.on("mujoco", space="stands", generations=1)
    assert options.source.question == "stands"
    start = space_on("mujoco", "stands")
    parameters = start.parameters(start.start)
    assert (parameters.question, parameters.t_max) == (Question.STANDS, 3.0)
    assert parameters.early_exit == 0.0
    usual = load_cases(SearchOptions.on("mujoco", generations=1).source)
    asked = load_cases(options.source)
    safe = {(c.layout.name, c.scenario): c.safe for c in usual}
    earlier = [c for c in asked if c.safe < safe[c.layout.name, c.scenario]]
    assert 0.05 < len(earlier) / len(asked) < 0.1


def test_further_sets_take_turns_with_the_first():
    both = SearchOptions.on("mujoco", data=("real",), limit=4, generations=1).source
    first, real = CaseSource("search", "choosing", 4), CaseSource(directory="real", limit=4)
    cases = load_cases(both)
    names = [{c.layout.name for c in load_cases(source)} for source in (first, real)]
    assert sorted(c.layout.name for c in cases) == sorted(
        c.layout.name for source in (first, real) for c in load_cases(source)
    )
    fragile = sum(c.robust is False for c in load_cases(first))
    sure = cases[fragile:]  # the set of real size says nothing of robustness
    soon = {c.layout.name for c in sure[: len(sure) // 2]}
    assert all(soon & own for own in names)
    stored = both.stored()
    assert (stored["data"], CaseSource(**stored)) == (["real"], both)
    assert "data" not in first.stored()


def test_the_cost_that_counts_as_fast_can_be_stated(tmp_path):
    options = dataclasses.replace(OPTIONS, generations=1, goal=0.5)
    search = Search(tmp_path, options)
    best = search.run(workers=0)
    assert (search.goal, Search.of(tmp_path).options.goal) == (0.5, 0.5)
    assert preset(search).made_by["goal"] == 0.5
    speed = 0.15 * min(1.0, 0.5 / best.trial.mean_cost)
    assert fitness(best.trial, search.goal) == pytest.approx(0.85 * best.trial.accuracy + speed)
    with pytest.raises(TuningError, match="goal is 0; allowed: more than 0"):
        dataclasses.replace(OPTIONS, goal=0.0)


@pytest.mark.parametrize(
    ("engine", "data", "message"),
    [
        ("mujoco", ("real", "real"), "labelled set real is named 2 times; allowed: once"),
        ("chipmunk", ("real",), "its layouts are not planar; an engine of two dimensions takes"),
    ],
)
def test_sets_that_do_not_go_together_are_refused_before_work(engine, data, message):
    with pytest.raises(TuningError, match=message):
        SearchOptions.on(engine, data=data, generations=1)


def test_a_cost_model_of_fewer_cases_is_not_taken_for_that_of_all(tmp_path, monkeypatch):
    measured = []
    monkeypatch.setattr(cost, "calibrate", lambda *a, **b: measured.append(a[1]) or MODEL)
    space = space_on("mujoco")
    for limit in (1, 1, None, None, 1):
        source = CaseSource(limit=limit)
        kept_model(tmp_path / "cost.json", space, source, workers=0)
    assert [source.limit for source in measured] == [1, None, 1]

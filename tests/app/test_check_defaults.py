"""The default method: by number of boxes, by what is installed, and by what thresholds are for."""

import itertools
import json
from collections import Counter

import pytest

import steadyload as sl
from steadyload.app import check_defaults
from steadyload.app.check_defaults import PREFERENCES, Preference, default_help, default_method
from steadyload.app.checking import check_all
from steadyload.app.recommend.kept import load_fronts
from steadyload.app.viewing import write_view, write_views
from steadyload.cli import main
from steadyload.engines import registry
from steadyload.engines.registry import world_class
from steadyload.engines.world import EngineNotInstalledError
from steadyload.layouts.files.record import Refused
from steadyload.layouts.formats import Format, write_layouts
from steadyload.layouts.model.layout import Item, Layout, LayoutError, Pallet
from steadyload.layouts.model.question import Question
from steadyload.methods.cascade.thresholds import fitted_for
from steadyload.methods.registry import make_method
from steadyload.methods.session.recording import record_loading

RAPIER, MUJOCO = "cascade@rapier:question=stands", "cascade@mujoco:question=stands"
INSTEAD = (
    f"rapier3d is not installed, so loads are judged by {MUJOCO}: less often right on labelled "
    "loads of 25 to 61 boxes; pip install rapier3d"
)
SIZES = (1, 20, 21, 62, 63, 150)


def column(name, boxes):
    """Cubes of 10 cm, one on the other."""
    items = (Item(k, (40.0, 10.0 * k, 40.0), (10.0, 10.0, 10.0), 2.0) for k in range(boxes))
    return Layout(name, Pallet(120, 150, 80), tuple(items))


@pytest.fixture(autouse=True)
def anew(monkeypatch):
    """All four cascades have thresholds, and nothing has been said yet."""
    fitted = frozenset(itertools.product(("rapier", "mujoco"), Question))
    monkeypatch.setattr(check_defaults, "_fitted", lambda: fitted)
    check_defaults._say_once.cache_clear()
    yield
    check_defaults._say_once.cache_clear()


@pytest.fixture
def hide(monkeypatch):
    """Hides packages of engines, wherever one asks."""
    here = registry._is_installed

    def without(*packages):
        monkeypatch.setattr(
            registry, "_is_installed", lambda name: name not in packages and here(name)
        )

    return without


@pytest.fixture
def by_size(monkeypatch):
    """Loads of one box are judged by one rule, larger ones by another."""
    rules = (Preference("stands", "fbs", most=1), Preference("stands", "sme"))
    monkeypatch.setattr(check_defaults, "PREFERENCES", rules)


@pytest.mark.engine("rapier")
def test_with_rapier_loads_of_any_size_are_judged_by_its_cascade(caplog):
    assert {default_method(boxes) for boxes in SIZES} == {RAPIER}
    assert default_method(30, "within") == "cascade@rapier"
    assert caplog.messages == []


def test_without_rapier_one_sentence_says_what_takes_its_place(hide, caplog):
    hide("rapier3d")
    assert {default_method(boxes) for boxes in SIZES} == {MUJOCO}
    assert caplog.messages == [INSTEAD]
    with pytest.raises(EngineNotInstalledError, match=r"rapier3d: pip install rapier3d$"):
        world_class("rapier")


@pytest.mark.parametrize("hidden", [(), ("rapier3d",)])
def test_without_thresholds_for_rapier_nothing_is_missed(hidden, hide, monkeypatch, caplog):
    hide(*hidden)
    monkeypatch.setattr(check_defaults, "_fitted", lambda: {("mujoco", "stands")})
    assert default_method(30) == MUJOCO
    assert caplog.messages == []


def test_without_any_engine_the_best_static_method_of_the_size_judges(hide, caplog):
    hide("rapier3d", "mujoco")
    lstm = "lstm_e:question=stands"
    judges = [default_method(boxes) for boxes in SIZES]
    assert judges == ["settling", "settling", lstm, lstm, lstm, lstm]
    assert caplog.messages[0] == (
        "rapier3d and mujoco are not installed, so loads are judged by settling: less accurate; "
        "pip install rapier3d mujoco"
    )
    assert default_method(30, "within") == "equilibrium:time=0.3"
    assert default_method(101, "within") == "lstm_e"


def test_of_methods_without_an_engine_the_most_accurate_measured_on_its_size_is_taken(hide):
    hide("rapier3d", "mujoco")
    for front in load_fronts():
        free = {m.method: m.accuracy.value for m in front.measured if m.engine is None}
        for boxes in (front.fewest, front.most):
            chosen = default_method(boxes, str(front.question))
            assert free[chosen] == max(free.values()), (front.sizes, front.question)


def test_a_cascade_is_the_default_as_soon_as_the_package_has_its_thresholds(monkeypatch):
    monkeypatch.undo()
    fitted = fitted_for()
    assert ("mujoco", "stands") in fitted
    here = registry.missing_packages("rapier") == () and ("rapier", "stands") in fitted
    assert default_method(30) == (RAPIER if here else MUJOCO)


@pytest.mark.parametrize("one", PREFERENCES, ids=lambda one: f"{one.method}-{one.most}")
def test_every_default_is_a_spec_as_it_is_printed(one):
    spec = make_method(one.method).spec
    assert str(spec) == one.method
    assert spec.engine == one.engine
    assert one.engine is None or spec.name == "cascade"


def test_help_names_all_that_may_judge():
    stands = [one.method for one in PREFERENCES if one.question == "stands"]
    assert all(method in default_help() for method in stands)


def test_another_question_is_refused():
    with pytest.raises(ValueError, match="question is 'falls'; allowed: within, stands"):
        default_method(3, "falls")


@pytest.mark.parametrize("words", [(), ("--json",), ("--csv",)])
def test_the_command_says_it_once_and_not_in_its_records(
    words, hide, tmp_path, capsys, in_this_process
):
    hide("rapier3d")
    file = tmp_path / "pallets.json"
    write_layouts(file, [column("one", 1), column("three", 3)], Format.NATIVE)
    assert main(["check", str(file), *words]) == 0
    said = capsys.readouterr()
    assert said.err.count(INSTEAD) == said.err.count("rapier3d is not installed") == 1
    assert "not installed" not in said.out
    if words == ("--json",):
        assert [one["method"] for one in json.loads(said.out)] == [MUJOCO, MUJOCO]


def test_from_python_it_is_a_warning_once_a_process(hide, caplog):
    hide("rapier3d")
    assert [sl.check(column("c", boxes)).method for boxes in (1, 2)] == [MUJOCO, MUJOCO]
    assert caplog.messages == [INSTEAD]
    assert sl.check(column("c", 2), "sme").method == "sme"


def test_every_layout_of_a_file_is_judged_by_the_default_for_its_size(
    by_size, tmp_path, capsys, in_this_process
):
    files = [tmp_path / "mixed.json", tmp_path / "bad.csv"]
    write_layouts(files[0], [column("one", 1), column("three", 3)], Format.NATIVE)
    assert main(["check", str(files[0]), "--json"]) == 0
    records = json.loads(capsys.readouterr().out)
    assert {one["layout"]: one["method"] for one in records} == {"one": "fbs", "three": "sme"}
    assert main(["check", str(files[0])]) == 0
    assert capsys.readouterr().out.splitlines()[-1] == "2 pallets: 2 stand, 0 fail (fbs, sme)"
    assert [sl.check(column("c", boxes)).method for boxes in (1, 2)] == ["fbs", "sme"]
    named = check_all([("f", column("one", 1)), ("f", column("three", 3))], "pbs0.5", workers=0)
    assert Counter(one.method for one in named) == {"pbs0.5": 2}


def test_layouts_of_which_none_is_valid_have_an_answer(by_size):
    bad = Refused("bad", LayoutError("the weight of item 0 is -1"))
    [answer] = check_all([("f", bad)], workers=0)
    assert str(answer.answer) == "bad input"


def test_one_score_is_by_the_method_for_the_largest_layout(
    by_size, tmp_path, capsys, in_this_process
):
    file = tmp_path / "mixed.json"
    write_layouts(file, [column("three", 3), column("one", 1)], Format.NATIVE)
    assert main(["score", str(file), "--json"]) == 0
    said = capsys.readouterr()
    assert [one["method"] for one in json.loads(said.out)] == ["sme", "sme"]
    assert "all layouts are judged by sme, the default for 3 boxes" in said.err
    assert main(["score", str(file), "--json", "--max-items", "1"]) == 0
    said = capsys.readouterr()
    assert [one["method"] for one in json.loads(said.out)] == ["fbs", "fbs"]
    assert "all layouts" not in said.err


def test_a_page_of_loadings_has_every_load_judged_by_the_default_for_its_size(by_size, tmp_path):
    judged = []

    def record(layout, method):
        judged.append((layout.name, str(method.spec)))
        return record_loading(layout, method)

    loads = [column("one", 1), column("three", 3)]
    page = write_views(loads, output=tmp_path / "page.html", record=record)
    assert "2 layouts, judged by fbs and sme." in page.read_text()
    write_view(loads[1], output=tmp_path / "view.html", record=record)
    assert judged == [("one", "fbs"), ("three", "sme"), ("three", "sme")]

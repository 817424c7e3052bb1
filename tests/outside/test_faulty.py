"""Faulty methods, engines and studies of other distributions: each breaks nothing but itself."""

import importlib
import os
import sys

import pytest

from steadyload.cli import main
from steadyload.engines import registry as engine_registry
from steadyload.engines.errors import EngineNotInstalledError
from steadyload.engines.registry import capabilities, world_class
from steadyload.layouts import Item, Layout, Pallet
from steadyload.layouts.formats import Format, write_layouts
from steadyload.methods import registry
from steadyload.methods.registry import make_method, method_listing
from steadyload.plugins import PluginError
from steadyload.studies import registry as study_registry
from steadyload.studies.evaluation.judging import standard_methods

CODE = """
from dataclasses import dataclass
from steadyload.methods.contract.method import STABLE, Finding, Method


class Corners(Method):
    @dataclass(frozen=True)
    class Parameters:
        corners: int = 3
        share: float = 0.5
        strict: bool = False
        word: str = "any"

    def _judge(self, layout, watch):
        return STABLE


class Bare(Method):
    def _judge(self, layout, watch):
        return STABLE


class NoMethod:
    pass


NOTHING = None
"""

ENTRIES = """
[steadyload.methods]
corners = strange_judges:Corners
bare = strange_judges:Bare
none = strange_judges:NoMethod
lost = strange_judges:Lost
gone = strange_missing:Gone
broken = strange_broken:Method
leaves = strange_leaving:Method
[steadyload.engines]
strange = strange_broken:World
unknown = strange_judges:World
nothing = strange_judges:NOTHING
other = strange_judges:NoMethod
leaves = strange_leaving:World
[steadyload.studies]
strange = strange_broken:STUDY
leaves = strange_leaving:STUDY
"""

CACHES = (registry, engine_registry, study_registry)


@pytest.fixture
def strange(tmp_path, monkeypatch):
    about = tmp_path / "strange_judges-2.5.dist-info"
    about.mkdir()
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: strange-judges\nVersion: 2.5\n")
    (about / "entry_points.txt").write_text(ENTRIES)
    (tmp_path / "strange_judges.py").write_text(CODE)
    (tmp_path / "strange_broken.py").write_text("raise RuntimeError('no licence')\n")
    (tmp_path / "strange_leaving.py").write_text("raise SystemExit('good bye')\n")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(tmp_path), *filter(None, sys.path)]))
    importlib.invalidate_caches()
    for one in CACHES:
        one._from_other_distributions.cache_clear()
    engine_registry.absent_engines.cache_clear()
    yield
    for one in CACHES:
        one._from_other_distributions.cache_clear()
    sys.modules.pop("strange_judges", None)


def test_plain_fields_of_a_dataclass_are_parameters(strange):
    listed = {m.name: m for m in method_listing()}["corners"]
    told = [(p.name, p.value, p.unit, p.allowed, p.about) for p in listed.parameters]
    assert told == [
        ("corners", "3", "", "a number", ""),
        ("share", "0.5", "", "a number", ""),
        ("strict", "false", "", "true|false", ""),
        ("word", "any", "", "a text", ""),
    ]
    made = make_method("corners:share=0.25,strict=true,corners=4")
    assert (made.parameters.corners, made.parameters.share, made.parameters.strict) == (4, 0.25, 1)
    assert str(make_method(str(made.spec)).spec) == "corners:corners=4,share=0.25,strict=true"
    with pytest.raises(ValueError, match="strict is 'maybe'; allowed: true or false"):
        make_method("corners:strict=maybe")


FAULTY = {
    "bare": "strange_judges:Bare has no dataclass Parameters",
    "none": "strange_judges:NoMethod is no subclass of Method",
    "lost": "AttributeError: module 'strange_judges' has no attribute 'Lost'",
    "gone": "ModuleNotFoundError: No module named 'strange_missing'",
    "broken": "RuntimeError: no licence",
    "leaves": "SystemExit: good bye",
}


@pytest.mark.parametrize("name", FAULTY)
def test_a_faulty_method_says_whose_it_is_and_why(strange, name):
    with pytest.raises(PluginError) as caught:
        make_method(name)
    told = f"method {name!r} of strange-judges 2.5 cannot be used: {FAULTY[name]}"
    assert str(caught.value) == told


def test_listings_and_commands_go_on_without_what_is_faulty(strange, capsys):
    assert main(["methods"]) == 0
    told = capsys.readouterr()
    assert {"corners", "sme", "cascade"} <= {line.split()[0] for line in told.out.splitlines()[1:]}
    for name in FAULTY:
        assert told.err.count(f"method {name!r} of strange-judges 2.5 cannot be used") == 1
    for name in ("strange", "leaves"):
        assert told.err.count(f"study {name!r} of strange-judges 2.5 cannot be used") == 1
    assert main(["methods", "sme"]) == 0
    assert "sme" in standard_methods()


@pytest.mark.parametrize(
    ("name", "why"),
    [
        ("strange", "RuntimeError: no licence"),
        ("unknown", "AttributeError: module 'strange_judges' has no attribute 'World'"),
        ("nothing", "strange_judges:NOTHING is no FixedStepWorld"),
        ("other", "strange_judges:NoMethod is no FixedStepWorld"),
        ("leaves", "SystemExit: good bye"),
    ],
)
def test_a_faulty_engine_is_one_that_is_not_installed(strange, name, why, tmp_path, capsys):
    told = f"engine '{name}' of strange-judges 2.5 cannot be used: {why}"
    for asked in (capabilities, world_class):
        with pytest.raises(EngineNotInstalledError) as caught:
            asked(name)
        assert str(caught.value) == told
    layout = Layout("one", Pallet(9, 9, 9), (Item(0, (0, 0, 0), (9, 9, 9), 1),))
    write_layouts(tmp_path / "one.json", [layout], Format.NATIVE)
    assert main(["score", str(tmp_path / "one.json"), "-m", f"label@{name}"]) == 2
    assert told in capsys.readouterr().err
    assert main(["engines"]) == 0
    assert why in capsys.readouterr().out


def test_a_faulty_study_is_refused_by_name(strange):
    with pytest.raises(PluginError, match=r"study 'strange' of strange-judges 2\.5 cannot be used"):
        study_registry.study("strange")
    assert study_registry.study("scale").about

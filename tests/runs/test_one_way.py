"""A command reads a file once, checks a layout once, makes a method once and reads a shard once."""

import sys
from collections import Counter
from pathlib import Path

import pytest

from steadyload.app.checking import check_all
from steadyload.cli.running import run
from steadyload.layouts.formats import Format, write_layouts
from steadyload.layouts.model.layout import Layout
from steadyload.layouts.packing.packing import random_layouts
from steadyload.methods import registry
from steadyload.runs import methods_here
from steadyload.runs.scoring import read_entries
from steadyload.runs.store import Store

WATCHED = {
    registry.make_method.__code__: ("made", lambda local: str(local["spec"])),
    Layout.__post_init__.__code__: ("checked", lambda local: local["self"].name),
    Store.content.__code__: ("shard read", lambda local: local["key"]),
}
"""Code of functions whose calls are counted: under which word, and of what."""

LOADS = ("A", "B", "C")
METHODS = ("fbs", "sme", "simulation@mujoco:frequency=60")


class Counting:
    """Counts calls and files that are opened, while it is on."""

    on = False

    def __init__(self):
        self.of = {"made": Counter(), "checked": Counter(), "shard read": Counter()}
        self.opened = Counter()
        sys.addaudithook(self.hear)  # which no one can take off again

    def hear(self, event, details):
        if self.on and event == "open" and isinstance(details[0], str) and details[1] is not None:
            self.opened[Path(details[0]).name] += "r" in details[1]

    def see(self, frame, event, _):
        if event == "call" and frame.f_code in WATCHED:
            word, which = WATCHED[frame.f_code]
            self.of[word][which(frame.f_locals)] += 1

    def __enter__(self):
        self.on = True
        sys.setprofile(self.see)
        return self

    def __exit__(self, *raised):
        sys.setprofile(None)
        self.on = False

    def most(self, word, names):
        """How often something was done to each of some things."""
        return {self.of[word][name] for name in names}


@pytest.fixture
def layouts(tmp_path, monkeypatch):
    """Three loads in a file of the folder that the test works in."""
    monkeypatch.chdir(tmp_path)
    loads = [
        load.renamed(name) for load, name in zip(random_layouts(3, seed=1), LOADS, strict=True)
    ]
    write_layouts("loads.csv", loads, Format.CSV)
    Path("study.toml").write_text(
        f"name = 'few'\nmethods = {list(METHODS)}\nlayouts = ['loads.csv']\n"
        "scenarios = ['S1', 'S2b']\n"
    )
    return loads


def study(*more):
    assert run(["study", "run", "study.toml", "-o", "run", "--executor", "serial", *more]) == 0


def test_a_run_goes_one_way(layouts):
    with Counting() as found:
        study()
    assert found.opened["loads.csv"] == 1
    assert found.most("checked", LOADS) == {1}
    assert found.of["made"] == Counter(METHODS)
    assert found.opened["layouts.parquet"] <= 2, "once for keys, once to judge"


def test_a_run_that_goes_on_judges_from_what_it_has_read(layouts):
    study()
    shards = sorted(Path("run/results").iterdir())
    shards[0].unlink()
    with Counting() as found:
        study()
    assert found.opened["loads.csv"] == 1
    assert found.most("checked", LOADS) == {1}
    assert found.of["made"] == Counter(METHODS)
    assert [found.opened[shard.name] for shard in shards] == [0, *[1] * (len(shards) - 1)]
    assert not found.of["shard read"], "a checksum is enough to tell that a shard is whole"


def test_a_page_reads_manifest_and_shards_once(layouts):
    study()
    with Counting() as found:
        assert run(["study", "report", "run", "-o", "page"]) == 0
    shards = [path.name for path in Path("run/results").iterdir()]
    assert {found.opened[name] for name in (*shards, "manifest.json")} == {1}
    assert sorted(found.of["shard read"].values()) == [1] * len(shards)
    assert found.opened["layouts.parquet"] == 2, "once for its checksum, once for the layouts shown"
    assert max(found.of["checked"].values(), default=0) <= 1
    assert not found.of["made"]


@pytest.mark.parametrize(
    "words",
    [
        ["score", "loads.csv", "-m", "fbs", "-m", "sme"],
        ["view", "loads.csv", "-m", "sme", "--beside", "fbs"],
    ],
    ids=lambda words: words[0],
)
def test_a_command_goes_one_way(words, layouts):
    with Counting() as found:
        assert run(words) == 0
    assert found.opened["loads.csv"] == 1
    assert found.most("checked", LOADS) == {1}
    assert found.most("made", ("fbs", "sme")) == {1}


def test_a_check_makes_its_method_once(layouts):
    with Counting() as found:
        checked = check_all(read_entries(["loads.csv"]), "sme", workers=0)
    assert len(checked) == len(LOADS)
    assert found.opened["loads.csv"] == 1
    assert found.most("checked", LOADS) == {1}
    assert found.of["made"]["sme"] == 1


def test_a_run_forgets_methods_of_the_run_before(layouts):
    study()
    before = methods_here.method_named("sme")
    assert methods_here.method_named("sme") is before
    study("--rerun")
    assert methods_here.method_named("sme") is not before


def test_what_is_made_of_a_valid_layout_is_valid(layouts):
    for layout in layouts:
        half = layout.mass_offsets + layout.sizes / 4.0
        made = (
            layout.first(2), layout.renamed("other"), layout.on("deck"),
            layout.on("deck").first(1), layout.with_mass_offsets(half).first(3),
        )  # fmt: skip
        for one in made:
            again = Layout(one.name, one.pallet, one.items)
            assert again.content_hash() == one.content_hash()
            assert again.floor == one.floor
            assert len(again) == len(one)
            assert not one.weights.flags.writeable
            assert not one.mass_offsets.flags.writeable

"""The planar labelled set: how it is drawn, and the one that comes with the package."""

import dataclasses
import json

import pytest

from steadyload.cli import main
from steadyload.labelling.building.build import (
    PLANAR_OPTIONS,
    BuildOptions,
    build,
)
from steadyload.labelling.labelling import build_set, split_sizes
from steadyload.layouts.benchmark import load_benchmark
from steadyload.layouts.benchmark.overview import overview
from steadyload.layouts.benchmark.parts import PLANAR, Part
from steadyload.layouts.model.scenarios import Scenario, apply_scenario
from steadyload.layouts.packing.heuristics import HEURISTICS
from steadyload.layouts.packing.packing import (
    ITEM_CLASSES,
    MOST_ITEMS,
    generate,
    make_instance,
    pack_instance,
)
from steadyload.methods.simulation.scene import planar_scene
from steadyload.runs.definition import load_study
from steadyload.runs.labels import Cases, load_labels
from steadyload.runs.results import load_manifest
from steadyload.runs.runner import run_study
from steadyload.studies.kit import Lab

SCENARIOS = [str(s) for s in Scenario]
SAMPLE = 60


@pytest.fixture(scope="module")
def benchmark():
    return load_benchmark(PLANAR)


# --- how it is drawn -----------------------------------------------------------------------------


@pytest.mark.parametrize("number", ITEM_CLASSES)
def test_planar_items_keep_the_depth_and_are_turned_in_the_plane(number):
    instance = make_instance(number, 1, seed=3, item_count=20, planar=True)
    wide = make_instance(number, 1, seed=3, item_count=20)
    pallet = ITEM_CLASSES[number].pallet
    assert [size[:2] for size in instance.sizes] == [size[:2] for size in wide.sizes]
    packed = generate([instance])
    assert len(packed) > 10
    turned = set()
    for layout in (found.layout for found in packed):
        assert not layout.lower[:, 2].any()
        assert (layout.upper[:, 2] == pallet.depth).all()
        sides = {tuple(sorted(size[:2])) for size in instance.sizes}
        assert {tuple(sorted(item.size[:2])) for item in layout.items} <= sides
        turned |= {item.size[:2] not in {s[:2] for s in instance.sizes} for item in layout.items}
        assert len(layout) <= MOST_ITEMS
        volumes = (layout.upper - layout.lower).prod(axis=1)
        assert layout.weights == pytest.approx(250e-6 * volumes)
    assert turned == {True, False}


def test_planar_draws_leave_the_plane_alone_and_stay_in_it():
    (layout, *_) = pack_instance(make_instance(2, 0, seed=3, planar=True), HEURISTICS[0])
    for scenario in Scenario:
        free = apply_scenario(layout, scenario, 5).mass_offsets
        drawn = apply_scenario(layout, scenario, 5, planar=True)
        assert (drawn.mass_offsets[:, :2] == free[:, :2]).all()
        assert not drawn.mass_offsets[:, 2].any()
        assert free[:, 2].any() == (scenario is not Scenario.S1)
        assert planar_scene(drawn).across == "depth"


def test_small_layouts_can_be_left_out():
    options = dataclasses.replace(PLANAR_OPTIONS, instances=1, item_counts={1: 3, 2: 3, 3: 8})
    layouts, cases = build(options)
    everything, _ = build(dataclasses.replace(options, fewest_items=1))
    counts = everything["weights"].map(len)
    assert counts.min() < 3
    assert set(layouts["layout"]) == set(everything["layout"][counts >= 3])
    assert min(len(layout) for _, layout in cases) == 3


def test_the_command_builds_a_planar_set(tmp_path, capsys):
    out = str(tmp_path / "set")
    assert main(["benchmark", "build", "--planar", "--instances", "1", "-o", out]) == 0
    assert "next: steadyload benchmark label" in capsys.readouterr().out
    manifest = load_benchmark(out).manifest
    assert (manifest["planar"], manifest["instances"]) == (True, 1)
    assert split_sizes(manifest) == PLANAR_OPTIONS.splits


# --- how it is named -----------------------------------------------------------------------------


def test_a_study_and_the_command_name_it_by_a_word(benchmark, tmp_path, capsys):
    (tmp_path / "s.toml").write_text(
        'benchmark = "validation"\nbenchmark_directory = "planar"\nmethods = ["sme"]\nlimit = 2\n'
    )
    run_study(load_study(tmp_path / "s.toml"), tmp_path / "run")
    chosen = benchmark.select("validation", limit=2)
    labels = load_labels(tmp_path / "run")
    assert labels.index.tolist() == list(zip(chosen["layout"], chosen["scenario"], strict=True))
    assert load_manifest(tmp_path / "run")["labels"]["set"] == "planar"
    assert main(["study", "report", str(tmp_path / "run")]) == 0
    assert "of part `planar validation` of" in (tmp_path / "run" / "report.md").read_text()
    capsys.readouterr()
    assert main(["benchmark", "info", "planar", "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == overview(benchmark)


def test_a_run_on_the_set_itself_names_it_too(benchmark, tmp_path):
    Lab(tmp_path, 0).judge(["sme"], Cases(benchmark, Part.VALIDATION, limit=2), folder="run")
    assert load_manifest(tmp_path / "run")["labels"]["set"] == "planar"
    few = benchmark.drawn(benchmark.select("validation", limit=2))
    Lab(tmp_path, 0).judge(["sme"], Cases(few), folder="drawn")
    assert "set" not in load_manifest(tmp_path / "drawn")["labels"]


def test_a_folder_of_that_name_is_told_from_the_word(tmp_path, monkeypatch):
    options = BuildOptions(instances=1, item_counts={1: 3, 2: 3, 3: 3})
    build_set(options, tmp_path / "planar")
    monkeypatch.chdir(tmp_path)
    own = load_benchmark("./planar")
    assert len(own.layouts) < len(load_benchmark("planar").layouts)
    (tmp_path / "s.toml").write_text(
        'benchmark = "all"\nbenchmark_directory = "./planar"\nmethods = ["sme"]\n'
    )
    assert load_study(tmp_path / "s.toml").benchmark_directory == tmp_path / "planar"

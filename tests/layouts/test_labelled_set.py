"""The labelled set that comes with the package."""

import json

import numpy as np
import pandas as pd
import pytest

from steadyload.labelling.label_rows import LABEL, LIMITS
from steadyload.labelling.labelling import JUDGES
from steadyload.layouts.benchmark import load_benchmark
from steadyload.layouts.benchmark.build import BuildOptions, draw_case
from steadyload.layouts.benchmark.dataset import SHIPPED
from steadyload.layouts.benchmark.splits import SIZES, assign_splits
from steadyload.layouts.model.scenarios import Scenario
from steadyload.layouts.packing.heuristics import HEURISTICS
from steadyload.layouts.packing.packing import make_instance, pack_instance
from steadyload.methods.contract.method import Status
from steadyload.methods.registry import make_method

SCENARIOS = [str(s) for s in Scenario]
REMADE = 12


@pytest.fixture(scope="module")
def benchmark():
    return load_benchmark()


def test_it_has_the_papers_size(benchmark):
    assert 9_200 < len(benchmark.layouts) < 10_200
    assert len(benchmark.cases) == 3 * len(benchmark.layouts)
    assert (benchmark.cases["status"] == Status.DONE).mean() > 0.999
    assert sum(file.stat().st_size for file in SHIPPED.glob("*.parquet")) < 10e6


@pytest.mark.deep("hashes of 28,551 layouts: 6 s")
def test_every_layout_is_distinct(benchmark):
    cases = benchmark.cases
    assert not cases.duplicated(["layout", "scenario"]).any()
    geometries, contents = set(), set()
    for name, scenario in zip(cases["layout"], cases["scenario"], strict=True):
        layout = benchmark.layout(name, scenario)
        geometries.add(layout.geometry_hash())
        contents.add(layout.content_hash())
        assert (scenario == "S1") == (not layout.mass_offsets.any())
    assert len(geometries) == len(benchmark.layouts)
    assert len(contents) == len(cases)


def test_no_item_list_lies_in_two_splits(benchmark):
    cases = benchmark.cases[benchmark.cases["status"] == Status.DONE]
    cases = cases.assign(split=cases["split"].fillna("left over"))
    splits = cases.groupby("instance")["split"].agg(set)
    for instance, found in splits.items():
        assert len(found - {"left over"}) <= 1, instance
        assert found == {"train"} or "train" not in found, instance
    for held_out in ("validation", "test"):
        own = {i for i, found in splits.items() if held_out in found}
        assert {i.split("_Instance")[0] for i in own} == {"Class_1", "Class_2", "Class_3"}


@pytest.mark.parametrize("scenario", SCENARIOS)
@pytest.mark.parametrize(
    ("part", "size"), [("validation", SIZES.validation), ("test", SIZES.test), ("test-300", 300)]
)
def test_held_out_parts_are_balanced(benchmark, part, size, scenario):
    cases = benchmark.select(part, scenarios=(scenario,))
    assert len(cases) == size
    assert cases["failing_step"].isna().sum() == size // 2


def test_splits_follow_from_the_labels(benchmark):
    classes = benchmark.layouts["item_class"]
    cases = benchmark.cases.join(classes, on="layout")
    again = assign_splits(cases, seed=benchmark.manifest["seed"])
    assert (again["split"].fillna("") == cases["split"].fillna("")).all()
    assert (again["rank"].fillna(-1) == cases["rank"].fillna(-1)).all()


def test_labels_fit_the_movements(benchmark):
    broken = 0
    for case in benchmark.cases[benchmark.cases["status"] == Status.DONE].itertuples():
        corner, angle = np.asarray(case.corner_last), np.asarray(case.angle_last)
        centre, turned = np.asarray(case.centre_most), np.asarray(case.angle_most)
        for label, moved in (
            (case.failing_step, np.maximum(corner, angle)),
            (case.failing_step_paper, np.maximum(centre, turned)),
        ):
            if (abs(moved - 10.0) < 1e-3).any():
                continue  # an item fell by exactly 10 cm; movements are rounded to thousandths
            first = int((moved > 10.0).argmax()) if (moved > 10.0).any() else None
            assert (pd.isna(label) and first is None) or label == first, case.layout
        beyond = (np.asarray(case.corner_most) > 19.999) | (turned > 19.999)
        # Where the simulation failed after the label was decided, the trace ends there.
        broken += len(corner) < case.item_count and not beyond[-1]
        assert len(corner) == case.item_count or not pd.isna(case.failing_step), case.layout
        assert len(case.margin) == len(case.moved) == len(corner)
    assert broken < 1e-3 * len(benchmark.cases)


def test_a_random_sample_is_remade_from_scratch(benchmark):
    """Packed, drawn and judged anew."""
    seed = benchmark.manifest["seed"]
    method, options = make_method(LABEL), BuildOptions(seed=seed)
    labelled = benchmark.cases[benchmark.cases["status"] == Status.DONE]
    sample = labelled.sample(REMADE, random_state=5)
    assert benchmark.manifest["instances"] == options.instances
    for case in sample.itertuples():
        heuristic, _, number, _, which, _, bin_number = case.layout[1:].split("_")
        items = options.item_counts.get(int(number))
        instance = make_instance(int(number), int(which), seed=seed, item_count=items)
        packed = pack_instance(instance, HEURISTICS[int(heuristic) - 1])[int(bin_number)]
        layout = draw_case(packed, Scenario(case.scenario), seed)
        assert packed.name == case.layout
        assert layout.content_hash() == benchmark.layout(case.layout, case.scenario).content_hash()
        said = method.judge(layout).failing_step
        assert (said is None) if pd.isna(case.failing_step) else said == case.failing_step


def test_every_judge_is_asked_of_all_held_out_cases(benchmark):
    held_out = benchmark.cases[benchmark.cases["split"].isin(("validation", "test"))]
    needed = set(zip(held_out["layout"], held_out["scenario"], strict=True))
    assert len(needed) == 3 * (SIZES.validation + SIZES.test)
    reasons = {str(make_method(judge.spec).spec): str(judge.reason) for judge in JUDGES}
    reasons |= {str(make_method(spec).spec): "limits" for spec in LIMITS}
    assert set(benchmark.opinions["judge"]) == set(reasons)
    for judge, own in benchmark.opinions.groupby("judge"):
        assert set(own["reason"]) == {reasons[judge]}
        asked = list(zip(own["layout"], own["scenario"], strict=True))
        assert len(asked) == len(needed)
        assert set(asked) == needed


def test_the_manifest_says_what_it_was_made_with():
    manifest = json.loads((SHIPPED / "manifest.json").read_text())
    for step in ("built_with", "labelled_with"):
        assert manifest[step]["git"]
        assert "dirty" not in manifest[step]["git"]
        assert manifest[step]["versions"]["numba"]

"""The labelled sets that come with the package: splits, labels, and what they were made with."""

import json
import re
from collections import namedtuple
from functools import cache
from itertools import combinations

import numpy as np
import pandas as pd
import pytest

from steadyload.labelling.building.build import PLANAR_OPTIONS, BuildOptions
from steadyload.labelling.building.splits import SIZES, assign_splits
from steadyload.labelling.label_rows import LABEL, LIMITS
from steadyload.labelling.labelling import JUDGES
from steadyload.layouts.benchmark import load_benchmark
from steadyload.layouts.benchmark.dataset import KEYS
from steadyload.layouts.benchmark.parts import CHOOSING, LISTS, PLANAR, SETS, SHIPPED
from steadyload.layouts.benchmark.tables import write_tables
from steadyload.layouts.model.question import Question
from steadyload.layouts.model.scenarios import Scenario, draw_case
from steadyload.layouts.packing.heuristics import HEURISTICS
from steadyload.layouts.packing.packing import (
    ITEM_CLASSES,
    MOST_ITEMS,
    make_instance,
    pack_instance,
)
from steadyload.methods.contract.method import Status
from steadyload.methods.registry import make_method
from steadyload.methods.simulation.scene import planar_scene
from steadyload.tuning import TuningError
from steadyload.tuning.cascade.fitted import FitOptions
from steadyload.tuning.cases import load_cases, own_part
from steadyload.tuning.options import SearchOptions

SCENARIOS = [str(s) for s in Scenario]
LARGE = None
"""The set that has no name of its own."""

Drawn = namedtuple("Drawn", "options sizes reasons sample")
"""How a set is built and split, why judges are asked of its held-out cases, and which sample of
it is remade.
"""

LIMIT_REASONS = {str(make_method(spec).spec): "limits" for spec in LIMITS}
DRAWN = {
    LARGE: Drawn(
        BuildOptions(), SIZES,
        {str(make_method(j.spec).spec): str(j.reason) for j in JUDGES} | LIMIT_REASONS,
        {"n": 12, "random_state": 5},
    ),
    PLANAR: Drawn(
        PLANAR_OPTIONS, PLANAR_OPTIONS.splits, LIMIT_REASONS, {"n": 8, "random_state": 2}
    ),
}  # fmt: skip
NAMES = {"large": LARGE, "planar": PLANAR}
by_name = pytest.mark.parametrize("name", NAMES.values(), ids=NAMES)


def held_out(benchmark):
    return benchmark.cases[benchmark.cases["split"].isin(("validation", "test"))]


def step_of(case):
    return None if pd.isna(case.failing_step) else case.failing_step


@cache
def geometries(name):
    """By hash, of all layouts of a set."""
    benchmark = load_benchmark(name)
    return {benchmark.layout(n, "S1").geometry_hash() for n in benchmark.layouts.index}


# --- how they are split and labelled --------------------------------------------------------------


@by_name
def test_no_item_list_lies_in_two_splits(name):
    cases = load_benchmark(name).cases
    cases = cases[cases["status"] == Status.DONE]
    cases = cases.assign(split=cases["split"].fillna("left over"))
    splits = cases.groupby("instance")["split"].agg(set)
    for instance, found in splits.items():
        assert len(found - {"left over"}) == 1, instance
        assert found == {"train"} or "train" not in found, instance
    for part in ("train", "validation", "test"):
        own = {i for i, found in splits.items() if part in found}
        assert {re.search(r"Class_(\d)", i)[1] for i in own} == set("123")


@pytest.mark.parametrize("scenario", SCENARIOS)
@pytest.mark.parametrize("part", ["validation", "test", "test-300"])
@by_name
def test_held_out_parts_are_half_stable(name, part, scenario):
    sizes = DRAWN[name].sizes
    cases = load_benchmark(name).select(part, scenarios=(scenario,))
    assert len(cases) == (300 if part == "test-300" else getattr(sizes, part))
    assert cases["failing_step"].isna().sum() == len(cases) // 2


@by_name
def test_splits_follow_from_the_labels(name):
    benchmark, sizes = load_benchmark(name), DRAWN[name].sizes
    assert benchmark.manifest["splits"] == sizes.stored()
    cases = benchmark.cases.join(benchmark.layouts["item_class"], on="layout")
    again = assign_splits(cases, seed=benchmark.manifest["seed"], sizes=sizes)
    assert (again["split"].fillna("") == cases["split"].fillna("")).all()
    assert (again["rank"].fillna(-1) == cases["rank"].fillna(-1)).all()


@by_name
def test_a_random_sample_is_remade_from_scratch(name):
    """Packed, drawn and judged anew."""
    benchmark, (options, _, _, sample) = load_benchmark(name), DRAWN[name]
    method, planar = make_method(LABEL), name == PLANAR
    assert benchmark.manifest["instances"] == options.instances
    assert benchmark.manifest["seed"] == options.seed
    labelled = benchmark.cases[benchmark.cases["status"] == Status.DONE]
    for case in labelled.sample(**sample).itertuples():
        heuristic, number, which, bin_number = map(int, re.findall(r"\d+", case.layout))
        instance = make_instance(
            number, which, seed=options.seed, item_count=options.item_counts.get(number),
            planar=planar,
        )  # fmt: skip
        packed = pack_instance(instance, HEURISTICS[heuristic - 1])[bin_number]
        layout = draw_case(packed, Scenario(case.scenario), options.seed, planar=planar)
        assert packed.name == case.layout
        assert layout.content_hash() == benchmark.layout(case.layout, case.scenario).content_hash()
        assert method.judge(layout).failing_step == step_of(case)


@by_name
def test_every_judge_is_asked_of_all_held_out_cases(name):
    benchmark, reasons = load_benchmark(name), DRAWN[name].reasons
    cases = held_out(benchmark)
    needed = set(zip(cases["layout"], cases["scenario"], strict=True))
    assert set(benchmark.opinions["judge"]) == set(reasons)
    for judge, own in benchmark.opinions.groupby("judge"):
        assert set(own["reason"]) == {reasons[judge]}
        asked = list(zip(own["layout"], own["scenario"], strict=True))
        assert len(asked) == len(needed)
        assert set(asked) == needed


@pytest.mark.parametrize("name", [LARGE, PLANAR, LISTS, CHOOSING])
def test_the_manifest_names_clean_commits_and_versions(name):
    manifest = json.loads(((SETS[name] if name else SHIPPED) / "manifest.json").read_text())
    for made in (manifest["built_with"], manifest["labelled_with"],
                 manifest.get("stands", manifest)["labelled_with"]):  # fmt: skip
        assert made["git"]
        assert "dirty" not in made["git"]
        assert made["versions"]["numba"]


@pytest.mark.parametrize(("name", "least"), [(LARGE, 0.999), (PLANAR, 0.999), (LISTS, 0.9995),
                                             (CHOOSING, 0.999)])  # fmt: skip
def test_almost_every_case_is_labelled(name, least):
    assert (load_benchmark(name).cases["status"] == Status.DONE).mean() > least


def test_no_list_and_no_geometry_is_in_two_sets():
    sets = {name: load_benchmark(name) for name in (LARGE, LISTS, CHOOSING)}
    for name in (LISTS, CHOOSING):
        assert len(geometries(name)) == len(sets[name].layouts)
    lists = {name: set(found.layouts["instance"]) for name, found in sets.items()}
    for one, other in combinations(sets, 2):
        assert not lists[one] & lists[other]
        assert not geometries(one) & geometries(other)


# --- the large one --------------------------------------------------------------------------------


def test_it_has_the_papers_size():
    benchmark = load_benchmark()
    assert 9_200 < len(benchmark.layouts) < 10_200
    assert len(benchmark.cases) == 3 * len(benchmark.layouts)
    assert sum(file.stat().st_size for file in SHIPPED.glob("*.parquet")) < 10e6


def test_every_layout_is_distinct():
    benchmark = load_benchmark()
    cases = benchmark.cases
    assert not cases.duplicated(["layout", "scenario"]).any()
    contents = set()
    for name, scenario in zip(cases["layout"], cases["scenario"], strict=True):
        layout = benchmark.layout(name, scenario)
        contents.add(layout.content_hash())
        assert (scenario == "S1") == (not layout.mass_offsets.any())
    assert len(geometries(LARGE)) == len(benchmark.layouts)
    assert len(contents) == len(cases)


def test_labels_fit_the_movements():
    benchmark, broken = load_benchmark(), 0
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


# --- the planar one -------------------------------------------------------------------------------


def test_every_case_is_planar_and_every_geometry_there_once():
    benchmark = load_benchmark(PLANAR)
    assert len(benchmark.layouts) > 900
    assert len(benchmark.cases) == 3 * len(benchmark.layouts)
    for name, scenario in zip(benchmark.cases["layout"], benchmark.cases["scenario"], strict=True):
        layout = benchmark.layout(name, scenario)
        assert planar_scene(layout).across == "depth", (name, scenario)
        assert PLANAR_OPTIONS.fewest_items <= len(layout) <= MOST_ITEMS
        assert (scenario == "S1") == (not layout.mass_offsets.any())
    assert len(geometries(PLANAR)) == len(benchmark.layouts)
    assert set(benchmark.layouts["item_class"]) == set(ITEM_CLASSES)
    assert sum(file.stat().st_size for file in SETS[PLANAR].iterdir()) < 500e3


@pytest.mark.parametrize("engine", ["chipmunk", "mujoco"])
def test_engines_in_the_plane_and_in_space_agree_with_the_labels(engine):
    """Of the whole validation split Chipmunk names 98.3 % of the labels, MuJoCo 98.1 %."""
    benchmark, method = load_benchmark(PLANAR), make_method(f"label@{engine}:frequency=480")
    same = [
        method.judge(benchmark.layout(case.layout, case.scenario)).failing_step == step_of(case)
        for case in benchmark.select("validation", limit=20).itertuples()
    ]
    assert len(same) == 60
    assert np.mean(same) > 0.9


# --- the one of many item lists -------------------------------------------------------------------

PER_CLASS, MOST_OF_LIST, MOST_LAYOUTS = 30, 40, 30


@pytest.fixture(scope="module")
def lists():
    return load_benchmark(LISTS)


def test_thirty_lists_a_class_with_at_most_forty_balanced_cases_each(lists):
    cases = lists.cases
    assert set(cases["split"].dropna()) == {"test"}
    test = cases[cases["split"] == "test"]
    assert test.groupby("instance").size().max() <= MOST_OF_LIST
    classes = test.drop_duplicates("instance")["instance"].str.split("_").str[1]
    assert classes.value_counts().to_dict() == {"1": PER_CLASS, "2": PER_CLASS, "3": PER_CLASS}
    stable = test["failing_step"].isna()
    assert stable.groupby(test["scenario"]).mean().eq(0.5).all()
    of_a_list = stable.groupby([test["instance"], test["scenario"]])
    assert len(of_a_list) == 3 * 3 * PER_CLASS  # every list is asked in every scenario
    assert of_a_list.sum().between(2, MOST_OF_LIST // 6).all()
    assert (of_a_list.size() - of_a_list.sum()).between(2, MOST_OF_LIST // 6).all()
    assert lists.layouts.groupby("instance").size().max() == MOST_LAYOUTS
    assert len(lists.layouts) == 3 * PER_CLASS * MOST_LAYOUTS


@pytest.mark.parametrize("limit", [60, 300])
def test_first_ranks_are_balanced_and_of_many_lists(lists, limit):
    chosen = lists.select("test", limit=limit)
    assert chosen.groupby("scenario").size().eq(limit).all()
    assert chosen["failing_step"].isna().groupby(chosen["scenario"]).mean().eq(0.5).all()
    assert chosen["instance"].nunique() >= min(PER_CLASS * 3, limit // 2)


def test_some_labels_are_the_reference_asked_anew(lists):
    judge = make_method("label@reference")
    labelled = lists.cases[lists.cases["status"] == Status.DONE]
    chosen = np.random.default_rng(4).choice(len(labelled), 5, replace=False)
    for case in labelled.iloc[chosen].itertuples():
        verdict = judge.judge(lists.layout(case.layout, case.scenario))
        assert verdict.failing_step == step_of(case), (case.layout, case.scenario)


def test_whatever_fails_within_the_time_does_not_stand_longer(lists):
    """The second question has the same thresholds and more time: it never names a later step."""
    test = lists.cases[lists.cases["split"] == "test"]
    labels = lists.labels_on(Question.STANDS)
    both = test.merge(labels, on=KEYS, suffixes=("", "_stands"))
    assert len(both) == len(labels) == len(test)
    done = both[both["status_stands"] == Status.DONE]
    assert len(done) > 0.99 * len(both)
    within, stands = (
        done[c].fillna(done["item_count"]) for c in ("failing_step", "failing_step_stands")
    )
    assert (stands <= within).all()
    assert 0.02 < (stands < within).mean() < 0.2


# --- the one that searches and fits choose on -----------------------------------------------------

PARTS, LISTS_PER_CLASS, CASES_OF_LIST = ("search", "fitting"), 10, 36


@pytest.fixture(scope="module")
def choosing():
    return load_benchmark(CHOOSING)


@pytest.mark.parametrize("part", PARTS)
def test_each_part_has_ten_lists_a_class_and_is_half_stable(choosing, part):
    cases = choosing.select(part)
    classes = cases.drop_duplicates("instance")["instance"].str.split("_").str[1]
    assert classes.value_counts().to_dict() == dict.fromkeys("123", LISTS_PER_CLASS)
    assert cases.groupby("instance").size().max() <= CASES_OF_LIST
    stable = cases["failing_step"].isna()
    assert stable.groupby(cases["scenario"]).mean().eq(0.5).all()
    first = choosing.select(part, limit=60)
    assert first["failing_step"].isna().groupby(first["scenario"]).mean().eq(0.5).all()


def test_no_list_is_in_two_parts_and_almost_every_case_has_both_labels(choosing):
    one, other = (set(choosing.select(part)["instance"]) for part in PARTS)
    assert not one & other
    chosen = choosing.cases["split"].notna().sum()
    assert (choosing.labels_on(Question.STANDS)["status"] == Status.DONE).sum() > 0.99 * chosen


def test_a_search_and_a_fit_take_their_own_part_of_every_set(choosing):
    searched = SearchOptions.on("mujoco", generations=1, data=("real",), limit=6).source
    (fitted, real) = FitOptions("mujoco", data=("real",), limit=6).sources()
    assert (searched.part, searched.directory) == ("search", CHOOSING)
    assert (fitted.part, fitted.directory) == ("fitting", CHOOSING)
    assert (real.part, real.directory) == ("validation", "real")
    lists = {case.instance for case in load_cases(searched)}
    assert lists & set(choosing.select("search")["instance"])
    validation = load_benchmark("real").select("validation", limit=6)
    assert set(validation["instance"]) <= lists
    assert not lists & {case.instance for case in load_cases(fitted)}
    planar = SearchOptions.on("chipmunk", generations=1).source
    assert (planar.part, planar.directory) == ("validation", "planar")


def test_a_set_that_is_a_test_alone_is_refused():
    message = "lists: is split, and has no part fitting or validation; allowed: a set that has one"
    with pytest.raises(TuningError, match=message):
        FitOptions("mujoco", directory=LISTS).sources()
    with pytest.raises(TuningError, match="has no part search or validation"):
        SearchOptions.on("mujoco", benchmark=LISTS, generations=1)


def test_all_of_a_set_that_is_not_split_counts(tmp_path):
    benchmark = load_benchmark("planar")
    cases = benchmark.cases.drop(columns="instance").assign(split=None, rank=None)
    cases["split"] = cases["split"].astype(object)
    write_tables(tmp_path, benchmark.layouts.reset_index(), cases, benchmark.opinions, {})
    assert own_part(str(tmp_path), "fitting") == "train"

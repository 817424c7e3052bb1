"""Labelling a folder: shards, splits, further judges."""

import dataclasses
import multiprocessing
import os
import shutil
import signal

import numpy as np
import pandas as pd
import pytest

from steadyload.labelling import labelling
from steadyload.labelling.building.build import LISTS_OPTIONS, BuildOptions, build
from steadyload.labelling.building.splits import SplitSizes
from steadyload.labelling.label_rows import (
    LABEL,
    TRACES,
    TraceUnit,
    lost_row,
)
from steadyload.labelling.label_stands import SPEC, label_stands
from steadyload.labelling.labelling import (
    FurtherMethod,
    build_set,
    label_set,
    split_sizes,
    write_unlabelled,
)
from steadyload.layouts.benchmark import BenchmarkError, load_benchmark
from steadyload.layouts.benchmark.confidence import Reason
from steadyload.layouts.benchmark.dataset import row_of
from steadyload.layouts.benchmark.tables import (
    UNLABELLED,
    DamagedSetError,
    as_parquet,
    read_parquet,
    write_tables,
)
from steadyload.layouts.model.question import Question
from steadyload.layouts.model.scenarios import Scenario
from steadyload.layouts.packing.packing import random_layouts
from steadyload.methods.contract.method import Status
from steadyload.methods.registry import make_method

SIZES = SplitSizes(test=4, validation=2, test_lists=2, validation_lists=1)
JUDGES = (
    FurtherMethod(Reason.ENGINE, "label@mujoco:frequency=240"),
    FurtherMethod(Reason.MODEL, "label@mujoco:friction=0.4,frequency=240"),
)


@pytest.fixture(scope="module")
def unlabelled(tmp_path_factory):
    """24 layouts of at most six items, two an item list, with sizes of splits."""
    layouts = [lay.first(6) for lay in random_layouts(24, seed=5, scenario=Scenario.S1)]
    rows = [
        row_of(lay, f"Class_1_Instance_{k // 2}", 1, (lay.name,)) for k, lay in enumerate(layouts)
    ]
    cases = [("S1", lay) for lay in layouts]
    manifest = {"seed": 1, "splits": dataclasses.asdict(SIZES)}
    folder = tmp_path_factory.mktemp("labelling") / "set"
    write_unlabelled(folder, pd.DataFrame(rows), cases, manifest)
    return folder


@pytest.fixture
def folder(unlabelled, tmp_path):
    """A copy of the unlabelled set, to be changed."""
    return shutil.copytree(unlabelled, tmp_path / "set")


@pytest.fixture(scope="module")
def labelled_folder(unlabelled, tmp_path_factory):
    """The set with labels by the reference and its limits alone, to be read."""
    folder = shutil.copytree(unlabelled, tmp_path_factory.mktemp("labelled") / "set")
    label_set(folder, judges=())
    return folder


@pytest.fixture(scope="module")
def labelled(labelled_folder):
    """That set, read."""
    return load_benchmark(labelled_folder)


def label(folder, judges=JUDGES, **options):
    label_set(folder, judges=judges, **options)
    return load_benchmark(folder)


def test_labels_are_those_of_an_ordinary_judgement(labelled):
    found, method = labelled, make_method(LABEL)
    assert set(found.cases["failing_step"].isna()) == {True, False}
    for row in found.cases.itertuples():
        verdict = method.judge(found.layout(row.layout, row.scenario))
        said = None if pd.isna(row.failing_step) else int(row.failing_step)
        assert verdict.failing_step == said, row.layout
        if said is not None:
            assert max(row.corner_last[said], row.angle_last[said]) > 10.0
            assert row.moved[said] == verdict.moved_item
        steps = len(row.corner_last)
        assert steps == row.item_count or max(row.corner_last[-1], row.angle_last[-1]) > 20.0
        assert len(row.margin) == steps
        assert (np.array(row.corner_most) >= np.array(row.corner_last)).all()


def test_a_set_that_is_a_test_alone_is_labelled_and_judged_like_any_other(folder):
    found = label(folder, JUDGES[:1], sizes=SplitSizes(most_of_list=6))
    held = found.cases[found.cases["split"].notna()]
    assert set(held["split"]) == {"test"}
    assert held["failing_step"].isna().mean() == 0.5
    assert held.groupby("instance").size().max() <= 2  # one scenario: a stable, an unstable case
    asked = found.opinions[found.opinions["reason"] == str(Reason.ENGINE)]
    assert set(asked["layout"]) == set(held["layout"])
    assert split_sizes(found.manifest).most_of_list == 6


def test_further_lists_are_others_and_share_no_geometry_with_the_large_set(tmp_path):
    standard = dataclasses.replace(LISTS_OPTIONS, instances=1, most_layouts=4)
    build_set(standard, tmp_path)
    found, large = load_benchmark(tmp_path), load_benchmark()
    lists = set(found.layouts["instance"])
    assert lists == {f"Class_{c}_Instance_17" for c in (1, 2, 3)}
    assert not lists & set(large.layouts["instance"])
    assert found.layouts.groupby("instance").size().max() == 4
    assert len(found.cases) == 3 * len(found.layouts)
    assert split_sizes(found.manifest).most_of_list == 40

    def geometries(benchmark):
        return {benchmark.layout(n, "S1").geometry_hash() for n in benchmark.layouts.index}

    assert not geometries(found) & geometries(large)


def test_a_geometry_to_be_left_out_is_left_out():
    options = BuildOptions(instances=1, item_counts={1: 12, 2: 12, 3: 8})
    layouts, cases = build(options)
    [gone] = {layout.geometry_hash() for _, layout in cases if layout.name == layouts["layout"][0]}
    fewer, _ = build(options, apart_from={gone})
    assert len(fewer) == len(layouts) - 1
    assert layouts["layout"][0] not in set(fewer["layout"])


def test_further_judges_are_asked_of_validation_and_test_alone(folder):
    found = label(folder)
    asked = found.cases[found.cases["split"].isin(("validation", "test"))]
    keys = set(zip(asked["layout"], asked["scenario"], strict=True))
    assert len(keys) == 6
    for judge, own in found.opinions.groupby("judge"):
        assert set(zip(own["layout"], own["scenario"], strict=True)) == keys, judge
    mujoco = make_method(JUDGES[0].spec)
    own = found.opinions[found.opinions["judge"] == str(mujoco.spec)]
    for row in own.itertuples():
        step = mujoco.judge(found.layout(row.layout, row.scenario)).failing_step
        assert (step is None) if pd.isna(row.failing_step) else step == row.failing_step
    assert set(found.opinions["reason"]) == {"engine", "model", "limits"}
    limits = found.opinions[found.opinions["reason"] == "limits"]
    assert limits["judge"].nunique() == 4


def test_limits_are_those_of_an_ordinary_judgement(labelled):
    found = labelled
    for row in found.opinions.itertuples():
        verdict = make_method(row.judge).judge(found.layout(row.layout, row.scenario))
        step = None if pd.isna(row.failing_step) else int(row.failing_step)
        assert verdict.failing_step == step, (row.layout, row.judge)


def test_an_interrupted_run_goes_on(folder, monkeypatch):
    monkeypatch.setattr(labelling, "_SHARD", 8)
    first = label(folder, judges=())
    shards = sorted((folder / "traces").glob("*.parquet"))
    assert len(shards) == 3
    shards[0].unlink()
    shards[1].write_bytes(shards[1].read_bytes()[:50])
    kept, said = shards[2].stat().st_mtime_ns, []
    again = label(folder, judges=(), progress=lambda *where: said.append(where))
    assert said[0] == ("labels", 8, 24)
    assert shards[2].stat().st_mtime_ns == kept
    pd.testing.assert_frame_equal(first.cases, again.cases)


def test_killed_workers_change_no_label(folder, labelled, monkeypatch):
    monkeypatch.setattr(labelling, "_SHARD", 4)
    killed = set()

    def kill(what, done, total):
        alive = {worker.pid for worker in multiprocessing.active_children()} - killed
        if 0 < done < total and len(killed) < 2 and alive:
            killed.add(min(alive))
            os.kill(min(alive), signal.SIGKILL)

    disturbed = label(folder, judges=(), workers=2, progress=kill)
    assert killed
    pd.testing.assert_frame_equal(disturbed.cases, labelled.cases)


def test_sizes_of_splits_are_those_asked_for_then_those_of_the_manifest(folder):
    asked = SplitSizes(test=2, validation=2, test_lists=1, validation_lists=1)
    for sizes, expected in ((None, SIZES), (asked, asked), (None, asked)):
        found = label(folder, judges=(), sizes=sizes)
        counts = found.cases["split"].value_counts()
        assert (counts["test"], counts["validation"]) == (expected.test, expected.validation)
        assert split_sizes(found.manifest) == expected
    assert split_sizes({}) == SplitSizes()
    with pytest.raises(BenchmarkError, match=r"splits is .'tset': 4"):
        split_sizes({"splits": {"tset": 4}})


def test_a_case_that_crashes_has_no_label(tmp_path):
    (layout,) = random_layouts(1, seed=5)
    row = lost_row(Status.CRASHED, TraceUnit((("S1", layout),), {}), 0, "by SIGABRT")
    table = as_parquet(pd.DataFrame([row], columns=TRACES.names), TRACES)
    (tmp_path / "x.parquet").write_bytes(table)
    (found,) = read_parquet(tmp_path / "x.parquet", TRACES).itertuples()
    assert (found.layout, found.status, found.reason) == (layout.name, "crashed", "by SIGABRT")
    assert pd.isna(found.failing_step)


def test_a_case_beyond_its_hard_limit_has_no_label(tmp_path, monkeypatch):
    monkeypatch.setattr(labelling, "CASE_SECONDS", 1e-6)
    (layout,) = random_layouts(1, seed=5)
    rows = pd.DataFrame([row_of(layout, "Class_1_Instance_0", 1, (layout.name,))])
    write_unlabelled(tmp_path / "set", rows, [("S1", layout)], {"seed": 1})
    (found,) = labelling._traced(tmp_path / "set", 1, lambda *_: None).itertuples()
    assert found.status == "timeout"
    assert found.reason.startswith("no answer within 1e-0")
    assert pd.isna(found.failing_step)


@pytest.mark.usefixtures("outside")
def test_a_further_method_that_hangs_ends_no_labelling(tmp_path, monkeypatch):
    monkeypatch.setattr(labelling, "CASE_SECONDS", 3.0)
    layouts = random_layouts(3, seed=5)
    rows = [row_of(lay, f"Class_1_Instance_{k}", 1, (lay.name,)) for k, lay in enumerate(layouts)]
    cases = [("S1", lay) for lay in layouts]
    write_unlabelled(tmp_path / "set", pd.DataFrame(rows), cases, {"seed": 1})
    found = load_benchmark(tmp_path / "set")
    done = found.cases.drop(columns="instance").assign(status="done", split="test", rank=range(3))
    write_tables(
        tmp_path / "set", found.layouts.reset_index(), done, found.opinions, found.manifest
    )
    hanging = (FurtherMethod(Reason.ENGINE, "harmful:harm=hang"),)
    said = labelling._asked(tmp_path / "set", "test", hanging, 1, lambda *_: None)
    assert said.set_index("layout")["status"].to_dict() == {
        "layout-0000": "done", "layout-0001": "done", "layout-0002": "timeout",
    }  # fmt: skip


def test_a_built_set_is_not_overwritten(tmp_path):
    options = BuildOptions(instances=1, item_counts={1: 3, 2: 3, 3: 3})
    count = build_set(options, tmp_path / "set")
    found = load_benchmark(tmp_path / "set")
    assert count == len(found.cases) == 3 * len(found.layouts)
    assert set(found.cases["status"]) == {UNLABELLED}
    with pytest.raises(BenchmarkError, match="already holds"):
        build_set(options, tmp_path / "set")
    with pytest.raises(BenchmarkError, match="no labelled case"):
        found.select("test")


def test_what_is_stored_is_what_is_judged(tmp_path):
    options = BuildOptions(instances=1, item_counts={1: 3, 2: 3, 3: 3})
    layouts, cases = build(options)
    write_unlabelled(tmp_path / "set", layouts, cases, {"seed": 1})
    found = load_benchmark(tmp_path / "set")
    for scenario, layout in cases:
        assert found.layout(layout.name, scenario).content_hash() == layout.content_hash()
    hashes = [layout.geometry_hash() for scenario, layout in cases if scenario == "S1"]
    assert len(set(hashes)) == len(hashes) == len(layouts)


def test_labels_follow_the_criterion(labelled):
    """The other criterion looks at centres, at any sample."""
    found = labelled
    method = make_method(f"{LABEL}:criterion=paper,early_exit=0")
    for row in found.cases.itertuples():
        step = method.judge(found.layout(row.layout, row.scenario)).failing_step
        said = row.failing_step_paper
        assert (step is None) if pd.isna(said) else step == said, row.layout


def test_labels_of_the_other_question_are_those_of_an_ordinary_judgement(
    labelled, labelled_folder, tmp_path
):
    folder, said = shutil.copytree(labelled_folder, tmp_path / "set"), []
    count = label_stands(folder, training_cases=6, progress=lambda *where: said.append(where))
    found, method = load_benchmark(folder), make_method(SPEC)
    held_out = found.cases["split"].isin(("validation", "test")).sum()
    training = (found.cases["split"] == "train").sum()
    assert count == len(found.further_labels) == held_out + min(2, training)
    assert said[-1][0] == "train"
    for row in found.further_labels.itertuples():
        verdict = method.judge(found.layout(row.layout, row.scenario))
        step = None if pd.isna(row.failing_step) else int(row.failing_step)
        assert (str(verdict.status), verdict.failing_step) == (row.status, step)
    chosen = found.select("test", question=Question.STANDS).set_index(["layout", "scenario"])
    known = found.further_labels.set_index(["layout", "scenario"])["failing_step"]
    pd.testing.assert_series_equal(chosen["failing_step"], known.loc[chosen.index])
    pd.testing.assert_frame_equal(found.select("test"), labelled.select("test"))
    with pytest.raises(BenchmarkError, match="of test for the question stands"):
        labelled.select("test", question=Question.STANDS)


def test_labels_of_the_other_question_go_with_the_cases_that_they_are_of(labelled_folder, tmp_path):
    folder = shutil.copytree(labelled_folder, tmp_path / "set")
    label_stands(folder, training_cases=0)
    label_set(folder, judges=())
    assert load_benchmark(folder).further_labels.empty
    label_stands(folder, training_cases=0)
    damaged = folder / "labels.parquet"
    damaged.write_bytes(damaged.read_bytes()[:-8] + b"01234567")
    with pytest.raises(DamagedSetError, match=r"labels\.parquet"):
        load_benchmark(folder)


def test_a_set_without_splits_has_no_labels_of_the_other_question(folder):
    with pytest.raises(BenchmarkError, match="no case is in a split"):
        label_stands(folder)

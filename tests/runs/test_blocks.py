"""Studies whose layouts are judged in blocks come to the rows of those that judge one by one."""

import json
from dataclasses import replace

import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pytest
from verdict_tables import verdicts

from steadyload.layouts.formats import Format, read_written, write_layouts
from steadyload.layouts.model.batch import LayoutBatch
from steadyload.layouts.model.layout import replace_items
from steadyload.layouts.packing.packing import random_layouts
from steadyload.methods import make_method
from steadyload.runs import blocks
from steadyload.runs.blocks import block_unit, blocks_of, judge_block
from steadyload.runs.box_ids import with_box_ids
from steadyload.runs.definition import StudyDefinition, StudyError
from steadyload.runs.pool import PartLimit, Processes
from steadyload.runs.results import LAYOUTS_FILE, kept_layouts, load_results
from steadyload.runs.runner import run_study
from steadyload.runs.units import OtherCodeError, hard_limit, made_now, timed_out_row
from steadyload.studies.report.comparing import compare

BAD = "layout-0002"
ONE_BY_ONE = {"shard_size": 12}
"""A study that states the size of its shards judges one layout after the other."""


def study_of(*methods, generated=40, **values):
    return StudyDefinition("many", methods, generated=generated, seed=20, **values)


@pytest.fixture(params=[10_000, 7])
def size(request, monkeypatch):
    """Layouts of a block."""
    monkeypatch.setattr(blocks, "BLOCK_LAYOUTS", request.param)
    return request.param


METHODS = [
    ("sme",), ("fbs", "pbs0.7"), ("equilibrium", "simulation@mujoco:frequency=60"),
]  # fmt: skip


@pytest.mark.parametrize("methods", METHODS)
@pytest.mark.parametrize("repetitions", [1, 2])
def test_rows_are_those_of_judging_one_by_one(tmp_path, size, methods, repetitions):
    study = study_of(*methods, generated=20, repetitions=repetitions)
    assert run_study(study, tmp_path / "blocks") == 20 * repetitions * len(methods)
    run_study(replace(study, **ONE_BY_ONE), tmp_path / "rows")
    pd.testing.assert_frame_equal(verdicts(tmp_path / "blocks"), verdicts(tmp_path / "rows"))
    assert (load_results(tmp_path / "blocks")["cpu_total"] > 0.0).all()
    groups = pq.read_metadata(tmp_path / "blocks" / LAYOUTS_FILE).num_row_groups
    assert groups == -(-20 // size)
    first, second = (compare(tmp_path / name).rows for name in ("blocks", "rows"))
    assert list(first["fully_stable"]) == list(second["fully_stable"])


@pytest.mark.parametrize("kind", [Format.PARQUET, Format.NATIVE])
def test_blocks_depend_on_the_layouts_alone(tmp_path, size, kind):
    layouts, prints = random_layouts(20, seed=2), set()
    for parts in ((20,), (3, 17), (7, 7, 6), (1,) * 20):
        ends = np.cumsum(parts)
        files = [tmp_path / f"{len(parts)}-{k}" for k in range(len(parts))]
        for file, end, count in zip(files, ends, parts, strict=True):
            write_layouts(file, layouts[end - count : end], kind)
        study = StudyDefinition("cut", ("sme",), files=tuple(files))
        found = list(blocks_of(study.batches()))
        assert [len(block.batch) for block in found] == [
            min(size, 20 - k) for k in range(0, 20, size)
        ]
        hashes = [one for block in found for one in block.batch.content_hashes()]
        assert hashes == [layout.content_hash() for layout in layouts]
        prints.add(tuple(block.fingerprint for block in found))
    assert len(prints) == 1


@pytest.mark.parametrize("items", [1, 30, 10**6])
def test_a_block_has_a_bounded_number_of_items(monkeypatch, items):
    monkeypatch.setattr(blocks, "BLOCK_ITEMS", items)
    layouts = random_layouts(25, seed=2)
    for entries in (layouts, [LayoutBatch.of(layouts)]):
        found = list(blocks_of(entries))
        assert sum(len(block.batch) for block in found) == 25
        assert all(len(b.batch) == 1 or len(b.batch.weights) <= items for b in found)
    assert len(found) == (1 if items > 1000 else 25 if items == 1 else len(found))


def test_the_first_layouts_are_judged_alone(tmp_path):
    write_layouts(tmp_path / "a", random_layouts(9, seed=2), Format.PARQUET)
    study = StudyDefinition("few", ("sme",), files=(tmp_path / "a",), limit=4)
    assert run_study(study, tmp_path / "run") == 4
    twice = StudyDefinition("few", ("sme",), files=(tmp_path / "a", tmp_path / "a"))
    with pytest.raises(StudyError, match="'layout-0000' stands in two files"):
        run_study(twice, tmp_path / "other")
    assert not list((tmp_path / "other").glob("*.parquet"))


def test_an_interrupted_run_goes_on_to_the_same_table(tmp_path, monkeypatch):
    monkeypatch.setattr(blocks, "BLOCK_LAYOUTS", 7)
    study = study_of("sme", "fbs", "simulation@mujoco:frequency=60", generated=20)
    seen = []

    def stop_at(stop):
        def interrupt(done, total):
            seen.append((done, total))
            if done == stop:
                raise KeyboardInterrupt

        return interrupt

    for stop in (14, 40, 52):  # in the blocks of one method, at their end, and after them
        with pytest.raises(KeyboardInterrupt):
            run_study(study, tmp_path / "run", progress=stop_at(stop))
        assert len(load_results(tmp_path / "run")) == stop
    shard = next((tmp_path / "run" / "results").glob("*.parquet"))
    lost = pq.read_metadata(shard).num_rows
    shard.unlink()
    assert run_study(study, tmp_path / "run", progress=stop_at(None)) == 60 - 52 + lost
    run_study(study, tmp_path / "calm")
    assert seen[-1] == (60, 60)
    pd.testing.assert_frame_equal(verdicts(tmp_path / "run"), verdicts(tmp_path / "calm"))
    assert run_study(study, tmp_path / "run") == 0
    assert run_study(study, tmp_path / "run", rerun=True) == 60


def test_a_damaged_copy_is_noticed_and_made_again(tmp_path):
    study, run = study_of("sme"), tmp_path / "run"
    run_study(study, run)
    copy = run / LAYOUTS_FILE
    content = copy.read_bytes()
    copy.write_bytes(content[:-20] + b"x" * 20)
    with pytest.raises(ValueError, match=r"layouts\.parquet: cannot be read, it is damaged"):
        kept_layouts(run)
    assert run_study(study, run) == 0
    assert copy.read_bytes() == content


def test_ids_and_loads_are_kept_with_the_layouts(tmp_path):
    layouts = [
        replace_items(
            layout,
            tuple(
                replace(item, name=f"box {item.sequence}", max_load=9.0 * k if k % 2 else None)
                for item in layout.items
            ),
        )
        for k, layout in enumerate(random_layouts(12, seed=20))
    ]
    write_layouts(tmp_path / "a.json", layouts, Format.NATIVE)
    study = StudyDefinition("ids", ("fbs",), files=(tmp_path / "a.json",))
    run_study(study, tmp_path / "run")
    again = list(read_written(kept_layouts(tmp_path / "run")))
    assert [layout.items for layout in again] == [layout.items for layout in layouts]
    rows = with_box_ids(load_results(tmp_path / "run"), tmp_path / "run")
    failed = rows[rows["failing_step"].notna()]
    assert len(failed)
    assert (failed["failing_box"] == "box " + failed["failing_step"].astype(str)).all()


def test_what_is_refused_stands_in_the_manifest(tmp_path):
    write_layouts(tmp_path / "a.json", random_layouts(3, seed=2), Format.NATIVE)
    content = json.loads((tmp_path / "a.json").read_text())
    content["layouts"][1]["items"][0]["weight"] = -1
    (tmp_path / "a.json").write_text(json.dumps(content))
    study = StudyDefinition("bad", ("sme",), files=(tmp_path / "a.json",))
    assert run_study(study, tmp_path / "run") == 2
    told = json.loads((tmp_path / "run" / "manifest.json").read_text())
    assert (told["layouts"], told["refused"]["count"]) == (2, 1)
    assert told["refused"]["first"][0].startswith('a.json: layout "layout-0001": item 0: weight')


@pytest.mark.parametrize("name", ["version of method", "numpy"])
def test_a_block_is_judged_by_the_code_that_it_states_alone(tmp_path, name):
    study, made = study_of("sme"), made_now([make_method("sme")])["sme"]
    blocks.write_copy(tmp_path / "a.parquet", list(blocks_of(study.batches())))
    [block] = blocks_of(study.batches())
    unit = block_unit(study, "sme", made, tmp_path / "a.parquet", 0, block)
    assert len(list(judge_block(unit))) == 1
    told = rf"would judge by {name} .* instead of 0;"
    with pytest.raises(OtherCodeError, match=told):
        judge_block(replace(unit, made_by={**made, name: "0"}))


@pytest.mark.usefixtures("outside")
def test_a_layout_that_ends_the_process_costs_one_row(tmp_path):
    study = study_of("harmful_batches:harm=abort", "fbs", generated=6)
    assert run_study(study, tmp_path / "run", workers=1) == 12
    frame = load_results(tmp_path / "run")
    (crashed,) = frame[frame["status"] != "done"].itertuples()
    assert (crashed.layout, crashed.status) == (BAD, "crashed")
    assert crashed.reason == "its process ended by SIGABRT, the second in a row"


@pytest.mark.usefixtures("outside")
def test_a_layout_that_hangs_costs_one_row(tmp_path):
    study = study_of("harmful_batches:harm=hang", generated=4)
    limit = PartLimit(2.0, timed_out_row)
    assert run_study(study, tmp_path / "run", workers=1, limit=limit) == 4
    status = load_results(tmp_path / "run").set_index("layout")["status"]
    assert status.to_dict() == {k: "timeout" if k == BAD else "done" for k in status.index}


def test_a_failure_within_a_batch_is_a_row(tmp_path, monkeypatch):
    method = type(make_method("sme"))
    whole = method._judge

    def fails(self, layout, watch):
        return 1 / 0 if layout.name == BAD else whole(self, layout, watch)

    monkeypatch.setattr(method, "_judge", fails)
    monkeypatch.setattr(method, "evaluate", lambda self, batch: 1 / 0)
    run_study(study_of("sme", generated=4), tmp_path / "run")
    found = load_results(tmp_path / "run").set_index("layout")
    assert found["status"].to_dict() == {k: "error" if k == BAD else "done" for k in found.index}
    assert found.loc[BAD, "reason"] == "ZeroDivisionError: division by zero"


@pytest.mark.parametrize("shares", [True, False])
def test_workers_read_the_file_or_are_handed_the_rows(tmp_path, monkeypatch, shares):
    study = study_of("sme", "fbs", generated=20, timeout=50.0)
    with Processes(2) as executor:
        monkeypatch.setattr(executor, "shares_files", shares)
        run_study(study, tmp_path / "run", workers=executor, limit=hard_limit(50.0))
    run_study(study, tmp_path / "calm")
    pd.testing.assert_frame_equal(verdicts(tmp_path / "run"), verdicts(tmp_path / "calm"))

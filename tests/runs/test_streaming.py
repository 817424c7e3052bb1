"""Studies of any number of rows: what is held at a time does not grow with them."""

import gc
import json

import numpy as np
import pandas as pd
import pytest

from steadyload.layouts.formats import (
    Format,
    read_layouts,
    read_written,
    write_layouts,
)
from steadyload.layouts.model.layout import Layout, LayoutError
from steadyload.layouts.packing.packing import random_layouts
from steadyload.reports.pages.writing import write_page
from steadyload.runs.definition import StudyDefinition, StudyError
from steadyload.runs.results import KEYS, ResultsError, each_shard, load_results
from steadyload.runs.runner import run_study
from steadyload.studies.kit import Lab
from steadyload.studies.scale.many import write_many
from steadyload.studies.scale.measuring import Size, measured
from steadyload.studies.scale.study import Scale


def layouts_in_memory():
    # Not by isinstance: some objects of other packages warn when they are asked for their class.
    return sum(type(thing) is Layout for thing in gc.get_objects())


def test_a_study_holds_no_more_layouts_than_it_is_at(tmp_path):
    study = StudyDefinition("many", ("fbs", "sme"), generated=120, seed=1, shard_size=4)
    held = []

    def count(done, total):
        if done % 80 == 0:
            held.append(layouts_in_memory())

    before = layouts_in_memory()
    assert run_study(study, tmp_path / "run", progress=count) == 240
    assert len(held) == 4
    assert max(held) - before <= 2 * study.shard_size


def test_units_come_as_they_are_asked_for(tmp_path):
    """All methods judge the first cases before the next: an interrupted study can be compared."""
    study = StudyDefinition("many", ("fbs", "sme"), generated=6, seed=1, shard_size=2)

    def interrupt(done, total):
        if done == 8:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run_study(study, tmp_path / "run", progress=interrupt)
    judged = load_results(tmp_path / "run").groupby("method")["layout"].agg(set)
    assert judged["fbs"] == judged["sme"] == {f"layout-000{k}" for k in range(4)}
    assert run_study(study, tmp_path / "run") == 4


def test_layouts_that_were_written_are_read_in_turn(tmp_path):
    file, layouts = tmp_path / "layouts.json", random_layouts(4, seed=2)
    write_layouts(file, iter(layouts), Format.NATIVE)
    # As json.dump writes it, and as older run folders hold it.
    assert file.read_text() == json.dumps(json.loads(file.read_text()), indent=1) + "\n"
    for found in (read_layouts(file), list(read_written(file))):
        assert [(lay.name, lay.items) for lay in found] == [
            (lay.name, lay.items) for lay in layouts
        ]
    (one,) = read_written(file, {"layout-0002"})
    assert one.items == layouts[2].items
    write_layouts(tmp_path / "none.json", [], Format.NATIVE)
    assert list(read_written(tmp_path / "none.json")) == []


@pytest.mark.parametrize("keep", [0, 100, 1000, -1, -4, -5])
def test_a_cut_off_file_is_refused(tmp_path, keep):
    file = tmp_path / "layouts.json"
    write_layouts(file, random_layouts(2, seed=2), Format.NATIVE)
    file.write_text(file.read_text()[:keep])
    with pytest.raises(LayoutError, match=r"layouts\.json: .* cut off"):
        list(read_written(file))


def test_a_name_that_stands_in_two_files_is_refused_before_anything_is_judged(tmp_path):
    for name in ("a.json", "b.json"):
        write_layouts(tmp_path / name, random_layouts(2, seed=2), Format.NATIVE)
    study = StudyDefinition("twice", ("fbs",), files=(tmp_path / "a.json", tmp_path / "b.json"))
    with pytest.raises(StudyError, match="'layout-0000' stands in two files"):
        run_study(study, tmp_path / "run")
    assert not list((tmp_path / "run").glob("*.json"))
    (tmp_path / "b.json").unlink()
    with pytest.raises(StudyError, match=r"b\.json: No such file"):
        run_study(study, tmp_path / "run")
    assert run_study(StudyDefinition("once", ("fbs",), generated=1), tmp_path / "run") == 1


def test_results_can_be_read_by_column_and_by_shard(tmp_path):
    study = StudyDefinition("small", ("fbs", "sme"), generated=5, seed=1, shard_size=2)
    run_study(study, tmp_path / "run")
    rows = load_results(tmp_path / "run")
    some = load_results(tmp_path / "run", [*KEYS, "score"])
    pd.testing.assert_frame_equal(some, rows[[*KEYS, "score"]])
    fewer = load_results(tmp_path / "run", ["score", "method"])
    pd.testing.assert_frame_equal(fewer, rows[["score", "method"]])
    shards = list(each_shard(tmp_path / "run"))
    assert [len(shard) for shard in shards] == [2, 2, 2, 2, 1, 1]
    together = pd.concat(shards).sort_values(KEYS, ignore_index=True)
    pd.testing.assert_frame_equal(together, rows)
    with pytest.raises(ResultsError, match=r"no manifest\.json"):
        next(each_shard(tmp_path))


def test_what_a_study_needs_is_measured(tmp_path):
    lab = Lab(tmp_path / "work")
    found = measured([1000, 2000], lab)
    assert measured([1000, 2000], lab) == found
    _, point = found.points
    assert (point.rows, point.layouts) == (2000, 50)
    for step in (point.run, point.load, point.report):
        assert step.cpu > 0.0
        assert 10.0 < step.peak < 10_000.0
    text = write_page(Scale().page(found), tmp_path).read_text()
    assert f" {point.run.peak:.0f} |" in text
    assert f"2,000 rows take {point.run.peak:.0f} MiB" in " ".join(text.split())
    assert [judging.layouts for judging in found.by_layouts] == [1000, 2000]
    assert {judging.layouts for judging in found.by_workers} == {2000}
    for judging in (*found.by_layouts, *found.by_workers):
        assert judging.command > 0.0
        if judging.where != "serial":
            assert judging.judges > 0.0
            assert judging.worker_peak > 10.0
        assert judging.files == 5, "two shards, layouts, manifest and lock"
    assert [(one.method, one.threads) for one in found.by_threads] == [
        (method, threads) for method in ("sme", "equilibrium") for threads in (1, 2)
    ]
    assert all(one.wall > 0.0 for one in found.by_threads)
    assert found.simulated.alone > 0.5, "a simulation takes milliseconds"
    needed = found.simulated.command + found.simulated.judges
    assert needed == pytest.approx((1.0 + found.simulated.overhead) * found.simulated.alone)


def test_many_layouts_differ_and_are_those_of_as_many_lists(tmp_path):
    [file] = write_many(tmp_path, 4, 50, seed=3)
    layouts = read_layouts(file)
    assert len({layout.content_hash() for layout in layouts}) == 200
    assert len({layout.geometry_hash() for layout in layouts}) == 4
    again = write_many(tmp_path / "again", 4, 50, seed=3)
    assert again[0].read_bytes() == file.read_bytes()
    reach = max(np.abs(one.mass_offsets / one.sizes).max() for one in layouts)
    assert 0.05 < reach <= 0.1 + 0.01


def test_every_field_of_what_is_asked_changes_its_key():
    assert len({Size(80, 1).key, Size(2000, 50).key, Size(120, 1).key}) == 3

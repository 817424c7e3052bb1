"""Studies: definitions, resuming, equal rows from every executor."""

import dataclasses
import json
import re
import sys
from importlib import metadata
from pathlib import Path

import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from verdict_tables import verdicts

from steadyload.atomic import manifest_text
from steadyload.engines.registry import ENGINES, EngineEntry, installed_versions
from steadyload.engines.world import EngineNotInstalledError
from steadyload.layouts.formats import Format, write_layouts
from steadyload.layouts.model.layout import LayoutError
from steadyload.layouts.packing.packing import random_layouts
from steadyload.methods import Status
from steadyload.methods.contract.method import judge
from steadyload.methods.registry import make_method
from steadyload.runs import runner
from steadyload.runs.definition import StudyDefinition, StudyError, load_study
from steadyload.runs.kept_only import NotKeptError, kept_only
from steadyload.runs.results import (
    COLUMNS,
    ROWS,
    SCHEMA,
    ResultsError,
    each_shard,
    load_manifest,
    load_results,
)
from steadyload.runs.runner import run_study
from steadyload.runs.units import OtherCodeError, Unit, judge_unit, made_now, usual_size

STUDY = """
name = "small"
layouts = ["layouts.json"]
scenarios = ["S1", "S2b"]
seed = 3
shard_size = 2
methods = ["fbs", "sme", "simulation@mujoco:frequency=90"]
"""


@pytest.fixture
def study_file(tmp_path, stack):
    layouts = [stack(0.0, 3.0).renamed("a"), stack(0.0, 6.0, 0.0).renamed("b"), stack(0.0)]
    write_layouts(tmp_path / "layouts.json", layouts, Format.NATIVE)
    (tmp_path / "study.toml").write_text(STUDY)
    return tmp_path / "study.toml"


def test_a_study_gives_one_row_per_case_and_method(study_file, tmp_path):
    seen = []
    computed = run_study(
        load_study(study_file), tmp_path / "run", progress=lambda *at: seen.append(at)
    )
    frame = load_results(tmp_path / "run")
    assert computed == len(frame) == 3 * 2 * 3
    assert list(frame.columns) == list(COLUMNS)
    assert seen[0] == (0, 18)
    assert seen[-1] == (18, 18)
    fbs = frame[(frame["method"] == "fbs") & (frame["scenario"] == "S1")].set_index("layout")
    assert fbs["failing_step"].isna().to_dict() == {"a": False, "b": False, "stack": True}
    assert fbs["score"].to_dict() == {"a": 0.5, "b": 1 / 3, "stack": 1.0}
    assert (frame["status"] == "done").all()
    manifest = load_manifest(tmp_path / "run")
    assert manifest["finished"]
    assert manifest["study"]["seed"] == 3
    assert str(tmp_path) not in (tmp_path / "run" / "manifest.json").read_text()
    # The same rows, read by pandas alone.
    assert len(pd.read_parquet(tmp_path / "run" / "results")) == 18


def test_other_processes_give_the_rows_of_this_one(study_file, tmp_path):
    study = dataclasses.replace(load_study(study_file), repetitions=2)
    run_study(study, tmp_path / "here")
    for workers in (1, 2):
        run_study(study, tmp_path / str(workers), workers=workers)
        found = verdicts(tmp_path / str(workers))
        pd.testing.assert_frame_equal(verdicts(tmp_path / "here"), found)
    assert len(found) == 36


def test_a_second_run_computes_only_what_is_missing(study_file, tmp_path):
    study, run = load_study(study_file), tmp_path / "run"
    run_study(study, run)
    assert run_study(study, run) == 0
    next((run / "results").glob("*.parquet")).unlink()
    assert run_study(study, run) == 2
    assert run_study(study, run, rerun=True) == 18


def test_a_finished_run_without_a_shard_is_refused_and_one_that_goes_on_says_how_many_are_there(
    study_file, tmp_path, caplog
):
    study, run = load_study(study_file), tmp_path / "run"
    run_study(study, run)
    assert len(load_results(run)) == 18
    assert not caplog.records
    for shard in list((run / "results").glob("*.parquet"))[:2]:
        shard.unlink()
    with pytest.raises(ResultsError, match="2 of 9 shards of a finished run are missing; run the"):
        load_results(run)
    with pytest.raises(ResultsError, match="2 of 9 shards of a finished run"):
        list(each_shard(run))
    manifest = json.loads((run / "manifest.json").read_text()) | {"finished": None}
    del manifest["checksum"]
    (run / "manifest.json").write_text(manifest_text(manifest))
    assert len(load_results(run)) == 14
    assert f"{run}: the run is not finished; 7 of 9 shards are there" in caplog.text
    run_study(study, run)
    assert len(load_results(run)) == 18


def test_where_kept_rows_are_wanted_alone_nothing_is_judged_or_written(study_file, tmp_path):
    study, run = load_study(study_file), tmp_path / "run"
    run_study(study, run)
    next((run / "results").glob("*.parquet")).unlink()
    before = {path: path.read_bytes() for path in run.rglob("*") if path.is_file()}
    told = r"run: 2 of 18 results are not kept .*; judge them"
    with kept_only("judge them"), pytest.raises(NotKeptError, match=told):
        run_study(study, run)
    assert {path: path.read_bytes() for path in run.rglob("*") if path.is_file()} == before
    fewer = dataclasses.replace(study, timeout=50.0)
    with kept_only("judge them"), pytest.raises(NotKeptError, match="18 of 18"):
        run_study(fewer, run)
    assert run_study(study, run) == 2
    with kept_only("judge them"):
        assert run_study(study, run) == 0


def test_a_changed_method_or_layout_counts_as_missing(study_file, tmp_path, stack):
    run = tmp_path / "run"
    run_study(load_study(study_file), run)
    study_file.write_text(STUDY.replace('"sme"', '"pbs0.5"'))
    assert run_study(load_study(study_file), run) == 6
    assert set(load_results(run)["method"]) == {"fbs", "pbs0.5", "simulation@mujoco:frequency=90"}
    # What was computed before is still there, and is not read.
    assert len(list((run / "results").glob("*.parquet"))) == 12
    write_layouts(tmp_path / "layouts.json", [stack(0.0, 2.0)], Format.NATIVE)
    assert run_study(load_study(study_file), run) == 6
    assert len(load_results(run)) == 6


def test_another_floor_counts_as_missing(study_file, tmp_path, stack):
    layouts = [stack(0.0, 3.0).renamed("a"), stack(-46.0).renamed("over")]
    write_layouts(tmp_path / "layouts.json", layouts, Format.NATIVE)
    run = tmp_path / "run"
    study = study_file.read_text().replace('methods = ["fbs"', 'shard_size = 1\nmethods = ["fbs"')
    study = study.replace("shard_size = 2\n", "").replace(', "S2b"', "")
    study_file.write_text(study)
    assert run_study(load_study(study_file), run) == 6
    # Of two layouts one overhangs the deck: on a plane, only its verdicts are others.
    study_file.write_text(study + 'floor = "infinite"\n')
    assert run_study(load_study(study_file), run) == 3
    assert load_manifest(run)["study"]["floor"] == "infinite"
    stable = load_results(run).query("layout == 'over'")["failing_step"].isna()
    assert stable.all()
    study_file.write_text(study + 'floor = "deck"\n')
    assert run_study(load_study(study_file), run) == 3
    study_file.write_text(study + 'floor = "auto"\noverhang = 6\n')
    assert run_study(load_study(study_file), run) == 0
    study_file.write_text(study + "overhang = 5\nstrict = true\n")
    with pytest.raises(LayoutError, match="-5 to"):
        run_study(load_study(study_file), run)


def test_other_code_where_it_is_judged_is_refused(stack):
    made_by = made_now([make_method("sme")])["sme"]
    judgements = ((0, "S1", stack(0.0)),)
    assert len(list(judge_unit(Unit("sme", judgements, Path("x"), made_by)))) == 1
    for name, value, message in (
        ("version of method", "0", "would judge by version of method 1 instead of 0;"),
        ("numpy", "99", f"would judge by numpy {made_by['numpy']} instead of 99;"),
        ("jolt", "5", "would judge by jolt missing instead of 5;"),
    ):
        with pytest.raises(OtherCodeError, match=re.escape(message)):
            judge_unit(Unit("sme", judgements, Path("x"), {**made_by, name: value}))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("seed = 3", "sead = 3"), "unknown key 'sead'; did you mean 'seed'?"),
        (("seed = 3", "seed = -1"), "seed is -1; allowed: a whole number, 0 or more"),
        (("seed = 3", "seed = true"), "seed is True"),
        (('"S2b"', '"S3"'), "scenarios[1] is 'S3'; allowed: S1, S2a, S2b"),
        (("layouts.json", "nothing-*.json"), "matches no file"),
        (('["fbs", ', '["fbs", "fbs", '), "methods: 'fbs' is the same as 'fbs'; name it once"),
        (('["fbs", ', '["pbs0.5", "pbs:alpha=0.5", '), "is the same as 'pbs0.5'"),
        (("layouts = ", "layout_files = "), "unknown key 'layout_files'"),
        (('name = "small"', "name = "), "not valid TOML"),
        (("seed = 3", "overhang = -1"), "overhang is -1; allowed: a number, 0 to 100000 [cm]"),
        (("seed = 3", 'floor = "desk"'), "floor is 'desk'; did you mean 'deck'?"),
        (('methods = ["fbs"', 'methods = [3, "fbs"'), "methods[0] is 3; allowed: a text"),
        (('"sme"', '"smee"'), "did you mean 'sme'"),
    ],
)
def test_a_wrong_definition_is_refused(study_file, change, message):
    study_file.write_text(STUDY.replace(*change))
    with pytest.raises(StudyError) as caught:
        load_study(study_file)
    assert message in str(caught.value)
    assert str(study_file) in str(caught.value)


def test_labels_hold_for_the_floor_that_they_were_made_on():
    for given, message in (({"floor": "deck"}, "infinite floor"), ({"overhang": 3.0}, "its own")):
        with pytest.raises(StudyError, match=message):
            StudyDefinition("labels", ("fbs",), benchmark="test", **given)


def test_a_folder_of_something_else_is_left_alone(study_file, tmp_path):
    other = tmp_path / "other"
    other.mkdir()
    (other / "precious.txt").write_text("x")
    with pytest.raises(ResultsError, match="holds something that is no study"):
        run_study(load_study(study_file), other)
    run_study(load_study(study_file), tmp_path / "run")
    study_file.write_text(STUDY.replace('"small"', '"large"'))
    with pytest.raises(ResultsError, match="holds the study 'small'"):
        run_study(load_study(study_file), tmp_path / "run")
    assert [p.name for p in other.iterdir()] == ["precious.txt"]


def test_a_folder_left_by_an_early_interrupt_can_be_used(study_file, tmp_path):
    (tmp_path / "run" / "results").mkdir(parents=True)
    assert run_study(load_study(study_file), tmp_path / "run") == 18


def test_two_runs_do_not_share_a_folder(study_file, tmp_path):
    from steadyload.runs.runner import _claim, locked

    study, run = load_study(study_file), tmp_path / "run"
    _claim(run, study)
    with locked(run), pytest.raises(ResultsError, match="another run is at work"):
        run_study(study, run)
    assert run_study(study, run) == 18


@pytest.mark.parametrize("content", ["[]", "null", "{}", '{"study": []}', "{", "\xff"])
def test_a_manifest_that_is_none_is_refused(tmp_path, content):
    (tmp_path / "manifest.json").write_bytes(content.encode("latin-1"))
    with pytest.raises(ResultsError, match=r"manifest\.json"):
        load_results(tmp_path)


def test_a_missing_engine_is_said_before_anything_is_judged(study_file, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "mujoco", None)
    monkeypatch.delitem(sys.modules, "steadyload.engines.with_mujoco", raising=False)
    with pytest.raises(EngineNotInstalledError, match="pip install mujoco"):
        run_study(load_study(study_file), tmp_path / "run")
    assert not (tmp_path / "run").exists()


def test_new_engine_versions_count_as_missing(study_file, tmp_path, monkeypatch):
    study, run = load_study(study_file), tmp_path / "run"
    run_study(study, run)
    real = metadata.version
    monkeypatch.setattr(metadata, "version", lambda p: "99" if p == "mujoco" else real(p))
    assert run_study(study, run) == 6, "only those of methods that declare the package"


def test_max_items_judges_a_prefix_of_the_same_layout(study_file):
    study = load_study(study_file)
    whole = study.cases(study.layouts())
    cut = dataclasses.replace(study, max_items=1).cases(study.layouts())
    for (_, layout), (_, prefix) in zip(whole, cut, strict=True):
        assert prefix.items == layout.items[:1]


def test_an_unexpected_failure_of_a_method_is_a_row(stack, monkeypatch):
    method = make_method("sme")
    monkeypatch.setattr(type(method), "_judge", lambda *_: 1 / 0)
    verdict = judge(method, stack(0.0))
    assert verdict.status is Status.ERROR
    assert verdict.reason == "ZeroDivisionError: division by zero"
    assert verdict.score is None


def test_a_study_may_generate_its_layouts(tmp_path, study_file):
    (tmp_path / "made.toml").write_text('generated = 4\nseed = 5\nmethods = ["fbs"]\n')
    study = load_study(tmp_path / "made.toml")
    made = [layout.content_hash() for layout in study.layouts()]
    assert made == [layout.content_hash() for layout in random_layouts(4, seed=5)]
    run_study(study, tmp_path / "run")
    assert len(load_results(tmp_path / "run")) == 4
    assert load_manifest(tmp_path / "run")["study"]["generated"] == 4
    (tmp_path / "both.toml").write_text(STUDY.replace("seed = 3", "seed = 3\ngenerated = 2"))
    names = [layout.name for layout in load_study(tmp_path / "both.toml").layouts()]
    assert names == ["a", "b", "stack", "layout-0000", "layout-0001"]
    for text, message in (
        ('methods = ["fbs"]\n', "or generated = a number"),
        (
            'methods = ["fbs"]\ngenerated = 0\n',
            "generated is 0; allowed: a whole number, 1 or more",
        ),
    ):
        (tmp_path / "wrong.toml").write_text(text)
        with pytest.raises(StudyError, match=message):
            load_study(tmp_path / "wrong.toml")


def test_options_of_an_engine_stand_in_the_rows(tmp_path, stack):
    write_layouts(tmp_path / "one.json", [stack(0.0)], Format.NATIVE)
    spec = "label@reference:tolerance=1e-6,contact=adams"
    (tmp_path / "study.toml").write_text(f'layouts = ["one.json"]\nmethods = ["{spec}"]\n')
    run_study(load_study(tmp_path / "study.toml"), tmp_path / "run")
    row = load_results(tmp_path / "run").iloc[0]
    assert row["method"] == "label@reference:tolerance=1e-06,contact=adams"
    parameters = json.loads(row["parameters"])
    assert (parameters["tolerance"], parameters["contact"]) == (1e-6, "adams")
    assert parameters["stiffness"] is None


def test_a_changed_adapter_from_elsewhere_is_asked_anew(tmp_path, monkeypatch):
    adapter = tmp_path / "outside_world.py"
    adapter.write_text(
        "from steadyload.engines.with_bullet import BulletWorld\n"
        "class OutsideWorld(BulletWorld):\n    pass\n"
    )
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setitem(ENGINES, "outside", EngineEntry("outside_world:OutsideWorld"))
    (tmp_path / "study.toml").write_text('generated = 1\nmethods = ["label@outside", "sme"]\n')
    study = load_study(tmp_path / "study.toml")
    assert run_study(study, tmp_path / "run") == 2
    assert run_study(study, tmp_path / "run") == 0
    adapter.write_text(adapter.read_text() + "# changed\n")
    assert run_study(study, tmp_path / "run") == 1


def test_results_do_not_depend_on_optional_packages_of_other_engines(monkeypatch):
    versions = {"numpy": "2", "drake": "1", "pybullet": "3"}
    monkeypatch.setattr(
        "steadyload.engines.registry.importlib.metadata.version", lambda p: versions[p]
    )
    # A table of its own: what is taken out of the real one comes back at its end.
    known = {name: ENGINES[name] for name in ("bullet", "drake")}
    known["mujoco"] = EngineEntry("x:X", ("numpy",))
    monkeypatch.setattr("steadyload.engines.registry.ENGINES", known)
    assert installed_versions("mujoco") == {"pybullet": "3", "numpy": "2"}
    assert installed_versions("drake") == {"pybullet": "3", "numpy": "2", "drake": "1"}
    assert installed_versions() == {"pybullet": "3", "numpy": "2", "drake": "1"}


def test_rows_without_a_column_that_came_later_are_read(study_file, tmp_path):
    run_study(load_study(study_file), tmp_path / "run")
    names = [name for name in SCHEMA.names if name != "body_substeps"]
    old = pq.read_table(next((tmp_path / "run" / "results").glob("*.parquet")), columns=names)
    sink = pa.BufferOutputStream()
    pq.write_table(old, sink)
    read = ROWS.decode(sink.getvalue().to_pybytes())
    assert read.column_names == SCHEMA.names
    assert read["body_substeps"].null_count == len(old)
    assert read.select(names).equals(old)


@pytest.mark.parametrize(
    ("cases", "size"), [(0, 12), (600, 12), (3327, 12), (3328, 13), (12_800, 50), (10**7, 100)]
)
def test_units_of_a_large_study_are_larger(cases, size):
    assert usual_size(cases) == size
    units = -(-cases // size)
    assert units >= min(256, cases // 12)  # so many workers have something to do


@pytest.mark.parametrize("by_an_earlier_version", [False, True])
def test_a_run_goes_on_with_units_of_the_size_it_was_begun_with(
    by_an_earlier_version, tmp_path, monkeypatch
):
    study = StudyDefinition("grows", ("fbs",), generated=60, seed=2, scenarios=("S1",), limit=24)
    folder = tmp_path / "run"
    run_study(study, folder)
    begun = load_manifest(folder)
    assert begun["cases_a_unit"] == 12
    if by_an_earlier_version:
        del begun["cases_a_unit"]
        (folder / "manifest.json").write_text(manifest_text(begun))
    monkeypatch.setattr("steadyload.runs.units.UNITS", 3)
    grown = dataclasses.replace(study, limit=None)
    assert run_study(grown, folder) == 60 - 24
    assert run_study(grown, tmp_path / "new") == 60
    assert load_manifest(folder)["cases_a_unit"] == 12
    assert load_manifest(tmp_path / "new")["cases_a_unit"] == 20
    assert len(list((tmp_path / "new" / "results").iterdir())) == 3
    pd.testing.assert_frame_equal(*(verdicts(at) for at in (folder, tmp_path / "new")))


@pytest.mark.parametrize(
    ("before", "now", "machines"),
    [
        ({}, "A", "A"),
        ({"machine": "A"}, "A", "A"),
        ({"machine": "A"}, "B", "A; B"),
        ({"machine": "A; B"}, "A", "B; A"),
        ({"machine": "A; B"}, "C", "A; B; C"),
    ],
)
def test_a_manifest_names_all_machines_of_its_verdicts(before, now, machines):
    assert runner._machines(before, now) == machines

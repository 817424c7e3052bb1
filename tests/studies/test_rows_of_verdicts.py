"""Rows of pages that compare verdicts are one tidy table, and run folders again."""

import io
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

import steadyload as sl
from steadyload.layouts.benchmark import load_benchmark
from steadyload.layouts.model.question import Question
from steadyload.runs import tidy
from steadyload.runs.able import asked_question
from steadyload.runs.definition import StudyDefinition
from steadyload.runs.labels import labelled_cases
from steadyload.runs.results import load_manifest, load_results
from steadyload.runs.runner import run_study
from steadyload.runs.timing import timed
from steadyload.studies import kept_rows, published
from steadyload.studies.kept_rows import RowsError, keep, rows, unpack

METHODS = ("fbs", "sme", "ps3@mujoco", "ps_opt@mujoco:question=stands")
WALL_PHASES = ("wall_build", "wall_step", "wall_read")
ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def entry(tmp_path_factory):
    """A page of a run on labelled cases with a timing pass, and one on layouts of nobody."""
    (page,) = published.named(("evaluation",))
    found = replace(page, work=tmp_path_factory.mktemp("runs") / "evaluation")
    study = StudyDefinition("small", METHODS, benchmark="test", limit=6, shard_size=7)
    run_study(study, found.work / "spatial")
    layouts = [layout for _, layout in labelled_cases(replace(study, limit=2))]
    timed(METHODS[:2], layouts, found.work / "spatial" / "times", repeats=1, block=3)
    run_study(StudyDefinition("drawn", METHODS[1:3], generated=5), found.work / "more" / "drawn")
    return found


@pytest.fixture(scope="module")
def file(entry, tmp_path_factory):
    return keep(entry, tmp_path_factory.mktemp("rows"))


def test_a_row_says_all_of_a_verdict_and_its_case(entry, file):
    found = rows("evaluation", file.parent)
    assert list(found) == list(tidy.ABOUT)
    pd.testing.assert_frame_equal(found, pd.read_parquet(file))
    own = found[found["run"] == "spatial"].set_index(["method", "layout", "scenario"])
    kept = load_results(entry.work / "spatial").set_index(own.index.names).loc[own.index]
    assert len(own) == len(kept) == 4 * 18
    for name in ("status", "layout_hash", "item_count", "failing_step", "substeps", "engine"):
        same = (own[name] == kept[name]) | (own[name].isna() & kept[name].isna())
        assert same.all(), name
    np.testing.assert_array_equal(own["cpu_total_ns"], np.round(1e9 * kept["cpu_total"]))
    for name in ("displacement_cm", "rotation_deg", "score"):
        np.testing.assert_array_equal(own[name], kept[name])
    cases = load_benchmark()
    for question in Question:
        labels = cases.labels_on(question).set_index(["layout", "scenario"])
        there = own.index.droplevel("method").isin(labels.index)
        assert own[f"labelled_{question}"].tolist() == there.tolist()
    questions = {spec: asked_question(spec) or Question.WITHIN for spec in METHODS}
    assert own["question"].tolist() == [questions[spec] for spec, *_ in own.index]
    assert Question.STANDS in questions.values()


def test_times_of_the_timing_pass_stand_beside_the_verdicts_on_its_cases(entry, file):
    found = rows("evaluation", file.parent)
    timed_rows = found[found["timed_cpu_ns"].notna()]
    assert set(timed_rows["method"]) == {*METHODS[:2]}
    assert set(timed_rows["run"]) == {"spatial"}
    assert len(timed_rows) == 2 * 6
    assert (timed_rows["timed_wall_ns"] > 0).all()


def test_a_run_without_labels_has_none(file):
    found = rows("evaluation", file.parent)
    drawn = found[found["run"] == "more/drawn"]
    assert len(drawn) == 2 * 5
    assert not drawn["labelled_within"].fillna(False).any()
    assert drawn[["label_within", "label_stands", "list"]].isna().all(axis=None)


def test_run_folders_come_back_with_their_keys(entry, file, tmp_path):
    back = replace(entry, work=tmp_path / "runs" / "evaluation")
    assert unpack(back, file.parent) == back.work
    for run in ("spatial", "more/drawn"):
        assert load_manifest(back.work / run) == load_manifest(entry.work / run)
        one, other = (load_results(work / run) for work in (entry.work, back.work))
        times = [name for name in one if name.startswith(("cpu_", "wall_"))]
        same = [name for name in one if name not in times]
        pd.testing.assert_frame_equal(one[same], other[same])
        known = [name for name in times if name not in WALL_PHASES]
        assert (one[known] - other[known]).abs().max(axis=None) <= 0.5001e-9
        assert other[list(WALL_PHASES)].isna().all(axis=None)
    assert keep(back, tmp_path / "again").read_bytes() == file.read_bytes()
    study = StudyDefinition("small", METHODS, benchmark="test", limit=6, shard_size=7)
    assert run_study(study, back.work / "spatial") == 0, "nothing is judged again"


@pytest.mark.parametrize("share", np.linspace(0.01, 0.99, 8))
def test_a_changed_byte_is_noticed_or_changes_nothing(share, entry, file, tmp_path):
    content = bytearray(file.read_bytes())
    content[int(share * len(content))] ^= 4
    (tmp_path / "rows").mkdir()
    (tmp_path / "rows" / file.name).write_bytes(content)
    back = replace(entry, work=tmp_path / "runs" / "evaluation")
    try:
        unpack(back, tmp_path / "rows")
    except RowsError:
        assert not back.work.exists()
    else:
        assert keep(back, tmp_path / "again").read_bytes() == file.read_bytes()


def harmed(content, table):
    """Contents that are no whole file of rows, by what was done to them."""
    beside = pq.read_metadata(pa.BufferReader(content)).metadata[b"files"].decode()

    def other(column, value, files=beside):
        place = table.schema.names.index(column)
        values = pa.array([value] * len(table), table.schema.field(column).type)
        changed = table.set_column(place, column, values)
        return tidy.content(changed, files=files)

    return {
        "cut off": content[:-100],
        "empty": b"",
        "nothing beside it": tidy.content(table),
        "no archive beside it": tidy.content(table, files="no"),
        "a run that leads elsewhere": other("run", "../.."),
        "a run that is not there": other("run", "other"),
        "a shard that leads elsewhere": other("shard", "../x"),
        "no key": other("shard", None),
        "no scenario": other("scenario", None),
        "no substeps": other("substeps", None),
    }


def test_a_damaged_or_harmful_table_is_named_and_leaves_no_folder(entry, file, tmp_path):
    content = file.read_bytes()
    table = pq.read_table(io.BytesIO(content))
    back = replace(entry, work=tmp_path / "runs" / "evaluation")
    for harm, changed in harmed(content, table).items():
        (tmp_path / "rows").mkdir(exist_ok=True)
        (tmp_path / "rows" / file.name).write_bytes(changed)
        with pytest.raises(RowsError) as told:
            unpack(back, tmp_path / "rows")
        assert "is damaged or cut off; restore the file" in str(told.value), harm
        assert [*tmp_path.glob("runs/*")] == [], harm
    assert not [*tmp_path.rglob("*.unfinished")]


def test_what_is_too_much_beside_the_verdicts_is_refused(entry, tmp_path, monkeypatch):
    monkeypatch.setattr(kept_rows, "_MOST_BESIDE", 1000)
    with pytest.raises(RowsError, match=r"take 0\.0 MB; allowed: 0\.0 MB; pages with more keep"):
        keep(entry, tmp_path)
    assert not [*tmp_path.iterdir()]


def test_rows_that_are_not_there_are_said(tmp_path):
    with pytest.raises(RowsError, match=r"evaluation\.parquet: does not exist; rows come with a"):
        rows("evaluation", tmp_path)
    with pytest.raises(RowsError, match="'speed' is not made of verdicts alone; allowed: evalu"):
        rows("speed")
    with pytest.raises(published.UnknownPageError, match="unknown page 'evaluatoin'; did you mean"):
        rows("evaluatoin")
    assert sl.rows is rows


def test_accuracy_by_a_frame_of_pandas_is_that_of_the_page():
    """What somebody who has the table alone computes."""
    found = rows("evaluation", ROOT / published.ROWS).query("run == 'spatial'")
    right = (found["status"] == "done") & (
        found["failing_step"].fillna(-1) == found["label_within"].fillna(-1)
    )
    shares = right.groupby(found["method"]).mean()
    page = (ROOT / published.FOLDER / "evaluation" / "report.md").read_text()
    assert f"| SME | {100 * shares['sme']:.1f} [" in " ".join(page.split())

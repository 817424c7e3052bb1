"""A labelled set, out into layout files, and the command around it."""

import csv
import json

import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from steadyload.atomic import write_atomically
from steadyload.cli import main
from steadyload.layouts import Item, Layout, Pallet
from steadyload.layouts.benchmark import BenchmarkError, load_benchmark, tables
from steadyload.layouts.benchmark.dataset import row_of
from steadyload.layouts.benchmark.export import LABEL_COLUMNS, export, labels_path
from steadyload.layouts.benchmark.overview import overview
from steadyload.layouts.benchmark.tables import (
    CASES,
    LABELS,
    DamagedSetError,
    as_parquet,
    write_further,
    write_tables,
)
from steadyload.layouts.files.csv_cells import unguarded
from steadyload.layouts.files.record import FormatError
from steadyload.layouts.formats import Format, read_layouts

ENSEMBLE = (("numerical", "fine"), ("model", "smooth"), ("limits", "strict"))
PALLET = Pallet(100.0, 100.0, 100.0)


def layout(name, count):
    return Layout(name, PALLET, tuple(
        Item(k, (10.0 * k, 0.0, 1 / 3), (10.0, 7.0, 10.0), 1.5 + k) for k in range(count)
    ))  # fmt: skip


NO_LABELS = {
    "question": "within", "status": {}, "cases": 0, "robust": 0, "fragile": 0, "mean": None,
}  # fmt: skip
"""How an overview counts a question of which a set has no labels."""


def case(name, scenario, count, step, split=None, rank=None, **more):
    offsets = None if scenario == "S1" else [0.1 * k for k in range(3 * count)]
    return dict.fromkeys(CASES.names) | {
        "layout": name, "scenario": scenario, "item_count": count, "offsets": offsets,
        "split": split, "rank": rank, "status": "done", "failing_step": step,
        "failing_step_paper": step,
    } | more  # fmt: skip


def opinion(name, scenario, reason, judge, step, status="done"):
    return {"layout": name, "scenario": scenario, "question": "within", "reason": reason,
            "judge": judge, "status": status, "failing_step": step}  # fmt: skip


@pytest.fixture
def folder(tmp_path):
    layouts = [row_of(layout("A", 4), "one", 3, ("A",)), row_of(layout("B", 2), "two", 1, ("B",))]
    cases = [
        case("A", "S1", 4, None, "test", 1),
        case("B", "S1", 2, 1, "test", 0, failing_step_paper=0),
        case("A", "S2a", 4, 3, "test", 0),
        case("B", "S2a", 2, None, "train"),
        case("A", "S2b", 4, 0),
        case("B", "S2b", 2, None, status="diverged"),
    ]
    opinions = [
        opinion("A", "S1", "numerical", "fine", None),
        opinion("A", "S1", "model", "smooth", 2),
        opinion("A", "S1", "limits", "strict", 2),
        *(opinion("A", "S2a", r, j, 3) for r, j in ENSEMBLE),
        opinion("A", "S1", "engine", "drake", None),
        opinion("B", "S1", "engine", "drake", 1, "timeout"),
    ]
    frames = [pd.DataFrame(rows) for rows in (layouts, cases, opinions)]
    write_tables(tmp_path / "set", *frames, {"origin": "made here"})
    return tmp_path / "set"


@pytest.mark.parametrize("name", ["layouts", "cases", "opinions"])
def test_a_table_that_is_not_the_one_written_is_named(folder, tmp_path, name):
    """One that can be read, as a copy out of another set."""
    file = folder / f"{name}.parquet"
    whole = pd.read_parquet(file)
    file.write_bytes(as_parquet(whole[::-1], pq.read_schema(file)))
    with pytest.raises(
        DamagedSetError, match=rf"{name}\.parquet: is damaged, .* make the set anew"
    ):
        load_benchmark(folder)


def test_a_changed_manifest_of_a_set_is_named(folder):
    about = folder / "manifest.json"
    about.write_text(about.read_text().replace("made here", "made there"))
    with pytest.raises(DamagedSetError, match=r"manifest\.json: is damaged"):
        load_benchmark(folder)


def test_a_set_interrupted_while_it_is_written_again_can_be_read(folder, monkeypatch):
    before, written = load_benchmark(folder), []

    def interrupt(path, content):
        written.append(path.name)
        if path.name == "cases.parquet":
            raise KeyboardInterrupt
        write_atomically(path, content)

    monkeypatch.setattr(tables, "write_atomically", interrupt)
    frames = (before.layouts.reset_index()[::-1], before.cases, before.opinions)
    with pytest.raises(KeyboardInterrupt):
        write_tables(folder, *frames, before.manifest)
    assert written == ["manifest.json", "layouts.parquet", "cases.parquet"]
    assert set(load_benchmark(folder).layouts.index) == {"A", "B"}


def labels(path):
    with labels_path(path).open(newline="") as file:
        return list(csv.DictReader(file))


@pytest.mark.parametrize("kind", [Format.NATIVE, Format.CSV, Format.JOB, Format.PARQUET])
def test_exported_cases_come_back_as_they_were(folder, tmp_path, kind):
    benchmark = load_benchmark(folder)
    path = tmp_path / "cases.file"
    assert export(benchmark, path, kind) == 5
    back = {lay.name: lay for lay in read_layouts(path)}
    assert list(back) == ["B_S1", "A_S1", "A_S2a", "B_S2a", "A_S2b"]
    for name, lay in back.items():
        key = name.rsplit("_", 1)
        assert lay.items == benchmark.layout(*key).items
        assert lay.content_hash() == benchmark.layout(*key).content_hash()
    assert [row["layout"] for row in labels(path)] == list(back)


def test_labels_lie_beside_the_layouts(folder, tmp_path):
    path = tmp_path / "cases.json"
    export(load_benchmark(folder), path, Format.NATIVE)
    rows = {row["layout"]: row for row in labels(path)}
    assert tuple(rows["A_S1"]) == LABEL_COLUMNS
    assert rows["A_S1"] == {
        "layout": "A_S1", "scenario": "S1", "instance": "one", "split": "test", "rank": "1",
        "item_count": "4", "failing_step": "", "score": "1.0", "failing_step_paper": "",
        "confidence": "0.3333333333333333", "robust": "False", "stands": "",
        "failing_step_stands": "",
    }  # fmt: skip
    assert [rows["A_S2a"][k] for k in ("failing_step", "score", "robust")] == ["3", "0.75", "True"]
    assert [rows["B_S1"][k] for k in ("failing_step", "failing_step_paper")] == ["1", "0"]
    assert [rows["A_S2b"][k] for k in ("split", "rank", "score", "confidence")] == [
        "",
        "",
        "0.0",
        "",
    ]
    assert sorted(p.name for p in tmp_path.iterdir()) == ["cases.json", "cases.labels.csv", "set"]


def test_names_in_labels_are_no_formulas_and_can_be_read_back(folder, tmp_path):
    whole = load_benchmark(folder)
    named = {"A": "=cmd()", "B": "'=B"}
    frames = [whole.layouts.reset_index(), whole.cases, whole.opinions]
    write_tables(tmp_path / "odd", *(f.replace({"layout": named}) for f in frames), {})
    path = tmp_path / "cases.csv"
    export(load_benchmark(tmp_path / "odd"), path, Format.CSV)
    cells = [row["layout"] for row in labels(path)]
    assert {cell[:3] for cell in cells} == {"'=c", "''="}
    assert [unguarded(cell) for cell in cells] == [layout.name for layout in read_layouts(path)]


def test_a_slice_is_exported(folder, tmp_path):
    path = tmp_path / "cases.csv"
    benchmark = load_benchmark(folder)
    assert export(benchmark, path, Format.CSV, part="test", scenarios=("S1",), limit=1) == 1
    assert [lay.name for lay in read_layouts(path)] == ["B_S1"]
    with pytest.raises(BenchmarkError, match="no labelled case"):
        export(benchmark, path, Format.CSV, part="validation")


def test_failing_cases_alone_are_exported(folder, tmp_path):
    """By the label of either question, and the limit counts these alone."""
    path = tmp_path / "cases.json"

    def names(**flags):
        export(load_benchmark(folder), path, Format.NATIVE, failing=True, **flags)
        return [lay.name for lay in read_layouts(path)]

    assert names() == ["B_S1", "A_S2a", "A_S2b"]
    with pytest.raises(BenchmarkError, match="none of these cases fails; allowed: a part of which"):
        names(part="train")
    rows = [dict.fromkeys(LABELS.names) | {
        "layout": "A", "scenario": scenario, "question": "stands",
        "status": "done", "failing_step": step,
    } for scenario, step in (("S1", 3), ("S2a", None))]  # fmt: skip
    write_further(folder, "labels", pd.DataFrame(rows), {})
    assert names() == ["B_S1", "A_S1", "A_S2a", "A_S2b"]
    of_stands = [(row["stands"], row["failing_step_stands"]) for row in labels(path)]
    assert of_stands == [("", ""), ("False", "3"), ("True", ""), ("", "")]
    assert names(limit=1) == ["B_S1", "A_S2a", "A_S2b"]
    assert names(scenarios=("S2a",)) == ["A_S2a"]


def test_an_unknown_scenario_is_named(folder, tmp_path):
    whole = load_benchmark(folder)
    frames = [whole.layouts.reset_index(), whole.cases, whole.opinions]
    write_tables(tmp_path / "odd", *(f.replace({"scenario": {"S2a": "x\x1b"}}) for f in frames), {})
    with pytest.raises(BenchmarkError, match=r"scenario of a case is 'x.*; allowed: S1, S2a, S2b"):
        load_benchmark(tmp_path / "odd")


def test_a_column_whose_name_is_no_text_is_refused():
    frame = pd.DataFrame({"abc": [1]})
    content = as_parquet(frame, pa.schema([pa.field("abc", pa.int64())])).replace(b"abc", b"ab\xef")
    with pytest.raises(BenchmarkError, match="cannot be read as Parquet"):
        tables.from_parquet(content, CASES)


def test_an_export_is_whole_or_not_at_all(folder, tmp_path):
    benchmark = load_benchmark(folder)
    with pytest.raises(FormatError, match="aclpp"):
        export(benchmark, tmp_path / "x.yaml", Format.ACLPP)
    (tmp_path / "a.labels.csv").mkdir()
    with pytest.raises(IsADirectoryError) as caught:
        export(benchmark, tmp_path / "a.json", Format.NATIVE)
    assert caught.value.filename == str(tmp_path / "a.labels.csv")
    with pytest.raises(IsADirectoryError):
        export(benchmark, folder, Format.NATIVE)
    with pytest.raises(FileNotFoundError) as caught:
        export(benchmark, tmp_path / "no" / "a.json", Format.NATIVE)
    assert caught.value.filename == str(tmp_path / "no" / "a.json")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.labels.csv", "set"]


def test_an_overview_counts(folder):
    found = overview(load_benchmark(folder))
    assert (found["layouts"], found["instances"], found["cases"]) == (2, 2, 6)
    assert found["origin"] == "made here"
    assert [(row["split"], row["scenario"]) for row in found["splits"]] == [
        ("train", "S2a"), ("test", "S1"), ("test", "S2a"), ("none", "S2b"),
    ]  # fmt: skip
    assert found["splits"][1] == {
        "split": "test", "scenario": "S1", "cases": 2, "stable": 1, "unstable": 1, "layouts": 2,
        "instances": 2, "items_mean": 3.0,
    }  # fmt: skip
    # What was not labelled is counted by its status alone.
    assert (found["splits"][3]["cases"], found["splits"][3]["unstable"]) == (1, 1)
    assert found["natural_stable"] == {"S1": 0.5, "S2a": 0.5, "S2b": 0.0}
    within, stands = found["labels"]
    assert within == {
        "question": "within", "status": {"done": 5, "diverged": 1},
        "cases": 2, "robust": 1, "fragile": 1, "mean": pytest.approx(2 / 3),
    }  # fmt: skip
    assert stands == NO_LABELS | {"question": "stands"}
    judges = {row["judge"]: (row["cases"], row["agreement"]) for row in found["judges"]}
    # A judge without an answer does not agree.
    assert judges == {
        "fine": (2, 1.0), "smooth": (2, 0.5), "strict": (2, 0.5), "drake": (2, 0.5)
    }  # fmt: skip


def test_a_set_without_opinions_has_an_overview_and_labels(folder, tmp_path):
    benchmark = load_benchmark(folder)
    none = benchmark.opinions.iloc[:0]
    write_tables(tmp_path / "bare", benchmark.layouts.reset_index(), benchmark.cases, none, {})
    bare = load_benchmark(tmp_path / "bare")
    found = overview(bare)
    assert found["labels"][0] == NO_LABELS | {"status": {"done": 5, "diverged": 1}}
    assert (found["judges"], found["origin"]) == ([], None)
    export(bare, tmp_path / "cases.csv", Format.CSV)
    assert {row["confidence"] for row in labels(tmp_path / "cases.csv")} == {""}


# --- the command ---------------------------------------------------------------------------------


def test_info_prints_json_and_a_table(folder, capsys):
    assert main(["benchmark", "info", str(folder), "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == overview(load_benchmark(folder))
    assert main(["benchmark", "info", str(folder)]) == 0
    printed = capsys.readouterr().out
    for part in ("2 layouts of 2 instances", "S2a 50.0 %", "1 fragile", "drake", "items, mean"):
        assert part in printed


@pytest.mark.parametrize(("name", "to", "kind"), [
    ("c.csv", (), "csv"), ("c.json", (), "native"), ("c.json", ("--to", "job"), "job"),
])  # fmt: skip
def test_export_takes_a_slice_and_a_format(folder, tmp_path, capsys, name, to, kind):
    out = tmp_path / name
    whole = ["benchmark", "export", str(folder), "--part", "test", "-o", str(out)]
    assert main(whole) == 0
    assert len(labels(out)) == 3
    assert main([*whole, "--scenario", "S1", *to, "--limit", "1"]) == 0
    assert "1 cases" in capsys.readouterr().out
    assert [lay.name for lay in read_layouts(out)] == ["B_S1"]
    begins = {"csv": "layout,", "native": '{\n "format"', "job": '{\n "ulds"'}[kind]
    assert out.read_text().startswith(begins)
    assert [row["failing_step"] for row in labels(out)] == ["1"]
    assert main([*whole, "--failing", *to]) == 0
    assert [lay.name for lay in read_layouts(out)] == ["B_S1", "A_S2a"]


def test_import_says_what_came_of_it(tmp_path, capsys):
    from steadyload.layouts.writers import as_job

    jobs = tmp_path / "Data" / "Data_2" / "2_AeJobs" / "Ulds_scenario_1"
    scores = tmp_path / "Data" / "Data_2" / "4_Benchmark" / "Ulds_scenario_1"
    jobs.mkdir(parents=True)
    scores.mkdir(parents=True)
    (jobs / "H1_Class_3_Instance_0_ULD_0.json").write_text(as_job([layout("x", 3)]))
    (scores / "H1_Class_3_Instance_0_ULD_0.json").write_text('{"score": [0.667]}')
    for number in range(12):
        (jobs / f"broken-{number}.json").write_text("{")
    out = tmp_path / "set"
    assert main(["benchmark", "import", str(tmp_path), "-o", str(out)]) == 0
    printed = capsys.readouterr().out
    assert "1 layouts, 1 cases (1 labelled, 0 not)" in printed
    assert "refused: 2 more" in printed
    assert load_benchmark(out).cases["failing_step"].tolist() == [2]


def test_a_wrong_folder_is_one_sentence_and_status_2(tmp_path, capsys):
    out = tmp_path / "out"
    for arguments in (
        ["info", tmp_path],
        ["export", tmp_path, "-o", tmp_path / "x.json"],
        ["import", tmp_path, "-o", out],
    ):
        assert main(["benchmark", *map(str, arguments)]) == 2
        printed = capsys.readouterr()
        assert (printed.out, printed.err.count("\n")) == ("", 1)
        assert str(tmp_path) in printed.err
    assert list(tmp_path.iterdir()) == []

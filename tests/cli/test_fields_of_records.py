"""Fields of records: docs list them, and lengths and angles have units."""

import csv
import io
import json
import re
from pathlib import Path

import pyarrow.parquet as pq
import pytest

import steadyload as sl
from steadyload.app.repair_results import repair_fields
from steadyload.cli import main
from steadyload.layouts import Item, Layout, Pallet
from steadyload.layouts.formats import Format, write_layouts
from steadyload.methods.registry import make_method
from steadyload.methods.uncertainty import parse_uncertainty
from steadyload.repairing.plan import Kind
from steadyload.runs.definition import StudyDefinition
from steadyload.runs.results import COLUMNS, SCHEMA, load_results
from steadyload.runs.runner import run_study
from steadyload.runs.verdict_reliability import Sampling

KINDS = ("verdict", "check", "score", "uncertain", "results")
DOCS = Path(__file__).parents[2] / "docs"
ROW = re.compile(r"^\| (.*?) \| (.*) \|$", re.MULTILINE)
UNSAID = {"displacement", "rotation", "distance", "angle", "height", "width", "depth", "gap",
          "shift", "way", "direction", "tilt"}  # fmt: skip
"""Words for a length or an angle."""

UNITS = {"cm", "mm", "m", "deg", "rad"}

BOXES = (
    Item(0, (40.0, 0.0, 40.0), (10.0, 10.0, 10.0), 1.0, name="A"),
    Item(1, (49.0, 10.0, 40.0), (10.0, 10.0, 10.0), 1.0, name="B"),
)
FALLS = Layout("falls", Pallet(100.0, 60.0, 100.0), BOXES)
METHOD = "ps_opt@mujoco"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    made = tmp_path_factory.mktemp("records")
    write_layouts(made / "falls.json", [FALLS], Format.NATIVE)
    return made


@pytest.fixture(scope="module")
def records(folder):
    """Records that hold a movement, by the page and the head of the table that lists them."""
    file = folder / "falls.json"
    of_method = {"uncertainty": parse_uncertainty("com=1mm"), "sampling": Sampling(most=64)}
    [scored] = sl.score([file], [METHOD], **of_method)
    run_study(StudyDefinition("run", (METHOD,), files=(file,)), folder / "run")
    [row] = load_results(folder / "run").to_dict("records")
    return {
        "verdict": ("api.md", "field of a verdict", make_method(METHOD).judge(FALLS).to_dict()),
        "check": ("check.md", "field", sl.check(FALLS, METHOD, transport="tilt").to_dict()),
        "score": ("api.md", "field of a score", scored),
        "uncertain": ("uncertainty.md", "field", scored["uncertain"]),
        "results": ("studies.md", "column", row),
    }


def listed(page, head):
    """Rows of a table of docs: the fields of each, and what is said of them."""
    text = (DOCS / page).read_text()
    table = text.split(f"| {head} | ", 1)[1].split("\n", 2)[2].split("\n\n")[0]
    return [(re.findall(r"`(\w+)`", fields), said) for fields, said in ROW.findall(table)]


@pytest.mark.parametrize("kind", KINDS)
def test_docs_list_all_fields_in_their_order(records, kind):
    page, head, record = records[kind]
    assert [field for fields, _ in listed(page, head) for field in fields] == list(record)


@pytest.mark.parametrize(("words", "head"), [
    (("--directions", "1"), "field of a limit"),
    (("--rule", "tilt"), "field of a rule or a history"),
])  # fmt: skip
def test_docs_list_the_fields_of_loads_on_the_road(folder, capsys, words, head):
    main(["transport", str(folder / "falls.json"), *words, "--json"])
    fields = {field for found, _ in listed("transport.md", head) for field in found}
    assert fields == json.loads(capsys.readouterr().out)[0].keys()


def test_docs_list_the_fields_of_repairs_in_their_order():
    found = sl.repair(FALLS)
    assert found.outcome == "repaired"
    for head, record in (
        ("field of a repair", found.to_dict()),
        ("field of a repair in a check", repair_fields(found)),
    ):
        assert [field for fields, _ in listed("repair.md", head) for field in fields] == [*record]
    [said] = [said for fields, said in listed("repair.md", "field of a repair")
              if fields == ["changes"]]  # fmt: skip
    assert re.findall(r"`(\w+)`", said) == list(found.to_dict()["changes"][0])


def test_docs_list_all_that_may_change():
    assert [word for words, _ in listed("repair.md", "word") for word in words] == [*Kind]


def test_a_length_or_an_angle_has_its_unit_in_its_name(records, folder, capsys):
    main(["transport", str(folder / "falls.json"), "--rule", "tilt", "--json"])
    keys = {key for _, _, record in records.values() for key in record}
    keys |= json.loads(capsys.readouterr().out)[0].keys()
    repair = sl.repair(FALLS)
    keys |= repair.to_dict().keys() | repair.to_dict()["changes"][0].keys()
    keys |= repair_fields(repair).keys()
    without = {key for key in keys if UNSAID & {*key.split("_")} and not UNITS & {*key.split("_")}}
    assert without == {
        "direction",  # of an axis, such as +x
    } | {key for key in keys if key.startswith("gap_") and key != "gap_cm"}  # of boxes


def test_check_hands_out_the_same_fields_as_csv(folder, records, capsys, in_this_process):
    main(["check", str(folder / "falls.json"), "-m", METHOD, "--csv"])
    [row] = csv.DictReader(io.StringIO(capsys.readouterr().out))
    assert list(row) == list(records["check"][2])
    assert row["moved_item"] == "1"


def test_stored_rows_keep_their_names_and_are_handed_out_with_units(folder):
    [shard] = (folder / "run" / "results").glob("*.parquet")
    stored = pq.read_table(shard)
    assert stored.schema.names == SCHEMA.names
    rows = load_results(folder / "run")
    assert list(rows.columns) == list(COLUMNS)
    assert rows["displacement_cm"].tolist() == stored["displacement"].to_pylist()
    assert rows["rotation_deg"].tolist() == stored["rotation"].to_pylist()
    names = ["rotation_deg", "score"]
    assert load_results(folder / "run", names).equals(rows[names])

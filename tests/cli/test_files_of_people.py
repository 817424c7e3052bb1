"""Commands on files as people have them: profiles, standard input, ids, layouts that are wrong."""

import io
import json

import pytest

from steadyload.cli import main
from steadyload.layouts.formats import Format, read_layouts, write_layouts
from steadyload.layouts.model.layout import Item, Layout, Pallet
from steadyload.runs.box_ids import with_box_ids
from steadyload.runs.results import load_manifest, load_results

# The second box hangs over the first by more than half: in mm and g, z up, centres, own headers.
WAREHOUSE = """\
Palette;PL;PB;PH;Folge;Artikel;X;Y;Z;L;B;H;Gewicht
P-1;1200;800;2000;0;SKU-2001;150;100,5;50;300;201;100;8611
P-1;1200;800;2000;1;SKU-2002;310;100,5;150;300;201;100;7250
P-2;1200;800;2000;0;SKU-2003;150;100,5;50;300;201;100;8611
"""

PROFILE = """\
units = "mm"
weight = "g"
up = "z"
positions = "centre"

[columns]
layout = "Palette"
pallet_length = "PL"
pallet_width = "PB"
pallet_height = "PH"
sequence = "Folge"
id = "Artikel"
length = "L"
width = "B"
height = "H"
weight = "Gewicht"
"""

COLUMNS = (
    "layout=Palette,pallet_length=PL,pallet_width=PB,pallet_height=PH,sequence=Folge,id=Artikel",
    "length=L,width=B,height=H,weight=Gewicht",
)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "wms.csv").write_text(WAREHOUSE)
    (tmp_path / "wms.toml").write_text(PROFILE)
    return tmp_path


def run(capsys, *words):
    status = main([str(word) for word in words])
    said = capsys.readouterr()
    return status, said.out, said.err


def leaning(name, ids=("", "")):
    spots = ((0.0, 0.0), (25.0, 20.0))
    items = [
        Item(k, (x, y, 0.0), (30.0, 20.0, 30.0), 5.0, name=ids[k]) for k, (x, y) in enumerate(spots)
    ]
    return Layout(name, Pallet(100.0, 100.0, 100.0), tuple(items))


def with_bad(path, bad=1, good=1):
    """A file of layouts, of which the first have no weight."""
    write_layouts(path, [leaning(f"L{k}") for k in range(bad + good)], Format.NATIVE)
    content = json.loads(path.read_text())
    for layout in content["layouts"][:bad]:
        layout["items"][1] |= {"weight": 0, "name": "SKU-7"}
    path.write_text(json.dumps(content))
    return path


def test_a_profile_and_flags_say_the_same(folder, capsys):
    status, table, err = run(capsys, "score", "wms.csv", "--profile", "wms.toml", "-m", "fbs")
    assert (status, err) == (0, "")
    assert "box SKU-2002 (2nd of 2): 46.7% of its base is supported" in table
    flags = ["--units", "mm", "--weight", "g", "--up", "z", "--positions", "centre",
             "--columns", COLUMNS[0], "--columns", COLUMNS[1]]  # fmt: skip
    _, out, _ = run(capsys, "score", "wms.csv", "--json", "-m", "sme", *flags)
    profile = ["--profile", "wms.toml"]
    _, same, _ = run(capsys, "score", "wms.csv", "--json", "-m", "sme", *profile)
    records, others = (
        [{k: v for k, v in r.items() if "seconds" not in k} for r in json.loads(t)]
        for t in (out, same)
    )
    assert records == others
    assert (records[0]["failing_step"], records[0]["failing_box"]) == (1, "SKU-2002")
    assert records[0]["moved_box"] == "SKU-2002"
    assert records[1]["failing_box"] is None


@pytest.mark.parametrize(
    "words",
    [
        ("view", "wms.csv", "--profile", "wms.toml", "--layout", "P-2", "-o", "wms.csv"),
        ("convert", "wms.csv", "--profile", "wms.toml", "-o", "./wms.csv"),
    ],
)
def test_what_is_read_is_not_written_over(folder, capsys, words):
    before = (folder / "wms.csv").read_bytes()
    status, out, err = run(capsys, *words)
    assert (status, out) == (2, "")
    assert "wms.csv' is read, too; allowed: another file" in err
    assert (folder / "wms.csv").read_bytes() == before


def test_the_demo_leaves_pallets_of_ones_own_alone(folder, capsys):
    own = folder / "pallets.json"
    write_layouts(own, [leaning("mine")], Format.NATIVE)
    before = own.read_bytes()
    status, _, err = run(capsys, "demo", "--no-open", "-o", ".")
    assert status == 2
    assert "'pallets.json' is not the demo's; allowed: a folder without that file" in err
    assert (own.read_bytes(), (folder / "index.html").exists()) == (before, False)


def test_flags_override_a_profile(folder, capsys):
    words = ("score", "wms.csv", "--profile", "wms.toml", "--units", "m")
    status, out, err = run(capsys, *words)
    assert (status, out) == (2, "")
    assert "pallet height is 2000 m; allowed: a positive finite number, 0.0005 to 1000 m" in err


def test_a_method_names_boxes_by_their_ids(folder, capsys):
    for ids, label in ((("a", "b"), "box b (2nd of 2)"), (("", ""), "box 2 of 2")):
        write_layouts(folder / "a.json", [leaning("A", ids)], Format.NATIVE)
        _, out, _ = run(capsys, "score", "a.json", "-m", "equilibrium", "--json")
        (record,) = json.loads(out)
        assert record["reason"] == (f"no contact forces balance {label} when {label} is placed")


@pytest.mark.parametrize("command", ["score", "convert", "view"])
def test_standard_input_is_read(folder, capsys, monkeypatch, command):
    monkeypatch.setattr("sys.stdin", io.TextIOWrapper(io.BytesIO(WAREHOUSE.encode())))
    more = {"convert": ("-o", "out.json"), "view": ("--layout", "P-1", "-m", "sme"), "score": ()}
    status, out, err = run(capsys, command, "-", "--profile", "wms.toml", *more[command])
    assert (status, err) == (0, "")
    assert out
    if command == "convert":
        assert read_layouts("out.json")[0].items[1].name == "SKU-2002"


def test_wrong_layouts_are_reported_and_the_others_judged(folder, capsys):
    with_bad(folder / "a.json", bad=7, good=2)
    status, out, err = run(capsys, "score", "a.json", "-m", "fbs", "-m", "sme", "--json")
    assert status == 3
    records = json.loads(out)
    assert sum(r["status"] == "done" for r in records) == 4
    assert sum(r["status"] == "refused" for r in records) == 14
    lines = err.splitlines()
    assert lines[0] == (
        'steadyload: a.json: layout "L0": box SKU-7 (2nd): weight is 0 kg; '
        "allowed: a positive finite number, 1e-09 to 1000000 kg"
    )
    assert lines[5:] == [
        "steadyload: ... and 2 more", "steadyload: 7 of 9 layouts were refused",
    ]  # fmt: skip


def test_what_is_done_with_wrong_layouts_can_be_said(folder, capsys):
    with_bad(folder / "a.json")
    status, out, err = run(capsys, "score", "a.json", "--strict")
    assert (status, out, err.count("\n")) == (2, "", 1)
    assert "weight is 0 kg" in err
    status, out, err = run(capsys, "score", "a.json", "--skip-invalid")
    assert (status, err) == (0, "")
    assert "weight is 0 kg" in out
    _, out, _ = run(capsys, "score", "a.json", "--skip-invalid", "--json")
    told = [(record["status"], record["score"]) for record in json.loads(out)]
    assert told[:2] == [("refused", None), ("done", 0.5)]
    status, _, err = run(capsys, "score", "a.json", "--strict", "--skip-invalid")
    assert status == 2
    assert "not allowed with --strict" in err


@pytest.mark.parametrize("bad", [1, 3])
def test_a_file_without_a_right_layout_is_wrong_input(folder, capsys, bad):
    with_bad(folder / "a.json", bad=bad, good=0)
    status, out, err = run(capsys, "score", "a.json")
    assert (status, out) == (2, "")
    assert ("3 of 3 layouts were refused" in err) == (bad == 3)
    assert err.count("\n") == (1 if bad == 1 else 4)


def test_one_refused_layout_is_told_in_the_singular(folder, capsys):
    with_bad(folder / "a.json", bad=1, good=2)
    (folder / "s.toml").write_text('layouts = ["a.json"]\nmethods = ["fbs"]\n')
    status, _, err = run(capsys, "study", "run", "s.toml", "--executor", "serial")
    assert (status, err.splitlines()[-1]) == (3, "steadyload: 1 of 3 layouts was refused")
    assert run(capsys, "study", "report", "runs/s")[0] == 0
    page = (folder / "runs" / "s" / "report.md").read_text()
    assert "**1 further layout of the files was refused**, since it is not valid" in page


def test_a_study_leaves_out_wrong_layouts_and_says_so(folder, capsys):
    with_bad(folder / "a.json", bad=2, good=2)
    (folder / "s.toml").write_text('layouts = ["a.json"]\nmethods = ["fbs", "sme"]\n')
    words = ("study", "run", "s.toml", "--executor", "serial")
    for computed in (4, 0):
        status, out, err = run(capsys, *words)
        assert status == 3
        assert out.startswith(f"{computed} rows computed")
        assert 'a.json: layout "L0": box SKU-7 (2nd): weight is 0 kg' in err
        assert "2 of 4 layouts were refused" in err
    manifest = load_manifest(folder / "runs" / "s")
    assert (manifest["layouts"], manifest["refused"]["count"]) == (2, 2)
    assert str(folder) not in manifest["refused"]["first"][0]
    assert run(capsys, "study", "report", "runs/s")[0] == 0
    page = (folder / "runs" / "s" / "report.md").read_text()
    assert "**2 further layouts of the files were refused**" in page
    status, _, err = run(capsys, *words, "--strict")
    assert status == 2
    assert "weight is 0 kg" in err
    mended = [leaning(f"L{k}") for k in (2, 3)]  # what was judged, and nothing else
    write_layouts(folder / "a.json", mended, Format.NATIVE)
    with_bad(folder / "b.json", bad=4, good=0)
    assert run(capsys, *words)[0] == 0
    assert "refused" not in load_manifest(folder / "runs" / "s")
    (folder / "s.toml").write_text('layouts = ["b.json"]\nmethods = ["fbs"]\n')
    status, _, err = run(capsys, *words)
    assert (status, err.count("\n")) == (2, 1)
    assert "weight is 0 kg" in err


def test_a_study_reads_files_by_its_profile(folder, capsys):
    (folder / "s.toml").write_text(
        'layouts = ["wms.csv"]\nmethods = ["fbs"]\nprofile = "wms.toml"\n'
    )
    assert run(capsys, "study", "run", "s.toml", "--executor", "serial")[0] == 0
    assert read_layouts("runs/s/layouts.parquet")[0].items[1].size == (20.1, 10.0, 30.0)
    (folder / "wms.toml").write_text('units = "mn"')
    status, _, err = run(capsys, "study", "run", "s.toml", "--executor", "serial")
    assert status == 2
    assert "wms.toml: units is 'mn'" in err


def test_ids_change_no_key_and_are_found_again(folder, capsys):
    shards = []
    for ids in (("", ""), ("SKU-1", "SKU-2")):
        write_layouts(folder / "a.json", [leaning("A", ids)], Format.NATIVE)
        (folder / "s.toml").write_text('layouts = ["a.json"]\nmethods = ["fbs", "pbs:alpha=0.1"]\n')
        status, out, _ = run(capsys, "study", "run", "s.toml", "--executor", "serial")
        assert status == 0
        shards.append(load_manifest(folder / "runs" / "s")["shards"])
    assert shards[0] == shards[1]
    assert out.startswith("0 rows computed")
    rows = with_box_ids(load_results("runs/s"), "runs/s").set_index("method")
    assert rows.loc["fbs", "failing_box"] == rows.loc["fbs", "moved_box"] == "SKU-2"
    assert rows["failing_box"].isna().tolist() == [False, True]
    assert run(capsys, "study", "report", "runs/s")[0] == 0
    assert "| 1 (SKU-2) |" in (folder / "runs" / "s" / "report.md").read_text()


@pytest.mark.parametrize("name", ["out.yaml", "out.xlsx", "out.csv.gz"])
def test_an_ending_that_cannot_be_written_is_refused(folder, capsys, name):
    words = ("convert", "wms.csv", "--profile", "wms.toml", "-o", name)
    status, out, err = run(capsys, *words)
    assert (status, out) == (2, "")
    assert "allowed: .csv, .json, .parquet, or --to with one of native, csv, job, parquet\n" in err
    assert not (folder / name).exists()
    assert run(capsys, *words, "--to", "csv")[0] == 0


def test_a_layout_is_viewed_although_another_is_wrong(folder, capsys):
    with_bad(folder / "a.json")
    assert run(capsys, "view", "a.json", "--layout", "L1", "-m", "sme")[0] == 0
    status, out, err = run(capsys, "view", "a.json", "-m", "sme")
    assert (status, out) == (3, "view.html\n")
    assert "box SKU-7 (2nd): weight is 0 kg" in err
    status, _, err = run(capsys, "view", "a.json", "--layout", "L0", "-m", "sme")
    assert status == 2
    assert "box SKU-7 (2nd): weight is 0 kg" in err


def test_the_viewer_names_boxes_and_escapes_them(folder, capsys):
    write_layouts(folder / "a.json", [leaning("A", ("<i>", "<script>x"))], Format.NATIVE)
    assert run(capsys, "view", "a.json", "-m", "fbs")[0] == 0
    page = (folder / "view.html").read_text()
    assert "fails at box &lt;script&gt;x (2nd of 2)<" in page
    assert "<script>x" not in page

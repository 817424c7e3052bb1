"""``steadyload repair``, and ``check --repair``: what is written, printed, refused and ended by."""

import csv
import dataclasses
import errno
import io
import json
import os
import shutil
import threading
from types import SimpleNamespace

import pytest

import steadyload as sl
from steadyload.app import checking, repairs
from steadyload.cli import main
from steadyload.cli import repair as repair_command
from steadyload.cli.terminal import ROW
from steadyload.layouts.formats import Format, write_layouts
from steadyload.layouts.writers import as_native
from steadyload.methods.contract.method import Status, Verdict
from steadyload.repairing.plan import Kind

PALLET = sl.Pallet(120, 160, 80)


def boxes(name, *told):
    """A layout of boxes of 40 x 30 x 40 cm, each (id, x, y, z)."""
    items = tuple(
        sl.Item(n, (x, y, z), (40, 30, 40), 12.0 - n, name=id_)
        for n, (id_, x, y, z) in enumerate(told)
    )
    return sl.Layout(name, PALLET, items)


STANDS = boxes("stands", ("A", 0, 0, 0), ("B", 10, 30.4, 0))
LEANS = boxes("leans", ("A", 0, 0, 0), ("B", 25, 30, 0))
EARLY = boxes("early", ("A", 0, 0, 0), ("TOP", 25, 30, 0), ("B", 40, 0, 0))
HOPELESS = sl.Layout(
    "hopeless",
    sl.Pallet(40, 40, 40, overhang=0.0),
    (
        sl.Item(0, (0, 0, 0), (10, 30, 10), 12, name="PILLAR", max_load=1.0),
        sl.Item(1, (0, 30, 0), (40, 10, 40), 9, name="SLAB", max_load=1.0),
    ),
)
"""Neither box may bear the other, and there is no room for one beside the other."""

WAREHOUSE = """\
Palette;PL;PB;PH;Folge;Artikel;Kunde;X;Y;Z;L;B;H;Gewicht
P-1;1200;800;2000;1;SKU-2001;007;150;100,50;50;300;201;100;8611
P-1;1200;800;2000;2;SKU-2002;=1+1;310;100,50;150;300;201;100;7250
P-2;1200;800;2000;1;SKU-2003;;150;100,50;50;300;201;100;8611
"""
PROFILE = """\
units = "mm"
weight = "g"
up = "z"
positions = "centre"
order = "from-1"
other_columns = "ignore"

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


@pytest.fixture
def folder(tmp_path, monkeypatch, in_this_process):
    """Where the files lie and the command runs."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def run(folder, capsys):
    """Run the command; returns status, output and errors."""

    def of(*words):
        status = main([*map(str, words)])
        said = capsys.readouterr()
        return status, said.out, said.err

    return of


def native(path, *layouts):
    write_layouts(path, layouts, Format.NATIVE)
    return path


def places(path, **reading):
    return {
        layout.name: [(item.name, item.position) for item in layout.items]
        for layout in sl.read(path, **reading)
    }


def test_a_native_file_is_written_with_its_failing_plans_replaced(run, folder):
    native(folder / "in.json", STANDS, LEANS, EARLY)
    status, out, err = run("repair", "in.json", "-o", "out.json")
    assert (status, err) == (0, "plans: out.json\n")
    header, *rows, moved, reordered, last = out.splitlines()
    assert header.split() == ["pallet", "boxes", "repair"]
    assert [" ".join(row.split()) for row in rows] == [
        "stands 2 stands as it is",
        "leans 2 stands, by 2.0 cm: 1 box moved",
        "early 3 stands, by 7.5 cm, by another order of loading alone",
    ]
    assert moved.startswith("leans: box B (2nd of 2) moves ")
    assert moved.endswith(" cm towards -x")
    assert reordered == "early: box B (3rd of 3) is loaded before box TOP (2nd of 3)"
    assert last.startswith("3 plans: 1 stands as it is, 2 repaired (")
    before, after = places("in.json"), places("out.json")
    assert after["stands"] == before["stands"]
    assert after["leans"][0] == before["leans"][0]
    assert 10.0 < after["leans"][1][1][0] < 25.0
    assert after["early"] == [before["early"][step] for step in (0, 2, 1)]
    assert run("check", "in.json")[0] == 1
    assert run("check", "out.json")[0] == 0
    assert places("in.json") == before


@pytest.mark.parametrize("flags", [("--profile", "wms.toml"), None])
def test_a_file_in_the_words_of_a_warehouse_is_read_back_by_the_same_flags(run, folder, flags):
    (folder / "in.csv").write_text(WAREHOUSE)
    (folder / "wms.toml").write_text(PROFILE)
    if flags is None:
        columns = PROFILE.partition("[columns]\n")[2].replace('"', "").replace(" ", "").split()
        flags = ("--units", "mm", "--weight", "g", "--up", "z", "--positions", "centre",
                 "--order", "from-1", "--other-columns", "ignore",
                 "--columns", ",".join(columns))  # fmt: skip
    status, out, _ = run("repair", "in.csv", "-o", "out.csv", "--allow", "turn,shift", *flags)
    assert status == 0
    assert "P-1: box SKU-2002 (2nd of 2) " in out
    assert " mm towards -x" in out
    assert run("check", "in.csv", *flags)[0] == 1
    assert run("check", "out.csv", *flags)[0] == 0
    before, after = WAREHOUSE.splitlines(), (folder / "out.csv").read_text().splitlines()
    assert [line for line in before if line not in after] == [before[2]]
    [line] = [line for line in after if line not in before]
    old, new = csv.DictReader([before[0], before[2], line], delimiter=";")
    assert [name for name in old if old[name] != new[name]] == ["X"]
    assert 150 < float(new["X"].replace(",", ".")) < 310


def test_what_is_not_repaired_stays_as_it_is_and_is_told(run, folder):
    native(folder / "in.json", HOPELESS, LEANS)
    status, out, _ = run("repair", "in.json", "-o", "out.json", "--seconds", "3")
    assert status == 1
    assert places("out.json")["hopeless"] == places("in.json")["hopeless"]
    [told] = [line for line in out.splitlines() if line.startswith("hopeless: ")]
    assert told.startswith("hopeless: not repaired: box PILLAR (1st of 2) has no free place")
    assert "2 plans: 0 stand as they are, 1 repaired, 1 not repaired (" in out
    words = ("--allow", "order,drop,shift,turn,move,leave", "--seconds", "3")
    status, out, _ = run("repair", "in.json", "-o", "out.json", *words)
    assert status == 0
    left = [line for line in out.splitlines() if line.endswith("is left out")]
    kept = [name for name, _ in places("out.json")["hopeless"]]
    assert len(left) == 2 - len(kept) > 0
    for line in left:
        assert line.split()[2] not in kept
    assert len(places("out.json")["leans"]) == 2


@pytest.mark.parametrize("words", [("--json",), ("--csv",)])
def test_records_have_the_fields_of_a_repair(run, folder, words):
    native(folder / "in.json", STANDS, EARLY, LEANS)
    status, out, err = run("repair", "in.json", "-o", "out.json", *words)
    assert (status, err) == (0, "plans: out.json\n")
    if words == ("--json",):
        records = json.loads(out)
        assert [len(record["changes"]) for record in records] == [0, 1, 1]
        assert [record["by_order_alone"] for record in records] == [False, True, False]
        sentences = [[change["sentence"] for change in record["changes"]] for record in records]
    else:
        records = [*csv.DictReader(io.StringIO(out))]
        sentences = [list(filter(None, record["changes"].split("; "))) for record in records]
    assert sentences[1] == ["box B (3rd of 3) is loaded before box TOP (2nd of 3)"]
    assert [record["outcome"] for record in records] == ["unchanged", "repaired", "repaired"]
    assert list(records[0]) == list(sl.repair(STANDS).to_dict())


def test_a_plan_that_stands_stays_in_the_file_whatever_is_closed_when_it_is_read(run, folder):
    native(folder / "in.json", STANDS, LEANS)
    status, _, _ = run("repair", "in.json", "-o", "out.json", "--snap")
    assert status == 0
    assert places("out.json")["stands"] == places("in.json")["stands"]
    assert places("out.json", snap_gap=0.5)["stands"] != places("in.json")["stands"]


def test_standard_input_is_repaired_into_a_named_format(run, folder, monkeypatch):
    content = "".join(as_native([STANDS, EARLY])).encode()
    for to, name in (("native", "out.json"), ("csv", "made/standard-input.csv")):
        (folder / "made").mkdir(exist_ok=True)
        monkeypatch.setattr("sys.stdin", io.TextIOWrapper(io.BytesIO(content)))
        status, _, _ = run("repair", "-", "-o", "made" if to == "csv" else name, "--to", to)
        assert status == 0
        assert [item for item, _ in places(name)["early"]] == ["A", "B", "TOP"]


def test_standard_input_and_a_pipe_keep_their_form(run, folder, monkeypatch):
    content = native(folder / "in.json", STANDS, EARLY).read_bytes()
    assert run("repair", "in.json", "-o", "expected.json")[0] == 0
    monkeypatch.setattr("sys.stdin", io.TextIOWrapper(io.BytesIO(content)))
    assert run("repair", "-", "-o", "out.json")[0] == 0
    assert (folder / "out.json").read_bytes() == (folder / "expected.json").read_bytes()
    os.mkfifo(folder / "pipe")
    writer = threading.Thread(target=(folder / "pipe").write_bytes, args=(content,))
    writer.start()
    (folder / "made").mkdir()
    assert run("repair", "pipe", "-o", "made")[0] == 0
    writer.join()
    assert (folder / "made" / "pipe").read_bytes() == (folder / "expected.json").read_bytes()


@pytest.mark.parametrize("kind", [Format.NATIVE, Format.CSV])
def test_what_was_read_is_written_also_where_the_file_was_replaced_meanwhile(
    run, folder, monkeypatch, kind
):
    def replaced(layout, options):
        native(folder / "in", LEANS.renamed("stands"), STANDS.renamed("leans"))
        return own(layout, options)

    own = repairs._repaired
    write_layouts(folder / "in", [STANDS, LEANS], kind)
    assert run("repair", "in", "-o", "expected")[0] == 0
    monkeypatch.setattr(repairs, "_repaired", replaced)
    assert run("repair", "in", "-o", "out")[0] == 0
    assert (folder / "out").read_bytes() == (folder / "expected").read_bytes()
    assert run("check", "out")[0] == 0


@pytest.mark.parametrize("words", [(), ("--overhang", "20"), ("--floor", "infinite"), ("--snap",)])
def test_a_file_is_repaired_with_what_flags_state_of_its_deck(run, folder, words):
    write_layouts(folder / "in.csv", [LEANS, EARLY], Format.CSV)
    assert run("repair", "in.csv", "-o", "out.csv", *words)[0] == 0
    assert run("check", "out.csv", *words)[0] == 0


def test_a_search_that_ends_by_its_time_is_told(run, folder):
    native(folder / "in.json", LEANS, STANDS)
    status, out, _ = run("repair", "in.json", "-o", "out.json", "--seconds", "1e-6")
    assert status == 1
    assert "leans: not repaired: no plan was found within 1e-06 s of CPU time\n" in out
    assert out.endswith("; 1 ended after 1e-06 s, more may find better\n")
    assert places("out.json") == places("in.json")


def test_the_question_of_a_method_and_where_it_errs_are_told(run, folder):
    plan = boxes("beyond", ("A", 0, 0, 0), ("B", 5, 30, 0))
    items = [dataclasses.replace(item, weight=10.0 ** (5 * k - 2)) for k, item in
             enumerate(plan.items)]  # fmt: skip
    native(folder / "in.json", dataclasses.replace(plan, items=tuple(items)))
    words = ("repair", "in.json", "-o", "out.json", "--seconds", "2", "-m")
    assert "(ps_opt@mujoco:question=stands)" in run(*words, "ps_opt@mujoco")[1]
    _, out, err = run(*words, "ps_opt@mujoco:question=within")
    assert "(ps_opt@mujoco:question=within)" in out
    assert "1 of 1 cases lie beyond what its engine was measured to hold" in err


def test_the_help_tells_the_defaults(run, monkeypatch):
    monkeypatch.setenv("COLUMNS", "400")
    _, out, _ = run("repair", "--help")
    assert f"(default: {repairs.SHIFT_CM:g})" in out
    assert f"(default: {repairs.SECONDS:g})" in out
    assert set(repairs.ALLOWED) == {*Kind} - {Kind.LEAVE}
    assert f"{', '.join(Kind)}, several with commas (default: all but leave)" in out


def test_several_files_go_into_a_folder_and_a_folder_takes_one(run, folder):
    (folder / "more").mkdir()
    native(folder / "a.json", LEANS)
    native(folder / "more" / "b.json", STANDS, EARLY)
    status, out, err = run("repair", "a.json", "more/b.json", "-o", "made")
    assert status == 0
    assert [line.split()[0] for line in out.splitlines()[:2]] == ["file", "a.json"]
    assert "b.json: early: box B" in out
    assert err == "plans: made/a.json\nplans: made/b.json\n"
    assert run("check", "made/a.json", "made/b.json")[0] == 0
    assert run("repair", "a.json", "-o", "more")[0] == 0
    assert run("check", "more/a.json")[0] == 0
    assert run("repair", "a.json", "more/b.json", "-o", "tables", "--to", "csv")[0] == 0
    assert places("tables/b.csv").keys() == {"stands", "early"}


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("in.json", "-o", "in.json"), "--output: 'in.json' is read, too"),
        (("in.json", "-o", "./link.json"), "--output: 'link.json' is read, too"),
        (("in.json", "-o", "."), "--output: 'in.json' is read, too"),
        (("in.json", "-o", "no/such/out.json"), "--output: 'no/such' is no folder"),
        (("in.json", "more/x.json", "-o", "out.txt"), "--output: 'out.txt' is no folder"),
        (("in.json", "more/in.json", "-o", "made"), "'in.json' and 'more/in.json' would both"),
        (("in.json", "-o", "own.toml", "--profile", "own.toml"), "'own.toml' is read, too"),
        (("made.json.native.json", "-o", "made.json"), "'made.json.native.json' is read, too"),
        (("in.json", "more/x.json", "-o", "taken"), "--output: 'taken/in.json' is a folder"),
        (("in.json", "in.json", "-o", "made"), "'in.json' and 'in.json' would both be written"),
        (("in.json", "./in.json", "-o", "more"), "'in.json' and 'in.json' would both be written"),
        (("made.json.native.json", "-o", "made.json", "--to", "csv"), "is read, too"),
        (("in.parquet", "-o", "x.parquet"), "'in.parquet' is a Parquet file, which has no text"),
        (("table", "-o", "x"), "'table' is a Parquet file, which has no text to change; allowed"),
        (("large.json", "-o", "x.json"), "large.json: is too large to be changed; allowed: up to"),
        (("no.json", "-o", "x.json"), "no.json: No such file or directory"),
        (("in.json", "-o", "x.json", "--allow", "order,mve"), "allow has 'mve'; did you mean"),
        (("in.json", "-o", "x.json", "--method", "smee"), "'smee'"),
        (("in.json", "-o", "x.json", "--seconds", "0"), "--seconds: '0'; allowed: a number"),
        (("in.json", "-o", "x.json", "--shift-cm", "-1"), "--shift-cm: '-1'; allowed"),
        (("in.json", "-o", "x.json", "--json", "--csv"), "--json: not allowed with --csv"),
        (("in.json",), "repair: -o OUT is needed"),
        (("in.json", "-o"), "repair: -o has no value; allowed: -o OUT"),
        ((), "repair: FILE is needed"),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, tuple) else "",
)
def test_words_that_are_not_allowed_are_refused_before_anything_is_searched(
    run, folder, monkeypatch, words, told
):
    monkeypatch.setattr(repairs, "_repaired", lambda *_: pytest.fail("it was searched"))
    (folder / "more").mkdir()
    (folder / "out.txt").write_text("kept")
    for name in ("in.json", "more/x.json", "more/in.json", "made.json.native.json"):
        native(folder / name, LEANS)
    for name in ("in.parquet", "table"):
        write_layouts(folder / name, [LEANS], Format.PARQUET)
    shutil.copy(folder / "in.json", folder / "large.json")
    os.truncate(folder / "large.json", 257 * 1024**2)
    (folder / "own.toml").write_text("units = 'cm'")
    (folder / "taken" / "in.json").mkdir(parents=True)
    (folder / "link.json").symlink_to("in.json")
    before = sorted(folder.rglob("*"))
    status, out, err = run("repair", *words)
    assert (status, out) == (2, "")
    assert told in err
    assert err.count("\n") == 1
    assert sorted(folder.rglob("*")) == before
    assert (folder / "out.txt").read_text() == "kept"


def test_a_layout_that_is_not_valid_stays_in_the_file_and_ends_with_2(run, folder):
    native(folder / "in.json", LEANS, STANDS)
    content = json.loads((folder / "in.json").read_text())
    content["layouts"][1]["items"][0]["weight"] = -1
    (folder / "in.json").write_text(json.dumps(content))
    status, out, err = run("repair", "in.json", "-o", "out.json")
    assert status == 2
    assert 'in.json: layout "stands": box A (1st): weight is -1 kg; allowed' in err
    assert "2 plans: 0 stand as they are, 1 repaired, 1 bad input (" in out
    after = json.loads((folder / "out.json").read_text())
    assert after["layouts"][1] == content["layouts"][1]
    assert after["layouts"][0] != content["layouts"][0]
    assert run("repair", "in.json", "-o", "out.csv", "--to", "csv")[0] == 2
    assert places("out.csv").keys() == {"leans"}


@pytest.mark.parametrize("words", [(), ("--json",)])
def test_what_was_found_is_told_where_it_cannot_be_written(run, folder, monkeypatch, words):
    def full(*_, **__):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), "out.json")

    monkeypatch.setattr("steadyload.app.repaired_files.rewrite", full)
    native(folder / "in.json", LEANS, STANDS)
    status, out, err = run("repair", "in.json", "-o", "out.json", *words)
    assert (status, err) == (2, "steadyload: out.json: No space left on device\n")
    if words:
        assert [one["outcome"] for one in json.loads(out)] == ["repaired", "unchanged"]
    else:
        assert "2 plans: 1 stands as it is, 1 repaired (" in out
    assert not (folder / "out.json").exists()


def test_a_plan_that_was_not_judged_ends_with_3(run, folder, monkeypatch):
    native(folder / "in.json", LEANS)
    unknown = Verdict(2, Status.TIMEOUT, reason="it took too long")
    monkeypatch.setattr(checking, "judge", lambda *_: unknown)
    status, out, _ = run("repair", "in.json", "-o", "out.json", "-m", "sme", "--seconds", "2")
    assert status == 3
    assert "1 not repaired" in out
    assert places("out.json") == places("in.json")


def test_what_the_form_of_a_file_cannot_state_is_written_beside_it(run, folder):
    """A packer's plan has no order of its own: it is loaded by height."""
    certificate = (
        "TYPE,ID,COPIES,BIN,STACK,X,Y,Z,LX,LY,LZ\nBIN,0,1,0,-1,0,0,0,100,100,100\n"
        "ITEM,0,1,0,0,0,0,0,40,40,30\nITEM,1,1,0,0,27,0,30,40,40,30\n"
    )
    (folder / "in.csv").write_text(certificate)
    status, out, err = run(
        "repair", "in.csv", "-o", "out.csv", "--allow", "shift", "--margin", "1.5"
    )
    assert status == 2
    assert "1 repaired" in out
    assert "allowed in a certificate of PackingSolver: whole numbers" in err
    assert "nothing is written to out.csv; its plans are in out.csv.native.json" in err
    assert not (folder / "out.csv").exists()
    assert run("check", "out.csv.native.json")[0] == 0


@pytest.mark.parametrize("after", [1, 2])
def test_what_is_repaired_by_an_interrupt_is_written(run, folder, monkeypatch, after):
    native(folder / "in.json", EARLY, LEANS, STANDS)
    own, done = repairs._repaired, []

    def interrupted(layout, options):
        if len(done) == after:
            raise KeyboardInterrupt
        done.append(layout.name)
        return own(layout, options)

    monkeypatch.setattr(repairs, "_repaired", interrupted)
    status, out, err = run("repair", "in.json", "-o", "out.json")
    assert status == 130
    told = f"{after} of 3 plans were done; the others are written as they were"
    assert err.splitlines()[-1] == f"steadyload: interrupted; {told}"
    assert out.count("not repaired: interrupted before its end") == 3 - after
    before, written = places("in.json"), places("out.json")
    assert [name for name in before if before[name] != written[name]] == ["early", "leans"][:after]


@pytest.mark.parametrize("words", [("--json",), ("--csv",), ()])
def test_a_check_with_repairs_adds_them_and_changes_nothing_else(run, folder, words):
    native(folder / "in.json", STANDS, LEANS, HOPELESS)
    plain, more = run("check", "in.json", *words), run("check", "in.json", "--repair", *words)
    assert plain[0] == more[0] == 1
    if words == ("--json",):
        old, new = json.loads(plain[1]), json.loads(more[1])
    elif words == ("--csv",):
        old, new = ([*csv.DictReader(io.StringIO(out))] for out in (plain[1], more[1]))
    else:
        told = more[1].splitlines()
        extra = [line for line in told if ": repair: " in line or line.startswith("repair: ")]
        assert [line for line in told if line not in extra] == plain[1].splitlines()
        assert extra[0] == "leans: repair: stands, by 2.0 cm: 1 box moved"
        assert extra[1].startswith("leans: repair: box B (2nd of 2) moves ")
        assert extra[2].startswith("hopeless: repair: not repaired: box PILLAR (1st of 2)")
        assert extra[3] == "repair: 1 of 2 that fail or hover stand when they are changed"
        return
    for one in old + new:
        one.pop("cpu_seconds")
    assert [{key: one[key] for key in old[0]} for one in new] == old
    assert [one["repair_outcome"] or None for one in new] == [None, "repaired", "not repaired"]
    assert "box B (2nd of 2) moves " in str(new[1]["repair_changes"])
    assert {key for key in new[0] if key not in old[0]} == {
        "repair_outcome", "repair_sentence", "repair_by_order_alone", "repair_boxes_moved",
        "repair_distance_cm", "repair_boxes_left_out", "repair_changes", "repair_margin_cm",
        "repair_chance_5mm",
    }  # fmt: skip


def test_a_check_with_repairs_heeds_its_limit_on_gaps(run, folder):
    native(folder / "in.json", boxes("airy", ("A", 0, 0, 0), ("B", 0, 31, 0)))
    for limit, outcome in (("2", None), ("0.5", "repaired")):
        words = ("--fail-on", f"any,gaps={limit}", "--repair", "--json")
        [record] = json.loads(run("check", "in.json", *words)[1])
        assert record["repair_outcome"] == outcome


def test_the_page_of_a_check_plays_a_repaired_plan(run, folder):
    native(folder / "in.json", STANDS, LEANS, HOPELESS)
    assert run("check", "in.json", "--html", "plain")[0] == 1
    assert run("check", "in.json", "--html", "made", "--repair")[0] == 1
    plain, made = ((folder / name / "index.html").read_text() for name in ("plain", "made"))
    ids = ['id="repaired-0"', 'id="repaired-1"', 'id="repaired-2"', 'id="planned"']
    assert [one in made for one in ids] == [False, True, False, True]
    assert [one in plain for one in ids] == [False] * 4
    assert "repair: stands, by 2.0 cm: 1 box moved" in made
    shutil.rmtree(folder / "made")


@pytest.mark.parametrize("words", [("--json",), ()])
def test_an_interrupt_of_repairs_keeps_the_answers_of_a_check(run, folder, monkeypatch, words):
    native(folder / "in.json", EARLY, LEANS)
    own = repairs._repaired

    def interrupted(layout, options):
        if layout.name == "leans":
            raise KeyboardInterrupt
        return own(layout, options)

    monkeypatch.setattr(repairs, "_repaired", interrupted)
    status, out, err = run("check", "in.json", "--repair", "--html", "page", *words)
    assert (status, err) == (130, "steadyload: interrupted\n")
    assert not (folder / "page").exists()
    if words:
        assert [one["answer"] for one in json.loads(out)] == ["fails", "fails"]
        assert [one["repair_outcome"] for one in json.loads(out)] == ["repaired", "not repaired"]
    else:
        assert "repair: 1 of 2 that fail or hover stand when they are changed" in out


@pytest.mark.parametrize("name", ["a", "n" * 30, "n" * 300])
@pytest.mark.parametrize("sentence", ["stands", "stands, by 2.0 cm: 8 boxes moved, " * 9])
def test_name_and_outcome_have_no_more_room_than_a_row(name, sentence):
    one = SimpleNamespace(name=name, sentence=sentence, outcome="")
    widths = repair_command._widths([one], ("a.csv", "b.csv"))
    assert min(widths) > 0
    assert sum(widths) + len("  boxes  ") + len("a.csv  ") <= ROW

"""``steadyload check``: an answer a pallet, its exit status, and records with units in names."""

import csv
import io
import json
import subprocess
import sys
from dataclasses import replace

import pytest

import steadyload as sl
from steadyload.app import checking, demo
from steadyload.app.check_defaults import default_method
from steadyload.app.checking import check, check_all, reliability
from steadyload.app.demo import demo_pallets
from steadyload.app.recommend.kept import load_fronts
from steadyload.cli import main
from steadyload.layouts.benchmark import load_benchmark
from steadyload.layouts.benchmark.parts import REAL
from steadyload.layouts.formats import Format, write_layouts
from steadyload.layouts.model.layout import Item, Layout, Pallet
from steadyload.layouts.model.question import Question
from steadyload.methods.contract.method import Status
from steadyload.methods.registry import make_method
from steadyload.runs import able
from steadyload.runs.scoring import read_entries
from steadyload.transport.rules import Rule

PALLET = Pallet(120, 150, 80)
HEAD = (
    "layout,pallet_length,pallet_width,pallet_height,sequence,id,x,y,z,length,width,height,weight"
)
"""Of a file with z up."""


def stack(name, shift, offset=(0.0, 0.0, 0.0), id_="SKU-2002"):
    """A box on another one, shifted along x or z [cm]."""
    return Layout(
        name,
        PALLET,
        (
            Item(0, position=(40, 0, 30), size=(30, 20, 20), weight=10, name="SKU-2001"),
            Item(
                1, position=(40 + shift[0], 20, 30 + shift[1]), size=(30, 20, 20), weight=8,
                mass_offset=offset, name=id_,
            ),
        ),
    )  # fmt: skip


DEFAULT = default_method(2)
BY = (
    "By: how much smaller all contacts may be on every side with the load still standing, at rest "
    "where boxes have gaps below them; a load is a close call below 1 cm."
)

STANDING, FALLING = stack("stands", (5.0, 0.0)), stack("falls", (22.0, 0.0))
REMEDY = (
    "box SKU-2002 (2nd of 2) would stand if it lay 7.5 cm towards -x, or if its support reached "
    "7.5 cm further to +x"
)
"""Of the falling one: back by as far as it lies past the edge, and by 5 mm."""


def _gentle():
    """A rule that asks for next to nothing."""
    return Rule("tilt", "", "", {"forwards": 0.01}, 0.1, 0.5, 0.1, 10.0, displacement=5.0)


@pytest.fixture
def run(capsys, tmp_path, in_this_process):
    """Run the command on layouts, or on files; returns status, output and errors."""

    def of(given, *words):
        files = given
        if isinstance(given[0], Layout):
            files = [tmp_path / "pallets.json"]
            write_layouts(files[0], given, Format.NATIVE)
        status = main(["check", *map(str, files), *words])
        said = capsys.readouterr()
        return status, said.out, said.err

    return of


def with_bad(path, layouts, bad):
    """A file of layouts, of which one has a weight below zero."""
    write_layouts(path, layouts, Format.NATIVE)
    content = json.loads(path.read_text())
    content["layouts"][bad]["items"][0]["weight"] = -1
    path.write_text(json.dumps(content))
    return path


def written(path, *rows, head=HEAD):
    path.write_text("\n".join([head, *rows]) + "\n")
    return path


def test_a_row_a_pallet_and_counts_that_fit_eighty_columns(run):
    long = stack("a name that is far too long to stand in a narrow table", (22.0, 0.0),
                 id_="an id that is long enough to fill a whole column by itself")  # fmt: skip
    status, out, _ = run([STANDING, FALLING, long])
    lines = out.splitlines()
    header, first, second, third, whole, fault, remedy, full, _, _, accuracy, by, last = lines
    assert status == 1
    assert header.split() == ["pallet", "boxes", "accuracy", "answer"]
    assert " ".join(first.split()) == "stands 2 96 % stands, by 10 cm or more"
    assert by == BY
    assert "fails at box 2 of 2: SKU-2002 tips to" in second
    assert third.startswith("a name that is fa...")
    assert whole == "falls: fails at box 2 of 2: SKU-2002 tips to +x, 1.5 cm"
    assert full.endswith("to fill a whole column by itself tips to +x, 1.5 cm")
    assert last == f"3 pallets: 1 stand, 2 fail ({DEFAULT})"
    assert max(map(len, (header, first, second, third, last))) <= 80
    assert fault.startswith("falls: the centre of mass of box SKU-2002 (2nd of 2) lies 7.0 cm past")
    assert remedy == f"falls: {REMEDY}"
    assert "the same for all such pallets" in accuracy
    assert "sure" not in out


def test_an_answer_that_the_table_cuts_stands_in_full_below(run):
    """Of loads that stand, fail, are crushed, hover and are crushed, and were not judged."""
    long = "an id that is long enough to fill a whole column by itself"
    lower, upper = stack("crushed", (5.0, 0.0), id_=long).items
    lower, upper = replace(lower, name=long, max_load=1.0), replace(upper, name="B")
    air = Item(2, (0.0, 5.0, 0.0), (20, 20, 20), 5.0, name="AIR")
    crushed = Layout("crushed", PALLET, (lower, upper))
    both = Layout("both", PALLET, (lower, upper, air))
    airy = hovering(0.4, id_=long).renamed("airy")
    _, out, _ = run([crushed, both, airy, FALLING])
    lines = out.splitlines()
    for name, count in (("crushed", 2), ("both", 3)):
        said = f"crushed when the 2nd box is placed: box {long} (1st of {count}) bears 8 kg of 1"
        assert f"{name}: {said}" in lines
    assert "both: box AIR (3rd of 3) has nothing under it; it drops 5.0 cm onto the floor" in lines
    assert f"airy: stands, by 10.0 cm at rest at {long}; 0.4 cm of air under {long}" in lines
    assert not any(line.startswith("falls: fails") for line in lines)  # it is not cut
    assert max(map(len, lines[:5])) <= 80
    method = ("-m", "ps_opt@mujoco:question=stands")
    late = STANDING.renamed("late on a day in the week before")
    _, out, _ = run([late], "--timeout", "1e-9", *method)
    [row, full] = [line for line in out.splitlines() if line.startswith("late on")]
    assert row.endswith("...")
    assert full.startswith(f"{late.name}: not judged: ")
    assert row[:-3].rpartition("not judged: ")[2] in full


def test_a_load_that_was_not_judged_does_not_count_as_hovering(run):
    words = ("--timeout", "1e-9", "-m", "ps_opt@mujoco:question=stands", "--json")
    for allowed, status in (("any", 3), ("any,gaps=1", 3), ("fails,gaps", 0)):
        code, out, _ = run([hovering(4.0)], *words, "--fail-on", allowed)
        [told] = json.loads(out)
        assert (code, told["answer"], told["hovering"]) == (status, "not judged", True)
    assert run([hovering(4.0), FALLING], "--fail-on", "any")[0] == 1


def test_answers_are_those_of_the_method_and_of_score(run, tmp_path, capsys):
    _, out, _ = run([STANDING, FALLING], "--json")
    told = json.loads(out)
    assert main(["score", str(tmp_path / "pallets.json"), "-m", DEFAULT, "--json"]) == 0
    scored = json.loads(capsys.readouterr().out)
    for mine, theirs in zip(told, scored, strict=True):
        assert mine["score"] == theirs["score"]
        assert mine["failing_step"] == theirs["failing_step"]
        assert mine["displacement_cm"] == theirs["displacement_cm"]
        assert mine["rotation_deg"] == theirs["rotation_deg"]
        for key in ("items", "layout", "file"):
            assert mine[key] == theirs[key]
    assert [one["answer"] for one in told] == ["stands", "fails"]
    assert (told[1]["failing_box"], told[1]["side"]) == ("SKU-2002", "right")


def test_csv_and_json_hold_the_same_records(run):
    status, out, _ = run([STANDING, FALLING], "--json")
    told = json.loads(out)
    assert (status, run([STANDING, FALLING], "--csv")[0]) == (1, 1)
    rows = list(csv.DictReader(io.StringIO(run([STANDING, FALLING], "--csv")[1])))
    texts = [{k: "" if v in (None, []) else str(v) for k, v in one.items()} for one in told]
    assert rows[1]["direction"] == "'+x"  # no formula
    for mine, theirs in zip(rows, texts, strict=True):
        mine["direction"] = mine["direction"].removeprefix("'")
        del mine["cpu_seconds"], theirs["cpu_seconds"]
        assert mine == theirs


@pytest.mark.parametrize(
    ("layouts", "words", "status"),
    [
        ([STANDING], (), 0),
        ([STANDING, FALLING], (), 1),
        ([STANDING, FALLING], ("--fail-on", "nothing"), 0),
        ([STANDING], ("--timeout", "1e-9"), 3),
        ([STANDING], ("--timeout", "1e-9", "--fail-on", "fails"), 0),
        ([FALLING], ("--fail-on", "fails"), 1),
        ([STANDING, FALLING], ("--limit", "1"), 0),
    ],
)
def test_the_exit_status_tells_the_worst_answer(run, layouts, words, status):
    assert run(layouts, *words, "-m", "ps_opt@mujoco:question=stands")[0] == status


def test_what_is_not_valid_is_told_and_the_others_are_judged(run, tmp_path):
    file = with_bad(tmp_path / "two.json", [STANDING, FALLING], bad=1)
    status, out, _ = run([file])
    assert status == 2
    assert "bad input" in out
    assert out.splitlines()[-1].startswith("2 pallets: 1 stand, 0 fail, 1 bad input")
    found = check_all(read_entries([file]), workers=0)
    assert "weight" in found[1].reason
    assert found[1].file == file.name or found[1].file == str(file)
    told = found[1].to_dict()
    unknown = ("items", "score", "unsupported", "hovering", "gaps", "gap_cm")
    assert [told[each] for each in unknown] == [None] * len(unknown)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("-m", "smee"), "did you mean 'sme'"),
        (("--json", "--csv"), "not allowed with"),
        (("--fail-on", "never"), "'never'; allowed: any, fails, gaps=CM, margin=CM"),
        (("--fail-on", "gaps=-1"), "gaps is '-1'; allowed: centimetres, 0 or more"),
        (("--fail-on", "gaps=nan"), "gaps is 'nan'"),
        (("--fail-on", "any,gaps="), "gaps is ''"),
        (("--fail-on", "margin"), "'margin'; allowed: any, fails"),
        (("--fail-on", "margin=-1"), "margin is '-1'; allowed: centimetres, 0 or more"),
        (("--fail-on", "margin=1,margin=2"), "has margin twice"),
        (("--fail-on", "fails=2"), "allowed: any, fails, gaps=CM, margin=CM"),
        (("--fail-on", "nothing,fails"), "allowed: nothing alone"),
        (("--fail-on", "gaps=1,gaps=2"), "gaps twice"),
    ],
)
def test_wrong_words_end_with_status_two(run, words, message):
    status, out, err = run([STANDING], *words)
    assert (status, out) == (2, "")
    assert message in err


def test_files_beyond_the_limit_are_not_read(run, tmp_path):
    good, bad = tmp_path / "good.json", tmp_path / "bad.json"
    write_layouts(good, [STANDING], Format.NATIVE)
    bad.write_text("")
    assert run([good, bad], "--limit", "1")[0] == 0
    status, _, err = run([good, bad])
    assert status == 2
    assert "is empty" in err


def test_a_reader_that_closes_the_pipe_takes_no_status(tmp_path):
    file = tmp_path / "many.json"
    write_layouts(file, [stack(f"{k}-" + "x" * 80, (22.0, 0.0)) for k in range(300)], Format.NATIVE)
    command = [sys.executable, "-m", "steadyload.cli", "check", str(file)]
    words = [*command, "-m", "sme", "--csv"]
    with subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as made:
        first = made.stdout.readline()
        made.stdout.close()
        said = made.stderr.read()
    assert first.startswith(b"layout,file,"), said
    assert said == b""
    assert made.returncode == 1


def test_what_ends_its_process_or_hangs_is_not_judged():
    entry = ("f.json", STANDING)
    unit = checking._Entry(0, STANDING, "sme", None)
    for status in (Status.CRASHED, Status.TIMEOUT):
        found = checking._not_judged(status, unit, 0, "because")
        assert (str(found.answer), str(found.verdict.status)) == ("not judged", status)
        assert found.sentence == "not judged: because"
    assert [one.file for one in check_all([entry], "sme", workers=1)] == ["f.json"]


def test_several_processes_say_the_same():
    layouts = [stack(str(k), (3.0 * k, 0.0)) for k in range(9)]
    entries = [("", layout) for layout in layouts]
    here, there = (check_all(entries, workers=workers) for workers in (0, 2))
    assert [str(one) for one in here] == [str(one) for one in there]
    assert [one.layout for one in there] == [layout.name for layout in layouts]


def test_a_box_without_support_is_said_to_have_nothing_under_it(run):
    status, out, _ = run([stack("hangs", (31.0, 0.0)), FALLING])
    assert status == 1
    assert "fails at box 2 of 2: SKU-2002 has nothing under it" in out
    told = json.loads(run([stack("hangs", (31.0, 0.0)), FALLING], "--json")[1])
    assert [one["unsupported"] for one in told] == [True, False]


def hovering(rise, id_="SKU-2002"):
    lower, upper = stack("hovers", (5.0, 0.0), id_=id_).items
    return Layout("hovers", PALLET, (lower, replace(upper, position=(45.0, 20.0 + rise, 30.0))))


@pytest.mark.parametrize(
    ("rise", "words", "status", "answer"),
    [
        (4.0, (), 1, "hovers"),
        (1.7, (), 0, "stands"),
        (1.7, ("--fail-on", "any,gaps=1"), 1, "hovers"),
        (4.0, ("--fail-on", "any,gaps=5"), 0, "stands"),
        (4.0, ("--fail-on", "gaps"), 1, "hovers"),
        (4.0, ("--fail-on", "gaps=4.5"), 0, "stands"),
        (4.0, ("--fail-on", "fails"), 0, "hovers"),
        (4.0, ("--fail-on", "fails,gaps"), 1, "hovers"),
        (4.0, ("--fail-on", "nothing"), 0, "hovers"),
    ],
)
def test_a_box_in_the_air_is_called_out_and_fails_beyond_a_limit(run, rise, words, status, answer):
    code, out, _ = run([hovering(rise)], "--json", *words)
    [told] = json.loads(out)
    assert (code, told["answer"]) == (status, answer)
    assert (told["gaps"], told["gap_cm"]) == (1, pytest.approx(rise))
    assert (told["gap_box"], told["gap_onto_box"], told["gap_onto_step"]) == (
        "SKU-2002", "SKU-2001", 0,
    )  # fmt: skip
    assert told["unsupported"] == told["hovering"] == (answer == "hovers")
    said = f"has nothing under it; it drops {rise:.1f} cm onto box SKU-2001 (1st of 2)"
    assert told["gap_note"] == f"box SKU-2002 (2nd of 2) {said}"
    assert told["reason"] == (told["gap_note"] if answer == "hovers" else "")


def test_a_gap_equal_to_the_limit_does_not_hover_at_any_height(run, tmp_path):
    """Of files in mm and in cm; records have the gap without what rounding adds."""
    for unit, per_cm in (("mm", 10), ("cm", 1)):
        rows = []
        for mm in range(101, 601, 5):
            top, rise = f"{mm * per_cm / 10:.10g}", f"{(mm + 3) * per_cm / 10:.10g}"
            sides = f"P{mm},{120 * per_cm},{80 * per_cm},{180 * per_cm}"
            base = f"{40 * per_cm},{40 * per_cm}"
            rows.append(f"{sides},0,A,0,0,0,{base},{top},12")
            rows.append(f"{sides},1,B,0,0,{rise},{base},{20 * per_cm},8")
        words = ["--units", unit, "--up", "z", "--json", "--fail-on", "gaps=0.3", "-m", "sme"]
        status, out, _ = run([written(tmp_path / f"{unit}.csv", *rows)], *words)
        assert status == 0
        told = json.loads(out)
        assert [one["gap_cm"] for one in told] == [0.3] * 100
        assert not any(one["hovering"] for one in told)


def test_a_gap_is_told_in_text_on_the_page_and_in_python(run, tmp_path):
    status, out, _ = run([hovering(4.0), hovering(0.4).renamed("near")], "--html", str(tmp_path))
    assert status == 1
    lines = out.splitlines()
    note = (
        "box SKU-2002 (2nd of 2) has nothing under it; it drops 4.0 cm onto box SKU-2001 (1st of 2)"
    )
    assert lines[1].endswith("hovers at box 2 of 2: SKU-2002, 4.0 cm above SKU-2001")
    assert "stands, by 10.0 cm at rest at SKU-2002; 0.4 cm" in lines[2]
    assert lines[3] == f"hovers: {note}"
    rule = (
        "Too far: a corner by 10 cm along an axis, or a turn by 10 degrees, unless the method says "
        "otherwise; a box that drops by less counts as placed. A load that stands by that rule "
        "hovers where a box has nothing under it and drops farther than 2 cm."
    )
    assert lines[-3:-1] == [rule, BY]
    assert lines[-1].startswith("2 pallets: 1 stand (1 with gaps), 0 fail, 1 hover (")
    page = (tmp_path / "index.html").read_text()
    assert 'class="card hovers"' in page
    assert note in page
    assert "it drops 0.4 cm onto" in page
    found = sl.check(hovering(4.0))
    assert not found.stands
    assert note in str(found)
    assert sl.check(hovering(4.0), gaps_cm=None).stands
    assert sl.check(hovering(1.7)).stands
    for wrong in (-1.0, float("nan"), "2", True):
        with pytest.raises(checking.GapLimitError, match="gaps_cm is"):
            sl.check(STANDING, gaps_cm=wrong)


def test_the_page_states_the_limit_on_gaps_and_the_axes_of_the_file(run, tmp_path):
    run([hovering(0.4)], "--html", str(tmp_path / "ours"))
    page = (tmp_path / "ours" / "index.html").read_text()
    assert "it and drops farther than 2 cm." in page
    assert "a box that leans to +x leans where the arrow +x points." in page
    file = written(
        tmp_path / "mm.csv",
        "bad,1200,800,1600,0,A,0,0,0,400,400,300,-1",
        "P,1200,800,1600,0,A,0,0,0,400,400,300,12",
    )
    words = ["--units", "mm", "--up", "z", "-m", "sme", "--fail-on", "gaps=0.5"]
    assert run([file], *words, "--html", str(tmp_path / "theirs"))[0] == 2
    page = (tmp_path / "theirs" / "index.html").read_text()
    assert "Too far: a corner by 100 mm along an axis" in page
    assert "it and drops farther than 5 mm." in page
    assert "a box that leans to +y leans where the arrow +y points." in page


def test_weights_are_in_the_unit_of_the_file(run, tmp_path):
    file = written(
        tmp_path / "g.csv",
        "P,1200,800,1600,0,A,0,0,0,400,400,300,12000,5000",
        "P,1200,800,1600,1,B,0,0,300,400,400,300,9000,",
        head=f"{HEAD},max_load",
    )
    words = ["--units", "mm", "--up", "z", "--weight", "g", "-m", "sme"]
    status, out, _ = run([file], *words, "--html", str(tmp_path))
    said = "crushed when the 2nd box is placed: box A (1st of 2) bears 9 kg of 5"
    assert status == 1
    assert said in out
    assert said in (tmp_path / "index.html").read_text()
    [told] = json.loads(run([file], *words, "--json")[1])
    assert (told["reason"], told["bears_kg"]) == (said, pytest.approx(9.0))


def test_rows_of_several_files_name_their_files(run, capsys, tmp_path):
    for folder in ("a", "b"):
        (tmp_path / folder).mkdir()
        write_layouts(tmp_path / folder / "one.json", [FALLING], Format.NATIVE)
    write_layouts(tmp_path / "two.json", [FALLING], Format.NATIVE)
    one, same, two = (str(tmp_path / name) for name in ("a/one.json", "b/one.json", "two.json"))
    words = ("-m", "sme")
    lines = run([one, two], *words)[1].splitlines()
    assert [line.split()[:2] for line in lines[:3]] == [
        ["file", "pallet"], ["one.json", "falls"], ["two.json", "falls"],
    ]  # fmt: skip
    assert max(map(len, lines[:3])) <= 80
    for name, (reason, remedy) in (("one.json", lines[3:5]), ("two.json", lines[5:7])):
        assert reason.startswith(f"{name}: falls: the centre of mass of box SKU-2002 ")
        assert remedy == f"{name}: falls: {REMEDY}"
    lines = run([one, same], *words, "--html", str(tmp_path))[1].splitlines()
    names = [line.split()[0] for line in lines[1:3]]
    assert [name[-11:] for name in names] == [one[-11:], same[-11:]]
    page = (tmp_path / "index.html").read_text()
    assert one in page
    assert same in page
    told = json.loads(run([one, two], *words, "--json")[1])
    assert [each["file"] for each in told] == [one, two]
    assert run([one], *words)[1].split()[0] == "pallet"
    for command in (["score", "-m", "sme"], ["transport", "--directions", "1"]):
        main([*command, one, two])
        lines = capsys.readouterr().out.splitlines()
        assert [line.split()[0] for line in lines[:3]] == ["file", "one.json", "two.json"]
    main(["transport", one, "--directions", "1", "--json"])
    assert [told["file"] for told in json.loads(capsys.readouterr().out)] == [one]


def test_a_load_that_falls_and_hovers_elsewhere_says_both(run):
    items = (*FALLING.items, Item(2, (0.0, 5.0, 0.0), (20, 20, 20), 5.0, name="AIR"))
    both = Layout("both", PALLET, items)
    status, out, _ = run([both], "--fail-on", "gaps=3")
    assert status == 1
    assert "both: box AIR (3rd of 3) has nothing under it; it drops 5.0 cm onto the floor" in out
    assert "both: the centre of mass of box SKU-2002" in out
    assert run([both], "--fail-on", "gaps=6")[0] == 0


def test_reasons_are_of_the_load_and_those_of_the_method_stand_beside(run):
    [told] = json.loads(run([FALLING], "--json", "-m", "equilibrium")[1])
    assert told["reason"].startswith("the centre of mass of box SKU-2002 (2nd of 2) lies 7.0 cm")
    assert told["method_reason"] == (
        "no contact forces balance box SKU-2002 (2nd of 2) when box SKU-2002 (2nd of 2) is placed"
    )
    assert (told["direction"], told["side"]) == ("+x", "right")
    assert told["beyond_edge_cm"] == pytest.approx(7.0)
    assert (told["edge_of_step"], told["base_supported"]) == (0, pytest.approx(8 / 30))


@pytest.mark.parametrize(
    ("height", "said"),
    [
        ("340", ["hovers at box 2 of 2: B, 40 mm above A", "it drops 40 mm onto box A"]),
        ("320.2", ["hovers at box 2 of 2: B, 20.2 mm above A", "it drops 20.2 mm onto box A"]),
        ("300.5", ["stands, by 100 mm or more at rest; 0.5 mm of air under B"]),
    ],
)
def test_sentences_speak_the_axes_and_the_unit_of_the_file(run, tmp_path, height, said):
    file = written(
        tmp_path / "mm.csv",
        "P,1200,800,1600,0,A,0,0,0,400,400,300,12",
        "P,1200,800,1600,1,B,250,0,300,400,400,300,9",
        "Q,1200,800,1600,0,A,0,0,0,400,400,300,12",
        f"Q,1200,800,1600,1,B,0,0,{height},400,400,300,9",
    )
    status, out, _ = run([file], "--units", "mm", "--up", "z")
    assert status == 1
    assert "fails at box 2 of 2: B tips to +x, 28 mm" in out
    assert "lies 50 mm past the edge of box A (1st of 2) (+x); 38 % of its base is supported" in out
    assert all(sentence in out for sentence in said)


def test_a_layout_beyond_what_an_engine_holds_is_warned_of_and_not_sure(run):
    light, heavy = stack("one", (5.0, 0.0)).items
    beyond = Layout("beyond", PALLET, (replace(light, weight=0.01), replace(heavy, weight=1000.0)))
    within = stack("within", (5.0, 0.0))
    spec = "ps_opt@mujoco:question=stands"
    _, out, err = run([beyond, within], "-m", spec)
    assert f"warning: {spec}: 1 of 2 cases lie beyond what its engine was measured to hold" in err
    first, second = out.splitlines()[1:3]
    assert first.split()[:3] == ["beyond", "2", "-"]
    assert second.split()[3] == "%"
    said = check(beyond, spec).outside[0]
    assert "1e+05 times as heavy" in said


def test_a_line_says_what_becomes_of_the_load_on_the_road():
    said = str(check(stack("one", (5.0, 0.0)), transport="en12195"))
    assert "stands, by 10 cm or more; does not hold en12195 at 0 degrees: item" in said
    assert "; holds tilt [" in str(check(stack("one", (5.0, 0.0)), transport=_gentle()))


def test_names_take_the_room_that_sentences_leave(run):
    names = [f"LH8098-29NOV15-FRA-LEJ pallet {k}" for k in range(3)]
    _, out, _ = run([stack(name, (5.0, 0.0)) for name in names])
    assert all(name in out for name in names)
    long = stack("short", (22.0, 0.0), id_="B" * 26)
    assert f"{'B' * 26} tips" in run([long])[1]


def test_reliability_is_what_was_measured_on_layouts_of_the_size():
    spec = str(make_method(DEFAULT).spec)
    for boxes in (2, 30, 50):
        found = reliability(spec, boxes)
        [front] = [
            f for f in load_fronts()
            if f.question == "stands" and f.fewest <= boxes <= f.most
            and any(m.method == spec for m in f.measured)
            and (f.cases, f.part) == (found.cases, found.part)
        ]  # fmt: skip
        [entry] = [m for m in front.measured if m.method == spec]
        assert found.accuracy == entry.accuracy
    assert reliability(spec, 1000) is None
    assert reliability("sme", 2).part == "test of the set lists"  # of the question stands
    assert reliability("ps3@mujoco", 2) is None
    assert reliability("pbs:alpha=0.123", 2) is None


def test_in_python_an_answer_prints_in_one_line():
    told = str(sl.check(FALLING))
    assert told.startswith(
        "falls (2 boxes): fails at box 2 of 2: SKU-2002 tips to +x, 1.5 cm; the centre of mass of "
        "box SKU-2002 (2nd of 2) lies 7.0 cm past the edge of box SKU-2001 (1st of 2) (+x); 27 % "
        f"of its base is supported; {REMEDY} ["
    )
    assert DEFAULT in told
    assert "\n" not in told
    assert sl.check(STANDING).stands
    simulated = sl.check(FALLING, "ps_opt@mujoco:question=stands")
    assert f"tips to +x, {simulated.verdict.displacement:.1f} cm" in simulated.sentence
    static = sl.check(FALLING, "sme")
    assert static.sentence == "fails at box 2 of 2: SKU-2002 leans to +x"
    assert sl.check(stack("off", (22.0, 0.0), (-8.0, 0.0, 0.0)), "fbs").sentence == (
        "fails at box 2 of 2: SKU-2002"
    )


def test_a_page_of_all_pallets_is_written_beside_the_rows(run, tmp_path):
    status, out, err = run([STANDING, FALLING], "--html", str(tmp_path / "out"))
    assert status == 1
    assert out.splitlines()[-1].startswith("2 pallets: 1 stand, 1 fail")
    assert f"page: {tmp_path / 'out' / 'index.html'}" in err
    (tmp_path / "file").write_text("")
    status, out, err = run([STANDING], "--html", str(tmp_path / "file"))
    assert (status, out) == (2, "")
    assert f"--html: '{tmp_path / 'file'}' is no folder; allowed: a folder" in err
    page = (tmp_path / "out" / "index.html").read_text()
    assert "2 pallets: 1 stand, 1 fail." in page
    assert [name in page for name in ("fails at box 2 of 2: SKU-2002", "player-0", "player-1")] == [
        True
    ] * 3


def test_the_demo_checks_pallets_of_which_half_are_labelled_as_standing(
    capsys, monkeypatch, tmp_path, in_this_process
):
    monkeypatch.chdir(tmp_path)
    pallets = demo_pallets(4)
    monkeypatch.setattr(demo, "demo_pallets", lambda: pallets)
    assert main(["demo"]) == 0
    out = capsys.readouterr().out.splitlines()
    assert out[-1].startswith("4 pallets: ")
    assert (tmp_path / "demo" / "index.html").exists()
    labels = load_benchmark(REAL).labels_on(Question.STANDS)
    fails = labels.set_index(["layout", "scenario"])["failing_step"].notna()
    assert [fails[layout.name, "S1"] for layout in pallets].count(False) == 2
    assert main(["check", "demo/pallets.json", "--fail-on", "nothing"]) == 0


@pytest.mark.parametrize("name", ["=1+1", "+1", "-1", "@SUM(A1)", "plain - name"])
def test_no_name_is_a_formula_in_a_spreadsheet(run, name):
    _, out, _ = run([stack(name, (5.0, 0.0))], "--csv")
    [record] = csv.DictReader(io.StringIO(out))
    assert record["layout"] == (name if name[0] == "p" else f"'{name}")


def test_the_default_method_is_made_once_and_one_that_is_named_every_time(monkeypatch):
    made = []

    def counted(spec):
        made.append(spec)
        return make_method(spec)

    monkeypatch.setattr(able, "make_method", counted)
    monkeypatch.setattr(checking, "make_method", counted)
    checking._default.cache_clear()
    for _ in range(3):
        sl.check(STANDING)
        sl.check(STANDING, "fbs")
    assert made == [DEFAULT, "fbs", "fbs", "fbs"]


FLAT = Layout("flat", PALLET, (Item(0, (40.0, 0.0, 30.0), (30.0, 10.0, 30.0), 8.0),))
TALL = Layout("tall", PALLET, (Item(0, (40.0, 0.0, 30.0), (12.0, 40.0, 30.0), 8.0, name="T"),))


def test_a_rule_of_the_road_is_asked_of_the_complete_load(run):
    status, out, _ = run([FLAT, TALL], "--transport", "eumos40509")
    header, flat, tall, _, _, count, judged, note = out.splitlines()
    assert status == 1
    assert header.split() == ["pallet", "boxes", "accuracy", "eumos40509", "answer"]
    assert flat.endswith("holds       stands, by 10 cm or more")
    assert tall.endswith("tips        stands, by 6.0 cm at T")
    assert count.endswith("; 1 hold eumos40509 (equilibrium:sides=frictionless)")
    assert judged == (
        "The answer judges the loading, box by box; eumos40509 judges the ride of the complete "
        "load, where a box with any gap below it has no support unless a simulation answers."
    )
    assert note == "On the road: rigid boxes, without wrap, straps or anti-slip mats."
    assert max(map(len, (header, flat, tall))) <= 80
    assert run([FLAT], "--transport", "eumos40509")[0] == 0
    assert run([TALL], "--transport", "eumos40509", "--fail-on", "nothing")[0] == 0
    assert "holds" not in run([TALL])[1]


def test_a_simulation_answers_for_the_road_itself(run):
    words = ("--transport", "eumos40509", "-m", "label@mujoco", "--json")
    flat, tall = json.loads(run([FLAT, TALL], *words)[1])
    assert flat["transport_method"] == tall["transport_method"] == "label@mujoco:question=stands"
    assert (flat["transport_held"], tall["transport_held"]) == (True, False)
    assert (tall["transport_direction_deg"], tall["transport_moved_item"]) == (0.0, 0)
    assert tall["transport_mode"] == "tips"
    assert {flat[k] for k in ("transport_direction_deg", "transport_mode")} == {None}
    asked = json.loads(run([FLAT], "--json")[1])[0]
    assert {v for k, v in asked.items() if k.startswith("transport_")} == {None, ""}


def test_bad_input_has_no_place_on_the_road(run, tmp_path):
    file = with_bad(tmp_path / "two.json", [FLAT, TALL], bad=0)
    status, out, _ = run([file], "--transport", "tilt")
    assert status == 2
    assert out.splitlines()[1].split()[-3:] == ["-", "bad", "input"]
    status, out, err = run([FLAT], "--transport", "tilted")
    assert (status, out) == (2, "")
    assert "did you mean 'tilt'?" in err


def test_the_page_says_what_holds(run, tmp_path):
    run([FLAT, TALL], "--transport", "eumos40509", "--html", str(tmp_path / "out"))
    page = (tmp_path / "out" / "index.html").read_text()
    assert "holds eumos40509" in page
    assert "eumos40509 judges the ride of the complete load" in page
    assert "eumos40509: box T (1st of 1) tips at 0 degrees" in page
    assert "<em>road: no</em>" in page


def test_a_load_that_stands_by_little_is_a_close_call(run, tmp_path):
    """By its margin as planned, at rest, and by none that is known: a box that leans on another."""
    close, far = stack("close", (14.8, 0.0)), stack("far", (5.0, 0.0))
    told = check(close)
    assert (told.answer, told.close_call) == ("stands", True)
    assert told.margin.cm == pytest.approx(0.2, abs=2e-3)
    assert told.sentence == "close call, by 0.2 cm at SKU-2002"
    status, out, _ = run([close, far], "--html", str(tmp_path))
    assert status == 0
    assert out.splitlines()[-1].startswith("2 pallets: 2 stand (1 close call), 0 fail")
    page = (tmp_path / "index.html").read_text()
    assert "<em>close call</em>" in page
    assert "1 by little" in page
    for words, expected in (("margin=1", 1), ("any", 0), ("any,margin=0.1", 0), ("margin=0.3", 1)):
        assert run([close, far], "--fail-on", words)[0] == expected
    [record, other] = json.loads(run([close, far], "--json")[1])
    assert (record["close_call"], other["close_call"]) == (True, False)
    assert record["margin_cm"] == pytest.approx(0.2, abs=2e-3)
    assert (record["margin_kind"], record["margin_item"]) == ("as planned", 1)


def test_a_load_that_stands_by_a_simulation_alone_is_a_close_call(run):
    never = Layout("never", PALLET, (
        Item(0, (0.0, 0.0, 0.0), (30.0, 30.0, 30.0), 5.0),
        Item(1, (16.0, 30.0, 0.0), (30.0, 20.0, 30.0), 5.0),
    ))  # fmt: skip
    told = check(never, "ps_opt@mujoco:question=stands,eps_t=1000,eps_r=180")
    assert (told.answer, told.margin, told.close_call) == ("stands", None, True)
    assert told.sentence == "close call, margin not known"
    status, _, _ = run([never], "-m", told.method, "--fail-on", "margin=0")
    assert status == 1


def test_a_box_that_bears_too_much_fails_at_its_step(run, tmp_path):
    size = (30.0, 10.0, 30.0)
    boxes = [Item(k, (40.0, 10.0 * k, 30.0), size, 8.0, name=f"C{k}") for k in range(4)]
    boxes[1] = replace(boxes[1], max_load=12.0)
    weak = Layout("weak", PALLET, tuple(boxes))
    status, out, _ = run([weak], "--html", str(tmp_path / "out"))
    assert status == 1
    assert "crushed when the 4th box is placed: box C1 (2nd of 4) bears 16 kg of 12" in out
    said = json.loads(run([weak], "--json")[1])[0]
    assert (said["answer"], said["score"], said["failing_step"]) == ("fails", 1.0, None)
    assert (said["crushed_step"], said["crushed_item"], said["allowed_kg"]) == (3, 1, 12.0)
    assert said["bears_kg"] == pytest.approx(16.0)
    assert "bears 16 kg of 12" in (tmp_path / "out" / "index.html").read_text()


def test_what_falls_before_it_crushes_falls():
    top = Item(2, (62.0, 40.0, 30.0), (30, 20, 20), 90.0, name="HEAVY")
    items = tuple(replace(item, max_load=50.0) for item in FALLING.items)
    found = sl.check(Layout("falls", PALLET, (*items, top)))
    assert found.sentence.startswith("fails at box 2")
    assert found.crushed is None


@pytest.mark.parametrize("command", ["check", "score"])
@pytest.mark.parametrize("method", ["sme", "equilibrium"])
def test_a_rule_is_asked_without_tables_and_solvers(command, method, tmp_path):
    file = tmp_path / "pallet.json"
    write_layouts(file, [FALLING], Format.NATIVE)
    script = f"""
import sys
from steadyload.cli import main
main(["{command}", {str(file)!r}, "-m", "{method}"])
heavy = {{"pandas", "pyarrow", "scipy.optimize", "scipy.special", "scipy.sparse", "clarabel"}}
assert not heavy & set(sys.modules), heavy & set(sys.modules)
"""
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert "falls" in done.stdout

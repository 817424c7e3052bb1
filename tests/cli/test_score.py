"""``steadyload score``: records are printed as they come, after all input was checked."""

import json

import pytest

from steadyload.cli import main
from steadyload.layouts import Item, Layout, Pallet
from steadyload.layouts.formats import Format, write_layouts
from steadyload.runs import scoring


@pytest.fixture
def files(tmp_path):
    """A file of three layouts, and one whose last row is cut off."""
    pallet = Pallet(120.0, 160.0, 80.0)
    items = (Item(0, (0, 0, 0), (40, 30, 40), 5.0), Item(1, (70, 30, 0), (40, 30, 40), 5.0))
    layouts = [Layout(name, pallet, items[: k + 1]) for k, name in enumerate("AB")]
    write_layouts(tmp_path / "good.csv", [*layouts, Layout("C", pallet, items)], Format.CSV)
    text = (tmp_path / "good.csv").read_text()
    (tmp_path / "cut.csv").write_text(text.replace("A,", "D,", 1)[:-30])
    return str(tmp_path / "good.csv"), str(tmp_path / "cut.csv")


def judging(monkeypatch, after):
    """Names of layouts as they are judged; calls ``after`` with each."""
    judged = []
    judge = scoring.judge

    def watched(method, layout, timeout):
        verdict = judge(method, layout, timeout)
        judged.append(layout.name)
        after(layout.name)
        return verdict

    monkeypatch.setattr(scoring, "judge", watched)
    return judged


def test_records_are_printed_as_they_come(files, capsys, monkeypatch):
    printed = []

    def look(name):
        printed.append(capsys.readouterr().out)

    judging(monkeypatch, look)
    assert main(["score", files[0], "-m", "fbs", "--json"]) == 0
    rest = capsys.readouterr().out
    assert [text.count('"layout"') for text in [*printed, rest]] == [0, 1, 1, 1]
    text = "".join([*printed, rest])
    assert text == json.dumps(json.loads(text), indent=1) + "\n"
    assert [record["layout"] for record in json.loads(text)] == ["A", "B", "C"]


def test_nothing_is_judged_or_printed_before_all_files_are_checked(files, capsys, monkeypatch):
    judged = judging(monkeypatch, lambda name: None)
    assert main(["score", *files, "-m", "fbs", "--json"]) == 2
    out, err = capsys.readouterr()
    assert (out, judged, err.count("\n")) == ("", [], 1)
    assert "cut.csv: line 6 has" in err


def test_people_read_the_box_at_which_a_load_fails_counted_from_1(files, capsys):
    assert main(["score", files[0], "-m", "fbs"]) == 0
    header, first, second, _ = capsys.readouterr().out.splitlines()
    assert header.split()[:6] == ["layout", "method", "boxes", "score", "fails", "at"]
    assert first.split()[:5] == ["A", "fbs", "1", "1.000", "-"]
    assert second.split()[:5] == ["B", "fbs", "2", "0.500", "2"]


def test_an_interrupted_array_has_no_end(files, capsys, monkeypatch):
    def interrupt(name):
        if name == "B":
            raise KeyboardInterrupt

    judging(monkeypatch, interrupt)
    assert main(["score", files[0], "-m", "fbs", "--json"]) == 130
    out, err = capsys.readouterr()
    assert err == "steadyload: interrupted\n"
    assert [record["layout"] for record in json.loads(out + "\n]")] == ["A"]
    with pytest.raises(ValueError, match="Expecting"):
        json.loads(out)


def test_a_bar_in_the_terminal_leaves_the_output_alone(files, capsys, monkeypatch):
    monkeypatch.setenv("FORCE_COLOR", "1")  # what rich takes for a terminal
    assert main(["score", files[0], "-m", "fbs", "--json"]) == 0
    out, err = capsys.readouterr()
    assert len(json.loads(out)) == 3
    assert "judging" in err


def test_where_records_go_to_the_terminal_there_is_no_bar(files, capsys, monkeypatch):
    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.setattr("sys.stdout.isatty", lambda: True)
    assert main(["score", files[0], "-m", "fbs", "--json"]) == 0
    assert "judging" not in capsys.readouterr().err

"""A page is written whole or not at all, and leaves alone what is not its own."""

import os
import subprocess
import sys
from pathlib import Path

import matplotlib.figure
import pytest

from steadyload.reports import writing
from steadyload.reports.page import Page, Picture, Section
from steadyload.reports.table import Column, Table, columns_for, words
from steadyload.reports.writing import write_page

KILLED = """
import os, sys
from pathlib import Path
import matplotlib.figure
from steadyload.reports.page import Page, Picture, Section
from steadyload.reports.writing import write_page
left, replace = int(sys.argv[1]), Path.replace
def killing(self, target):
    global left
    left -= 1
    if left < 0:
        os._exit(9)
    return replace(self, target)
Path.replace = killing
pictures = [Picture(name, matplotlib.figure.Figure(), "Shows.") for name in ("b", "c")]
write_page(Page("New", "So.", [Section("One", pictures=pictures)], {}), Path("."))
"""


PAGES = ("report.md", "report.html")


def page(*names, summary="So."):
    pictures = [
        Picture(name, matplotlib.figure.Figure(), f"Shows {name} (once).") for name in names
    ]
    return Page("Title", summary, [Section("One", pictures=pictures)], {"made": "here"})


def files(folder):
    return {str(p.relative_to(folder)) for p in folder.rglob("*") if p.is_file()}


def test_pictures_that_the_new_page_has_not_are_removed_and_nothing_else(tmp_path):
    write_page(page("old", "both"), tmp_path)
    mine = {"figures/mine.png", "figures/notes.txt", "other.md", "views/index.html"}
    for name in mine:
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text("x")
    write_page(page("both", "new"), tmp_path)
    assert files(tmp_path) == {*PAGES, "figures/both.svg", "figures/new.svg", *mine}
    write_page(page(), tmp_path)
    assert files(tmp_path) == {*PAGES, *mine}


def test_an_interrupted_page_leaves_the_one_before(tmp_path, monkeypatch):
    write_page(page("a", "b"), tmp_path)
    before = {name: (tmp_path / name).read_bytes() for name in files(tmp_path)}
    drawn = []

    def interrupt(figure):
        drawn.append(figure)
        if len(drawn) == 2:
            raise KeyboardInterrupt
        return ".svg", b"half"

    monkeypatch.setattr(writing, "image", interrupt)
    with pytest.raises(KeyboardInterrupt):
        write_page(page("a", "c", summary="New."), tmp_path)
    assert {name: (tmp_path / name).read_bytes() for name in files(tmp_path)} == before


def test_a_page_that_cannot_be_made_leaves_the_one_before(tmp_path):
    write_page(page("a"), tmp_path)
    before = {name: (tmp_path / name).read_bytes() for name in files(tmp_path)}
    pictures = page("b").sections[0].pictures
    broken = Page("Title", "So.", [Section("One", tables=None, pictures=pictures)], {})
    with pytest.raises(TypeError):
        write_page(broken, tmp_path)
    assert {name: (tmp_path / name).read_bytes() for name in files(tmp_path)} == before


def contents(folder):
    return {name: (folder / name).read_bytes() for name in files(folder)}


@pytest.mark.parametrize("moved", [0, 1, 2, 3])
def test_a_page_interrupted_between_two_of_its_files_is_the_one_before(
    tmp_path, monkeypatch, moved
):
    (tmp_path / "figures").mkdir()
    (tmp_path / "figures" / "mine.png").write_text("mine")
    write_page(page("a", "b"), tmp_path)
    before, replace, calls = contents(tmp_path), Path.replace, []

    def interrupt(self, target):
        calls.append(target)
        if len(calls) == moved + 1:
            raise KeyboardInterrupt
        return replace(self, target)

    with monkeypatch.context() as patched:
        patched.setattr(Path, "replace", interrupt)
        with pytest.raises(KeyboardInterrupt):
            write_page(page("b", "c", summary="New."), tmp_path)
    assert contents(tmp_path) == before
    write_page(page("b", "c", summary="New."), tmp_path)
    assert files(tmp_path) == {
        *PAGES, "figures/b.svg", "figures/c.svg", "figures/mine.png",
    }  # fmt: skip


def test_a_page_whose_process_was_killed_is_put_in_order_by_the_next(tmp_path):
    write_page(page("a", "b"), tmp_path)
    before = contents(tmp_path)
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    command = [sys.executable, "-c", KILLED, "2"]
    assert subprocess.run(command, cwd=tmp_path, env=environment, check=False).returncode == 9
    assert "figures/c.svg" in files(tmp_path)
    with pytest.raises(TypeError):
        write_page(Page("Title", "So.", [Section("One", tables=None)], {}), tmp_path)
    assert contents(tmp_path) == before


WIDE = Table([("a", *range(7)), ("b", *range(7, 14))], [words("name", 0)] + [
    Column(f"number {k}", k) for k in range(1, 8)
])  # fmt: skip
ENGINES = Table(
    [{"x": 1}],
    [words("what", lambda row: "x"), *columns_for(range(1, 9), "engine {}", lambda r, k: k)],
)


def header(lines):
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]


def test_a_wide_table_stands_in_whole_in_the_file_of_details(tmp_path):
    path = write_page(Page("Title", "So.", [Section("One", tables=[WIDE])], {}), tmp_path)
    text, details = path.read_text(), (tmp_path / "report-details.md").read_text()
    first, _, row, _ = header(line for line in text.splitlines() if line.startswith("|"))
    assert first == ["name", *(f"number {k}" for k in range(1, 6))]
    assert row == ["a", "0", "1", "2", "3", "4"]
    assert "[All 8 columns](report-details.md#table-1)" in text
    assert "## One\n\n### Table 1\n" in details
    assert str(WIDE) in details
    assert "[report.md](report.md)" in details
    assert "number 7" in (tmp_path / "report.html").read_text()


def test_a_notable_column_is_shown_unless_it_is_empty():
    def brief(said):
        columns = [*WIDE.columns[:7], Column("no verdict", lambda row: said, notable=True)]
        return header(Table(WIDE.rows, columns).brief("there").splitlines())[0]

    assert brief(None)[-1] == "number 5"
    assert brief("2 timeout")[-2:] == ["number 4", "no verdict"]


def test_columns_that_are_alike_go_on_below_where_two_tables_hold_them(tmp_path):
    path = write_page(Page("Title", "So.", [Section("One", tables=[ENGINES])], {}), tmp_path)
    lines = [line for line in path.read_text().splitlines() if line.startswith("| what")]
    assert header(lines) == [
        ["what", *(f"engine {k}" for k in range(1, 5))],
        ["what", *(f"engine {k}" for k in range(5, 9))],
    ]
    assert files(tmp_path) == set(PAGES)


def test_details_go_with_the_page_that_names_them(tmp_path):
    (tmp_path / "report-details.md").write_text("mine")
    write_page(page(), tmp_path)
    assert (tmp_path / "report-details.md").read_text() == "mine"
    write_page(Page("Title", "So.", [Section("One", tables=[WIDE])], {}), tmp_path)
    write_page(page(), tmp_path)
    assert files(tmp_path) == set(PAGES)

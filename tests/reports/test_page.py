"""A page is written whole or not at all, and leaves alone what is not its own."""

import os
import re
import subprocess
import sys
from pathlib import Path

import matplotlib.figure
import pytest

from steadyload.atomic import LinkError, checksum
from steadyload.reports.pages import writing
from steadyload.reports.pages.page import Page, Picture, Section
from steadyload.reports.pages.writing import write_page
from steadyload.reports.table import Column, Table, columns_for

PAGES = ("report.md", "report.html")
SUM = re.compile(r"\.[0-9a-f]{16}(?=\.)")
"""The checksum in the name of a picture or of details."""


def page(*names, summary="So."):
    pictures = [
        Picture(name, matplotlib.figure.Figure(), f"Shows {name} (once).") for name in names
    ]
    return Page("Title", summary, [Section("One", pictures=pictures)], {"made": "here"})


def files(folder):
    """Names of all files, without checksums."""
    return {SUM.sub("", name) for name in contents(folder)}


def contents(folder):
    found = (p for p in folder.rglob("*") if p.is_file())
    return {str(p.relative_to(folder)): p.read_bytes() for p in found}


def is_whole(folder):
    """Every picture and every file of details that the page links is there, as its name says."""
    text = (folder / "report.md").read_text()
    linked = [name for name in re.findall(r"\]\(([^)#]+)", text) if SUM.search(name)]
    return bool(linked) and all(
        SUM.search(name)[0] == f".{checksum((folder / name).read_bytes())}" for name in linked
    )


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
    before = contents(tmp_path)
    drawn = []

    def interrupt(figure):
        drawn.append(figure)
        if len(drawn) == 2:
            raise KeyboardInterrupt
        return ".svg", b"half"

    monkeypatch.setattr(writing, "image", interrupt)
    with pytest.raises(KeyboardInterrupt):
        write_page(page("a", "c", summary="New."), tmp_path)
    assert contents(tmp_path) == before


def test_a_page_that_cannot_be_made_leaves_the_one_before(tmp_path):
    write_page(page("a"), tmp_path)
    before = contents(tmp_path)
    pictures = page("b").sections[0].pictures
    broken = Page("Title", "So.", [Section("One", tables=None, pictures=pictures)], {})
    with pytest.raises(TypeError):
        write_page(broken, tmp_path)
    assert contents(tmp_path) == before


@pytest.mark.parametrize("moved", [0, 1, 2, 3])
def test_a_page_interrupted_between_two_of_its_files_is_the_one_before(
    tmp_path, monkeypatch, moved
):
    """The HTML file is a page by itself: of both files it may be the one that is new."""
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
    after = contents(tmp_path)
    assert after.keys() == before.keys()
    assert {name for name in after if after[name] != before[name]} <= {"report.html"}
    write_page(page("b", "c", summary="New."), tmp_path)
    assert files(tmp_path) == {
        *PAGES, "figures/b.svg", "figures/c.svg", "figures/mine.png",
    }  # fmt: skip


FORKED = """
import os, sys
from pathlib import Path
import matplotlib.figure
from steadyload.reports.pages import writing
from steadyload.reports.pages.page import Page, Picture, Section
from steadyload.reports.table import Column, Table
folder = Path(sys.argv[2])
def write(kind, folder):
    writing.image = lambda figure: (".svg", kind.encode())
    pictures = [Picture(name, matplotlib.figure.Figure(), "Shows.") for name in ("a", kind)]
    wide = Table([range(9)], [Column(f"{kind} {k}", k) for k in range(9)])
    writing.write_page(Page(kind, "So.", [Section("One", "", [wide], pictures)], {}), folder)
def killed(left):
    write("old", folder / str(left))
    def counting(before):
        def call(*given, **named):
            nonlocal left
            left -= 1
            if left < 0:
                os._exit(9)
            return before(*given, **named)
        return call
    if not os.fork():
        Path.replace, Path.unlink = counting(Path.replace), counting(Path.unlink)
        write("new", folder / str(left))
        os._exit(0)
    return os.wait()[1]
def many(kinds):
    for round in range(60):
        write(kinds[round % len(kinds)], folder)
if sys.argv[1] == "killed":
    left = 0
    while killed(left):
        left += 1
else:
    for kinds in (("one", "two"), ("two", "three", "one")):
        if not os.fork():
            many(kinds)
            os._exit(0)
    sys.exit(any(os.wait()[1] for _ in range(2)))
"""
"""Pages in processes of their own: killed at every change of a name, or two at a time."""


def forked(what, folder):
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    command = [sys.executable, "-c", FORKED, what, str(folder)]
    return subprocess.run(command, env=environment, check=False).returncode


def test_a_page_whose_process_was_killed_at_any_time_is_the_old_one_or_the_new_one(tmp_path):
    assert forked("killed", tmp_path) == 0
    folders = sorted(tmp_path.iterdir(), key=lambda folder: int(folder.name))
    assert len(folders) > 8, "five files are renamed, three removed"
    said = [(folder / "report.md").read_text()[2:5] for folder in folders]
    assert said == sorted(said, reverse=True)
    assert set(said) == {"old", "new"}
    for folder in folders:
        assert is_whole(folder), folder
        write_page(page("x"), folder)
        assert not list(folder.rglob(".*"))


def test_two_that_write_a_page_at_once_both_leave_a_whole_one(tmp_path):
    assert forked("at once", tmp_path) == 0
    assert is_whole(tmp_path)
    assert len(files(tmp_path)) == 5


def test_a_folder_of_pictures_that_is_a_link_is_refused(tmp_path):
    theirs, mine = tmp_path / "theirs", tmp_path / "mine"
    write_page(page("a"), theirs)
    write_page(page("a"), mine)
    before = contents(theirs)
    for file in (mine / "figures").iterdir():
        file.unlink()
    (mine / "figures").rmdir()
    (mine / "figures").symlink_to(theirs / "figures")
    for new in (page("b"), page()):
        with pytest.raises(LinkError, match="figures: is a link, which nothing that is written"):
            write_page(new, mine)
    assert contents(theirs) == before


def test_a_page_that_is_a_link_gives_way_and_what_it_points_to_stays(tmp_path):
    theirs = tmp_path / "theirs.md"
    theirs.write_text(f"![x](figures/x.{'0' * 16}.svg)\n")
    mine = tmp_path / "mine"
    (mine / "figures").mkdir(parents=True)
    named = mine / "figures" / f"x.{'0' * 16}.svg"
    named.write_text("mine")
    for name in PAGES:
        (mine / name).symlink_to(theirs)
    write_page(page(), mine)
    assert theirs.read_text().startswith("![x]")
    assert not (mine / "report.md").is_symlink()
    assert named.exists(), "the page that names it is no page of this folder"


@pytest.mark.parametrize("name", [".report.md.swp", ".report.md.undo", ".report.md.kate-swp"])
def test_what_an_editor_or_an_earlier_version_left_stays(tmp_path, name):
    (tmp_path / name).mkdir() if name.endswith("undo") else (tmp_path / name).write_text("mine")
    write_page(page("a"), tmp_path)
    write_page(page("b"), tmp_path)
    assert (tmp_path / name).exists()
    assert "figures/b.svg" in files(tmp_path)


WIDE = Table([("a", *range(7)), ("b", *range(7, 14))], [Column("name", 0, left=True)] + [
    Column(f"number {k}", k) for k in range(1, 8)
])  # fmt: skip
ENGINES = Table(
    [{"x": 1}],
    [
        Column("what", lambda row: "x", left=True),
        *columns_for(range(1, 9), "engine {}", lambda r, k: k),
    ],
)


def header(lines):
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]


def test_a_wide_table_stands_in_whole_in_the_file_of_details(tmp_path):
    path = write_page(Page("Title", "So.", [Section("One", tables=[WIDE])], {}), tmp_path)
    [beside] = tmp_path.glob("report-details.*.md")
    text, details = path.read_text(), beside.read_text()
    first, _, row, _ = header(line for line in text.splitlines() if line.startswith("|"))
    assert first == ["name", *(f"number {k}" for k in range(1, 6))]
    assert row == ["a", "0", "1", "2", "3", "4"]
    assert f"[All 8 columns]({beside.name}#table-1)" in text
    assert "## One\n\n### Table 1\n" in details
    assert str(WIDE) in details
    assert "[report.md](report.md)" in details
    assert "number 7" in (tmp_path / "report.html").read_text()


def test_further_sections_stand_in_the_file_of_details_and_last_in_the_html_page(tmp_path):
    first, more = (page(name) for name in ("first", "more"))
    (further,) = more.sections
    whole = Section("Further", tables=[WIDE], pictures=further.pictures)
    (picture,) = first.sections[0].pictures
    path = write_page(
        Page("Title", "So.\n\nSince.", [Section("One", "Text.")], {}, picture, [whole]), tmp_path
    )
    [beside] = tmp_path.glob("report-details.*.md")
    text, details = path.read_text(), beside.read_text()
    said = "# Title\n\nSo.\n\n![Shows first (once).](figures/first.*.svg)\n\n"
    said += "*Shows first (once).*\n\nSince.\n\n## One\n\nText.\n\n## Details\n\n"
    assert SUM.sub(".*", text).startswith(f"{said}[Further](report-details.*.md)\n")
    assert "## Further\n" in details
    assert str(WIDE) in details
    assert "![Shows more (once).](figures/more." in details
    assert is_whole(tmp_path)
    html = (tmp_path / "report.html").read_text()
    assert html.index("So.") < html.index("Shows first") < html.index("Since.")
    assert html.index("<h2>One") < html.index("<h2>Further") < html.index("Shows more")
    write_page(page("b"), tmp_path)
    assert files(tmp_path) == {*PAGES, "figures/b.svg"}


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
    write_page(Page("Title", "So.", [Section("One", tables=[WIDE])], {}), tmp_path)
    assert len(contents(tmp_path)) == 4
    write_page(page(), tmp_path)
    assert contents(tmp_path).keys() == {*PAGES, "report-details.md"}
    assert (tmp_path / "report-details.md").read_text() == "mine"

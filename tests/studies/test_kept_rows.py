"""Rows behind pages are packed and unpacked whole, and a page made of them judges nothing."""

from dataclasses import replace
from pathlib import Path

import pytest

from steadyload.cli import main
from steadyload.runs.results import load_results
from steadyload.studies import kept_rows, published
from steadyload.studies.kept_rows import RowsError, keep, kept, unpack

ROOT = Path(__file__).parents[2]


def contents(folder):
    return {p.relative_to(folder): p.read_bytes() for p in folder.rglob("*") if p.is_file()}


@pytest.fixture
def entry(tmp_path):
    found = replace(published.named(("table5",))[0], work=tmp_path / "runs" / "table5")
    for name, text in {"a/rows.parquet": "1", "manifest.json": "2", "b/c/d": "3"}.items():
        (found.work / name).parent.mkdir(parents=True, exist_ok=True)
        (found.work / name).write_text(text)
    return found


def test_rows_come_back_as_they_were_without_page_and_lock(entry, tmp_path):
    before = contents(entry.work)
    for name in (
        ".lock", "report.md", "report.html", "figures/x.svg", "checkpoints/x", "t/checkpoint.pt",
    ):  # fmt: skip
        (entry.work / name).parent.mkdir(exist_ok=True)
        (entry.work / name).write_text("page")
    archive = keep(entry, tmp_path / "rows")
    first = archive.read_bytes()
    assert keep(entry, tmp_path / "rows").read_bytes() == first
    assert unpack(entry, tmp_path / "rows") is None, "what is there stays"
    entry.work.rename(tmp_path / "gone")
    assert unpack(entry, tmp_path / "rows") == entry.work
    assert contents(entry.work) == before


def test_what_is_not_there_is_said(entry, tmp_path):
    lost = replace(entry, work=tmp_path / "nowhere")
    with pytest.raises(RowsError, match=r"steadyload pages remake table5 makes them"):
        keep(lost, tmp_path / "rows")
    assert unpack(lost, tmp_path / "rows") is None
    assert not (tmp_path / "rows").exists()


def test_every_page_has_a_folder_of_its_rows():
    work = {entry.name: str(entry.work) for entry in published.entries()}
    assert work["accuracy"] == "runs/accuracy"
    assert work["properties"] == "runs/properties"
    assert work["table5"] == work["table5_stands"] == "runs/table5"


def test_what_is_kept_is_listed_with_its_size():
    folder = ROOT / published.ROWS
    assert (folder / published.INDEX).read_text() == kept(folder)
    archives = {path.name for path in folder.glob("*.tar.xz")}
    assert archives
    assert archives == {path.name for path in folder.iterdir()} - {published.INDEX}


def test_a_page_of_unpacked_rows_is_the_same_and_judges_nothing(
    tmp_path, monkeypatch, in_this_process, undrawn
):
    monkeypatch.chdir(tmp_path)
    one = published.named(("table5",))[0]
    few = replace(
        one, command=("table5", "--limit", "2", "--timed", "1", "--repeats", "1", "-m", "fbs",
                      "-m", "sme"),
    )  # fmt: skip
    monkeypatch.setattr("steadyload.cli.pages.named", lambda names: [few])
    monkeypatch.setattr(kept_rows, "entries", lambda: [few])
    assert main(["pages", "remake", "table5", "--keep", "-o", "pages", "--rows", "rows"]) == 0
    page = Path("pages/table5/report.md").read_text()
    rows = contents(few.work)
    packed = Path("rows/table5.tar.xz").read_bytes()
    assert main(["pages", "keep", "table5", "--rows", "rows"]) == 0
    assert Path("rows/table5.tar.xz").read_bytes() == packed
    assert "| `table5.tar.xz` |" in Path("rows/README.md").read_text()
    few.work.rename("gone")
    assert main(["pages", "remake", "table5", "--rows", "rows", "-o", "again"]) == 0
    assert Path("again/table5/report.md").read_text() == page
    assert contents(few.work) == rows
    assert len(load_results(few.work / "spatial")) == 12

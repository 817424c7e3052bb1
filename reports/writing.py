"""A page becomes files: Markdown with pictures beside it, and one HTML file."""

from __future__ import annotations

import re
import shutil
from collections.abc import Mapping
from pathlib import Path
from tempfile import TemporaryDirectory

import jinja2

from steadyload.reports.charts import image
from steadyload.reports.html import template_text
from steadyload.reports.page import Page
from steadyload.reports.replacing import put_back, replace_together
from steadyload.reports.report_html import report_html
from steadyload.reports.table import Table

FIGURES = "figures"
"""Folder of the pictures, beside the page."""

DETAILS = "{}-details.md"
"""File beside a page, by the page's name, of the tables that it shows the first columns of."""


def write_page(page: Page, directory: Path, *, name: str = "report.md") -> Path:
    """Write a page and its pictures into ``directory``; returns the path of the Markdown file.

    Beside it, with the ending ``.html``, stands the same page as one file that needs nothing else;
    and a file of :data:`DETAILS` with the whole of those tables that are too wide for Markdown.
    The same page gives the same bytes. Pictures go to ``figures/`` beside the page. All is written
    into a folder of its own first and renamed into place then, as a set: an interruption leaves the
    page before or the new one. Pictures that only the page before had are removed, and nothing else
    is. When the process is killed in between, writing the page again puts all in order.
    """
    path, undo = directory / name, directory / f".{name}.undo"
    directory.mkdir(parents=True, exist_ok=True)
    put_back(directory, undo)
    for unfinished in directory.glob(f".{name}.*"):
        shutil.rmtree(unfinished)
    with TemporaryDirectory(prefix=f".{name}.", dir=directory) as beside:
        fresh = Path(beside)
        (fresh / FIGURES).mkdir()
        images = {p.name: image(p.figure) for section in page.sections for p in section.pictures}
        files = {picture: f"{FIGURES}/{picture}{ending}" for picture, (ending, _) in images.items()}
        for picture, (_, drawn) in images.items():
            (fresh / files[picture]).write_bytes(drawn)
        written = _texts(page, name, files) | {
            str(Path(name).with_suffix(".html")): report_html(page, images)
        }
        for file, text in written.items():
            (fresh / file).write_text(text)
        replace_together(
            directory, fresh, [*files.values(), *written], [*_shown(path), *written], undo
        )
    return path


def _texts(page: Page, name: str, pictures: Mapping[str, str]) -> dict[str, str]:
    """Markdown of a page and of its details, by file; ``pictures`` are files by name."""
    # Markdown is written, not HTML: there is nothing to escape here.
    environment = jinja2.Environment(  # noqa: S701
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        undefined=jinja2.StrictUndefined,
    )
    details = DETAILS.format(Path(name).stem)
    cut = [id(table) for section in page.sections for table in section.cut]

    def number(table: Table) -> int:
        return cut.index(id(table)) + 1

    def brief(table: Table | str) -> str:
        if isinstance(table, str):
            return table
        return table.brief(f"{details}#table-{number(table)}" if table.is_cut else "")

    def written(template: str) -> str:
        return environment.from_string(template_text(template)).render(
            page=page, name=name, files=pictures, brief=brief, number=number
        )

    made = {name: written("page.md.j2")}
    return made | {details: written("details.md.j2")} if cut else made


def _shown(path: Path) -> set[str]:
    """The files of the pictures and details that the page of an earlier run shows."""
    text = path.read_text(errors="replace") if path.exists() else ""
    details = re.escape(DETAILS.format(path.stem))
    found = rf"^!?\[.*\]\(({FIGURES}/[^/)]+|{details}(?=#table-1\)))[^)]*\)$"
    return set(re.findall(found, text, re.MULTILINE))

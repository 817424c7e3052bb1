"""A page becomes files: Markdown with pictures beside it, and one HTML file."""

from __future__ import annotations

import re
import shutil
from pathlib import Path
from tempfile import TemporaryDirectory

import jinja2

from steadyload.reports.charts import image
from steadyload.reports.html import template_text
from steadyload.reports.page import Page
from steadyload.reports.replacing import put_back, replace_together
from steadyload.reports.report_html import report_html

_FIGURES = "figures"
"""Folder of the pictures, beside the page."""


def write_page(page: Page, directory: Path, *, name: str = "report.md") -> Path:
    """Write a page and its pictures into ``directory``; returns the path of the Markdown file.

    Beside it, with the ending ``.html``, stands the same page as one file that needs nothing else.
    The same page gives the same bytes. Pictures go to ``figures/`` beside the page. All is written
    into a folder of its own first and renamed into place then, as a set: an interruption leaves the
    page before or the new one. Pictures that only the page before had are removed, and nothing else
    is. When the process is killed in between, writing the page again puts all in order.
    """
    path, undo = directory / name, directory / f".{name}.undo"
    template = template_text("page.md.j2")
    # Markdown is written, not HTML: there is nothing to escape here.
    environment = jinja2.Environment(  # noqa: S701
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        undefined=jinja2.StrictUndefined,
    )
    directory.mkdir(parents=True, exist_ok=True)
    put_back(directory, undo)
    for unfinished in directory.glob(f".{name}.*"):
        shutil.rmtree(unfinished)
    with TemporaryDirectory(prefix=f".{name}.", dir=directory) as beside:
        fresh = Path(beside)
        (fresh / _FIGURES).mkdir()
        images = {p.name: image(p.figure) for section in page.sections for p in section.pictures}
        files = {
            picture: f"{_FIGURES}/{picture}{ending}" for picture, (ending, _) in images.items()
        }
        for picture, (_, drawn) in images.items():
            (fresh / files[picture]).write_bytes(drawn)
        text = environment.from_string(template).render(page=page, files=files)
        (fresh / name).write_text(text)
        in_browser = str(Path(name).with_suffix(".html"))
        (fresh / in_browser).write_text(report_html(page, images))
        written = [name, in_browser]
        replace_together(
            directory, fresh, [*files.values(), *written], [*_shown(path), *written], undo
        )
    return path


def _shown(path: Path) -> set[str]:
    """The files of the pictures that the page of an earlier run shows."""
    text = path.read_text(errors="replace") if path.exists() else ""
    return set(re.findall(rf"^!\[.*\]\(({_FIGURES}/[^/)]+)\)$", text, re.MULTILINE))

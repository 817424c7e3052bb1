"""Pages: sections of text, tables and figures, written as one folder of Markdown and pictures.

A page is made of :class:`Section` records, whoever fills them: studies, learners and property tests
share this module, and their sections can stand on one page.
"""

from __future__ import annotations

import re
import shutil
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from tempfile import TemporaryDirectory

import jinja2
from matplotlib.figure import Figure

from steadyload.reports.charts import image
from steadyload.reports.replacing import put_back, replace_together
from steadyload.reports.table import Table

_FIGURES = "figures"
"""Folder of the pictures, beside the page."""


@dataclass(frozen=True, slots=True)
class Picture:
    """A figure under its file name, with its caption."""

    name: str
    figure: Figure
    caption: str


@dataclass(frozen=True, slots=True)
class Section:
    """A heading with text, tables (declared, or as Markdown) and pictures, in that order."""

    title: str
    text: str = ""
    tables: Sequence[Table | str] = ()
    pictures: Sequence[Picture] = ()


@dataclass(frozen=True, slots=True)
class Page:
    """A page: its title, a summary, sections, and its provenance."""

    title: str
    summary: str
    sections: Sequence[Section]
    manifest: Mapping[str, str]


def write_page(page: Page, directory: Path, *, name: str = "report.md") -> Path:
    """Write a page and its pictures into ``directory``; returns the path of the Markdown file.

    The same page gives the same bytes. Pictures go to ``figures/`` beside the page. All is written
    into a folder of its own first and renamed into place then, as a set: an interruption leaves the
    page before or the new one. Pictures that only the page before had are removed, and nothing else
    is. When the process is killed in between, writing the page again puts all in order.
    """
    path, undo = directory / name, directory / f".{name}.undo"
    template = resources.files("steadyload.reports.templates").joinpath("page.md.j2").read_text()
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
        files: dict[str, str] = {}
        for picture in (p for section in page.sections for p in section.pictures):
            ending, drawn = image(picture.figure)
            files[picture.name] = f"{_FIGURES}/{picture.name}{ending}"
            (fresh / files[picture.name]).write_bytes(drawn)
        text = environment.from_string(template).render(page=page, files=files)
        (fresh / name).write_text(text)
        replace_together(directory, fresh, [*files.values(), name], [*_shown(path), name], undo)
    return path


def _shown(path: Path) -> set[str]:
    """The files of the pictures that the page of an earlier run shows."""
    text = path.read_text(errors="replace") if path.exists() else ""
    return set(re.findall(rf"^!\[.*\]\(({_FIGURES}/[^/)]+)\)$", text, re.MULTILINE))

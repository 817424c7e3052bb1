"""Pages: sections of text, tables and figures, written as one folder of Markdown and pictures.

A page is made of :class:`Section` records, whoever fills them: studies, learners and property tests
share this module, and their sections can stand on one page.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib import resources
from pathlib import Path

import jinja2
from matplotlib.figure import Figure

from steadyload.reports.charts import image
from steadyload.reports.table import Table


@dataclass(frozen=True, slots=True)
class Picture:
    """A figure under its file name, with the sentence that says what to see in it."""

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
    """A page: its title, a summary, sections, and what it was made with."""

    title: str
    summary: str
    sections: Sequence[Section]
    manifest: Mapping[str, str]


def write_page(page: Page, directory: Path, *, name: str = "report.md") -> Path:
    """Write a page and its pictures into ``directory``; returns the path of the Markdown file.

    The same page gives the same bytes. Pictures go to ``figures/`` beside the page.
    """
    pictures = [p for section in page.sections for p in section.pictures]
    if pictures:
        (directory / "figures").mkdir(parents=True, exist_ok=True)
    files: dict[str, str] = {}
    for picture in pictures:
        ending, drawn = image(picture.figure)
        files[picture.name] = f"figures/{picture.name}{ending}"
        (directory / files[picture.name]).write_bytes(drawn)
    template = resources.files("steadyload.reports.templates").joinpath("page.md.j2").read_text()
    # Markdown is written, not HTML: there is nothing to escape here.
    environment = jinja2.Environment(  # noqa: S701
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        undefined=jinja2.StrictUndefined,
    )
    directory.mkdir(parents=True, exist_ok=True)
    path = directory / name
    path.write_text(environment.from_string(template).render(page=page, files=files))
    return path

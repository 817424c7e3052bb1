"""A page becomes files: Markdown with pictures beside it, and one HTML file."""

from __future__ import annotations

import fcntl
import os
import re
import tempfile
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path

import jinja2

from steadyload.atomic import (
    CHECKSUM_DIGITS,
    checksum,
    clear_unfinished,
    not_a_link,
    write_atomically,
)
from steadyload.reading import MAX_STORED_BYTES, content_of
from steadyload.reports.charts.drawing import image
from steadyload.reports.html import template_text
from steadyload.reports.pages.page import Block, Page, Picture
from steadyload.reports.pages.report_html import report_html
from steadyload.reports.table import Table

FIGURES = "figures"
"""Folder of the pictures, beside the page."""

DETAILS = "{}-details.{}.md"
"""File beside a page, by the page's name and a checksum, of its further sections and of the tables
that it shows the first columns of."""

_SUM = rf"[0-9a-f]{{{CHECKSUM_DIGITS}}}"


def write_page(page: Page, directory: Path, *, name: str = "report.md") -> Path:
    """Write a page and its pictures into ``directory``; returns the path of the Markdown file.

    Beside it, with the ending ``.html``, stands the same page as one file that needs nothing else;
    and a file of :data:`DETAILS` with its further sections and the whole of those tables that are
    too wide for Markdown.
    The same page gives the same bytes. Pictures go to ``figures/`` beside the page.

    Names of pictures and details have a checksum of their content, so that those of the page before
    stay as they are until the Markdown file, the last one, is renamed into place: an interruption
    at any time leaves the page before or the new one. What only the page before shows is removed
    then, if its name is such a name, and nothing else is. Links are not followed. A second process
    that writes a page into the folder waits for the first.

    Raises:
        LinkError: the folder of pictures is a link.
        OSError: a file cannot be written.
    """
    directory.mkdir(parents=True, exist_ok=True)
    images = {p.name: image(p.figure) for p in page.drawn}
    files = {
        picture: f"{FIGURES}/{picture}.{checksum(drawn)}{ending}"
        for picture, (ending, drawn) in images.items()
    }
    pictures = {files[picture]: drawn for picture, (_, drawn) in images.items()}
    *details, markdown = _texts(page, name, files)
    shown = pictures | {file: text.encode() for file, text in details}
    html = report_html(page, images)
    path = directory / name
    with _one_at_a_time(directory):
        clear_unfinished(directory, f"{path.stem}*")
        clear_unfinished(not_a_link(directory / FIGURES), "*")
        before = _shown(path)
        new = {file for file in shown if not os.path.lexists(directory / file)}
        try:
            if pictures:
                (directory / FIGURES).mkdir(exist_ok=True)
            for file, content in shown.items():
                write_atomically(directory / file, content)
            write_atomically(path.with_suffix(".html"), html)
            write_atomically(path, markdown[1])
        except BaseException:
            _remove(directory, new - _shown(path))
            raise
        _remove(directory, before - shown.keys())
    return path


def check_folder(directory: Path) -> None:
    """Raise what would keep a page from being written into a folder, which is not made yet.

    Raises:
        LinkError: the folder of pictures is a link.
        OSError: it is no folder, or nothing can be written there.
    """
    not_a_link(directory / FIGURES)
    there = next(path for path in (directory, *directory.parents) if os.path.lexists(path))
    try:
        with tempfile.TemporaryFile(dir=there):
            pass
    except OSError as error:
        raise type(error)(error.errno, error.strerror, str(there)) from None


@contextmanager
def _one_at_a_time(directory: Path) -> Iterator[None]:
    """Wait until no other process writes a page into a folder."""
    handle = os.open(directory, os.O_RDONLY | os.O_DIRECTORY)
    try:
        with suppress(OSError):  # some network file systems lock no folders
            fcntl.flock(handle, fcntl.LOCK_EX)
        yield
    finally:
        os.close(handle)


def _remove(directory: Path, files: Iterable[str]) -> None:
    for file in files:
        (directory / file).unlink(missing_ok=True)


def _texts(page: Page, name: str, pictures: Mapping[str, str]) -> list[tuple[str, str]]:
    """Files and Markdown of a page's details, if any, and of the page, which links them.

    ``pictures`` are files by name.
    """
    # Markdown is written, not HTML: there is nothing to escape here.
    environment = jinja2.Environment(  # noqa: S701
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        undefined=jinja2.StrictUndefined,
    )
    details = ""
    cut = [id(table) for section in page.sections for table in section.cut]

    def number(table: Table) -> int:
        return cut.index(id(table)) + 1

    def drawn(picture: Picture) -> str:
        return f"![{picture.caption}]({pictures[picture.name]})\n\n*{picture.caption}*"

    def brief(block: Block) -> str:
        if isinstance(block, Table):
            return block.brief(f"{details}#table-{number(block)}" if block.is_cut else "")
        return block if isinstance(block, str) else drawn(block)

    def written(template: str) -> str:
        return environment.from_string(template_text(template)).render(
            page=page, name=name, details=details, drawn=drawn, brief=brief, number=number
        )

    made = []
    if cut or page.details:
        text = written("details.md.j2")
        details = DETAILS.format(Path(name).stem, checksum(text.encode()))
        made = [(details, text)]
    return [*made, (name, written("page.md.j2"))]


def _shown(path: Path) -> set[str]:
    """The files that a page and its details show and whose names this module makes."""
    if path.is_symlink() or not path.is_file():
        return set()
    text = content_of(path, MAX_STORED_BYTES).decode(errors="replace")
    picture = rf"{FIGURES}/[^/)]+\.{_SUM}\.(?:svg|png)"
    details = rf"{re.escape(path.stem)}-details\.{_SUM}\.md"
    line = rf"^!?\[.*\]\(({picture}|{details})[^)]*\)$"
    found = set(re.findall(line, text, re.MULTILINE))
    return found.union(*(_shown(path.with_name(name)) for name in found if name.endswith(".md")))

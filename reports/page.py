"""Pages: sections of text, tables and figures, written as Markdown with pictures, and as HTML.

A page is made of :class:`Section` records, whoever fills them: studies, learners and property tests
share this module, and their sections can stand on one page.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from matplotlib.figure import Figure

from steadyload.reports.interactive import Interactive
from steadyload.reports.table import Table


@dataclass(frozen=True, slots=True)
class Picture:
    """A figure under its file name, with its caption.

    ``interactive``: a chart that stands in its place in the HTML page, with its own caption where
    it has one.
    """

    name: str
    figure: Figure
    caption: str
    interactive: Interactive | None = None


@dataclass(frozen=True, slots=True)
class Section:
    """A heading with text, tables (declared, or as Markdown) and pictures, in that order."""

    title: str
    text: str = ""
    tables: Sequence[Table | str] = ()
    pictures: Sequence[Picture] = ()

    @property
    def cut(self) -> tuple[Table, ...]:
        """Tables that a Markdown page shows the first columns of."""
        return tuple(t for t in self.tables if isinstance(t, Table) and t.is_cut)


@dataclass(frozen=True, slots=True)
class Page:
    """A page: its title, a summary, sections, and its provenance."""

    title: str
    summary: str
    sections: Sequence[Section]
    manifest: Mapping[str, str]

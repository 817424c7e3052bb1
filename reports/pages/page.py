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


Block = str | Table | Picture
"""A part of a section: Markdown, a table, or a picture."""


@dataclass(frozen=True, slots=True)
class Section:
    """A heading with text, tables (declared, or as Markdown) and pictures, in that order.

    ``placed``: further blocks, in any order, before them.
    """

    title: str
    text: str = ""
    tables: Sequence[Table | str] = ()
    pictures: Sequence[Picture] = ()
    placed: Sequence[Block] = ()

    @property
    def blocks(self) -> list[Block]:
        """All blocks in their order."""
        return [b for b in (*self.placed, self.text, *self.tables, *self.pictures) if b]

    @property
    def charts_first(self) -> list[Block]:
        """The blocks as a browser shows them."""
        return sorted(self.blocks, key=lambda b: not (isinstance(b, Picture) and b.interactive))

    @property
    def drawn(self) -> list[Picture]:
        """All pictures."""
        return [block for block in self.blocks if isinstance(block, Picture)]

    @property
    def cut(self) -> tuple[Table, ...]:
        """Tables that a Markdown page shows the first columns of."""
        return tuple(t for t in self.blocks if isinstance(t, Table) and t.is_cut)


@dataclass(frozen=True, slots=True)
class Page:
    """A page: its title, a summary, sections, and its provenance.

    ``figure`` stands behind the first paragraph of the summary; ``details`` are sections that the
    Markdown page links, and the HTML page shows last.
    """

    title: str
    summary: str
    sections: Sequence[Section]
    manifest: Mapping[str, str]
    figure: Picture | None = None
    details: Sequence[Section] = ()

    @property
    def drawn(self) -> list[Picture]:
        """All pictures."""
        placed = [p for section in (*self.sections, *self.details) for p in section.drawn]
        return ([self.figure] if self.figure else []) + placed

    @property
    def parts_of_summary(self) -> tuple[str, str]:
        """The first paragraph of the summary, which is the answer, and the others."""
        first, _, rest = self.summary.partition("\n\n")
        return first, rest

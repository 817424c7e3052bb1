"""Facts of a Markdown page: cells of its tables, sentences with a number, names of its figures."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any

CLOCK = "<clock>"
"""Stands for a value that a clock, a date, a machine or a version decides."""

_RULE = re.compile(r"^\|(\s*:?-+:?\s*\|)+\s*$")
_BAR = re.compile(r"(?<!\\)\|")
_IMAGE = re.compile(r"!\[[^\]]*\]\(([^)]+)\)")
_SENTENCE = re.compile(r"(?<=[.!?])\s+(?=[A-Z*`(\d])")
_DIGEST = re.compile(r"\b(?=[0-9a-f]*[a-f])(?=[0-9a-f]*\d)[0-9a-f]{8,64}\b")
_NUMBER = re.compile(r"\d+(?:[.,]\d+)*(?:e-?\d+)?")

Mask = Callable[[str, str], str]
"""Text with what clocks decide masked, from its place (a column, or a heading) and itself."""


@dataclass
class Table:
    """Rows of a table under its nearest heading; cells are text as on the page."""

    heading: str
    columns: list[str]
    rows: list[list[str]] = field(default_factory=list)

    def key_size(self) -> int:
        """Number of leading cells that name a row: the fewest that no two rows share."""
        for size in range(1, len(self.columns)):
            if len({tuple(row[:size]) for row in self.rows}) == len(self.rows):
                return size
        return max(1, len(self.columns) - 1)


@dataclass
class Page:
    """Facts of a page."""

    tables: list[Table] = field(default_factory=list)
    sentences: list[tuple[str, str]] = field(default_factory=list)
    figures: list[str] = field(default_factory=list)

    def to_json(self) -> dict[str, Any]:
        """A form for a file."""
        return {
            "tables": [vars(table) for table in self.tables],
            "sentences": [list(sentence) for sentence in self.sentences],
            "figures": self.figures,
        }

    @classmethod
    def from_json(cls, content: dict[str, Any]) -> Page:
        """The page that a file holds."""
        return cls(
            [Table(**table) for table in content["tables"]],
            [(heading, text) for heading, text in content["sentences"]],
            list(content["figures"]),
        )

    def fact_count(self) -> int:
        """Number of cells beside keys, sentences and figures."""
        cells = sum(len(t.rows) * (len(t.columns) - t.key_size()) for t in self.tables)
        return cells + len(self.sentences) + len(self.figures)


@dataclass(frozen=True)
class Cell:
    """A cell, and what names its row: pairs of column and text."""

    heading: str
    key: tuple[tuple[str, str], ...]
    column: str
    value: str

    def __str__(self) -> str:
        return f"{self.heading} | {', '.join(text for _, text in self.key)} | {self.column}"


def cells(table: Table) -> Iterator[Cell]:
    """Every cell beside the keys."""
    size = table.key_size()
    for row in table.rows:
        key = tuple(zip(table.columns[:size], row[:size], strict=True))
        for column, value in zip(table.columns[size:], row[size:], strict=True):
            yield Cell(table.heading, key, column, value)


def numbers(text: str) -> list[str]:
    """The numbers of a text, sorted."""
    return sorted(_NUMBER.findall(text))


def read_page(markdown: str) -> Page:
    """The facts of a page."""
    page, section, part, table = Page(), "", "", None
    lines = _DIGEST.sub("<hash>", markdown).splitlines()
    for line, following in zip(lines, [*lines[1:], ""], strict=True):
        text = line.strip()
        if not text.startswith("|"):
            table = None
        if text.startswith("#"):
            section, part = text.lstrip("# "), ""
        elif re.fullmatch(r"\*\*[^*]+\*\*", text):
            part = text.strip("*")
        elif text.startswith("|"):
            heading = f"{section} / {part}" if part else section
            if _RULE.match(following.strip()) and table is None:
                table = Table(heading, _distinct(_row(text)))
                page.tables.append(table)
            elif table is not None and not _RULE.match(text):
                table.rows.append(_row(text))
        else:
            page.figures += [name.rsplit("/", 1)[-1] for name in _IMAGE.findall(text)]
            page.sentences += [(section, said) for said in _sentences(_IMAGE.sub("", text))]
    return page


def masked(page: Page, mask: Mask) -> Page:
    """The page without what clocks decide."""
    return Page(
        [
            Table(
                table.heading,
                table.columns,
                [
                    [mask(f"{table.heading} | {row[0]} | {column}", text) if text != "-" else text
                     for column, text in zip(table.columns, row, strict=True)]
                    for row in table.rows
                ],
            )
            for table in page.tables
        ],
        [(heading, mask(heading, text)) for heading, text in page.sentences],
        page.figures,
    )  # fmt: skip


def _row(line: str) -> list[str]:
    return [cell.strip() for cell in _BAR.split(line.strip())[1:-1]]


def _distinct(columns: list[str]) -> list[str]:
    return [
        name if columns.index(name) == place else f"{name} #{columns[:place].count(name) + 1}"
        for place, name in enumerate(columns)
    ]


def _sentences(text: str) -> list[str]:
    whole = re.sub(r"^([-*]|\d+\.)\s+", "", text)
    return [said.strip() for said in _SENTENCE.split(whole) if re.search(r"\d", said)]

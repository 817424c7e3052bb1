"""Numbers and tables as Markdown. One place decides how an estimate or a time reads."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from operator import attrgetter
from typing import Any

from steadyload.statistics.estimate import Estimate

MISSING = "-"

_BAR = re.compile(r"(?<!\\)((?:\\\\)*)\|")
"""A bar that no backslash takes for text."""


def percent(estimate: Estimate | None) -> str:
    """``83.6 [81.2, 85.9]``: per cent with the interval."""
    if estimate is None or math.isnan(estimate.value):
        return MISSING
    # Adding 0 takes the sign off a zero.
    value, low, high = (
        round(100.0 * v, 1) + 0.0 for v in (estimate.value, estimate.low, estimate.high)
    )
    return f"{value:.1f} [{low:.1f}, {high:.1f}]"


def milliseconds(estimate: Estimate | None) -> str:
    """``12.3 [11.9, 12.8]`` with three significant digits."""
    if estimate is None or math.isnan(estimate.value):
        return MISSING
    return (
        f"{significant(estimate.value)} [{significant(estimate.low)}, {significant(estimate.high)}]"
    )


def factor(estimate: Estimate | None) -> str:
    """``0.21 [0.19, 0.24]``: a ratio with two significant digits."""
    if estimate is None or math.isnan(estimate.value):
        return MISSING
    return f"{compact(estimate.value)} [{compact(estimate.low)}, {compact(estimate.high)}]"


def duration(seconds: float) -> str:
    """``45 s``, ``12 min`` or ``3.4 h``: a time in the unit that suits it."""
    if seconds < 100.0:
        return f"{compact(seconds)} s"
    if seconds < 100.0 * 60.0:
        return f"{compact(seconds / 60.0)} min"
    return f"{compact(seconds / 3600.0)} h"


def significant(value: float, digits: int = 3) -> str:
    """A number with ``digits`` significant digits and no exponent."""
    if value == 0.0 or not math.isfinite(value):
        return f"{value:g}"
    decimals = max(0, digits - 1 - math.floor(math.log10(abs(value))))
    return f"{value:.{decimals}f}"


def compact(value: float, digits: int = 2) -> str:
    """A number of any size with ``digits`` significant digits; very small ones with exponent."""
    text = f"{value:.{digits - 1}e}"
    if 0.0 < abs(value) < 1e-4:
        return text
    return significant(float(text), digits)  # rounded first: 0.0998 is 0.10, not 0.100


def names(items: Iterable[str]) -> str:
    """Names in one cell; a dash when there are none."""
    return ", ".join(items) or MISSING


@dataclass(frozen=True, slots=True)
class Column:
    """A column of a table: its title, where its value stands in a row, and how it reads.

    Args:
        title: as it stands in the header.
        value: of a row: the name of an attribute, with dots for attributes of attributes, or a
            function.
        format: makes the cell's text of the value.
        left: aligned left, as words are; numbers are aligned right.
    """

    title: str
    value: str | Callable[[Any], Any]
    format: Callable[[Any], str] = str
    left: bool = False

    def cell(self, row: Any) -> str:
        """The text of this column in a row."""
        value = attrgetter(self.value) if isinstance(self.value, str) else self.value
        return self.format(value(row))


@dataclass(frozen=True, slots=True)
class Table:
    """A table, declared over rows: it reads as Markdown where it is printed."""

    rows: Sequence[Any]
    columns: Sequence[Column]

    def __str__(self) -> str:
        return _markdown(
            [column.title for column in self.columns],
            ([column.cell(row) for column in self.columns] for row in self.rows),
            [column.left for column in self.columns],
        )


def markdown_table(header: Sequence[str], rows: Iterable[Sequence[str]], *, left: int = 1) -> str:
    """A Markdown table, padded so that it also reads well as text.

    Args:
        header: column titles.
        rows: cells as text; ``|`` and line breaks are escaped.
        left: how many columns are aligned left; the others are aligned right.
    """
    return _markdown(header, rows, [index < left for index in range(len(header))])


def _markdown(header: Sequence[str], rows: Iterable[Sequence[str]], left: Sequence[bool]) -> str:
    cells = [[_escaped(c) for c in row] for row in (header, *rows)]
    widths = [max(3, *(len(row[i]) for row in cells)) for i in range(len(header))]

    def line(row: Sequence[str]) -> str:
        padded = (
            cell.ljust(width) if is_left else cell.rjust(width)
            for cell, width, is_left in zip(row, widths, left, strict=True)
        )
        return f"| {' | '.join(padded)} |"

    rule = (
        "-" * width if is_left else "-" * (width - 1) + ":"
        for width, is_left in zip(widths, left, strict=True)
    )
    return "\n".join([line(cells[0]), f"| {' | '.join(rule)} |", *map(line, cells[1:])])


def _escaped(cell: str) -> str:
    return _BAR.sub(r"\1\\|", cell).replace("\n", " ")

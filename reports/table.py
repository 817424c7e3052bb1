"""Numbers and tables as Markdown. One place decides how an estimate or a time reads."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from operator import attrgetter
from typing import Any, NamedTuple, TypeVar

from steadyload.statistics.estimate import Estimate

MISSING = "-"

MOST_COLUMNS = 6
"""Columns side by side on a Markdown page; its file of details has the others."""

Key = TypeVar("Key")

_BAR = re.compile(r"(?<!\\)((?:\\\\)*)\|")
"""A bar that no backslash takes for text."""


def cell(value: Any) -> str:
    """A value as it stands; a dash for none."""
    return MISSING if value is None else str(value)


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


def decimal(estimate: Estimate | None, digits: int = 2) -> str:
    """``1.02 [0.97, 1.07]``: fixed digits; no interval where none is known."""
    if estimate is None or math.isnan(estimate.value):
        return MISSING
    if math.isnan(estimate.low):
        return f"{estimate.value:.{digits}f}"
    return f"{estimate.value:.{digits}f} [{estimate.low:.{digits}f}, {estimate.high:.{digits}f}]"


def one_decimal(estimate: Estimate | None) -> str:
    """``1.0 [0.9, 1.1]``: likewise, with one digit after the point."""
    return decimal(estimate, digits=1)


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


def brief_time(seconds: float) -> str:
    """``12.3 ms`` or ``3.40 s``: the time of a judgement."""
    return f"{significant(1e3 * seconds)} ms" if seconds < 1.0 else f"{significant(seconds)} s"


def plain_percent(value: float | None, digits: int = 1) -> str:
    """``83.6``: a share in per cent without an interval."""
    return MISSING if value is None else f"{100.0 * value:.{digits}f}"


def least_shown(difference: float | None) -> str:
    """``1.2``: the least difference that cases show, in points; missing where they show none."""
    shows = difference and math.isfinite(difference)
    return plain_percent(difference) if shows else MISSING


def general(value: float | None) -> str:
    """A number in its shortest form."""
    return MISSING if value is None else f"{value:g}"


def significant(value: float | None, digits: int = 3) -> str:
    """A number with ``digits`` significant digits and no exponent."""
    if value is None:
        return MISSING
    if value == 0.0 or not math.isfinite(value):
        return f"{value:g}"
    decimals = max(0, digits - 1 - math.floor(math.log10(abs(value))))
    return f"{value:.{decimals}f}"


def compact(value: float | None, digits: int = 2) -> str:
    """A number of any size with ``digits`` significant digits; very small ones with exponent."""
    if value is None:
        return MISSING
    text = f"{value:.{digits - 1}e}"
    if 0.0 < abs(value) < 1e-4:
        return text
    return significant(float(text), digits)  # rounded first: 0.0998 is 0.10, not 0.100


def fixed(value: float | None, digits: int = 0) -> str:
    """A number with fixed digits."""
    return MISSING if value is None else f"{value:.{digits}f}"


def p_value(p: float | None) -> str:
    """The level of a test with two significant digits."""
    return MISSING if p is None else compact(p) if p >= 1e-4 else "< 0.0001"


def yes_no(true: bool) -> str:
    """A truth value as a word."""
    return "yes" if true else "no"


def names(items: Iterable[str]) -> str:
    """Names in one cell; a dash when there are none."""
    return ", ".join(items) or MISSING


def counts(numbers: Mapping[str, int]) -> str:
    """``3 timeout, 1 error``: numbers by name in one cell; a dash when there are none."""
    return names(f"{number} {name}" for name, number in numbers.items())


class Shown(NamedTuple):
    """How a column of frames is shown.

    Attributes:
        title: its header; of a column ``NAME:KEY`` it holds ``{}`` in the place of the key.
        form: makes the cell's text of the value.
        left: whether its cells are aligned left; None: where they are texts.
        notable: see :class:`Column`.
    """

    title: str
    form: Callable[[Any], str] = cell
    left: bool | None = None
    notable: bool = False


@dataclass(frozen=True, slots=True)
class Column:
    """A column of a table: its title, where its value stands in a row, and how it reads.

    Args:
        title: as it stands in the header.
        value: of a row: the name of an attribute, with dots for attributes of attributes, the
            place in a tuple, or a function; empty where the attribute is named as the title.
        format: makes the cell's text of the value.
        left: aligned left, as words are; numbers are aligned right.
        alike: one of several that show the same of something else, as of every engine.
        notable: shown where room is short, too, unless all its cells are empty.
    """

    title: str
    value: str | int | Callable[[Any], Any] = ""
    format: Callable[[Any], str] = cell
    left: bool = False
    alike: bool = False
    notable: bool = False

    def cell(self, row: Any) -> str:
        """The text of this column in a row."""
        if isinstance(self.value, int):
            return self.format(row[self.value])
        of = self.value if callable(self.value) else attrgetter(self.value or self.title)
        return self.format(of(row))


def columns_for(
    keys: Iterable[Key],
    title: str | Callable[[Key], str],
    value: str | Callable[[Any, Key], Any],
    form: Callable[[Any], str] = cell,
) -> list[Column]:
    """A column for every key, such as every scenario or engine.

    Args:
        keys: of the columns.
        title: text with ``{}`` in the place of the key, or a function of the key.
        value: of a row and a key; or the name of an attribute of rows that maps keys to values, of
            which a missing one is None.
        form: makes the cell's text of the value.
    """

    def column(key: Key) -> Column:
        named = title.format(key) if isinstance(title, str) else title(key)
        if isinstance(value, str):
            return Column(named, lambda row: attrgetter(value)(row).get(key), form, alike=True)
        return Column(named, lambda row: value(row, key), form, alike=True)

    return [column(key) for key in keys]


@dataclass(frozen=True, slots=True)
class Table:
    """A table, declared over rows: it reads as Markdown where it is printed.

    Args:
        rows: records, or tuples.
        columns: of the table.
        caption: a paragraph that stands before it.
    """

    rows: Iterable[Any]
    columns: Sequence[Column]
    caption: str = ""

    def __str__(self) -> str:
        return self._with_caption(self._printed(self.columns))

    @property
    def is_cut(self) -> bool:
        """True if :meth:`brief` leaves out columns."""
        return len(self.columns) > MOST_COLUMNS and not self._folds

    def brief(self, details: str) -> str:
        """The table with at most :data:`MOST_COLUMNS` columns side by side.

        Columns that are alike go on in a second table where two hold them all. Of other tables the
        first columns and notable ones are shown, with a link to the whole.

        Args:
            details: address of the whole table; not needed where nothing is left out.
        """
        if not self.is_cut:
            return self._with_caption(
                "\n\n".join(map(self._printed, self._folds or (self.columns,)))
            )
        notable = [
            column
            for column in self.columns[MOST_COLUMNS:]
            if column.notable and any(column.cell(row) != MISSING for row in self.rows)
        ]
        shown = self._printed([*self.columns[: MOST_COLUMNS - len(notable)], *notable])
        return self._with_caption(f"{shown}\n\n[All {len(self.columns)} columns]({details})")

    @property
    def _folds(self) -> Sequence[Sequence[Column]]:
        """Columns of the two tables of one that is wide and goes on below; empty for others."""
        labels = next((k for k, column in enumerate(self.columns) if column.alike), 0)
        first, alike = self.columns[:labels], self.columns[labels:]
        half = math.ceil(len(alike) / 2)
        fits = labels + half <= MOST_COLUMNS < len(self.columns)
        if not labels or not fits or not all(column.alike for column in alike):
            return ()
        return [*first, *alike[:half]], [*first, *alike[half:]]

    def _with_caption(self, printed: str) -> str:
        return f"{self.caption}\n\n{printed}" if self.caption else printed

    def _printed(self, columns: Sequence[Column]) -> str:
        return _markdown(
            [column.title for column in columns],
            ([column.cell(row) for column in columns] for row in self.rows),
            [column.left for column in columns],
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

"""CSV files of measurements: comments before the header, then rows as many as its columns."""

from __future__ import annotations

import csv
import io
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from itertools import chain

from steadyload.errors import UserError, nearest
from steadyload.escaping import printable, shown
from steadyload.layouts.files.csv_cells import number
from steadyload.layouts.files.limits import MAX_NUMBER_LENGTH, MAX_TEXT_LENGTH

SEPARATORS = ",;\t"

MAX_COMMENTS = 100
"""Lines of comments before a header."""

_COMMENT = ("#", '"#')


@dataclass(frozen=True)
class CsvRows:
    """A CSV file, opened.

    Attributes:
        comments: texts of the lines before the header that begin with ``#``, without that sign.
        header: names of the columns, as the file states them.
        rows: cells of every row that is not empty, with the number of its line.
    """

    comments: tuple[str, ...]
    header: tuple[str, ...]
    rows: Iterator[tuple[int, list[str]]]


def csv_rows(content: bytes, known: Collection[str], error: type[UserError]) -> CsvRows:
    """Comments, header and rows of a CSV file.

    What parts columns is what parts the header into the most known names: a comma, a semicolon or a
    tab.

    Args:
        content: of the file: UTF-8, with or without a byte order mark.
        known: names of columns.
        error: what is raised where the file is no such CSV; of rows, while they are read.
    """
    try:
        lines = io.StringIO(content.decode("utf-8-sig"), newline="")
    except UnicodeDecodeError as found:
        raise error(f"is not UTF-8 text (byte {found.start}); save it as UTF-8") from None
    comments: list[str] = []
    line, before = "", 0
    for line in lines:
        if line.startswith(_COMMENT):
            comments.append(_comment(line))
        elif line.strip():
            break
        before += 1
    else:
        raise error("has no header; allowed: a line of names of columns, then one a row")
    names = {name.casefold() for name in known}
    counts = {m: sum(_plain(c) in names for c in line.split(m)) for m in SEPARATORS}
    separator = max(counts, key=lambda mark: counts[mark])
    reader = csv.reader(chain([line], lines), strict=True, delimiter=separator)
    rows = _checked(reader, before, error)
    header = next(rows)[1]
    return CsvRows(tuple(comments), tuple(header), _of_length(rows, len(header), error))


def _comment(line: str) -> str:
    """Text of a comment; a spreadsheet adds separators, or quotes."""
    text = line.strip().strip('"').rstrip("".join(SEPARATORS)).strip('"').lstrip("# ")
    return printable(text.strip(), MAX_TEXT_LENGTH)


def _plain(cell: str) -> str:
    return cell.strip().strip('"').strip().casefold()


def _checked(
    reader: Iterator[list[str]], before: int, error: type[UserError]
) -> Iterator[tuple[int, list[str]]]:
    try:
        for row in reader:
            line = before + reader.line_num  # type: ignore[attr-defined]
            longest = max(map(len, row), default=0)
            if longest > MAX_TEXT_LENGTH:
                raise error(
                    f"line {line} has a cell of {longest} characters; allowed: {MAX_TEXT_LENGTH}"
                )
            if any(row):
                yield line, row
    except csv.Error as found:
        line = before + reader.line_num  # type: ignore[attr-defined]
        raise error(f"line {line} is not CSV ({printable(str(found))})") from None


def _of_length(
    rows: Iterator[tuple[int, list[str]]], count: int, error: type[UserError]
) -> Iterator[tuple[int, list[str]]]:
    for line, row in rows:
        if len(row) != count:
            raise error(f"line {line} has {len(row)} values; allowed: {count}, as the header says")
        yield line, row


def places(
    header: Sequence[str],
    known: Collection[str],
    required: Collection[str],
    error: type[UserError],
    other: str = "",
) -> dict[str, int]:
    """Place of every known column in a header; capitals do not matter.

    Args:
        header: names as the file states them.
        known: names that are allowed, and all that are required.
        required: names that must be there.
        error: what is raised: a column is unknown, missing, or there twice.
        other: what else may be done about an unknown column.
    """
    names = {name.casefold(): name for name in known}
    found: dict[str, int] = {}
    for place, stated in enumerate(header):
        name = names.get(stated.strip().casefold())
        if name is None:
            close = nearest(stated.strip(), known)
            raise error(f"has the unknown column {shown(stated)}; {close}{other}")
        if name in found:
            raise error(f"has the column {name!r} twice; allowed: once")
        found[name] = place
    for name in required:
        if name not in found:
            raise error(
                f"has no column {name!r}; allowed: {', '.join(required)} and, where they are "
                f"known, {', '.join(sorted(set(known) - set(required)))}"
            )
    return found


def number_in(cell: str) -> float | None:
    """The number that a cell states, with a decimal point or comma; None for another text."""
    text = cell.strip()
    if len(text) <= MAX_NUMBER_LENGTH and text.isascii() and "_" not in text:
        try:
            return float(text)
        except ValueError:
            pass
    found = number(text)
    return None if found is None else float(found)

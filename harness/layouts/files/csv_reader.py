"""Reader of CSV files: one row an item, bytes in, records out, one layout after the other."""

from __future__ import annotations

import csv
import logging
import re
from codecs import BOM_UTF8
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from decimal import Decimal
from itertools import chain
from typing import Any

from steadyload.escaping import printable
from steadyload.layouts.files.csv_cells import minus_half, number, times, unguarded
from steadyload.layouts.files.csv_columns import (
    SEPARATORS,
    Columns,
    find_columns,
    separator_of,
    turns,
    warn_of_turning,
)
from steadyload.layouts.files.dialect import LOADS, Dialect, sides_of
from steadyload.layouts.files.limits import MAX_ITEMS, MAX_LAYOUTS, MAX_TEXT_LENGTH
from steadyload.layouts.files.record import FormatError, Record, Refused, shown
from steadyload.layouts.files.sources import decoded
from steadyload.layouts.model.layout import LayoutError
from steadyload.layouts.model.units import UNITS, WEIGHT_UNITS

CSV_COLUMNS = (
    "layout",
    "pallet_width",
    "pallet_height",
    "pallet_depth",
    "sequence",
    "item",
    "x",
    "y",
    "z",
    "width",
    "height",
    "depth",
    "weight",
    "offset_x",
    "offset_y",
    "offset_z",
)
"""Columns of a file as it is written here."""

_SEPARATOR_LINE = re.compile(r"sep=([;,\t]?)")
"""First line by which a spreadsheet is told the separator."""

WINDOWS = "cp1252"
"""The encoding of CSV files of Excel in Western Europe."""

_log = logging.getLogger("steadyload")

_CHUNK = 1 << 16
"""Bytes that are split into lines at a time."""

_SIZES = ("width", "height", "depth")
_ONE = Decimal(1)
TURNED = {"y": (0, 1, 2), "z": (1, 2, 0)}
"""Axis that points up -> which of the file's axes are our x, y and z."""


def is_csv(line: str, dialect: Dialect) -> bool:
    """True if a file's first line is a header with a column that the dialect knows."""
    return bool(_SEPARATOR_LINE.fullmatch(line)) or separator_of(line, dialect) is not None


def read_csv(
    content: bytes | bytearray, dialect: Dialect, file: str | None = "CSV"
) -> Iterator[Record | Refused]:
    """Records of a CSV file, in the order in which their layouts first appear.

    Rows of a layout stand together, in any order: a first pass finds those that do not, so that
    the second one holds one layout at a time. A column left out that states how boxes are turned is
    told as a warning that names the ``file``; None for no warning.
    """
    if file is not None and encoding_of(content) == WINDOWS:
        _log.warning("%s: is no UTF-8 text, and is read as Windows-1252", file)
    separator, header, rows = opened(content, dialect)
    columns = find_columns(header, dialect)
    turning = dict(columns.turning) if file is not None else {}
    apart: dict[str, int] = {}
    """Lines at which layouts go on after rows of others, by name."""
    names: set[str] = set()
    name = ""
    for line, row in rows:
        if len(row) == columns.count:
            before, name = name, row[columns.layout]
            if name != before and name in names:
                apart.setdefault(name, line)
            names.add(name)
            for place in [place for place in turning if turns(row[place])]:
                warn_of_turning(str(file), turning.pop(place))
            if len(names) > MAX_LAYOUTS:
                raise FormatError(f"has more than {MAX_LAYOUTS} layouts; allowed: up to so many")
    read = _Rows(columns, dialect, separator)
    record: Record | Refused | None = None
    for line, row in opened(content, dialect)[2]:
        read.check(line, row)
        before, name = name, row[columns.layout]
        if name != before and record is not None:
            yield _numbered(record, dialect)
            record = None
        if name not in apart:
            record = read.added(record, line, row)
        elif name in names:
            names.remove(name)
            yield _apart(unguarded(name), line, apart[name])
    if record is not None:
        yield _numbered(record, dialect)


def _apart(name: str, first: int, line: int) -> Refused:
    """A layout of which some rows stand after rows of others."""
    if not name:
        return _unnamed(first)
    return Refused(
        name,
        FormatError(
            f"line {line} goes on with it after rows of another layout: do two pallets share this "
            "name? allowed: all rows of a layout together, and another name for each pallet"
        ),
    )


def _unnamed(line: int) -> Refused:
    return Refused("", FormatError(f"line {line} names no layout; allowed: its name"))


def _numbered(record: Record | Refused, dialect: Dialect) -> Record | Refused:
    """A complete record; refused where a sequence number stands there twice, or where its sequence
    begins at 1 and 0 was said, or at 0 and 1.
    """
    numbers = [] if isinstance(record, Refused) else [item["sequence"] for item in record.items]
    if dialect.order == "rows" or not all(isinstance(n, int) for n in numbers):
        return record
    if len({*numbers}) < len(numbers):
        [(twice, _)] = Counter(numbers).most_common(1)
        shift = dialect.order == "from-1"
        return Refused(
            record.name,
            LayoutError(
                f"sequence {twice + shift} stands there twice: do two pallets share this name? "
                f"allowed: each of {shift:d} to {len(numbers) - 1 + shift} once, and another name "
                "for each pallet"
            ),
        )
    count, begins = len(numbers), min(numbers, default=0)
    from_one = dialect.order == "from-1"
    if begins != (-1 if from_one else 1):
        return record
    zero, one = f"each of 0 to {count - 1} once", f"each of 1 to {count} once"
    allowed = f"{one} as --order from-1 says, {zero}" if from_one else f"{zero}, {one}"
    said = "without it" if from_one else "where --order from-1 says so"
    text = f"its sequence numbers begin at {begins + from_one}; allowed: {allowed} {said}"
    return Refused(record.name, LayoutError(text))


def opened(
    content: bytes | bytearray, dialect: Dialect
) -> tuple[str, list[str], Iterator[tuple[int, list[str]]]]:
    """Separator, header, and the rows that are not empty, with the numbers of their lines."""
    lines = _lines(content)
    before, line = next(((k, line) for k, line in enumerate(lines) if line.strip()), (0, ""))
    stated = _SEPARATOR_LINE.fullmatch(line.rstrip("\n"))
    if stated:
        before, line = before + 1, next(lines, "")
    separator = (stated[1] if stated else "") or separator_of(line, dialect) or ","
    reader = csv.reader(chain([line], lines), strict=True, delimiter=separator)
    header = next(_checked(reader, before), (0, []))[1]
    return separator, header, _checked(reader, before)


def _checked(reader: Any, before: int) -> Iterator[tuple[int, list[str]]]:
    try:
        for row in reader:
            if any(row):
                yield before + reader.line_num, row
    except csv.Error as error:
        said = printable(str(error))
        raise FormatError(f"line {before + reader.line_num} is not CSV ({said})") from None


def encoding_of(content: bytes | bytearray) -> str:
    """UTF-8, or Windows-1252 for what is none and decodes cleanly so, as Excel's plain CSV does.

    Raises:
        FormatError: it is neither; the message says at which byte it is no UTF-8.
    """
    try:
        for start, part in _parts(content):
            decoded(part, start)
    except FormatError:
        try:
            for _, part in _parts(content):
                part.decode(WINDOWS)
        except UnicodeDecodeError:
            pass
        else:
            return WINDOWS
        raise
    return "utf-8"


def _parts(content: bytes | bytearray) -> Iterator[tuple[int, bytes | bytearray]]:
    """Whole lines of a text, where each part begins: no copy of the whole is made."""
    start = len(BOM_UTF8) if content.startswith(BOM_UTF8) else 0
    while start < len(content):
        end = content.find(b"\n", start + _CHUNK) + 1 or len(content)
        yield start, content[start:end]
        start = end


def _lines(content: bytes | bytearray) -> Iterator[str]:
    """The lines of a text that ends them by either character."""
    encoding = encoding_of(content)
    for _, part in _parts(content):
        text = part.decode(encoding).replace("\r\n", "\n").replace("\r", "\n")
        for line in text.removesuffix("\n").split("\n"):
            yield line + "\n"


@dataclass
class _Rows:
    """Rows of a file as items of records."""

    columns: Columns
    dialect: Dialect
    separator: str
    marks: dict[str, int] = field(default_factory=dict)
    """Decimal marks that the file has, with the first line of each."""
    last: tuple[list[str], dict[str, Any]] = ([], {})
    """Cells of the pallet in the row before, and what they state."""

    def check(self, line: int, row: Sequence[str]) -> None:
        """Refuse a row with too few or many cells, or with a cell that is too long."""
        if len(row) != self.columns.count:
            others = [mark for mark in SEPARATORS if mark != self.separator]
            mixed = next((m for m in others if any(m in cell for cell in row)), None)
            hint = "" if mixed is None else f", parted by {self.separator!r} and not by {mixed!r}"
            raise FormatError(
                f"line {line} has {len(row)} values; allowed: {self.columns.count}, as the header "
                f"says{hint}"
            )
        trailing = self.columns.trailing
        if trailing is not None and row[trailing].strip():
            raise FormatError(
                f"line {line} has the value {shown(row[trailing])} in a column without a header; "
                "allowed: a header for each column with values"
            )
        longest = max(map(len, row))
        if longest > MAX_TEXT_LENGTH:
            raise FormatError(
                f"line {line} has a cell of {longest} characters; allowed: {MAX_TEXT_LENGTH}"
            )

    def added(
        self, record: Record | Refused | None, line: int, row: Sequence[str]
    ) -> Record | Refused:
        """A layout's record with one row more."""
        if isinstance(record, Refused):
            return record
        pallet = self._pallet(line, row)
        if record is None:
            record = Record(unguarded(row[self.columns.layout]), pallet, [])
            if not record.name:
                return _unnamed(line)
        if record.pallet != pallet:
            error: LayoutError = FormatError(
                f"line {line} states another pallet size than the lines before; allowed: one "
                "pallet a layout"
            )
            return Refused(record.name, error)
        if len(record.items) == MAX_ITEMS:
            return Refused(
                record.name, LayoutError(f"has more than {MAX_ITEMS} items; allowed: {MAX_ITEMS}")
            )
        record.items.append(self._item(line, row, len(record.items)))
        return record

    def _pallet(self, line: int, row: Sequence[str]) -> dict[str, Any]:
        cells = [row[place] for place in self.columns.pallet]
        if cells != self.last[0] or not self.last[1]:
            sides = self._turned(self._lengths(line, row, self.columns.pallet) or self._stated())
            self.last = cells, dict(zip(_SIZES, map(_plain, sides), strict=True))
        return self.last[1]

    def _stated(self) -> list[Any]:
        """The sides of all pallets that the dialect states."""
        return [times(side, UNITS[self.dialect.units]) for side in sides_of(self.dialect.pallet)]

    def _item(self, line: int, row: Sequence[str], place: int) -> dict[str, Any]:
        columns = self.columns
        sizes = self._lengths(line, row, columns.size)
        position = self._lengths(line, row, columns.position)
        if self.dialect.positions == "centre":
            position = [
                minus_half(p, s) if isinstance(p, Decimal) and isinstance(s, Decimal) else p
                for p, s in zip(position, sizes, strict=True)
            ]
        offsets = self._lengths(line, row, columns.offset)
        weight = self._scaled(line, row[columns.weight], WEIGHT_UNITS[self.dialect.weight])
        if columns.sequence is None:
            sequence = place
        else:
            sequence = _whole(self._scaled(line, row[columns.sequence], _ONE))
            if self.dialect.order == "from-1" and isinstance(sequence, int):
                sequence -= 1
        item = {
            "sequence": sequence,
            "name": "" if columns.identity is None else unguarded(row[columns.identity]),
            "weight": _plain(weight),
        }
        item |= zip("xyz", map(_plain, self._turned(position)), strict=True)
        item |= zip(_SIZES, map(_plain, self._turned(sizes)), strict=True)
        for word, at in zip(LOADS, columns.load, strict=True):
            if at is not None and row[at].strip():
                item[word] = _plain(self._scaled(line, row[at], WEIGHT_UNITS[self.dialect.weight]))
        named = zip("xyz", self._turned(offsets), strict=True)
        return item | {f"offset_{axis}": _plain(v) for axis, v in named if v is not None}

    def _turned(self, values: Sequence[Any]) -> list[Any]:
        return [values[axis] for axis in TURNED[self.dialect.up]]

    def _lengths(self, line: int, row: Sequence[str], places: Iterable[int | None]) -> list[Any]:
        factor = UNITS[self.dialect.units]
        return [None if p is None else self._scaled(line, row[p], factor) for p in places]

    def _scaled(self, line: int, cell: str, factor: Decimal) -> Decimal | str:
        """A cell's number in our unit, else the cell as it is."""
        value = number(cell)
        if value is None or ("," in cell and self.separator == ","):
            return cell.strip()
        for mark in ".,":
            if mark in cell and mark not in self.marks:
                self._note(mark, line)
        return value if factor == _ONE else times(value, factor)

    def _note(self, mark: str, line: int) -> None:
        self.marks[mark] = line
        if len(self.marks) > 1:
            raise FormatError(
                f"has numbers with a decimal point (line {self.marks['.']}) and with a decimal "
                f"comma (line {self.marks[',']}); allowed: one of them, and no other mark in a "
                "number"
            )


def _plain(value: Any) -> Any:
    return float(value) if isinstance(value, Decimal) else value


def _whole(value: Decimal | str) -> Any:
    """A sequence number; beyond 15 digits a float is no longer exact."""
    number = _plain(value)
    exact = isinstance(number, float) and number.is_integer() and abs(number) < 1e15
    return int(number) if exact else number

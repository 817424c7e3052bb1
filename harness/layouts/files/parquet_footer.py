"""The footer of a Parquet file, as far as it says how large each row group is.

pyarrow aborts when it reads the sizes of a column whose entry is damaged, so they are read here.
The footer is a structure in Thrift's compact protocol.
"""

from __future__ import annotations

import io
from dataclasses import dataclass
from typing import Any, BinaryIO

from steadyload.layouts.files.limits import MAX_FOOTER_BYTES
from steadyload.layouts.files.record import FormatError
from steadyload.reading import in_words

_MAGIC = b"PAR1"
"""The first and the last bytes of a Parquet file."""

_ROW_GROUPS, _COLUMNS, _ROWS, _ABOUT, _VALUES, _SIZE = 4, 1, 3, 3, 5, 6
"""Fields of the structures of a footer: of the file, of a group, of a column, and of its data."""

_DAMAGED = "cannot be read as Parquet (its footer is damaged)"


def is_parquet(head: bytes) -> bool:
    """True for the first bytes of a Parquet file."""
    return head.startswith(_MAGIC)


@dataclass(frozen=True, slots=True)
class Group:
    """The size of a row group, as a footer states it.

    Attributes:
        rows: number of rows.
        values: of all columns, those in lists among them; at least the rows.
        longest: those of the column that has the most.
        size: bytes of all columns, unpacked.
    """

    rows: int
    values: int
    longest: int
    size: int


def footer_of(file: BinaryIO) -> bytes:
    """The footer of a file that can be read at any place; it is then at its start again.

    Raises:
        FormatError: it has none, or one that is too large.
    """
    end = file.seek(0, io.SEEK_END)
    file.seek(max(0, end - 8))
    last = file.read(8)
    length = int.from_bytes(last[:4], "little")
    if last[4:] != _MAGIC:
        raise FormatError("is a Parquet file that is cut off")
    if length > MAX_FOOTER_BYTES:
        raise FormatError(
            f"has a footer of {in_words(length)}; allowed: {in_words(MAX_FOOTER_BYTES)}"
        )
    file.seek(max(0, end - 8 - length))
    footer = file.read(length)
    file.seek(0)
    return footer


def groups_of(footer: bytes) -> list[Group]:
    """The row groups of a file, in its order.

    Raises:
        FormatError: the footer is damaged.
    """
    try:
        return [_group(each) for each in _Compact(footer).structure().get(_ROW_GROUPS, [])]
    except (AttributeError, LookupError, RecursionError, TypeError):
        raise FormatError(_DAMAGED) from None


def _group(stated: dict[int, Any]) -> Group:
    about = [column[_ABOUT] for column in stated[_COLUMNS]]
    values = [column[_VALUES] for column in about]
    sizes = [column[_SIZE] for column in about]
    rows = stated[_ROWS]
    if min(rows, *values, *sizes, 0) < 0:
        raise LookupError("a number below 0")
    return Group(rows, max(rows, sum(values)), max(values, default=0), sum(sizes))


class _Compact:
    """Values in Thrift's compact protocol, one after the other; structures by numbers of fields."""

    def __init__(self, content: bytes) -> None:
        self._content, self._at = content, 0

    def structure(self) -> dict[int, Any]:
        found: dict[int, Any] = {}
        field = 0
        while head := self._byte():
            field = field + (head >> 4) if head >> 4 else self._whole()
            found[field] = self._value(head & 15)
        return found

    def _value(self, kind: int) -> Any:
        if kind in (1, 2):
            return kind == 1
        if kind == 3:
            return self._byte()
        if kind in (4, 5, 6):
            return self._whole()
        if kind == 7:
            return self._skipped(8)
        if kind == 8:
            return self._skipped(self._number())
        if kind in (9, 10):
            return self._list()
        if kind == 11:
            return self._map()
        if kind == 12:
            return self.structure()
        raise LookupError("no such type")

    def _list(self) -> list[Any]:
        head = self._byte()
        count = head >> 4 if head >> 4 < 15 else self._number()
        return [self._element(head & 15) for _ in range(count)]

    def _map(self) -> None:
        count = self._number()
        kinds = self._byte() if count else 0
        for _ in range(count):
            self._element(kinds >> 4)
            self._element(kinds & 15)

    def _element(self, kind: int) -> Any:
        return self._byte() if kind in (1, 2) else self._value(kind)

    def _whole(self) -> int:
        number = self._number()
        return (number >> 1) ^ -(number & 1)

    def _number(self) -> int:
        found = 0
        for shift in range(0, 70, 7):
            byte = self._byte()
            found |= (byte & 127) << shift
            if byte < 128:
                return found
        raise LookupError("a number without end")

    def _byte(self) -> int:
        self._at += 1
        return self._content[self._at - 1]

    def _skipped(self, count: int) -> None:
        self._at += count

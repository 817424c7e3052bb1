"""Plain CSV files as a batch: columns become arrays, and no item an object.

Only what is read here exactly as :mod:`steadyload.layouts.files.csv_reader` reads it is read here.
Where a file may be wrong, or has what is rare, there is no batch: that reader then says what is
wrong.
"""

from __future__ import annotations

from codecs import BOM_UTF8
from collections.abc import Iterable
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.csv
from numpy.typing import NDArray

from steadyload.layouts.files.csv_cells import unguarded
from steadyload.layouts.files.csv_columns import (
    Columns,
    find_columns,
    separator_of,
    turns,
    warn_of_turning,
)
from steadyload.layouts.files.dialect import Dialect
from steadyload.layouts.files.limits import (
    MAX_ITEMS,
    MAX_LAYOUTS,
    MAX_NUMBER_LENGTH,
    MAX_TEXT_LENGTH,
)
from steadyload.layouts.model.batch import LayoutBatch, checked_batch
from steadyload.layouts.model.batch_checks import Pallets
from steadyload.layouts.model.layout import FloatArray, LayoutError

_PLAIN_KEYS = {"columns", "other_columns"}
"""Keys of a dialect that change no number."""

_NUMBER = r"^[+-]?(?:[0-9]+(?:[.][0-9]*)?|[.][0-9]+)(?:[eE][+-]?[0-9]{1,6})?$"
"""Finite numbers with a decimal point: a part of those of
:mod:`steadyload.layouts.files.csv_cells`."""

_PLAIN_DIGITS = b"0123456789.+-"
"""Characters of numbers without an exponent. Of texts of them Arrow converts those that
:data:`_NUMBER` matches, and no other."""


def batch_of_csv(
    content: bytes | bytearray, dialect: Dialect, deck: dict[str, Any], file: str = "CSV"
) -> LayoutBatch | None:
    """The batch of a CSV file; None where the other reader has to look at it.

    Args:
        content: all of the file.
        dialect: of the file.
        deck: what is stated of all pallets beside their sizes, as fields of a pallet.
        file: its name, for a warning of a column left out that states how boxes are turned.
    """
    if dialect.stated().keys() - _PLAIN_KEYS or _parts_otherwise(content):
        return None
    start = len(BOM_UTF8) if content.startswith(BOM_UTF8) else 0
    end = content.find(b"\n", start) + 1 or len(content)
    try:
        header = content[start:end].decode().removesuffix("\n").removesuffix("\r")
        separator = separator_of(header, dialect)
        if separator is None:
            return None
        columns = find_columns(header.split(separator), dialect)
        if columns.load != (None, None):
            return None
        cells = _cells(memoryview(content)[end:], separator, columns.count)
        if columns.trailing is not None and any(cells[columns.trailing].unique().to_pylist()):
            return None
        batch = _batch(cells, columns, deck)
    except (pa.ArrowException, LayoutError, ValueError):
        return None
    for place, name in columns.turning.items():
        if any(map(turns, cells[place].unique().to_pylist())):
            warn_of_turning(file, name)
    return batch


def _parts_otherwise(content: bytes | bytearray) -> bool:
    """True for a text that parts lines and cells not only by line ends and separators."""
    if b'"' in content or b"\0" in content:
        return True
    return b"\r" in content and content.count(b"\r") > content.count(b"\r\n")


def _cells(content: memoryview, separator: str, count: int) -> list[pa.Array]:
    """The columns of the rows as texts.

    Raises:
        pa.ArrowException: the rows are no such table.
        ValueError: a cell is too long.
    """
    names = [str(k) for k in range(count)]
    table = pyarrow.csv.read_csv(
        pa.BufferReader(pa.py_buffer(content)),
        read_options=pyarrow.csv.ReadOptions(column_names=names),
        parse_options=pyarrow.csv.ParseOptions(delimiter=separator, quote_char=False),
        convert_options=pyarrow.csv.ConvertOptions(
            column_types=dict.fromkeys(names, pa.string()), strings_can_be_null=False
        ),
    )
    cells = [column.combine_chunks() for column in table.columns]
    for column in cells:
        _bytes_of(column, MAX_TEXT_LENGTH)
    return cells


def _bytes_of(column: pa.Array, most: int) -> memoryview:
    """The texts of a column one after the other.

    Raises:
        ValueError: one has more bytes than allowed.
    """
    _, bounds, content = column.buffers()
    ends = np.frombuffer(bounds, np.int32, len(column) + 1, offset=4 * column.offset)
    if np.diff(ends).max(initial=0) > most:
        raise ValueError(f"a cell of more than {most} bytes")
    return memoryview(content or b"")[ends[0] : ends[-1]]


def _batch(cells: list[pa.Array], columns: Columns, deck: dict[str, Any]) -> LayoutBatch:
    """The batch of the columns of a file.

    Raises:
        ValueError: it may have none; likewise LayoutError and pa.ArrowException.
    """
    coded = cells[columns.layout].dictionary_encode()
    names = tuple(_texts(coded.dictionary))
    layouts = coded.indices.to_numpy()
    if (np.diff(layouts) < 0).any():
        raise ValueError("rows of a layout after those of another")
    assert columns.sequence is not None, "the other reader takes the order of rows"
    sequence = _numbers(cells[columns.sequence])
    order = _order(sequence, layouts)
    counts = np.bincount(layouts, minlength=len(names))
    starts = np.concatenate(([0], np.cumsum(counts)))
    if not names or len({*names}) < len(names):
        raise ValueError("no layouts, or one that stands there twice")
    if len(names) > MAX_LAYOUTS or counts.max() > MAX_ITEMS:
        raise ValueError("too many layouts or items")
    if (sequence[order] != np.arange(len(sequence)) - np.repeat(starts[:-1], counts)).any():
        raise ValueError("sequence numbers with gaps")
    sizes = _vectors(cells, columns.pallet)[order]
    other = sizes[1:] != sizes[:-1]
    other[starts[1:-1] - 1] = False
    if other.any():
        raise ValueError("two pallets of one layout")
    return checked_batch(
        starts,
        _vectors(cells, columns.position)[order],
        _vectors(cells, columns.size)[order],
        _numbers(cells[columns.weight])[order],
        _vectors(cells, columns.offset)[order],
        pallets=Pallets.sized(sizes[starts[:-1]], **deck),
        names=names,
        ids=() if columns.identity is None else _ids(cells[columns.identity], order),
    )


def _order(sequence: FloatArray, layouts: NDArray[np.int32]) -> NDArray[np.int64] | slice:
    """The order in which rows stand by layout and sequence; all of them where they do so already.

    Args:
        sequence: numbers of all rows.
        layouts: numbers of their layouts.
    """
    steps = np.diff(layouts)
    if ((steps == 0) & (np.diff(sequence) > 0.0) | (steps > 0)).all():
        return slice(None)
    return np.lexsort((sequence, layouts))


def _texts(column: pa.Array) -> list[str]:
    """The texts of cells, without the apostrophes that guard them."""
    texts: list[str] = column.to_pylist()
    guarded = b"'" in bytes(_bytes_of(column, MAX_TEXT_LENGTH))
    return [unguarded(text) for text in texts] if guarded else texts


def _vectors(cells: list[pa.Array], places: Iterable[int | None]) -> FloatArray:
    """Three columns as vectors; zero along an axis that has no column."""
    rows = len(cells[0])
    return np.stack([np.zeros(rows) if k is None else _numbers(cells[k]) for k in places], axis=1)


def _numbers(column: pa.Array) -> FloatArray:
    """The numbers that cells state.

    Raises:
        ValueError: a cell states none, or in another way.
    """
    others = bytes(_bytes_of(column, MAX_NUMBER_LENGTH)).translate(None, _PLAIN_DIGITS)
    if others and not pc.all(pc.match_substring_regex(column, _NUMBER)).as_py():
        raise ValueError("a cell that is no plain number")
    found: FloatArray = pc.cast(column, pa.float64()).to_numpy()
    return found


def _ids(column: pa.Array, order: NDArray[np.int64] | slice) -> tuple[str, ...]:
    """Ids of boxes in another order; none where all are empty."""
    coded = column.dictionary_encode()
    ids = _texts(coded.dictionary)
    places = coded.indices.to_numpy()[order]
    return tuple(map(ids.__getitem__, places.tolist())) if any(ids) else ()

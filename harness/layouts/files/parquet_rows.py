"""Rows of a Parquet file of layouts, which may come from anybody: checked, so many at a time."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import BinaryIO

import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq

from steadyload.errors import nearest
from steadyload.escaping import printable, shown
from steadyload.layouts.files.limits import MAX_GROUP_VALUES, MAX_LAYOUTS, MAX_TEXT_LENGTH
from steadyload.layouts.files.parquet_footer import Group, footer_of, groups_of
from steadyload.layouts.files.parquet_layouts import (
    GROUP_ITEMS,
    GROUP_LAYOUTS,
    REQUIRED,
    SCHEMA,
    TEXT,
)
from steadyload.layouts.files.parquet_table import is_text
from steadyload.layouts.files.record import FormatError
from steadyload.layouts.model.layout import LayoutError
from steadyload.reading import MAX_TABLE_BYTES, in_words

_LONGEST = 200
"""Characters of a library's message that are passed on."""


def row_batches(file: BinaryIO) -> Iterator[pa.RecordBatch]:
    """The rows of a file, so many at a time as fit into memory; texts are dictionaries.

    Args:
        file: it, open, of a size that is allowed; one that can be read at any place.

    Raises:
        FormatError: it is damaged, larger than a limit, or has other columns than layouts.
        OSError: it cannot be read.
    """
    with named_errors():
        groups = groups_of(footer_of(file))
        if (count := sum(group.rows for group in groups)) > MAX_LAYOUTS:
            raise FormatError(f"holds {count:,} layouts; allowed: at most {MAX_LAYOUTS:,}")
        about = pq.read_metadata(file)
        _check_columns(about.schema.to_arrow_schema())
        columns = map(about.schema.column, range(about.num_columns))
        texts = [each.path for each in columns if each.physical_type == "BYTE_ARRAY"]
        opened = pq.ParquetFile(file, metadata=about, read_dictionary=texts)
        for place, group in enumerate(groups):
            most = _rows_at_a_time(group)
            for rows in opened.iter_batches(most, row_groups=[place], use_threads=False):
                rows.validate(full=True)  # a changed bit may lead beyond the texts that there are
                if len(rows):
                    yield _plain(rows)


def _check_columns(schema: pa.Schema) -> None:
    """Refuse a file of other columns.

    Raises:
        FormatError: a column is missing, unknown, there twice, or of another type.
    """
    for name in REQUIRED:
        if name not in schema.names:
            raise FormatError(
                f"lacks the column {name!r}; allowed: a row a layout, with the columns "
                f"{', '.join(SCHEMA.names)}"
            )
    for name in schema.names:
        if name not in SCHEMA.names:
            told = nearest(name[:MAX_TEXT_LENGTH], SCHEMA.names)
            raise FormatError(f"has the unknown column {shown(name)}; {told}")
        if schema.names.count(name) > 1:
            raise FormatError(f"has the column {name!r} twice; allowed: each once")
        expected, found = SCHEMA.field(name).type, schema.field(name).type
        if not _is_kind(found, expected):
            raise FormatError(
                f"has the column {name!r} of type {printable(str(found), _LONGEST)}; "
                f"allowed: {_kind_in_words(expected)}"
            )


def _is_kind(found: pa.DataType, expected: pa.DataType) -> bool:
    """True for a type whose values are those of the expected one."""
    if pa.types.is_list(expected):
        whole = pa.types.is_list(found) or pa.types.is_large_list(found)
        return whole and _is_kind(found.value_type, expected.value_type)
    if pa.types.is_dictionary(found):
        found = found.value_type
    if expected == TEXT:
        return is_text(found)
    is_float = pa.types.is_float32(found) or pa.types.is_float64(found)
    return bool(is_float or pa.types.is_integer(found))


def _kind_in_words(expected: pa.DataType) -> str:
    listed = pa.types.is_list(expected)
    word = "texts" if (expected.value_type if listed else expected) == TEXT else "numbers"
    return f"lists of {word}" if listed else word


def _rows_at_a_time(group: Group) -> int:
    """Rows of a group that are read at a time.

    Raises:
        FormatError: the group is too large.
    """
    if group.values > MAX_GROUP_VALUES or group.size > MAX_TABLE_BYTES:
        raise FormatError(
            f"has a row group of {group.values:,} values and {in_words(group.size)} unpacked; "
            f"allowed: {MAX_GROUP_VALUES:,} and {in_words(MAX_TABLE_BYTES)}, write fewer rows a "
            "group"
        )
    return max(1, min(GROUP_LAYOUTS, GROUP_ITEMS * group.rows // max(group.longest, 1)))


def _plain(rows: pa.RecordBatch) -> pa.RecordBatch:
    """The same rows with numbers as floats, whatever they were.

    Raises:
        FormatError: a text is too long.
    """
    columns = []
    for name, column in zip(rows.schema.names, rows.columns, strict=True):
        expected = SCHEMA.field(name).type
        listed = pa.types.is_list(expected)
        if (expected.value_type if listed else expected) == TEXT:
            _check_length(name, column)
        elif column.type != expected:
            column = column.cast(expected)
        columns.append(column)
    return pa.RecordBatch.from_arrays(columns, names=rows.schema.names)


def _check_length(name: str, column: pa.Array) -> None:
    """Refuse texts that are too long; each is held once here, however often it stands there."""
    texts = column.values if hasattr(column, "values") else column
    texts = texts.dictionary if pa.types.is_dictionary(texts.type) else texts
    if (longest := pc.max(pc.utf8_length(texts)).as_py() or 0) > MAX_TEXT_LENGTH:
        raise FormatError(
            f"has a text of {longest:,} characters in the column {name!r}; allowed: at most "
            f"{MAX_TEXT_LENGTH:,}"
        )


@contextmanager
def named_errors() -> Iterator[None]:
    """Named errors in the place of those of the library, of a file that is none."""
    try:
        yield
    except LayoutError:
        raise
    except (OSError, KeyError, ValueError, pa.ArrowException) as error:
        if isinstance(error, OSError) and error.errno is not None:
            raise
        why = printable(" ".join(str(error).split()), _LONGEST)
        raise FormatError(f"cannot be read as Parquet ({why})") from None

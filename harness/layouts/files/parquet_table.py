"""Tables of Parquet files, up to a size: a small file can hold a value very many times."""

from __future__ import annotations

import io
from collections.abc import Sequence

import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq

from steadyload.layouts.files.parquet_footer import footer_of, groups_of
from steadyload.reading import MAX_TABLE_BYTES, in_words

MAX_TABLE_VALUES = 32 * 1024**2
"""Values of a table, those in lists among them; the largest of the package has two million."""


def is_text(kind: pa.DataType) -> bool:
    """Whether values of a type are texts: libraries write different ones."""
    kinds = (pa.types.is_string, pa.types.is_large_string, pa.types.is_string_view)
    return any(one(kind) for one in kinds)


class TableTooLargeError(ValueError):
    """A table of more values, or of more text, than is read."""


def table_of(
    content: bytes, *, schema: pa.Schema | None = None, columns: Sequence[str] | None = None
) -> pa.Table:
    """The table of a Parquet file.

    Args:
        content: of the file.
        schema: of the table; None for that of the file.
        columns: those to read; None for all.

    Raises:
        TableTooLargeError: it has more than :data:`MAX_TABLE_VALUES`, or takes more than
            :data:`.MAX_TABLE_BYTES` unpacked, or its texts do.
        OSError, ValueError, pyarrow.ArrowException: it is no such table.
    """
    groups = groups_of(footer_of(io.BytesIO(content)))
    values = sum(group.values for group in groups)
    if values > MAX_TABLE_VALUES:
        raise TableTooLargeError(f"it has {values:,} values; allowed: {MAX_TABLE_VALUES:,}")
    _hold(sum(group.size for group in groups))
    stated = pq.read_metadata(pa.BufferReader(content)).schema
    columns_of_file = map(stated.column, range(len(stated)))
    texts = sorted({c.path for c in columns_of_file if c.physical_type == "BYTE_ARRAY"})
    if texts and values:
        # Every text is held once here, however often it stands in a column.
        file = pq.ParquetFile(pa.BufferReader(content), read_dictionary=texts)
        kept = file.read(columns=texts, use_threads=False)
        _hold(sum(_length(chunk) for column in kept.columns for chunk in column.chunks))
    return pq.read_table(
        pa.BufferReader(content), schema=schema, columns=columns, page_checksum_verification=True
    )


def _hold(size: int) -> None:
    if size > MAX_TABLE_BYTES:
        raise TableTooLargeError(
            f"it takes {in_words(size)} unpacked; allowed: {in_words(MAX_TABLE_BYTES)}"
        )


def _length(chunk: pa.Array) -> int:
    """Bytes of all texts of a column, of lists, or of structures."""
    if isinstance(chunk, pa.StructArray):
        return sum(map(_length, chunk.flatten()))
    if isinstance(chunk, pa.ListArray | pa.LargeListArray):
        return _length(chunk.flatten())
    if not pa.types.is_dictionary(chunk.type):
        return int(chunk.nbytes)
    return pc.sum(pc.binary_length(chunk.dictionary).take(chunk.indices)).as_py() or 0

"""The reader of Parquet files: bytes in, layouts out, and records of what is not valid."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, BinaryIO

import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq

from steadyload.layouts.files.limits import MAX_ITEMS
from steadyload.layouts.files.parquet_layouts import (
    IDS,
    LOADS,
    OF_ITEMS,
    OFFSETS,
    PALLET_SIDES,
    batch_of,
    loads_of,
    written_batch,
)
from steadyload.layouts.files.parquet_rows import named_errors, row_batches
from steadyload.layouts.files.record import DECK_KEYS, FormatError, Record, Refused
from steadyload.layouts.model.batch import LayoutBatch
from steadyload.layouts.model.layout import Layout, LayoutError

_LISTS = (*OF_ITEMS, *OFFSETS, IDS, LOADS)


def read_parquet(
    file: BinaryIO, deck: Mapping[str, Any] | None = None
) -> Iterator[LayoutBatch | Record | Refused]:
    """Layouts of a file, in its order, in batches; where rows are not all valid, or state loads,
    records.

    Args:
        file: see :func:`row_batches`.
        deck: what is stated of all pallets, as fields of a pallet.

    Raises:
        FormatError: as :func:`row_batches`, or a layout has no name.
    """
    first = 0
    for rows in row_batches(file):
        batch = batch_of(rows, deck)
        yield from _records(rows, first) if batch is None else (batch,)
        first += len(rows)


def written_groups(file: BinaryIO) -> Iterator[pa.RecordBatch]:
    """The row groups of a file that was written here, of which nothing is checked again.

    Raises:
        FormatError: it is damaged.
    """
    with named_errors():
        opened = pq.ParquetFile(file)
        for group in range(opened.num_row_groups):
            yield written_group(opened, group)


def written_group(file: pq.ParquetFile, group: int) -> pa.RecordBatch:
    """A row group of such a file."""
    [rows] = file.read_row_group(group, use_threads=False).combine_chunks().to_batches()
    return rows


def layouts_of(rows: pa.RecordBatch) -> Iterator[Layout]:
    """The layouts of written rows, with the loads that their items may bear."""
    batch, loads = written_batch(rows), loads_of(rows)
    for place, layout in enumerate(batch):
        yield layout.bearing(loads[place]) if loads and loads[place] else layout


def _records(rows: pa.RecordBatch, first: int) -> Iterator[Record | Refused]:
    for place, name in enumerate(rows.column("layout").to_pylist()):
        if name is None:
            row = first + place
            raise FormatError(f"row {row} (counted from 0) has layout missing; allowed: a text")
        try:
            yield _record(name, rows.slice(place, 1))
        except LayoutError as error:
            # The error as it was raised would hold the rows, by the frames of its traceback.
            yield Refused(name, error.located())


def _record(name: str, row: pa.RecordBatch) -> Record:
    lists = {key: row.column(key) for key in row.schema.names if key in _LISTS}
    counts = {key: _length(column) for key, column in lists.items() if not column.null_count}
    for key in OF_ITEMS:
        if key not in counts:
            raise LayoutError(f"{key} is missing; allowed: a list of numbers, one an item")
    for key, count in counts.items():
        if count > MAX_ITEMS:
            raise FormatError(f"has {count:,} items; allowed: at most {MAX_ITEMS:,}")
        if count != counts["x"]:
            raise LayoutError(
                f"{key} has {count:,} entries, and x has {counts['x']:,}; allowed: one an item"
            )
    values = {key: lists[key].to_pylist()[0] for key in counts}
    ids = values.pop(IDS, [None] * counts["x"])
    loads = values.pop(LOADS, [None] * counts["x"])
    items = [
        {"sequence": k, "name": identity or ""}
        | {key: column[k] for key, column in values.items()}
        | ({} if load is None else {LOADS: load})
        for k, (identity, load) in enumerate(zip(ids, loads, strict=True))
    ]
    [pallet] = row.select([key for key in row.schema.names if key not in lists]).to_pylist()
    size = {side.removeprefix("pallet_"): pallet[side] for side in PALLET_SIDES}
    stated = {key: pallet[key] for key in DECK_KEYS if pallet.get(key) is not None}
    return Record(name, size | stated, items)


def _length(column: pa.Array) -> int:
    return int(pc.list_value_length(column)[0].as_py())

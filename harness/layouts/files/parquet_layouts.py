"""Parquet files of layouts: one row for each, with lists of its items in loading order.

With a list a column, a layout is named once and lies in one row, so that a range of rows is a range
of layouts, and the numbers of a column are one array. Rows are read and written a group at a time:
a file of any length takes as much memory as its largest group.
"""

from __future__ import annotations

import io
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from steadyload.layouts.files.limits import MAX_ITEMS
from steadyload.layouts.files.record import DECK_KEYS
from steadyload.layouts.model.batch import LayoutBatch, checked_batch
from steadyload.layouts.model.batch_checks import Pallets
from steadyload.layouts.model.layout import FloatArray, Layout, LayoutError, Pallet

PALLET_SIDES = ("pallet_width", "pallet_height", "pallet_depth")
OF_ITEMS = ("x", "y", "z", "width", "height", "depth", "weight")
OFFSETS = ("offset_x", "offset_y", "offset_z")
IDS, LOADS = "id", "max_load"

TEXT, _NUMBER = pa.string(), pa.float64()

SCHEMA = pa.schema(
    [
        pa.field("layout", TEXT, nullable=False),
        *(pa.field(side, _NUMBER, nullable=False) for side in PALLET_SIDES),
        pa.field("overhang", _NUMBER),
        pa.field("deck_height", _NUMBER),
        pa.field("floor", TEXT),
        *(pa.field(key, pa.list_(_NUMBER), nullable=False) for key in (*OF_ITEMS, *OFFSETS)),
        pa.field(IDS, pa.list_(TEXT)),
        pa.field(LOADS, pa.list_(_NUMBER)),
    ]
)
"""Columns of a file as it is written: ``layout`` names it; lengths [cm], weights and loads [kg].

``x``, ``y``, ``z``: left-bottom-back corners; ``width``, ``height``, ``depth``: sizes as placed;
``offset_*``: centre of mass minus geometric centre. Null: ``id`` where no box of the layout has
one, ``max_load`` where no item states one, and in a list of these that of an item without."""

REQUIRED = tuple(field.name for field in SCHEMA if not field.nullable and field.name not in OFFSETS)
"""Columns that every file has. Without offsets centres of mass lie in the middle."""

GROUP_LAYOUTS, GROUP_ITEMS = 10_000, 250_000
"""Layouts and items of a row group that is written, and of what is read at a time, at most; a
layout with more items is one by itself."""

_COMPRESSION = {"compression": "zstd", "compression_level": 1}


def rows_of(batch: LayoutBatch, max_loads: Sequence[Sequence[float | None]] = ()) -> pa.RecordBatch:
    """The rows of some layouts, as :data:`SCHEMA` has them.

    Args:
        batch: the layouts.
        max_loads: of each layout the loads that its items may bear [kg], None for an item that
            states none, and none where no item does; none where no layout has some.
    """
    pallets, starts = batch.kinds, pa.array(batch.starts.astype(np.int32))
    which = pa.array(pallets.which)

    def of_pallets(values: Iterable[Any], kind: pa.DataType) -> pa.Array:
        return pa.array(list(values), kind).take(which)

    def lists(values: FloatArray | Sequence[str], kind: pa.DataType) -> pa.Array:
        flat = np.ascontiguousarray(values) if isinstance(values, np.ndarray) else values
        return pa.ListArray.from_arrays(starts, pa.array(flat, kind))

    vectors = (*batch.lower.T, *batch.sizes.T, batch.weights, *batch.mass_offsets.T)
    columns = [
        pa.array(batch.names, TEXT),
        *(of_pallets((kind.size[axis] for kind in pallets.kinds), _NUMBER) for axis in range(3)),
        *(
            of_pallets((getattr(kind, key) for kind in pallets.kinds), SCHEMA.field(key).type)
            for key in DECK_KEYS
        ),
        *(lists(values, _NUMBER) for values in vectors),
        lists(batch.ids, TEXT) if batch.ids else pa.nulls(len(batch), pa.list_(TEXT)),
        pa.array([list(own) or None for own in max_loads], pa.list_(_NUMBER))
        if any(max_loads)
        else pa.nulls(len(batch), pa.list_(_NUMBER)),
    ]
    return pa.RecordBatch.from_arrays(columns, schema=SCHEMA)


def as_parquet(layouts: Iterable[Layout]) -> Iterator[bytes]:
    """The bytes of a file, a row group at a time; its layouts are asked for in turn."""
    return parquet_of(
        rows_of(LayoutBatch.of(group), [layout.max_loads for layout in group])
        for group in _groups(layouts)
    )


def parquet_of(groups: Iterable[pa.RecordBatch], schema: pa.Schema = SCHEMA) -> Iterator[bytes]:
    """The bytes of a file of some rows, of which each batch is a row group.

    Args:
        groups: the rows, asked for in turn.
        schema: of them.
    """
    sink = _Sink()
    with pq.ParquetWriter(pa.PythonFile(sink, "w"), schema, **_COMPRESSION) as writer:
        for rows in groups:
            writer.write_batch(rows, row_group_size=max(len(rows), 1))
            yield sink.taken()
    yield sink.taken()


def _groups(layouts: Iterable[Layout]) -> Iterator[list[Layout]]:
    """Layouts in groups that are bounded."""
    group: list[Layout] = []
    items = 0
    for layout in layouts:
        if group and (len(group) == GROUP_LAYOUTS or items + len(layout) > GROUP_ITEMS):
            yield group
            group, items = [], 0
        group.append(layout)
        items += len(layout)
    if group:
        yield group


class _Sink(io.RawIOBase):
    """Takes what is written until it is taken from it."""

    def __init__(self) -> None:
        super().__init__()
        self._parts: list[bytes] = []
        self._length = 0

    def writable(self) -> bool:
        return True

    def write(self, content: Any) -> int:
        self._parts.append(bytes(content))
        self._length += len(self._parts[-1])
        return len(self._parts[-1])

    def tell(self) -> int:
        return self._length

    def taken(self) -> bytes:
        """The bytes that were written since the last time."""
        parts, self._parts = self._parts, []
        return b"".join(parts)


def loads_of(rows: pa.RecordBatch) -> Sequence[Sequence[float | None]]:
    """The loads that items of written rows may bear, as :func:`rows_of` takes them."""
    loads = rows.column(LOADS)
    return () if loads.null_count == len(rows) else [own or () for own in loads.to_pylist()]


def batch_of(rows: pa.RecordBatch, deck: Mapping[str, Any] | None = None) -> LayoutBatch | None:
    """The batch of some rows; None where one is not valid, or states loads that items may bear.

    Args:
        rows: of :func:`steadyload.layouts.files.parquet_rows.row_batches`.
        deck: what is stated of all pallets, as fields of a pallet, in the place of what rows state.
    """
    if LOADS in rows.schema.names and rows.column(LOADS).null_count < len(rows):
        return None
    try:
        starts, *arrays, more = _read(rows, deck or {})
        return None if np.diff(starts).max() > MAX_ITEMS else checked_batch(starts, *arrays, **more)
    except (LayoutError, ValueError, pa.ArrowException):
        return None


def written_batch(rows: pa.RecordBatch) -> LayoutBatch:
    """The batch of rows that :func:`rows_of` made, which is not checked again."""
    *arrays, more = _read(rows, {})
    return checked_batch(*arrays, **more, known=True)


def _read(rows: pa.RecordBatch, deck: Mapping[str, Any]) -> list[Any]:
    """Starts and arrays of a batch, and the rest that it is made of, by name.

    Raises:
        ValueError: something is missing, or lists differ in length.
        LayoutError: a pallet is not allowed.
    """
    given = dict(zip(rows.schema.names, rows.columns, strict=True))
    starts = _starts(given["x"])
    values = {key: _flat(given[key], starts) for key in OF_ITEMS}
    values |= {
        key: _flat(given[key], starts) if key in given else np.zeros(starts[-1]) for key in OFFSETS
    }
    return [
        starts,
        np.stack([values[key] for key in OF_ITEMS[:3]], axis=1),
        np.stack([values[key] for key in OF_ITEMS[3:6]], axis=1),
        np.array(values["weight"]),
        np.stack([values[key] for key in OFFSETS], axis=1),
        {
            "pallets": _pallets(given, deck),
            "names": _names(given["layout"]),
            "ids": _ids(given[IDS], starts) if IDS in given else (),
        },
    ]


def _starts(column: pa.Array) -> NDArray[np.int64]:
    """Where the lists of a column begin among all values."""
    if column.null_count:
        raise ValueError("a list is missing")
    found: NDArray[np.int64] = column.offsets.to_numpy().astype(np.int64)
    return found - found[0]


def _flat(column: pa.Array, starts: NDArray[np.int64]) -> FloatArray:
    """The numbers of all lists of a column, if these begin where they do in others."""
    values = column.flatten()
    if values.null_count or not np.array_equal(_starts(column), starts):
        raise ValueError("a number is missing, or lists differ in length")
    found: FloatArray = values.to_numpy()
    return found


def _texts(column: pa.Array) -> list[str | None]:
    """Texts of a column that is a dictionary, or none yet."""
    coded = column if pa.types.is_dictionary(column.type) else column.dictionary_encode()
    texts = [*coded.dictionary.to_pylist(), None]
    places = coded.indices.fill_null(len(texts) - 1) if coded.null_count else coded.indices
    return list(map(texts.__getitem__, places.to_numpy().tolist()))


def _names(column: pa.Array) -> tuple[str, ...]:
    if column.null_count:
        raise ValueError("a name is missing")
    if pa.types.is_dictionary(column.type):
        column = column.dictionary_decode().fill_null("")
    return tuple(column.to_numpy(zero_copy_only=False).tolist())


def _ids(column: pa.Array, starts: NDArray[np.int64]) -> tuple[str, ...]:
    """Ids of all boxes; none where no box has one."""
    if column.null_count == len(column):
        return ()
    if column.null_count:
        return tuple(
            text or ""
            for own, count in zip(column.to_pylist(), np.diff(starts).tolist(), strict=True)
            for text in _fitting(own, count)
        )
    if not np.array_equal(_starts(column), starts):
        raise ValueError("lists differ in length")
    ids = tuple(text or "" for text in _texts(column.flatten()))
    return ids if any(ids) else ()


def _fitting(own: list[str | None] | None, count: int) -> list[str | None]:
    if own is not None and len(own) != count:
        raise ValueError("lists differ in length")
    return [""] * count if own is None else own


def _pallets(given: Mapping[str, pa.Array], deck: Mapping[str, Any]) -> Pallets:
    """The pallets of all rows."""
    keys = [key for key in DECK_KEYS if key in given and key not in deck]
    columns = [given[key] for key in (*PALLET_SIDES, *keys)]
    first, which = np.array([0]), np.zeros(len(columns[0]), dtype=np.int64)
    for column in columns:
        coded = column if pa.types.is_dictionary(column.type) else column.dictionary_encode()
        count = len(coded.dictionary) + 1
        if count > 2 or coded.null_count:  # more than one value
            places = coded.indices.fill_null(count - 1).to_numpy(zero_copy_only=False)
            _, first, which = np.unique(
                which * count + places, return_index=True, return_inverse=True
            )
    kinds = []
    for row in first.tolist():
        width, height, depth, *stated = (column[row].as_py() for column in columns)
        told = {k: value for k, value in zip(keys, stated, strict=True) if value is not None}
        kinds.append(Pallet(width, height, depth, **told, **deck))
    return Pallets(tuple(kinds), which)

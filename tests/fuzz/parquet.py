"""Structured mutation of Parquet files: columns and values of their tables, or their bytes."""

import io

import pyarrow as pa
import pyarrow.parquet as pq
from mutation import mutated

_TYPES = (pa.string(), pa.int64(), pa.float64(), pa.list_(pa.float64()), pa.binary(), pa.bool_())
_VALUES = (
    None, "", "x\x1b[2J", "x" * 3000, 0, -1, 2**15 - 1, 2**31 - 1, 1e308, float("nan"), [], [0.0],
    [float("nan")] * 3, [1.0] * 4000, [-1.0, 0.0], True, b"\xff",
)  # fmt: skip


def mutated_table(content, draw):
    """A file of a table with other columns, types, values or rows, or with changed bytes."""
    if draw.random() < 0.3:
        return mutated(content, draw)
    table = pq.read_table(pa.BufferReader(content))
    for _ in range(draw.choice((1, 1, 2, 3))):
        table = _changed(table, draw)
    sink = io.BytesIO()
    pq.write_table(table, sink)
    return sink.getvalue()


def _changed(table, draw):
    if not table.num_columns:
        return table
    place = draw.randrange(table.num_columns)
    field, kind = table.schema.field(place), draw.randrange(9)
    if kind == 0:
        return table.remove_column(place)
    if kind == 1:
        renamed = list(table.column_names)
        renamed[place] = draw.choice(("", "x", "layout", "a" * 300))
        return table.rename_columns(renamed)
    if kind == 2:
        other = draw.choice(_TYPES)
        return table.set_column(place, field.name, pa.nulls(table.num_rows, other))
    if kind == 3:
        return table.slice(0, draw.randrange(table.num_rows + 1))
    if kind == 4:
        return pa.concat_tables([table] * draw.choice((2, 50)))
    if kind == 5:
        rows = draw.choice((3_000, 300_000))  # of which the latter are too many
        texts = pa.DictionaryArray.from_arrays(pa.array([0] * rows, pa.int32()), ["x" * 1000])
        nulls = [pa.nulls(rows, column.type) for column in table.columns]
        return pa.table(nulls, table.column_names).set_column(place, field.name, texts)
    values = table.column(place).to_pylist()
    for row in range(len(values)):
        if draw.random() < 0.7:
            values[row] = draw.choice(_VALUES)
    try:
        column = pa.array(values, field.type)
    except (pa.ArrowException, TypeError, ValueError, OverflowError):
        return table
    return table.set_column(place, field.with_nullable(True), column)

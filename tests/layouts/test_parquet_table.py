"""How much of a Parquet file is read: small ones can hold a value very many times."""

import io
import subprocess
import sys

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from steadyload.layouts.benchmark import tables
from steadyload.layouts.files import parquet_table
from steadyload.layouts.files.parquet_table import TableTooLargeError, table_of
from steadyload.runs.store import ResultsError, Store, parquet


def repeated(text, rows):
    """A column that holds one text in every row, and takes little memory."""
    return pa.DictionaryArray.from_arrays(pa.array(np.zeros(rows, dtype=np.int32)), [text])


def content_of(**columns):
    sink = io.BytesIO()
    pq.write_table(pa.table(columns), sink, compression="zstd")
    return sink.getvalue()


TEXTS = content_of(a=repeated("x" * 10_000, 30_000))
LISTS = content_of(a=pa.ListArray.from_arrays([0, 30_000], repeated("x" * 10_000, 30_000)))
NUMBERS = content_of(a=np.zeros(34_000_000, dtype=np.int8))


@pytest.mark.parametrize("content", [TEXTS, LISTS, NUMBERS], ids=["texts", "lists", "numbers"])
def test_a_small_file_of_a_large_table_is_refused_before_it_is_read(content, monkeypatch):
    assert len(content) < 300_000
    monkeypatch.setattr(parquet_table.pq, "read_table", None)
    with pytest.raises(TableTooLargeError, match=r"^it (has 34,000,000 values|takes 287 MiB)"):
        table_of(content)


def test_a_file_that_unpacks_to_too_many_bytes_is_refused(monkeypatch):
    content = content_of(a=np.arange(100_000, dtype=np.float64))
    monkeypatch.setattr(parquet_table, "MAX_TABLE_BYTES", 500_000)
    with pytest.raises(TableTooLargeError, match="unpacked; allowed: 489 KiB"):
        table_of(content)


def test_other_tables_are_read_whole():
    columns = {"a": ["x", None], "b": [["x", None], None], "c": [1, None], "d": [b"x", None]}
    assert table_of(content_of(**columns)).to_pydict() == columns


def renamed(content, place):
    """The same file with another name in one of the two places that state that of its column."""
    before, between, after = content.split(b"names")
    first, second = [b"nymes" if place == k else b"names" for k in (0, 1)]
    return before + first + between + second + after


@pytest.mark.parametrize("place", [0, 1])
def test_texts_count_where_the_file_names_their_column_in_two_ways(place):
    assert table_of(renamed(content_of(names=["a", "b"]), place)).num_rows == 2
    with pytest.raises(TableTooLargeError, match="287 MiB"):
        table_of(renamed(content_of(names=repeated("x" * 10_000, 30_000)), place))


FLIPS = """
import io
import pyarrow as pa
import pyarrow.parquet as pq
from steadyload.layouts.files.parquet_table import table_of

sink = io.BytesIO()
pq.write_table(pa.table({"step": [1, None], "name": ["a", "b"]}), sink)
whole = sink.getvalue()
footer = int.from_bytes(whole[-8:-4], "little") + 8
for place in range(8 * (len(whole) - footer), 8 * len(whole)):
    flipped = bytearray(whole)
    flipped[place // 8] ^= 1 << place % 8
    try:
        table_of(bytes(flipped))
    except (OSError, ValueError, pa.ArrowException):
        pass
"""


def test_no_flipped_bit_of_a_footer_ends_the_process():
    """pyarrow ends the process for some of them, when it is asked for the size of a column."""
    done = subprocess.run([sys.executable, "-c", FLIPS], capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")


def test_a_labelled_table_and_a_shard_that_are_too_large_are_named(tmp_path, monkeypatch):
    schema = pa.schema([pa.field("a", pa.string())])
    (tmp_path / "table.parquet").write_bytes(TEXTS)
    with pytest.raises(tables.BenchmarkError, match=r"table\.parquet.*287 MiB unpacked; allowed"):
        tables.read_parquet(tmp_path / "table.parquet", schema)
    store = Store(tmp_path / "rows", parquet(schema))
    store.write("one", [{"a": "x"}, {"a": "y"}])
    assert store.read("one").equals(pd.DataFrame({"a": ["x", "y"]}))
    monkeypatch.setattr(parquet_table, "MAX_TABLE_VALUES", 1)
    with pytest.raises(ResultsError, match=r"one\..*\.parquet: is too large: it has 2 values"):
        store.decoded("one", table_of)

"""All verdicts of a folder of runs as one tidy table, a row a verdict, and the way back to shards.

A row says by which run and shard it is kept, what a method said of which case, what the labels of
that case are, and what it took. Anything that reads Parquet reads the table; :func:`shards` gives
run folders their files back.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Mapping
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq

from steadyload.layouts.benchmark.dataset import KEYS
from steadyload.layouts.model.question import Question
from steadyload.methods.contract.method import Status
from steadyload.runs.labels import LABELS, LABELS_FILE, load_labels
from steadyload.runs.results import SCHEMA, load_manifest, result_store, shard_of
from steadyload.runs.timing import kept_times

ABOUT: Mapping[str, tuple[pa.DataType, str]] = {
    "run": (pa.string(), "folder of the run, below the work folder of the page"),
    "shard": (pa.string(), "key of the unit of work in which the row was judged"),
    "layout": (pa.string(), "name of the layout"),
    "layout_hash": (pa.string(), "digest of its content, with the centres of mass of the case"),
    "scenario": (pa.string(), "S1, S2a or S2b: where centres of mass lie"),
    "list": (pa.string(), "item list that the layout was packed from; cluster of intervals"),
    "class": (pa.string(), "class of items of that list; stratum of intervals"),
    "item_count": (pa.int32(), "boxes of the layout"),
    "label_within": (pa.int16(), "failing step by the reference, question `within`; null: stable"),
    "label_stands": (pa.int16(), "the same of the question `stands`"),
    "labelled_within": (pa.bool_(), "whether the case has a label of the question `within`"),
    "labelled_stands": (pa.bool_(), "whether it has one of the question `stands`"),
    "robust": (pa.bool_(), "whether perturbed labels agree; missing where none were made"),
    "method": (pa.string(), "spec of the method"),
    "method_name": (pa.string(), "its name"),
    "engine": (pa.string(), "its engine; missing for a method without one"),
    "parameters": (pa.string(), "all its parameters, JSON"),
    "question": (pa.string(), "question that its parameters state; `within` where they state none"),
    "repetition": (pa.int32(), "number of the judgement of this case by this method, from 0"),
    "status": (pa.string(), "`done`, or why there is no verdict"),
    "failing_step": (pa.int32(), "items placed before the first that moves too far; null: stable"),
    "score": (pa.float64(), "share of items placed safely; missing without a verdict"),
    "moved_item": (pa.int32(), "item that moved too far"),
    "displacement_cm": (pa.float64(), "its way"),
    "rotation_deg": (pa.float64(), "its turn"),
    "reason": (pa.string(), "why the verdict is so, or why there is none"),
    "ignored": (pa.list_(pa.string()), "settings that the engine ignored"),
    "emulated": (pa.list_(pa.string()), "settings that it emulated"),
    "substeps": (pa.int64(), "steps of the engine"),
    "body_substeps": (pa.int64(), "steps times boxes that take part"),
    "cpu_build_ns": (pa.int64(), "CPU time of building scenes, while judging"),
    "cpu_step_ns": (pa.int64(), "CPU time of stepping"),
    "cpu_read_ns": (pa.int64(), "CPU time of reading positions"),
    "cpu_total_ns": (pa.int64(), "CPU time of the judgement"),
    "wall_total_ns": (pa.int64(), "wall time of the judgement"),
    "timed_cpu_ns": (pa.int64(), "CPU time in the timing pass, methods in turns; null: not timed"),
    "timed_wall_ns": (pa.int64(), "wall time of that"),
}  # fmt: skip
"""Columns of the table: type and meaning, with units in their names."""

TABLE = pa.schema([pa.field(name, kind) for name, (kind, _) in ABOUT.items()])
"""Schema of the table."""

_NS = re.compile(r"(?P<time>(?:cpu|wall)_\w+)_ns")
_STORED = {"displacement_cm": "displacement", "rotation_deg": "rotation"}
_KEPT = {name: found["time"] if (found := _NS.fullmatch(name)) else _STORED.get(name, name)
         for name in ABOUT}  # fmt: skip
"""Column of the table -> that of the rows of a shard, where it comes from there."""

_NUMBERS = [name for name, kept in _KEPT.items() if name != kept]
"""Columns of numbers that hardly repeat."""


def table(work: Path, runs: Iterable[str]) -> pa.Table:
    """The verdicts of runs, sorted by run, method and case.

    Args:
        work: folder that they lie in.
        runs: their folders, below it.

    Raises:
        ResultsError: a folder is none of a run, or is damaged.
    """
    found = pa.concat_tables(_rows(work / run, run) for run in runs)
    return found.sort_by([(name, "ascending") for name in ("run", "method", *KEYS, "repetition")])


def content(table: pa.Table, **more: str) -> bytes:
    """The table as a Parquet file, with further texts beside the schema."""
    sink = pa.BufferOutputStream()
    with pq.ParquetWriter(
        sink, table.schema, compression="zstd", compression_level=19,
        use_dictionary=[name for name in ABOUT if name not in _NUMBERS],
        use_byte_stream_split=_NUMBERS, write_statistics=False, write_page_checksum=True,
    ) as writer:  # fmt: skip
        writer.write_table(table)
        writer.add_key_value_metadata(more)
    return sink.getvalue().to_pybytes()


def write_shards(table: pa.Table, work: Path) -> None:
    """Write the shards of all runs of a table below a folder. Phases of wall time are not known."""
    stored = {
        kept: _as_stored(table[name], name, SCHEMA.field(kept).type)
        for name, kept in _KEPT.items() if kept in SCHEMA.names
    }  # fmt: skip
    unknown = pa.nulls(len(table), pa.float64()).fill_null(np.nan)
    rows = pa.table([stored.get(name, unknown) for name in SCHEMA.names], schema=SCHEMA)
    units = pd.DataFrame({name: table[name].to_numpy() for name in ("run", "shard")})
    for (run, shard), places in units.groupby(["run", "shard"]).indices.items():
        result_store(work / run).add(shard, shard_of(rows.take(places)))


def _rows(folder: Path, run: str) -> pa.Table:
    """The verdicts of a run."""
    store, shards = result_store(folder), load_manifest(folder)["shards"]
    each = {key: store.read(key) for key in shards if key in store}
    rows = pa.concat_tables(each.values())
    keys = rows.select(["layout", "layout_hash", "scenario", "method", "parameters"]).to_pandas()
    questions = {text: _question(text) for text in keys["parameters"].unique()}
    added = (
        keys.merge(_labels(folder), "left", on=KEYS)
        .merge(kept_times(folder / "times"), "left", on=["method", "layout", "layout_hash"])
        .assign(
            run=run, shard=np.repeat(list(each), [len(own) for own in each.values()]),
            question=keys["parameters"].map(questions),
        )
    )  # fmt: skip
    columns = [
        _as_kept(rows[kept], one) if kept in SCHEMA.names
        else pa.array(added[one.name], one.type, from_pandas=True)
        for one, kept in zip(TABLE, _KEPT.values(), strict=True)
    ]  # fmt: skip
    return pa.table(columns, schema=TABLE)


def _as_kept(column: pa.ChunkedArray, one: pa.Field) -> pa.ChunkedArray:
    """A column of a shard in the table: times in nanoseconds, the resolution of the clocks."""
    if _NS.fullmatch(one.name):
        column = pc.round(pc.multiply(column, 1e9))
    return column.cast(one.type, safe=False)


def _as_stored(column: pa.ChunkedArray, name: str, kind: pa.DataType) -> pa.ChunkedArray:
    found = column.cast(kind)
    return pc.divide(found, 1e9) if _NS.fullmatch(name) else found


def _question(parameters: str) -> str:
    return str(json.loads(parameters).get("question", Question.WITHIN))


def _labels(folder: Path) -> pd.DataFrame:
    """The labels of the cases of a run by question; without any row where it has none."""
    if LABELS_FILE in load_manifest(folder).get("files", {}):
        found = load_labels(folder).reset_index()
    else:
        found = LABELS.empty_table().to_pandas()
    stands = found["stands"] == Status.DONE
    return pd.DataFrame(
        {
            **{name: found[name] for name in KEYS},
            "list": found["instance"], "class": found["item_class"],
            "label_within": found["failing_step"], "labelled_within": True,
            "label_stands": found["failing_step_stands"].where(stands), "labelled_stands": stands,
            "robust": found["robust"],
        }
    )  # fmt: skip

"""The Parquet form of a labelled set: three tables and a manifest in one folder."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path
from typing import Any

import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq

from steadyload.atomic import (
    ChecksumError,
    checksum,
    manifest_text,
    verified_manifest,
    write_atomically,
)
from steadyload.errors import UserError
from steadyload.escaping import printable
from steadyload.layouts.files.parquet_table import table_of
from steadyload.layouts.files.record import shown
from steadyload.reading import MAX_STORED_BYTES, MAX_TABLE_BYTES, content_of, json_of

VERSION = 2

_LONGEST = 200
"""Characters of a library's message that are passed on."""

UNLABELLED = "unlabelled"
"""Status of a case that has not been judged yet."""

_TEXT, _NUMBERS = pa.string(), pa.list_(pa.float64())


def later(field: pa.Field) -> pa.Field:
    """A column that was added to a schema later: files without it are read as if it were null."""
    return field.with_metadata({"later": "yes"})


LAYOUTS = pa.schema(
    [
        pa.field("layout", _TEXT, nullable=False),
        pa.field("instance", _TEXT, nullable=False),
        pa.field("item_class", pa.int8(), nullable=False),
        pa.field("sources", pa.list_(_TEXT), nullable=False),
        pa.field("pallet", _NUMBERS, nullable=False),
        pa.field("positions", _NUMBERS, nullable=False),
        pa.field("sizes", _NUMBERS, nullable=False),
        pa.field("weights", _NUMBERS, nullable=False),
    ]
)
"""A row a geometry. ``instance``: the item list it was packed from. ``sources``: the names of all
packings that gave it. Lengths [cm] as x, y, z of item 0, then of item 1, ...; weights [kg]."""

CASES = pa.schema(
    [
        pa.field("layout", _TEXT, nullable=False),
        pa.field("scenario", _TEXT, nullable=False),
        pa.field("item_count", pa.int16(), nullable=False),
        pa.field("offsets", _NUMBERS),
        pa.field("split", _TEXT),
        pa.field("rank", pa.int32()),
        pa.field("status", _TEXT, nullable=False),
        pa.field("failing_step", pa.int16()),
        pa.field("failing_step_paper", pa.int16()),
        pa.field("moved", pa.list_(pa.int16())),
        *(
            pa.field(f"{what}_{when}", pa.list_(pa.float32()))
            for what in ("corner", "centre", "angle")
            for when in ("last", "most")
        ),
        pa.field("margin", pa.list_(pa.float32())),
    ]
)
"""A row a layout and scenario.

``offsets``: centre of mass minus geometric centre [cm], as the positions; null when all are zero.
``split``: see :class:`steadyload.layouts.benchmark.dataset.Part`, null for rows of no split;
``rank``: place in it, by scenario. ``status``: how labelling ended; only ``done`` has labels.
``failing_step``: counted from 0, criterion ``adams``, null for a stable layout;
``failing_step_paper``: likewise, criterion ``paper``.

The lists hold a value a step that was simulated. The largest over all items placed by then:
``corner`` how far a left-bottom-back corner moved along one axis [cm], ``centre`` how far a
geometric centre moved [cm], ``angle`` how far an item turned about an axis [degrees]; ``last`` at
the last sample, ``most`` at any. ``moved``: the item that is furthest beyond its thresholds then.
``margin``: how far every contact patch may shrink until balance is lost [cm], over the items joined
to the one placed last by standing on each other.
"""

OPINIONS = pa.schema(
    [
        pa.field("layout", _TEXT, nullable=False),
        pa.field("scenario", _TEXT, nullable=False),
        pa.field("question", _TEXT, nullable=False),
        pa.field("reason", _TEXT, nullable=False),
        pa.field("judge", _TEXT, nullable=False),
        pa.field("status", _TEXT, nullable=False),
        pa.field("failing_step", pa.int16()),
    ]
)
"""A row a layout, scenario, question and further method. ``reason``: why it could disagree, see
:class:`steadyload.layouts.benchmark.confidence.Reason`; ``judge``: what was changed, or a
method."""

LABELS = pa.schema(
    [
        pa.field("layout", _TEXT, nullable=False),
        pa.field("scenario", _TEXT, nullable=False),
        pa.field("question", _TEXT, nullable=False),
        pa.field("status", _TEXT, nullable=False),
        pa.field("failing_step", pa.int16()),
        pa.field("moved_item", pa.int16()),
        pa.field("displacement", pa.float32()),
        pa.field("rotation", pa.float32()),
    ]
)
"""A row a case and question; the labels of ``within`` are in :data:`CASES`, since splits follow
from them, and other questions have labels of some cases only. ``status``: ``done``, ``unsettled``,
or how labelling ended without a label. ``failing_step``: the label, counted from 0, null for a
stable layout. ``moved_item``: the item that moved too far, or moves most; ``displacement`` [cm] and
``rotation`` [degrees] of it when that was seen."""

SCREENING = pa.schema(
    [
        pa.field("layout", _TEXT, nullable=False),
        pa.field("scenario", _TEXT, nullable=False),
        pa.field("screen", pa.list_(pa.float32()), nullable=False),
        pa.field("reference", pa.list_(pa.float32()), nullable=False),
        pa.field("why", pa.list_(_TEXT), nullable=False),
        later(pa.field("second", pa.list_(pa.float32()))),
    ]
)
"""A row a case that was labelled by screening, see :mod:`steadyload.labelling.screening`.
The lists hold a value a step: how far the item got that moved most, in units of the threshold, by
the simulation that ``screen``s, by the ``second`` one where there are two, and by the
``reference``, not a number where that was not asked; and ``why`` it was, empty where it was not."""

SCREENED = pa.schema(
    [
        *(
            pa.field(name, _TEXT, nullable=False)
            for name in ("layout", "scenario", "status", "reason")
        ),
        pa.field("item_count", pa.int16(), nullable=False),
        pa.field("failing_step", pa.int16()),
        pa.field("stands", _TEXT, nullable=False),
        pa.field("failing_step_stands", pa.int16()),
        pa.field("moved_item", pa.int16()),
        pa.field("moved", pa.list_(pa.int16())),
        *(
            pa.field(f"{what}_{when}", pa.list_(pa.float32()))
            for what in ("corner", "angle")
            for when in ("last", "most")
        ),
        *(
            pa.field(name, pa.list_(pa.float32()))
            for name in ("margin", "screen", "second", "reference")
        ),
        pa.field("why", pa.list_(_TEXT)),
    ]
)
"""Cases as :mod:`steadyload.labelling.screening` labels them, one in each row: their columns of
:data:`CASES`, :data:`LABELS` and :data:`SCREENING`."""

BEGUN = SCREENED.append(pa.field("key", _TEXT, nullable=False))
"""Rows of cases that a set still calls unlabelled, or of labels that were made again, each with the
key of what it depends on."""

_TABLES = {"layouts": LAYOUTS, "cases": CASES, "opinions": OPINIONS}

FURTHER = {"labels": LABELS, "screening": SCREENING, "begun": BEGUN, "again": BEGUN}
"""Tables that only some labelled sets have, by name; labelling alone reads the last two."""

SET_FILES = ("manifest.json", "notes.md", *(f"{name}.parquet" for name in (*_TABLES, *FURTHER)))
"""Files of the folder of a labelled set."""

_CHECKSUMS = "checksums"
"""Entry of the manifest: the checksum of every table, by name."""


class BenchmarkError(UserError):
    """A folder that holds no labelled set, a damaged one, or one that lacks what is needed."""


class DamagedSetError(BenchmarkError):
    """A file of a labelled set whose content is no longer what was written."""

    def __init__(self, path: Path) -> None:
        super().__init__(
            f"{path}: is damaged, its checksum is another; take it from a backup, or remove the "
            "folder and make the set anew"
        )


def write_tables(
    directory: Path,
    layouts: pd.DataFrame,
    cases: pd.DataFrame,
    opinions: pd.DataFrame,
    manifest: dict[str, Any],
    *,
    keep_further: bool = False,
) -> None:
    """Write a labelled set. All that takes time or may fail comes before the first file.

    While tables are being replaced, a manifest that is there has no checksums of them.

    Args:
        directory: made when it does not exist.
        layouts: :data:`LAYOUTS`.
        cases: :data:`CASES`.
        opinions: :data:`OPINIONS`.
        manifest: further entries.
        keep_further: the tables of :data:`FURTHER` that are there are of these cases, too; without
            it they are no part of the set any more.
    """
    frames = {"layouts": layouts, "cases": cases, "opinions": opinions}
    contents = {name: as_parquet(frame, _TABLES[name]) for name, frame in frames.items()}
    directory.mkdir(parents=True, exist_ok=True)
    path = directory / "manifest.json"
    further: dict[str, Any] = {}
    sums: dict[str, str] = {}
    with suppress(BenchmarkError):
        before = _load_manifest(path)
        if keep_further:
            further = {name: before[name] for name in FURTHER if name in before}
            known = before.get(_CHECKSUMS, {})
            sums = {name: known[name] for name in FURTHER if name in known}
        write_atomically(path, manifest_text({**before, _CHECKSUMS: sums}))
    for name, content in contents.items():
        write_atomically(directory / f"{name}.parquet", content)
    counts = {"layouts": len(layouts), "cases": len(cases), "opinions": len(opinions)}
    sums |= {name: checksum(content) for name, content in contents.items()}
    given = {key: value for key, value in manifest.items() if key not in FURTHER}
    own = {"version": VERSION, **counts, _CHECKSUMS: sums}
    # Those of an earlier manifest give way.
    write_atomically(path, manifest_text(own | given | own | further))


def write_further(
    directory: Path, name: str, frame: pd.DataFrame, made_with: dict[str, Any]
) -> None:
    """Write one of the tables of :data:`FURTHER` into a labelled set.

    Args:
        directory: of the set; its other tables stay as they are.
        name: of the table.
        frame: a row a case; those that are there give way.
        made_with: of these rows, for the manifest.

    Raises:
        BenchmarkError: no labelled set.
    """
    path = directory / "manifest.json"
    manifest = _load_manifest(path)
    content = as_parquet(frame, FURTHER[name])
    sums = dict(manifest.get(_CHECKSUMS, {}))
    sums.pop(name, None)
    manifest.pop(name, None)
    write_atomically(path, manifest_text({**manifest, _CHECKSUMS: sums}))
    write_atomically(directory / f"{name}.parquet", content)
    about = {name: made_with, _CHECKSUMS: {**sums, name: checksum(content)}}
    write_atomically(path, manifest_text({**manifest, **about}))


def read_further(directory: Path, name: str) -> pd.DataFrame:
    """One of the tables of :data:`FURTHER`; empty where a set has none.

    Raises:
        BenchmarkError: not a labelled set, or a damaged one.
    """
    schema = FURTHER[name]
    expected = _load_manifest(directory / "manifest.json").get(_CHECKSUMS, {}).get(name)
    if expected is None:  # of another labelling, or half written
        return no_rows(schema)
    return read_parquet(directory / f"{name}.parquet", schema, expected)


def refuse_foreign(directory: Path) -> None:
    """A folder of something else is never written into: its manifest would be lost.

    Raises:
        BenchmarkError: it is a file, or holds what is no part of a labelled set.
    """
    if directory.exists() and not directory.is_dir():
        raise BenchmarkError(f"{directory}: is not a folder")
    names = {path.name for path in directory.iterdir()} if directory.is_dir() else set()
    foreign = sorted(names - {*SET_FILES})
    if names == {"manifest.json"}:
        foreign = ["manifest.json"]
    if foreign:
        raise BenchmarkError(
            f"{directory}: holds {foreign[0]!r}, so it is no labelled set to replace; "
            "allowed: a new or an empty folder, or a labelled set"
        )


def no_rows(schema: pa.Schema) -> pd.DataFrame:
    """A table without rows, of the types of one that is read."""
    return from_parquet(as_parquet(pd.DataFrame(columns=schema.names), schema), schema)


def as_parquet(frame: pd.DataFrame, schema: pa.Schema) -> bytes:
    """A table as the bytes of a Parquet file."""
    columns = [pa.array(_plain(frame[field.name]), field.type) for field in schema]
    table = pa.Table.from_arrays(columns, schema=schema)
    sink = pa.BufferOutputStream()
    pq.write_table(table, sink, compression="zstd", compression_level=19)
    return bytes(sink.getvalue().to_pybytes())


def _plain(column: pd.Series) -> list[Any]:
    """Values with None for every kind of missing; a list is never missing."""
    return [None if pd.api.types.is_scalar(v) and pd.isna(v) else v for v in column]


def read_tables(
    directory: Path,
) -> tuple[pd.DataFrame, pd.DataFrame, pd.DataFrame, dict[str, Any]]:
    """Layouts, cases, verdicts of further methods and manifest of a folder.

    Whole numbers that may be missing come as pandas' nullable integers.

    Raises:
        BenchmarkError: not such a folder, one of another version, or a damaged one.
    """
    manifest = _load_manifest(directory / "manifest.json")
    sums = manifest.pop(_CHECKSUMS, {})
    layouts, cases, opinions = (
        read_parquet(directory / f"{name}.parquet", schema, sums.get(name))
        for name, schema in _TABLES.items()
    )
    return layouts, cases, opinions, manifest


def _load_manifest(path: Path) -> dict[str, Any]:
    try:
        content = content_of(path, MAX_STORED_BYTES)
    except FileNotFoundError:
        raise BenchmarkError(f"{path.parent}: no manifest.json; is it a labelled set?") from None
    try:
        manifest = json_of(content)
        version = manifest["version"]
        found = verified_manifest(manifest)
    except ChecksumError:
        raise DamagedSetError(path) from None
    except (ValueError, TypeError, LookupError, RecursionError):
        raise BenchmarkError(f"{path}: is not the manifest of a labelled set") from None
    if version != VERSION:
        raise BenchmarkError(f"{path}: version is {shown(version)}; allowed: {VERSION}")
    return found


def read_parquet(path: Path, schema: pa.Schema, expected: str | None = None) -> pd.DataFrame:
    """A table of one of the schemas above.

    Args:
        path: the file.
        schema: of the table.
        expected: its checksum; None where it is not known.

    Raises:
        BenchmarkError: it is missing, damaged, or of another schema.
    """
    try:
        content = content_of(path, MAX_TABLE_BYTES)
    except FileNotFoundError:
        raise BenchmarkError(f"{path}: is missing") from None
    if expected not in (None, checksum(content)):
        raise DamagedSetError(path)
    try:
        return from_parquet(content, schema)
    except BenchmarkError as error:
        raise BenchmarkError(f"{path}: {error}") from None


def from_parquet(content: bytes, schema: pa.Schema) -> pd.DataFrame:
    """A table from the bytes of a Parquet file; raises as :func:`read_parquet`."""
    nullable = {pa.int16(): pd.Int16Dtype(), pa.int32(): pd.Int32Dtype()}
    try:
        table = table_of(content)
        for field in schema:
            if field.metadata and field.name not in table.schema.names:
                table = table.append_column(field, pa.nulls(len(table), field.type))
        found = table.schema
        if found.names == schema.names and found.types == schema.types:
            return table.to_pandas(types_mapper=nullable.get)
    except (OSError, ValueError, pa.ArrowException) as error:
        why = printable(" ".join(str(error).split()), _LONGEST)
        raise BenchmarkError(f"cannot be read as Parquet ({why})") from None
    raise BenchmarkError("has other columns than a labelled set")

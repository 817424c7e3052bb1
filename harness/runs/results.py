"""The one result schema: a row per (method, layout, scenario, repetition), in Parquet.

A run folder holds ``manifest.json``, ``layouts.parquet`` and ``results/*.parquet``, a
:class:`steadyload.runs.store.Store`: a run that was interrupted at any moment can be loaded and
resumed. The manifest has the checksums of the single files beside it.
"""

from __future__ import annotations

import json
import logging
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import partial
from operator import attrgetter
from pathlib import Path
from typing import Any

import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq

from steadyload.atomic import ChecksumError, verified_manifest
from steadyload.layouts.files.parquet_table import table_of
from steadyload.layouts.files.record import shown
from steadyload.layouts.model.layout import Layout
from steadyload.methods.contract.method import Method, Verdict
from steadyload.methods.contract.spec import stored_values
from steadyload.reading import MAX_STORED_BYTES, content_of, json_of
from steadyload.runs.store import Codec, DamagedError, Store, checksum_of
from steadyload.runs.store import ResultsError as ResultsError

_log = logging.getLogger("steadyload")

SCHEMA_VERSION = 2
"""2: shards and the files beside them have checksums. The rows are those of 1."""

LAYOUTS_FILE = "layouts.parquet"
"""Name of the copy of the layouts in a run folder."""

_SECONDS = ("build", "step", "read", "total")

SCHEMA = pa.schema(
    [
        pa.field("layout", pa.string(), nullable=False),
        pa.field("layout_hash", pa.string(), nullable=False),
        pa.field("scenario", pa.string(), nullable=False),
        pa.field("item_count", pa.int32(), nullable=False),
        pa.field("method", pa.string(), nullable=False),
        pa.field("method_name", pa.string(), nullable=False),
        pa.field("engine", pa.string()),
        pa.field("parameters", pa.string(), nullable=False),
        pa.field("repetition", pa.int32(), nullable=False),
        pa.field("status", pa.string(), nullable=False),
        pa.field("failing_step", pa.int32()),
        pa.field("score", pa.float64()),
        pa.field("moved_item", pa.int32()),
        pa.field("displacement", pa.float64()),
        pa.field("rotation", pa.float64()),
        pa.field("reason", pa.string(), nullable=False),
        pa.field("ignored", pa.list_(pa.string()), nullable=False),
        pa.field("emulated", pa.list_(pa.string()), nullable=False),
        pa.field("substeps", pa.int64(), nullable=False),
        *(
            pa.field(f"{clock}_{phase}", pa.float64(), nullable=False)
            for clock in ("cpu", "wall")
            for phase in _SECONDS
        ),
        pa.field("body_substeps", pa.int64()),
    ]
)
"""Column names, types and which may be null. ``displacement`` [cm], ``rotation`` [degrees],
``cpu_*`` and ``wall_*`` [s]; ``parameters`` is the full parameter set as JSON; ``failing_step`` is
null for a stable layout and for a verdict without a score. ``body_substeps``: substeps times the
boxes that take part, null in rows of earlier versions."""

_WITH_UNITS = {"displacement": "displacement_cm", "rotation": "rotation_deg"}
"""Columns that are handed out under another name than they are stored under."""

_STORED = {handed: stored for stored, handed in _WITH_UNITS.items()}

COLUMNS = tuple(_WITH_UNITS.get(name, name) for name in SCHEMA.names)
"""Columns of the rows that are handed out: those of :data:`SCHEMA`, with units in their names."""

_MANIFEST_KEYS = ("schema_version", "study", "study_hash", "data_hash", "shards", "finished")

KEYS = ["layout", "scenario", "method", "repetition"]


OF_VERDICTS: Mapping[str, Callable[[Verdict], Any]] = {
    **{
        name: attrgetter(name)
        for name in (
            "status", "failing_step", "score", "moved_item", "displacement", "rotation", "reason",
            "ignored", "emulated",
        )
    },
    "substeps": attrgetter("effort.substeps"),
    **{
        f"{clock}_{phase}": attrgetter(f"{clock}.{phase}")
        for clock in ("cpu", "wall")
        for phase in _SECONDS
    },
    "body_substeps": attrgetter("effort.body_substeps"),
}  # fmt: skip
"""The columns that a row takes from its verdict, each with its value."""


def result_row(
    layout: Layout, scenario: str, said: Mapping[str, Any], repetition: int, verdict: Verdict
) -> dict[str, Any]:
    """One row of :data:`SCHEMA`.

    Args:
        layout: as it was judged.
        scenario: of the case.
        said: of the method, see :func:`said_of`.
        repetition: of the judgement.
        verdict: on it.
    """
    return {
        "layout": layout.name,
        "layout_hash": layout.content_hash(),
        "scenario": scenario,
        "item_count": verdict.item_count,
        "repetition": repetition,
        **said,
        **{name: value(verdict) for name, value in OF_VERDICTS.items()},
    }


def said_of(method: Method) -> dict[str, Any]:
    """Values of the columns that say which method judged."""
    return {
        "method": str(method.spec),
        "method_name": method.spec.name,
        "engine": method.spec.engine,
        "parameters": json.dumps(stored_values(method.parameters), sort_keys=True),
    }


_FEW = 100
"""Rows of a shard in which dictionaries save no room."""


def shard_of(rows: pa.Table) -> bytes:
    """The bytes of a shard of some rows."""
    sink = pa.BufferOutputStream()
    # Of a dozen rows, as most shards have, a dictionary a column takes half of the time.
    pq.write_table(rows, sink, use_dictionary=len(rows) > _FEW, write_statistics=False)
    return sink.getvalue().to_pybytes()


def _encoded(rows: Sequence[dict[str, Any]]) -> bytes:
    return shard_of(pa.Table.from_pylist([dict(r) for r in rows], schema=SCHEMA))


def _decoded(content: bytes, columns: Sequence[str] | None = None) -> pa.Table:
    return table_of(content, schema=SCHEMA, columns=None if columns is None else list(columns))


ROWS: Codec[dict[str, Any], pa.Table] = Codec(".parquet", _encoded, _decoded)
"""A shard of rows."""


def result_store(directory: Path) -> Store[dict[str, Any], pa.Table]:
    """The shards of a run folder."""
    return Store(directory / "results", ROWS)


def superseded(directory: Path) -> set[Path]:
    """Shards in a run folder that its manifest does not list: of an earlier study or other code.

    Raises:
        ResultsError: as :func:`load_manifest`.
    """
    listed, store = load_manifest(directory)["shards"], result_store(directory)
    return {store.path(key) for key in set(store.keys()).difference(listed)}


def load_results(directory: str | Path, columns: Sequence[str] | None = None) -> pd.DataFrame:
    """All rows of a run folder as a DataFrame with :data:`COLUMNS`.

    A run that is not finished gives the rows that are there, with a warning that says how many
    shards are missing. Integer columns that may be missing come as pandas' nullable ``Int32``. Rows
    are sorted, so equal studies give equal frames whatever order they were computed in.

    Args:
        directory: the run folder.
        columns: those to read, in this order; None for all. For many rows, leave out columns that
            are not needed: ``ignored`` and ``emulated`` take as much memory as all others.

    Raises:
        ResultsError: not a run folder, one of another schema version, a damaged one, or a finished
            one without all of its shards.
    """
    read = None if columns is None else [*columns, *KEYS]
    rows = in_order(each_table(directory, load_manifest(directory), read))
    return rows if columns is None else rows[list(columns)]


def in_order(tables: Iterable[pa.Table]) -> pd.DataFrame:
    """The rows of shards, all of them, sorted by :data:`KEYS`."""
    rows = _frame(pa.concat_tables(tables))
    return rows.sort_values(KEYS, kind="stable", ignore_index=True)


def each_shard(
    directory: str | Path, columns: Sequence[str] | None = None
) -> Iterator[pd.DataFrame]:
    """The rows of a run folder, one shard after the other, however many there are.

    Args:
        directory: the run folder.
        columns: those to read; None for all.

    Raises:
        ResultsError: as :func:`load_results`.
    """
    for table in each_table(directory, load_manifest(directory), columns):
        rows = _frame(table)
        yield rows if columns is None else rows[list(columns)]


def each_table(
    directory: str | Path, manifest: Mapping[str, Any], columns: Sequence[str] | None = None
) -> Iterator[pa.Table]:
    """The tables of the existing shards of a run, one after the other, each read once.

    Args:
        directory: the run folder.
        manifest: of it.
        columns: those to read, as rows are handed out; None for all.

    Raises:
        ResultsError: as :func:`load_results`.
    """
    directory = Path(directory)
    if columns is not None:
        columns = list(dict.fromkeys(_STORED.get(name, name) for name in columns))
    store = result_store(directory)
    keys = [key for key in manifest["shards"] if key in store]
    lost = len(manifest["shards"]) - len(keys)
    if lost and manifest.get("finished"):
        raise ResultsError(
            f"{directory}: {lost} of {len(manifest['shards'])} shards of a finished run are "
            "missing; run the study again to judge them anew"
        )
    if not keys:
        raise ResultsError(f"{directory}: holds no results yet")
    if lost:
        _log.warning(
            "%s: the run is not finished; %d of %d shards are there",
            directory, len(keys), len(manifest["shards"]),
        )  # fmt: skip
    for key in keys:
        yield store.decoded(key, partial(_decoded, columns=columns))


def kept_file(directory: str | Path, name: str, manifest: Mapping[str, Any] | None = None) -> Path:
    """A single file of a run folder, as it was written.

    Args:
        directory: the run folder.
        name: of the file.
        manifest: of the folder; None reads it.

    Raises:
        ResultsError: not a run folder, or the file is missing or damaged.
    """
    path = Path(directory) / name
    manifest = load_manifest(directory) if manifest is None else manifest
    expected, found = manifest.get("files", {}).get(name), checksum_of(path)
    if not found:
        raise ResultsError(f"{path}: is missing; run the study again to write it anew")
    if found != expected:
        raise DamagedError(path)
    return path


def kept_layouts(directory: str | Path, manifest: Mapping[str, Any] | None = None) -> Path:
    """The copy of the layouts of a run; arguments and errors are those of :func:`kept_file`."""
    return kept_file(directory, LAYOUTS_FILE, manifest)


def _frame(table: pa.Table) -> pd.DataFrame:
    """Stored rows as they are handed out."""
    nullable = {pa.int32(): pd.Int32Dtype()}
    return table.to_pandas(types_mapper=nullable.get).rename(columns=_WITH_UNITS)


def load_manifest(directory: str | Path) -> dict[str, Any]:
    """The manifest of a run folder.

    Raises:
        DamagedError: it is not what was written.
        ResultsError: not a run folder, or one of another :data:`SCHEMA_VERSION`.
        TooLargeError: it has too many bytes.
    """
    path = Path(directory) / "manifest.json"
    try:
        content = content_of(path, MAX_STORED_BYTES)
    except FileNotFoundError:
        raise ResultsError(f"{directory}: no manifest.json; is it the folder of a study?") from None
    try:
        manifest = json_of(content)
    except (ValueError, RecursionError):
        raise ResultsError(f"{path}: not valid JSON; is it cut off?") from None
    if not _is_manifest(manifest):
        raise ResultsError(f"{path}: is not the manifest of a study")
    found = manifest["schema_version"]
    if found != SCHEMA_VERSION:
        raise ResultsError(
            f"{directory}: schema version {shown(found)}; allowed: {SCHEMA_VERSION}; run the study "
            "again to compute it anew"
        )
    try:
        return verified_manifest(manifest)
    except ChecksumError:
        raise DamagedError(path) from None


def _is_manifest(found: Any) -> bool:
    if not isinstance(found, dict) or not set(_MANIFEST_KEYS) <= found.keys():
        return False
    study, shards, files = found["study"], found["shards"], found.get("files", {})
    size = found.get("cases_a_unit", 1)
    return (
        isinstance(study, dict)
        and isinstance(study.get("name"), str)
        and isinstance(shards, list)
        and all(isinstance(key, str) for key in shards)
        and isinstance(files, dict)
        and isinstance(found.get("refused", {}), dict)
        and isinstance(size, int)
        and size >= 1
    )

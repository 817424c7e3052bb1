"""Rows behind published pages, packed beside them: a page is redrawn from them without judging.

Verdicts are one tidy Parquet table a page, see :mod:`steadyload.runs.tidy`; beside its schema are
the other files of the work folder. What pages measure otherwise is an archive.
"""

from __future__ import annotations

import base64
import dataclasses
import io
import json
import lzma
import re
import tarfile
import tempfile
from collections.abc import Sequence
from fnmatch import fnmatchcase
from functools import partial
from pathlib import Path, PurePosixPath
from typing import Any

import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq

from steadyload.atomic import write_atomically
from steadyload.config import bind
from steadyload.errors import UserError
from steadyload.layouts.files.limits import MAX_FILE_BYTES, MAX_FOOTER_BYTES
from steadyload.layouts.files.parquet_table import TableTooLargeError, table_of
from steadyload.reading import (
    MAX_STORED_BYTES,
    TooLargeError,
    UnpacksTooLargeError,
    content_of,
    json_of,
    regular,
    unpacked,
)
from steadyload.runs import tidy
from steadyload.runs.provenance import MadeWith
from steadyload.runs.results import load_manifest, superseded
from steadyload.runs.store import CHECKPOINT, CHECKPOINTS, DamagedError, ResultsError
from steadyload.studies.published import ROWS, Entry, entries, named

MADE_WITH = "made_with.json"
"""States with what rows were made: in a work folder of its rows, beside the archives of all rows,
by archive."""

_LEFT_OUT = (".lock", "report.md", "report.html", "report-details*.md", "figures", MADE_WITH)
"""What a work folder holds besides rows, as patterns, and :data:`.CHECKPOINTS` anywhere in it."""

_MANIFEST = "manifest.json"

_BESIDE = "files"
"""Key, beside the schema of a table of verdicts, of the archive of all other files, in base 85."""

_MOST_BESIDE = MAX_FOOTER_BYTES - 2**16
"""Characters of that archive: it lies in the footer of the file, with what this says of columns."""

_MOST_FILES = 100_000
"""Files of an archive, ten times those of the largest one; :data:`.MAX_FILE_BYTES` are those of
the archive, and also of all its files together."""


class RowsError(UserError):
    """Rows that cannot be packed, or an archive of rows that cannot be unpacked."""


def keep(entry: Entry, folder: Path = ROWS) -> Path:
    """Pack the work folder of a page; the same rows give the same bytes. Returns the file.

    Shards that the manifest of their run does not list are left out.

    Args:
        entry: the page.
        folder: of the archives; pages that are made of one work folder share one.

    Raises:
        RowsError: the work folder does not exist, or has too much beside the verdicts.
    """
    if not entry.work.is_dir():
        raise RowsError(
            f"the rows of page {entry.name!r} should lie in {entry.work}, which does not exist; "
            f"steadyload pages remake {entry.name} makes them"
        )
    runs = _runs(entry.work) if entry.verdicts else []
    found = _packed(entry.work, [entry.work / run / "results" for run in runs])
    if entry.verdicts:
        beside = base64.b85encode(found).decode()
        if len(beside) > _MOST_BESIDE:
            raise RowsError(
                f"{entry.work}: files beside the verdicts take {_megabytes(len(beside))}; allowed: "
                f"{_megabytes(_MOST_BESIDE)}; pages with more keep an archive"
            )
        found = tidy.content(tidy.table(entry.work, map(str, runs)), **{_BESIDE: beside})
    folder.mkdir(parents=True, exist_ok=True)
    write_atomically(archive_of(entry, folder), found)
    stated = _stated_in(entry.work / MADE_WITH)
    if stated is not None:
        every = {**(_stated_in(folder / MADE_WITH) or {}), entry.work.name: stated}
        write_atomically(folder / MADE_WITH, _as_json(dict(sorted(every.items()))))
    return archive_of(entry, folder)


def rows(page: str, folder: str | Path = ROWS) -> pd.DataFrame:
    """The verdicts behind a published page, a row a verdict, with the labels of its case.

    Args:
        page: its name, such as ``evaluation``.
        folder: of the kept rows; by default that of a clone, in which this process was started.

    Returns:
        Columns as ``reports/rows/README.md`` explains them, those of :data:`.tidy.ABOUT`.

    Raises:
        RowsError: its rows are no verdicts, the file is not there, or it is damaged.

    Example:
        >>> found = sl.rows("evaluation")  # doctest: +SKIP
        >>> found.groupby("method")["cpu_total_ns"].median()  # doctest: +SKIP
    """
    (entry,) = named((page,))
    if not entry.verdicts:
        tables = [one.name for one in entries() if one.verdicts]
        raise RowsError(
            f"page {page!r} is not made of verdicts alone; allowed: {', '.join(tables)}"
        )
    file = archive_of(entry, Path(folder))
    if not file.exists():
        raise _not_there(file)
    return _table(file).to_pandas()


def unpack(entry: Entry, folder: Path = ROWS) -> Path | None:
    """Unpack the rows of a page into its work folder, unless that exists: all of them, or none.

    Returns:
        The work folder; None where it was there before, and is left as it is, and where nothing is
        packed for this page.
    """
    archive = archive_of(entry, folder)
    if entry.work.exists() or not archive.exists():
        return None
    table = _table(archive) if entry.verdicts else None
    packed = io.BytesIO(_content(archive, beside=entry.verdicts))
    entry.work.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix=f".{entry.work.name}.", dir=entry.work.parent) as fresh:
        rows = Path(fresh, "rows")
        try:
            with tarfile.open(fileobj=packed, mode="r:") as found:
                found.extractall(rows, _checked(found, archive), filter="data")
        except tarfile.TarError:
            raise _damaged(archive) from None
        if table is not None:
            _write_shards(table, rows, archive)
        stated = (_stated_in(folder / MADE_WITH) or {}).get(entry.work.name)
        if stated is not None:
            write_atomically(rows / MADE_WITH, _as_json(stated))
        rows.rename(entry.work)
    return entry.work


def unpacked_rows(page: str, work: Path) -> Path:
    """The rows of a page, unpacked into another work folder unless that has them."""
    (entry,) = named((page,))
    there = dataclasses.replace(entry, work=work / entry.work.name)
    if unpack(there) is None and not there.work.exists():
        raise _not_there(archive_of(entry, ROWS))
    return there.work


def _packed(work: Path, but: Sequence[Path]) -> bytes:
    """The files of a work folder as an archive, without those below some folders."""
    files, old, packed = sorted(work.rglob("*")), _superseded(work), io.BytesIO()
    with tarfile.open(fileobj=packed, mode="w", format=tarfile.PAX_FORMAT) as archive:
        for path in files:
            inside = path.relative_to(work)
            if _is_left_out(inside) or path in old or path.parent in but:
                continue
            if path.is_file():
                about = tarfile.TarInfo(str(inside))
                about.size = path.stat().st_size
                with regular(path, MAX_FILE_BYTES) as content:
                    archive.addfile(about, content)
    return lzma.compress(packed.getvalue(), preset=9)


def _content(file: Path, *, beside: bool) -> bytes:
    """The unpacked archive of a file, of limited size; that beside the schema of a table."""
    content = _read(file)
    try:
        if beside:
            metadata = pq.read_metadata(pa.BufferReader(content)).metadata or {}
            content = base64.b85decode(metadata[_BESIDE.encode()])
        return unpacked(content, MAX_FILE_BYTES)
    except UnpacksTooLargeError:
        raise _too_large(file) from None
    except (LookupError, OSError, ValueError, pa.ArrowException):
        raise _damaged(file) from None


def _read(file: Path) -> bytes:
    if not file.is_file():
        raise RowsError(f"{file}: is no file")
    try:
        return content_of(file, MAX_FILE_BYTES)
    except TooLargeError:
        raise _too_large(file) from None


def _table(file: Path) -> pa.Table:
    """The table of verdicts in a file."""
    content = _read(file)
    try:
        return table_of(content, schema=tidy.TABLE)
    except TableTooLargeError as error:
        raise RowsError(f"{file}: is too large: {error}") from None
    except (OSError, ValueError, pa.ArrowException):
        raise _damaged(file) from None


def _write_shards(table: pa.Table, work: Path, file: Path) -> None:
    """Write the shards of a table into run folders that the archive beside it has."""
    known = {str(run) for run in _runs(work)}
    keys = table["shard"].unique().to_pylist()
    if not known.issuperset(table["run"].unique().to_pylist()) or not all(map(_is_key, keys)):
        raise _damaged(file)
    try:
        tidy.write_shards(table, work)
    except pa.ArrowException:  # a shard has no row without what a verdict must have
        raise _damaged(file) from None


def _is_key(found: str | None) -> bool:
    return found is not None and re.fullmatch(r"[0-9a-f]+", found) is not None


def _checked(found: tarfile.TarFile, archive: Path) -> list[tarfile.TarInfo]:
    """The members of an archive, before any is written.

    Raises:
        RowsError: one is not a file below the folder, or they are too many or too large.
    """
    members, size = [], 0
    for member in found:
        path = PurePosixPath(member.name)
        below = not path.is_absolute() and ".." not in path.parts and "\\" not in member.name
        if not (member.isreg() and not member.issparse() and below):
            raise RowsError(
                f"{archive}: holds {member.name!r}; allowed: files below the work folder alone"
            )
        members.append(member)
        size += member.size
        if len(members) > _MOST_FILES or size > MAX_FILE_BYTES:
            raise RowsError(
                f"{archive}: holds too much; allowed: {_MOST_FILES} files of {MAX_FILE_BYTES} bytes"
            )
    return members


def _not_there(file: Path) -> RowsError:
    return RowsError(f"{file}: does not exist; rows come with a clone, name its reports/rows")


def _too_large(file: Path) -> RowsError:
    return RowsError(f"{file}: is too large; allowed: {MAX_FILE_BYTES} bytes, unpacked, too")


def _damaged(archive: Path) -> RowsError:
    return RowsError(f"{archive}: cannot be read, it is damaged or cut off; restore the file")


def state_made(work: Path) -> None:
    """Write beside the rows of a work folder with what they were made; see :data:`MADE_WITH`."""
    write_atomically(work / MADE_WITH, _as_json(dataclasses.asdict(MadeWith.here())))


def made_with(work: Path) -> MadeWith | None:
    """With what the rows in a work folder were made; None where that is not stated."""
    file = work / MADE_WITH
    return bind(MadeWith, _stated_in(file), str(file), RowsError) if file.exists() else None


def _stated_in(file: Path) -> Any:
    """The content of a JSON file; None where there is none."""
    if not file.exists():
        return None
    try:
        return json_of(content_of(file, MAX_STORED_BYTES))
    except (ValueError, RecursionError):
        raise _damaged(file) from None


def _as_json(content: Any) -> str:
    return json.dumps(content, indent=1) + "\n"


def kept(folder: Path = ROWS) -> str:
    """The archives in Markdown, with their sizes and the pages made of each."""
    pages: dict[Path, list[str]] = {}
    for entry in entries():
        if archive_of(entry, folder).exists():
            pages.setdefault(archive_of(entry, folder), []).append(entry.name)
    whole = sum(path.stat().st_size for path in pages)
    return "\n".join(
        [
            "# Rows behind published pages",
            "",
            f"{_megabytes(whole)} in all. `steadyload pages remake PAGE` unpacks the rows of a "
            "page into its work folder and makes the page; with `--judge` it also judges and times "
            "what is missing there. `steadyload pages keep PAGE` packs them anew.",
            "",
            "| file | size | pages |",
            "| ---- | ---: | ----- |",
            *(
                f"| `{path.name}` | {_megabytes(path.stat().st_size)} | {_links(names)} |"
                for path, names in sorted(pages.items())
            ),
            "",
            "A `.parquet` file is a table of verdicts that anything which reads Parquet reads; "
            "`steadyload.rows(PAGE)` gives it as a frame of pandas. Beside its schema, under "
            f"`{_BESIDE}`, are the other files of the work folder.",
            "",
            "| column | type | meaning |",
            "| ------ | ---- | ------- |",
            *(f"| `{name}` | {kind} | {about} |" for name, (kind, about) in tidy.ABOUT.items()),
            "",
        ]
    )


def _runs(work: Path) -> list[Path]:
    """Folders of all runs below a folder, as paths from there."""
    found = []
    for manifest in sorted(work.rglob(_MANIFEST)):
        try:
            load_manifest(manifest.parent)
        except DamagedError:
            raise
        except ResultsError:  # the manifest of something else, such as weights
            continue
        found.append(manifest.parent.relative_to(work))
    return found


def _superseded(work: Path) -> set[Path]:
    """Shards of all runs in a folder that no manifest lists."""
    return set().union(*(superseded(work / run) for run in _runs(work)))


def _is_left_out(inside: Path) -> bool:
    return any(map(partial(fnmatchcase, inside.parts[0]), _LEFT_OUT)) or _goes_on(inside)


def _goes_on(inside: Path) -> bool:
    """True for what an interrupted run continues from."""
    return any(Path(part).stem in (CHECKPOINTS, CHECKPOINT) for part in inside.parts)


def archive_of(entry: Entry, folder: Path) -> Path:
    """Where the rows of a page are packed; pages of one work folder share a file."""
    return folder / f"{entry.work.name}{'.parquet' if entry.verdicts else '.tar.xz'}"


def _megabytes(size: int) -> str:
    return f"{size / 1e6:.1f} MB"


def _links(names: Sequence[str]) -> str:
    return ", ".join(f"[{name}](../published/{name}/report.md)" for name in names)

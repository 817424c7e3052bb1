"""Rows behind published pages, packed beside them: a page is redrawn from them without judging."""

from __future__ import annotations

import dataclasses
import io
import json
import lzma
import tarfile
import tempfile
from collections.abc import Sequence
from fnmatch import fnmatchcase
from functools import partial
from pathlib import Path, PurePosixPath
from typing import Any

from steadyload.atomic import write_atomically
from steadyload.config import bind
from steadyload.errors import UserError
from steadyload.layouts.files.limits import MAX_FILE_BYTES
from steadyload.reading import (
    MAX_STORED_BYTES,
    TooLargeError,
    UnpacksTooLargeError,
    content_of,
    json_of,
    regular,
    unpacked,
)
from steadyload.runs.provenance import MadeWith
from steadyload.runs.results import superseded
from steadyload.runs.store import CHECKPOINT, CHECKPOINTS, DamagedError, ResultsError
from steadyload.studies.published import ROWS, Entry, entries

MADE_WITH = "made_with.json"
"""States with what rows were made: in a work folder of its rows, beside the archives of all rows,
by archive."""

_LEFT_OUT = (".lock", "report.md", "report.html", "report-details*.md", "figures", MADE_WITH)
"""What a work folder holds besides rows, as patterns, and :data:`.CHECKPOINTS` anywhere in it."""

_MANIFEST = "manifest.json"

_MOST_FILES = 100_000
"""Files of an archive, ten times those of the largest one; :data:`.MAX_FILE_BYTES` are those of
the archive, and also of all its files together."""


class RowsError(UserError):
    """Rows that cannot be packed, or an archive of rows that cannot be unpacked."""


def keep(entry: Entry, folder: Path = ROWS) -> Path:
    """Pack the work folder of a page; the same rows give the same bytes. Returns the archive.

    Shards that the manifest of their run does not list are left out.

    Args:
        entry: the page.
        folder: of the archives; pages that are made of one work folder share one.

    Raises:
        RowsError: the work folder does not exist.
        DamagedError: the manifest of a run in it has changed since it was written.
        TooLargeError: a file has more than :data:`.MAX_FILE_BYTES`.
        OSError: the archive cannot be written.
    """
    if not entry.work.is_dir():
        raise RowsError(
            f"the rows of page {entry.name!r} should lie in {entry.work}, which does not exist; "
            f"steadyload pages remake {entry.name} makes them"
        )
    files, old = sorted(entry.work.rglob("*")), _superseded(entry.work)
    packed = io.BytesIO()
    with tarfile.open(fileobj=packed, mode="w", format=tarfile.PAX_FORMAT) as archive:
        for path in files:
            inside = path.relative_to(entry.work)
            if _is_left_out(inside) or path in old:
                continue
            if path.is_file():
                about = tarfile.TarInfo(str(inside))
                about.size = path.stat().st_size
                with regular(path, MAX_FILE_BYTES) as content:
                    archive.addfile(about, content)
    folder.mkdir(parents=True, exist_ok=True)
    write_atomically(archive_of(entry, folder), lzma.compress(packed.getvalue(), preset=9))
    stated = _stated_in(entry.work / MADE_WITH)
    if stated is not None:
        every = {**(_stated_in(folder / MADE_WITH) or {}), entry.work.name: stated}
        write_atomically(folder / MADE_WITH, _as_json(dict(sorted(every.items()))))
    return archive_of(entry, folder)


def unpack(entry: Entry, folder: Path = ROWS) -> Path | None:
    """Unpack the rows of a page into its work folder, unless that exists: all of them, or none.

    Returns:
        The work folder; None where it was there before, and is left as it is, and where nothing is
        packed for this page.

    Raises:
        RowsError: the archive is damaged, too large, or holds more than files below the folder.
        OSError: the rows cannot be read or written.
    """
    archive = archive_of(entry, folder)
    if entry.work.exists() or not archive.exists():
        return None
    packed = io.BytesIO(_content(archive))
    entry.work.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix=f".{entry.work.name}.", dir=entry.work.parent) as fresh:
        rows = Path(fresh, "rows")
        try:
            with tarfile.open(fileobj=packed, mode="r:") as found:
                found.extractall(rows, _checked(found, archive), filter="data")
        except tarfile.TarError:
            raise _damaged(archive) from None
        stated = (_stated_in(folder / MADE_WITH) or {}).get(entry.work.name)
        if stated is not None:
            write_atomically(rows / MADE_WITH, _as_json(stated))
        rows.rename(entry.work)
    return entry.work


def _content(archive: Path) -> bytes:
    """The uncompressed content of an archive, of limited size."""
    if not archive.is_file():
        raise RowsError(f"{archive}: is no file")
    try:
        return unpacked(content_of(archive, MAX_FILE_BYTES), MAX_FILE_BYTES)
    except (TooLargeError, UnpacksTooLargeError):
        raise RowsError(
            f"{archive}: is too large; allowed: {MAX_FILE_BYTES} bytes, unpacked, too"
        ) from None
    except ValueError:
        raise _damaged(archive) from None


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


def _damaged(archive: Path) -> RowsError:
    return RowsError(f"{archive}: cannot be read, it is damaged or cut off; restore the file")


def state_made(work: Path) -> None:
    """Write beside the rows of a work folder with what they were made; see :data:`MADE_WITH`.

    Raises:
        OSError: it cannot be written.
    """
    write_atomically(work / MADE_WITH, _as_json(dataclasses.asdict(MadeWith.here())))


def made_with(work: Path) -> MadeWith | None:
    """With what the rows in a work folder were made; None where that is not stated.

    Raises:
        RowsError: what states it is damaged.
    """
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
            "| archive | size | pages |",
            "| ------- | ---: | ----- |",
            *(
                f"| `{path.name}` | {_megabytes(path.stat().st_size)} | {_links(names)} |"
                for path, names in sorted(pages.items())
            ),
            "",
        ]
    )


def _superseded(work: Path) -> set[Path]:
    """Shards of all runs in a folder that no manifest lists."""
    found: set[Path] = set()
    for manifest in work.rglob(_MANIFEST):
        try:
            found |= superseded(manifest.parent)
        except DamagedError:
            raise
        except ResultsError:  # the manifest of something else, such as weights
            continue
    return found


def _is_left_out(inside: Path) -> bool:
    return any(map(partial(fnmatchcase, inside.parts[0]), _LEFT_OUT)) or _goes_on(inside)


def _goes_on(inside: Path) -> bool:
    """True for what an interrupted run continues from."""
    return any(Path(part).stem in (CHECKPOINTS, CHECKPOINT) for part in inside.parts)


def archive_of(entry: Entry, folder: Path) -> Path:
    """Where the rows of a page are packed; pages of one work folder share an archive."""
    return folder / f"{entry.work.name}.tar.xz"


def _megabytes(size: int) -> str:
    return f"{size / 1e6:.1f} MB"


def _links(names: Sequence[str]) -> str:
    return ", ".join(f"[{name}](../published/{name}/report.md)" for name in names)

"""Rows behind published pages, packed beside them: a page is redrawn from them without judging."""

from __future__ import annotations

import io
import lzma
import tarfile
from collections.abc import Sequence
from pathlib import Path

from steadyload.atomic import write_atomically
from steadyload.errors import UserError
from steadyload.studies.published import ROWS, Entry, entries
from steadyload.studies.study import CHECKPOINT, CHECKPOINTS

_LEFT_OUT = (".lock", "report.md", "report.html", "report-details.md", "figures")
"""What a work folder holds besides rows, and :data:`.CHECKPOINTS` anywhere in it."""


class RowsError(UserError):
    """There are no rows to be packed."""


def keep(entry: Entry, folder: Path = ROWS) -> Path:
    """Pack the work folder of a page; the same rows give the same bytes. Returns the archive.

    Args:
        entry: the page.
        folder: of the archives; pages that are made of one work folder share one.

    Raises:
        RowsError: the work folder does not exist.
        OSError: the archive cannot be written.
    """
    if not entry.work.is_dir():
        raise RowsError(
            f"the rows of page {entry.name!r} should lie in {entry.work}, which does not exist; "
            f"steadyload pages remake {entry.name} makes them"
        )
    packed = io.BytesIO()
    with tarfile.open(fileobj=packed, mode="w", format=tarfile.PAX_FORMAT) as archive:
        for path in sorted(entry.work.rglob("*")):
            inside = path.relative_to(entry.work)
            if path.is_file() and inside.parts[0] not in _LEFT_OUT and not _goes_on(inside):
                about = tarfile.TarInfo(str(inside))
                about.size = path.stat().st_size
                with path.open("rb") as content:
                    archive.addfile(about, content)
    folder.mkdir(parents=True, exist_ok=True)
    write_atomically(_archive(entry, folder), lzma.compress(packed.getvalue(), preset=9))
    return _archive(entry, folder)


def unpack(entry: Entry, folder: Path = ROWS) -> Path | None:
    """Unpack the rows of a page into its work folder, unless that exists.

    Returns:
        The work folder; None where it was there before, and is left as it is, and where nothing is
        packed for this page.

    Raises:
        OSError: the rows cannot be read or written.
    """
    archive = _archive(entry, folder)
    if entry.work.exists() or not archive.exists():
        return None
    with tarfile.open(archive, "r:xz") as rows:
        rows.extractall(entry.work, filter="data")
    return entry.work


def kept(folder: Path = ROWS) -> str:
    """The archives in Markdown, with their sizes and the pages made of each."""
    pages: dict[Path, list[str]] = {}
    for entry in entries():
        if _archive(entry, folder).exists():
            pages.setdefault(_archive(entry, folder), []).append(entry.name)
    whole = sum(path.stat().st_size for path in pages)
    return "\n".join(
        [
            "# Rows behind published pages",
            "",
            f"{_megabytes(whole)} in all. `steadyload pages remake PAGE` unpacks the rows of a "
            "page into its work folder, judges what is missing there, and makes the page. "
            "`steadyload pages keep PAGE` packs them anew.",
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


def _goes_on(inside: Path) -> bool:
    """True for what an interrupted run continues from."""
    return any(Path(part).stem in (CHECKPOINTS, CHECKPOINT) for part in inside.parts)


def _archive(entry: Entry, folder: Path) -> Path:
    return folder / f"{entry.work.name}.tar.xz"


def _megabytes(size: int) -> str:
    return f"{size / 1e6:.1f} MB"


def _links(names: Sequence[str]) -> str:
    return ", ".join(f"[{name}](../published/{name}/report.md)" for name in names)

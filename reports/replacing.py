"""Sets of files that are replaced together: an interruption leaves the old set or the new one."""

from __future__ import annotations

import json
import shutil
from collections.abc import Collection
from pathlib import Path

from steadyload.errors import UserError

_JOURNAL = "journal.json"
"""File of an undo folder that says it is complete, and which files are not to be there."""


def replace_together(
    directory: Path, fresh: Path, files: Collection[str], before: Collection[str], undo: Path
) -> None:
    """Move new files into place, and remove those of the set before that the new one has not.

    Whatever is about to change is copied first. An exception puts it back; after the end of the
    process, :func:`put_back` does.

    Args:
        directory: where the files belong.
        fresh: a folder beside them, on the same disk, with the new files under their names.
        files: names of the new files, relative to the folder.
        before: names of the files of the set that is replaced; there may be fewer.
        undo: the folder of the copies; it is there only while files are moved.
    """
    put_back(directory, undo)
    copies = fresh / undo.name
    changing = {file for file in {*files, *before} if (directory / file).exists()}
    for file in changing:
        (copies / file).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(directory / file, copies / file)
    copies.mkdir(exist_ok=True)
    (copies / _JOURNAL).write_text(json.dumps(sorted({*files} - changing)))
    copies.rename(undo)
    try:
        for file in files:
            (directory / file).parent.mkdir(exist_ok=True)
            (fresh / file).replace(directory / file)
        for file in {*before} - {*files}:
            (directory / file).unlink(missing_ok=True)
        (undo / _JOURNAL).unlink()
    except BaseException:
        put_back(directory, undo)
        raise
    shutil.rmtree(undo, ignore_errors=True)


def put_back(directory: Path, undo: Path) -> None:
    """Put a set back whose replacement was begun and not finished; else change nothing."""
    journal = undo / _JOURNAL
    if journal.exists():
        for file in _absent(journal):
            (directory / file).unlink(missing_ok=True)
        for copy in undo.rglob("*"):
            if copy.is_file() and copy != journal:
                copy.replace(directory / copy.relative_to(undo))
        journal.unlink()
    shutil.rmtree(undo, ignore_errors=True)


def _absent(journal: Path) -> list[str]:
    """Files of a journal, relative to the folder."""
    try:
        files = json.loads(journal.read_bytes())
        if not isinstance(files, list) or not all(map(_lies_within, files)):
            raise ValueError
    except (ValueError, RecursionError):
        raise UserError(
            f"{journal}: is damaged; copy what lies beside it to {journal.parent.parent}, then "
            "remove its folder"
        ) from None
    return files


def _lies_within(file: object) -> bool:
    return isinstance(file, str) and not Path(file).is_absolute() and ".." not in Path(file).parts

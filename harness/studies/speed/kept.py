"""The last run of the benchmark, kept beside its page."""

from __future__ import annotations

from pathlib import Path

from steadyload.atomic import clear_unfinished, manifest_text, write_atomically
from steadyload.stored import StoredFileError, stored_object
from steadyload.studies.speed.records import SpeedRun

FILE = "times.json"
"""Name of the file in the folder of the page."""

_REMEDY = "remove it, and measure anew"


def last_run(folder: Path) -> SpeedRun | None:
    """The run that is kept in a folder; None where there is none.

    Raises:
        StoredFileError: the file is damaged.
        OSError: it cannot be read.
    """
    path = folder / FILE
    if not path.exists():
        return None
    try:
        return SpeedRun.from_json(stored_object(path, _REMEDY))
    except (LookupError, TypeError, ValueError):
        raise StoredFileError(path, _REMEDY) from None


def keep(run: SpeedRun, folder: Path) -> Path:
    """Keep a run in a folder, in the place of the one before; the path of the file."""
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / FILE
    clear_unfinished(folder, FILE)
    write_atomically(path, manifest_text(run.to_json()))
    return path

"""History of the benchmark: runs kept beside the page, and those from before it kept any."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from steadyload.atomic import clear_unfinished
from steadyload.reading import own_file
from steadyload.stored import REMEDY, StoredFileError, store_list, stored_list
from steadyload.studies.speed.records import EarlierRun, SpeedRun

FILE = "history.json"
"""Name of the history in the folder of the page."""

FORMER = own_file("steadyload.studies.speed", "former.json")
"""Figures of versions that are no longer there, measured on the same layouts."""

_RUNS = "runs"
_REMEDY = "restore it, or remove it to begin a new history"


def former_runs() -> list[EarlierRun]:
    """The runs that come with the package."""
    return _earlier(stored_list(FORMER, _RUNS, REMEDY), FORMER, REMEDY)


def earlier_runs(folder: Path) -> list[EarlierRun]:
    """The runs in the history of a folder, in order; none where there is no history.

    Raises:
        StoredFileError: the history is damaged.
        OSError: it cannot be read.
    """
    return _earlier(stored_list(folder / FILE, _RUNS, _REMEDY), folder / FILE, _REMEDY)


def last_run(folder: Path) -> tuple[SpeedRun, list[EarlierRun]] | None:
    """The last run in the history of a folder and those before it.

    None where there is no run, or the last one was kept before runs told what they were made with.

    Raises:
        StoredFileError: the history is damaged.
        OSError: it cannot be read.
    """
    path = folder / FILE
    entries = stored_list(path, _RUNS, _REMEDY)
    if not entries or "made_with" not in entries[-1]:
        return None
    try:
        return SpeedRun.from_json(entries[-1]), _earlier(entries[:-1], path, _REMEDY)
    except (LookupError, TypeError, ValueError):
        raise StoredFileError(path, _REMEDY) from None


def keep(run: SpeedRun, folder: Path) -> Path:
    """Add a run to the history of a folder; the path of the history."""
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / FILE
    clear_unfinished(folder, FILE)
    store_list(path, _RUNS, [*stored_list(path, _RUNS, _REMEDY), run.to_json()])
    return path


def _earlier(entries: list[Any], path: Path, remedy: str) -> list[EarlierRun]:
    try:
        return [EarlierRun.from_json(entry) for entry in entries]
    except (LookupError, TypeError, ValueError, OverflowError):
        raise StoredFileError(path, remedy) from None

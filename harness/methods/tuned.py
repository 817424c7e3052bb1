"""Parameters that searches found, with their provenance: ``tuned.json``.

``{name: {engine: {"parameters": ..., "made_by": ...}}}``; for another question than that of the
label the name is ``PRESET:question=...``. Searches write it
(``steadyload tune --write-preset``); nobody edits it.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

from steadyload.atomic import write_atomically
from steadyload.engines.registry import engines_here
from steadyload.layouts.model.question import Question, with_question
from steadyload.reading import own_file
from steadyload.stored import REMEDY, StoredFileError, stored_object

TUNED, EQUAL = "ps_opt", "ps_opt-equal"
"""Names of the tuned presets: the best that is known on every engine, and what searches found that
differ in their engine alone, for comparisons of engines. Both exist before anything was tuned, and
then on no engine."""


class About(NamedTuple):
    """A tuned preset: its title, where it comes from, and how far ``tune`` searches for it."""

    title: str
    source: str
    search: str


ABOUT: Mapping[str, About] = {
    TUNED: About("PS_opt", "searches on labelled layouts, an engine each", "--budget 20m"),
    EQUAL: About(
        "PS_opt, equal searches", "searches that differ in their engine alone",
        "--population 24 --generations 5",
    ),
}  # fmt: skip
"""The tuned presets by name."""

FILE = own_file("steadyload.methods", "tuned.json")
"""Where searches write to, and presets are read from."""


@dataclass(frozen=True, slots=True)
class Tuned:
    """Parameters that a search found on one engine.

    Attributes:
        parameters: of a simulation on that engine.
        made_by: everything that is needed to find them again, and their evaluation.
    """

    parameters: Mapping[str, Any]
    made_by: Mapping[str, Any]


def tuned_name(question: str, preset: str = TUNED) -> str:
    """Name of a tuned preset's entry for a question: that of the label has the plain name."""
    return with_question(preset, question)


def tuned() -> Mapping[str, Mapping[str, Tuned]]:
    """Tuned parameters, by name of the preset and by engine.

    Raises:
        StoredFileError: the file is damaged.
    """
    return _read(FILE)


def tuned_engines() -> tuple[str, ...]:
    """The engines that studies compare and that have tuned parameters for every question.

    Raises:
        StoredFileError: see :func:`tuned`.
    """
    found = [tuned().get(tuned_name(question), {}) for question in Question]
    return tuple(name for name in engines_here() if all(name in own for own in found))


@cache
def _read(file: Path) -> Mapping[str, Mapping[str, Tuned]]:
    return {name: {} for name in ABOUT} | {
        name: {engine: Tuned(**entry) for engine, entry in engines.items()}
        for name, engines in _entries(file).items()
    }


def _entries(file: Path) -> dict[str, dict[str, dict[str, Any]]]:
    found = stored_object(file, REMEDY) if file.exists() else {}
    for engines in found.values():
        if not isinstance(engines, dict) or not all(map(_is_entry, engines.values())):
            raise StoredFileError(file, REMEDY)
    return found


def _is_entry(entry: Any) -> bool:
    return (
        isinstance(entry, dict)
        and entry.keys() == {"parameters", "made_by"}
        and all(isinstance(part, dict) for part in entry.values())
    )


def write_tuned(name: str, engine: str, found: Tuned) -> Path:
    """Replace the tuned parameters of an engine by newly found ones; returns :data:`FILE`."""
    entries = _entries(FILE)
    entry = {"parameters": dict(found.parameters), "made_by": dict(found.made_by)}
    entries.setdefault(name, {})[engine] = entry
    ordered = {n: dict(sorted(engines.items())) for n, engines in sorted(entries.items())}
    write_atomically(FILE, json.dumps(ordered, indent=1) + "\n")
    _read.cache_clear()
    return FILE

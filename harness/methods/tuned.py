"""Parameters that searches found, with their provenance: ``tuned.json``.

A list of records: ``preset``, ``question``, ``engine``, ``parameters``, ``made_by``. Searches write
it (``steadyload tune --write-preset``); nobody edits it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

from steadyload.engines.registry import engines_here
from steadyload.layouts.model.question import Question, question_named
from steadyload.reading import own_file
from steadyload.stored import REMEDY, StoredFileError, store_list, stored_list

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


def tuned(question: str = Question.WITHIN, preset: str = TUNED) -> Mapping[str, Tuned]:
    """The tuned parameters of a preset for a question, by engine.

    Raises:
        QuestionError: no such question.
        StoredFileError: the file is damaged.
    """
    return _read(FILE).get((preset, question_named(question)), {})


def tuned_engines() -> tuple[str, ...]:
    """The engines that studies compare and that have tuned parameters for every question.

    Raises:
        StoredFileError: see :func:`tuned`.
    """
    found = [tuned(question) for question in Question]
    return tuple(name for name in engines_here() if all(name in own for own in found))


@cache
def _read(file: Path) -> Mapping[tuple[str, str], Mapping[str, Tuned]]:
    """Tuned parameters by preset and question, then by engine."""
    found: dict[tuple[str, str], dict[str, Tuned]] = {}
    for record in _records(file):
        own = found.setdefault((record["preset"], record["question"]), {})
        own[record["engine"]] = Tuned(record["parameters"], record["made_by"])
    return found


_NAMES, _VALUES = ("preset", "question", "engine"), ("parameters", "made_by")
"""Keys of a record that hold texts, and that hold objects."""


def _records(file: Path) -> list[dict[str, Any]]:
    found = stored_list(file, "tuned", REMEDY)
    for record in found:
        named = all(isinstance(record.get(key), str) for key in _NAMES)
        if not named or not all(isinstance(record.get(key), dict) for key in _VALUES):
            raise StoredFileError(file, REMEDY)
    return found


def write_tuned(question: str, engine: str, found: Tuned, preset: str = TUNED) -> Path:
    """Replace the tuned parameters on an engine by newly found ones; returns :data:`FILE`."""
    names = (preset, str(question_named(question)), engine)
    values = (dict(found.parameters), dict(found.made_by))
    records = {tuple(map(record.get, _NAMES)): record for record in _records(FILE)}
    records[names] = dict(zip((*_NAMES, *_VALUES), (*names, *values), strict=True))
    store_list(FILE, "tuned", [records[names] for names in sorted(records)])
    _read.cache_clear()
    return FILE

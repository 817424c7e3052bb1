"""Accept and reject thresholds of cascades: ``cascades.json``, written by a command, never by hand.

``{engine: {"default": budget, "budgets": {budget: {"stages": ..., "last": ..., "found": ...}},
"made_of": ..., "made_by": ...}}``; for another question than that of the label the key is
``ENGINE:question=...``. ``steadyload cascade fit`` writes it.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from steadyload.atomic import (
    ChecksumError,
    manifest_text,
    verified_manifest,
    write_atomically,
)
from steadyload.config import bind
from steadyload.escaping import printable
from steadyload.layouts.model.question import Question, with_question
from steadyload.methods.contract.method import Method
from steadyload.methods.contract.spec import SpecError, stored_values
from steadyload.reading import MAX_STORED_BYTES, content_of, json_of, own_file

FILE = own_file("steadyload.methods", "cascades.json")
"""The thresholds that come with the package."""

_LONGEST = 200
"""Characters of names from a file in a message."""


class ThresholdsError(SpecError):
    """No thresholds for what is requested, or ones fitted with other methods than there are now."""


@dataclass(frozen=True, slots=True)
class Stage:
    """A method with accept and reject thresholds: it decides the steps whose score is beyond one.

    Attributes:
        method: its spec.
        low: accept threshold: a step with a lower score is stable; None: it accepts no step.
        high: reject threshold: a step with a higher score is unstable; None: it rejects no step.
        items: it scores the steps alone at which so many items lie at most, the new one among them;
            None: it scores every step.
    """

    method: str
    low: float | None
    high: float | None
    items: int | None = None

    def __str__(self) -> str:
        """The method, and the number of items up to which it scores steps."""
        return self.method if self.items is None else f"{self.method} to {self.items} items"

    def scores(self, step: int) -> bool:
        """Whether the stage scores a step, which is counted from 0."""
        return self.items is None or step < self.items

    def unstable(self, score: float) -> bool | None:
        """Decision on a step by its step score; None where it is left to the next stage."""
        if self.low is not None and score < self.low:
            return False
        if self.high is not None and score > self.high:
            return True
        return None


@dataclass(frozen=True, slots=True)
class Ladder:
    """Stages of a cascade, in order.

    Attributes:
        stages: that decide the steps beyond their thresholds.
        last: spec of the method that decides the rest.
        found: evaluation on the cases it was fitted on, for people.
    """

    stages: tuple[Stage, ...]
    last: str
    found: Mapping[str, Any]

    @property
    def methods(self) -> tuple[str, ...]:
        """Specs of the methods of all stages."""
        return (*(stage.method for stage in self.stages), self.last)

    def stored(self) -> dict[str, Any]:
        """The ladder as it is stored: without ``items`` of a stage that scores every step."""
        stored = asdict(self)
        stored["stages"] = [
            {key: value for key, value in stage.items() if (key, value) != ("items", None)}
            for stage in stored["stages"]
        ]
        return stored


@dataclass(frozen=True, slots=True)
class Thresholds:
    """Thresholds that were fitted for one engine.

    Attributes:
        default: the budget that is used if none is given [points of accuracy].
        ladders: by budget.
        made_of: by spec of every method, its :func:`fingerprint` when thresholds were fitted.
        made_by: everything that is needed to fit them again.
    """

    default: float
    ladders: Mapping[float, Ladder]
    made_of: Mapping[str, str]
    made_by: Mapping[str, Any]


def fingerprint(method: Method) -> str:
    """Hash of everything that determines a method's scores: its parameters, and trained weights."""
    values = json.dumps(stored_values(method.parameters), sort_keys=True)
    return hashlib.sha256(f"{values} {method.trained}".encode()).hexdigest()[:16]


def load_thresholds(
    engine: str, file: Path = FILE, question: Question = Question.WITHIN
) -> Thresholds:
    """Thresholds that were fitted for an engine and a question.

    Raises:
        ThresholdsError: nothing was, there is no such file, or it is none of thresholds.
    """
    if not file.is_file():
        raise ThresholdsError(
            f"{file}: no such file of thresholds; to make it run {fit_command(engine, question)} "
            f"-o {file}"
        )
    entries, key = _read(file), with_question(engine, question)
    if key not in entries:
        known = printable(", ".join(entries), _LONGEST) or "no engine yet"
        fitted = f"thresholds were fitted for {known}"
        raise ThresholdsError(
            f"cascade@{key}: {fitted}; to fit them run {fit_command(engine, question)}"
        )
    try:
        return _thresholds(entries[key])
    except (KeyError, TypeError, ValueError, AttributeError):
        raise ThresholdsError(f"{file}: holds no thresholds for {key}") from None


def fitted_for(file: Path = FILE) -> frozenset[str]:
    """Engines that a file has thresholds for; for another question than that of the label
    ``ENGINE:question=...``.

    Raises:
        ThresholdsError: it is no file of thresholds, or damaged.
    """
    return frozenset(_read(file))


def fit_command(engine: str, question: Question) -> str:
    """The command that fits thresholds."""
    more = "" if question is Question.WITHIN else f" --question {question}"
    return f"steadyload cascade fit --engine {engine}{more}"


def write_thresholds(
    engine: str, fitted: Thresholds, file: Path = FILE, question: Question = Question.WITHIN
) -> Path:
    """Replace the thresholds of an engine and question by newly fitted ones; returns the file."""
    entries = _read(file)
    entries[with_question(engine, question)] = {
        "default": fitted.default,
        "budgets": {f"{budget:g}": ladder.stored() for budget, ladder in fitted.ladders.items()},
        "made_of": dict(fitted.made_of),
        "made_by": dict(fitted.made_by),
    }
    write_atomically(file, manifest_text(dict(sorted(entries.items()))))
    return file


def _read(file: Path) -> dict[str, Any]:
    if not file.exists():
        return {}
    content = content_of(file, MAX_STORED_BYTES)
    try:
        entries = json_of(content)
    except (ValueError, RecursionError):
        entries = None
    if not isinstance(entries, dict):
        raise ThresholdsError(f"{file}: is no file of thresholds")
    try:
        return verified_manifest(entries)
    except ChecksumError:
        raise ThresholdsError(f"{file}: is damaged; remove it to fit anew") from None


def _thresholds(entry: Mapping[str, Any]) -> Thresholds:
    stated = dict(entry)
    stated["ladders"] = {float(key): ladder for key, ladder in stated.pop("budgets").items()}
    found = bind(Thresholds, stated, "thresholds")
    if found.default not in found.ladders:
        raise ValueError(found.default)
    return found

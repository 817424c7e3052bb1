"""Accept and reject thresholds of cascades: ``cascades.json``, written by a command, never by hand.

A list of records: ``engine``, ``question``, ``default`` budget, ``budgets``, which has ``stages``,
``last`` and ``found`` by budget, ``made_of`` and ``made_by``. A stage is
``{"method": ..., "low": ..., "high": ...}``; it has ``"items": 60`` where it scores the steps of
few items alone, and ``"larger": [{"above": 40, "low": ..., "high": ...}, ...]`` where thresholds
depend on the number of items. ``steadyload cascade fit`` writes it.
"""

from __future__ import annotations

import hashlib
import itertools
import json
from bisect import bisect_right
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from steadyload.config import bind
from steadyload.escaping import printable
from steadyload.layouts.model.question import Question, question_named, with_question
from steadyload.methods.contract.method import Method
from steadyload.methods.contract.spec import SpecError, stored_values
from steadyload.reading import own_file
from steadyload.stored import StoredFileError, store_list, stored_list

FILE = own_file("steadyload.methods", "cascades.json")
"""The thresholds that come with the package."""

_NAMES = ("engine", "question")
"""Keys of a record that name what its thresholds are for."""

_REMEDY = "remove it to fit anew"

_LONGEST = 200
"""Characters of names from a file in a message."""

_UNSTATED = (("items", None), ("larger", ()))
"""Values of fields that a stage leaves out where it is stored."""


class ThresholdsError(SpecError):
    """No thresholds for what is requested, or ones fitted with other methods than there are now."""


@dataclass(frozen=True, slots=True)
class Larger:
    """Thresholds of a stage for the steps at which more items lie than a given number.

    Attributes:
        above: that number; the new item is among those that lie.
        low, high: as of a :class:`Stage`; None for both: these steps are not scored.
    """

    above: int
    low: float | None
    high: float | None


@dataclass(frozen=True, slots=True)
class Stage:
    """A method with accept and reject thresholds: it decides the steps whose score is beyond one.

    Attributes:
        method: its spec.
        low: accept threshold: a step with a lower score is stable; None: it accepts no step.
        high: reject threshold: a step with a higher score is unstable; None: it rejects no step.
        items: it scores the steps alone at which so many items lie at most, the new one among them;
            None: it scores every step.
        larger: other thresholds for the steps of larger loads, each up to the next one, by
            ascending numbers of items.

    Raises:
        ValueError: numbers of items do not ascend from 1, up to ``items``.
    """

    method: str
    low: float | None
    high: float | None
    items: int | None = None
    larger: tuple[Larger, ...] = ()

    def __post_init__(self) -> None:
        numbers = [0, *(each.above for each in self.larger)]
        if self.larger and self.items is not None:
            numbers.append(self.items)
        if any(later <= earlier for earlier, later in itertools.pairwise(numbers)):
            raise ValueError(f"numbers of items of {self.method}: {numbers[1:]} do not ascend")

    def __str__(self) -> str:
        """The method, the numbers of items of the steps that it scores, and where thresholds
        change.
        """
        scored = [each for each in self.ranges if (each.low, each.high) != (None, None)]
        first = scored[0].above if scored else 0
        name = f"{self.method}{_between(first, self.items)}"
        changes = [str(each.above) for each in self.larger if each.above > first]
        if not changes:
            return name
        return f"{name} (other thresholds above {' and '.join(changes)} items)"

    @property
    def ranges(self) -> tuple[Larger, ...]:
        """The thresholds of every range of numbers of items, the first one from 1 item on."""
        return (Larger(0, self.low, self.high), *self.larger)

    def at(self, step: int) -> Larger:
        """Those of :attr:`ranges` that hold at a step, which is counted from 0."""
        number = bisect_right(self.larger, step, key=lambda each: each.above)
        return self.larger[number - 1] if number else Larger(0, self.low, self.high)

    def scores(self, step: int) -> bool:
        """Whether the stage scores a step, which is counted from 0: it may decide it."""
        if self.items is not None and step >= self.items:
            return False
        own = self.at(step)
        return own.low is not None or own.high is not None

    def unstable(self, step: int, score: float) -> bool | None:
        """Decision on a step by its step score; None where it is left to the next stage."""
        if self.scores(step):
            own = self.at(step)
            if own.low is not None and score < own.low:
                return False
            if own.high is not None and score > own.high:
                return True
        return None


def _between(above: int, items: int | None) -> str:
    """The steps between two numbers of items, in words; none for all steps."""
    if above == 0:
        return "" if items is None else f" to {items} items"
    return f" above {above} items" if items is None else f" from {above + 1} to {items} items"


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
        """The ladder as it is stored: ``items`` and ``larger`` of a stage only where it has any."""
        stored = asdict(self)
        stored["stages"] = [
            {key: value for key, value in stage.items() if (key, value) not in _UNSTATED}
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
        StoredFileError: the file is damaged.
    """
    question = question_named(question)
    if not file.is_file():
        raise ThresholdsError(
            f"{file}: no such file of thresholds; to make it run {fit_command(engine, question)} "
            f"-o {file}"
        )
    key, records = with_question(engine, question), _records(file)
    if (engine, question) not in records:
        known = printable(", ".join(with_question(*names) for names in records), _LONGEST)
        raise ThresholdsError(
            f"cascade@{key}: thresholds were fitted for {known or 'no engine yet'}; to fit them "
            f"run {fit_command(engine, question)}"
        )
    try:
        return _thresholds(records[engine, question])
    except (KeyError, TypeError, ValueError, AttributeError):
        raise ThresholdsError(f"{file}: holds no thresholds for {key}") from None


def fitted_for(file: Path = FILE) -> frozenset[tuple[str, str]]:
    """Engines and questions that a file has thresholds for.

    Raises:
        StoredFileError: it is damaged.
    """
    return frozenset(_records(file))


def fit_command(engine: str, question: Question) -> str:
    """The command that fits thresholds."""
    more = "" if question == Question.WITHIN else f" --question {question}"
    return f"steadyload cascade fit --engine {engine}{more}"


def write_thresholds(
    engine: str, fitted: Thresholds, file: Path = FILE, question: Question = Question.WITHIN
) -> Path:
    """Replace the thresholds of an engine and question by newly fitted ones; returns the file."""
    records = _records(file)
    records[engine, str(question)] = {
        "engine": engine,
        "question": str(question),
        "default": fitted.default,
        "budgets": {f"{budget:g}": ladder.stored() for budget, ladder in fitted.ladders.items()},
        "made_of": dict(fitted.made_of),
        "made_by": dict(fitted.made_by),
    }
    store_list(file, "fitted", [records[names] for names in sorted(records)])
    return file


def _records(file: Path) -> dict[tuple[str, str], dict[str, Any]]:
    """The records of a file, by engine and question; none where there is no such file."""
    found = stored_list(file, "fitted", _REMEDY)
    if not all(isinstance(record.get(key), str) for record in found for key in _NAMES):
        raise StoredFileError(file, _REMEDY)
    return {(record["engine"], record["question"]): record for record in found}


def _thresholds(record: Mapping[str, Any]) -> Thresholds:
    stated = {key: value for key, value in record.items() if key not in _NAMES}
    stated["ladders"] = {float(key): ladder for key, ladder in stated.pop("budgets").items()}
    found = bind(Thresholds, stated, "thresholds")
    if found.default not in found.ladders:
        raise ValueError(found.default)
    return found

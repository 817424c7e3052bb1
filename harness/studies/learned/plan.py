"""What a study of learners trains and compares."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any

from steadyload.layouts.benchmark import Part
from steadyload.learners.generation import GenerationOptions
from steadyload.learners.jobs import BENCHMARK


class Section(StrEnum):
    """A part of the study; each is a table of the plan's file."""

    TABLE = "table"
    SIZE = "size"
    SOURCES = "sources"
    REMEDIES = "remedies"
    CALIBRATION = "calibration"
    LEAK = "leak"
    FOREIGN = "foreign"


@dataclass(frozen=True)
class PlannedTraining:
    """A training under a name; it is made once for every seed.

    Attributes:
        title: for people.
        preset: what the options start from, see :mod:`steadyload.learners.options`.
        options: changed ones; no seed.
        data: names of the plan's sets, and ``benchmark``.
        seeds: one training each.
        members, left_out, limit, lists, leaky: see :class:`steadyload.learners.jobs.TrainingJob`.
        start: name of the training that is trained on, seed by seed.
        budget: wall seconds over all members. Without one what is trained hangs on nothing but
            the plan.
    """

    name: str
    title: str
    preset: str = "quick"
    options: Mapping[str, Any] = field(default_factory=dict)
    data: tuple[str, ...] = (BENCHMARK,)
    seeds: tuple[int, ...] = (0,)
    members: int = 1
    left_out: float = 0.0
    limit: int | None = None
    lists: int | None = None
    start: str = ""
    leaky: bool = False
    budget: float = 86400.0


@dataclass(frozen=True)
class TablePlan:
    """Learners beside other methods.

    Attributes:
        methods: spec strings.
        trainings: names; the weights of the first seed judge, too.
        held: the spec, or name of a training, that all others are held against.
        timed: cases of the part that are timed, in turns with all methods.
        repeats: how often.
        batches: sizes that are tried where a method judges many at once.
    """

    methods: tuple[str, ...]
    trainings: tuple[str, ...] = ()
    held: str = "lstm_e"
    timed: int = 300
    repeats: int = 5
    batches: tuple[int, ...] = (8, 32, 64, 128, 256, 512)


@dataclass(frozen=True)
class Curve:
    """Trainings that differ in the size of their training set."""

    title: str
    trainings: tuple[str, ...]


@dataclass(frozen=True)
class Contrast:
    """A training, and others that are held against it."""

    baseline: str
    trainings: tuple[str, ...]


@dataclass(frozen=True)
class CalibrationPlan:
    """Whose probabilities are looked at: names of weights that are shipped, or of trainings."""

    judges: tuple[str, ...]


@dataclass(frozen=True)
class ForeignPlan:
    """Layouts of another kind.

    Attributes:
        judges: learned methods, spec strings.
        others: methods whose verdicts are compared with theirs.
        max_items: so many first items of a layout are judged.
    """

    judges: tuple[str, ...]
    others: tuple[str, ...]
    max_items: int = 20


@dataclass(frozen=True)
class Plan:
    """A study of learners; a section that is not planned is None or empty.

    Attributes:
        part: of the labelled set, on which all are judged.
        sets: to generate, by name.
        trainings: by name.
    """

    part: Part
    sets: Mapping[str, GenerationOptions]
    trainings: Mapping[str, PlannedTraining]
    table: TablePlan | None = None
    size: tuple[Curve, ...] = ()
    sources: Contrast | None = None
    remedies: Contrast | None = None
    calibration: CalibrationPlan | None = None
    leak: tuple[Contrast, ...] = ()
    foreign: ForeignPlan | None = None

    def sections(self) -> list[Section]:
        """Those that are planned."""
        return [section for section in Section if getattr(self, section)]

    def needed(self, sections: Collection[Section]) -> list[PlannedTraining]:
        """The trainings of some sections, each after the one that it starts from."""
        found: dict[str, PlannedTraining] = {}
        for name in self.named(sections):
            chain = [name]
            while self.trainings[chain[-1]].start:
                chain.append(self.trainings[chain[-1]].start)
            found |= {each: self.trainings[each] for each in reversed(chain) if each not in found}
        return list(found.values())

    def named(self, sections: Collection[Section]) -> Iterable[str]:
        """Names of trainings that sections ask for."""
        for section in sections:
            for what in _as_tuple(getattr(self, section)):
                names = (
                    getattr(what, "baseline", ""),
                    *getattr(what, "trainings", ()),
                    *(n for n in getattr(what, "judges", ()) if n in self.trainings),
                )
                yield from filter(None, names)


def _as_tuple(value: Any) -> tuple[Any, ...]:
    if value is None:
        return ()
    return value if isinstance(value, tuple) else (value,)

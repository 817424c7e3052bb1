"""Plan of a study of learners: its trainings and comparisons."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any

from steadyload.config import option
from steadyload.layouts.benchmark.parts import UNLEARNT, Part
from steadyload.learners import LearnerError
from steadyload.learners.generation import GenerationOptions
from steadyload.learners.options import options_from, training_preset
from steadyload.learners.sequences import BENCHMARK


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
        preset: the options that are changed, see :mod:`steadyload.learners.options`.
        options: changed options, without the seed.
        data: names of the plan's sets, and ``benchmark``.
        members, left_out, limit, lists, leaky: see :class:`steadyload.learners.jobs.TrainingJob`.
        start: name of the training that is continued, seed by seed.
        budget: over all members. Without a budget the weights depend on the plan alone.
    """

    name: str
    title: str
    preset: str = "quick"
    options: Mapping[str, Any] = field(default_factory=dict)
    data: tuple[str, ...] = (BENCHMARK,)
    seeds: tuple[int, ...] = option((0,), "one training each", least=0, fewest=1)
    members: int = option(1, "networks", least=0)
    left_out: float = option(0.0, "share of item lists", least=0)
    limit: int | None = option(None, "cases a scenario", least=0)
    lists: int | None = option(None, "item lists", least=0)
    start: str = ""
    leaky: bool = False
    budget: float = option(86400.0, "of wall time", unit="s", least=0)

    def of_job(self) -> dict[str, Any]:
        """The arguments of a :class:`steadyload.learners.jobs.TrainingJob` that it states."""
        names = ("members", "left_out", "budget", "limit", "lists", "leaky")
        return {name: getattr(self, name) for name in names}

    def __post_init__(self) -> None:
        training_preset(self.preset)
        options_from(self.options, where="options")
        if "seed" in self.options or len(set(self.seeds)) < len(self.seeds):
            raise LearnerError("seeds are a list of their own; allowed: each of them once")


@dataclass(frozen=True)
class TablePlan:
    """Learners beside other methods.

    Attributes:
        methods: spec strings.
        trainings: names; the weights of the first seed are a method, too.
        held: the spec, or name of a training, that all others are compared with.
        batches: for methods that judge many layouts at once.
    """

    methods: tuple[str, ...]
    trainings: tuple[str, ...] = ()
    held: str = "lstm_e"
    limit: int | None = option(None, "cases a scenario", least=1)
    timed: int = option(300, "cases of these that are timed", least=0)
    repeats: int = option(5, "of the timing", least=0)
    batches: tuple[int, ...] = option((8, 32, 64, 128, 256, 512), "batch sizes", least=0)


@dataclass(frozen=True)
class Curve:
    """Trainings that differ in the size of their training set."""

    title: str
    trainings: tuple[str, ...]


@dataclass(frozen=True)
class Contrast:
    """A training, and others that are compared with it."""

    baseline: str
    trainings: tuple[str, ...]


@dataclass(frozen=True)
class CalibrationPlan:
    """Methods whose calibration is measured: names of shipped weights, or of trainings."""

    judges: tuple[str, ...]


@dataclass(frozen=True)
class ForeignPlan:
    """Layouts of another kind.

    Attributes:
        judges: learned methods, spec strings.
        others: methods whose verdicts are compared with theirs.
    """

    judges: tuple[str, ...]
    others: tuple[str, ...]
    max_items: int = option(20, "first items of a layout that are judged", least=0)


@dataclass(frozen=True)
class Plan:
    """A study of learners; a section that is not planned is None or empty.

    Attributes:
        part: of the labelled set, on which all methods are evaluated.
        directory: word or folder of that set; None for the large set of the package. A leak is
            measured on the large set, from whose held-out item lists leaky trainings learn.
        sets: sets to generate, by name.
        trainings: by name.
    """

    part: Part = option(Part.TEST, "of the labelled set", choices=UNLEARNT)
    directory: str | None = None
    sets: Mapping[str, GenerationOptions] = field(default_factory=dict)
    trainings: Mapping[str, PlannedTraining] = field(default_factory=dict)
    table: TablePlan | None = None
    size: tuple[Curve, ...] = ()
    sources: Contrast | None = None
    remedies: Contrast | None = None
    calibration: CalibrationPlan | None = None
    leak: tuple[Contrast, ...] = ()
    foreign: ForeignPlan | None = None

    def sections(self) -> list[Section]:
        """The planned sections."""
        return [section for section in Section if getattr(self, section)]

    def needed(self, sections: Collection[Section]) -> list[PlannedTraining]:
        """The trainings of some sections, each after the one that it continues."""
        found: dict[str, PlannedTraining] = {}
        for name in self.named(sections):
            chain = [name]
            while self.trainings[chain[-1]].start:
                chain.append(self.trainings[chain[-1]].start)
            found |= {each: self.trainings[each] for each in reversed(chain) if each not in found}
        return list(found.values())

    def named(self, sections: Collection[Section]) -> Iterable[str]:
        """Names of the trainings of some sections."""
        for what in self._planned(sections):
            yield from filter(None, [getattr(what, "baseline", "")])
            yield from getattr(what, "trainings", ())
            yield from (name for name in getattr(what, "judges", ()) if name in self.trainings)

    def judging(self) -> set[str]:
        """Names of the trainings whose first seed is a method of the study."""
        judges = self.calibration.judges if self.calibration else ()
        own = self.table.trainings if self.table else ()
        return {name for name in (*own, *judges) if name in self.trainings}

    def method_names(self, sections: Collection[Section]) -> Iterable[str]:
        """Names and specs of the methods of some sections, besides trainings."""
        for what in self._planned(sections):
            for kind in ("methods", "judges", "others"):
                yield from getattr(what, kind, ())

    def _planned(self, sections: Collection[Section]) -> Iterable[Any]:
        for section in sections:
            found = getattr(self, section)
            yield from found if isinstance(found, tuple) else filter(None, [found])

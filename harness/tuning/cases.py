"""The labelled cases that genotypes are judged on, in the order in which they are judged."""

from __future__ import annotations

import hashlib
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from functools import cache
from typing import Any

import pandas as pd

from steadyload.engines.registry import capabilities
from steadyload.layouts.benchmark import load_benchmark
from steadyload.layouts.benchmark.dataset import KEYS
from steadyload.layouts.benchmark.parts import CHOOSING, PLANAR, REAL, Part
from steadyload.layouts.model.layout import Layout
from steadyload.layouts.model.question import Question
from steadyload.statistics.placed import items_placed_by_case
from steadyload.tuning import TuningError


@dataclass(frozen=True, slots=True)
class Case:
    """A layout with its label.

    Attributes:
        layout: with its centres of mass.
        safe: items placed safely, all of them for a stable layout.
        scenario: where its centres of mass are from.
        instance: the item list that it was packed from.
        robust: whether the whole ensemble names its step; None where none has judged it.
    """

    layout: Layout
    safe: int
    scenario: str
    instance: str
    robust: bool | None


def set_for(engine: str, named: str | None, further: Sequence[str]) -> str:
    """The labelled set that a choice on an engine is made on: as named, or one of the package.

    Args:
        engine: registered name.
        named: word or folder; None for the set that suits the engine.
        further: sets that are used, too.

    Raises:
        TuningError: a set stands there twice, or is not planar on an engine of two dimensions.
    """
    planar = capabilities(engine).dimensions == 2
    directory = named or (PLANAR if planar else CHOOSING)
    _refuse_twice((directory, *further))
    if planar and REAL in (directory, *further):
        raise TuningError(
            f"labelled set {REAL}: its layouts are not planar; an engine of two dimensions takes "
            f"planar ones, such as those of {PLANAR}"
        )
    return directory


def _refuse_twice(directories: Sequence[str | None]) -> None:
    for name, count in Counter(directory or "benchmark" for directory in directories).items():
        if count > 1:
            raise TuningError(f"labelled set {name} is named {count} times; allowed: once")


@dataclass(frozen=True, slots=True)
class CaseSource:
    """Source of cases: a part of a labelled set, and the set's folder, None for the shipped one.

    ``limit``: only so many a scenario of every set, those of the first ranks. ``question``: whose
    labels count. ``data``: further sets, of which the part counts that :func:`own_part` names.
    """

    part: str = str(Part.VALIDATION)
    directory: str | None = None
    limit: int | None = None
    question: str = str(Question.WITHIN)
    data: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "data", tuple(self.data))  # a stored one is a list
        _refuse_twice((self.directory, *self.data))

    def parts(self) -> dict[str | None, str]:
        """The part by set, None for the shipped one.

        Raises:
            TuningError: see :func:`own_part`.
        """
        return {self.directory: self.part} | {one: own_part(one, self.part) for one in self.data}

    def stored(self) -> dict[str, Any]:
        """The fields as they are stored; question and further sets only where unusual."""
        found = {**asdict(self), "data": list(self.data)}
        usual = {"question": Question.WITHIN, "data": []}
        return {name: value for name, value in found.items() if usual.get(name, self) != value}


def own_part(directory: str | None, wanted: str) -> str:
    """The part of a set that a choice is made on, and nothing is learnt from.

    Args:
        directory: word or folder; None for the large set of the package.
        wanted: of :class:`steadyload.layouts.benchmark.Part`.

    Returns:
        ``wanted``, where the set has that part; its validation part, where it has none; all of a
        set that is not split.

    Raises:
        TuningError: it is split otherwise.
    """
    splits = set(load_benchmark(directory).cases["split"].dropna())
    for part in (wanted, str(Part.VALIDATION)):
        if part in splits:
            return part
    if splits - {str(Part.TRAIN)}:
        raise TuningError(
            f"{directory}: is split, and has no part {wanted} or validation; allowed: a set that "
            "has one, or one that is not split"
        )
    return str(Part.TRAIN)


@cache
def load_cases(source: CaseSource) -> tuple[Case, ...]:
    """The cases with fragile labels first: on these parameter sets differ most, and soonest.

    Among the fragile and among the others sets and scenarios take turns, so that a search that is
    interrupted, or a genotype that is given up, has seen all of them. A set that says nothing of
    robustness, such as that of real size, takes its turns among the others.

    Raises:
        BenchmarkError: not a labelled set, or it holds no such case.
        TuningError: see :func:`own_part`.
    """
    found = [turn for own in source.parts().items() for turn in _turns(source, *own)]
    return tuple(case for _, _, case in sorted(found, key=lambda turn: turn[:2]))


def _turns(source: CaseSource, directory: str | None, part: str) -> list[tuple[bool, int, Case]]:
    """The cases of one set: whether the label is sure, its turn among such of a scenario."""
    benchmark = load_benchmark(directory)
    question = Question(source.question)
    chosen = benchmark.select(part, limit=source.limit, question=question)
    chosen = chosen.join(benchmark.confidence_on(Question.WITHIN)["robust"], on=KEYS)
    sure = chosen["robust"].astype("boolean").fillna(True).astype(bool)
    turn = chosen.groupby(["scenario", sure]).cumcount()
    safe = items_placed_by_case(chosen["failing_step"], chosen["item_count"])
    robust = [None if pd.isna(value) else bool(value) for value in chosen["robust"]]
    layouts = map(benchmark.layout, chosen["layout"], chosen["scenario"])
    cases = map(Case, layouts, safe, chosen["scenario"], chosen["instance"], robust)
    return list(zip(sure, turn, cases, strict=True))


def fingerprint(cases: Iterable[Case]) -> str:
    """Hash of layouts and labels, in the order of the cases."""
    lines = "\n".join(f"{case.layout.content_hash()} {case.safe}" for case in cases)
    return hashlib.sha256(lines.encode()).hexdigest()[:16]

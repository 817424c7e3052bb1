"""Records for the page of the paper's experiment, and their computation from what was judged."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from steadyload.layouts.model.scenarios import Scenario
from steadyload.methods.registry import make_method
from steadyload.runs.accuracy import accuracy_of_seeds
from steadyload.runs.comparison import difference
from steadyload.runs.evaluation import ALL
from steadyload.runs.labels import item_lists
from steadyload.runs.paper import paper
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.metrics import mean, share
from steadyload.studies.replication.methods import (
    ALL_LINES,
    PS_OPT,
    Line,
)
from steadyload.studies.replication.networks import Effort
from steadyload.studies.replication.splits import VALIDATION, SplitKind
from steadyload.studies.replication.study import (
    LSTM_1,
    LSTM_E,
    MEMORISER,
    SUPPORT,
    Replicated,
    Rights,
    costs_of,
)

ByGroup = Mapping[str, Estimate]
"""Estimates by scenario, and of all."""

S2 = "S2"
"""Group of S2a and S2b together."""

GROUPS = (str(Scenario.S1), str(Scenario.S2A), str(Scenario.S2B), ALL)

_NO_PAPER: Mapping[str, float] = {}


@dataclass(frozen=True, slots=True)
class MethodRow:
    """A method that learns nothing here.

    Attributes:
        line: its title and spec.
        accuracy: by group.
        paper: the paper's own, as shares; empty where it has none.
        lost: test files without a verdict.
        cpu: mean CPU time of a judgement [ms].
    """

    line: Line
    accuracy: ByGroup
    paper: Mapping[str, float]
    lost: int
    cpu: float


@dataclass(frozen=True, slots=True)
class LearnedRow:
    """Something that learnt from the training part of a split.

    Attributes:
        name: see :mod:`steadyload.studies.replication.study`.
        kind: of the split.
        accuracy: by group.
        with_twin, without_twin: on the test files whose geometry is in the training of their
            scenario, or is not; of all scenarios.
        paper: as of :class:`MethodRow`.
    """

    name: str
    kind: SplitKind
    accuracy: ByGroup
    with_twin: Estimate
    without_twin: Estimate
    paper: Mapping[str, float]


@dataclass(frozen=True, slots=True)
class SplitRow:
    """A split: its trainings, their cases (least and most), and the test files with a twin."""

    kind: SplitKind
    trainings: int
    cases: tuple[int, int]
    twins: ByGroup


@dataclass(frozen=True, slots=True)
class EffortRow:
    """The trainings of one kind on one split: epochs as least and most, and how many time ended."""

    name: str
    kind: SplitKind
    trainings: int
    epochs: tuple[int, int]
    best: tuple[int, int]
    hours: float
    cut_off: int


@dataclass(frozen=True, slots=True)
class Answer:
    """A difference between accuracies, and the paper's where it has one."""

    about: str
    found: Estimate
    paper: float | None = None


@dataclass(frozen=True, slots=True)
class Change:
    """A step from the paper's set-up to ours.

    Attributes:
        title: what is changed.
        accuracy: after it, on all test files.
        change: to the step before, on the same files; None for the first one.
    """

    title: str
    accuracy: Estimate
    change: Estimate | None


@dataclass(frozen=True, slots=True)
class CountRow:
    """Files of a scenario: labelled, stable among them, held out for validation and test."""

    scenario: str
    labelled: int
    stable: Estimate
    validation: int
    test: int
    distinct: int


@dataclass(frozen=True)
class ReplicationSummary:
    """Everything that the page shows.

    Attributes:
        quick: whether it is of the quick run.
        epochs: most epochs of a training.
        files, geometries, lists: of the data set as it was used.
        unlabelled: files by scenario without a label.
        counts: by scenario.
        methods: rules and simulations.
        learned: what learnt, by split.
        splits: of the test.
        efforts: of trainings.
        answers: differences that answer the question of the page.
        networks, simulations: steps from the paper's set-up to ours.
        left_out: by spec, the reason why a method cannot judge.
        made_with: provenance.
    """

    quick: bool
    epochs: int
    files: int
    geometries: int
    lists: int
    unlabelled: int
    counts: tuple[CountRow, ...]
    methods: tuple[MethodRow, ...]
    learned: tuple[LearnedRow, ...]
    splits: tuple[SplitRow, ...]
    efforts: tuple[EffortRow, ...]
    answers: tuple[Answer, ...]
    networks: tuple[Change, ...]
    simulations: tuple[Change, ...]
    left_out: Mapping[str, str]
    made_with: Mapping[str, str]

    def method(self, spec: str) -> MethodRow | None:
        """The row of a method; None where it was not judged."""
        return next((row for row in self.methods if row.line.spec == spec), None)

    def learnt(self, name: str, kind: SplitKind) -> LearnedRow | None:
        """The row of what learnt on a split; None where there is none."""
        found = (row for row in self.learned if (row.name, row.kind) == (name, kind))
        return next(found, None)


def summarise(done: Replicated) -> ReplicationSummary:
    """The summary of a replication."""
    tests = done.tests
    lines = {str(make_method(line.spec).spec): line for line in ALL_LINES}
    costs = costs_of(done.judged)
    methods = tuple(
        MethodRow(
            lines.get(spec, Line(spec, done.judged.keys[spec].title)),
            by_group(right, tests),
            paper_of(lines[spec].paper) if spec in lines else _NO_PAPER,
            int(done.judged.said[spec].isna().reindex(_keys(tests)).sum()),
            costs[spec],
        )
        for spec, right in done.rights.items()
    )
    learned = tuple(
        LearnedRow(
            name,
            kind,
            by_group(right, tests),
            _accuracy(right, tests, split.twins),
            _accuracy(right, tests, ~split.twins),
            paper_of(name if name in (LSTM_1, LSTM_E) else ""),
        )
        for kind, split in done.splits.items()
        for name, right in split.rights.items()
    )
    return ReplicationSummary(
        quick=done.asked.quick,
        epochs=done.asked.epochs,
        files=len(done.files.table),
        geometries=done.files.table["geometry"].nunique(),
        lists=tests["instance"].nunique(),
        unlabelled=done.unlabelled,
        counts=tuple(_counts(done)),
        methods=methods,
        learned=learned,
        splits=tuple(
            SplitRow(
                kind,
                len(split.folds),
                _ends([int(fold.train.sum()) for fold in split.folds]),
                by_group(split.twins[None], tests),
            )
            for kind, split in done.splits.items()
        ),
        efforts=tuple(
            _effort(name, kind, efforts)
            for kind, split in done.splits.items()
            for name, efforts in split.efforts.items()
        ),
        answers=tuple(_answers(done)),
        networks=tuple(_changes(_network_steps(done), tests)),
        simulations=tuple(_changes(_simulation_steps(done), tests)),
        left_out=done.left_out,
        made_with=done.made_with,
    )


def paper_of(title: str) -> Mapping[str, float]:
    """The paper's accuracies of a method by group, as shares; empty where it has none."""
    return next((row.accuracy for row in paper().rows if row.title == title), _NO_PAPER)


def by_group(right: Rights, tests: pd.DataFrame) -> dict[str, Estimate]:
    """Accuracy by scenario and of all, the mean over seeds, clustered by item list."""
    scenarios = tests["scenario"].to_numpy()
    masks = {g: scenarios == g if g != ALL else np.ones(len(tests), bool) for g in GROUPS}
    return {group: _accuracy(right, tests, mask) for group, mask in masks.items()}


def _accuracy(right: Rights, tests: pd.DataFrame, mask: NDArray[np.bool_]) -> Estimate:
    return accuracy_of_seeds(right[:, mask], item_lists(tests)[mask])


def fall(right: Rights, tests: pd.DataFrame) -> Estimate:
    """Accuracy in S1 minus that in S2a and S2b together, clustered by item list."""
    first = (tests["scenario"] == Scenario.S1).to_numpy(bool)
    weights = np.where(first, 1.0 / first.sum(), -1.0 / (~first).sum()) * len(tests)
    return mean(right.mean(axis=0) * weights, item_lists(tests))


def _answers(done: Replicated) -> list[Answer]:
    tests = done.tests
    found = []
    printed = paper_of(LSTM_1)
    papers_fall = printed["S1"] - (printed["S2a"] + printed["S2b"]) / 2.0
    first = (tests["scenario"] == Scenario.S1).to_numpy(bool)
    lists = item_lists(tests)
    pairs = (
        (SplitKind.FILE, SplitKind.FEWER, "fewer training files"),
        (SplitKind.FEWER, SplitKind.GEOMETRY, "no twins in training, as many files"),
        (SplitKind.GEOMETRY, SplitKind.LIST, "item lists held out instead of geometries"),
    )
    for name in (LSTM_1, MEMORISER):
        for one, other, about in pairs:
            a, b = (done.splits[kind].rights[name][:, first] for kind in (one, other))
            lost = difference(a, b, lists[first])
            found.append(Answer(f"{name} in S1, what is lost by {about}", lost))
    for name in (LSTM_1, MEMORISER):
        for kind, word in ((SplitKind.FILE, "file"), (SplitKind.LIST, "item list")):
            drop = fall(done.splits[kind].rights[name], tests)
            beside = papers_fall if (name, kind) == (LSTM_1, SplitKind.FILE) else None
            found.append(Answer(f"{name}, fall from S1 to S2, split by {word}", drop, beside))
    return found


def _network_steps(done: Replicated) -> list[tuple[str, Rights]]:
    splits = done.splits
    found = [
        ("LSTM_1, split by file", splits[SplitKind.FILE].rights[LSTM_1]),
        ("fewer training files", splits[SplitKind.FEWER].rights[LSTM_1]),
        ("split by geometry", splits[SplitKind.GEOMETRY].rights[LSTM_1]),
        ("split by item list", splits[SplitKind.LIST].rights[LSTM_1]),
        ("features of support", splits[SplitKind.LIST].rights[SUPPORT]),
    ]
    shipped = done.rights.get("lstm_1")
    return found if shipped is None else [*found, ("more item lists: our lstm_1", shipped)]


def _simulation_steps(done: Replicated) -> list[tuple[str, Rights]]:
    specs = ((line, str(make_method(line.spec).spec)) for line in PS_OPT)
    return [(line.title, done.rights[spec]) for line, spec in specs if spec in done.rights]


def _changes(steps: Sequence[tuple[str, Rights]], tests: pd.DataFrame) -> list[Change]:
    lists, found = item_lists(tests), []
    before: Rights | None = None
    for title, right in steps:
        change = None if before is None else difference(right, before, lists)
        found.append(Change(title, accuracy_of_seeds(right, lists), change))
        before = right
    return found


def _counts(done: Replicated) -> list[CountRow]:
    rows = []
    for scenario, own in done.cases.groupby("scenario", sort=True):
        held = done.part.loc[own.index]
        rows.append(
            CountRow(
                str(scenario),
                len(own),
                share(own["failing_step"].isna(), item_lists(own)),
                int((held == VALIDATION).sum()),
                len(done.tests[done.tests["scenario"] == scenario]),
                int(own["content"].nunique()),
            )
        )
    return rows


def _effort(name: str, kind: SplitKind, efforts: Sequence[Effort]) -> EffortRow:
    return EffortRow(
        name,
        kind,
        len(efforts),
        _ends([effort.epochs for effort in efforts]),
        _ends([effort.best_epoch for effort in efforts]),
        sum(effort.seconds for effort in efforts) / 3600.0,
        sum(effort.cut_off for effort in efforts),
    )


def _ends(values: Sequence[int]) -> tuple[int, int]:
    return min(values), max(values)


def _keys(tests: pd.DataFrame) -> pd.MultiIndex:
    return pd.MultiIndex.from_arrays([tests["name"], tests["scenario"]])

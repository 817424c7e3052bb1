"""Rows of the page of the paper's experiment, computed from what was judged and trained."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from steadyload.labelling.paper_labels import Labelling
from steadyload.layouts.model.scenarios import Scenario
from steadyload.methods.registry import make_method
from steadyload.reports.columns import column, percent, plain_percent, row, significant
from steadyload.runs.accuracy import accuracy_of_seeds
from steadyload.runs.comparison import difference
from steadyload.runs.evaluation import ALL
from steadyload.runs.labels import item_lists
from steadyload.runs.paper import paper
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.metrics import mean, share
from steadyload.studies.replication.methods import (
    ALL_LINES,
    AS_RUN,
    LSTM_1,
    LSTM_E,
    MEMORISER,
    PS_OPT,
    READINGS,
    SUPPORT,
    Line,
)
from steadyload.studies.replication.splits import TABLE_2, TEST, VALIDATION, SplitKind

if TYPE_CHECKING:
    from steadyload.studies.replication.judging import Replicated, Rights


Groups = Mapping[str, Estimate]
"""Estimates by scenario, and of all test files; all are clustered by item list."""

SCENARIOS = tuple(map(str, Scenario))


def _ends(ends: tuple[int, int]) -> str:
    """``3``, or ``3 to 5``: the least and the greatest."""
    return " to ".join(map(str, dict.fromkeys(ends)))


@row
class MethodRow:
    """A method that learns nothing here."""

    spec: str
    title: str = column("method")
    accuracy: Groups = column("{} %", percent)
    paper: float | None = column("the paper, all %", plain_percent)
    without_verdict: int = column("no verdict")
    cpu_ms: float = column("CPU ms", significant)

    @property
    def test_files(self) -> int:
        """The number of files that it is tested on."""
        return self.accuracy[ALL].n

    @property
    def off(self) -> float:
        """How far its accuracy is from the paper's, as a share."""
        return abs(self.accuracy[ALL].value - (self.paper or 0.0))


@row
class LearnedRow:
    """Something that learnt from the training part of a split, see :class:`SplitKind`.

    ``with_twin``, ``without_twin``: on the test files of all scenarios whose geometry is in the
    training of their scenario, or is not.
    """

    name: str = column("method")
    split: str = column("split by")
    accuracy: Groups = column("{} %", percent)
    with_twin: Estimate = column("with a twin %", percent)
    without_twin: Estimate = column("without %", percent)


@row
class PrintedRow:
    """The paper's own accuracies of a network."""

    name: str = column("the paper")
    accuracy: Mapping[str, float] = column("{} %", plain_percent)


@row
class SplitRow:
    """A split: its trainings, their cases (least and most), and the test files with a twin."""

    split: str = column("split by")
    trainings: int = column()
    cases: tuple[int, int] = column("training cases", _ends)
    twins: Groups = column("{}, twin in training %", percent)


@row
class TrainingRow:
    """The trainings of one kind on one split; of epochs the least and the most."""

    name: str = column("network")
    split: str = column("split by")
    trainings: str = column(left=False)
    epochs: tuple[int, int] = column(form=_ends)
    best: tuple[int, int] = column("best epoch", _ends)
    hours: float = column(form=significant)


@row
class Answer:
    """A difference between accuracies, and the paper's where it has one."""

    about: str = column("difference, in points")
    found: Estimate = column("here", percent)
    paper: float | None = column("the paper", plain_percent)


@row
class Change:
    """A step from the paper's set-up of a method to ours; ``change``: to the step before, on the
    same files.
    """

    of: str
    title: str
    accuracy: Estimate = column("accuracy %", percent)
    change: Estimate | None = column("change, points", percent)


@row
class Steps:
    """Steps from the paper's set-up of a method to ours, and the paper's accuracy."""

    of: str
    paper: float
    changes: tuple[Change, ...]


@row
class CountRow:
    """Labelled files of a scenario, stable ones among them, and those that are held out."""

    scenario: str = column()
    labelled: int = column("files")
    distinct: int = column("distinct cases")
    stable: Estimate = column("stable %", percent)
    validation: int = column()
    test: int = column()


@dataclass(frozen=True)
class Results:
    """Accuracies of everything that was judged and trained.

    Attributes:
        files, geometries, lists: of the data set as it was used.
        unlabelled: files by scenario without a label.
        counts: by scenario.
        methods: rules and simulations.
        printed: the paper's figures of networks that are trained here.
        learned: what learnt, by name and split.
        splits: of the test.
        trainings: by split and name.
        answers: differences that answer the question of the page.
        steps: of LSTM_1 and of PS_opt, as far as they were judged.
        left_out: by spec, the reason why a method cannot judge.
    """

    files: int
    geometries: int
    lists: int
    unlabelled: int
    counts: Sequence[CountRow]
    methods: Sequence[MethodRow]
    printed: Sequence[PrintedRow]
    learned: Sequence[LearnedRow]
    splits: Sequence[SplitRow]
    trainings: Sequence[TrainingRow]
    answers: Sequence[Answer]
    steps: Sequence[Steps]
    left_out: Mapping[str, str]

    @property
    def best(self) -> PrintedRow:
        """The paper's best network of those that are trained here."""
        return self.printed[-1]

    def together(self, *titles: str) -> list[tuple[MethodRow, ...]]:
        """The rows of some methods as one tuple; none where one of them was not judged."""
        rows = {one.title: one for one in self.methods}
        return [tuple(rows[title] for title in titles)] if rows.keys() >= {*titles} else []

    def learnt(self, name: str, split: str) -> LearnedRow:
        """The row of what learnt on a split."""
        return next(one for one in self.learned if (one.name, one.split) == (name, split))

    def answer(self, about: str) -> Answer:
        """The answer to a question."""
        return next(one for one in self.answers if one.about == about)

    @property
    def readings(self) -> list[MethodRow]:
        """The readings of the paper's simulations."""
        rows = {one.spec: one for one in self.methods}
        return [rows[line.spec] for line in (*READINGS, *AS_RUN) if line.spec in rows]

    @property
    def others(self) -> list[MethodRow]:
        """The other methods."""
        return [one for one in self.methods if one not in self.readings]

    @property
    def tested(self) -> tuple[int, int]:
        """Test files of a scenario, the least and the greatest number."""
        return _range(one.test for one in self.counts)

    @property
    def validation(self) -> Mapping[str, int]:
        """Files by scenario that the paper's Table 2 has for validation."""
        return {name: sum(size.validation) for name, size in TABLE_2.items()}


@dataclass(frozen=True)
class Found:
    """Results of the study: all of them, or the labels alone."""

    results: Results | None = None
    labelling: Labelling | None = None
    made_with: Mapping[str, str] = field(default_factory=dict)


def summarise(done: Replicated) -> Results:
    """The rows of a replication."""
    tests, table, splits = done.tests, done.files.table, done.splits
    lines = {str(make_method(line.spec).spec): line for line in ALL_LINES}
    keys = pd.MultiIndex.from_frame(tests[["name", "scenario"]])
    methods = []
    for own in done.judged.methods:
        spec, said = own.method.spec, done.judged.judged.said[own.method.spec]
        line = lines.get(spec, Line(spec, own.method.title))
        methods.append(
            MethodRow(
                line.spec,
                line.title,
                by_group(done.rights[spec], tests),
                paper_of(line.paper).get(ALL),
                int(said.isna().reindex(keys).sum()),
                own.cpu.value,
            )
        )
    names = dict.fromkeys(name for split in splits.values() for name in split.rights)
    learned = [
        LearnedRow(
            name,
            kind.words,
            by_group(split.rights[name], tests),
            _accuracy(split.rights[name], tests, split.twins),
            _accuracy(split.rights[name], tests, ~split.twins),
        )
        for name in names
        for kind, split in splits.items()
        if name in split.rights
    ]
    return Results(
        files=len(table),
        geometries=table["geometry"].nunique(),
        lists=tests["instance"].nunique(),
        unlabelled=len(table) * len(SCENARIOS) - len(done.cases),
        counts=[_counts(done, scenario) for scenario in SCENARIOS],
        methods=methods,
        printed=[PrintedRow(name, paper_of(name)) for name in (LSTM_1, LSTM_E) if name in names],
        learned=learned,
        splits=[
            SplitRow(
                kind.words,
                len(split.folds),
                _range(int(fold.train.sum()) for fold in split.folds),
                by_group(split.twins[None], tests, SCENARIOS),
            )
            for kind, split in splits.items()
        ],
        trainings=[
            TrainingRow(
                name,
                kind.words,
                f"{len(own)}, {sum(each.cut_off for each in own)} cut off",
                _range(each.epochs for each in own),
                _range(each.best_epoch for each in own),
                sum(each.seconds for each in own) / 3600.0,
            )
            for kind, split in splits.items()
            for name, own in split.efforts.items()
        ],
        answers=_answers(done),
        steps=_steps(done),
        left_out=done.left_out,
    )


def paper_of(title: str) -> Mapping[str, float]:
    """The paper's accuracies of a method by group, as shares; empty where it has none."""
    return next((row.accuracy for row in paper().rows if row.title == title), {})


def by_group(
    right: Rights, tests: pd.DataFrame, groups: Sequence[str] = (*SCENARIOS, ALL)
) -> dict[str, Estimate]:
    """Accuracy by scenario and of all, the mean over seeds."""
    of = tests["scenario"].to_numpy()
    masks = {group: (of == group) | (group == ALL) for group in groups}
    return {group: _accuracy(right, tests, mask) for group, mask in masks.items()}


def _accuracy(right: Rights, tests: pd.DataFrame, mask: NDArray[np.bool_]) -> Estimate:
    return accuracy_of_seeds(right[:, mask], item_lists(tests)[mask])


def fall(right: Rights, tests: pd.DataFrame) -> Estimate:
    """Accuracy in S1 minus that in S2a and S2b together."""
    first = (tests["scenario"] == Scenario.S1).to_numpy(bool)
    weights = np.where(first, 1.0 / first.sum(), -1.0 / (~first).sum()) * len(tests)
    return mean(right.mean(axis=0) * weights, item_lists(tests))


def _answers(done: Replicated) -> list[Answer]:
    tests, splits, found = done.tests, done.splits, []
    first = (tests["scenario"] == Scenario.S1).to_numpy(bool)
    lists = item_lists(tests)[first]
    pairs = (
        (SplitKind.FILE, SplitKind.FEWER, "fewer training files"),
        (SplitKind.FEWER, SplitKind.GEOMETRY, "no twins in training, as many files"),
        (SplitKind.GEOMETRY, SplitKind.LIST, "item lists held out instead of geometries"),
    )
    for name in (LSTM_1, MEMORISER):
        for one, other, about in pairs:
            a, b = (splits[kind].rights[name][:, first] for kind in (one, other))
            lost = difference(a, b, lists)
            found.append(Answer(f"{name} in S1, what is lost by {about}", lost, None))
    printed = paper_of(LSTM_1)
    papers = printed["S1"] - (printed["S2a"] + printed["S2b"]) / 2.0
    for name in (LSTM_1, MEMORISER):
        for kind in (SplitKind.FILE, SplitKind.LIST):
            beside = papers if (name, kind) == (LSTM_1, SplitKind.FILE) else None
            about = f"{name}, fall from S1 to S2, split by {kind.words}"
            found.append(Answer(about, fall(splits[kind].rights[name], tests), beside))
    return found


def _steps(done: Replicated) -> list[Steps]:
    own = {kind: split.rights for kind, split in done.splits.items()}
    networks = {
        "LSTM_1, split by file": own[SplitKind.FILE][LSTM_1],
        "fewer training files": own[SplitKind.FEWER][LSTM_1],
        "split by geometry": own[SplitKind.GEOMETRY][LSTM_1],
        "split by item list": own[SplitKind.LIST][LSTM_1],
        "features of support": own[SplitKind.LIST][SUPPORT],
    }
    shipped = done.rights.get("lstm_1")
    if shipped is not None:
        networks["more item lists: our lstm_1"] = shipped
    specs = {line.title: str(make_method(line.spec).spec) for line in PS_OPT}
    simulations = {t: done.rights[spec] for t, spec in specs.items() if spec in done.rights}
    return [
        Steps(of, paper_of(of)[ALL], tuple(_changes(of, steps, done.tests)))
        for of, steps in ((LSTM_1, networks), ("PS_opt", simulations))
        if steps
    ]


def _changes(of: str, steps: Mapping[str, Rights], tests: pd.DataFrame) -> Iterable[Change]:
    lists, before = item_lists(tests), None
    for title, right in steps.items():
        change = None if before is None else difference(right, before, lists)
        yield Change(of, title, accuracy_of_seeds(right, lists), change)
        before = right


def _counts(done: Replicated, scenario: str) -> CountRow:
    own = done.cases[done.cases["scenario"] == scenario]
    held = done.part.loc[own.index].value_counts()
    return CountRow(
        scenario,
        len(own),
        int(own["content"].nunique()),
        share(own["failing_step"].isna(), item_lists(own)),
        int(held[VALIDATION]),
        int(held[TEST]),
    )


def _range(values: Iterable[int]) -> tuple[int, int]:
    known = list(values)
    return min(known), max(known)

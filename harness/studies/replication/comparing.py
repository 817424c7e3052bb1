"""The paper's experiment: every method on the same test files, as the rows of its page."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
import pandas as pd

from steadyload.labelling.building.paper_files import PaperFiles
from steadyload.labelling.paper_labels import (
    Labels,
    case_layouts,
    labelled_cases,
    set_of,
)
from steadyload.layouts.benchmark.parts import Part
from steadyload.layouts.model.scenarios import Scenario
from steadyload.methods.registry import make_method
from steadyload.reports.columns import column, percent, plain_percent, row, significant
from steadyload.runs.able import able_methods
from steadyload.runs.accuracy import accuracy_of_seeds, verdicts_against_labels
from steadyload.runs.comparison import difference
from steadyload.runs.evaluation import ALL, MethodEvaluation
from steadyload.runs.labels import Cases, item_lists
from steadyload.runs.paper import PaperRow, paper
from steadyload.runs.provenance import provenance_lines
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.metrics import mean, share
from steadyload.studies.kit import Lab
from steadyload.studies.replication.methods import (
    AS_RUN,
    LSTM_1,
    MEMORISER,
    METHODS,
    PAPER,
    PS_OPT,
    READINGS,
    SUPPORT,
    Extent,
)
from steadyload.studies.replication.splits import (
    TABLE_2,
    TEST,
    VALIDATION,
    Mask,
    Rights,
    Sizes,
    SplitKind,
    draw_parts,
    folds,
    with_twin,
)

Groups = Mapping[str, Estimate]
"""Estimates by scenario, and of all test files; all are clustered by item list."""

SCENARIOS = tuple(map(str, Scenario))

_SHARD = 50

_SEED = 0
"""Of the draws of test and validation files."""

_NETWORKS = {
    "LSTM_1, split by file": (LSTM_1, SplitKind.FILE),
    "fewer training files": (LSTM_1, SplitKind.FEWER),
    "split by geometry": (LSTM_1, SplitKind.GEOMETRY),
    "split by item list": (LSTM_1, SplitKind.LIST),
    "features of support": (SUPPORT, SplitKind.LIST),
    "more item lists: our lstm_1": ("our lstm_1", ""),
}
"""From LSTM_1 as in the paper to ours: what it is, and its split."""

_LOST = {
    "fewer training files": (SplitKind.FILE, SplitKind.FEWER),
    "no twins in training, as many files": (SplitKind.FEWER, SplitKind.GEOMETRY),
    "item lists held out instead of geometries": (SplitKind.GEOMETRY, SplitKind.LIST),
}


def _ends(numbers: Sequence[int]) -> str:
    """``3``, or ``3 to 5``: the least and the greatest."""
    return " to ".join(map(str, dict.fromkeys((min(numbers), max(numbers)))))


@row
class MethodRow:
    """A method that learns nothing here.

    ``is_reading``: whether it is PS_3, PS_5 or PS_opt as the authors may have run them.
    """

    title: str = column("method")
    accuracy: Groups = column("{} %", percent)
    paper: float | None = column("the paper, all %", plain_percent)
    without_verdict: int = column("no verdict")
    cpu_ms: float = column("CPU ms", significant)
    is_reading: bool

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

    Attributes:
        with_twin, without_twin: on the test files of all scenarios whose geometry is in the
            training of their scenario, or is not.
        epochs, best: of every training; none of what has no epochs.
    """

    name: str = column("method")
    split: str = column("split by")
    accuracy: Groups = column("{} %", percent)
    with_twin: Estimate = column("with a twin %", percent)
    without_twin: Estimate = column("without %", percent)
    trainings: str = column(left=False)
    epochs: Sequence[int] = column(form=_ends)
    best: Sequence[int] = column("best epoch", _ends)
    hours: float = column(form=significant)


@row
class SplitRow:
    """A split: its trainings, the cases of each, and the test files with a twin."""

    split: str = column("split by")
    trainings: int = column()
    cases: Sequence[int] = column("training cases", _ends)
    twins: Groups = column("{}, twin in training %", percent)


@row
class Answer:
    """A difference between accuracies, and the paper's where it has one."""

    about: str = column("difference, in points")
    found: Estimate = column("here", percent)
    paper: float | None = column("the paper", plain_percent, default=None)


@row
class Change:
    """A step from a method of the paper, with its accuracy there, to ours; ``change``: to the step
    before, on the same files.
    """

    of: str
    paper: float
    title: str
    accuracy: Estimate = column("accuracy %", percent)
    change: Estimate | None = column("change, points", percent)


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

    ``extent`` is that of the trainings. ``files``, ``geometries``, ``lists`` took part,
    ``unlabelled`` files by scenario have no label. ``printed`` are the paper's figures of what is
    trained here; that has rows by its name and split. ``left_out`` has the reasons why methods
    cannot judge, by spec; ``made_with`` the provenance of the others' verdicts and times.
    """

    extent: Extent
    files: int
    geometries: int
    lists: int
    unlabelled: int
    counts: Sequence[CountRow]
    methods: Sequence[MethodRow]
    printed: Sequence[PaperRow]
    learned: Mapping[tuple[str, str], LearnedRow]
    splits: Sequence[SplitRow]
    answers: Mapping[str, Answer]
    changes: Sequence[Change]
    left_out: Mapping[str, str]
    made_with: Mapping[str, str]

    def together(self, *titles: str) -> list[tuple[MethodRow, ...]]:
        """The rows of some methods as one tuple; none where one of them was not judged."""
        rows = {one.title: one for one in self.methods}
        return [tuple(rows[title] for title in titles)] if rows.keys() >= {*titles} else []


def replicate(
    lab: Lab,
    files: PaperFiles,
    labels: Labels,
    extent: Extent,
    *,
    methods: Iterable[str] = METHODS.values(),
    sizes: Sizes = TABLE_2,
) -> Results:
    """Judge and train what is missing; an interrupted run is resumed."""
    from steadyload.studies.replication.learning import learn  # only this needs the extra

    cases = labelled_cases(files, labels)
    cases["part"] = draw_parts(cases, seed=_SEED, sizes=sizes)
    test = (cases["part"] == TEST).to_numpy(bool)
    tests = cases[test]
    named, left_out = able_methods((), lambda: methods)
    evaluation = lab.judge(
        named, Cases(set_of(files, tests), Part.TEST), folder="judged", name="replication",
        shard_size=_SHARD,
    )  # fmt: skip
    said = evaluation.judged.said.reindex(pd.MultiIndex.from_frame(tests[["name", "scenario"]]))
    judged = [_judged(own, said[own.method.spec], tests) for own in evaluation.methods]
    learned = learn(lab, cases, case_layouts(files, cases), extent)
    rights: dict[tuple[str, str], Rights] = {(one.title, ""): right for one, right in judged}
    rights |= {key: own.right[:, test] for key, own in learned.items()}
    parts = {kind: folds(cases, kind) for kind in SplitKind}
    twins = {kind: with_twin(cases, own)[test] for kind, own in parts.items()}
    names = dict.fromkeys(name for name, _ in learned)
    return Results(
        extent,
        files=len(files.table),
        geometries=files.table["geometry"].nunique(),
        lists=tests["instance"].nunique(),
        unlabelled=len(files.table) * len(SCENARIOS) - len(cases),
        counts=[_counts(scenario, own) for scenario, own in cases.groupby("scenario")],
        methods=[one for one, _ in judged],
        printed=[each for each in paper().rows if each.title in names],
        learned={
            (name, kind.words): LearnedRow(
                name,
                kind.words,
                by_group(rights[name, kind], tests),
                _accuracy(rights[name, kind], tests, twins[kind]),
                _accuracy(rights[name, kind], tests, ~twins[kind]),
                f"{len(own)}, {sum(each.cut_off for each in own)} cut off",
                [each.epochs for each in own],
                [each.best_epoch for each in own],
                sum(each.seconds for each in own) / 3600.0,
            )
            for name in names
            for (of, kind), (_, own) in learned.items()
            if of == name
        },
        splits=[
            SplitRow(
                kind.words,
                len(own),
                [int(fold.train.sum()) for fold in own],
                by_group(twins[kind][None], tests, SCENARIOS),
            )
            for kind, own in parts.items()
        ],
        answers={one.about: one for one in _answers(rights, tests)},
        changes=[
            *_changes(LSTM_1, _NETWORKS, rights, tests),
            *_changes("PS_opt", {title: (title, "") for title in PS_OPT}, rights, tests),
        ],
        left_out=left_out,
        made_with=provenance_lines(evaluation.judged.manifest),
    )


def _judged(
    own: MethodEvaluation, said: pd.Series, tests: pd.DataFrame
) -> tuple[MethodRow, Rights]:
    """The row of a method, and on which test files it is right; twins share a verdict in S1."""
    title = _titles().get(own.method.spec, own.method.title)
    right = verdicts_against_labels(said, tests)["right"].to_numpy(bool)[None]
    made = MethodRow(
        title,
        by_group(right, tests),
        paper_of(PAPER.get(title, "")).get(ALL),
        int(said.isna().sum()),
        own.cpu.value,
        title in READINGS | AS_RUN,
    )
    return made, right


@cache
def _titles() -> Mapping[str, str]:
    """Titles by canonical spec."""
    return {str(make_method(spec).spec): title for title, spec in METHODS.items()}


def paper_of(title: str) -> Mapping[str, float]:
    """The paper's accuracies of a method by group, as shares; empty where it has none."""
    return next((one.accuracy for one in paper().rows if one.title == title), {})


def by_group(
    right: Rights, tests: pd.DataFrame, groups: Sequence[str] = (*SCENARIOS, ALL)
) -> Groups:
    """Accuracy by scenario and of all, the mean over seeds."""
    of = tests["scenario"].to_numpy()
    return {group: _accuracy(right, tests, (of == group) | (group == ALL)) for group in groups}


def _accuracy(right: Rights, tests: pd.DataFrame, mask: Mask) -> Estimate:
    return accuracy_of_seeds(right[:, mask], item_lists(tests)[mask])


def fall(right: Rights, tests: pd.DataFrame) -> Estimate:
    """Accuracy in S1 minus that in S2a and S2b together."""
    first = (tests["scenario"] == Scenario.S1).to_numpy(bool)
    weights = np.where(first, 1.0 / first.sum(), -1.0 / (~first).sum()) * len(tests)
    return mean(right.mean(axis=0) * weights, item_lists(tests))


def _answers(rights: Mapping[tuple[str, str], Rights], tests: pd.DataFrame) -> Iterable[Answer]:
    first = (tests["scenario"] == Scenario.S1).to_numpy(bool)
    for name in (LSTM_1, MEMORISER):
        for about, kinds in _LOST.items():
            one, other = (rights[name, kind][:, first] for kind in kinds)
            lost = difference(one, other, item_lists(tests)[first])
            yield Answer(f"{name} in S1, what is lost by {about}", lost)
    printed = paper_of(LSTM_1)
    papers = printed["S1"] - (printed["S2a"] + printed["S2b"]) / 2.0
    for name in (LSTM_1, MEMORISER):
        for kind in (SplitKind.FILE, SplitKind.LIST):
            beside = papers if (name, kind) == (LSTM_1, SplitKind.FILE) else None
            about = f"{name}, fall from S1 to S2, split by {kind.words}"
            yield Answer(about, fall(rights[name, kind], tests), beside)


def _changes(
    of: str,
    steps: Mapping[str, tuple[str, str]],
    rights: Mapping[tuple[str, str], Rights],
    tests: pd.DataFrame,
) -> Iterable[Change]:
    """Steps, as far as they were judged; each has the key of what is right after it."""
    lists, before = item_lists(tests), None
    for title, key in steps.items():
        if key in rights:
            change = None if before is None else difference(rights[key], before, lists)
            accuracy = accuracy_of_seeds(rights[key], lists)
            yield Change(of, paper_of(of)[ALL], title, accuracy, change)
            before = rights[key]


def _counts(scenario: str, own: pd.DataFrame) -> CountRow:
    held = own["part"].value_counts()
    return CountRow(
        scenario,
        len(own),
        own["content"].nunique(),
        share(own["failing_step"].isna(), item_lists(own)),
        int(held[VALIDATION]),
        int(held[TEST]),
    )

"""Ceiling of the labels: the agreement of the reference with itself under small changes.

A label is one verdict of the reference. An ensemble of changed references gives further verdicts
(:mod:`steadyload.layouts.benchmark.confidence`), which are as good as the changes are small. A
method that predicts the same failing step by other means is one more draw from such verdicts: it
cannot be expected to agree with the label more often than they agree among themselves.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike, NDArray

from steadyload.layouts.benchmark.confidence import ENSEMBLE, Reason
from steadyload.layouts.benchmark.dataset import KEYS
from steadyload.layouts.model.question import Question
from steadyload.layouts.model.scenarios import in_usual_order
from steadyload.reports.columns import column, percent, row
from steadyload.runs.accuracy import accuracy_of
from steadyload.runs.evaluation import ALL, in_group
from steadyload.runs.labels import item_lists
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.metrics import mean
from steadyload.statistics.placed import items_placed_by_case

_ENSEMBLES = {
    Question.WITHIN: "numerics, contact model, thresholds and time",
    Question.STANDS: "numerics, contact model and thresholds",
}
"""Names of the whole ensemble, by question."""


def widening(question: Question) -> Mapping[str, tuple[Reason, ...]]:
    """Sets of changes by name, each including the one before. The last one is the ensemble."""
    return {
        "numerics": (Reason.NUMERICAL,),
        "numerics and contact model": (Reason.NUMERICAL, Reason.MODEL),
        _ENSEMBLES[question]: (Reason.NUMERICAL, Reason.MODEL, Reason.LIMITS),
    }


_STABLE = -1.0

Answers = NDArray[np.float64]
"""Items placed safely, NaN without a verdict: shape (cases, verdicts)."""


@row
class CeilingRow:
    """Agreement of the verdicts of an ensemble of references.

    ``judges``: number of further verdicts on a case, besides the label. ``label``: agreement of
    each of them with the label. ``twin``: of two of all verdicts, drawn at random. ``plurality``:
    of one of all verdicts, drawn at random, with the most frequent of the others. ``answers``: the
    last two for every group of cases, by heading of a table.
    """

    name: str = column("what changes")
    judges: int = column("further answers")
    label: Estimate = column("accuracy %", percent)
    twin: Estimate
    plurality: Estimate
    answers: Mapping[str, Estimate] = column("{} %", percent, default_factory=dict)


@row
class FurtherMethod:
    """A further method: the share of all cases on which it names the step of the label."""

    reason: str = column("what differs")
    method: str = column()
    same: Estimate = column("same step %", percent)


@row
class Ceiling:
    """Ceiling of the labels.

    ``by_group``: all cases and, where there are several, every scenario; of each a row for every
    set of changes in :func:`widening`, in its order. ``methods``: every further method, on all
    cases.
    """

    by_group: Mapping[str, tuple[CeilingRow, ...]]
    methods: tuple[FurtherMethod, ...]

    @property
    def rows(self) -> list[CeilingRow]:
        """Rows of all cases, with the answers of every group."""
        return [
            replace(
                own,
                answers={
                    f"{title}, {group}": getattr(rows[place], name)
                    for group, rows in self.by_group.items()
                    for name, title in (("twin", "two answers"), ("plurality", "best guess"))
                },
            )
            for place, own in enumerate(self.by_group[ALL])
        ]


def label_ceiling(
    labels: pd.DataFrame, opinions: pd.DataFrame, question: Question = Question.WITHIN
) -> Ceiling | None:
    """The ceiling of the labels of some cases; None where no case has been judged by an ensemble.

    It is that of the cases that all further methods have judged.

    Args:
        labels: a row a case, :data:`steadyload.runs.labels.LABELS`, indexed by layout and
            scenario.
        opinions: verdicts of further methods on these cases and others,
            :data:`steadyload.layouts.benchmark.tables.OPINIONS`.
        question: of both.
    """
    said = opinions.assign(
        answer=opinions["failing_step"]
        .astype("Float64")
        .fillna(_STABLE)
        .astype(float)
        .where(opinions["status"] == "done")
    )
    judges = ["reason", "judge"]
    table = said.pivot(index=KEYS, columns=judges, values="answer")
    if not set(map(str, ENSEMBLE)) <= set(table.columns.levels[0]):
        return None
    asked = said.pivot(index=KEYS, columns=judges, values="status").notna().all(axis=1)
    labels = labels[labels.index.isin(asked.index[asked])]
    if labels.empty:
        return None
    table = table.reindex(labels.index)
    table = table.mask(table == _STABLE, labels["item_count"].astype(float), axis=0)
    label = items_placed_by_case(labels["failing_step"], labels["item_count"]).to_numpy(float)
    lists = item_lists(labels)
    scenarios = in_usual_order(labels.index.unique("scenario"))
    masks = {group: in_group(labels.index, group) for group in (ALL, *scenarios)}
    return Ceiling(
        by_group={
            group: tuple(
                _row(name, label[here], _of(table, reasons)[here], lists[here])
                for name, reasons in widening(question).items()
            )
            for group, here in masks.items()
            if group == ALL or len(scenarios) > 1
        },
        methods=tuple(
            FurtherMethod(reason, judge, accuracy_of(table[reason, judge], labels))
            for own in Reason
            for reason, judge in sorted(table.columns)
            if reason == str(own)
        ),
    )


def _of(table: pd.DataFrame, reasons: Sequence[Reason]) -> Answers:
    chosen = [column for column in table.columns if column[0] in {str(r) for r in reasons}]
    return table[chosen].to_numpy(float)


def _row(name: str, label: NDArray[np.float64], judges: Answers, lists: ArrayLike) -> CeilingRow:
    answers = np.column_stack([label, judges])
    return CeilingRow(
        name=name,
        judges=judges.shape[1],
        label=mean((judges == label[:, None]).mean(axis=1), lists),
        twin=mean(twins(answers), lists),
        plurality=mean(plurality(answers), lists),
    )


def twins(answers: Answers) -> NDArray[np.float64]:
    """By case, the share of pairs of equal verdicts; a missing verdict equals nothing.

    It is an unbiased estimate of the probability that two independent verdicts agree.

    Args:
        answers: items placed safely, shape (cases, verdicts), two or more verdicts.
    """
    count = answers.shape[1]
    same = np.zeros(len(answers))
    for one in range(count):
        same += (answers[:, [one]] == answers).sum(axis=1)
        same -= ~np.isnan(answers[:, one])  # itself
    return same / (count * (count - 1))


def plurality(answers: Answers) -> NDArray[np.float64]:
    """By case, the share of verdicts that are the most frequent one of all the others.

    It is the expected accuracy of a method that knows all other verdicts and predicts the most
    frequent one; of several equally frequent ones it predicts one at random.

    Args:
        answers: items placed safely, shape (cases, verdicts), two or more verdicts.
    """
    found = np.zeros(len(answers))
    for place, case in enumerate(answers):
        values, counts = np.unique(case[~np.isnan(case)], return_counts=True)
        for value, count in zip(values, counts, strict=True):
            # Without one verdict of this value: where it is most frequent, and its ties.
            others = np.where(values == value, counts - 1, counts)
            leads = others.max()
            if count - 1 == leads and leads > 0:
                found[place] += count / (others == leads).sum()
    return found / answers.shape[1]

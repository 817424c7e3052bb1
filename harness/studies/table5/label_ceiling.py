"""What the noise of labels leaves to be reached: how often other answers to the question agree.

A label is one answer, found once. Beside it there are those of an ensemble of changed references
(:mod:`steadyload.layouts.benchmark.confidence`), each as good an answer as the changes are small. A
method that answers the same question by other means is one more draw from such answers: it cannot
be expected to agree with the label more often than they agree among themselves.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike, NDArray

from steadyload.layouts.benchmark.confidence import Reason
from steadyload.layouts.benchmark.dataset import KEYS
from steadyload.runs.evaluation import ALL
from steadyload.statistics.metrics import mean, share
from steadyload.studies.table5.records import Ceiling, CeilingRow

WIDENING: tuple[tuple[str, tuple[Reason, ...]], ...] = (
    ("numerics", (Reason.NUMERICAL,)),
    ("numerics and contact model", (Reason.NUMERICAL, Reason.MODEL)),
    (
        "numerics, contact model, thresholds and time",
        (Reason.NUMERICAL, Reason.MODEL, Reason.LIMITS),
    ),
)
"""Sets of changes, each with all of the one before. The last one is the ensemble."""

_STABLE = -1.0

Answers = NDArray[np.float64]
"""Failing steps, -1 for a stable layout, not a number without a verdict: shape (cases, answers)."""


def label_ceiling(labels: pd.DataFrame, opinions: pd.DataFrame) -> Ceiling | None:
    """What judges that were asked again say of some cases; None where there was no ensemble.

    Args:
        labels: a row a case, :data:`steadyload.runs.labels.LABELS`, indexed by layout and
            scenario.
        opinions: of these cases and others, :data:`steadyload.layouts.benchmark.tables.OPINIONS`.
    """
    said = opinions.assign(
        answer=opinions["failing_step"]
        .astype("Float64")
        .fillna(_STABLE)
        .astype(float)
        .where(opinions["status"] == "done")
    )
    table = said.pivot(index=KEYS, columns=["reason", "judge"], values="answer")
    if not {str(r) for _, reasons in WIDENING for r in reasons} <= set(table.columns.levels[0]):
        return None
    table = table.reindex(labels.index)
    label = labels["failing_step"].astype("Float64").fillna(_STABLE).to_numpy(float)
    lists = labels["instance"].to_numpy()
    scenarios = labels.index.get_level_values("scenario")
    groups = {ALL: np.ones(len(labels), bool)}
    if scenarios.nunique() > 1:
        groups |= {str(s): np.asarray(scenarios == s) for s in dict.fromkeys(scenarios)}
    return Ceiling(
        by_group={
            group: tuple(
                _row(name, label[here], _of(table, reasons)[here], lists[here])
                for name, reasons in WIDENING
            )
            for group, here in groups.items()
        },
        engines=tuple(
            CeilingRow(judge, 1, share(table[reason, judge].to_numpy() == label, lists), None, None)
            for reason, judge in table.columns
            if reason == str(Reason.ENGINE)
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
    """By case, the share of pairs of answers that are the same; no verdict agrees with nothing.

    It estimates without bias how often two independent draws of an answer agree.

    Args:
        answers: shape (cases, answers), two or more answers.
    """
    count = answers.shape[1]
    same = np.zeros(len(answers))
    for one in range(count):
        same += (answers[:, [one]] == answers).sum(axis=1)
        same -= ~np.isnan(answers[:, one])  # itself
    return same / (count * (count - 1))


def plurality(answers: Answers) -> NDArray[np.float64]:
    """By case, how often one answer, left out, is the most frequent one of the others.

    It is what a judge may expect who knows how all other draws fall and names the likeliest; of
    several that are equally frequent it names one by chance.

    Args:
        answers: shape (cases, answers), two or more answers.
    """
    found = np.zeros(len(answers))
    for row, case in enumerate(answers):
        values, counts = np.unique(case[~np.isnan(case)], return_counts=True)
        for value, count in zip(values, counts, strict=True):
            # Without one answer of this value: where it leads now, and with how many.
            others = np.where(values == value, counts - 1, counts)
            leads = others.max()
            if count - 1 == leads and leads > 0:
                found[row] += count / (others == leads).sum()
    return found / answers.shape[1]

"""Columns of tables of methods, over rows of :class:`steadyload.runs.evaluation.MethodEvaluation`.

A page picks its columns from these, so that one quantity has one name and one form on all pages.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable, Sequence

from steadyload.reports.table import (
    Column,
    Table,
    counts,
    factor,
    milliseconds,
    percent,
    words,
)
from steadyload.runs.evaluation import ALL, MethodEvaluation

METHOD = words("method", "method.title")
N = Column("n", "accuracy.n")
ACCURACY = Column("accuracy %", "accuracy", percent)
OVER = Column("overestimated %", "over", percent)
UNDER = Column("underestimated %", "under", percent)
STABLE_OR_NOT = Column("stable or not %", "stable_or_not", percent)
WITHIN_ONE = Column("within one %", "within_one", percent)
NATURAL = Column("natural prevalence %", "natural", percent)
SCORE = Column("mean score %", "score", percent)
FULLY_STABLE = Column("fully stable %", "fully_stable", percent)
CPU = Column("CPU ms", "cpu", milliseconds)
WALL = Column("wall ms", "wall", milliseconds)
AHEAD = Column("ahead", "ahead", percent)
COST_RATIO = Column("cost ratio", "cost_ratio", factor)
NO_VERDICT = Column("no verdict", "without_verdict", counts)


def robust_and_fragile(rows: Sequence[MethodEvaluation]) -> list[Column]:
    """Accuracy on robust and on fragile labels, with their numbers in the titles."""
    return [
        Column(f"robust % (n {rows[0].robust.n})", "robust", percent),
        Column(f"fragile % (n {rows[0].fragile.n})", "fragile", percent),
    ]


def titled(column: Column, title: str) -> Column:
    """The same column under another title."""
    return dataclasses.replace(column, title=title)


def by_group(groups: Iterable[str], table: Callable[[str], Table]) -> list[Table]:
    """A table a group: of all cases, and then of each scenario under its name."""
    return [
        dataclasses.replace(table(group), caption="" if group == ALL else f"**Scenario {group}**")
        for group in groups
    ]

"""Columns of tables of methods, over rows of :class:`steadyload.runs.evaluation.MethodEvaluation`.

A page picks its columns from these, so that one quantity has one name and one form on all pages.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

from steadyload.escaping import markdown
from steadyload.reports.interactive import CostChart, CostPoint
from steadyload.reports.table import (
    Column,
    Table,
    cell,
    counts,
    factor,
    milliseconds,
    percent,
    words,
)
from steadyload.runs.evaluation import ALL, Evaluation, LabelledPart, MethodEvaluation

METHOD = words("method", "method.title")
N = Column("n", "accuracy.n")
N_SCORED = Column("n", "fully_stable.n")
N_TIMED = Column("n", "cpu.n")
ACCURACY = Column("accuracy %", "accuracy", percent)
STANDS = Column("stands %", "stands", percent)
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
NO_VERDICT = Column("no verdict", "without_verdict", counts, notable=True)

JUDGED = (METHOD, N, ACCURACY, OVER, UNDER)
"""A method, and how often it is right, too late and too early."""

SCORED = (N_SCORED, SCORE, FULLY_STABLE)
"""Scores of a method, which need no labels."""

CASE = (words("layout", form=markdown), words("scenario"), Column("items", "item_count"))
"""Columns that name a case."""


def robust_and_fragile(rows: Sequence[MethodEvaluation]) -> list[Column]:
    """Accuracy on robust and on fragile labels, with their numbers in the titles.

    There are no such columns where no label has an ensemble.
    """
    if not rows[0].robust.n + rows[0].fragile.n:
        return []
    return [
        Column(f"robust % (n {rows[0].robust.n})", "robust", percent),
        Column(f"fragile % (n {rows[0].fragile.n})", "fragile", percent),
    ]


def of_stands(about: LabelledPart) -> list[Column]:
    """Accuracy on labels of the question ``stands``, where there are any."""
    return [STANDS] if about.stands else []


def natural_prevalence(about: LabelledPart) -> list[Column]:
    """Accuracy at the natural share of stable layouts, where that is known."""
    return [NATURAL] if about.natural_stable else []


def stands_explained(about: LabelledPart) -> str:
    """Sentences on the column of the question ``stands``; empty where there is no such column."""
    if not about.stands:
        return ""
    done = about.stands.get("done", 0)
    rest = ", ".join(f"{n} {status}" for status, n in about.stands.items() if status != "done")
    return (
        f" *Stands*: accuracy when the same cases are labelled for another question: does anything "
        f"move too far until everything rests, within 3 s, instead of within 0.3 s? n = {done}"
        f"{f'; {rest}, without such a label, are not counted' if rest else ''}."
    )


def by_spec(title: str, found: Mapping[str, Any], form: Callable[[Any], str] = cell) -> Column:
    """A column of values that stand beside the rows, by the spec of the method."""
    return Column(title, lambda row: found.get(row.method.spec), form)


def titled(column: Column, title: str) -> Column:
    """The same column under another title."""
    return dataclasses.replace(column, title=title)


def by_group(groups: Iterable[str], table: Callable[[str], Table]) -> list[Table]:
    """A table a group: of all cases, and then of each scenario under its name."""
    return [
        dataclasses.replace(table(group), caption="" if group == ALL else f"**Scenario {group}**")
        for group in groups
    ]


def terms_explained(about: LabelledPart) -> str:
    """Sentences on the columns of errors, of robust and fragile labels, and of prevalence."""
    told = (
        "*Overestimated*: the method lets the loading fail later than the label does, or not at "
        "all; *underestimated*: earlier."
    )
    if about.robust + about.fragile:
        told += (
            " A label is *robust* when every judge of the ensemble that was asked again names the "
            "same step, and *fragile* when one does not."
        )
    natural = ", ".join(f"{s} {100 * share:.1f} %" for s, share in about.natural_stable.items())
    if natural:
        told += (
            " *Natural prevalence*: accuracy on stable and on unstable cases, weighted by scenario "
            f"with the share of stable layouts in the whole set ({natural})."
        )
    return told


def best_in_words(methods: Iterable[MethodEvaluation], near: float) -> str:
    """Sentences on the most accurate method, and on the cheapest that is nearly as accurate.

    Args:
        methods: on the same labelled cases.
        near: largest difference to the best accuracy that counts as nearly as accurate.
    """
    rows = list(methods)
    best = max(rows, key=lambda m: m.accuracy.value)
    told = f"The most accurate method is {best.method.title}: {percent(best.accuracy)} %"
    if best.cpu.n:
        told += f" at {milliseconds(best.cpu)} ms of CPU time a layout"
    other = cheapest_near(rows, near)
    if other is None:
        return f"{told}. "
    points = f"{100 * near:g} point{'' if near == 0.01 else 's'}"
    if other is best:
        return f"{told}. No cheaper one is within {points} of it. "
    return (
        f"{told}; the cheapest within {points} of it is {other.method.title}: "
        f"{percent(other.accuracy)} % at {milliseconds(other.cpu)} ms. "
    )


def cheapest_near(methods: Iterable[MethodEvaluation], near: float) -> MethodEvaluation | None:
    """The cheapest method that is nearly as accurate as the best; None where none was timed."""
    rows = list(methods)
    least = max(m.accuracy.value for m in rows) - near
    timed = [m for m in rows if m.accuracy.value >= least and m.cpu.n]
    return min(timed, key=lambda m: m.cpu.value, default=None)


def by_title(found: Evaluation) -> dict[str, Sequence[MethodEvaluation]]:
    """Rows of methods by the title of a group of cases."""
    return {"all scenarios" if g == ALL else g: found.rows[g] for g in found.groups}


def cost_chart(found: Evaluation) -> CostChart:
    """Accuracy against CPU time, a group of cases at a time."""
    return CostChart(
        {
            title: [CostPoint(m.method, m.accuracy, m.cpu) for m in rows]
            for title, rows in by_title(found).items()
        }
    )

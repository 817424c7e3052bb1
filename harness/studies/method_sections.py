"""Columns of tables of methods, over rows of :class:`steadyload.runs.evaluation.MethodEvaluation`.

A page picks its columns from these, so that one quantity has one name and one form on all pages.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from steadyload.reports.columns import columns_of
from steadyload.reports.interactive import CostChart, CostPoint
from steadyload.reports.pages.composing import page_environment
from steadyload.reports.table import Column, cell, percent
from steadyload.runs.evaluation import (
    Evaluation,
    LabelledPart,
    MethodEvaluation,
    cheapest_near,
)

_SHOWN = columns_of(MethodEvaluation)

METHOD = _SHOWN["method"]
N = Column("n", "accuracy.n")
N_TIMED = Column("n", "cpu.n")
ACCURACY = _SHOWN["accuracy"]
STANDS = _SHOWN["stands"]
OVER = _SHOWN["over"]
UNDER = _SHOWN["under"]
STABLE_OR_NOT = _SHOWN["stable_or_not"]
NATURAL = _SHOWN["natural"]
CPU = _SHOWN["cpu"]
WALL = _SHOWN["wall"]
AHEAD = _SHOWN["ahead"]
COST_RATIO = _SHOWN["cost_ratio"]
NO_VERDICT = _SHOWN["without_verdict"]


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


def by_spec(title: str, found: Mapping[str, Any], form: Callable[[Any], str] = cell) -> Column:
    """A column of values that stand beside the rows, by the spec of the method."""
    return Column(title, lambda row: found.get(row.method.spec), form)


def titled(column: Column, title: str) -> Column:
    """The same column under another title."""
    return dataclasses.replace(column, title=title)


def terms_explained(about: LabelledPart) -> str:
    """Sentences on the columns of errors, of robust and fragile labels, and of prevalence."""
    return _said("terms", about)


def best_in_words(methods: Iterable[MethodEvaluation], near: float) -> str:
    """Sentences on the most accurate method, and on the cheapest that is nearly as accurate.

    Args:
        methods: on the same labelled cases.
        near: largest difference to the best accuracy that counts as nearly as accurate.
    """
    rows = list(methods)
    return f"{_said('best', rows, cheapest_near(rows, near), near)} "


def _said(macro: str, *values: Any) -> str:
    """The text of a macro of ``methods.md.j2``."""
    environment = page_environment(Path(__file__).parent, [])
    template = environment.get_template("methods.md.j2")
    return " ".join(getattr(template.module, macro)(*values).split())


def cost_chart(found: Evaluation) -> CostChart:
    """Accuracy against CPU time, a group of cases at a time."""
    return CostChart(
        {
            title: [CostPoint(m.method, m.accuracy, m.cpu) for m in rows]
            for title, rows in found.by_title.items()
        }
    )

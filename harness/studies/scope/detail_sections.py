"""Sections of the page of scopes on every option: paired cost, significance, number of boxes."""

from __future__ import annotations

from steadyload.reports.page import Section
from steadyload.reports.table import (
    Column,
    Table,
    columns_for,
    compact,
    counts,
    factor,
    percent,
    words,
)
from steadyload.studies.scope.summary import ScopeTable

OPTION = words("simulated", "title")
"""The column that names an option."""


def details_section(table: ScopeTable) -> Section:
    """Cost in proportion, and differences in accuracy with their significance."""
    return Section(
        f"Every option, question {table.question}",
        "*CPU, paired*: the median over the "
        "cases of the time over that of the whole pile on the same case. *Body-substeps*: "
        "simulated substeps times boxes that took part, in proportion. *Difference*: accuracy by "
        "the labels of this question minus that of the whole pile, in points; *p*: exact sign-flip "
        "test by item lists, corrected by Holm for the options of this table. "
        f"{table.costs.explained()}",
        [
            Table(
                table.rows,
                [
                    OPTION,
                    Column("n", "same.n"),
                    Column("CPU, paired", "cpu_paired", factor),
                    Column("body-substeps", "body_substeps", compact),
                    Column("difference", "difference", percent),
                    Column("p", "p", _p),
                    Column("accuracy, within %", "within", percent),
                    Column("accuracy, stands %", "stands", percent),
                    words("no verdict", "without_verdict", counts),
                ],
            )
        ],
    )


def boxes_section(table: ScopeTable) -> Section:
    """Verdicts kept and cost by number of boxes."""
    places = range(len(table.whole.sizes))
    boxes = [size.boxes for size in table.whole.sizes]
    return Section(
        f"By number of boxes, question {table.question}",
        "",
        [
            Table(
                table.options,
                [
                    OPTION,
                    *columns_for(
                        places,
                        lambda at: f"{boxes[at]} boxes: same %",
                        lambda row, at: row.sizes[at].same,
                        percent,
                    ),
                    *columns_for(
                        places, lambda at: f"{boxes[at]}: CPU", lambda row, at: row.sizes[at].cpu,
                        compact,
                    ),
                ],
            )
        ],
    )  # fmt: skip


def _p(value: float | None) -> str:
    return "-" if value is None else compact(value) if value >= 1e-4 else "< 0.0001"

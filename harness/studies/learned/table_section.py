"""The part of the page of learned methods that compares them with other methods: Table 5."""

from __future__ import annotations

from steadyload.reports.charts.front import front
from steadyload.reports.pages.page import Picture, Section
from steadyload.reports.table import (
    Column,
    Table,
    columns_for,
    general,
    plain_percent,
    significant,
)
from steadyload.runs.evaluation import ALL
from steadyload.statistics.estimate import Estimate
from steadyload.studies import method_sections as column
from steadyload.studies.learned.summary import MethodTable

_MOST_WALL = 0.4
"""Largest time of a learned method, one layout at a time [ms a layout]."""

_LEAST_RATE = 10_000.0
"""Target rate of a learned method, many layouts at a time [layouts/s]."""


def judge_table(table: MethodTable) -> Section:
    """Section of accuracy, scenario by scenario, and cost."""
    tables = [_accuracies(table, group) for group in table.rows]
    if table.timed:
        tables.append(_times(table))
    if table.batched:
        tables.append(_rates(table))
    timed = (
        f" {table.cost_source.explained()} A case counts with the median of its repeats, a method "
        "with the mean over cases; nothing that a method does once is in them."
    )
    return Section(
        "Beside other methods",
        "\n".join([*_held_bars(table), *_time_bars(table)])
        + "\n\n*Paper*: what Table 5 of the paper prints of the method of that name, on a test set "
        "of its own; its learners may have met the geometries of that set in training."
        f"{timed if table.timed else ''}",
        tables,
        _pictures(table),
    )


def _accuracies(table: MethodTable, group: str) -> Table:
    paper = {spec: row.accuracy.get(group) for spec, row in table.paper.items()}
    columns = [
        column.METHOD,
        column.N,
        column.ACCURACY,
        column.by_spec("paper %", paper, plain_percent),
        column.OVER,
        column.UNDER,
        column.titled(column.AHEAD, f"{table.held.title} minus it"),
        *([column.NO_VERDICT] if group == ALL else []),
    ]
    title = "All scenarios" if group == ALL else f"Scenario {group}"
    return Table(table.rows[group], columns, f"**{title}**")


def _times(table: MethodTable) -> Table:
    size, rate, cpu_rate = (
        {spec: best[place] for spec, best in table.fastest.items()} for place in range(3)
    )
    columns = [
        column.METHOD,
        column.N_TIMED,
        Column("repeats", lambda _: table.repeats),
        column.CPU,
        column.WALL,
        column.by_spec(
            "paper wall ms", {s: r.runtime[ALL] for s, r in table.paper.items()}, general
        ),
        Column("layouts/s one by one", lambda row: f"{1e3 / row.wall.value:.0f}"),
        column.by_spec("best batch", size),
        column.by_spec("layouts/s at that", rate, _whole),
        column.by_spec("layouts per CPU s", cpu_rate, _whole),
    ]
    return Table(table.timed, columns, "**Time**")


def _whole(value: float | None) -> str:
    return significant(value) if value is None else f"{value:.0f}"


def _rates(table: MethodTable) -> Table:
    sizes = sorted({size for found in table.batched.values() for size in found})
    rates = {
        spec: {size: 1e3 / wall for size, (_, wall) in found.items()}
        for spec, found in table.batched.items()
    }
    return Table(
        [row for row in table.timed if row.method.spec in rates],
        [
            column.METHOD,
            column.N_TIMED,
            *columns_for(sizes, "{}", lambda r, size: rates[r.method.spec].get(size), _whole),
        ],
        "**Layouts a second, by the number judged at once**",
    )


def _held_bars(table: MethodTable) -> list[str]:
    """Comparison of the method that all are compared with and the paper's of that name."""
    held = table.held
    if held.spec not in table.paper:
        return []
    told = []
    for group, bar in table.paper[held.spec].accuracy.items():
        if group in table.rows and group != ALL:
            found = next(row.accuracy for row in table.rows[group] if row.method == held)
            reached = "reached" if found.value >= bar else "missed"
            told.append(
                f"{group} {100 * found.value:.1f} % against {100 * bar:.1f} % "
                f"({reached}{_unsure(found, bar)})"
            )
    return [f"- {held.title} beside the paper's: {'; '.join(told)}."]


def _unsure(found: Estimate, bar: float) -> str:
    return ", the interval holds the bar" if found.low < bar < found.high else ""


def _time_bars(table: MethodTable) -> list[str]:
    said = []
    for row in table.timed:
        if row.method.spec not in table.fastest:
            continue
        size, rate, cpu_rate = table.fastest[row.method.spec]
        wall = "at most" if row.wall.value <= _MOST_WALL else "above"
        fast = "at least" if rate >= _LEAST_RATE else "below"
        said.append(
            f"- {row.method.title}: {significant(row.wall.value)} ms a layout one at a time, "
            f"{wall} {_MOST_WALL:g} ms ({significant(row.cpu.value)} ms of CPU time); {rate:.0f} "
            f"layouts/s with {size} at once, {fast} {_LEAST_RATE:.0f} ({cpu_rate:.0f} a second of "
            "CPU time)."
        )
    return said


def _pictures(table: MethodTable) -> list[Picture]:
    if not table.timed:
        return []
    return [
        Picture(
            "learned-table",
            front(table.timed).figure,
            "Accuracy over all scenarios against CPU time a layout, one layout at a time; good "
            "methods stand at the upper left. Bars are 95 % intervals.",
        )
    ]

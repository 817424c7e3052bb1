"""The part of the page of learned judges that holds them against other methods: Table 5."""

from __future__ import annotations

from collections.abc import Sequence

from steadyload.reports.charts import CostPoint, plot_cost_accuracy
from steadyload.reports.page import Picture, Section
from steadyload.reports.table import (
    MISSING,
    markdown_table,
    names,
    percent,
    significant,
)
from steadyload.runs.evaluation import ALL, MethodEvaluation
from steadyload.statistics.estimate import Estimate
from steadyload.studies.learned.records import BatchTimes, JudgeTable

_MOST_WALL = 0.4
"""ms a layout that a learned judge may take, one at a time."""

_LEAST_RATE = 10_000.0
"""Layouts a second that it is to judge, many at a time."""


def judge_table(table: JudgeTable, scenarios: Sequence[str]) -> Section:
    """What methods say, scenario by scenario, and what they cost."""
    parts = [ALL, *scenarios]
    tables = [f"**{_part_title(part)}**\n\n{_accuracies(table, part)}" for part in parts]
    if table.times:
        tables.append(f"**Time**\n\n{_times(table)}")
    if any(row.batched for row in table.times):
        tables.append(f"**Layouts a second, by the number judged at once**\n\n{_rates(table)}")
    return Section(
        "Beside other methods",
        "\n".join([*_held_bars(table, scenarios), *_time_bars(table.times)])
        + "\n\n*Paper*: what Table 5 of the paper prints of the method of that name, on a test set "
        "of its own; its learners may have met the geometries of that set in training. "
        f"{_how_timed(table)}",
        tables,
        _pictures(table),
    )


def _part_title(part: str) -> str:
    return "All scenarios" if part == ALL else f"Scenario {part}"


def _accuracies(table: JudgeTable, part: str) -> str:
    header = (
        "method", "n", "accuracy %", "paper %", "overestimated %", "underestimated %",
        f"{table.held.title} minus it", *(("no verdict",) if part == ALL else ()),
    )  # fmt: skip
    return markdown_table(
        header,
        [
            (
                row.method.title,
                str(row.accuracy.n),
                percent(row.accuracy),
                _printed(table, row, part),
                percent(row.over),
                percent(row.under),
                percent(row.ahead),
                *((_without(row),) if part == ALL else ()),
            )
            for row in table.rows[part]
        ],
    )


def _printed(table: JudgeTable, row: MethodEvaluation, part: str) -> str:
    """The accuracy that the paper prints of the method of that name."""
    printed = table.paper.get(row.method.spec)
    if printed is None or part not in printed.accuracy:
        return MISSING
    return f"{100 * printed.accuracy[part]:.1f}"


def _without(row: MethodEvaluation) -> str:
    return names(f"{count} {status}" for status, count in row.without_verdict.items())


def _times(table: JudgeTable) -> str:
    header = (
        "method", "n", "repeats", "CPU ms", "wall ms", "paper wall ms",
        "layouts/s one by one", "best batch", "layouts/s at that", "layouts per CPU s",
    )  # fmt: skip
    paper = {spec: row.runtime[ALL] for spec, row in table.paper.items()}
    rows = []
    for row in table.times:
        size, rate, cpu_rate = _best(row)
        rows.append(
            (
                row.method.title,
                str(row.layouts),
                str(row.repeats),
                significant(row.cpu),
                significant(row.wall),
                _of_paper(paper.get(row.method.spec)),
                f"{1e3 / row.wall:.0f}",
                str(size) if size else MISSING,
                f"{rate:.0f}" if size else MISSING,
                f"{cpu_rate:.0f}" if size else MISSING,
            )
        )
    return markdown_table(header, rows)


def _of_paper(wall: float | None) -> str:
    return MISSING if wall is None else f"{wall:g}"


def _rates(table: JudgeTable) -> str:
    shown = [row for row in table.times if row.batched]
    sizes = sorted({size for row in shown for size in row.batched})
    return markdown_table(
        ("method", "n", *map(str, sizes)),
        [
            (
                row.method.title,
                str(row.layouts),
                *(f"{1e3 / row.batched[s][1]:.0f}" if s in row.batched else MISSING for s in sizes),
            )
            for row in shown
        ],
    )


def _best(row: BatchTimes) -> tuple[int, float, float]:
    """The number of layouts at once that takes the least CPU time, which others at work on the
    machine disturb the least, and layouts a second of wall and CPU time.

    All 0 where a method knows no batches.
    """
    if not row.batched:
        return 0, 0.0, 0.0
    size, (cpu, wall) = min(row.batched.items(), key=lambda pair: pair[1][0])
    return size, 1e3 / wall, 1e3 / cpu


def _held_bars(table: JudgeTable, scenarios: Sequence[str]) -> list[str]:
    """Whether the method that all are held against is as good as the paper's of that name."""
    held = table.held
    if held.spec not in table.paper:
        return []
    told = []
    for scenario in scenarios:
        bar = table.paper[held.spec].accuracy.get(scenario)
        if bar is not None:
            row = next(row for row in table.rows[scenario] if row.method == held)
            reached = "reached" if row.accuracy.value >= bar else "missed"
            told.append(
                f"{scenario} {100 * row.accuracy.value:.1f} % against {100 * bar:.1f} % "
                f"({reached}{_unsure(row.accuracy, bar)})"
            )
    return [f"- {held.title} beside the paper's: {'; '.join(told)}."]


def _unsure(found: Estimate, bar: float) -> str:
    return ", the interval holds the bar" if found.low < bar < found.high else ""


def _time_bars(times: Sequence[BatchTimes]) -> list[str]:
    said = []
    for row in times:
        size, rate, cpu_rate = _best(row)
        if not size:
            continue
        wall = "at most" if row.wall <= _MOST_WALL else "above"
        fast = "at least" if rate >= _LEAST_RATE else "below"
        said.append(
            f"- {row.method.title}: {significant(row.wall)} ms a layout one at a time, {wall} "
            f"{_MOST_WALL:g} ms ({significant(row.cpu)} ms of CPU time); {rate:.0f} layouts/s with "
            f"{size} at once, {fast} {_LEAST_RATE:.0f} ({cpu_rate:.0f} a second of CPU time)."
        )
    return said


def _how_timed(table: JudgeTable) -> str:
    if not table.times:
        return ""
    return (
        f"{table.cost_source.explained()} Times are medians over the repeats; nothing that a "
        "method does once is in them."
    )


def _pictures(table: JudgeTable) -> list[Picture]:
    times = {row.method.spec: row for row in table.times}
    points = [
        CostPoint(row.method, row.accuracy, _point(times[row.method.spec]))
        for row in table.rows[ALL]
        if row.method.spec in times
    ]
    if not points:
        return []
    return [
        Picture(
            "learned-table",
            plot_cost_accuracy(points),
            "Accuracy over all scenarios against CPU time a layout, one layout at a time; good "
            "methods stand at the upper left. Bars are 95 % intervals of the accuracy.",
        )
    ]


def _point(row: BatchTimes) -> Estimate:
    return Estimate(row.cpu, row.cpu, row.cpu, row.layouts)

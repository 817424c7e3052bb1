"""The page of scopes: verdicts that change and cost that is saved, and the steps that balance."""

from __future__ import annotations

from collections.abc import Sequence

from steadyload.escaping import markdown
from steadyload.layouts.question import Question
from steadyload.reports.charts.change import change
from steadyload.reports.page import Page, Picture, Section
from steadyload.reports.table import (
    Column,
    Table,
    compact,
    factor,
    names,
    percent,
    significant,
    words,
)
from steadyload.studies.scope.balanced_steps import Balance, BalancedSteps
from steadyload.studies.scope.detail_sections import OPTION, boxes_section, details_section
from steadyload.studies.scope.study import ScopeResult
from steadyload.studies.scope.summary import KEPT, OptionRow, ScopeTable

_ASKED = {
    Question.WITHIN: "Does anything move too far within 0.3 s (`question=within`)?",
    Question.STANDS: "Does the load stand (`question=stands`)?",
}
_BALANCE = {
    Balance.BALANCES: "balances with 0.1 mm to spare",
    Balance.NARROW: "within 0.1 mm of losing balance",
    Balance.OUT: "out of balance by 0.1 mm or more",
}
_STEPS = (
    words("step", lambda row: _BALANCE[row.balance]),
    Column("steps", "steps"),
    Column("cases", "cases"),
    Column("moved by half a threshold %", "far", percent),
    Column("moved too far %", "too_far", percent),
    Column("farthest", "most", compact),
)


def scope_page(result: ScopeResult) -> Page:
    """Compose the page."""
    tables = list(result.tables.values())
    sections = [
        *(_front(table) for table in tables),
        _balanced(result.steps),
        _figure(tables),
        *(details_section(table) for table in tables),
        *(boxes_section(table) for table in tables),
        _depends(result),
    ]
    return Page(
        "Simulations of only what a step changes",
        f"{_saved(tables)} {_certified(result.steps)}",
        sections,
        _made_with(tables),
    )


def _made_with(tables: Sequence[ScopeTable]) -> dict[str, str]:
    """Provenance of the runs: that of the first, with what differs between questions."""
    differ = ("labels", "rows", "started", "finished")
    shared = {k: v for k, v in tables[0].manifest.items() if k not in differ}
    own = {f"{k}, {table.question}": table.manifest[k] for table in tables for k in differ}
    return own | shared


def _saved(tables: Sequence[ScopeTable]) -> str:
    """The first sentence: by question, the cheapest option that keeps nearly all verdicts."""
    return (
        f"Of what can be left out, the cheapest that keeps at least {100.0 * KEPT:g} % of the "
        f"verdicts of the whole pile is {' and '.join(map(_cheapest, tables))}."
    )


def _cheapest(table: ScopeTable) -> str:
    row = table.cheapest
    asked = f"for `question={table.question}`"
    if row is not None:
        return f"{row.title} {asked} ({_kept(row)})"
    most = max(table.options, key=lambda option: option.same.value)
    lost = sum(table.whole.without_verdict.values())
    left_out = f", and {lost} without a verdict on the whole pile" if lost else ""
    return f"none {asked}, where {most.title} keeps most ({_kept(most)}{left_out})"


def _kept(row: OptionRow) -> str:
    return (
        f"{100.0 * row.same.value:.1f} % at {compact(row.cpu_total.value)} of its CPU time, "
        f"n = {row.same.n}"
    )


def _certified(steps: BalancedSteps) -> str:
    """The second sentence: what a step that balances needs."""
    row = steps.of(Balance.BALANCES)
    moved_far = round(row.far.value * row.steps) if row.steps else 0
    return (
        f"{moved_far or 'None'} of {row.steps:,} steps that balance with 0.1 mm to spare, as do "
        "all before them, moved anything by more than half a threshold (the farthest by "
        f"{compact(row.most)} of one), as seen by the simulation that screens labels; the "
        f"reference was asked about {row.asked:,} of them. Such a step needs no simulation, and "
        "balance costs microseconds ([speed](../speed/report.md))."
    )


def _front(table: ScopeTable) -> Section:
    whole = table.whole
    return Section(
        _ASKED[table.question],
        f"{table.cases} cases, {table.layouts} layouts of {table.instances} item lists. *Same*: "
        "the status and failing step of the whole pile; *earlier*, *later*, *none*: cases in which "
        "an option fails earlier or later than that, or has no verdict. *Accuracy*: by the labels "
        "of this question. *CPU, median*: median time of a case over that of the whole pile, "
        f"{significant(whole.milliseconds)} ms; *CPU, all*: time of all cases over that of the "
        "whole pile.",
        [
            Table(
                table.rows,
                [
                    OPTION,
                    Column("same %", lambda row: row.same if row.p is not None else None, percent),
                    Column("earlier / later / none", _changes),
                    Column("accuracy %", "accuracy", percent),
                    Column("CPU, median", "cpu", compact),
                    Column("CPU, all", "cpu_total", factor),
                ],
            )
        ],
    )


def _changes(row: OptionRow) -> str:
    return f"{row.earlier} / {row.later} / {sum(row.without_verdict.values())}"


def _balanced(steps: BalancedSteps) -> Section:
    known = steps.of(Balance.BALANCES)
    within, stands = (steps.failing[str(question)] for question in Question)
    tables: list[Table | str] = [
        Table(steps.first, _STEPS, "Steps before which every step of the case balances:"),
        Table(
            steps.later,
            _STEPS,
            "Steps after one that does not balance so: every step begins with all items in their "
            "planned positions, so that what lost its balance earlier moves again, beside whatever "
            "was placed last. Of those that balance and at which something moved by half a "
            f"threshold, it is in {steps.again[0]} of {steps.again[1]} the item that moved most at "
            "an earlier step, too, that does not balance:",
        ),
    ]
    if steps.exceptions:
        tables.append(
            Table(
                steps.exceptions,
                [
                    words("layout", "layout", markdown), words("scenario"), Column("step"),
                    Column("margin cm", "margin"), Column("item"),
                    Column("screen", "screen", compact), Column("reference", "reference", compact),
                ],
                "Steps of the first line of the first table at which something moved by more than "
                "half a threshold:",
            )
        )  # fmt: skip
    return Section(
        "Steps that balance need no simulation",
        f"All {steps.steps:,} steps of the {steps.cases} labelled cases of the set, of "
        f"{steps.instances} item lists, in whatever split. A step balances with 0.1 mm to spare "
        "when forces that only press, on contact patches drawn in by 0.1 mm on every side, hold "
        "all items that are joined to the new one by standing on each other "
        "(`equilibrium:margin=0.01`). How far something moved is what a simulation by MuJoCo at "
        "1 kHz saw of every step, or the reference where it was asked and saw more, at any look "
        "until all rested, at most 3 s; of steps after the first at which a load does not stand, "
        f"within 0.3 s. The reference was asked about {known.asked:,} steps of the first line, "
        "most of them drawn at random, and saw nothing move by more than "
        f"{compact(known.most_by_reference)} of a threshold. *Farthest* is in thresholds. "
        "Intervals count item lists, as if all steps of one were a single observation. "
        f"{steps.whole} cases balance at every step: by the labels {within} of them fail within "
        f"0.3 s, and {stands} do not stand.",
        tables,
    )


def _figure(tables: list[ScopeTable]) -> Section:
    return Section(
        "Verdicts that change, and cost",
        "",
        (),
        [
            Picture(
                "changed_verdicts",
                change(
                    tables,
                    "cpu_total",
                    "changed",
                    within="options",
                    panel="question",
                    panel_title="question {}",
                    x_label="CPU time of all cases over that of the whole pile",
                    y_label="changed verdicts (% of cases)",
                ).figure,
                "Share of verdicts that differ from those of the whole pile against CPU time in "
                "proportion; good options stand at the lower left. Bars are 95 % intervals, "
                "colour tells the option, marker the engine, the dashed line is the cost of the "
                "whole pile.",
            )
        ],
    )


def _depends(result: ScopeResult) -> Section:
    asked = result.asked
    drawn = names(f"{source} {count}" for source, count in result.sources.items())
    least, most = result.boxes
    return Section(
        "What these numbers depend on",
        f"**Cases.** Drawn of train and validation of a labelled set of real size, in turns over "
        f"sources and scenarios by rank: {drawn}; {least} to {most} boxes (at most "
        f"{asked.most_items} were allowed). Larger piles were not asked here.\n\n"
        "**Whole pile.** `label@mujoco`: every placement afresh, all items, 480 substeps a second, "
        "0.3 s, or 3 s for `stands`. An option may be right where the whole pile is wrong: "
        "accuracies are by the labels.\n\n"
        f"**Labels.** `{result.label or 'not stated'}` where it was asked, and "
        f"`{result.screen or 'not stated'}` elsewhere (docs/benchmark.md), which is near to what "
        "is measured here: accuracies of other engines are held to a harder standard.\n\n"
        f"**Limit.** A verdict may take {asked.seconds:g} s; cases in which the whole "
        "pile has no verdict but `unsettled` are left out of *same*.",
    )

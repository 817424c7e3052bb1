"""The page of speed: what a judgement costs, and how that grows with the number of items."""

from __future__ import annotations

from typing import Any

from steadyload.reports.pages.page import Page, Section
from steadyload.reports.table import (
    MISSING,
    Column,
    Table,
    milliseconds,
    percent,
    words,
)
from steadyload.runs.costs import load_explained
from steadyload.studies.speed.growth_section import growth_sections, title
from steadyload.studies.speed.measuring import ENOUGH, POSITIONS
from steadyload.studies.speed.records import CaseSet, Cost, Kind, SpeedRun
from steadyload.studies.speed.scenes import LABELLED


def speed_page(run: SpeedRun) -> Page:
    """Compose the page of what was measured."""
    sections = [
        _judgements(run),
        *_positions(run),
        *_steps(run),
        *growth_sections(run),
    ]
    return Page(
        "What a judgement costs",
        _summary(run),
        [*sections, _method(run)],
        {**run.made_with, "processor": run.machine},
    )


def _specs(run: SpeedRun) -> list[str]:
    return list(dict.fromkeys(c.method for c in run.costs if c.method))


def _summary(run: SpeedRun) -> str:
    labelled = run.cases[0]
    told = []
    for spec in _specs(run):
        cost = run.cost(labelled.name, Kind.JUDGE, spec)
        if cost is not None:
            told.append(f"{title(spec)} {milliseconds(cost.microseconds)} us")
    empty, loop = run.cost(labelled.name, Kind.EMPTY), run.cost(labelled.name, Kind.LOOP)
    assert empty is not None
    assert loop is not None
    how = "compiled and warm" if run.compiled else "**not compiled**"
    return (
        f"A judgement takes, on {run.machine}, one core, {how}: {', '.join(told)} "
        f"(`judge`, n = {labelled.layouts} labelled cases of {labelled.mean_items:.1f} items in "
        f"the mean). Of that an empty verdict, with its stopwatch, takes "
        f"{milliseconds(empty.microseconds)} us, and the loop over the layouts "
        f"{milliseconds(loop.microseconds)} us. CPU times are medians of "
        f"{empty.microseconds.n} repeats, fewer of what takes seconds, in turns in one process; "
        f"brackets hold the 95 % interval of the median over repeats, their range where there are "
        f"fewer than six."
        + (" **A quick run: few layouts and repeats.**" if run.quick else "")
        + load_explained(run.load)
    )


def _judgements(run: SpeedRun) -> Section:
    return Section(
        "One judgement, many at once, and placements",
        "*Judge*: layouts one by one, each verdict with its times. *Batch*: all layouts at once by "
        "`evaluate`, in compiled code, one core. *Placement*: `try_place` in a session, of all "
        "items of a layout up to the first that fails. A judgement ends at the first step that is "
        "not stable.",
        [table for cases in run.cases for table in _tables(run, cases)],
    )


def _tables(run: SpeedRun, cases: CaseSet) -> list[Table | str]:
    def column(heading: str, kind: Kind, form: Any) -> Column:
        return Column(heading, lambda spec: form(run.cost(cases.name, kind, spec)))

    def count(kind: Kind) -> Any:
        return lambda spec: getattr(run.cost(cases.name, kind, spec), "count", None)

    bare = [
        (named, run.cost(cases.name, kind))
        for named, kind in (("the loop", Kind.LOOP), ("an empty verdict", Kind.EMPTY))
    ]
    told = ", ".join(f"{name} {_microseconds(cost)} us" for name, cost in bare)
    columns = [
        words("method", title),
        Column("n", count(Kind.JUDGE)),
        column("judge, us", Kind.JUDGE, _microseconds),
        column("batch, layouts/s", Kind.BATCH, _rate),
        Column("placements", count(Kind.PLACE)),
        column("placement, us", Kind.PLACE, _microseconds),
    ]
    caption = (
        f"**{_named(cases)}**: {cases.layouts} layouts, {cases.mean_items:.1f} items in the mean. "
        f"Without a judgement: {told}."
    )
    late = [c for c in run.costs if c.cases == cases.name and c.kind is Kind.JUDGE and c.missing]
    notes = [
        f"{title(c.method)}: {c.missing} of {c.count + c.missing} layouts had no verdict within "
        f"{run.patience:g} s and are left out."
        for c in late
    ]
    return [Table(_specs(run), columns, caption), *notes]


def _named(cases: CaseSet) -> str:
    return "Labelled set, validation" if cases.name == LABELLED else f"File `{cases.name}`"


def _microseconds(cost: Cost | None) -> str:
    return MISSING if cost is None else milliseconds(cost.microseconds)


def _rate(cost: Cost | None) -> str:
    """Layouts a second with the interval, in whole thousands where they are many."""
    if cost is None:
        return MISSING
    e = cost.microseconds
    rates = (1e6 / e.value, 1e6 / e.high, 1e6 / e.low)
    value, low, high = (f"{float(f'{rate:.2e}'):,.0f}" for rate in rates)
    return f"{value} [{low}, {high}]"


def _positions(run: SpeedRun) -> list[Section]:
    rows = [cost for cost in run.costs if cost.kind is Kind.FEASIBLE]
    if not rows:
        return []
    columns = [
        words("cases", "cases"),
        words("method", lambda cost: title(cost.method)),
        Column("positions", "count"),
        Column("us a position", _microseconds_of),
    ]
    return [
        Section(
            "Many positions of one item",
            f"`feasible` in a session that holds all items but the last of the largest layout that "
            f"is stable, for {POSITIONS:,} positions of that item, drawn at random over the deck, "
            "each on the highest top below it; in one compiled call.",
            [Table(rows, columns)],
        )
    ]


def _steps(run: SpeedRun) -> list[Section]:
    if not run.steps:
        return []
    columns = [
        words("cases", "cases"),
        words("method", lambda row: title(row.method)),
        Column("steps"),
        Column("kept %", "kept", percent),
        Column("asked %", "asked", percent),
    ]
    return [
        Section(
            "Steps kept and asked",
            "*Kept*: the forces found before balance the new item, too. *Asked*: the model of "
            "motion says how far items get. Brackets hold 95 % intervals over layouts.",
            [Table(run.steps, columns)],
        )
    ]


def _microseconds_of(cost: Cost) -> str:
    return milliseconds(cost.microseconds)


def _method(run: SpeedRun) -> Section:
    return Section(
        "How it is measured",
        "All work is done once before, and then in turns, the first one changing from repeat to "
        "repeat, in one process and one thread: code is compiled or loaded, and layouts have their "
        "arrays. A repeat is all layouts; short work is repeated for 2 ms at least, and work "
        f"that has taken {ENOUGH:g} s is not repeated again. A method that would take more than "
        "10 s for the layouts of a set is measured on every tenth. Numbers depend on the processor "
        "and on what else runs: compare ratios within one run."
        + ("" if run.compiled else " Numba's compilation was switched off."),
    )

"""The page of precision: what few digits cost, and what a contact model costs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from steadyload.properties.closed_form_tests import ClosedFormResult, closed_form_tests
from steadyload.reports.pages.page import Page, Picture, Section
from steadyload.reports.table import (
    MISSING,
    Column,
    Table,
    columns_for,
    compact,
    names,
    percent,
    words,
)
from steadyload.studies.precision.changes import DISTANCES, SCALES, Change
from steadyload.studies.precision.figures import plot_turned
from steadyload.studies.precision.sizes import EDGES, FREQUENCY, TESTS
from steadyload.studies.precision.summary import ALL, EngineRow


def precision_page(
    rows: Sequence[EngineRow],
    cases: int,
    item_lists: int,
    sizes: Mapping[tuple[str, str, float], ClosedFormResult],
    made_with: Mapping[str, str],
) -> Page:
    """Compose the page."""
    return Page(
        "What single precision costs",
        f"{_answer(rows)} {_advice(rows)}\n\n{cases} cases of {item_lists} item lists are judged "
        "with the label's own protocol at 480 Hz on every engine, as they are, moved over the "
        "floor, and made larger or smaller (with times multiplied by the root of the factor). In "
        "exact mechanics no verdict changes by any of that. A moved layout is the same to an "
        "engine but for the digits of its coordinates: what is turned is turned by precision. A "
        "layout of another size keeps all its digits: what is turned is turned by lengths, speeds "
        "and times that are fixed within an engine's contact model. Engines of double precision "
        "with the same settings stand beside. Brackets hold 95 % intervals, of item lists drawn "
        "anew.",
        [_turned(rows), _sizes(sizes), _accuracy(rows), _outside()],
        dict(made_with),
    )


def _answer(rows: Sequence[EngineRow]) -> str:
    single = [row for row in rows if row.single and row.excess]
    if not single:
        return "No engine of single precision is installed here beside one of double precision."
    near, far = DISTANCES[0], DISTANCES[-1]
    by_size = max(SCALES, key=lambda change: max(row.excess[change].value for row in single))
    return (
        f"{' '.join(_of_distance(row, near, far) for row in single)} "
        f"What a contact model costs shows where a load is {by_size.name}: "
        f"{names([_more(row, by_size) for row in single])} points more."
    )


def _of_distance(row: EngineRow, near: Change, far: Change) -> str:
    found = [row.excess[change] for change in DISTANCES]
    said = (
        f"On {row.engine} {percent(row.excess[far])} points more verdicts are turned than in "
        f"double precision where a load is {far.name} from the origin of a world, and "
        f"{percent(row.excess[near])} where it is {near.name}"
    )
    if all(excess.low <= 0.0 for excess in found):
        return f"{said}: no cost of its single precision was seen."
    if found[-1].low > found[0].value:
        return f"{said}: its digits run out with distance."
    return f"{said}: it is more sensitive to any rounding, wherever the load lies."


def _more(row: EngineRow, change: Change) -> str:
    return f"{percent(row.excess[change])} ({row.engine})"


def _advice(rows: Sequence[EngineRow]) -> str:
    right = names([f"{percent(row.accuracy[ALL][ALL])} % ({row.engine})" for row in rows])
    return (
        "Who simulates in single precision, as on a GPU, does well to place each load at an origin "
        "of its own, and to choose the unit of length so that boxes are as large as the engine's "
        f"authors had in mind. As they are, cases are judged as labelled on {right}."
    )


def _turned(rows: Sequence[EngineRow]) -> Section:
    def column(change: Change) -> Column:
        return Column(f"{change.name} %", lambda row: row.turned[change], percent)

    def more(change: Change) -> Column:
        return Column(
            f"{change.name}, more", lambda row: row.excess.get(change), percent, alike=True
        )

    kind = words("precision", lambda row: "single" if row.single else "double")
    return Section(
        "Verdicts turned by distance and by size",
        "*Turned*: another failing step than the same engine names for the layout as it is, or "
        "none. Some cases are so near to falling that any rounding turns them, in double "
        "precision, too; *more*: the share beyond the mean of those of double precision, in "
        "points, on the same cases.",
        [
            Table(rows, [words("engine"), kind, *map(column, DISTANCES)]),
            Table(rows, [words("engine"), kind, *map(column, SCALES)]),
            Table(
                [row for row in rows if row.single],
                [words("engine"), *map(more, (*DISTANCES, *SCALES))],
            ),
        ],
        [
            Picture(
                "turned",
                plot_turned(rows),
                "Share of verdicts that are turned; solid: single precision, dashed: double.",
            )
        ],
    )


def _sizes(found: Mapping[tuple[str, str, float], ClosedFormResult]) -> Section:
    units = {test.name: test.error_unit for test in closed_form_tests()}
    engines = list(dict.fromkeys(engine for _, engine, _ in found))

    def error(row: tuple[str, float], engine: str) -> str:
        result = found[row[0], engine, row[1]]
        return compact(result.error) if result.error is not None else result.note or MISSING

    rows = [(test, edge) for test in TESTS for edge in EDGES]
    columns = [
        words("test", 0),
        words("in", lambda row: units[row[0]]),
        Column("edge, m", 1, "{:g}".format),
        *columns_for(engines, "{}", error),
    ]
    return Section(
        "Closed forms at three sizes",
        f"Errors of tests of [closed forms](../closed_forms/report.md) at {FREQUENCY} substeps a "
        "second, with cubes of 0.1, 1 and 10 m. Lengths grow by a factor and times by its root, "
        "and errors are told in the lengths of the smallest, so that exact mechanics gives the "
        "same number at each size: what changes from row to row comes from lengths, speeds and "
        "times that are fixed within an engine, or from digits. A tipping offset below 0 means "
        "that a box tips too early.",
        [Table(rows, columns)],
    )


def _accuracy(rows: Sequence[EngineRow]) -> Section:
    def column(kind: str, group: str) -> Column:
        return Column(f"{group} %", lambda row: row.accuracy[kind][group], percent)

    def table(kind: str) -> Table:
        columns = [column(kind, group) for group in rows[0].accuracy[kind]]
        return Table(rows, [words("engine"), *columns], "" if kind == ALL else f"**By {kind}**")

    return Section(
        "Accuracy by size and height of the load, and by mass ratio",
        "Share of cases, as they are, whose failing step is the label's. Height: of a whole load. "
        "Masses: the heaviest item of a load over the lightest.",
        [table(kind) for kind in rows[0].accuracy],
    )


def _outside() -> Section:
    return Section(
        "What was not measured",
        "Engines on a GPU, such as MuJoCo Warp, were not measured. They compute in "
        "single precision, as the engines above do on the CPU. That an engine holds a box that "
        "stands on its edge ([Rapier, issue 934](https://github.com/dimforge/rapier/issues/934)) "
        "is looked at by a conformance check of every adapter: a tenth of a degree from its "
        "balance it has to fall at the rate of an upright pendulum, to 10 %.",
    )

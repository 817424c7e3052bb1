"""The page of precision: what few digits cost, and what a contact model costs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from steadyload.reports.page import Page, Picture, Section
from steadyload.reports.table import Column, Table, names, percent, words
from steadyload.studies.precision.changes import DISTANCES, SCALES, Change
from steadyload.studies.precision.figures import plot_turned
from steadyload.studies.precision.summary import ALL, EngineRow

_HARMLESS = 0.01
"""Share of turned verdicts up to which a distance counts as harmless."""


def precision_page(
    rows: Sequence[EngineRow], cases: int, item_lists: int, made_with: Mapping[str, str]
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
        [_turned(rows), _accuracy(rows), _outside()],
        dict(made_with),
    )


def _answer(rows: Sequence[EngineRow]) -> str:
    far = DISTANCES[-1]
    single = [row for row in rows if row.single]
    double = [row for row in rows if not row.single]
    if not single:
        return "No engine of single precision is installed here."
    by_size = max(SCALES, key=lambda change: max(row.turned[change].value for row in single))
    return (
        f"Single precision by itself turns {_list(single, far)} of verdicts {far.moved:g} m from "
        f"the origin of a world ({_list(double, far)} in double precision); a contact model turns "
        f"{_list(single, by_size)} where the same load is {by_size.name} "
        f"({_list(double, by_size)})."
    )


def _list(rows: Sequence[EngineRow], change: Change) -> str:
    return names([f"{percent(row.turned[change])} % ({row.engine})" for row in rows]) or "none"


def _advice(rows: Sequence[EngineRow]) -> str:
    single = [row for row in rows if row.single]
    if not single:
        return ""
    harmless = [
        change.moved
        for change in DISTANCES
        if all(row.turned[change].value <= _HARMLESS for row in single)
    ]
    keep = (
        f"Who simulates on a GPU, in single precision, loses at most {100 * _HARMLESS:g} % of "
        f"verdicts up to {max(harmless):g} m from the origin, and need only place each load near "
        "an origin of its own."
        if harmless
        else "Who simulates on a GPU, in single precision, must place each load at an origin of "
        f"its own: already {DISTANCES[0].moved:g} m away more than {100 * _HARMLESS:g} % of "
        "verdicts are turned."
    )
    right = names([f"{percent(row.accuracy[ALL][ALL])} % ({row.engine})" for row in rows])
    return f"{keep} There the engines name the label's failing step on {right}."


def _turned(rows: Sequence[EngineRow]) -> Section:
    def column(change: Change) -> Column:
        return Column(f"{change.name} %", lambda row: row.turned[change], percent)

    kind = words("precision", lambda row: "single" if row.single else "double")
    return Section(
        "Verdicts turned by distance and by size",
        "*Turned*: another failing step than the same engine names for the layout as it is, or no "
        "verdict.",
        [
            Table(rows, [words("engine"), kind, *map(column, DISTANCES)]),
            Table(rows, [words("engine"), kind, *map(column, SCALES)]),
        ],
        [
            Picture(
                "turned",
                plot_turned(rows),
                "Share of verdicts that are turned; solid: single precision, dashed: double.",
            )
        ],
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
        "Engines on a GPU, such as MuJoCo Warp, were not run: no GPU was at hand. They compute in "
        "single precision, as the engines above do on the CPU.",
    )

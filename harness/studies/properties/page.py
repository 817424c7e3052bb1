"""The page of property tests: a matrix, and every counterexample as table, picture and file."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import PurePosixPath

from steadyload.methods.naming import MethodKey
from steadyload.reports.charts.scene import scene
from steadyload.reports.pages.page import Page, Picture, Section
from steadyload.reports.table import (
    MISSING,
    Column,
    Table,
    columns_for,
    general,
    names,
    percent,
    words,
)
from steadyload.studies.properties.study import ENOUGH, PropertyRow, PropertyTable, Standing

_SIGNS = {
    Standing.HOLDS: "holds",
    Standing.TOO_FEW: "too few",
    Standing.FINDING: "**finding**",
    Standing.VIOLATED: "**violated**",
    Standing.NOT_ASKED: MISSING,
}


def _lengths(three: Sequence[float]) -> str:
    return ", ".join(map(general, three))


_ITEMS = (
    words("item", 0),
    Column("x, y, z (cm)", lambda row: row[1].position, _lengths),
    Column("width, height, depth (cm)", lambda row: row[1].size, _lengths),
    Column("offset x, y, z (cm)", lambda row: row[1].mass_offset, _lengths),
    Column("kg", lambda row: row[1].weight, general),
)
"""Columns of numbered items."""


def properties_page(found: PropertyTable, manifest: Mapping[str, str]) -> Page:
    """Compose the page of a run of property tests."""
    counts = dict.fromkeys(Standing, 0)
    for row in found.rows:
        counts[row.standing] += 1
    examples = sum(row.examples for row in found.rows)
    summary = (
        f"{_answer(found)}Properties: {len(found.about)}; methods: {len(found.methods)}; "
        f"pairs that hold: {counts[Standing.HOLDS]}, declared findings: "
        f"{counts[Standing.FINDING]}, violated: {counts[Standing.VIOLATED]}, "
        f"with too few cases to say: {counts[Standing.TOO_FEW]}, on {examples} cases in all. "
        "A property is asked only of methods that declare what it is about; a case is drawn at "
        "random within the range that the method declares, built so that it can be loaded, and "
        "one that violates a property is made as small as it gets."
    )
    refused = sum(row.refused for row in found.rows)
    if refused:
        summary += (
            f" Not asked, and no violation: {refused} cases outside the range that a method "
            "declares, which it refused."
        )
    return Page("Property tests", summary, property_sections(found), manifest)


def _answer(found: PropertyTable) -> str:
    """Sentences on the methods of which all holds, and on what does not hold of the others."""
    against = {
        standing: [row for row in found.rows if row.standing is standing]
        for standing in (Standing.VIOLATED, Standing.FINDING)
    }
    unsound = {row.method for rows in against.values() for row in rows}
    said = [
        "All properties that they were asked hold of "
        f"{len(found.methods) - len(unsound)} of {len(found.methods)} methods, each on up to "
        f"{max((row.examples for row in found.rows), default=0)} cases."
    ]
    for standing, heading in (
        (Standing.VIOLATED, "Violated"),
        (Standing.FINDING, "Known not to hold, declared with a reason"),
    ):
        by_property: dict[str, list[str]] = {}
        for row in against[standing]:
            by_property.setdefault(row.property, []).append(row.method.title)
        if by_property:
            listed = "; ".join(f"*{name}* of {names(of)}" for name, of in by_property.items())
            said.append(f"{heading}: {listed}.")
    return " ".join(said) + "\n\n"


def property_sections(found: PropertyTable) -> list[Section]:
    """Methods, counterexamples, all pairs, and the properties in words; for any page."""
    failing = [row for row in found.rows if row.smallest is not None or row.why]
    return [
        _by_method(found),
        *([_counted(failing)] if failing else []),
        *(_counterexample(row) for row in failing),
        _pairs(found),
        _in_words(found),
    ]


def _by_method(found: PropertyTable) -> Section:
    own = {method: [row for row in found.rows if row.method == method] for method in found.methods}

    def named(standing: Standing) -> Callable[[MethodKey], Iterable[str]]:
        return lambda method: [row.property for row in own[method] if row.standing is standing]

    columns = [
        words("method", "title"),
        Column("holds", lambda method: len(list(named(Standing.HOLDS)(method)))),
        words("violated", named(Standing.VIOLATED), names),
        words("declared finding", named(Standing.FINDING), names),
        words("too few cases", named(Standing.TOO_FEW), names),
        Column("refused", lambda method: f"{sum(row.refused for row in own[method])} of "
               f"{sum(row.examples for row in own[method])}"),
    ]  # fmt: skip
    text = (
        "Number of properties that hold, and the names of those that do not. *Refused*: cases that "
        "the method refused, which test nothing. *Too few cases*: without a violation, but tested "
        f"by less than {100.0 * ENOUGH:g} % of the cases tried."
    )
    return Section("Methods", text, [Table(found.methods, columns)])


def _counted(failing: Sequence[PropertyRow]) -> Section:
    columns = [
        words("property"),
        words("method", "method.title"),
        words("standing"),
        Column("n", lambda row: row.share.n if row.share else None),
        Column("violated %", "share", percent),
        Column("steps off, median", "steps", general),
    ]
    text = (
        "How often each is violated, among the cases that tested it, with 95 % intervals "
        "(Wilson's), and by how many steps. A "
        f"finding that no case drawn here shows has {MISSING}."
    )
    return Section("What does not hold", text, [Table(failing, columns)])


def _pairs(found: PropertyTable) -> Section:
    cells = {(row.method.spec, row.property): row for row in found.rows}
    tables = [
        Table(
            found.methods,
            [
                words("method", "title"),
                *columns_for(
                    of_kind, "{}", lambda method, name: cells.get((method.spec, name)), _cell
                ),
            ],
            f"**{kind}**",
        )
        for kind, of_kind in found.kinds.items()
    ]
    return Section(
        "Properties and methods",
        "In each cell, how the method stands to the property, and how many of the cases tried "
        f"tested it. {MISSING}: not asked.",
        tables,
    )


def _cell(row: PropertyRow | None) -> str:
    if row is None:
        return MISSING
    shown = _SIGNS[row.standing]
    if row.standing is not Standing.NOT_ASKED:
        shown += f" {row.asked}/{row.examples}"
    if row.refused:
        shown += f", {row.refused} refused"
    return shown


def _in_words(found: PropertyTable) -> Section:
    return Section(
        "What they say",
        tables=[Table(found.about.items(), [words("property", 0), words("what must hold", 1)])],
    )


def _counterexample(row: PropertyRow) -> Section:
    title = f"{row.standing.capitalize()}: {row.property}, {row.method.title}"
    smallest = row.smallest
    if smallest is None:
        return Section(title, f"No answer: {row.why}.")
    drawn = "; ".join(f"{name} {value:g}" for name, value in smallest.change.items())
    text = f"{smallest.found[0].upper()}{smallest.found[1:]}."
    if drawn:
        text += f" Drawn with it: {drawn}."
    if row.why:
        text += f"\n\n{row.why}"
    text += f"\n\nThe layout: [{smallest.file}]({smallest.file})."
    picture = Picture(
        f"counterexample_{PurePosixPath(smallest.file).stem.replace('-', '_')}",
        scene(smallest.layout).figure,
        "The layout in cm; dots are centres of mass.",
    )
    return Section(title, text, [Table(enumerate(smallest.layout.items), _ITEMS)], [picture])


def refusals(rows: Sequence[PropertyRow]) -> dict[str, tuple[int, int]]:
    """Cases that methods refused, and cases tried, by the spec of every method that refused any."""
    counts: dict[str, tuple[int, int]] = {}
    for row in rows:
        refused, tried = counts.get(row.method.spec, (0, 0))
        counts[row.method.spec] = refused + row.refused, tried + row.examples
    return {spec: count for spec, count in counts.items() if count[0]}


def violations(rows: Sequence[PropertyRow]) -> list[PropertyRow]:
    """Rows of violations that are not declared as findings."""
    return [row for row in rows if row.standing is Standing.VIOLATED]

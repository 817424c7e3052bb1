"""The page of property tests: a matrix, and every counterexample as table, picture and file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import PurePosixPath

from steadyload.reports.page import Page, Picture, Section
from steadyload.reports.scene import plot_scene
from steadyload.reports.table import MISSING, Column, Table, columns_for, general, words
from steadyload.studies.properties.study import PropertyRow, PropertyTable, Standing

_SIGNS = {
    Standing.HOLDS: "holds",
    Standing.FINDING: "**finding**",
    Standing.VIOLATED: "**violated**",
    Standing.NOT_ASKED: MISSING,
}

_ITEMS = (
    words("item", 0),
    *columns_for(range(3), "xyz".__getitem__, lambda row, axis: row[1].position[axis], general),
    *columns_for(
        range(3),
        ("width", "height", "depth").__getitem__,
        lambda row, axis: row[1].size[axis],
        general,
    ),
    Column("offset x, y, z (cm)", lambda row: ", ".join(map(general, row[1].mass_offset))),
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
        f"Properties: {len(found.about)}; methods: {len(found.methods)}; pairs that hold: "
        f"{counts[Standing.HOLDS]}, declared findings: {counts[Standing.FINDING]}, violated: "
        f"{counts[Standing.VIOLATED]}, on {examples} cases in all. A property is "
        "asked only of methods that declare what it is about; a case is drawn at random, built "
        "so that it can be loaded, and one that violates a property is made as small as it gets."
    )
    refused = sum(row.refused for row in found.rows)
    if refused:
        summary += (
            f" Not asked, and no violation: {refused} cases outside the range that a method "
            "declares, which it refused."
        )
    return Page("Property tests", summary, property_sections(found), manifest)


def property_sections(found: PropertyTable) -> list[Section]:
    """The matrix, the properties in words, and the counterexamples; for any page."""
    failing = [row for row in found.rows if row.smallest is not None or row.why]
    return [_matrix(found), _in_words(found), *(_counterexample(row) for row in failing)]


def _matrix(found: PropertyTable) -> Section:
    cells = {(row.method.spec, row.property): row for row in found.rows}
    columns = columns_for(
        found.methods,
        lambda method: method.title,
        lambda name, method: cells.get((method.spec, name)),
        _cell,
    )
    return Section(
        "Properties and methods",
        "In each cell, how the method stands to the property, and on how many of the cases tried "
        f"the property said anything. {MISSING}: not asked.",
        [Table(found.about, [words("property", str), *columns])],
    )


def _cell(row: PropertyRow | None) -> str:
    if row is None:
        return MISSING
    shown = _SIGNS[row.standing]
    if row.standing is not Standing.NOT_ASKED:
        shown += f" {row.asked}/{row.examples}"
    if row.refused:
        shown += f"; not asked: {row.refused} outside the method's range"
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
        plot_scene(smallest.layout),
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

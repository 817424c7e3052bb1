"""Results of property tests: rows of pairs, of methods and of counterexamples."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from enum import StrEnum
from operator import attrgetter
from pathlib import Path
from typing import NamedTuple

from steadyload.layouts.model.layout import Layout
from steadyload.methods.naming import MethodKey
from steadyload.properties.property import Property
from steadyload.reports.columns import cell, column, general, names, percent, row
from steadyload.statistics.estimate import Estimate

ENOUGH = 0.1
"""Share of the cases tried that have to test a property before it counts as one that holds."""


class Standing(StrEnum):
    """Result of a property for a method.

    ``holds``: no counterexample among the cases tried. ``too few cases``: none either, but less
    than the share :data:`ENOUGH` of the cases tested it. ``finding``: it does not hold, and that is
    declared. ``violated``: it does not hold, and that is not declared. ``not asked``: the method
    does not declare what the property needs, or the property applies to no case, or the method
    refused all cases to which it applies.
    """

    HOLDS = "holds"
    TOO_FEW = "too few cases"
    FINDING = "finding"
    VIOLATED = "violated"
    NOT_ASKED = "not asked"


_SIGNS = {
    Standing.HOLDS: "holds",
    Standing.TOO_FEW: "too few",
    Standing.FINDING: "**finding**",
    Standing.VIOLATED: "**violated**",
    Standing.NOT_ASKED: cell(None),
}


def _lengths(three: Sequence[float]) -> str:
    return ", ".join(map(general, three))


@row
class Box:
    """An item of a counterexample."""

    number: str = column("item")
    position: tuple[float, float, float] = column("x, y, z (cm)", _lengths)
    size: tuple[float, float, float] = column("width, height, depth (cm)", _lengths)
    mass_offset: tuple[float, float, float] = column("offset x, y, z (cm)", _lengths)
    weight: float = column("kg", general)


@row
class SmallestCase:
    """The smallest case found on which a property does not hold.

    ``found``: found and expected results. ``change``: other values drawn for the case.
    ``file``: path of the layout, relative to the page.
    """

    found: str
    change: Mapping[str, float]
    layout: Layout
    file: str

    @property
    def picture(self) -> str:
        """The name of its picture."""
        return f"counterexample_{Path(self.file).stem.replace('-', '_')}"

    @property
    def boxes(self) -> list[Box]:
        """Its items."""
        return [
            Box(str(number), item.position, item.size, item.mass_offset, item.weight)
            for number, item in enumerate(self.layout.items)
        ]


@row
class PropertyRow:
    """Result of one property for one method.

    ``examples``: cases tried; ``asked``: those to which the property applies; ``refused``: those
    that the method refused, which lie outside its range. ``why``: the reason of a declared finding,
    or how an engine ended its process. ``share``: of the cases that tested it, those that violate
    it, and ``steps``, the median distance of their failing steps from the expected ones; None where
    no case drawn violates it, or it is not about failing steps.
    """

    property: str = column()
    method: MethodKey = column(form=attrgetter("title"), left=True)
    standing: Standing = column()
    n: int | None = column(about="cases that tested it; None without a share")
    share: Estimate | None = column("violated %", percent)
    steps: float | None = column("steps off, median", general)
    examples: int
    asked: int
    refused: int
    why: str
    smallest: SmallestCase | None


class Refused(NamedTuple):
    """Cases that a method refused, of all that were tried."""

    cases: int
    of: int

    def __str__(self) -> str:
        return f"{self.cases} of {self.of}"


@row
class MethodTested:
    """A method, by what holds of it."""

    method: MethodKey = column(form=attrgetter("title"), left=True)
    holds: int = column()
    violated: Sequence[str] = column("violated", names, left=True)
    findings: Sequence[str] = column("declared finding", names, left=True)
    too_few: Sequence[str] = column("too few cases", names, left=True)
    refused: Refused = column()


def _cell(row: PropertyRow | None) -> str:
    if row is None:
        return cell(None)
    shown = _SIGNS[row.standing]
    if row.standing is not Standing.NOT_ASKED:
        shown += f" {row.asked}/{row.examples}"
    return f"{shown}, {row.refused} refused" if row.refused else shown


@row
class Pairs:
    """A method and the properties of one kind; None where one was not asked of it."""

    method: str = column()
    pairs: Mapping[str, PropertyRow | None] = column("{}", _cell)


@row
class Found:
    """Properties x methods: the properties, and a row for each pair.

    ``pairs``: by what properties are about. ``enough``: :data:`ENOUGH`.
    """

    statements: Sequence[Property]
    methods: Sequence[MethodTested]
    rows: Sequence[PropertyRow]
    pairs: Mapping[str, Sequence[Pairs]]
    made_with: Mapping[str, str]
    enough: float = ENOUGH

    @property
    def counts(self) -> Mapping[str, int]:
        """Number of pairs by standing."""
        return {s: sum(row.standing is s for row in self.rows) for s in Standing}

    @property
    def sound(self) -> int:
        """Number of methods of which all properties hold that they were asked."""
        return sum(not (method.violated or method.findings) for method in self.methods)

    @property
    def refused(self) -> int:
        """Number of cases that methods refused."""
        return sum(row.refused for row in self.rows)

    @property
    def fewer(self) -> list[str]:
        """Names of the properties that are tested on fewer cases than others."""
        return [each.name for each in self.statements if each.share < 1.0]

    @property
    def failing(self) -> list[PropertyRow]:
        """Pairs that do not hold, or have no answer."""
        return [row for row in self.rows if row.smallest is not None or row.why]

    @property
    def shares(self) -> list[Mapping[str, str | Estimate]]:
        """Shares of the cases that violate them, of those of which some case drawn does."""
        return [
            {"title": f"{one.property}, {one.method.title}", "share": one.share}
            for one in self.failing
            if one.share is not None
        ]

    @property
    def violations(self) -> list[PropertyRow]:
        """Violations that are not declared as findings."""
        return [row for row in self.rows if row.standing is Standing.VIOLATED]

    @property
    def violated(self) -> Mapping[str, list[str]]:
        """Titles of the methods that violate a property, by the property."""
        found: dict[str, list[str]] = {}
        for one in self.violations:
            found.setdefault(one.property, []).append(one.method.title)
        return found

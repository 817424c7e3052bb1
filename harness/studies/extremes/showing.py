"""Rows of the page of the extremes: outcomes, what was held, and errors against closed forms."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import groupby
from operator import attrgetter
from typing import Any, ClassVar

from steadyload.properties.closed_form_tests import ClosedFormResult, ClosedFormTest
from steadyload.reports.columns import column, compact, row
from steadyload.runs.provenance import provenance_lines
from steadyload.studies.closed_form_errors import (
    ErrorPoint,
    errors_by_argument,
    errors_by_frequency,
    hertz,
)
from steadyload.studies.extremes.envelopes import EnvelopeRow, envelope_rows, from_here_on
from steadyload.studies.extremes.loads import Loads
from steadyload.studies.extremes.measuring import Outcome
from steadyload.studies.extremes.sweeps import SWEEPS, TIMEOUT, ExtremeCell, ExtremeSweep

_SPOKEN_OF = (60, 240, 1000)
"""Frequencies in sentences and tables of numbers, where they were measured."""

_CURVES = (30, 90, 240, 1000)
"""Frequencies of the panels that show errors against the value."""

_TITLES = {
    Outcome.CLOSE: "within the stricter limit",
    Outcome.HELD: "held",
    Outcome.FAILED: "failed",
    Outcome.NO_VERDICT: "without a verdict",
    Outcome.UNDEFINED: "not defined for the engine",
}
_NUMBERS = {
    "moved": "moved (mm)",
    "turned": "turned (deg)",
    "penetration": "penetration (mm)",
    "energy": "energy (mm)",
    "cpu": "CPU ms",
}
"""Titles of numbers of a cell."""


@row
class Largest:
    """The largest value that an engine held at a frequency; ``numbers`` by title."""

    engine: str = column()
    frequency: int | None = column("substeps", hertz)
    value: float = column("largest held", "{:,g}".format)
    numbers: Mapping[str, float | None] = column("{}", compact)


@row
class Values:
    """Quantities that an engine found at a frequency, or those of the closed form, by value."""

    engine: str = column()
    substeps: str = column(left=False)
    found: Mapping[str, float | None] = column("{}", lambda number: compact(number, 3))


@dataclass(frozen=True)
class Swept:
    """A sweep with its cells."""

    sweep: ExtremeSweep
    cells: Sequence[ExtremeCell]

    @property
    def largest(self) -> list[Largest]:
        """The largest values held at some frequencies."""
        found = {}
        for cell in self.cells:
            if cell.outcome.good and cell.frequency in (*_SPOKEN_OF, None):
                at = cell.engine, cell.frequency
                numbers = {title: cell.numbers.get(name) for name, title in _NUMBERS.items()}
                found[at] = Largest(*at, cell.value, numbers)
        return list(found.values())

    @property
    def values(self) -> list[Values]:
        """Quantities that were found, below those of the closed form as the cells hold them."""
        titles = {value: f"{self.sweep.axis} {value:g}" for value in self.sweep.values}
        expected: dict[str, float | None] = dict.fromkeys(titles.values())
        found: dict[tuple[str, str], dict[str, float | None]] = {}
        for cell in self.cells:
            at, run = titles[cell.value], (cell.engine, hertz(cell.frequency))
            found.setdefault(run, {})[at] = cell.numbers.get("found")
            expected[at] = cell.numbers.get("expected", expected[at])
        runs = [Values(*run, own) for run, own in found.items()]
        return [Values("closed form", "", expected), *runs]

    @property
    def tests(self) -> list[ClosedFormTest]:
        """Its values as tests, in per cent of the closed form.

        That of 0, where a box does not stop or rebound, is another test, and none of these.
        """
        s = self.sweep
        return [
            ClosedFormTest(
                f"{value:g}", s.title, s.definition, 1.0, s.quantity, relative=True,
                resolution=s.resolution, argument=value, argument_name=s.label,
            )
            for value in s.values
            if value
        ]  # fmt: skip

    @property
    def results(self) -> list[ClosedFormResult]:
        """Errors in these tests, where the closed form is not 0."""
        return [
            ClosedFormResult(
                f"{c.value:g}", c.engine, c.frequency, c.numbers["found"],
                100.0 * (c.numbers["found"] - expected) / expected,
            )
            for c in self.cells
            if (expected := c.numbers.get("expected"))
        ]  # fmt: skip

    @property
    def points(self) -> list[ErrorPoint]:
        """Errors by value at some frequencies."""
        results = [r for r in self.results if r.frequency in (*_CURVES, None)]
        return errors_by_argument(self.tests, results) if results else []


@dataclass(frozen=True)
class Found:
    """All results.

    Attributes:
        cells: by sweep, in the order of the page.
        made_by: provenance of the measurement.
        loads: what moved and scaled loads show.
    """

    cells: Sequence[ExtremeCell]
    made_by: Mapping[str, Any]
    loads: Loads

    timeout: ClassVar[float] = TIMEOUT
    titles: ClassVar[Mapping[Outcome, str]] = _TITLES
    usual: ClassVar[int] = 240
    """Substeps a second of the sentence that begins the page."""

    @cached_property
    def envelope(self) -> tuple[EnvelopeRow, ...]:
        """Limits that were held at each frequency, at the label's thresholds."""
        return envelope_rows(self.cells)

    @cached_property
    def rests(self) -> tuple[EnvelopeRow, ...]:
        """The same at the thresholds of rest."""
        return envelope_rows(self.cells, at_rest=True)

    @property
    def from_here_on(self) -> tuple[EnvelopeRow, ...]:
        """Limits that were held at a frequency and at all higher ones."""
        return from_here_on(self.envelope)

    @property
    def at_rest(self) -> tuple[EnvelopeRow, ...]:
        """The same at the thresholds of rest."""
        return from_here_on(self.rests)

    @property
    def made_with(self) -> Mapping[str, str]:
        """Provenance, at the foot of the page."""
        return provenance_lines(self.made_by)

    @cached_property
    def swept(self) -> list[Swept]:
        """Sweeps that have cells."""
        found = groupby(self.cells, key=attrgetter("sweep"))
        return [Swept(SWEEPS[name], list(cells)) for name, cells in found]

    @property
    def resting(self) -> list[Swept]:
        """Sweeps in which nothing may move."""
        return [one for one in self.swept if not one.sweep.quantity]

    @property
    def formulas(self) -> list[Swept]:
        """Sweeps that are compared with a closed form."""
        return [one for one in self.swept if one.sweep.quantity]

    @property
    def points(self) -> list[ErrorPoint]:
        """Errors at the value that represents each sweep."""
        return [
            point
            for one in self.formulas
            for test in one.tests
            if test.argument == one.sweep.shown
            for point in errors_by_frequency([test], one.results)
        ]

    @property
    def counted(self) -> Mapping[str, int]:
        """Number of cells by the title of their outcome."""
        counted = Counter(cell.outcome for cell in self.cells)
        return {title: counted[outcome] for outcome, title in _TITLES.items()}

    @property
    def usually(self) -> list[EnvelopeRow]:
        """Rows at a usual frequency and above; none where no frequency up to it was measured."""
        last = {r.engine: r for r in self.from_here_on if (r.frequency or 0) <= self.usual}
        return list(last.values()) if any(r.frequency for r in last.values()) else []

    @property
    def silent(self) -> Mapping[str, list[str]]:
        """Frequencies at which there was no verdict, by engine and sweep."""
        at: dict[str, dict[str, None]] = {}
        for cell in self.cells:
            if cell.outcome is Outcome.NO_VERDICT:
                what = f"{cell.engine}, {SWEEPS[cell.sweep].title.lower()}"
                at.setdefault(what, {})[hertz(cell.frequency)] = None
        return {what: list(frequencies) for what, frequencies in at.items()}

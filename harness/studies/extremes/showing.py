"""Rows of the page of the extremes: outcomes, what was held, and errors against closed forms."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
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
from steadyload.studies.extremes.sweeps import ExtremeCell, ExtremeSweep, sweeps

_SPOKEN_OF = (60, 240, 1000)
"""Frequencies in sentences and tables of numbers, where they were measured."""

_USUAL = 240
"""Substeps a second of the sentence that begins the page."""

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


@row
class Swept:
    """A sweep with its cells.

    ``largest`` is of sweeps in which nothing may move; ``values`` and ``points``, errors at some
    frequencies, are of those that are compared with a closed form.
    """

    sweep: ExtremeSweep
    cells: Sequence[ExtremeCell]
    largest: Sequence[Largest]
    values: Sequence[Values]
    points: Sequence[ErrorPoint]


@row
class Found:
    """All results.

    ``envelope`` and ``rests``: what was held at each frequency at the label's thresholds and at
    those of rest; ``from_here_on`` and ``at_rest``: at that frequency and all higher ones.
    ``loads``: what moved and scaled loads show; None where none was judged.
    ``timeout``: of a cell [s]; ``made_by``: provenance of the measurement.
    """

    swept: Sequence[Swept]
    envelope: Sequence[EnvelopeRow]
    rests: Sequence[EnvelopeRow]
    from_here_on: Sequence[EnvelopeRow]
    at_rest: Sequence[EnvelopeRow]
    timeout: float
    made_by: Mapping[str, Any]
    loads: Loads | None

    titles: ClassVar[Mapping[Outcome, str]] = _TITLES
    tall: ClassVar[int] = 10
    """Stack height on a pallet [items]."""
    uneven: ClassVar[float] = 10.0
    """Mass ratio on a pallet, where weights are a few kilograms to tens of them."""
    usual: ClassVar[int] = _USUAL

    @property
    def made_with(self) -> Mapping[str, str]:
        """Provenance, at the foot of the page."""
        return provenance_lines(self.made_by)

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
        return errors_by_frequency(
            [_test(s, s.shown) for one in self.formulas if (s := one.sweep).shown is not None],
            [result for one in self.formulas for result in _results(one.sweep, one.cells)],
        )

    @property
    def counted(self) -> Mapping[str, int]:
        """Number of cells by the title of their outcome."""
        counted = Counter(cell.outcome for one in self.swept for cell in one.cells)
        return {title: counted[outcome] for outcome, title in _TITLES.items()}

    @property
    def usually(self) -> list[EnvelopeRow]:
        """Rows at a usual frequency and above; none where no frequency up to it was measured."""
        up_to = [r for r in self.from_here_on if r.frequency is None or r.frequency <= _USUAL]
        last = {r.engine: r for r in up_to}
        return list(last.values()) if any(r.frequency for r in last.values()) else []

    @property
    def spoken_of(self) -> Mapping[int, list[EnvelopeRow]]:
        """Rows at some frequencies, and of engines that choose their own steps."""
        return {
            frequency: [r for r in self.envelope if r.frequency in (frequency, None)]
            for frequency in _SPOKEN_OF
            if any(r.frequency == frequency for r in self.envelope)
        }

    @property
    def fit(self) -> Mapping[str, EnvelopeRow | None]:
        """By engine, the lowest frequency from which on it holds what stands on pallets."""
        found: dict[str, EnvelopeRow | None] = {r.engine: None for r in self.envelope}
        for r in reversed(self.from_here_on):
            ratio = min(r.heavy_on_light, r.light_on_heavy)
            if r.tower_height >= self.tall and ratio >= self.uneven:
                found[r.engine] = r
        return found

    @property
    def blind(self) -> list[EnvelopeRow]:
        """Rows at which a plate over an edge is misjudged."""
        return [one for one in self.envelope if not one.sees_falls]

    @property
    def silent(self) -> Mapping[str, list[str]]:
        """Frequencies at which there was no verdict, by engine and sweep."""
        at: dict[str, dict[str, None]] = {}
        for one in self.swept:
            for cell in one.cells:
                if cell.outcome is Outcome.NO_VERDICT:
                    what = f"{cell.engine}, {one.sweep.title.lower()}"
                    at.setdefault(what, {})[hertz(cell.frequency)] = None
        return {what: list(frequencies) for what, frequencies in at.items()}


def summarise(
    cells: Sequence[ExtremeCell],
    timeout: float,
    made_by: Mapping[str, Any],
    loads: Loads | None = None,
) -> Found:
    """The results that the page shows; sweeps without cells are left out."""
    rows, strict = envelope_rows(cells), envelope_rows(cells, frozenset({Outcome.CLOSE}))
    by_sweep: dict[str, list[ExtremeCell]] = {}
    for cell in cells:
        by_sweep.setdefault(cell.sweep, []).append(cell)
    swept = [
        Swept(sweep, own, _largest(own), _values(sweep, own), _points(sweep, own))
        for name, sweep in sweeps().items()
        if (own := by_sweep.get(name))
    ]
    held = from_here_on(rows), from_here_on(strict)
    return Found(swept, rows, strict, *held, timeout, made_by, loads)


def _largest(cells: Sequence[ExtremeCell]) -> list[Largest]:
    """The largest values held at some frequencies."""
    largest: dict[tuple[str, int | None], Largest] = {}
    for cell in cells:
        if cell.outcome.good and cell.frequency in (*_SPOKEN_OF, None):
            numbers = {title: cell.numbers.get(name) for name, title in _NUMBERS.items()}
            at = cell.engine, cell.frequency
            largest[at] = Largest(*at, cell.value, numbers)
    return list(largest.values())


def _values(sweep: ExtremeSweep, cells: Sequence[ExtremeCell]) -> list[Values]:
    """Quantities that were found, below those of the closed form as the cells hold them."""
    titles = {value: f"{sweep.axis} {value:g}" for value in sweep.values}
    expected: dict[str, float | None] = dict.fromkeys(titles.values())
    found: dict[tuple[str, str], dict[str, float | None]] = {}
    for cell in cells:
        at, numbers = titles[cell.value], cell.numbers
        found.setdefault((cell.engine, hertz(cell.frequency)), {})[at] = numbers.get("found")
        expected[at] = numbers.get("expected", expected[at])
    return [
        Values("closed form", "", expected), *(Values(*run, own) for run, own in found.items())
    ]  # fmt: skip


def _points(sweep: ExtremeSweep, cells: Sequence[ExtremeCell]) -> list[ErrorPoint]:
    """Errors by value; at 0, where a box does not stop or rebound, it is another test."""
    tests = [_test(sweep, value) for value in sweep.values if value]
    results = [r for r in _results(sweep, cells) if r.frequency in (*_CURVES, None)]
    return errors_by_argument(tests, results) if results else []


def _test(sweep: ExtremeSweep, value: float) -> ClosedFormTest:
    """One value of a sweep as a test, in per cent of its closed form."""
    return ClosedFormTest(
        f"{sweep.name} {value:g}", sweep.title, sweep.definition, 1.0, sweep.quantity,
        relative=True, resolution=sweep.resolution, argument=value, argument_name=sweep.label,
    )  # fmt: skip


def _results(sweep: ExtremeSweep, cells: Sequence[ExtremeCell]) -> list[ClosedFormResult]:
    """Errors in per cent of the closed form, where that is not 0."""
    results = []
    for c in cells:
        expected = c.numbers.get("expected")
        if expected:
            found = c.numbers["found"]
            error = 100.0 * (found - expected) / expected
            name = f"{sweep.name} {c.value:g}"
            results.append(ClosedFormResult(name, c.engine, c.frequency, found, error))
    return results

"""The page of the extremes: outcomes, what was held, and errors against closed forms."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from itertools import groupby
from operator import attrgetter
from types import SimpleNamespace
from typing import Any

import pandas as pd

from steadyload.properties.closed_form_tests import ClosedFormResult, ClosedFormTest
from steadyload.runs.provenance import provenance_lines
from steadyload.studies.closed_form_errors import errors_by_argument, errors_by_frequency, hertz
from steadyload.studies.extremes.envelopes import EnvelopeRow, envelope_rows, from_here_on
from steadyload.studies.extremes.loads import Loads
from steadyload.studies.extremes.measuring import Outcome
from steadyload.studies.extremes.sweeps import SWEEPS, TIMEOUT, ExtremeCell, ExtremeSweep

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


class Found(SimpleNamespace):
    """All that the page shows."""

    envelope: Sequence[EnvelopeRow]
    rests: Sequence[EnvelopeRow]
    from_here_on: Sequence[EnvelopeRow]
    at_rest: Sequence[EnvelopeRow]
    usually: Sequence[EnvelopeRow]
    loads: Loads
    made_by: Mapping[str, Any]
    made_with: Mapping[str, str]


def shown(cells: Sequence[ExtremeCell], made_by: Mapping[str, Any], loads: Loads) -> Found:
    """All results."""
    swept = [_swept(SWEEPS[n], list(own)) for n, own in groupby(cells, key=attrgetter("sweep"))]
    formulas = [one for one in swept if one.sweep.quantity]
    envelope, rests = envelope_rows(cells), envelope_rows(cells, at_rest=True)
    ever = from_here_on(envelope)
    counted = Counter(cell.outcome for cell in cells)
    return Found(
        resting=[one for one in swept if not one.sweep.quantity],
        formulas=formulas,
        points=[
            point
            for one in formulas
            for test in one.tests
            if test.argument == one.sweep.shown
            for point in errors_by_frequency([test], one.results)
        ],
        envelope=envelope,
        rests=rests,
        from_here_on=ever,
        at_rest=from_here_on(rests),
        usually=_usually(ever),
        usual=_USUAL,
        counted={title: counted[outcome] for outcome, title in _TITLES.items()},
        silent=_silent(cells),
        titles=_TITLES,
        timeout=TIMEOUT,
        loads=loads,
        made_by=made_by,
        made_with=provenance_lines(made_by),
    )


def _swept(sweep: ExtremeSweep, cells: Sequence[ExtremeCell]) -> SimpleNamespace:
    """A sweep with its cells, and of one with a closed form tests and errors in them.

    Tests are in per cent of the closed form. That of 0, where a box does not stop or rebound, is
    none of these.
    """
    tests = [
        ClosedFormTest(
            f"{value:g}", sweep.title, sweep.definition, 1.0, sweep.quantity, relative=True,
            resolution=sweep.resolution, argument=value, argument_name=sweep.label,
        )
        for value in dict.fromkeys(cell.value for cell in cells if cell.value)
    ]  # fmt: skip
    results = [
        ClosedFormResult(
            f"{c.value:g}", c.engine, c.frequency, c.numbers["found"],
            100.0 * (c.numbers["found"] - expected) / expected,
        )
        for c in cells
        if (expected := c.numbers.get("expected"))
    ]  # fmt: skip
    drawn = [r for r in results if r.frequency in (*_CURVES, None)]
    return SimpleNamespace(
        sweep=sweep,
        cells=cells,
        largest=_largest(cells),
        found=_values(sweep, cells),
        tests=tests,
        results=results,
        points=errors_by_argument(tests, drawn) if drawn else [],
    )


def _largest(cells: Sequence[ExtremeCell]) -> pd.DataFrame:
    """The largest value that an engine held at some frequencies, with numbers of that cell."""
    good = [c for c in cells if c.outcome.good and c.frequency in (*_SPOKEN_OF, None)]
    rows = [
        {"engine": c.engine, "rate": hertz(c.frequency), "largest": c.value}
        | {f"number:{title}": c.numbers.get(name) for name, title in _NUMBERS.items()}
        for c in good
    ]
    return pd.DataFrame(rows, dtype=object).drop_duplicates(["engine", "rate"], keep="last")


def _values(sweep: ExtremeSweep, cells: Sequence[ExtremeCell]) -> pd.DataFrame:
    """Quantities that were found, below those of the closed form as the cells hold them."""
    first: dict[str, Any] = {"engine": "closed form", "rate": ""}
    rows: dict[tuple[str, str], dict[str, Any]] = {}
    for cell in cells:
        at, run = f"quantity:{sweep.axis} {cell.value:g}", (cell.engine, hertz(cell.frequency))
        rows.setdefault(run, {"engine": run[0], "rate": run[1]})[at] = cell.numbers.get("found")
        first[at] = cell.numbers.get("expected", first.get(at))
    return pd.DataFrame([first, *rows.values()], dtype=object)


def _usually(rows: Sequence[EnvelopeRow]) -> list[EnvelopeRow]:
    """Rows at a usual frequency and above; none where no frequency up to it was measured."""
    last = {r.engine: r for r in rows if (r.frequency or 0) <= _USUAL}
    return list(last.values()) if any(r.frequency for r in last.values()) else []


def _silent(cells: Sequence[ExtremeCell]) -> dict[str, list[str]]:
    """Frequencies at which there was no verdict, by engine and sweep."""
    at: dict[str, dict[str, None]] = {}
    for cell in cells:
        if cell.outcome is Outcome.NO_VERDICT:
            what = f"{cell.engine}, {SWEEPS[cell.sweep].title.lower()}"
            at.setdefault(what, {})[hertz(cell.frequency)] = None
    return {what: list(frequencies) for what, frequencies in at.items()}

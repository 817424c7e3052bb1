"""Results of the extremes: each engine's envelope, computed from the cells, and its file."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import steadyload.methods
from steadyload.atomic import write_atomically
from steadyload.engines.registry import installed_versions
from steadyload.methods.envelope import ENVELOPES
from steadyload.properties.closed_form_tests import ClosedFormResult, ClosedFormTest
from steadyload.stored import REMEDY, stored_object
from steadyload.studies.extremes.measuring import Outcome
from steadyload.studies.extremes.sweeps import ExtremeCell, ExtremeSweep, sweeps

_SIZE_SWEEPS = ("size-two", "size-five")
_NOMINAL = 10.0
"""Edge of a cube from which the range of sizes is extended in both directions [cm]."""

ENVELOPE_SWEEPS = (
    "tower", "heavy-on-light", "heavy-on-two", "light-on-heavy", *_SIZE_SWEEPS, "items",
    "plate-on-edge",
)  # fmt: skip
"""The sweeps that an envelope is made from."""

Held = dict[float, bool]
"""Measured value -> whether it was held."""


@dataclass(frozen=True, slots=True)
class EnvelopeRow:
    """Envelope of an engine at one frequency, at the label's thresholds.

    ``tower_height`` in items, mass ratios as numbers, sizes in cm, 0 where nothing was held.
    ``sees_falls``: a plate beyond an edge falls, and one before it stays.
    """

    engine: str
    frequency: int | None
    tower_height: int
    heavy_on_light: float
    light_on_heavy: float
    least_size: float
    most_size: float
    item_count: int
    sees_falls: bool


@dataclass(frozen=True, slots=True)
class Extremes:
    """All results of the study of extremes.

    ``envelope``: at the label's thresholds; ``rests``: at those of rest. ``from_here_on`` and
    ``at_rest``: the same, for values held at that frequency and all higher ones; only where falls
    are detected and two cubes hold, and one row where two are equal. ``timeout``: of a cell [s].
    """

    sweeps: tuple[ExtremeSweep, ...]
    cells: tuple[ExtremeCell, ...]
    envelope: tuple[EnvelopeRow, ...]
    rests: tuple[EnvelopeRow, ...]
    from_here_on: tuple[EnvelopeRow, ...]
    at_rest: tuple[EnvelopeRow, ...]
    timeout: float


def extremes_record(cells: Sequence[ExtremeCell], timeout: float) -> Extremes:
    """The record for the page; sweeps without cells are left out."""
    measured = {cell.sweep for cell in cells}
    rows = envelope_rows(cells)
    strict = envelope_rows(cells, frozenset({Outcome.CLOSE}))
    return Extremes(
        sweeps=tuple(s for name, s in sweeps().items() if name in measured),
        cells=tuple(cells),
        envelope=rows,
        rests=strict,
        from_here_on=from_here_on(rows),
        at_rest=from_here_on(strict),
        timeout=timeout,
    )


GOOD = frozenset(outcome for outcome in Outcome if outcome.good)


def envelope_rows(
    cells: Iterable[ExtremeCell], counts: frozenset[Outcome] = GOOD
) -> tuple[EnvelopeRow, ...]:
    """Envelope of each engine at each frequency at which all sweeps for it were measured.

    Args:
        cells: of any sweeps.
        counts: outcomes that count as held.
    """
    held: dict[tuple[str, int | None], dict[str, Held]] = {}
    for cell in cells:
        by_sweep = held.setdefault((cell.engine, cell.frequency), {})
        by_sweep.setdefault(cell.sweep, {})[cell.value] = cell.outcome in counts
    return tuple(
        _row(engine, frequency, found)
        for (engine, frequency), found in held.items()
        if set(ENVELOPE_SWEEPS) <= set(found)
    )


def _row(engine: str, frequency: int | None, held: Mapping[str, Held]) -> EnvelopeRow:
    least, most = _range(held)
    return EnvelopeRow(
        engine=engine,
        frequency=frequency,
        tower_height=int(_up_to(held["tower"])),
        heavy_on_light=min(_up_to(held["heavy-on-light"]), _up_to(held["heavy-on-two"])),
        light_on_heavy=_up_to(held["light-on-heavy"]),
        least_size=least,
        most_size=most,
        item_count=int(_up_to(held["items"])),
        sees_falls=all(held["plate-on-edge"].values()),
    )


def _up_to(held: Held) -> float:
    """The largest value that was held with all smaller ones; 0 where the smallest was not."""
    largest = 0.0
    for value in sorted(held):
        if not held[value]:
            break
        largest = float(value)
    return largest


def _range(held: Mapping[str, Held]) -> tuple[float, float]:
    """Ends of the range of held sizes around the nominal one; zeros where that was not held."""
    both = {v: all(held[s][v] for s in _SIZE_SWEEPS) for v in held[_SIZE_SWEEPS[0]]}
    downwards = _up_to({-v: good for v, good in both.items() if v <= _NOMINAL})
    upwards = _up_to({v: good for v, good in both.items() if v >= _NOMINAL})
    return abs(downwards), upwards


def from_here_on(rows: Sequence[EnvelopeRow]) -> tuple[EnvelopeRow, ...]:
    """Envelopes that hold at a frequency and at all higher ones that were measured."""
    kept: list[EnvelopeRow] = []
    for engine in dict.fromkeys(row.engine for row in rows):
        mine = sorted((r for r in rows if r.engine == engine), key=lambda r: -(r.frequency or 0))
        joined: list[EnvelopeRow] = []
        for row in mine:
            joined.append(_both(row, joined[-1]) if joined else row)
        rising = [row for row in reversed(joined) if row.sees_falls and _holds_two(row)]
        alike = [dataclasses.replace(b, frequency=a.frequency) == a for a, b in pairwise(rising)]
        kept += [row for row, same in zip(rising, [False, *alike], strict=False) if not same]
    return tuple(kept)


def _holds_two(row: EnvelopeRow) -> bool:
    """Two equal cubes of the usual size stand on each other."""
    return row.tower_height > 1 and row.heavy_on_light >= 1.0 and row.most_size > 0.0


def _both(row: EnvelopeRow, higher: EnvelopeRow) -> EnvelopeRow:
    """Intersection of the envelopes of a row and of the higher frequencies."""
    least, most = max(row.least_size, higher.least_size), min(row.most_size, higher.most_size)
    if not (row.most_size and higher.most_size):
        least = most = 0.0
    both = ("tower_height", "heavy_on_light", "light_on_heavy", "item_count", "sees_falls")
    least_of_two = {name: min(getattr(row, name), getattr(higher, name)) for name in both}
    return dataclasses.replace(row, least_size=least, most_size=most, **least_of_two)


def expected_value(sweep: ExtremeSweep, value: float, cells: Sequence[ExtremeCell]) -> float | None:
    """Value of the closed form, as the cells hold it; None where no engine has a result."""
    mine = (c for c in cells if c.sweep == sweep.name and c.value == value)
    return next((c.numbers["expected"] for c in mine if "expected" in c.numbers), None)


def closed_form_test(sweep: ExtremeSweep, value: float) -> ClosedFormTest:
    """One value of a sweep as a test, in per cent of its closed form."""
    axis = f"{sweep.axis} ({sweep.unit})" if sweep.unit else sweep.axis
    return ClosedFormTest(
        f"{sweep.name} {value:g}", sweep.title, sweep.definition, 1.0, sweep.quantity,
        relative=True, resolution=sweep.resolution, argument=value, argument_name=axis,
    )  # fmt: skip


def closed_form_results(
    sweep: ExtremeSweep, cells: Sequence[ExtremeCell]
) -> list[ClosedFormResult]:
    """Errors in per cent of the closed form, where that is not 0."""
    results = []
    for c in cells:
        expected = c.numbers.get("expected")
        if c.sweep == sweep.name and expected:
            found = c.numbers["found"]
            error = 100.0 * (found - expected) / expected
            name = f"{sweep.name} {c.value:g}"
            results.append(ClosedFormResult(name, c.engine, c.frequency, found, error))
    return results


def envelope_file() -> Path:
    """Path of the envelopes that :mod:`steadyload.methods.envelope` reads."""
    return Path(steadyload.methods.__path__[0]) / ENVELOPES


def write_envelopes(
    rows: Sequence[EnvelopeRow],
    rests: Sequence[EnvelopeRow],
    made_by: Mapping[str, Any],
    path: Path | None = None,
) -> Path:
    """Write measured envelopes; engines that were not measured keep their entries in the file.

    Args:
        rows: as :func:`envelope_rows` gives them.
        rests: the same with the limits of rest; of the same engines and frequencies.
        made_by: the provenance of the measurement.
        path: the file; that of the package if None.
    """
    path = path or envelope_file()
    entries = stored_object(path, REMEDY) if path.exists() else {}
    for engine in dict.fromkeys(row.engine for row in rows):
        holds, still = ([row for row in of if row.engine == engine] for of in (rows, rests))
        packages = set(installed_versions(engine)) & set(made_by["versions"])
        entries[engine] = {
            "made": {
                "git": made_by["git"],
                "versions": {name: made_by["versions"][name] for name in sorted(packages)},
            },
            "rows": [
                {"frequency": row.frequency, "holds": _holds(row), "rests": _holds(strict)}
                for row, strict in zip(holds, still, strict=True)
            ],
        }
    write_atomically(path, json.dumps(entries, indent=1) + "\n")
    return path


def _holds(row: EnvelopeRow) -> dict[str, Any]:
    values = dataclasses.asdict(row)
    return {k: v for k, v in values.items() if k not in ("engine", "frequency")}

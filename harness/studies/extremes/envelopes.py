"""Envelopes of engines, computed from the cells of sweeps, and their file."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Iterable, Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import steadyload.methods
from steadyload.atomic import write_atomically
from steadyload.engines.registry import installed_versions
from steadyload.methods.envelope import ENVELOPES
from steadyload.reports.columns import column, row, yes_no
from steadyload.stored import REMEDY, stored_object
from steadyload.studies.closed_form_errors import hertz
from steadyload.studies.extremes.measuring import Outcome
from steadyload.studies.extremes.sweeps import ExtremeCell

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


def _limit(value: float) -> str:
    return f"{value:,.0f}" if value else "none"


class Edges(NamedTuple):
    """A range of edges [cm]; zeros where there is none."""

    least: float
    most: float

    def __str__(self) -> str:
        return f"{self.least:g} to {self.most:g}" if self.most else "none"


@row
class EnvelopeRow:
    """Envelope of an engine at one frequency, at the label's thresholds.

    ``tower_height`` in items, mass ratios as numbers, sizes in cm, 0 where nothing was held.
    ``sees_falls``: a plate beyond an edge falls, and one before it stays.
    """

    engine: str = column()
    frequency: int | None = column("substeps", hertz)
    tower_height: int = column("stacks", _limit)
    heavy_on_light: float = column("heavy on light", _limit)
    light_on_heavy: float = column("light on heavy", _limit)
    least_size: float
    most_size: float
    item_count: int = column("items", _limit)
    sees_falls: bool = column("sees falls", yes_no)

    @property
    def rate(self) -> str:
        """The frequency with its unit."""
        return hertz(self.frequency)

    @property
    def edges(self) -> Edges:
        """The range of edges that were held."""
        return Edges(self.least_size, self.most_size)


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
    for engine in dict.fromkeys(r.engine for r in rows):
        mine = sorted((r for r in rows if r.engine == engine), key=lambda r: -(r.frequency or 0))
        joined: list[EnvelopeRow] = []
        for own in mine:
            joined.append(_both(own, joined[-1]) if joined else own)
        rising = [r for r in reversed(joined) if r.sees_falls and _holds_two(r)]
        alike = [dataclasses.replace(b, frequency=a.frequency) == a for a, b in pairwise(rising)]
        kept += [r for r, same in zip(rising, [False, *alike], strict=False) if not same]
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
    for engine in dict.fromkeys(r.engine for r in rows):
        holds, still = ([r for r in of if r.engine == engine] for of in (rows, rests))
        packages = set(installed_versions(engine)) & set(made_by["versions"])
        entries[engine] = {
            "made": {
                "git": made_by["git"],
                "versions": {name: made_by["versions"][name] for name in sorted(packages)},
            },
            "rows": [
                {"frequency": own.frequency, "holds": _holds(own), "rests": _holds(strict)}
                for own, strict in zip(holds, still, strict=True)
            ],
        }
    write_atomically(path, json.dumps(entries, indent=1) + "\n")
    return path


def _holds(row: EnvelopeRow) -> dict[str, Any]:
    values = dataclasses.asdict(row)
    return {k: v for k, v in values.items() if k not in ("engine", "frequency")}

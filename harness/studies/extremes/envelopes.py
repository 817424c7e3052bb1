"""Envelopes of engines, computed from the cells of sweeps, and their file."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Mapping, Sequence
from itertools import accumulate, groupby, takewhile
from operator import attrgetter
from pathlib import Path
from typing import Any, NamedTuple

import steadyload.methods
from steadyload.atomic import manifest_text, write_atomically
from steadyload.engines.registry import installed_versions
from steadyload.methods.envelope import ENVELOPES, Envelope
from steadyload.reports.columns import column, row, yes_no
from steadyload.stored import REMEDY, stored_object
from steadyload.studies.closed_form_errors import hertz
from steadyload.studies.extremes.measuring import Outcome
from steadyload.studies.extremes.sweeps import ExtremeCell

_NOMINAL = 10.0
"""Edge of a cube from which the range of sizes is extended in both directions [cm]."""

ENVELOPE_SWEEPS = (
    "tower", "heavy-on-light", "heavy-on-two", "light-on-heavy", "size-two", "size-five", "items",
    "plate-on-edge",
)  # fmt: skip
"""The sweeps that an envelope is made from."""

_LIMITS = tuple(limit.name for limit in dataclasses.fields(Envelope))


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


def envelope_rows(
    cells: Iterable[ExtremeCell], *, at_rest: bool = False
) -> tuple[EnvelopeRow, ...]:
    """Envelope of each engine at each frequency at which all sweeps for it were measured."""
    held: dict[tuple[str, int | None], dict[str, dict[float, bool]]] = {}
    for cell in cells:
        by_sweep = held.setdefault((cell.engine, cell.frequency), {})
        by_sweep.setdefault(cell.sweep, {})[cell.value] = (
            cell.outcome is Outcome.CLOSE if at_rest else cell.outcome.good
        )
    rows = []
    for run, found in held.items():
        if not set(ENVELOPE_SWEEPS) <= set(found):
            continue
        largest = {name: _up_to(found[name]) for name in ENVELOPE_SWEEPS}
        sizes = {v: found["size-two"][v] and found["size-five"][v] for v in found["size-two"]}
        rows.append(
            EnvelopeRow(
                *run,
                tower_height=int(largest["tower"]),
                heavy_on_light=min(largest["heavy-on-light"], largest["heavy-on-two"]),
                light_on_heavy=largest["light-on-heavy"],
                least_size=abs(_up_to({-v: held for v, held in sizes.items() if v <= _NOMINAL})),
                most_size=_up_to({v: held for v, held in sizes.items() if v >= _NOMINAL}),
                item_count=int(largest["items"]),
                sees_falls=all(found["plate-on-edge"].values()),
            )
        )
    return tuple(rows)


def _up_to(held: Mapping[float, bool]) -> float:
    """The largest value that was held with all smaller ones; 0 where the smallest was not."""
    return float(max(takewhile(held.__getitem__, sorted(held)), default=0.0))


def from_here_on(rows: Iterable[EnvelopeRow]) -> tuple[EnvelopeRow, ...]:
    """Envelopes that hold at a frequency and at all higher ones that were measured.

    Left out are frequencies at which falls are not seen, or two equal cubes of the usual size do
    not stand on each other, and those that hold what the next lower one does.
    """
    kept: list[EnvelopeRow] = []
    for _, own in groupby(rows, key=attrgetter("engine")):
        joined = accumulate(sorted(own, key=lambda r: -(r.frequency or 0)), _both)
        use = [
            r for r in joined
            if r.sees_falls and r.tower_height > 1 and r.heavy_on_light >= 1.0 and r.most_size
        ]  # fmt: skip
        same = groupby(reversed(use), key=lambda r: dataclasses.replace(r, frequency=None))
        kept += [next(alike) for _, alike in same]
    return tuple(kept)


def _both(higher: EnvelopeRow, row: EnvelopeRow) -> EnvelopeRow:
    """Intersection of the envelopes of a row and of the higher frequencies."""
    both = {name: min(getattr(row, name), getattr(higher, name)) for name in _LIMITS}
    least = max(row.least_size, higher.least_size) if both["most_size"] else 0.0
    return dataclasses.replace(row, **both | {"least_size": least})


def envelope_file() -> Path:
    """Path of the envelopes that :mod:`steadyload.methods.envelope` reads."""
    return Path(steadyload.methods.__path__[0]) / ENVELOPES


def write_envelopes(
    rows: Sequence[EnvelopeRow],
    rests: Sequence[EnvelopeRow],
    made_by: Mapping[str, Any],
) -> None:
    """Write measured envelopes; engines that were not measured keep their entries in the file."""
    path = envelope_file()
    entries = stored_object(path, REMEDY) if path.exists() else {}
    for engine in dict.fromkeys(r.engine for r in rows):
        versions = made_by["versions"]
        packages = sorted(set(installed_versions(engine)) & set(versions))
        entries[engine] = {
            "made": {
                "git": made_by["git"],
                "versions": {name: versions[name] for name in packages},
            },
            "rows": [
                {"frequency": own.frequency, "holds": _holds(own), "rests": _holds(strict)}
                for own, strict in zip(rows, rests, strict=True)
                if own.engine == engine
            ],
        }
    write_atomically(path, manifest_text(entries))


def _holds(row: EnvelopeRow) -> dict[str, Any]:
    return {name: getattr(row, name) for name in _LIMITS}

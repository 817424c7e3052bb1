"""Runs of the cells of the extremes: in rounds, over processes, resumable.

A run folder holds ``cells/*.json``, a :class:`steadyload.runs.store.Store` with a shard for every
cell, and ``manifest.json``. The store is completed in rounds: which cells are missing depends on
those before them.
"""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Mapping, Sequence

from steadyload.atomic import write_atomically
from steadyload.engines.registry import (
    package_versions,
    warm_up,
    world_class,
)
from steadyload.methods.simulation import loading
from steadyload.properties import closed_forms
from steadyload.runs.asked import Asked, asked, measured
from steadyload.runs.pool import PartLimit
from steadyload.runs.provenance import made_on, provenance
from steadyload.runs.store import Codec, Store, locked
from steadyload.runs.units import hard_seconds
from steadyload.studies.extremes import measuring
from steadyload.studies.extremes import sweeps as sweeping
from steadyload.studies.extremes.measuring import Outcome
from steadyload.studies.extremes.sweeps import (
    FREQUENCIES,
    SWEEPS,
    TIMEOUT,
    ExtremeCell,
    measure_cell,
)
from steadyload.studies.kit import Lab


class CellUnit(Asked[ExtremeCell], what="extremes"):
    """A cell to be measured."""

    sweep: str
    engine: str
    frequency: int | None
    value: float | int  # in keys as the sweep states it
    timeout: float
    made_by: Mapping[str, str] = asked("made by")

    def describe(self, part: int) -> str:
        """Description of the cell for messages."""
        rate = "" if self.frequency is None else f", {self.frequency} Hz"
        return f"{self.sweep} {self.value:g} on {self.engine}{rate}"

    def measure(self) -> ExtremeCell:
        """Measure it."""
        return measure_cell(self.sweep, self.engine, self.frequency, self.value, self.timeout)


def cell_without_verdict(unit: CellUnit, part: int, reason: str) -> ExtremeCell:
    """The cell of an engine that ends its process, or exceeds its hard limit."""
    assert part == 0, "a unit is one cell"
    outcome = Outcome.NO_VERDICT
    return ExtremeCell(unit.sweep, unit.engine, unit.frequency, unit.value, outcome, note=reason)


def run_extremes(
    lab: Lab,
    engines: Sequence[str],
    sweeps: Sequence[str] = tuple(SWEEPS),
    frequencies: Sequence[int] = FREQUENCIES,
) -> list[ExtremeCell]:
    """Measure the missing cells of sweeps; returns all cells, in the order of the page.

    A sweep that ends after some consecutive failures is measured value by value, so it has no cells
    beyond them.
    """
    with locked(lab.work):
        made_with = provenance()
        made_by = {engine: _made_by(engine) for engine in engines}
        lines = [
            [
                CellUnit(sweep, engine, frequency, value, TIMEOUT, made_by[engine])
                for value in SWEEPS[sweep].values
            ]
            for sweep in sweeps
            for engine in engines
            for frequency in _frequencies(engine, frequencies)
        ]
        units = [unit for line in lines for unit in line]
        store = Store(lab.work / "cells", _CELLS)
        missing = store.survey(units).missing
        cells = {unit.key: store.read(unit.key) for unit in units if unit.key not in missing}
        while True:
            left = [own for line in lines if (own := _left(line, cells))]
            done = len(units) - sum(map(len, left))
            lab.progress("measuring", done, len(units))
            if not left:
                break
            # One value at a time where a sweep may end.
            now = [u for own in left for u in own[: 1 if SWEEPS[own[0].sweep].stops else None]]
            for engine in {unit.engine for unit in now}:
                warm_up(engine, 0)  # compiled here, not in every worker
            store.complete(
                now,
                measured,
                crashed=cell_without_verdict,
                limit=PartLimit(hard_seconds(TIMEOUT), cell_without_verdict),
                workers=lab.workers,
                progress=lambda new, _, done=done: lab.progress(
                    "measuring", done + new, len(units)
                ),
            )
            cells |= {unit.key: store.read(unit.key) for unit in now}
        manifest = {"engines": engines, "sweeps": sweeps, "timeout": TIMEOUT, **made_with}
        write_atomically(lab.work / "manifest.json", json.dumps(manifest, indent=1) + "\n")
    return [cells[unit.key] for unit in units if unit.key in cells]


def _left(line: Sequence[CellUnit], cells: Mapping[str, ExtremeCell]) -> list[CellUnit]:
    """Units of one sweep, engine and frequency, by rising value, that are to be measured at most.

    None are left after as many failures in a row as end the sweep.
    """
    stops = SWEEPS[line[0].sweep].stops
    last = [cells[unit.key] for unit in line if unit.key in cells][-stops:] if stops else []
    if last and len(last) == stops and not any(cell.outcome.good for cell in last):
        return []
    return [unit for unit in line if unit.key not in cells]


def _decoded(content: bytes) -> ExtremeCell:
    record = json.loads(content)
    return ExtremeCell(**record | {"outcome": Outcome(record["outcome"])})


_CELLS: Codec[ExtremeCell, ExtremeCell] = Codec(
    ".json",
    lambda cells: (json.dumps(dataclasses.asdict(cells[0]), indent=1) + "\n").encode(),
    _decoded,
)


def _made_by(engine: str) -> dict[str, str]:
    """Versions of the parts and packages on which a cell depends, by name."""
    parts = {
        "sweeps": sweeping.VERSION,
        "measuring": measuring.VERSION,
        "closed forms": closed_forms.VERSION,
        "loading": loading.VERSION,
    }
    versions = {f"version of {part}": str(number) for part, number in parts.items()}
    return made_on(engine) | package_versions(("numpy", "scipy")) | versions


def _frequencies(engine: str, frequencies: Sequence[int]) -> Sequence[int | None]:
    return (None,) if world_class(engine).capabilities.error_controlled else frequencies

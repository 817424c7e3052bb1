"""Runs of the cells of the extremes: in rounds, over processes, resumable.

A run folder holds ``cells/*.json``, a :class:`steadyload.runs.store.Store` with a shard for every
cell, and ``manifest.json``. The store is completed in rounds: which cells are missing depends on
those before them.
"""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from steadyload.atomic import write_atomically
from steadyload.engines.registry import engines as registered
from steadyload.engines.registry import engines_here, package_versions, world_class
from steadyload.errors import nearest
from steadyload.methods.simulation import loading
from steadyload.progress import Progress, silent
from steadyload.properties import closed_forms as closed_form_runs
from steadyload.runs.asked import Asked, asked, measured
from steadyload.runs.definition import StudyError
from steadyload.runs.pool import IN_THIS_PROCESS, PartLimit
from steadyload.runs.provenance import made_on, provenance
from steadyload.runs.store import Codec, Store, locked
from steadyload.runs.units import hard_seconds
from steadyload.studies.extremes import measuring as extreme_runs
from steadyload.studies.extremes import sweeps as sweeps_of
from steadyload.studies.extremes.measuring import Outcome
from steadyload.studies.extremes.sweeps import (
    FREQUENCIES,
    TIMEOUT,
    ExtremeCell,
    measure_cell,
    sweep_names,
    sweeps,
)

MadeBy = Mapping[str, str]
"""Versions of the parts and packages that a cell depends on, by name."""


class CellUnit(Asked[ExtremeCell], question="extremes"):
    """A cell to be measured."""

    sweep: str
    engine: str
    frequency: int | None
    value: float
    timeout: float
    made_by: MadeBy = asked("made by")

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
    return ExtremeCell(
        unit.sweep, unit.engine, unit.frequency, unit.value, Outcome.NO_VERDICT, note=reason
    )


def run_extremes(
    directory: Path,
    *,
    only_engines: Sequence[str] | None = None,
    only_sweeps: Sequence[str] | None = None,
    frequencies: Sequence[int] = FREQUENCIES,
    timeout: float = TIMEOUT,
    workers: int = IN_THIS_PROCESS,
    progress: Progress = silent,
) -> list[ExtremeCell]:
    """Measure the missing cells of sweeps; returns all selected cells, in the order of the page.

    A sweep that ends after some consecutive failures is measured value by value, so it has no cells
    beyond them.

    Args:
        directory: the run folder; made when it does not exist.
        only_engines: registered names; those of :func:`engines_here` if None.
        only_sweeps: names of sweeps; all if None.
        frequencies: substeps a second; an engine that chooses its own steps runs once.
        timeout: CPU seconds a cell may take.
        workers: see :func:`steadyload.runs.runner.run_study`.
        progress: called with cells done and the largest possible number of cells.

    Raises:
        StudyError: no engine or sweep of that name.
        EngineNotInstalledError: the library behind an engine is missing.
        ResultsError: another run is at work in the folder, or it holds something else.
        WorkerDiedError: see :func:`steadyload.runs.pool.run_units`.
    """
    names = _known(only_engines, engines_here(), registered(), "engine")
    picked = _known(only_sweeps, sweep_names(), sweep_names(), "sweep")
    with locked(directory):
        made_with = provenance()
        made_by = {engine: _made_by(engine) for engine in names}
        lines = [
            Line.of(sweep, engine, frequency, timeout, made_by[engine])
            for sweep in picked
            for engine in names
            for frequency in _frequencies(engine, frequencies)
        ]
        units = [unit for line in lines for unit in line.units]
        store = Store(directory / "cells", _CELLS)
        missing = store.survey(units).missing
        cells = {unit.key: store.read(unit.key) for unit in units if unit.key not in missing}
        while True:
            done = len(units) - sum(len(line.left(cells)) for line in lines)
            progress(done, len(units))
            waiting = [unit for line in lines for unit in line.measurable(cells)]
            if not waiting:
                break
            for engine in {unit.engine for unit in waiting}:
                world_class(engine).warm_up(0)  # compiled here, not in every worker
            store.complete(
                waiting,
                measured,
                crashed=cell_without_verdict,
                limit=PartLimit(hard_seconds(timeout), cell_without_verdict),
                workers=workers,
                progress=lambda new, _, done=done: progress(done + new, len(units)),
            )
            cells |= {unit.key: store.read(unit.key) for unit in waiting}
        manifest = {"engines": names, "sweeps": picked, "timeout": timeout, **made_with}
        write_atomically(directory / "manifest.json", json.dumps(manifest, indent=1) + "\n")
    return [cell for line in lines for cell in line.measured(cells)]


@dataclass(frozen=True, slots=True)
class Line:
    """All cells of one sweep on one engine at one frequency.

    Attributes:
        units: a unit a value, by rising value.
        stops: consecutive failures after which the sweep ends; None for never.
    """

    units: tuple[CellUnit, ...]
    stops: int | None

    @classmethod
    def of(
        cls, sweep: str, engine: str, frequency: int | None, timeout: float, made_by: MadeBy
    ) -> Line:
        """The line of a sweep."""
        own = sweeps()[sweep]
        units = (CellUnit(sweep, engine, frequency, v, timeout, made_by) for v in own.values)
        return cls(tuple(units), own.stops)

    def measured(self, cells: Mapping[str, ExtremeCell]) -> list[ExtremeCell]:
        """The cells of this line among some cells by key."""
        return [cells[unit.key] for unit in self.units if unit.key in cells]

    def measurable(self, cells: Mapping[str, ExtremeCell]) -> list[CellUnit]:
        """Units that can be measured now: one value at a time where a sweep may end."""
        left = self.left(cells)
        return left if self.stops is None else left[:1]

    def left(self, cells: Mapping[str, ExtremeCell]) -> list[CellUnit]:
        """Units that are still to be measured at most."""
        last = self.measured(cells)[-self.stops :] if self.stops else []
        if last and len(last) == self.stops and not any(cell.outcome.good for cell in last):
            return []
        return [unit for unit in self.units if unit.key not in cells]


def _encoded(answers: Sequence[ExtremeCell]) -> bytes:
    [cell] = answers
    return (json.dumps(dataclasses.asdict(cell), indent=1) + "\n").encode()


def _decoded(content: bytes) -> ExtremeCell:
    record = json.loads(content)
    return ExtremeCell(**{**record, "outcome": Outcome(record["outcome"])})


_CELLS: Codec[ExtremeCell, ExtremeCell] = Codec(".json", _encoded, _decoded)


def _made_by(engine: str) -> dict[str, str]:
    """Versions on which a cell depends besides its parameters."""
    parts = {
        "sweeps": sweeps_of.VERSION,
        "measuring": extreme_runs.VERSION,
        "closed forms": closed_form_runs.VERSION,
        "loading": loading.VERSION,
    }
    versions = {f"version of {part}": str(number) for part, number in parts.items()}
    return made_on(engine) | package_versions(("numpy", "scipy")) | versions


def _frequencies(engine: str, frequencies: Sequence[int]) -> tuple[int | None, ...]:
    own_steps = world_class(engine).capabilities.error_controlled
    return (None,) if own_steps else tuple(frequencies)


def _known(
    asked: Sequence[str] | None, unasked: Sequence[str], known: Any, what: str
) -> tuple[str, ...]:
    """The selected names, in the order of the page.

    Raises:
        StudyError: an unknown name.
    """
    if asked is None:
        return tuple(unasked)
    for name in asked:
        if name not in known:
            raise StudyError(f"unknown {what} {name!r}; {nearest(name, known)}")
    return tuple(name for name in known if name in asked)

"""Running the cells of the extremes: in rounds, over processes, resumable.

A run folder holds ``cells/*.json``, one file an engine and sweep, named by a key of all that its
cells depend on, and ``manifest.json``. Every file is whole or not there.
"""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from steadyload.atomic import write_atomically
from steadyload.engines.registry import engine_names, world_class
from steadyload.engines.registry import engines as registered
from steadyload.methods import loading
from steadyload.methods.spec import nearest
from steadyload.runs.definition import StudyError
from steadyload.runs.executors import IN_THIS_PROCESS, SinglePart, run_units
from steadyload.runs.provenance import key_of, made_on, package_versions, provenance
from steadyload.runs.results import ResultsError
from steadyload.runs.runner import locked
from steadyload.studies.closed_forms import measuring as closed_form_runs
from steadyload.studies.extremes import measuring as extreme_runs
from steadyload.studies.extremes import sweeps as sweeps_of
from steadyload.studies.extremes.records import ExtremeCell, Outcome
from steadyload.studies.extremes.sweeps import (
    FREQUENCIES,
    TIMEOUT,
    measure_cell,
    sweep_names,
    sweeps,
)

Key = tuple[int | None, float]
"""A cell's place in its sweep: frequency and value."""


@dataclass(frozen=True, slots=True)
class CellUnit(SinglePart):
    """A unit of work with one part: a cell."""

    sweep: str
    engine: str
    frequency: int | None
    value: float
    timeout: float

    def describe(self, part: int) -> str:
        """The cell for people."""
        rate = "" if self.frequency is None else f", {self.frequency} Hz"
        return f"{self.sweep} {self.value:g} on {self.engine}{rate}"


def measure_unit(unit: CellUnit) -> Iterator[ExtremeCell]:
    """Measure a unit's cell."""
    yield measure_cell(unit.sweep, unit.engine, unit.frequency, unit.value, unit.timeout)


def crashed_cell(unit: CellUnit, reason: str) -> ExtremeCell:
    """The cell of an engine that ends its process."""
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
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> list[ExtremeCell]:
    """Measure what is missing of the sweeps; returns all cells asked for, in order of the page.

    A sweep that stops after some failures in a row is measured value by value, so it has no cells
    beyond them.

    Args:
        directory: the run folder; made when it does not exist.
        only_engines: registered names; all that are compared unasked if None.
        only_sweeps: names of sweeps; all if None.
        frequencies: substeps a second; an engine that chooses its own steps runs once.
        timeout: wall seconds a cell may take.
        workers: see :func:`steadyload.runs.runner.run_study`.
        progress: called with cells done and the most that there can be.

    Raises:
        StudyError: no engine or sweep of that name.
        EngineNotInstalledError: the library behind an engine is missing.
        ResultsError: another run is at work in the folder, or it holds something else.
        WorkerDiedError: see :func:`steadyload.runs.executors.run_units`.
    """
    names = _known(only_engines, engine_names(), registered(), "engine")
    picked = _known(only_sweeps, sweep_names(), sweep_names(), "sweep")
    lines = [
        Line(sweep, engine, frequency)
        for sweep in picked
        for engine in names
        for frequency in _frequencies(engine, frequencies)
    ]
    if directory.exists() and not directory.is_dir():
        raise ResultsError(f"{directory}: is not a folder")
    (directory / "cells").mkdir(parents=True, exist_ok=True)
    with locked(directory):
        made_by = provenance()
        shards = {
            (sweep, engine): Shard(directory / "cells", sweep, engine, timeout)
            for sweep in picked
            for engine in names
        }
        most = sum(len(sweeps()[line.sweep].about.values) for line in lines)
        while True:
            waiting = [
                CellUnit(line.sweep, line.engine, line.frequency, value, timeout)
                for line in lines
                for value in line.next_values(shards[line.sweep, line.engine])
            ]
            left = {line: line.left(shards[line.sweep, line.engine]) for line in lines}
            progress(most - sum(left.values()), most)
            if not waiting:
                break
            measured = run_units(
                measure_unit,
                waiting,
                workers=workers,
                crashed=lambda unit, part, reason: crashed_cell(unit, reason),
            )
            for _, (cell,) in measured:
                shard = shards[cell.sweep, cell.engine]
                shard.add(cell)
                line = Line(cell.sweep, cell.engine, cell.frequency)
                left[line] = line.left(shard)
                progress(most - sum(left.values()), most)
        manifest = {"engines": names, "sweeps": picked, "timeout": timeout, **made_by}
        write_atomically(directory / "manifest.json", json.dumps(manifest, indent=1) + "\n")
    return [cell for line in lines for cell in line.cells(shards[line.sweep, line.engine])]


@dataclass(frozen=True, slots=True)
class Line:
    """All values of one sweep on one engine at one frequency."""

    sweep: str
    engine: str
    frequency: int | None

    def cells(self, shard: Shard) -> list[ExtremeCell]:
        """Cells that are there, values rising."""
        values = sweeps()[self.sweep].about.values
        found = (shard.cells.get((self.frequency, value)) for value in values)
        return [cell for cell in found if cell is not None]

    def next_values(self, shard: Shard) -> list[float]:
        """Values that can be measured now."""
        about = sweeps()[self.sweep].about
        missing = [v for v in about.values if (self.frequency, v) not in shard.cells]
        if about.stops is None:
            return missing
        return [] if not missing or self._stopped(shard) else missing[:1]

    def left(self, shard: Shard) -> int:
        """How many values are still to be measured, at most."""
        about = sweeps()[self.sweep].about
        if self._stopped(shard):
            return 0
        return sum((self.frequency, v) not in shard.cells for v in about.values)

    def _stopped(self, shard: Shard) -> bool:
        stops = sweeps()[self.sweep].about.stops
        if stops is None:
            return False
        last = self.cells(shard)[-stops:]
        return len(last) == stops and not any(cell.outcome.good for cell in last)


class Shard:
    """The cells of one engine and sweep, kept in a file that is rewritten with every cell.

    Args:
        folder: where the file lies.
        sweep, engine: whose cells they are.
        timeout: that they were measured under [s].
    """

    def __init__(self, folder: Path, sweep: str, engine: str, timeout: float) -> None:
        asked = {"question": "extremes", "sweep": sweep, "engine": engine, "timeout": timeout}
        self.path = folder / f"{key_of({**asked, 'made by': _made_by(engine)})}.json"
        self._about = {"sweep": sweep, "engine": engine}
        self.cells: dict[Key, ExtremeCell] = {}
        for record in self._read():
            cell = ExtremeCell(**{**record, "outcome": Outcome(record["outcome"])})
            self.cells[cell.frequency, cell.value] = cell

    def add(self, cell: ExtremeCell) -> None:
        """Keep a cell."""
        self.cells[cell.frequency, cell.value] = cell
        records = [dataclasses.asdict(c) for c in self.cells.values()]
        write_atomically(self.path, json.dumps({**self._about, "cells": records}) + "\n")

    def _read(self) -> list[dict[str, Any]]:
        """What is there; a file that cannot be read counts as not there."""
        try:
            return json.loads(self.path.read_bytes())["cells"]
        except (FileNotFoundError, ValueError):
            return []


def _made_by(engine: str) -> dict[str, str]:
    """What a cell comes from besides what is asked."""
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
    """The names asked for, in the order of the page.

    Raises:
        StudyError: a name nobody knows.
    """
    if asked is None:
        return tuple(unasked)
    for name in asked:
        if name not in known:
            raise StudyError(f"unknown {what} {name!r}; {nearest(name, known)}")
    return tuple(name for name in known if name in asked)

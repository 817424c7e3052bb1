"""Cost of judging: the timing pass, and batches of layouts for methods that judge them."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
import pandas as pd

from steadyload.layouts.benchmark import load_benchmark
from steadyload.layouts.model import Layout
from steadyload.learners import LearnerError
from steadyload.methods.method import Method
from steadyload.methods.registry import make_method
from steadyload.runs.pool import SinglePart
from steadyload.runs.provenance import key_of, made_by
from steadyload.runs.store import JSON, Store, locked
from steadyload.runs.timing import Times, taken
from steadyload.runs.timing import timed as taken_singly
from steadyload.studies.learned.plan import TablePlan

VERSION = 1
"""Version of how times are taken: raised when their meaning changes."""

_BATCH = "batch"
"""The parameter of a method that judges many layouts at once."""


@dataclass(frozen=True)
class BatchUnit(SinglePart):
    """A unit of work: the timing of methods that judge many layouts at once.

    Attributes:
        methods: spec strings of methods that judge batches.
        layouts: that every method judges.
        repeats: number of repetitions, all methods in turns.
        batches: batch sizes.
    """

    methods: tuple[str, ...]
    layouts: tuple[Layout, ...]
    repeats: int
    batches: tuple[int, ...]

    def describe(self, part: int) -> str:
        """Description of the unit for messages."""
        return f"timing batches of {len(self.methods)} methods on {len(self.layouts)} layouts"

    @cached_property
    def key(self) -> str:
        """Hash of everything that the times depend on."""
        identity = {
            "question": "times in batches",
            "version": VERSION,
            "made by": {spec: made_by(make_method(spec)) for spec in self.methods},
            "layouts": [layout.content_hash() for layout in self.layouts],
            "repeats": self.repeats,
            "batches": list(self.batches),
        }
        return f"times-{key_of(identity)}"


Batched = Mapping[int, tuple[float, float]]
"""Batch size -> CPU and wall time a layout [ms]."""


@dataclass(frozen=True)
class TableTimes:
    """Times of all methods of the table.

    ``single``: of the timing pass, one layout at a time. ``batched``: by spec; empty for a method
    without batches.
    """

    single: Times
    batched: Mapping[str, Batched]


def timed(
    table: TablePlan, methods: Sequence[str], cases: pd.DataFrame, folder: Path, *, workers: int
) -> TableTimes:
    """Times of the methods of a table; stored in the folder, and not taken again.

    Args:
        table: with the repetitions and batch sizes.
        methods: specs.
        cases: of the labelled set, by layout and scenario.
        folder: made when it does not exist.
        workers: 0 times in this process, any other number in one with a single thread.

    Raises:
        LearnerError: a method ended its process while many layouts were judged at once.
        ResultsError: a method ended its process while layouts were judged one at a time.
    """
    benchmark = load_benchmark()
    layouts = tuple(
        benchmark.layout(name, scenario)
        for name, scenario in zip(cases["layout"], cases["scenario"], strict=True)
    )
    # A block of all layouts, as in batches.
    single = taken_singly(
        methods, layouts, folder / "times", repeats=table.repeats, block=len(layouts),
        workers=workers,
    )  # fmt: skip
    able = tuple(spec for spec in methods if _knows_batches(spec))
    batched: dict[str, Batched] = {spec: {} for spec in methods}
    if able and table.batches:
        unit = BatchUnit(able, layouts, table.repeats, table.batches)
        batched |= _timed_batches(unit, folder, workers)
    return TableTimes(single, batched)


def _timed_batches(unit: BatchUnit, folder: Path, workers: int) -> dict[str, Batched]:
    with locked(folder):
        store = Store(folder, JSON)
        store.complete([unit], _time, lost=_refuse, workers=min(workers, 1))
        [times] = store.read(unit.key)
    return {
        spec: {int(size): (cpu, wall) for size, (cpu, wall) in sizes.items()}
        for spec, sizes in times.items()
    }


def _refuse(unit: BatchUnit, reason: str) -> NoReturn:
    raise LearnerError(f"{unit.describe(0)}: {reason}")


def _time(unit: BatchUnit) -> Iterator[dict[str, Any]]:
    return (_times(unit) for _ in range(1))


def _times(unit: BatchUnit) -> dict[str, Any]:
    most = max(map(len, unit.layouts))
    methods = {(spec, size): _at_once(spec, size) for spec in unit.methods for size in unit.batches}
    for method in methods.values():
        method.prepare(most)
        method.judge(unit.layouts[0])
    found: dict[tuple[str, int], list[tuple[float, float]]] = {each: [] for each in methods}
    for _ in range(unit.repeats):
        for each, method in methods.items():
            cpu, wall = taken(partial(method.judge_many, unit.layouts))
            found[each].append((cpu / len(unit.layouts), wall / len(unit.layouts)))
    return {
        spec: {str(size): np.median(found[spec, size], axis=0).tolist() for size in unit.batches}
        for spec in unit.methods
    }


def _knows_batches(spec: str) -> bool:
    return _BATCH in {f.name for f in dataclasses.fields(make_method(spec).parameters)}


def _at_once(spec: str, size: int) -> Method:
    """The method with a batch size."""
    plain = str(make_method(spec).spec)
    return make_method(f"{plain}{',' if ':' in plain else ':'}{_BATCH}={size}")

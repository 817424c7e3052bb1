"""Cost of judging batches of layouts, for methods that judge several at once."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from steadyload.layouts.model.layout import Layout
from steadyload.methods.contract.method import Method
from steadyload.methods.registry import make_method
from steadyload.runs.asked import Asked, asked, measured
from steadyload.runs.provenance import made_by
from steadyload.runs.store import JSON, Store, locked
from steadyload.runs.timing import taken
from steadyload.studies.learned.summary import Batched

VERSION = 1
"""Version of how times are taken: raised when their meaning changes."""

_BATCH = "batch"
"""The parameter of a method that judges many layouts at once."""


class BatchUnit(
    Asked[dict[str, Any]], question="times in batches", version=VERSION, prefix="times-"
):
    """The timing of methods that judge many layouts at once.

    Attributes:
        made_by: of each method that judges batches, by its spec.
        layouts: that every method judges.
        repeats: number of repetitions, all methods in turns.
        batches: batch sizes.
    """

    made_by: Mapping[str, Mapping[str, str]] = asked("made by")
    layouts: tuple[Layout, ...]
    repeats: int
    batches: tuple[int, ...]

    def describe(self, part: int) -> str:
        """Description of the unit for messages."""
        return f"timing batches of {len(self.made_by)} methods on {len(self.layouts)} layouts"

    def measure(self) -> dict[str, Any]:
        """Medians of CPU and wall time of a layout [ms], by spec and batch size."""
        most, layouts = max(map(len, self.layouts)), self.layouts
        methods = {(spec, n): _at_once(spec, n) for spec in self.made_by for n in self.batches}
        for method in methods.values():
            method.prepare(most)
            method.judge(layouts[0])
        found: dict[tuple[str, int], list[tuple[float, float]]] = {each: [] for each in methods}
        for _ in range(self.repeats):
            for each, method in methods.items():
                cpu, wall = taken(partial(method.judge_many, layouts))
                found[each].append((cpu / len(layouts), wall / len(layouts)))
        return {
            spec: {str(n): np.median(found[spec, n], axis=0).tolist() for n in self.batches}
            for spec in self.made_by
        }


def timed_batches(
    methods: Sequence[str],
    layouts: Sequence[Layout],
    folder: Path,
    *,
    repeats: int,
    batches: tuple[int, ...],
    workers: int,
) -> dict[str, Batched]:
    """Times by spec of the methods that judge batches; stored in the folder, and not taken again.

    Args:
        methods: spec strings; those that judge one layout at a time are left out.
        layouts: that every method judges.
        folder: made when it does not exist.
        repeats: number of repetitions, all methods in turns.
        batches: batch sizes.
        workers: 0 times in this process, any other number in one with a single thread.

    Raises:
        ResultsError: a method ended its process.
    """
    able = tuple(spec for spec in methods if _knows_batches(spec))
    if not (able and batches):
        return {}
    made = {spec: made_by(make_method(spec)) for spec in able}
    unit = BatchUnit(made, tuple(layouts), repeats, batches)
    with locked(folder):
        store = Store(folder, JSON)
        store.complete([unit], measured, workers=min(workers, 1))
        [times] = store.read(unit.key)
    return {
        spec: {int(size): (cpu, wall) for size, (cpu, wall) in sizes.items()}
        for spec, sizes in times.items()
    }


def _knows_batches(spec: str) -> bool:
    return _BATCH in {f.name for f in dataclasses.fields(make_method(spec).parameters)}


def _at_once(spec: str, size: int) -> Method:
    """The method with a batch size."""
    plain = str(make_method(spec).spec)
    return make_method(f"{plain}{',' if ':' in plain else ':'}{_BATCH}={size}")

"""What judging costs, all methods in turns, in one process and one thread."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from pathlib import Path
from typing import Any, NoReturn

import numpy as np

from steadyload.layouts.model import Layout
from steadyload.learners import LearnerError
from steadyload.methods.method import Method
from steadyload.methods.registry import make_method
from steadyload.runs.executors import SinglePart
from steadyload.runs.provenance import key_of, made_by
from steadyload.runs.store import JSON, Store, locked
from steadyload.runs.timing import machine_load, taken

VERSION = 1
"""Of how times are taken: raised when they would mean something else."""

_BATCH = "batch"
"""The parameter of a method that judges many layouts at once."""


@dataclass(frozen=True)
class TimingUnit(SinglePart):
    """What is timed.

    Attributes:
        methods: spec strings.
        layouts: that every method judges, one at a time.
        repeats: how often, all methods in turns.
        batches: layouts at once, where a method knows batches.
    """

    methods: tuple[str, ...]
    layouts: tuple[Layout, ...]
    repeats: int
    batches: tuple[int, ...]

    def describe(self, part: int) -> str:
        """The unit for people."""
        return f"timing {len(self.methods)} methods on {len(self.layouts)} layouts"

    @cached_property
    def key(self) -> str:
        """Key of all that times are of."""
        made = key_of(
            {
                "question": "times in turns and in batches",
                "version": VERSION,
                "made by": {spec: made_by(make_method(spec)) for spec in self.methods},
                "layouts": [layout.content_hash() for layout in self.layouts],
                "repeats": self.repeats,
                "batches": list(self.batches),
            }
        )
        return f"times-{made}"


Times = dict[str, Any]
"""``load``, and ``methods``: by spec ``cpu`` and ``wall`` [ms a layout] one at a time, and
``batched``: by number at once, as text, a pair of the same."""


def timed(unit: TimingUnit, folder: Path, *, workers: int) -> Times:
    """Times of a unit; kept in the folder, and taken again only for another unit.

    Args:
        unit: what to time.
        folder: made when it does not exist.
        workers: 0 times in this process, any other number in one with a single thread.

    Raises:
        LearnerError: a method ended its process.
    """
    with locked(folder):
        store = Store(folder, JSON)
        store.complete([unit], _time, lost=_refuse, workers=min(workers, 1))
        [times] = store.read(unit.key)
    return times


def _refuse(unit: TimingUnit, reason: str) -> NoReturn:
    raise LearnerError(f"{unit.describe(0)}: {reason}")


def _time(unit: TimingUnit) -> Iterator[Times]:
    return (_times(unit) for _ in range(1))


def _times(unit: TimingUnit) -> Times:
    methods = {spec: make_method(spec) for spec in unit.methods}
    batched = {spec: _batched(method, unit.batches) for spec, method in methods.items()}
    for method in methods.values():
        method.prepare(max(map(len, unit.layouts)))
        method.judge(unit.layouts[0])
    load = machine_load()
    single: dict[str, list[tuple[float, float]]] = {spec: [] for spec in methods}
    many: dict[str, dict[int, list[tuple[float, float]]]] = {
        spec: {size: [] for size in sizes} for spec, sizes in batched.items()
    }
    for _ in range(unit.repeats):
        for spec, method in methods.items():
            single[spec].append(_taken(partial(_one_by_one, method), unit.layouts))
            for size, judge in batched[spec].items():
                many[spec][size].append(_taken(judge.judge_many, unit.layouts))
    return {
        "load": load,
        "methods": {
            spec: {
                "cpu": _medians(taken)[0],
                "wall": _medians(taken)[1],
                "batched": {str(size): _medians(each) for size, each in many[spec].items()},
            }
            for spec, taken in single.items()
        },
    }


def _batched(method: Method, sizes: Sequence[int]) -> Mapping[int, Method]:
    """The method for every number of layouts at once; none where it knows no batches."""
    if _BATCH not in {f.name for f in dataclasses.fields(method.parameters)}:
        return {}
    plain = str(method.spec)
    mark = "," if ":" in plain else ":"
    return {size: make_method(f"{plain}{mark}{_BATCH}={size}") for size in sizes}


def _one_by_one(method: Method, layouts: Sequence[Layout]) -> None:
    for layout in layouts:
        method.judge(layout)


def _taken(
    judge: Callable[[Sequence[Layout]], object], layouts: Sequence[Layout]
) -> tuple[float, float]:
    """CPU and wall time a layout [ms]."""
    cpu, wall = taken(partial(judge, layouts))
    return cpu / len(layouts), wall / len(layouts)


def _medians(taken: Sequence[tuple[float, float]]) -> list[float]:
    return np.median(np.array(taken), axis=0).tolist()

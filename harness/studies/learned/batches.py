"""Cost of judging batches of layouts, for methods that judge several at once."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from pathlib import Path
from typing import Any, NoReturn

import numpy as np

from steadyload.layouts.model.layout import Layout
from steadyload.learners import LearnerError
from steadyload.methods.contract.method import Method
from steadyload.methods.registry import make_method
from steadyload.runs.pool import SinglePart
from steadyload.runs.provenance import key_of, made_by
from steadyload.runs.store import JSON, Store, locked
from steadyload.runs.timing import taken
from steadyload.studies.learned.summary import Batched

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
        LearnerError: a method ended its process.
    """
    able = tuple(spec for spec in methods if _knows_batches(spec))
    if not (able and batches):
        return {}
    unit = BatchUnit(able, tuple(layouts), repeats, batches)
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

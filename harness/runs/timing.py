"""Controlled timing pass: one process, one thread, methods in turns on equal layouts.

Times of a study over several processes allow ratios at best. Here every method judges a block of
layouts before it is the next one's turn, so that a disturbance of the machine affects all of them;
the first method changes from block to block; and everything is repeated.
"""

from __future__ import annotations

import dataclasses
import logging
import os
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from operator import attrgetter
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from steadyload.atomic import manifest_text, verified_manifest, write_atomically
from steadyload.layouts.model.layout import Layout
from steadyload.methods.contract.method import judge
from steadyload.methods.registry import make_method
from steadyload.progress import Progress, silent
from steadyload.reading import MAX_STORED_BYTES, content_of, json_of
from steadyload.runs.asked import Asked, asked, kept_rows
from steadyload.runs.methods_here import method_named
from steadyload.runs.provenance import made_by
from steadyload.runs.store import JSON, Store
from steadyload.runs.units import MadeBy, made_now

VERSION = 1
"""Version of how times are taken: raised when their meaning changes."""

_WHILE_JUDGING = "load of the machine"
_BATCH = "batch"
"""The parameter of a method that judges many layouts at once."""

_log = logging.getLogger("steadyload")

BLOCK = 50
"""Layouts that a method judges in a turn; long turns, because a switch of methods costs time."""


def taken(work: Callable[[], object]) -> tuple[float, float]:
    """CPU time of this process and wall time of some work [ms]."""
    cpu, wall = time.process_time(), time.perf_counter()
    work()
    cpu, wall = time.process_time() - cpu, time.perf_counter() - wall
    return 1e3 * cpu, 1e3 * wall


def machine_load() -> float | None:
    """Mean number of runnable processes in the last minute; None where the system has none."""
    return os.getloadavg()[0] if hasattr(os, "getloadavg") else None


def load_while(judge: Callable[[], int], file: Path) -> float | None:
    """Judge what is missing; the load of the machine meanwhile, or that of the time before.

    Args:
        judge: what is done; returns 0 where nothing was missing.
        file: where the load is written down, and read where nothing was missing.

    Returns:
        The larger one of the loads before and after; None where it is not known.
    """
    before = machine_load()
    if not judge():
        return kept_load(file)
    after = machine_load()
    load = None if before is None or after is None else max(before, after)
    write_atomically(file, manifest_text({_WHILE_JUDGING: load}))
    return load


def kept_load(file: Path) -> float | None:
    """The load that was written down; unknown where it was not, or is damaged."""
    if not file.exists():
        return None
    try:
        load = verified_manifest(json_of(content_of(file, MAX_STORED_BYTES)))[_WHILE_JUDGING]
        if isinstance(load, bool) or not isinstance(load, int | float | None):
            raise ValueError
    except (LookupError, RecursionError, TypeError, ValueError):
        _log.warning("%s: is damaged; the load of the machine is not known", file)
        return None
    return load


TimedCases = tuple[tuple[str, str], ...]
"""Name and content hash of each layout that was timed."""


def _timed_cases(layouts: Iterable[Layout]) -> TimedCases:
    return tuple((layout.name, layout.content_hash()) for layout in layouts)


@dataclass(frozen=True)
class TurnTimes:
    """Times of a turn, as they are kept.

    Attributes:
        cases: that were timed; those kept by an earlier version may not say.
        cpu, wall: by method, of each case [ms].
        load: of the machine meanwhile; None where the system does not tell.
    """

    cpu: Mapping[str, tuple[float, ...]]
    wall: Mapping[str, tuple[float, ...]]
    load: float | None = None
    cases: TimedCases = ()


class Turn(Asked[TurnTimes], what="times in turns", version=VERSION, prefix="times-"):
    """All methods judge a block of layouts, one method after the other.

    Attributes:
        made_by: of each method, by its spec.
        layouts: that every method judges, one at a time.
        block: layouts of a turn at most.
        number: of this turn, counted from 0; the method that is first changes with it.
    """

    made_by: Mapping[str, MadeBy] = asked("made by")
    layouts: tuple[Layout, ...]
    block: int
    number: int = asked("repeat")

    def describe(self, part: int) -> str:
        """Description of the unit for messages."""
        return (
            f"timing {len(self.made_by)} methods on {len(self.layouts)} layouts, turn {self.number}"
        )

    def measure(self) -> TurnTimes:
        """See :class:`TurnTimes`."""
        names = tuple(self.made_by)
        methods = {spec: method_named(spec) for spec in names}
        for method in methods.values():
            method.prepare(max(map(len, self.layouts)))
        before = machine_load()
        found: dict[str, list[tuple[float, float]]] = {}
        first = self.number % len(names)
        for spec in [*names[first:], *names[:first]]:
            method = methods[spec]
            # The state of the caches after the previous method is not to count.
            judge(method, self.layouts[0])
            found[spec] = [taken(partial(judge, method, layout)) for layout in self.layouts]
        after = machine_load()
        return TurnTimes(
            cpu={spec: tuple(cpu for cpu, _ in found[spec]) for spec in names},
            wall={spec: tuple(wall for _, wall in found[spec]) for spec in names},
            load=None if before is None or after is None else max(before, after),
            cases=_timed_cases(self.layouts),
        )


@dataclass(frozen=True)
class Times:
    """Measured times of methods.

    Attributes:
        cpu, wall: by method [ms], shape (repeats, layouts).
        load: the most processes that wanted to run while times were taken, one of them ours; None
            where the system does not tell.
        made_with: provenance of the last block, as a page shows it; empty where it is not known.
    """

    cpu: dict[str, NDArray[np.float64]]
    wall: dict[str, NDArray[np.float64]]
    load: float | None
    made_with: Mapping[str, str] = field(default_factory=dict)


def timed(
    methods: Sequence[str],
    layouts: Iterable[Layout],
    folder: Path,
    *,
    repeats: int,
    block: int = BLOCK,
    workers: int = 1,
    progress: Progress = silent,
) -> Times:
    """Times of methods on the same layouts; every block is stored, and not taken again.

    A block counts as taken when methods, their versions, layouts and packages were the same.

    Args:
        methods: spec strings; without any there is nothing to time.
        layouts: that every method judges.
        folder: where times are kept; made when it does not exist.
        repeats: number of times that every layout is judged.
        block: layouts that a method judges in a turn.
        workers: 0 times in this process, any other number in one beside it, with a single thread.
        progress: called with blocks done and blocks in all, over all repeats.

    Raises:
        ResultsError: a method ended its process.
        WorkerDiedError: see :func:`steadyload.runs.pool.run_units`.
    """
    if not methods:
        return Times({}, {}, None)
    chosen = tuple(layouts)
    named = {spec: make_method(spec) for spec in methods}
    made = made_now(named.values())
    blocks = [chosen[start : start + block] for start in range(0, len(chosen), block)]
    turns = [Turn(made, own, block, number) for number, own in enumerate(blocks * repeats)]
    kept, made_with = kept_rows(
        folder, turns, TurnTimes, workers=min(workers, 1), progress=progress
    )
    loads = [turn.load for turn in kept if turn.load is not None]
    cpu, wall = (
        {
            spec: np.concatenate([clock(turn)[str(one)] for turn in kept]).reshape(repeats, -1)
            for spec, one in named.items()
        }
        for clock in (attrgetter("cpu"), attrgetter("wall"))
    )
    return Times(cpu, wall, max(loads) if len(loads) == len(kept) else None, made_with)


def kept_times(folder: Path) -> pd.DataFrame:
    """Times that :func:`timed` has kept in a folder, which need not exist.

    Returns:
        A row a method and layout: ``method``, ``layout``, ``layout_hash``, ``timed_cpu_ns`` and
        ``timed_wall_ns``, medians of all repeats; without those that do not name their layouts.

    Raises:
        DamagedError: a file has changed since it was written.
    """
    store: Store[dict[str, Any], list[dict[str, Any]]] = Store(folder, JSON)
    turns = [
        turn
        for key in store.keys()  # noqa: SIM118 - a store is no mapping
        for turn in store.read(key)
        if "by_size" not in turn
    ]
    rows = [
        (spec, name, digest, cpu, wall)
        for turn in turns
        for spec in turn["cpu"]
        for (name, digest), cpu, wall in zip(
            turn.get("cases", ()), turn["cpu"][spec], turn["wall"][spec], strict=False
        )
    ]
    case = ["method", "layout", "layout_hash"]
    found = pd.DataFrame(rows, columns=[*case, "timed_cpu_ns", "timed_wall_ns"])
    return (1e6 * found.groupby(case, sort=False).median()).round().reset_index()


@dataclass(frozen=True)
class BatchTimes:
    """Times of methods that judge many layouts at once, as they are kept.

    Attributes:
        cases: that were timed.
        by_size: by spec and batch size, medians of CPU and wall time of a layout [ms].
    """

    cases: TimedCases
    by_size: Mapping[str, Mapping[str, tuple[float, float]]]


class BatchUnit(Asked[BatchTimes], what="times in batches", version=VERSION, prefix="times-"):
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

    def measure(self) -> BatchTimes:
        """See :class:`BatchTimes`."""
        most, layouts = max(map(len, self.layouts)), self.layouts
        methods = {
            (spec, n): make_method(str(make_method(spec).spec.stating(_BATCH, n)))
            for spec in self.made_by
            for n in self.batches
        }
        for method in methods.values():
            method.prepare(most)
            method.judge(layouts[0])
        found: dict[tuple[str, int], list[tuple[float, float]]] = {each: [] for each in methods}
        for _ in range(self.repeats):
            for each, method in methods.items():
                cpu, wall = taken(partial(method.judge_many, layouts))
                found[each].append((cpu / len(layouts), wall / len(layouts)))
        medians = {each: np.median(times, axis=0).tolist() for each, times in found.items()}
        return BatchTimes(
            cases=_timed_cases(layouts),
            by_size={
                spec: {str(n): tuple(medians[spec, n]) for n in self.batches}
                for spec in self.made_by
            },
        )


def timed_batches(
    methods: Sequence[str],
    layouts: Sequence[Layout],
    folder: Path,
    *,
    repeats: int,
    batches: tuple[int, ...],
    workers: int = 1,
) -> dict[str, dict[int, tuple[float, float]]]:
    """CPU and wall time a layout [ms] by method and batch size; kept, and not taken again.

    Args:
        methods: spec strings; those that judge one layout at a time are left out.
        layouts: that every method judges.
        folder: where times are kept; made when it does not exist.
        repeats: number of repetitions, all methods in turns.
        batches: batch sizes.
        workers: see :func:`timed`.

    Raises:
        ResultsError: a method ended its process.
    """
    named = {spec: make_method(spec) for spec in methods}
    able = {
        spec: made_by(method)
        for spec, method in named.items()
        if _BATCH in {f.name for f in dataclasses.fields(method.parameters)}
    }
    if not (able and batches):
        return {}
    unit = BatchUnit(able, tuple(layouts), repeats, batches)
    [times], _ = kept_rows(folder, [unit], BatchTimes, workers=min(workers, 1))
    return {
        spec: {int(size): both for size, both in sizes.items()}
        for spec, sizes in times.by_size.items()
    }

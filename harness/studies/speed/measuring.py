"""Measurement of CPU times in turns: all work is repeated side by side, in one process."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from steadyload.layouts.model.batch import LayoutBatch
from steadyload.layouts.model.layout import Item, Layout
from steadyload.methods.contract.method import Method, NotBatchedError, verdict_by
from steadyload.methods.contract.verdict import STABLE
from steadyload.methods.session.session import LoadingSession
from steadyload.progress import Progress
from steadyload.runs.timing import taken
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.metrics import median

_LEAST = 2e-3
"""CPU time of a repeat at least [s]; shorter work is done several times."""

ENOUGH = 6.0
"""CPU time of all repeats of one work after which it is not repeated again [s]."""

POSITIONS = 1000
"""Positions that are judged at once."""

_SEED = 0

Work = Callable[[], float]
"""Does something, and says how many CPU seconds it took of what is measured."""


@dataclass(slots=True)
class Job:
    """Work that is measured: ``count`` equal parts; ``seconds`` of one part in every repeat."""

    work: Work
    count: int = 1
    seconds: list[float] = field(default_factory=list)

    @property
    def microseconds(self) -> Estimate:
        """CPU time of one part: the median of the repeats."""
        return median([1e6 * each for each in self.seconds])


def measure(
    jobs: Sequence[Job],
    repeats: int,
    progress: Progress,
    *,
    enough: float = ENOUGH,
) -> None:
    """Repeat all jobs in turns, the first one changing.

    Every job is done once before, which is not counted, and not again after ``enough`` CPU
    seconds.
    """
    loops, spent = [], [0.0] * len(jobs)
    for job in jobs:
        first = max(job.work(), 1e-7)
        loops.append(math.ceil(_LEAST / first))
    for repeat in range(repeats):
        progress(repeat, repeats)
        start = repeat * len(jobs) // max(repeats, 1)
        for place in [*range(start, len(jobs)), *range(start)]:
            if spent[place] > enough:
                continue
            job = jobs[place]
            seconds = sum(job.work() for _ in range(loops[place]))
            spent[place] += seconds
            job.seconds.append(seconds / loops[place] / job.count)


def _timed(call: Callable[[], object]) -> Work:
    return lambda: 1e-3 * taken(call)[0]


def looping(layouts: Sequence[Layout]) -> Job:
    """A Python loop over layouts that does nothing."""

    def loop() -> None:
        for _ in layouts:
            pass

    return Job(_timed(loop), len(layouts))


def empty_verdicts(layouts: Sequence[Layout]) -> Job:
    """A verdict on every layout, with its times, by a method that does nothing."""

    def loop() -> None:
        for layout in layouts:
            verdict_by(lambda watch: STABLE, len(layout), None)

    return Job(_timed(loop), len(layouts))


def judging(method: Method, layouts: Sequence[Layout]) -> Job:
    """Judgements of layouts one by one."""

    def loop() -> None:
        judge = method.judge
        for layout in layouts:
            judge(layout)

    return Job(_timed(loop), len(layouts))


def judging_together(method: Method, layouts: Sequence[Layout]) -> Job | None:
    """Judgements of all layouts at once; None for a method that judges one layout at a time.

    The batch is made before.
    """
    batch = LayoutBatch.of(layouts)
    try:
        method.evaluate(LayoutBatch.of(layouts[:1]))
    except NotBatchedError:
        return None
    return Job(_timed(lambda: method.evaluate(batch)), len(layouts))


def placing(method: Method, layouts: Sequence[Layout]) -> Job:
    """Placements of items in sessions: of every layout up to the first that fails."""

    def placements(layout: Layout) -> tuple[int, float]:
        with LoadingSession(layout.pallet, method) as session:
            start, placed = time.process_time(), 0
            for item in layout.items:
                placed += 1
                if not session.try_place(item).stable:
                    break
            return placed, time.process_time() - start

    def work() -> float:
        return sum(placements(layout)[1] for layout in layouts)

    return Job(work, sum(placements(layout)[0] for layout in layouts))


def judging_positions(method: Method, layout: Layout) -> Job:
    """Judgements of positions of the last item of a layout, on all others, which are stable."""
    session = LoadingSession(layout.pallet, method)
    for item in layout.items[:-1]:
        session.try_place(item)
    item = layout.items[-1]
    positions = _positions(item, layout)
    return Job(_timed(lambda: session.feasible(item, positions)), POSITIONS)


def _positions(item: Item, layout: Layout) -> np.ndarray:
    """Positions of an item drawn over the deck, each on the highest top below it."""
    random = np.random.default_rng(_SEED)
    deck, base = np.array(layout.pallet.size)[::2], np.array(item.size)[::2]
    low = random.uniform(0.0, np.maximum(deck - base, 0.0), (POSITIONS, 2))
    high = low + base
    others, tops = layout.lower[:-1, ::2], layout.upper[:-1, 1]
    beneath = (low[:, None] < layout.upper[:-1, ::2]) & (high[:, None] > others)
    height = np.where(beneath.all(axis=2), tops, 0.0).max(axis=1, initial=0.0)
    return np.column_stack((low[:, 0], height, low[:, 1]))

"""Cost of a judgement by number of items, of layouts that are stable throughout."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from steadyload.layouts.model.layout import Layout
from steadyload.methods.contract.method import Method, Status
from steadyload.progress import NamedProgress, silent
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.growth import exponent
from steadyload.statistics.metrics import median
from steadyload.studies.speed.measuring import Job, judging, judging_together, measure
from steadyload.studies.speed.records import GrowthCurve, GrowthPoint, Kind
from steadyload.studies.speed.scenes import Scene, Source

ITEM_COUNTS = (10, 20, 50, 100, 200)
LATE = 50
"""Number of items from which on the second exponent is fitted."""

_COPIES = (5, 200)
"""Fewest and most layouts of a batch, all the same."""

_BATCH = 5e-3
"""CPU time of a batch, about, between these numbers [s]."""

_ENOUGH = 1.0
"""CPU time of one layout's judgements after which they are not repeated again [s]."""


@dataclass(frozen=True, slots=True)
class _Key:
    """Key of a job; ``source`` is the place of the layout in the scene."""

    kind: Kind
    scene: str
    method: str
    items: int
    source: int
    joined: bool


def growth_curves(
    methods: Mapping[str, Method],
    scenes: Sequence[Scene],
    counts: Sequence[int],
    *,
    repeats: int,
    patience: float,
    progress: NamedProgress = silent,
) -> list[GrowthCurve]:
    """Cost by number of items: a curve a scene and method.

    A size is measured on the layouts of the scene whose first items the method calls stable, so
    that every item is judged. A curve has no point where there is none.

    Args:
        methods: by spec.
        scenes: that are judged.
        counts: numbers of items.
        repeats: of every judgement.
        patience: seconds after which a judgement is given up.
        progress: called with each scene and method, then with repeats done and repeats in all.
    """
    jobs = []
    for scene in scenes:
        for spec, method in methods.items():
            progress(f"{scene.name}, {spec}")
            sources = scene.sources(method, patience)
            for count in counts:
                for place, layout, seconds in _stable(method, sources, count, patience):
                    of = (scene.name, spec, count, place, count > sources[place].alone)
                    jobs.append(Job(_Key(Kind.JUDGE, *of), 1, judging(method, [layout])))
                    copies = int(np.clip(_BATCH / max(seconds, 1e-9), *_COPIES))
                    together = judging_together(method, [layout] * copies)
                    if together is not None:
                        jobs.append(Job(_Key(Kind.BATCH, *of), copies, together))
    measure(jobs, repeats, partial(progress, "growth"), enough=_ENOUGH)
    return [_curve(scene.name, spec, jobs) for scene in scenes for spec in methods]


def _stable(
    method: Method, sources: Sequence[Source], count: int, patience: float
) -> Iterator[tuple[int, Layout, float]]:
    """Places of sources, their first items, and the seconds that their judgement took."""
    for place, source in enumerate(sources):
        if len(source.layout) >= count:
            part = source.layout.first(count)
            verdict = method.judge(part, timeout=patience)
            if verdict.status is Status.DONE and verdict.stable:
                yield place, part, verdict.cpu.total


def _curve(scene: str, spec: str, jobs: Sequence[Job]) -> GrowthCurve:
    alone = _taken(Kind.JUDGE, scene, spec, jobs)
    batch = _taken(Kind.BATCH, scene, spec, jobs)
    points = [
        GrowthPoint(
            count,
            sum(key.joined for key, _ in alone if key.items == count),
            median([cost for key, cost in alone if key.items == count]),
            median([cost for key, cost in batch if key.items == count]),
        )
        for count in sorted({key.items for key, _ in alone})
    ]
    late = [(key, cost) for key, cost in alone if key.items >= LATE]
    return GrowthCurve(scene, spec, tuple(points), _fit(alone), _fit(late), _fit(batch))


def _taken(kind: Kind, scene: str, spec: str, jobs: Sequence[Job]) -> list[tuple[_Key, float]]:
    """The cost of every layout [us], the median of its repeats."""
    found = []
    for job in jobs:
        assert isinstance(job.key, _Key)
        if (job.key.kind, job.key.scene, job.key.method) == (kind, scene, spec):
            found.append((job.key, 1e6 * float(np.median(job.seconds))))
    return found


def _fit(taken: Sequence[tuple[_Key, float]]) -> Estimate:
    sizes, costs = [key.items for key, _ in taken], [cost for _, cost in taken]
    return exponent(sizes, costs, [key.source for key, _ in taken])

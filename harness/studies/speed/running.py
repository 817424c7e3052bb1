"""The benchmark: what judgements cost, measured side by side in one process."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from itertools import product
from typing import Any, NamedTuple

import numpy as np

from steadyload.layouts.model.layout import Layout
from steadyload.methods.contract.declared import Trait
from steadyload.methods.contract.method import Method, Status
from steadyload.methods.registry import make_method
from steadyload.progress import NamedProgress, silent
from steadyload.runs.provenance import machine_kind, provenance_lines
from steadyload.runs.timing import machine_load
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.growth import exponent
from steadyload.statistics.metrics import median, ratio
from steadyload.studies.speed.measuring import (
    Job,
    empty_verdicts,
    judging,
    judging_positions,
    judging_together,
    looping,
    measure,
    placing,
)
from steadyload.studies.speed.records import LATE, CaseSet, Cost, Found, Growth, GrowthPoint
from steadyload.studies.speed.scenes import FULL, PILES, Extent, Source, joined, piles

ITEM_COUNTS = (10, 20, 50, 100, 200)

_EVERY = 10
_LONGEST = 10.0
"""CPU time of judging a set once above which only every tenth layout is judged [s]."""

_COPIES = (5, 200)
"""Fewest and most layouts of a batch, all the same."""

_BATCH = 5e-3
"""CPU time of a batch, about, between these numbers [s]."""

_ENOUGH = 1.0
"""CPU time of one layout's judgements after which they are not repeated again [s]."""


def run_speed(
    specs: Sequence[str],
    sets: Mapping[str, Sequence[Layout]],
    extent: Extent,
    progress: NamedProgress,
) -> Found:
    """Measure methods on sets of layouts, the first of which is the labelled one."""
    methods = {spec: make_method(spec) for spec in specs}
    largest = max(len(layout) for layouts in sets.values() for layout in layouts)
    for spec, method in methods.items():
        progress(f"{spec}: prepared")
        method.prepare(max(largest, extent.most_items))
    before, made_with = machine_load(), provenance_lines()
    cases, costs = [], []
    for name, layouts in sets.items():
        own, of_methods = _on_a_set(name, layouts, methods, extent, progress)
        cases.append(own)
        costs += of_methods
    packed = piles(extent)
    scenes: dict[str, Callable[[Method], Sequence[Source]]] = {PILES: lambda method: packed}
    for name, layouts in list(sets.items())[1:]:
        scenes[name] = partial(joined, name, layouts, extent)
    growth, points = grown(methods, scenes, extent, progress)
    after = machine_load()
    return Found(
        date=time.strftime("%Y-%m-%d", time.gmtime()),
        quick=extent != FULL,
        load=None if before is None or after is None else max(before, after),
        patience=extent.patience,
        cases=cases,
        costs=costs,
        growth=growth,
        points=points,
        made_with={**made_with, "processor": machine_kind()},
    )


def _on_a_set(
    name: str,
    layouts: Sequence[Layout],
    methods: Mapping[str, Method],
    extent: Extent,
    progress: NamedProgress,
) -> tuple[CaseSet, list[Cost]]:
    """Costs on one set: without a method, and of every method in every way that it can judge."""
    jobs = {("", "loop"): looping(layouts), ("", "empty"): empty_verdicts(layouts)}
    costs: dict[str, dict[str, Any]] = {}
    for spec, method in methods.items():
        progress(f"{name}, {spec}")
        judged, missing = _judged(method, layouts, extent.patience)
        ways = _ways(method, judged) if judged else {}
        jobs |= {(spec, way): job for way, job in ways.items()}
        placements = ways["placement"].count if judged else None
        costs[spec] = {"n": len(judged), "missing": missing, "placements": placements}
        costs[spec] |= step_shares(method, judged)
    measure([*jobs.values()], extent.repeats, partial(progress, name))

    def taken(spec: str) -> dict[str, Any]:
        return {way: job.microseconds for (own, way), job in jobs.items() if own == spec}

    mean_items = sum(map(len, layouts)) / len(layouts)
    return CaseSet(name, len(layouts), mean_items, **taken("")), [
        Cost(name, spec, **found, **taken(spec)) for spec, found in costs.items()
    ]


def _judged(method: Method, layouts: Sequence[Layout], patience: float) -> tuple[list[Layout], int]:
    """The layouts on which a method is measured, and how many more had no verdict in time.

    These are all, or every tenth where judging all takes long.
    """

    def with_verdict(some: Sequence[Layout]) -> list[Layout]:
        return [x for x in some if method.judge(x, timeout=patience).status is Status.DONE]

    few = layouts[::_EVERY]
    start = time.process_time()
    found = with_verdict(few)
    long = _EVERY * (time.process_time() - start) > _LONGEST
    if long or len(few) == len(layouts):
        return found, len(few) - len(found)
    found = with_verdict(layouts)
    return found, len(layouts) - len(found)


def _ways(method: Method, layouts: Sequence[Layout]) -> dict[str, Job]:
    """Work of a method on a set of layouts, by the field of :class:`Cost`."""
    ways = {"judge": judging(method, layouts), "placement": placing(method, layouts)}
    batch = judging_together(method, layouts)
    if batch is not None:
        ways["batch"] = batch
        stable = [x for x in layouts if len(x) > 1 and method.judge(x).stable]
        if stable:
            ways["position"] = judging_positions(method, max(stable, key=len))
    return ways


def step_shares(method: Method, layouts: Sequence[Layout]) -> dict[str, Any]:
    """Steps of some layouts, and shares of them, by the field of :class:`Cost`.

    A method counts its steps if it has ``step_counts``: of a layout, how many steps were judged,
    for how many the forces found before were kept, and for how many the model of motion was asked.
    There are none where it counts none.
    """
    counts = getattr(method, "step_counts", None)
    if counts is None or not layouts or Trait.MOVEMENT not in method.traits:
        return {}
    steps, kept, asked = np.array([counts(layout) for layout in layouts]).T
    return {"steps": int(steps.sum()), "kept": ratio(kept, steps), "asked": ratio(asked, steps)}


class _Sized(NamedTuple):
    """Work on the first items of a source."""

    items: int
    source: int
    joined: bool
    in_batch: bool
    job: Job

    @property
    def cost(self) -> float:
        """CPU time of a judgement [us]."""
        return self.job.microseconds.value


def grown(
    methods: Mapping[str, Method],
    scenes: Mapping[str, Callable[[Method], Sequence[Source]]],
    extent: Extent,
    progress: NamedProgress = silent,
) -> tuple[list[Growth], list[GrowthPoint]]:
    """Cost by number of items: exponents a scene and method, and their points.

    A size is measured on the layouts of the scene whose first items the method calls stable, so
    that every item is judged. There is no point where there is none.
    """
    found = {}
    for scene, spec in product(scenes, methods):
        progress(f"{scene}, {spec}")
        found[scene, spec] = list(_sized(methods[spec], scenes[scene](methods[spec]), extent))
    jobs = [one.job for own in found.values() for one in own]
    measure(jobs, extent.repeats, partial(progress, "growth"), enough=_ENOUGH)
    growth, points = [], []
    for (scene, spec), own in found.items():
        alone, batch = ([one for one in own if one.in_batch is there] for there in (False, True))
        for count in sorted({one.items for one in alone}):
            judge, together = (
                median([one.cost for one in of if one.items == count]) for of in (alone, batch)
            )
            beside = sum(one.joined for one in alone if one.items == count)
            points.append(GrowthPoint(scene, spec, count, beside, judge, _known(together)))
        late = [one for one in alone if one.items >= LATE]
        if alone:
            growth.append(Growth(scene, spec, *map(_exponent, (alone, late, batch))))
    return growth, points


def _sized(method: Method, sources: Sequence[Source], extent: Extent) -> Iterator[_Sized]:
    """Work on every size of every source that the method calls stable, alone and in a batch."""
    for count, (place, source) in product(ITEM_COUNTS, enumerate(sources)):
        if count > min(len(source.layout), extent.most_items):
            continue
        part = source.layout.first(count)
        verdict = method.judge(part, timeout=extent.patience)
        if verdict.status is not Status.DONE or not verdict.stable:
            continue
        is_joined = count > source.alone
        yield _Sized(count, place, is_joined, False, judging(method, [part]))
        copies = int(np.clip(_BATCH / max(verdict.cpu.total, 1e-9), *_COPIES))
        together = judging_together(method, [part] * copies)
        if together is not None:
            yield _Sized(count, place, is_joined, True, together)


def _exponent(sized: Sequence[_Sized]) -> Estimate | None:
    items, costs = [one.items for one in sized], [one.cost for one in sized]
    return _known(exponent(items, costs, [one.source for one in sized]))


def _known(estimate: Estimate) -> Estimate | None:
    """An estimate, where it has an interval."""
    return None if math.isnan(estimate.low) else estimate

"""The benchmark: what judgements cost, measured side by side in one process."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numba

from steadyload.layouts.model.layout import Layout
from steadyload.methods.contract.method import Method, Status
from steadyload.methods.registry import make_method
from steadyload.progress import NamedProgress
from steadyload.runs.provenance import machine_kind, provenance, provenance_lines, source_line
from steadyload.runs.timing import machine_load
from steadyload.statistics.metrics import median
from steadyload.studies.speed.growth import ITEM_COUNTS, growth_curves
from steadyload.studies.speed.measuring import (
    POSITIONS,
    Job,
    empty_verdicts,
    judging,
    judging_positions,
    judging_together,
    looping,
    measure,
    placing,
)
from steadyload.studies.speed.records import CaseSet, Cost, Kind, SpeedRun
from steadyload.studies.speed.scenes import Cases, growing, piles
from steadyload.studies.speed.steps import step_shares

_EVERY = 10
_LONGEST = 10.0
"""CPU time of judging a set once above which only every tenth layout is judged [s]."""


@dataclass(frozen=True, slots=True)
class Extent:
    """How much is measured.

    Attributes:
        repeats: of every measurement.
        draws: layouts of a size in the growth.
        most_items: of a layout in the growth.
        patience: seconds after which a judgement is given up.
    """

    repeats: int = 9
    draws: int = 8
    most_items: int = 200
    patience: float = 2.0


FULL = Extent()
QUICK = Extent(repeats=3, draws=2, most_items=50, patience=0.5)


def speed_run(
    specs: Sequence[str], sets: Sequence[Cases], extent: Extent, progress: NamedProgress
) -> SpeedRun:
    """Measure methods on sets of layouts, the first of which is the labelled one.

    Raises:
        SpecError: there is no such method.
    """
    methods = {spec: make_method(spec) for spec in specs}
    largest = max(len(layout) for cases in sets for layout in cases.layouts)
    for spec, method in methods.items():
        progress(f"{spec}: prepared")
        method.prepare(max(largest, extent.most_items))
    before, made = machine_load(), provenance()
    costs, steps = [], []
    for cases in sets:
        judged = {}
        for spec, method in methods.items():
            progress(f"{cases.name}, {spec}")
            judged[spec] = _judged(method, cases.layouts, extent.patience)
            shares = step_shares(cases.name, spec, method, judged[spec][0])
            steps += [shares] if shares else []
        costs += _costs(methods, cases, judged, extent.repeats, progress)
    scenes = [piles(extent.most_items, extent.draws)]
    scenes += [growing(cases, extent.most_items, extent.draws) for cases in sets[1:]]
    curves = growth_curves(
        methods,
        scenes,
        [count for count in ITEM_COUNTS if count <= extent.most_items],
        repeats=extent.repeats,
        patience=extent.patience,
        progress=progress,
    )
    after = machine_load()
    return SpeedRun(
        date=time.strftime("%Y-%m-%d", time.gmtime()),
        source=source_line(made),
        machine=machine_kind(),
        compiled=not numba.config.DISABLE_JIT,
        quick=extent != FULL,
        load=None if before is None or after is None else max(before, after),
        patience=extent.patience,
        cases=tuple(_described(cases) for cases in sets),
        costs=tuple(costs),
        steps=tuple(steps),
        growth=tuple(curves),
        made_with=provenance_lines(made),
    )


def _described(cases: Cases) -> CaseSet:
    counts = [len(layout) for layout in cases.layouts]
    return CaseSet(cases.name, len(counts), sum(counts) / len(counts))


def _costs(
    methods: Mapping[str, Method],
    cases: Cases,
    judged: Mapping[str, tuple[list[Layout], int]],
    repeats: int,
    progress: NamedProgress,
) -> list[Cost]:
    """Costs on one set: without a method, and of every method in every way that it can judge.

    Args:
        methods: by spec.
        cases: the set.
        judged: by spec, the layouts of the set that are judged, and how many had no verdict.
        repeats: of every measurement.
        progress: called with repeats done and repeats in all.
    """
    name, jobs = cases.name, []
    for kind, work in (
        (Kind.LOOP, looping(cases.layouts)),
        (Kind.EMPTY, empty_verdicts(cases.layouts)),
    ):
        jobs.append(Job((kind, ""), len(cases.layouts), work))
    for spec, method in methods.items():
        if judged[spec][0]:
            jobs += _jobs(spec, method, judged[spec][0])
    measure(jobs, repeats, partial(progress, name))
    found = []
    for job in jobs:
        kind, spec = job.key  # type: ignore[misc]
        taken = median([1e6 * seconds for seconds in job.seconds])
        missing = judged[spec][1] if spec else 0
        found.append(Cost(name, kind, spec, job.count, missing, taken))
    return found


def _jobs(spec: str, method: Method, layouts: Sequence[Layout]) -> list[Job]:
    jobs = [Job((Kind.JUDGE, spec), len(layouts), judging(method, layouts))]
    together = judging_together(method, layouts)
    if together is not None:
        jobs.append(Job((Kind.BATCH, spec), len(layouts), together))
        stable = [x for x in layouts if len(x) > 1 and method.judge(x).stable]
        if stable:
            positions = judging_positions(method, max(stable, key=len))
            jobs.append(Job((Kind.FEASIBLE, spec), POSITIONS, positions))
    placements, work = placing(method, layouts)
    jobs.append(Job((Kind.PLACE, spec), placements, work))
    return jobs


def _judged(method: Method, layouts: Sequence[Layout], patience: float) -> tuple[list[Layout], int]:
    """The layouts on which a method is measured, and how many more had no verdict in time.

    These are all, or every tenth where judging all takes long.
    """
    few = layouts[::_EVERY]
    start = time.process_time()
    found = _with_verdict(method, few, patience)
    long = _EVERY * (time.process_time() - start) > _LONGEST
    if long or len(few) == len(layouts):
        return found, len(few) - len(found)
    found = _with_verdict(method, layouts, patience)
    return found, len(layouts) - len(found)


def _with_verdict(method: Method, layouts: Sequence[Layout], patience: float) -> list[Layout]:
    return [x for x in layouts if method.judge(x, timeout=patience).status is Status.DONE]

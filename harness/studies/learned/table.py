"""Learned methods compared with others: accuracy, and cost one layout at a time and in batches."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from steadyload.layouts.benchmark import load_benchmark
from steadyload.layouts.benchmark.dataset import KEYS
from steadyload.layouts.model.layout import Layout
from steadyload.learners.plans.plan import Plan, TablePlan
from steadyload.learners.plans.trainings import Workshop
from steadyload.learners.shipping import method_for
from steadyload.methods.contract.method import Method
from steadyload.methods.naming import MethodKey, method_key
from steadyload.methods.registry import make_method
from steadyload.reports.columns import column, fixed, general, plain_percent, row
from steadyload.runs.asked import Asked, asked, measured
from steadyload.runs.costs import timed_costs
from steadyload.runs.evaluation import ALL, MethodEvaluation, evaluate
from steadyload.runs.labels import Cases
from steadyload.runs.paper import paper
from steadyload.runs.provenance import made_by
from steadyload.runs.store import JSON, Store, locked
from steadyload.runs.timing import taken, timed
from steadyload.studies.kit import Lab

VERSION = 1
"""Version of how times in batches are taken: raised when their meaning changes."""

_BATCH = "batch"
"""The parameter of a method that judges many layouts at once."""

_RULE = "equilibrium:time=0.3"
"""A rule of the quantities that features of support hold, for comparison with what is learnt."""


@row
class Judged:
    """A method on a group of cases."""

    found: MethodEvaluation
    paper: float | None = column("paper %", plain_percent, "accuracy in Table 5 of the paper")


@row
class Timed:
    """Times of a method on all cases that are timed; None where it judges one at a time alone."""

    found: MethodEvaluation
    repeats: int = column()
    paper_wall_ms: float | None = column("paper wall ms", general)
    one_by_one: float = column("layouts/s one by one", fixed, "of wall time")
    best_batch: int | None = column("best batch", about="the fastest by CPU time")
    rate: float | None = column("layouts/s at that", fixed, "of wall time")
    cpu_rate: float | None = column("layouts per CPU s", fixed)
    rates: Mapping[int, float] = column("{}", fixed, "layouts/s of wall time, by batch size")


@row
class Table:
    """Methods, all compared with the method ``held``; ``costs`` explains the source of times."""

    held: MethodKey
    groups: Mapping[str, Sequence[Judged]]
    timed: Sequence[Timed]
    costs: str

    @property
    def own(self) -> Mapping[str, Judged]:
        """The method that all are compared with, by group."""
        return {
            group: next(each for each in rows if each.found.method == self.held)
            for group, rows in self.groups.items()
        }

    @property
    def others(self) -> list[MethodEvaluation]:
        """The other methods, on all cases."""
        return [each.found for each in self.groups[ALL] if each.found.method != self.held]

    @property
    def rule(self) -> MethodEvaluation | None:
        """A rule of the same quantities that nearly is as accurate, or more, without learning."""
        least = self.own[ALL].found.accuracy.low
        able = (each for each in self.others if each.accuracy.value >= least)
        return next((each for each in able if each.method.spec == _RULE), None)


def judge_table(lab: Lab, plan: Plan, workshop: Workshop, limit: int | None) -> Table:
    """Judge the part by all methods of the table, then time them in turns.

    Args:
        lab: where it runs; an interrupted run is resumed.
        plan: with a table.
        workshop: has the trainings.
        limit: largest number of cases a scenario; None for all.

    Raises:
        as :func:`steadyload.runs.runner.run_study` and :func:`steadyload.runs.timing.timed`.
    """
    table, benchmark, folder = plan.table, load_benchmark(), lab.work / "table"
    assert table is not None
    named = (_key(name, table, workshop) for name in (*table.methods, *table.trainings))
    keys = {key.spec: key for key in named}
    held = _key(table.held, table, workshop)
    judged = lab.judge(
        tuple(keys), Cases(benchmark, plan.part, limit=limit), folder="table/verdicts",
        name="learned", shard_size=100,
    ).judged  # fmt: skip
    cases = benchmark.select(plan.part, limit=limit)
    share = max(1, table.timed // cases["scenario"].nunique())
    timed_cases = pd.MultiIndex.from_frame(cases.groupby("scenario", sort=False).head(share)[KEYS])
    layouts = [benchmark.layout(name, scenario) for name, scenario in timed_cases]
    times = timed(
        tuple(keys), layouts, folder / "times",
        repeats=table.repeats, block=len(layouts), workers=lab.workers,
    )  # fmt: skip
    batches = _timed_batches(tuple(keys), layouts, folder, table, lab.workers)
    evaluation = evaluate(judged, costs=timed_costs(times, timed_cases))
    # The paper's PS_opt has other parameters than ours, so that simulations have no column.
    printed = {spec: None if key.engine else paper().row_of(key) for spec, key in keys.items()}
    groups = {
        group: [
            Judged(
                evaluation.row(spec, group, against=held.spec, key=key),
                own.accuracy.get(group) if (own := printed[spec]) else None,
            )
            for spec, key in keys.items()
        ]
        for group in evaluation.rows
    }
    rows = []
    for found in (each.found for each in groups[ALL] if each.found.cpu.n):
        sizes, own = batches.get(found.method.spec, {}), printed[found.method.spec]
        best = min(sizes, key=lambda size: sizes[size][0], default=None)
        cpu, wall = sizes[best] if best else (None, None)
        rows.append(
            Timed(
                found,
                table.repeats,
                own.runtime[ALL] if own else None,
                1e3 / found.wall.value,
                best,
                1e3 / wall if wall else None,
                1e3 / cpu if cpu else None,
                {size: 1e3 / wall for size, (_, wall) in sorted(sizes.items())},
            )
        )
    return Table(held, groups, rows, evaluation.cost_source.explained())


def _key(name: str, table: TablePlan, workshop: Workshop) -> MethodKey:
    """A method of the table, by its spec or the name of a training."""
    if name not in table.trainings:
        return method_key(make_method(name))
    run = workshop.runs(name)[0]
    key = method_key(make_method(f"{method_for(run.training.members)}:weights={run.weights}"))
    # A family of its own, so that figures distinguish trainings.
    return dataclasses.replace(key, title=f"{run.training.title}, seed {run.seed}", family=name)


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


def _timed_batches(
    methods: Sequence[str], layouts: Sequence[Layout], folder: Path, table: TablePlan, workers: int
) -> dict[str, dict[int, tuple[float, float]]]:
    """CPU and wall time a layout [ms] by spec and batch size; kept, and not taken again."""
    made = {spec: make_method(spec) for spec in methods}
    able = {
        spec: made_by(method)
        for spec, method in made.items()
        if _BATCH in {f.name for f in dataclasses.fields(method.parameters)}
    }
    if not (able and table.batches):
        return {}
    unit = BatchUnit(able, tuple(layouts), table.repeats, table.batches)
    with locked(folder):
        store = Store(folder, JSON)
        store.complete([unit], measured, workers=min(workers, 1))
        [times] = store.read(unit.key)
    return {
        spec: {int(size): (cpu, wall) for size, (cpu, wall) in sizes.items()}
        for spec, sizes in times.items()
    }


def _at_once(spec: str, size: int) -> Method:
    """The method with a batch size."""
    plain = str(make_method(spec).spec)
    return make_method(f"{plain}{',' if ':' in plain else ':'}{_BATCH}={size}")

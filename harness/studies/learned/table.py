"""Learners compared with other methods: accuracy and cost of each."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import pandas as pd

from steadyload.layouts.benchmark import load_benchmark
from steadyload.layouts.benchmark.dataset import KEYS
from steadyload.learners.plans.plan import Plan, TablePlan
from steadyload.learners.plans.trainings import Workshop
from steadyload.learners.shipping import method_for
from steadyload.methods.naming import MethodKey, method_key
from steadyload.methods.registry import make_method
from steadyload.progress import Progress, silent
from steadyload.runs.costs import timed_costs
from steadyload.runs.definition import StudyDefinition
from steadyload.runs.evaluation import evaluate
from steadyload.runs.paper import paper
from steadyload.runs.runner import run_study
from steadyload.runs.timing import timed
from steadyload.studies.learned.batches import timed_batches
from steadyload.studies.learned.summary import MethodTable

_SHARD_SIZE = 100


def judge_table(
    plan: Plan,
    workshop: Workshop,
    folder: Path,
    *,
    limit: int | None,
    workers: int,
    progress: Progress = silent,
) -> MethodTable:
    """Judge the part by all methods of the table, then time them in turns.

    Args:
        plan: with a table.
        workshop: has the trainings.
        folder: of the run; an interrupted run is resumed.
        limit: largest number of cases a scenario; None for all.
        workers: processes beside this one.
        progress: called with rows done and rows in all.

    Raises:
        as :func:`steadyload.runs.runner.run_study` and
        :func:`steadyload.studies.learned.batches.timed_batches`.
    """
    table = plan.table
    assert table is not None
    named = (_key(name, table, workshop) for name in (*table.methods, *table.trainings))
    keys = {key.spec: key for key in named}
    study = StudyDefinition(
        name="learned",
        methods=tuple(keys),
        benchmark=plan.part,
        limit=limit,
        shard_size=_SHARD_SIZE,
    )
    run_study(study, folder / "verdicts", workers=workers, progress=progress)
    benchmark = load_benchmark()
    cases = benchmark.select(plan.part, limit=limit)
    few = cases.groupby("scenario", sort=False).head(
        max(1, table.timed // cases["scenario"].nunique())
    )
    timed_cases = pd.MultiIndex.from_frame(few[KEYS])
    layouts = [benchmark.layout(name, scenario) for name, scenario in timed_cases]
    times = timed(
        tuple(keys), layouts, folder / "times",
        repeats=table.repeats, block=len(layouts), workers=workers,
    )  # fmt: skip
    evaluation = evaluate(folder / "verdicts", costs=timed_costs(times, timed_cases))
    held = _key(table.held, table, workshop)
    # The paper's PS_opt has other parameters than ours, so that simulations have no column.
    printed = {spec: paper().row_of(key) for spec, key in keys.items() if key.engine is None}
    return MethodTable(
        held=held,
        rows={
            group: tuple(
                evaluation.row(key.spec, group, against=held.spec, key=key) for key in keys.values()
            )
            for group in evaluation.rows
        },
        paper={spec: column for spec, column in printed.items() if column is not None},
        batched=timed_batches(
            tuple(keys),
            layouts,
            folder,
            repeats=table.repeats,
            batches=table.batches,
            workers=workers,
        ),
        repeats=table.repeats,
        cost_source=evaluation.cost_source,
    )


def _key(name: str, table: TablePlan, workshop: Workshop) -> MethodKey:
    """A method of the table, by its spec or the name of a training."""
    if name not in table.trainings:
        return method_key(make_method(name))
    run = workshop.runs(name)[0]
    judge = method_for(run.training.members)
    key = method_key(make_method(f"{judge}:weights={run.weights}"))
    # A family of its own, so that figures distinguish trainings.
    return dataclasses.replace(key, title=f"{run.training.title}, seed {run.seed}", family=name)

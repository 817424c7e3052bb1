"""Learners compared with other methods: accuracy and cost of each."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from pathlib import Path

import pandas as pd

from steadyload.layouts.benchmark import load_benchmark
from steadyload.layouts.benchmark.dataset import KEYS
from steadyload.methods.naming import MethodKey, method_key
from steadyload.methods.registry import make_method
from steadyload.runs.costs import timed_costs
from steadyload.runs.definition import StudyDefinition
from steadyload.runs.evaluation import evaluate
from steadyload.runs.runner import run_study
from steadyload.studies.learned.plan import Plan, TablePlan
from steadyload.studies.learned.summary import MethodTable
from steadyload.studies.learned.timing import timed
from steadyload.studies.learned.trainings import Workshop
from steadyload.studies.table5.paper import paper

PAPER_COLUMNS: Mapping[str, str] = {
    "fbs": "FBS",
    "pbs:alpha=0.9": "PBS 0.9",
    "pbs:alpha=0.7": "PBS 0.7",
    "pbs:alpha=0.5": "PBS 0.5",
    "sme": "SME",
    "lstm_1": "LSTM_1",
    "lstm_e": "LSTM_e",
}
"""Columns of the paper's Table 5 by spec of the method of that name. The paper's PS_opt has other
parameters than ours and is left out."""

_SHARD_SIZE = 100


def judge_table(
    plan: Plan,
    workshop: Workshop,
    folder: Path,
    *,
    limit: int | None,
    workers: int,
    progress: Callable[[int, int], None] = lambda done, total: None,
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
        :func:`steadyload.studies.learned.timing.timed`.
    """
    table = plan.table
    assert table is not None
    specs = _specs(table, workshop)
    keys = dict(_named(name, spec, workshop) for name, spec in specs.items())
    study = StudyDefinition(
        name="learned",
        methods=tuple(keys),
        benchmark=plan.part,
        limit=limit,
        shard_size=_SHARD_SIZE,
    )
    run_study(study, folder / "verdicts", workers=workers, progress=progress)
    cases = load_benchmark().select(plan.part, limit=limit)
    few = cases.groupby("scenario", sort=False).head(
        max(1, table.timed // cases["scenario"].nunique())
    )
    times = timed(table, tuple(keys), few, folder, workers=workers)
    evaluation = evaluate(
        folder / "verdicts",
        costs=timed_costs(times.single, pd.MultiIndex.from_frame(few[KEYS])),
    )
    held = str(make_method(specs[table.held]).spec)
    printed = {row.title: row for row in paper().rows}
    return MethodTable(
        held=keys[held],
        rows={
            group: tuple(
                evaluation.row(spec, group, against=held, key=key) for spec, key in keys.items()
            )
            for group in evaluation.rows
        },
        paper={spec: printed[PAPER_COLUMNS[spec]] for spec in keys if spec in PAPER_COLUMNS},
        batched=times.batched,
        repeats=table.repeats,
        cost_source=evaluation.cost_source,
    )


def _specs(table: TablePlan, workshop: Workshop) -> dict[str, str]:
    """Specs by their name in the plan."""
    found = {spec: spec for spec in table.methods}
    for name in table.trainings:
        run = workshop.runs(name)[0]
        found[name] = f"{'lstm_1' if run.training.members == 1 else 'lstm_e'}:weights={run.weights}"
    return found


def _named(name: str, spec: str, workshop: Workshop) -> tuple[str, MethodKey]:
    method = make_method(spec)
    key = method_key(method)
    training = workshop.plan.trainings.get(name)
    if training is not None:
        # A family of its own, so that figures distinguish trainings.
        title = f"{training.title}, seed {training.seeds[0]}"
        key = dataclasses.replace(key, title=title, family=name)
    return str(method.spec), key

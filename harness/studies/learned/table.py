"""Learners beside other methods: what each says, and what it costs."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
import pandas as pd

from steadyload.layouts.benchmark import load_benchmark
from steadyload.methods.naming import MethodKey, method_key
from steadyload.methods.registry import make_method
from steadyload.runs.definition import StudyDefinition
from steadyload.runs.evaluation import verdicts_against_labels
from steadyload.runs.labels import load_labels
from steadyload.runs.results import load_results
from steadyload.runs.runner import run_study
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.metrics import mean, outcomes, share
from steadyload.studies.learned.plan import Plan, TablePlan
from steadyload.studies.learned.records import ALL, JudgeRow, JudgeTable, TimeRow
from steadyload.studies.learned.timing import TimingUnit, timed
from steadyload.studies.learned.trainings import Workshop

PAPER: Mapping[str, tuple[tuple[float, float, float, float], float]] = {
    "fbs": ((0.6200, 0.6000, 0.5333, 0.5844), 0.02),
    "pbs:alpha=0.9": ((0.6600, 0.6233, 0.5767, 0.6200), 0.03),
    "pbs:alpha=0.7": ((0.8033, 0.7633, 0.6733, 0.7467), 0.03),
    "pbs:alpha=0.5": ((0.8533, 0.7933, 0.6800, 0.7756), 0.01),
    "sme": ((0.8633, 0.8533, 0.7900, 0.8356), 0.18),
    "lstm_1": ((0.9733, 0.7600, 0.7167, 0.8167), 3.67),
    "lstm_e": ((0.9867, 0.7800, 0.7400, 0.8356), 26.44),
}
"""Table 5 of the paper, on its own test set of 900 cases: accuracy on S1, S2a, S2b and all, and ms
a layout. Its PS_opt is another one than ours, and stands for none of these methods."""

_SCENARIOS = ("S1", "S2a", "S2b", ALL)
_SHARD_SIZE = 100


def judge_table(
    plan: Plan,
    workshop: Workshop,
    folder: Path,
    *,
    limit: int | None,
    workers: int,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> JudgeTable:
    """Judge the part by all methods of the table, then time them in turns.

    Args:
        plan: with a table.
        workshop: has the trainings.
        folder: of what is judged; an interrupted run goes on.
        limit: only so many cases a scenario.
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
    results = load_results(folder / "verdicts")
    said = outcomes(results)
    labels = load_labels(folder / "verdicts").loc[said.index]
    held = str(make_method(specs[table.held]).spec)
    benchmark = load_benchmark()
    cases = benchmark.select(plan.part, limit=limit)
    few = cases.groupby("scenario", sort=False).head(
        max(1, table.timed // cases["scenario"].nunique())
    )
    layouts = tuple(
        benchmark.layout(name, scenario)
        for name, scenario in zip(few["layout"], few["scenario"], strict=True)
    )
    unit = TimingUnit(tuple(keys), layouts, table.repeats, table.batches)
    times = timed(unit, folder, workers=workers)
    compared = {spec: verdicts_against_labels(said[spec], labels) for spec in keys}
    statuses = results.groupby("method")["status"].value_counts()
    return JudgeTable(
        held=keys[held].title,
        rows=tuple(
            _row(key, compared[spec], None if spec == held else compared[held], labels, statuses)
            for spec, key in keys.items()
        ),
        times=tuple(
            TimeRow(
                key,
                len(layouts),
                table.repeats,
                times["methods"][spec]["cpu"],
                times["methods"][spec]["wall"],
                {
                    int(size): (cpu, wall)
                    for size, (cpu, wall) in times["methods"][spec]["batched"].items()
                },
            )
            for spec, key in keys.items()
        ),
        load=times["load"],
    )


def _specs(table: TablePlan, workshop: Workshop) -> dict[str, str]:
    """Specs by the name that the plan has for them."""
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
        # A family of its own, so that figures tell trainings apart.
        title = f"{training.title}, seed {training.seeds[0]}"
        key = dataclasses.replace(key, title=title, family=name)
    return str(method.spec), key


def _row(
    key: MethodKey,
    mine: pd.DataFrame,
    held: pd.DataFrame | None,
    labels: pd.DataFrame,
    statuses: pd.Series,
) -> JudgeRow:
    instances = labels["instance"].to_numpy()
    scenarios = labels.index.get_level_values("scenario").to_numpy()
    parts = {ALL: np.ones(len(labels), dtype=bool)} | {
        str(s): scenarios == s for s in sorted(set(scenarios))
    }

    def shares(column: str) -> dict[str, Estimate]:
        hits = mine[column].to_numpy(bool)
        return {name: share(hits[which], instances[which]) for name, which in parts.items()}

    right = mine["right"].to_numpy(float)
    ahead = None if held is None else held["right"].to_numpy(float) - right
    accuracy, wall = PAPER.get(key.spec, ((), None))
    return JudgeRow(
        method=key,
        accuracy=shares("right"),
        over=shares("over"),
        under=shares("under"),
        difference=None
        if ahead is None
        else {name: mean(ahead[which], instances[which]) for name, which in parts.items()},
        paper=dict(zip(_SCENARIOS, accuracy, strict=False)),
        paper_wall=wall,
        without_verdict={
            str(status): int(count)
            for (spec, status), count in statuses.items()
            if spec == key.spec and status != "done"
        },
    )

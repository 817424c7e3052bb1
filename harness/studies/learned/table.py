"""Learned methods compared with others: accuracy, and cost one layout at a time and in batches."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence

import pandas as pd

from steadyload.layouts.benchmark import load_benchmark
from steadyload.layouts.benchmark.dataset import KEYS
from steadyload.layouts.benchmark.parts import set_named
from steadyload.layouts.model.scenarios import Scenario
from steadyload.learners.plans.plan import Plan, TablePlan
from steadyload.learners.plans.trainings import Workshop
from steadyload.learners.shipping import method_for
from steadyload.methods.naming import MethodKey, method_key
from steadyload.methods.registry import make_method
from steadyload.reports.columns import column, fixed, general, plain_percent, row
from steadyload.runs.costs import timed_costs
from steadyload.runs.evaluation import ALL, MethodEvaluation, evaluate
from steadyload.runs.labels import Cases
from steadyload.runs.paper import paper
from steadyload.runs.timing import timed, timed_batches
from steadyload.studies.kit import Lab

_RULE = "equilibrium:time=0.3"
"""A rule of the quantities that features of support hold, for comparison with what is learnt."""


@row
class Judged:
    """A method on a group of cases; times are shown on all of them alone."""

    found: MethodEvaluation
    paper: float | None = column("paper %", plain_percent, "accuracy in Table 5 of the paper")
    repeats: int = column()
    paper_wall_ms: float | None = column("paper wall ms", general)
    one_by_one: float | None = column("layouts/s one by one", fixed, "of wall time")
    best_batch: int | None = column("best batch", about="the fastest by CPU time; None without any")
    rate: float | None = column("layouts/s at that", fixed, "of wall time")
    cpu_rate: float | None = column("layouts per CPU s", fixed)
    rates: Mapping[int, float] = column("{}", fixed, "layouts/s of wall time, by batch size")


@row
class Table:
    """Methods by group; all are compared with ``held``. ``costs`` explains the source of times.

    ``labelled_set``: its word or folder, None for the large set of the package. ``part``, ``cases``
    and ``item_lists``: of it, that all judge.
    """

    labelled_set: str | None
    part: str
    cases: int
    item_lists: int
    held: MethodKey
    own: Mapping[str, Judged]
    groups: Mapping[str, Sequence[Judged]]
    costs: str

    @property
    def timed(self) -> list[Judged]:
        """The methods that were timed, on all cases."""
        return [each for each in self.groups[ALL] if each.found.cpu.n]

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
    """Judge cases by all methods of the table, at most so many a scenario; then time them."""
    table, folder = plan.table, lab.work / "table"
    assert table is not None
    benchmark = load_benchmark(set_named(plan.directory))
    limit = min((most for most in (table.limit, limit) if most is not None), default=None)
    named = (_key(name, table, workshop) for name in (*table.methods, *table.trainings))
    keys = {key.spec: key for key in named}
    held = _key(table.held, table, workshop)
    judged = lab.judge(
        tuple(keys), Cases(benchmark, plan.part, limit=limit), folder="table/verdicts",
        name="learned", shard_size=100,
    ).judged  # fmt: skip
    few = max(1, table.timed // len(Scenario))
    timed_cases = pd.MultiIndex.from_frame(
        benchmark.select(plan.part, limit=min(few, limit or few))[KEYS]
    )
    layouts = [benchmark.layout(name, scenario) for name, scenario in timed_cases]
    times = timed(
        tuple(keys), layouts, folder / "times",
        repeats=table.repeats, block=len(layouts), workers=lab.workers,
    )  # fmt: skip
    batches = timed_batches(
        tuple(keys), layouts, folder,
        repeats=table.repeats, batches=table.batches, workers=lab.workers,
    )  # fmt: skip
    evaluation = evaluate(judged, costs=timed_costs(times, timed_cases))

    def row_of(key: MethodKey, group: str) -> Judged:
        found = evaluation.row(key.spec, group, against=held.spec, key=key)
        # The paper's PS_opt has other parameters than ours, so that simulations have no column.
        printed = None if key.engine else paper().row_of(key)
        sizes = sorted(batches.get(key.spec, {}).items())
        cpu_rates = {size: 1e3 / cpu for size, (cpu, _) in sizes}
        rates = {size: 1e3 / wall for size, (_, wall) in sizes}
        best = max(cpu_rates, key=lambda size: cpu_rates[size], default=0)
        return Judged(
            found,
            printed.accuracy.get(group) if printed else None,
            table.repeats,
            printed.runtime[ALL] if printed else None,
            1e3 / found.wall.value if found.wall.n else None,
            best or None,
            rates.get(best),
            cpu_rates.get(best),
            rates,
        )

    own = {group: row_of(held, group) for group in evaluation.rows}
    groups = {group: [row_of(key, group) for key in keys.values()] for group in evaluation.rows}
    return Table(
        plan.directory, str(plan.part), len(judged.said), judged.clusters.nunique(), held, own,
        groups, evaluation.cost_source.explained(),
    )  # fmt: skip


def _key(name: str, table: TablePlan, workshop: Workshop) -> MethodKey:
    """A method of the table, by its spec or the name of a training."""
    if name not in table.trainings:
        return method_key(make_method(name))
    run = workshop.runs(name)[0]
    key = method_key(make_method(f"{method_for(run.training.members)}:weights={run.weights}"))
    # A family of its own, so that figures distinguish trainings.
    return dataclasses.replace(key, title=run.title, family=name)

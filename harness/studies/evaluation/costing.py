"""CPU time of judging with a time limit, and how it grows with the number of boxes."""

from __future__ import annotations

import numpy as np
import pandas as pd

from steadyload.layouts.benchmark.dataset import KEYS
from steadyload.reports.columns import column, decimal, milliseconds, percent, row, significant
from steadyload.runs.costs import CPU, judging_costs
from steadyload.runs.evaluation import ALL, Evaluation, in_group
from steadyload.runs.judged import JudgedCases
from steadyload.statistics.clusters import Labels
from steadyload.statistics.estimate import NOTHING, Estimate
from steadyload.statistics.growth import exponent
from steadyload.statistics.metrics import mean, share

BRIEF, LONG = 300.0, 1000.0
"""CPU times within which tables say how many cases are judged [ms]."""


@row
class Cost:
    """CPU time of a judgement [ms] with a time limit.

    ``brief``, ``long``: shares of all cases that are judged within :data:`BRIEF`, :data:`LONG`; one
    that is refused is not.
    """

    mean: Estimate = column("mean ms", milliseconds)
    median: float = column("median ms", significant)
    ninety: float = column("90 % ms", significant)
    brief: Estimate = column("judged in 0.3 s %", percent)
    long: Estimate = column("judged in 1 s %", percent)
    worst: float = column("worst ms", significant)


@row
class Growth:
    """Exponent of the number of boxes in the CPU time of a method.

    Over the cases that it calls stable, so that all boxes were judged: of those of the set, and of
    these with small ones.
    """

    own: Estimate = column("exponent, the set", decimal)
    everything: Estimate = column("exponent, all", decimal)


def growth_of(spec: str, own: JudgedCases, small: JudgedCases | None) -> Growth:
    """Growth of a method's cost, on labelled cases."""
    of_own = _stable_costs(own, spec)
    everything = of_own if small is None else pd.concat([_stable_costs(small, spec), of_own])
    return Growth(*(exponent(d["boxes"], d["cost"], d["list"]) if len(d) else NOTHING
                    for d in (of_own, everything)))  # fmt: skip


def _stable_costs(judged: JudgedCases, spec: str) -> pd.DataFrame:
    """Boxes, cost and item list of the cases that a method calls stable."""
    assert judged.labels is not None, "the runs are on labelled sets"
    boxes = judged.labels["item_count"].astype(int)
    stable = (judged.said[spec] == boxes).fillna(False).to_numpy(bool)
    taken = judging_costs(judged.results).milliseconds[spec][CPU].loc[judged.said.index]
    found = pd.DataFrame({"boxes": boxes, "cost": taken, "list": judged.clusters})[stable]
    return found[found["cost"] > 0.0]


def cost_of(taken: pd.Series, lists: Labels) -> Cost | None:
    """The cost of a method; None without a time.

    Args:
        taken: CPU time by case [ms], missing where there is none.
        lists: the item list of each case.
    """
    known = taken.notna().to_numpy()
    times, labels = taken[known].to_numpy(float), pd.Series(lists).to_numpy()
    if not len(times):
        return None
    median, ninety = np.quantile(times, (0.5, 0.9))
    brief, long = (share((taken <= limit).to_numpy(), labels) for limit in (BRIEF, LONG))
    found = mean(times, labels[known])
    return Cost(found, float(median), float(ninety), brief, long, float(times.max()))


def cost_in(evaluation: Evaluation, spec: str, group: str = ALL) -> Cost | None:
    """The cost of a method in an evaluation, on a group of its cases; None where it has none."""
    judged = evaluation.judged
    here = in_group(judged.said.index, group)
    taken = evaluation.costs.of(spec, None if group == ALL else group)
    if taken is None:
        return None
    return cost_of(taken[CPU].reindex(judged.said.index[here]), judged.clusters[here])


def body_substeps_of(judged: JudgedCases, spec: str) -> Estimate | None:
    """Engine steps times the boxes that take part, mean over all cases; None of a method without
    steps.
    """
    rows = judged.results[judged.results["method"] == spec]
    taken = rows[rows["repetition"] == 0].set_index(KEYS)["body_substeps"].loc[judged.said.index]
    return mean(taken.to_numpy(float), judged.clusters) if taken.any() else None

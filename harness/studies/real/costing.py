"""CPU time of judging by method, and how it grows with the number of boxes."""

from __future__ import annotations

import numpy as np
import pandas as pd

from steadyload.methods.contract.method import Status
from steadyload.reports.columns import column, decimal, row, significant
from steadyload.runs.costs import CPU, CostKind, CostSource, judging_costs
from steadyload.runs.judged import JudgedCases
from steadyload.statistics.estimate import NOTHING, Estimate
from steadyload.statistics.growth import exponent

SOURCE = CostSource(CostKind.JUDGING)

_WITHOUT_COST = (Status.REFUSED, Status.CRASHED, Status.ERROR)


@row
class JudgingCost:
    """CPU time of a judgement over cases [ms]: mean, median, 90th percentile, largest."""

    n: int
    mean: float = column("mean ms", significant)
    median: float = column("median ms", significant)
    ninety: float = column("90 % ms", significant)
    worst: float = column("worst ms", significant)


@row
class Growth:
    """Exponent of the number of boxes in the CPU time of a method.

    Over the cases that it calls stable, so that all boxes were judged: of those of real size, and
    of these with small ones.
    """

    real: Estimate = column("exponent, real size", decimal)
    everything: Estimate = column("exponent, all", decimal)


def statuses(judged: JudgedCases, spec: str) -> pd.Series:
    """The status of a method's verdicts, in the order of the cases."""
    own = judged.results[judged.results["method"] == spec]
    first = own[own["repetition"] == 0].set_index(["layout", "scenario"])
    return first["status"].loc[judged.said.index]


def judging_times(judged: JudgedCases, spec: str, timeout: float) -> pd.Series:
    """CPU time of judging by case [ms]; of a judgement that was given up, at least the time limit.

    Cases that were refused, or that ended the process, are missing.
    """
    status, cost = statuses(judged, spec), _costs(judged, spec)
    given_up = status == str(Status.TIMEOUT)
    cost = cost.where(~given_up, cost.clip(lower=1e3 * timeout))
    return cost[~status.isin([str(s) for s in _WITHOUT_COST])]


def _costs(judged: JudgedCases, spec: str) -> pd.Series:
    """CPU time of every case [ms], in the order of the cases."""
    taken = judging_costs(judged.results, SOURCE).of(spec)
    assert taken is not None, "the method has judged"
    return taken[CPU].loc[judged.said.index]


def cost_of(judged: JudgedCases, spec: str, timeout: float) -> JudgingCost | None:
    """Cost of judging, see :func:`judging_times`; None where no case has one."""
    cost = judging_times(judged, spec, timeout)
    if cost.empty:
        return None
    median, ninety = np.quantile(cost, (0.5, 0.9))
    return JudgingCost(
        len(cost), float(cost.mean()), float(median), float(ninety), float(cost.max())
    )


def growth_of(spec: str, real: JudgedCases, small: JudgedCases | None) -> Growth:
    """Growth of a method's cost, on labelled cases."""
    of_real = _stable_costs(real, spec)
    everything = of_real if small is None else pd.concat([_stable_costs(small, spec), of_real])
    return Growth(*(exponent(d["boxes"], d["cost"], d["list"]) if len(d) else NOTHING
                    for d in (of_real, everything)))  # fmt: skip


def _stable_costs(judged: JudgedCases, spec: str) -> pd.DataFrame:
    """Boxes, cost and item list of the cases that a method calls stable."""
    assert judged.labels is not None, "the runs are on labelled sets"
    boxes = judged.labels["item_count"].astype(int)
    stable = (judged.said[spec] == boxes).fillna(False).to_numpy(bool)
    cost = _costs(judged, spec)
    found = pd.DataFrame({"boxes": boxes, "cost": cost, "list": judged.clusters})[stable]
    return found[found["cost"] > 0.0]

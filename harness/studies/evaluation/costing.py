"""CPU time of judging with a time limit, and how it grows with the number of boxes."""

from __future__ import annotations

import numpy as np
import pandas as pd

from steadyload.reports.columns import column, decimal, row
from steadyload.runs.costs import CPU, judging_costs
from steadyload.runs.judged import JudgedCases
from steadyload.statistics.estimate import NOTHING, Estimate
from steadyload.statistics.growth import exponent


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


def summary_of(taken: pd.DataFrame | None) -> tuple[float, float, float, float] | None:
    """Mean, median, 90th percentile and largest CPU time [ms]; None without a case."""
    if taken is None:
        return None
    median, ninety = np.quantile(taken[CPU], (0.5, 0.9))
    return float(taken[CPU].mean()), float(median), float(ninety), float(taken[CPU].max())

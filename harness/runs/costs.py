"""Cost of judging by method and case, and the source of these times."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
import pandas as pd

from steadyload.layouts.benchmark.dataset import KEYS
from steadyload.methods.contract.method import Status
from steadyload.runs.timing import Times

BUSY = 1.5
"""Load above which other processes disturbed the timing; one process is the measured one."""

MARK = "**The machine was busy: compare times with one another alone.**"
"""Words by which a page marks times that were taken above that load."""

CPU, WALL = "cpu_total", "wall_total"
_WITHOUT_COST = [str(s) for s in (Status.REFUSED, Status.CRASHED, Status.ERROR)]
PHASES = ("cpu_build", "cpu_step", "cpu_read")


class CostKind(StrEnum):
    """The way in which times were taken."""

    TIMED = "timed"
    IN_TURNS = "in turns"
    JUDGING = "judging"
    ONE_PROCESS = "one process"


_EXPLAINED: Mapping[CostKind, str] = {
    CostKind.TIMED: "CPU times are those of the timing pass{cases}: one process, one thread, "
    "methods in turns on the same cases.",
    CostKind.IN_TURNS: "CPU times are of judging{cases} in one process and one thread, methods in "
    "turns of many cases.",
    CostKind.JUDGING: "CPU times are of judging{cases}, where several workers may share the "
    "machine: compare ratios, not milliseconds.",
    CostKind.ONE_PROCESS: "CPU times are of one process{cases}, beside whatever other work the "
    "machine has: compare ratios, not milliseconds.",
}


@dataclass(frozen=True, slots=True)
class CostSource:
    """Source of the costs of an evaluation.

    ``cases``: how many were timed, None for all. ``load``: the most processes that wanted to run
    while times were taken, one of them ours; None where it is not known. ``spread``: the mean CPU
    time of a method in its slowest repeat over that in its fastest, the largest of all methods;
    None without repeats.
    """

    kind: CostKind
    cases: int | None = None
    load: float | None = None
    spread: float | None = None

    def explained(self) -> str:
        """The sentences that explain costs on every page."""
        cases = "" if self.cases is None else f", on {self.cases} of the cases"
        told = _EXPLAINED[self.kind].format(cases=cases)
        if self.spread is not None:
            told += (
                " Between its fastest and its slowest repeat the mean of a method differs by a "
                f"factor of up to {self.spread:.2f}."
            )
        return told + load_explained(self.load)


def load_explained(load: float | None) -> str:
    """Sentence on the load of the machine, to end a paragraph; empty where it is not known."""
    if load is None:
        return ""
    told = f" While times were taken, {load:.1f} processes wanted to run, one of them ours."
    return told + (f" {MARK}" if load > BUSY else "")


@dataclass(frozen=True)
class Costs:
    """Times by method and case [ms], the median of the repetitions.

    ``milliseconds``: by spec a row a case, indexed by layout and scenario; at least the columns
    :data:`CPU` and :data:`WALL`. A method that was not timed is missing.
    """

    source: CostSource
    milliseconds: Mapping[str, pd.DataFrame]

    def of(self, spec: str, scenario: str | None = None) -> pd.DataFrame | None:
        """The times of a method, in one scenario or in all; None where it was not timed there."""
        found = self.milliseconds.get(spec)
        if found is not None and scenario is not None:
            found = found[found.index.get_level_values("scenario") == scenario]
        return found if found is not None and len(found) else None


def judging_costs(results: pd.DataFrame, source: CostSource | None = None) -> Costs:
    """The times that the result rows of a run hold.

    Args:
        results: the rows.
        source: of the times; None says no more of them than that they are of judging.
    """
    columns = [CPU, WALL, *(phase for phase in PHASES if phase in results)]
    taken = 1e3 * results.groupby(["method", *KEYS])[columns].median()
    specs = taken.index.unique("method")
    source = source or CostSource(CostKind.JUDGING)
    return Costs(source, {str(spec): taken.loc[spec] for spec in specs})


def limited_costs(results: pd.DataFrame, timeout: float) -> Costs:
    """Times of judging with a time limit [s]; an abandoned judgement costs that much at least.

    Cases that were refused, or that ended the process, are missing.
    """
    costs, found = judging_costs(results), {}
    first = results[results["repetition"] == 0]
    for spec, taken in costs.milliseconds.items():
        status = first[first["method"] == spec].set_index(KEYS)["status"].loc[taken.index]
        late = status == str(Status.TIMEOUT)
        cost = taken.where(~late, taken.clip(lower=1e3 * timeout))
        if len(known := cost[~status.isin(_WITHOUT_COST)]):
            found[spec] = known
    return Costs(costs.source, found)


def timed_costs(times: Times, cases: pd.MultiIndex) -> Costs:
    """The times of the timing pass.

    Args:
        times: of some methods.
        cases: that were timed, in the order of the times.
    """
    return Costs(
        CostSource(CostKind.TIMED, len(cases), times.load, _spread(times)),
        {
            spec: pd.DataFrame(
                {CPU: np.median(cpu, axis=0), WALL: np.median(times.wall[spec], axis=0)},
                index=cases,
            )
            for spec, cpu in times.cpu.items()
        },
    )


def _spread(times: Times) -> float | None:
    """See :attr:`CostSource.spread`."""
    means = [cpu.mean(axis=1) for cpu in times.cpu.values() if cpu.shape[1]]
    ratios = [own.max() / own.min() for own in means if len(own) > 1 and own.min() > 0.0]
    return max(ratios, default=None)

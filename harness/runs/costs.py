"""What judging cost by method and case, and where these times come from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
import pandas as pd

from steadyload.layouts.benchmark.dataset import KEYS
from steadyload.runs.timing import Times

BUSY = 1.5
"""Beyond this load a machine had more to do than to take times: one process is ours."""

CPU, WALL = "cpu_total", "wall_total"
PHASES = ("cpu_build", "cpu_step", "cpu_read")


class CostKind(StrEnum):
    """How times were taken."""

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
    """Where the costs of an evaluation come from.

    ``cases``: how many were timed, None for all. ``load``: the most processes that wanted to run
    while times were taken, one of them ours; None where it is not known.
    """

    kind: CostKind
    cases: int | None = None
    load: float | None = None

    def explained(self) -> str:
        """The sentence that stands beside costs on every page."""
        cases = "" if self.cases is None else f", on {self.cases} of the cases"
        return _EXPLAINED[self.kind].format(cases=cases) + load_explained(self.load)


def load_explained(load: float | None) -> str:
    """How busy the machine was, as the end of a paragraph; empty where it is not known."""
    if load is None:
        return ""
    told = f" While times were taken, {load:.1f} processes wanted to run, one of them ours."
    busy = " **The machine was busy: compare times with one another alone.**"
    return told + (busy if load > BUSY else "")


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


def judging_costs(results: pd.DataFrame, source: CostSource) -> Costs:
    """The times that the result rows of a run hold."""
    columns = [CPU, WALL, *(phase for phase in PHASES if phase in results)]
    taken = 1e3 * results.groupby(["method", *KEYS])[columns].median()
    specs = taken.index.unique("method")
    return Costs(source, {str(spec): taken.loc[spec] for spec in specs})


def timed_costs(times: Times, cases: pd.MultiIndex) -> Costs:
    """The times of the timing pass.

    Args:
        times: of some methods.
        cases: that were timed, in the order of the times.
    """
    return Costs(
        CostSource(CostKind.TIMED, len(cases), times.load),
        {
            spec: pd.DataFrame(
                {CPU: np.median(cpu, axis=0), WALL: np.median(times.wall[spec], axis=0)},
                index=cases,
            )
            for spec, cpu in times.cpu.items()
        },
    )

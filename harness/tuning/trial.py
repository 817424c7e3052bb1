"""Trials of genotypes: in rounds of more and more cases, given up once they cannot win the race."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from steadyload.methods.contract.method import Status, judge
from steadyload.methods.contract.spec import SpecError
from steadyload.methods.registry import make_method
from steadyload.runs.pool import PartLimit, SinglePart
from steadyload.runs.units import hard_seconds
from steadyload.tuning.cases import CaseSource, load_cases
from steadyload.tuning.cost import CostModel

BoolArray = NDArray[np.bool_]
FloatArray = NDArray[np.float64]

VERSION = 1
"""Of what a search gives up, and what it holds a genotype to be worth: raised when that changes."""

ACCURACY_WEIGHT, SPEED_WEIGHT = 0.85, 0.15
"""Section 5.2 of the paper."""

ROUNDS = (30, 60, 120, 300)
"""Cases after which a genotype may be given up; all cases are the last round."""

GROWTH = dict(zip(ROUNDS, (5.0, 2.5, 1.5, 1.3), strict=True))
"""Factor by which the gap of a genotype that is given up after a round grows until all cases: about
the median of 96 such genotypes on MuJoCo and Bullet, judged on all 900 cases of validation."""

WORST_COST = 1e4
"""ms; of what cannot be judged, and of a case of a trial at most on average: a hard limit."""

_SURE = 2.0
"""Standard errors."""


@dataclass(frozen=True)
class TrialResult:
    """Result of a trial: of one genotype, on the first cases.

    Attributes:
        right: whether it named the label's failing step, shape (n,).
        cost: modelled CPU time [ms], shape (n,).
        cpu: seconds spent on judging.
        reason: why there is nothing, where a genotype cannot be judged; then n is 0.
    """

    right: BoolArray
    cost: FloatArray
    cpu: float = 0.0
    reason: str = ""

    def __len__(self) -> int:
        return len(self.right)

    @property
    def accuracy(self) -> float:
        """Share of cases that are right; 0 without any."""
        return float(self.right.mean()) if len(self) else 0.0

    @property
    def mean_cost(self) -> float:
        """ms a layout; infinite without any."""
        return float(self.cost.mean()) if len(self) else math.inf

    def first(self, count: int) -> TrialResult:
        """The result after the first cases."""
        return TrialResult(self.right[:count], self.cost[:count], self.cpu, self.reason)


def without_result(reason: str) -> TrialResult:
    """The result where a genotype cannot be judged, for that reason."""
    return TrialResult(np.zeros(0, dtype=bool), np.zeros(0), reason=reason)


def speed(cost: float, goal: float) -> float:
    """1 up to the goal, and going down with the cost beyond it: goal / cost.

    The paper does not say what its own is.

    Args:
        cost: ms a layout.
        goal: the cost [ms a layout] that counts as fast.
    """
    return min(1.0, goal / max(cost, 1e-9))


def fitness(trial: TrialResult, goal: float) -> float:
    """0.85 accuracy + 0.15 speed, of a genotype that was judged on all cases."""
    return ACCURACY_WEIGHT * trial.accuracy + SPEED_WEIGHT * speed(trial.mean_cost, goal)


def worth(trial: TrialResult, goal: float) -> tuple[float, float, float]:
    """Fitness, accuracy (0 to 1) and mean cost [ms] of a genotype judged on all cases."""
    return fitness(trial, goal), trial.accuracy, trial.mean_cost


def behind(trial: TrialResult, rival: TrialResult) -> tuple[float, float]:
    """Gap in accuracy of a genotype to a rival on all cases, and the allowance for its error.

    The cases that are left are taken to come out alike: the first ones are those on which parameter
    sets differ.

    Args:
        trial: of a genotype, on the first cases.
        rival: on all cases.

    Returns:
        The difference, and what it may be off by: two standard errors of a paired difference, or
        what the rival has wrong among the cases that are left, whichever is less. One more
        disagreement is counted than was seen.
    """
    whole, count = len(rival), len(trial)
    ours, theirs = trial.right, rival.right[:count]
    disagreements = int((ours != theirs).sum())
    left = int((~rival.right[count:]).sum())
    allowance = min(_SURE * math.sqrt(disagreements + 1.0), left)
    return (int(theirs.sum()) - int(ours.sum())) / whole, allowance / whole


def estimated(
    trial: TrialResult, rival: TrialResult, goal: float, growth: float = 1.0
) -> tuple[float, float, float]:
    """Fitness, accuracy and cost [ms] that a genotype will have on all cases.

    Args:
        trial: of the genotype, on the first cases.
        rival: on all cases.
        goal: the cost [ms a layout] that counts as fast.
        growth: of what it is behind by now; at most as much as if the cases that are left were like
            the first.
    """
    same = rival.first(len(trial))
    growth = min(growth, len(rival) / len(trial))
    accuracy = rival.accuracy - growth * behind(trial, rival)[0]
    cost = rival.mean_cost * trial.mean_cost / same.mean_cost
    return ACCURACY_WEIGHT * accuracy + SPEED_WEIGHT * speed(cost, goal), accuracy, cost


class Race(Protocol):
    """Rule that decides, from its first cases, when a genotype can no longer win."""

    def lost(self, trial: TrialResult) -> bool:
        """True if the genotype can be given up."""
        ...

    def ahead(self, trial: TrialResult) -> TrialResult | None:
        """The rival that is furthest ahead of it; None without one."""
        ...


@dataclass(frozen=True)
class FitnessRace:
    """Against the fittest genotype so far."""

    goal: float
    rival: TrialResult

    def lost(self, trial: TrialResult) -> bool:
        """See :meth:`Race.lost`."""
        gap = fitness(self.rival, self.goal) - estimated(trial, self.rival, self.goal)[0]
        return gap > ACCURACY_WEIGHT * behind(trial, self.rival)[1]

    def ahead(self, trial: TrialResult) -> TrialResult:
        """See :meth:`Race.ahead`."""
        return self.rival


@dataclass(frozen=True)
class FrontRace:
    """Against all genotypes that no other one beats in both accuracy and cost."""

    rivals: Sequence[TrialResult] = ()

    def lost(self, trial: TrialResult) -> bool:
        """See :meth:`Race.lost`: one that costs no more is clearly more accurate."""
        found = (behind(trial, rival) for rival in self._no_dearer(trial))
        return any(gap > allowance for gap, allowance in found)

    def ahead(self, trial: TrialResult) -> TrialResult | None:
        """See :meth:`Race.ahead`: of those that cost no more the one ahead in accuracy.

        Held against it, what has lost is told to be beaten in both. Held against one that is
        dearer, it would seem to be nearly as accurate at a lower cost, whatever it is.
        """
        rivals = self._no_dearer(trial)
        return max(rivals, key=lambda rival: behind(trial, rival)[0], default=None)

    def _no_dearer(self, trial: TrialResult) -> list[TrialResult]:
        return [r for r in self.rivals if r.first(len(trial)).mean_cost <= trial.mean_cost]


@dataclass(frozen=True)
class TrialUnit(SinglePart):
    """A unit of work: one genotype, by its spec, until it is through or given up."""

    spec: str
    source: CaseSource
    model: CostModel
    race: Race

    def describe(self, part: int) -> str:
        """For people."""
        return self.spec


def run_trial(unit: TrialUnit) -> Iterator[TrialResult]:
    """Judge a genotype; one trial."""
    try:
        method = make_method(unit.spec)
    except SpecError as error:
        yield without_result(str(error))
        return
    cases = load_cases(unit.source)
    method.prepare(max(len(case.layout) for case in cases))
    right: list[bool] = []
    cost: list[float] = []
    cpu = 0.0
    for end in sorted({min(count, len(cases)) for count in (*ROUNDS, len(cases))}):
        for case in cases[len(right) : end]:
            verdict = judge(method, case.layout)
            right.append(verdict.items_placed == case.safe)
            # What ends in an error has done little, and must not look cheap for it.
            failed = verdict.status is Status.ERROR
            spent = unit.model.milliseconds(verdict.effort, method.parameters)
            cost.append(max(spent, WORST_COST) if failed else spent)
            cpu += verdict.cpu.total
        trial = TrialResult(np.array(right, dtype=bool), np.round(cost, 4), cpu)
        if end < len(cases) and unit.race.lost(trial):
            break
    yield trial


def trial_limit(case_count: int) -> PartLimit[TrialUnit, TrialResult]:
    """Hard limit of a trial on that many cases, such as one in a call of an engine that hangs."""
    return PartLimit(hard_seconds(1e-3 * WORST_COST * case_count), trial_without_result)


def trial_without_result(unit: TrialUnit, part: int, reason: str) -> TrialResult:
    """Of a genotype that ends the process it is judged in, or exceeds its hard limit."""
    return without_result(f"{unit.describe(part)}: {reason}")

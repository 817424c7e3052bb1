"""What the page of uncertain verdicts shows, as small typed records. Shares are 0 to 1."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from steadyload.methods.naming import MethodKey
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.reliability import Abstention, Reliability


@dataclass(frozen=True, slots=True)
class UncertainRow:
    """One method, asked what becomes of labelled cases that deviate from their plans.

    Attributes:
        method: the method.
        plan: accuracy of its verdict on the plan.
        likeliest: accuracy of the failing step that most samples have.
        ahead: the latter minus the former, case by case.
        unsure: share of cases whose probability of standing is from 5 to 95 %.
        changed: mean share of samples with another failing step than the plan; ``changed_robust``
            and ``changed_fragile`` of cases whose label is so.
        samples: mean number a case; ``endings``: cases by why there were not more.
        lost: samples without a verdict. ``unjudged``: cases of which none has one.
        cpu, plan_cpu: of a case with all its samples, and of the plan alone [ms].
        stands: what the probability that the whole load stands keeps, against the label.
        right: likewise the share of the likeliest failing step, against whether it is the label's.
        plan_brier: mean square of the plan's stable or not, 1 or 0, minus the label's.
        abstention: accuracy without the cases whose likeliest step is least sure.
    """

    method: MethodKey
    plan: Estimate
    likeliest: Estimate
    ahead: Estimate
    unsure: Estimate
    changed: Estimate
    changed_robust: Estimate
    changed_fragile: Estimate
    samples: Estimate
    endings: Mapping[str, int]
    lost: int
    unjudged: int
    cpu: Estimate
    plan_cpu: Estimate
    stands: Reliability
    right: Reliability
    plan_brier: Estimate
    abstention: Abstention


@dataclass(frozen=True, slots=True)
class Alone:
    """What changes where one thing alone deviates: shares as in :class:`UncertainRow`."""

    what: str
    changed: Estimate
    unsure: Estimate


@dataclass(frozen=True, slots=True)
class Checked:
    """A layout's probability of standing, by quasi-random and by many random samples."""

    layout: str
    scenario: str
    stands: float
    low: float
    high: float
    samples: int
    random: float

    @property
    def inside(self) -> bool:
        """The random samples' share lies in the interval."""
        return self.low <= self.random <= self.high


@dataclass(frozen=True, slots=True)
class Check:
    """Probabilities against those of ``random`` random samples a layout.

    ``gain``: how many random samples one sample is worth, by how far the scramblings' answers lie
    apart.
    """

    method: MethodKey
    random: int
    inside: Estimate
    gain: Estimate
    rows: tuple[Checked, ...]


@dataclass(frozen=True, slots=True)
class Uncertain:
    """All that the page shows.

    ``item_lists``: what intervals stand on. ``silent``: titles of methods that had no verdict on
    any sample.
    """

    part: str
    uncertainty: str
    half_width: float
    most: int
    item_lists: int
    rows: tuple[UncertainRow, ...]
    silent: tuple[str, ...]
    alone_method: MethodKey
    alone: tuple[Alone, ...]
    check: Check | None

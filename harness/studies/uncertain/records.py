"""Typed records for the page of uncertain verdicts. Shares are 0 to 1."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from steadyload.methods.naming import MethodKey
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.reliability import Abstention, Reliability


@dataclass(frozen=True, slots=True)
class UncertainRow:
    """Reliability of one method's verdicts on labelled cases that deviate from their plans.

    Attributes:
        method: the method.
        plan: accuracy of its verdict on the plan.
        likeliest: accuracy of the failing step that most samples have.
        ahead: the latter minus the former, case by case.
        unsure: share of cases whose probability of standing is from 5 to 95 %.
        changed: mean share of samples with another failing step than the plan; ``changed_robust``
            and ``changed_fragile`` of cases whose label is so.
        samples: mean number a case; ``endings``: cases by the reason for which sampling ended.
        lost: samples without a verdict. ``unjudged``: cases without any sample with a verdict.
        cpu, plan_cpu: of a case with all its samples, and of the plan alone [ms].
        stands: calibration of the probability that the whole load stands, against the label.
        right: calibration of the share of the likeliest failing step, against its being the
            label's.
        plan_brier: mean squared difference of stable (1 or 0) by the plan and by the label.
        abstention: accuracy without the cases whose likeliest step has the smallest share.
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
    """Effect of the deviation of one quantity alone: shares as in :class:`UncertainRow`."""

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
        """True if the random samples' share lies in the interval."""
        return self.low <= self.random <= self.high


@dataclass(frozen=True, slots=True)
class Check:
    """Comparison of probabilities with those of ``random`` random samples a layout.

    ``gain``: number of random samples that one sample is worth, by the variance between the
    scramblings.
    """

    method: MethodKey
    random: int
    inside: Estimate
    gain: Estimate
    rows: tuple[Checked, ...]


@dataclass(frozen=True, slots=True)
class Uncertain:
    """All records for the page.

    ``item_lists``: number of clusters of the intervals. ``silent``: titles of methods without a
    verdict on any sample.
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

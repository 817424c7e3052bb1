"""Typed results on uncertain verdicts, from the samples of labelled cases. Shares are 0 to 1."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike, NDArray

from steadyload.layouts.benchmark import load_benchmark
from steadyload.layouts.benchmark.dataset import KEYS
from steadyload.methods.naming import MethodKey, method_key
from steadyload.methods.registry import make_method
from steadyload.methods.uncertainty import parse_uncertainty
from steadyload.runs.accuracy import verdicts_against_labels
from steadyload.runs.comparison import difference
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.metrics import mean, ratio, share
from steadyload.statistics.reliability import Abstention, Reliability, abstention, reliability
from steadyload.studies.uncertain.sampling import CHECK, Sampled, UncertainOptions

UNSURE = (0.05, 0.95)
"""Range of probabilities of standing in which a case counts as unsure."""

_BINS = (0.0, UNSURE[0], 0.35, 0.65, UNSURE[1], 1.0)
"""Edges of bins; few cases are unsure, so that bins of equal width would be nearly empty."""


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


def summarise(asked: UncertainOptions, sampled: Sampled) -> Uncertain:
    """The records of a run, compared with the labels of the set that comes with the package."""
    benchmark = load_benchmark()
    labels = benchmark.cases.set_index(KEYS)[["instance", "failing_step", "item_count"]]
    labels = labels.join(benchmark.confidence["robust"])
    every = {spec: _Cases(table, labels) for spec, table in sampled.methods.items()}
    heard = {spec: cases for spec, cases in every.items() if cases.judged.any()}
    check = None
    if len(sampled.check):
        check = _check(asked, _Cases(sampled.check, labels))
    return Uncertain(
        part=str(asked.part),
        uncertainty=str(parse_uncertainty(asked.uncertainty)),
        half_width=asked.sampling.half_width,
        most=asked.sampling.looks[-1],
        item_lists=len({name for cases in every.values() for name in cases.instances}),
        rows=tuple(_row(spec, cases) for spec, cases in heard.items()),
        silent=tuple(method_key(make_method(spec)).title for spec in every if spec not in heard),
        alone_method=method_key(make_method(asked.alone_method)),
        alone=tuple(_alone(what, _Cases(table, labels)) for what, table in sampled.alone.items()),
        check=check,
    )


@dataclass(frozen=True, slots=True)
class _Answer:
    """Result of the samples of one case: shares of those with a verdict; empty without any."""

    stands: float
    likeliest: float
    sure: float
    changed: float


class _Cases:
    """A table of :class:`Sampled` with the labels of its cases."""

    def __init__(self, table: pd.DataFrame, labels: pd.DataFrame) -> None:
        self.table = table
        self.labels = labels.loc[pd.MultiIndex.from_frame(table[KEYS])]
        self.instances: NDArray[Any] = self.labels["instance"].to_numpy()
        self.stable: NDArray[np.bool_] = self.labels["failing_step"].isna().to_numpy()
        self.robust: NDArray[np.bool_] = self.labels["robust"].fillna(False).to_numpy(bool)
        self.fragile: NDArray[np.bool_] = ~self.labels["robust"].fillna(True).to_numpy(bool)
        self.plan: NDArray[np.int64] = table["nominal"].fillna(-1).astype(int).to_numpy()
        self.items: NDArray[np.int64] = table["item_count"].to_numpy()
        answers = [
            _answer(dict(safe), plan, count)
            for safe, plan, count in zip(table["safe"], self.plan, self.items, strict=True)
        ]
        self.judged = np.array([answer is not None for answer in answers])
        given = [answer or _Answer(np.nan, np.nan, np.nan, np.nan) for answer in answers]
        self.stands = np.array([answer.stands for answer in given])
        self.likeliest = np.array([answer.likeliest for answer in given])
        self.sure = np.array([answer.sure for answer in given])
        self.changed = np.array([answer.changed for answer in given])

    def right(self, safe: ArrayLike) -> NDArray[np.bool_]:
        """Mask of the cases on which a number of items placed safely, if any, is the label's."""
        compared = verdicts_against_labels(pd.Series(safe), self.labels)
        return compared["right"].to_numpy(bool)

    def unsure(self) -> NDArray[np.bool_]:
        """Mask of the unsure cases, of those with a result."""
        return (self.stands >= UNSURE[0]) & (self.stands <= UNSURE[1])


def _answer(safe: dict[int, int], plan: int, count: int) -> _Answer | None:
    total = sum(safe.values())
    if not total:
        return None
    likeliest = max(sorted(safe), key=lambda step: safe[step])
    return _Answer(
        stands=safe.get(count, 0) / total,
        likeliest=likeliest,
        sure=safe[likeliest] / total,
        changed=1.0 - safe.get(plan, 0) / total,
    )


def _row(spec: str, cases: _Cases) -> UncertainRow:
    lists, table = cases.instances, cases.table
    judged = cases.judged
    plan_right, right = cases.right(table["nominal"]), cases.right(cases.likeliest)
    plan_stands = (cases.plan == cases.items).astype(float)
    robust, fragile = judged & cases.robust, judged & cases.fragile
    return UncertainRow(
        method=method_key(make_method(spec)),
        plan=share(plan_right, lists),
        likeliest=share(right, lists),
        ahead=difference(right, plan_right, lists),
        unsure=share(cases.unsure()[judged], lists[judged]),
        changed=mean(cases.changed[judged], lists[judged]),
        changed_robust=mean(cases.changed[robust], lists[robust]),
        changed_fragile=mean(cases.changed[fragile], lists[fragile]),
        samples=mean(table["samples"], lists),
        endings={str(k): int(v) for k, v in table["ending"].value_counts().items()},
        lost=int(table["lost"].sum()),
        unjudged=int((~judged).sum()),
        cpu=mean(1e3 * table["cpu"], lists),
        plan_cpu=mean(1e3 * table["nominal_cpu"], lists),
        stands=reliability(cases.stands[judged], cases.stable[judged], lists[judged], _BINS),
        right=reliability(cases.sure[judged], right[judged], lists[judged], _BINS),
        plan_brier=mean((plan_stands - cases.stable)[judged] ** 2, lists[judged]),
        abstention=abstention(cases.sure[judged], right[judged], lists[judged]),
    )


def _alone(what: str, cases: _Cases) -> Alone:
    judged = cases.judged
    lists = cases.instances[judged]
    return Alone(what, mean(cases.changed[judged], lists), share(cases.unsure()[judged], lists))


def _check(asked: UncertainOptions, cases: _Cases) -> Check:
    table = cases.table
    rows = tuple(
        Checked(r.layout, r.scenario, float(s), r.low, r.high, r.samples, r.random)
        for r, s in zip(table.itertuples(), cases.stands, strict=True)
    )
    spread = cases.stands * (1.0 - cases.stands) / table["samples"]
    return Check(
        method=method_key(make_method(CHECK)),
        random=asked.random,
        inside=share([row.inside for row in rows], cases.instances),
        gain=ratio(spread, table["variance"], cases.instances),
        rows=rows,
    )

"""Typed results on uncertain verdicts, from the samples of labelled cases. Shares are 0 to 1."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from operator import attrgetter
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike, NDArray

from steadyload.layouts.benchmark import load_benchmark
from steadyload.layouts.benchmark.dataset import KEYS
from steadyload.methods.naming import MethodKey, method_key
from steadyload.methods.registry import make_method
from steadyload.methods.uncertainty import parse_uncertainty
from steadyload.reports.columns import (
    cell,
    column,
    counts,
    factor,
    milliseconds,
    percent,
    plain_percent,
    row,
    yes_no,
)
from steadyload.runs.accuracy import verdicts_against_labels
from steadyload.runs.comparison import difference
from steadyload.runs.costs import CostKind, CostSource
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.metrics import mean, ratio, share
from steadyload.statistics.reliability import Abstention, Reliability, abstention, reliability
from steadyload.studies.reliability import (
    Abstaining,
    Bin,
    Calibrated,
    abstaining,
    calibrated,
)
from steadyload.studies.uncertain.sampling import CHECK, Sampled, UncertainOptions

STANDS = "the load stands"
"""What a probability is of, beside the likeliest failing step."""

FEW = 10
"""Smallest number of cases of which a mean is shown."""

UNSURE = (0.05, 0.95)
"""Range of probabilities of standing in which a case counts as unsure."""

_BINS = (0.0, UNSURE[0], 0.35, 0.65, UNSURE[1], 1.0)
"""Edges of bins; few cases are unsure, so that bins of equal width would be nearly empty."""


def _enough(estimate: Estimate) -> str:
    return percent(estimate) if estimate.n >= FEW else cell(None)


def _counted(estimate: Estimate) -> str:
    return f"{estimate.value:.0f} [{estimate.low:.0f}, {estimate.high:.0f}]"


@row
class Judged:
    """Reliability of one method's verdicts on labelled cases that deviate from their plans."""

    method: MethodKey = column(form=attrgetter("title"), left=True)
    plan: Estimate = column("plan %", percent, "accuracy of its verdict on the plan")
    likeliest: Estimate = column(
        "likeliest step %", percent, "accuracy of the failing step that most samples have"
    )
    ahead: Estimate = column("ahead (points)", percent, "that minus the plan's, case by case")
    plan_brier: Estimate = column(
        "Brier, plan", factor, "mean squared difference of stable by the plan and by the label"
    )
    brier: Estimate = column("Brier, P", factor, "likewise, of the probability of standing")
    unsure: Estimate = column(
        "unsure %", _enough, "share of cases whose probability of standing is from 5 to 95 %"
    )
    changed: Estimate = column(
        "changed %", _enough, "mean share of samples with another failing step than the plan"
    )
    changed_robust: Estimate = column("robust %", _enough, "of cases whose label is so")
    changed_fragile: Estimate = column("fragile %", _enough, "likewise")
    samples: Estimate = column(form=_counted, about="mean number a case")
    plan_cpu: Estimate = column("CPU ms, plan", milliseconds)
    cpu: Estimate = column("CPU ms, all samples", milliseconds)
    endings: Mapping[str, int] = column(
        "sampling ended", counts, "cases by the reason for which sampling ended"
    )
    lost: int = column("samples without a verdict")
    unjudged: int = column("cases without one", about="without any sample with a verdict")


@row
class Alone:
    """Effect of the deviation of one quantity alone: shares as in :class:`Judged`."""

    what: str = column("deviates")
    changed: Estimate = column("changed %", percent)
    unsure: Estimate = column("unsure %", percent)


@row
class Checked:
    """A layout's probability of standing, by quasi-random and by many random samples."""

    layout: str = column()
    scenario: str = column()
    samples: int = column()
    stands: Estimate = column("P %", percent)
    random: float = column("random samples %", plain_percent)
    inside: bool = column(form=yes_no, about="the random samples' share lies in the interval")


@row
class Check:
    """Comparison of probabilities with those of ``random`` random samples a layout.

    ``gain``: number of random samples that one sample is worth, by the variance between the
    scramblings.
    """

    method: MethodKey
    random: int
    inside: Estimate
    gain: Estimate
    rows: Sequence[Checked]

    @property
    def count_inside(self) -> int:
        """Layouts whose random samples lie in the interval."""
        return sum(each.inside for each in self.rows)

    @property
    def farthest(self) -> float:
        """Largest distance of the two probabilities [points]."""
        return 100 * max(abs(each.stands.value - each.random) for each in self.rows)


@row
class Found:
    """All records for the page.

    ``item_lists``: number of clusters of the intervals. ``silent``: titles of methods without a
    verdict on any sample. ``calibrated``: probabilities of standing against the label, and of the
    likeliest step against its being the label's. ``abstaining``: accuracy without the cases whose
    likeliest step has the smallest share.
    """

    part: str
    uncertainty: str
    half_width: float
    most: int
    item_lists: int
    rows: Sequence[Judged]
    silent: Sequence[str]
    alone_method: MethodKey
    alone: Sequence[Alone]
    calibrated: Sequence[Calibrated]
    abstaining: Sequence[Abstaining]
    check: Check | None
    made_with: Mapping[str, str]
    costs: str = CostSource(CostKind.JUDGING).explained()
    few: int = FEW

    @property
    def first(self) -> Judged | None:
        """The most accurate of the methods that were asked of most cases."""
        return max(self.rows, key=lambda one: (one.plan.n, one.plan.value), default=None)

    @property
    def strongest(self) -> Alone | None:
        """The deviation that changes most."""
        return max(self.alone, key=lambda each: each.changed.value, default=None)

    @property
    def bins(self) -> list[Bin]:
        """All bins of :attr:`calibrated`."""
        return [one for own in self.calibrated for one in own.bins]


def summarise(asked: UncertainOptions, sampled: Sampled, made_with: Mapping[str, str]) -> Found:
    """The records of a run, compared with the labels of the set that comes with the package."""
    benchmark = load_benchmark()
    labels = benchmark.cases.set_index(KEYS)[["instance", "failing_step", "item_count"]]
    labels = labels.join(benchmark.confidence["robust"])
    every = {spec: _Cases(table, labels) for spec, table in sampled.methods.items()}
    heard = {spec: cases for spec, cases in every.items() if cases.judged.any()}
    given = {spec: cases.calibrations() for spec, cases in heard.items()}
    titles = {spec: method_key(make_method(spec)).title for spec in every}
    check = None
    if len(sampled.check):
        check = _check(asked, _Cases(sampled.check, labels))
    return Found(
        part=str(asked.part),
        uncertainty=str(parse_uncertainty(asked.uncertainty)),
        half_width=asked.sampling.half_width,
        most=asked.sampling.looks[-1],
        item_lists=len({name for cases in every.values() for name in cases.instances}),
        rows=[_row(spec, cases, given[spec][STANDS].brier) for spec, cases in heard.items()],
        silent=[title for spec, title in titles.items() if spec not in heard],
        alone_method=method_key(make_method(asked.alone_method)),
        alone=[_alone(what, _Cases(table, labels)) for what, table in sampled.alone.items()],
        calibrated=[
            calibrated(titles[spec], kind, found)
            for spec, kinds in given.items()
            for kind, found in kinds.items()
        ],
        abstaining=[abstaining(titles[spec], cases.abstention()) for spec, cases in heard.items()],
        check=check,
        made_with=made_with,
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

    def likeliest_right(self) -> NDArray[np.bool_]:
        """Mask of the cases on which the likeliest failing step is the label's."""
        return self.right(self.likeliest)

    def calibrations(self) -> dict[str, Reliability]:
        """Calibration of the probabilities that samples give, of those with a result."""
        here, right = self.judged, self.likeliest_right()
        lists = self.instances[here]
        return {
            STANDS: reliability(self.stands[here], self.stable[here], lists, _BINS),
            "the likeliest step is right": reliability(self.sure[here], right[here], lists, _BINS),
        }

    def abstention(self) -> Abstention:
        """Accuracy without the cases whose likeliest step has the smallest share."""
        here = self.judged
        return abstention(self.sure[here], self.likeliest_right()[here], self.instances[here])

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


def _row(spec: str, cases: _Cases, brier: Estimate) -> Judged:
    lists, table = cases.instances, cases.table
    judged = cases.judged
    plan_right, right = cases.right(table["nominal"]), cases.likeliest_right()
    plan_stands = (cases.plan == cases.items).astype(float)
    robust, fragile = judged & cases.robust, judged & cases.fragile
    return Judged(
        method=method_key(make_method(spec)),
        plan=share(plan_right, lists),
        likeliest=share(right, lists),
        ahead=difference(right, plan_right, lists),
        plan_brier=mean((plan_stands - cases.stable)[judged] ** 2, lists[judged]),
        brier=brier,
        unsure=share(cases.unsure()[judged], lists[judged]),
        changed=mean(cases.changed[judged], lists[judged]),
        changed_robust=mean(cases.changed[robust], lists[robust]),
        changed_fragile=mean(cases.changed[fragile], lists[fragile]),
        samples=mean(table["samples"], lists),
        plan_cpu=mean(1e3 * table["nominal_cpu"], lists),
        cpu=mean(1e3 * table["cpu"], lists),
        endings={str(k): int(v) for k, v in table["ending"].value_counts().items()},
        lost=int(table["lost"].sum()),
        unjudged=int((~judged).sum()),
    )


def _alone(what: str, cases: _Cases) -> Alone:
    judged = cases.judged
    lists = cases.instances[judged]
    return Alone(what, mean(cases.changed[judged], lists), share(cases.unsure()[judged], lists))


def _check(asked: UncertainOptions, cases: _Cases) -> Check:
    table = cases.table
    rows = [
        Checked(
            layout=r.layout,
            scenario=r.scenario,
            samples=r.samples,
            stands=Estimate(float(s), r.low, r.high, r.samples),
            random=r.random,
            inside=r.low <= r.random <= r.high,
        )
        for r, s in zip(table.itertuples(), cases.stands, strict=True)
    ]
    spread = cases.stands * (1.0 - cases.stands) / table["samples"]
    return Check(
        method=method_key(make_method(CHECK)),
        random=asked.random,
        inside=share([row.inside for row in rows], cases.instances),
        gain=ratio(spread, table["variance"], cases.instances),
        rows=rows,
    )

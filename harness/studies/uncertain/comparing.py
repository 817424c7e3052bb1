"""Typed results on uncertain verdicts, from the samples of labelled cases. Shares are 0 to 1."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from operator import attrgetter
from types import SimpleNamespace

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from steadyload.layouts.benchmark import load_benchmark
from steadyload.layouts.benchmark.dataset import KEYS
from steadyload.layouts.model.question import Question
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
    shown_column,
    yes_no,
)
from steadyload.runs.accuracy import verdicts_against_labels
from steadyload.runs.comparison import detectable, difference
from steadyload.runs.costs import CostKind, CostSource
from steadyload.statics.load_margin import MOST, margin_as_planned
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.metrics import mean, ratio, share
from steadyload.statistics.reliability import abstention, reliability
from steadyload.studies.reliability import Abstaining, Bin, Calibrated, abstaining, calibrated
from steadyload.studies.uncertain.sampling import (
    ALONE_METHOD,
    CHECK,
    PART,
    RANDOM,
    SAMPLING,
    SET,
    UNCERTAIN,
    Sampled,
)

FEW = 10
"""Smallest number of cases of which a mean is shown."""

UNSURE = (0.05, 0.95)
"""Range of probabilities of standing in which a case counts as unsure."""

_MARGINS = (0.0, 0.1, 0.25, 0.5, 1.0, 2.0, 3.0, 5.0, MOST, math.inf)
"""Edges of classes of margins [cm]."""

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
    shown: float = shown_column()
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
class Worth:
    """Probability that plans of about one margin stand."""

    margin: str = column("margin cm")
    stands: Estimate = column("P %", percent, "on average")
    firm: Estimate = column("P 95 % or more %", percent, "share of plans")
    least: float = column("least P %", plain_percent)


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
    def farthest(self) -> float:
        """Largest distance of the two probabilities [points]."""
        return 100 * max(abs(each.stands.value - each.random) for each in self.rows)


class Found(SimpleNamespace):
    """All that the page shows."""

    rows: Sequence[Judged]
    alone_method: MethodKey
    alone: Sequence[Alone]
    calibrated: Sequence[Calibrated]
    abstaining: Sequence[Abstaining]
    check: Check | None
    worth: Sequence[Worth]
    first: Judged
    bins: list[Bin]
    made_with: Mapping[str, str]


def _first(rows: Sequence[Judged]) -> Judged:
    return max(rows, key=lambda one: (one.plan.n, one.plan.value))


def summarise(sampled: Sampled, made_with: Mapping[str, str], asked: str = "within") -> Found:
    """The records of a run, compared with the labels.

    Args:
        sampled: the samples.
        made_with: provenance of the samples.
        asked: the question whose labels they are compared with.
    """
    alone_method = ALONE_METHOD[asked]
    labels = _labels(asked)
    keys = {spec: method_key(make_method(spec)) for spec in (*sampled.methods, alone_method, CHECK)}
    every = {keys[spec]: _Cases(table, labels) for spec, table in sampled.methods.items()}
    rows = [_row(key, cases) for key, cases in every.items()]
    check = None
    if len(sampled.check):
        check = _check(keys[CHECK], _Cases(sampled.check, labels))
    first = _first(rows)
    calibrations = [row for key, cases in every.items() for row in cases.calibrated(key.title)]
    return Found(
        labelled_set=SET,
        part=str(PART),
        asked=asked,
        stable=next(iter(every.values())).stable.mean(),
        uncertainty=str(parse_uncertainty(UNCERTAIN)),
        half_width=SAMPLING.half_width,
        most=SAMPLING.looks[-1],
        item_lists=len({name for cases in every.values() for name in cases.lists}),
        rows=rows,
        first=first,
        alone_method=keys[alone_method],
        alone=[_alone(what, _Cases(table, labels)) for what, table in sampled.alone.items()],
        calibrated=calibrations,
        bins=[one for own in calibrations for one in own.bins],
        abstaining=[cases.abstaining(key.title) for key, cases in every.items()],
        check=check,
        worth=list(_worth(every[first.method])),
        costs=CostSource(CostKind.JUDGING).explained(),
        few=FEW,
        made_with=made_with,
    )


def _worth(cases: _Cases) -> Iterator[Worth]:
    """Probabilities of standing over the margin, of plans that have one as planned."""
    benchmark, margins = load_benchmark(SET), []
    for case, judged in zip(cases.table[KEYS].itertuples(index=False), cases.judged, strict=True):
        margin = margin_as_planned(benchmark.layout(case.layout, case.scenario))
        margins.append(margin.cm if margin is not None and judged else math.nan)
    for low, high in itertools.pairwise(_MARGINS):
        here = (np.array(margins) >= low) & (np.array(margins) < high)
        if here.any():
            stands, lists = cases.stands[here], cases.lists[here]
            title = f"{low:g} to {high:g}" if math.isfinite(high) else f"{low:g} or more"
            yield Worth(
                title, mean(stands, lists), share(stands >= UNSURE[1], lists), float(stands.min())
            )


def _labels(asked: str) -> pd.DataFrame:
    """Labels of a question, by case, and whether they are robust, where that is known."""
    benchmark, question = load_benchmark(SET), Question(asked)
    cases = benchmark.select(PART, question=question).set_index(KEYS)
    robust = benchmark.confidence_on(question)["robust"]
    return cases[["instance", "failing_step", "item_count"]].join(robust)


class _Cases:
    """A table of :class:`Sampled` with the labels of its cases, a value a case.

    Attributes:
        lists: item lists.
        judged: whether a sample has a verdict; of the others the next four are not a number.
        stands, sure, changed: shares of samples that stand, that have the likeliest failing step,
            and that have another one than the plan.
        plan_right, right: whether the plan's failing step, and the likeliest one, is the label's.
    """

    def __init__(self, table: pd.DataFrame, labels: pd.DataFrame) -> None:
        own = labels.loc[pd.MultiIndex.from_frame(table[KEYS])]
        plan = table["nominal"].fillna(-1).astype(int)
        said = [
            _shares(dict(safe), *of)
            for safe, *of in zip(table["safe"], plan, table["item_count"], strict=True)
        ]
        self.stands, likeliest, self.sure, self.changed = np.array(said).T
        self.table = table
        self.lists = own["instance"].to_numpy()
        self.stable = own["failing_step"].isna().to_numpy()
        self.judged = ~np.isnan(self.sure)
        self.robust = self.judged & own["robust"].fillna(False).to_numpy(bool)
        self.fragile = self.judged & ~own["robust"].fillna(True).to_numpy(bool)
        self.plan_stands = (plan == table["item_count"]).to_numpy(float)
        self.plan_right, self.right = (
            verdicts_against_labels(pd.Series(safe), own)["right"].to_numpy(bool)
            for safe in (table["nominal"], likeliest)
        )
        self.unsure = (self.stands >= UNSURE[0]) & (self.stands <= UNSURE[1])

    def calibrated(self, judge: str) -> list[Calibrated]:
        """Calibration of the probabilities that samples give, of those with a result."""
        of = {
            "the load stands": (self.stands, self.stable),
            "the likeliest step is right": (self.sure, self.right),
        }
        here = self.judged
        return [
            calibrated(judge, kind, reliability(p[here], true[here], self.lists[here], _BINS))
            for kind, (p, true) in of.items()
        ]

    def abstaining(self, judge: str) -> Abstaining:
        """Accuracy without the cases whose likeliest step has the smallest share."""
        here = self.judged
        return abstaining(judge, abstention(self.sure[here], self.right[here], self.lists[here]))


def _shares(safe: dict[int, int], plan: int, count: int) -> tuple[float, float, float, float]:
    """Of samples: the share that stands, the likeliest number of items placed safely, its share,
    and the share with another one than the plan; not a number without a verdict.
    """
    total = sum(safe.values())
    if not total:
        return np.nan, np.nan, np.nan, np.nan
    likeliest = max(sorted(safe), key=lambda step: safe[step])
    stands, sure, plans = (safe.get(step, 0) / total for step in (count, likeliest, plan))
    return stands, likeliest, sure, 1.0 - plans


def _row(method: MethodKey, cases: _Cases) -> Judged:
    lists, table, judged = cases.lists, cases.table, cases.judged

    ahead = difference(cases.right, cases.plan_right, lists)

    def squared(forecast: NDArray[np.float64]) -> Estimate:
        return mean((forecast - cases.stable)[judged] ** 2, lists[judged])

    return Judged(
        method=method,
        plan=share(cases.plan_right, lists),
        likeliest=share(cases.right, lists),
        ahead=ahead,
        shown=detectable(ahead, len(set(lists))),
        plan_brier=squared(cases.plan_stands),
        brier=squared(cases.stands),
        unsure=share(cases.unsure[judged], lists[judged]),
        changed=mean(cases.changed[judged], lists[judged]),
        changed_robust=mean(cases.changed[cases.robust], lists[cases.robust]),
        changed_fragile=mean(cases.changed[cases.fragile], lists[cases.fragile]),
        samples=mean(table["samples"], lists),
        plan_cpu=mean(1e3 * table["nominal_cpu"], lists),
        cpu=mean(1e3 * table["cpu"], lists),
        endings={str(k): int(v) for k, v in table["ending"].value_counts().items()},
        lost=int(table["lost"].sum()),
        unjudged=int((~judged).sum()),
    )


def _alone(what: str, cases: _Cases) -> Alone:
    judged = cases.judged
    lists = cases.lists[judged]
    return Alone(what, mean(cases.changed[judged], lists), share(cases.unsure[judged], lists))


def _check(method: MethodKey, cases: _Cases) -> Check:
    rows = [
        Checked(
            layout=r.layout,
            scenario=r.scenario,
            samples=r.samples,
            stands=Estimate(float(s), r.low, r.high, r.samples),
            random=r.random,
            inside=r.low <= r.random <= r.high,
        )
        for r, s in zip(cases.table.itertuples(), cases.stands, strict=True)
    ]
    spread = cases.stands * (1.0 - cases.stands) / cases.table["samples"]
    return Check(
        method=method,
        random=RANDOM,
        inside=share([row.inside for row in rows], cases.lists),
        gain=ratio(spread, cases.table["variance"], cases.lists),
        rows=rows,
    )

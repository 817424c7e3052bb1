"""Computation of records for a page from the samples of labelled cases."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from steadyload.layouts.benchmark import load_benchmark
from steadyload.layouts.benchmark.dataset import KEYS
from steadyload.methods.naming import method_key
from steadyload.methods.registry import make_method
from steadyload.methods.uncertainty import parse_uncertainty
from steadyload.statistics.metrics import mean, ratio, share
from steadyload.statistics.reliability import abstention, reliability
from steadyload.studies.uncertain.records import (
    Alone,
    Check,
    Checked,
    Uncertain,
    UncertainRow,
)
from steadyload.studies.uncertain.study import CHECK, Sampled, UncertainOptions

UNSURE = (0.05, 0.95)
"""Range of probabilities of standing in which a case counts as unsure."""

_BINS = (0.0, UNSURE[0], 0.35, 0.65, UNSURE[1], 1.0)
"""Edges of bins; few cases are unsure, so that bins of equal width would be nearly empty."""


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
    likeliest: int
    sure: float
    changed: float


class _Cases:
    """A table of :class:`Sampled` with the labels of its cases."""

    def __init__(self, table: pd.DataFrame, labels: pd.DataFrame) -> None:
        self.table = table
        mine = labels.loc[pd.MultiIndex.from_frame(table[KEYS])]
        self.instances: NDArray[Any] = mine["instance"].to_numpy()
        counts = mine["item_count"].astype(int)
        self.label: NDArray[np.int64] = mine["failing_step"].fillna(counts).astype(int).to_numpy()
        self.stable: NDArray[np.bool_] = mine["failing_step"].isna().to_numpy()
        self.robust: NDArray[np.bool_] = mine["robust"].fillna(False).to_numpy(bool)
        self.fragile: NDArray[np.bool_] = ~mine["robust"].fillna(True).to_numpy(bool)
        self.plan: NDArray[np.int64] = table["nominal"].fillna(-1).astype(int).to_numpy()
        self.items: NDArray[np.int64] = table["item_count"].to_numpy()
        answers = [
            _answer(dict(safe), plan, count)
            for safe, plan, count in zip(table["safe"], self.plan, self.items, strict=True)
        ]
        self.judged = np.array([answer is not None for answer in answers])
        given = [answer or _Answer(np.nan, -1, np.nan, np.nan) for answer in answers]
        self.stands = np.array([answer.stands for answer in given])
        self.likeliest = np.array([answer.likeliest for answer in given])
        self.sure = np.array([answer.sure for answer in given])
        self.changed = np.array([answer.changed for answer in given])

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
    plan_right, right = cases.plan == cases.label, cases.likeliest == cases.label
    plan_stands = (cases.plan == cases.items).astype(float)
    robust, fragile = judged & cases.robust, judged & cases.fragile
    return UncertainRow(
        method=method_key(make_method(spec)),
        plan=share(plan_right, lists),
        likeliest=share(right, lists),
        ahead=mean(right.astype(float) - plan_right, lists),
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

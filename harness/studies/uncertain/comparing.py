"""Typed results on uncertain verdicts, from the samples of labelled cases. Shares are 0 to 1."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from types import SimpleNamespace

import numpy as np
import pandas as pd

from steadyload.layouts.benchmark import load_benchmark
from steadyload.layouts.benchmark.dataset import KEYS
from steadyload.layouts.model.question import Question
from steadyload.methods.naming import method_key
from steadyload.methods.registry import make_method
from steadyload.methods.uncertainty import parse_uncertainty
from steadyload.reports.columns import (
    column,
    percent,
    plain_percent,
    row,
    yes_no,
)
from steadyload.reports.frame_columns import FEW
from steadyload.runs import frames as v
from steadyload.runs.accuracy import verdicts_against_labels
from steadyload.runs.comparison import detectable
from steadyload.runs.costs import CostKind, CostSource
from steadyload.statics.load_margin import MOST, margin_as_planned
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.metrics import ratio, share
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

UNSURE = (0.05, 0.95)
"""Range of probabilities of standing in which a case counts as unsure."""

_MARGINS = (0.0, 0.1, 0.25, 0.5, 1.0, 2.0, 3.0, 5.0, MOST, math.inf)
"""Edges of classes of margins [cm]."""

_BINS = (0.0, UNSURE[0], 0.35, 0.65, UNSURE[1], 1.0)
"""Edges of bins; few cases are unsure, so that bins of equal width would be nearly empty."""


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

    title: str
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

    calibrated: Sequence[Calibrated]
    abstaining: Sequence[Abstaining]
    bins: Sequence[Bin]
    check: Check | None
    made_with: Mapping[str, str]


def summarise(sampled: Sampled, made_with: Mapping[str, str], asked: str = "within") -> Found:
    """The records of a run, compared with the labels."""
    labels, alone_method = _labels(asked), ALONE_METHOD[asked]
    frame = _cases(sampled.methods, labels).rename(columns={"of": "method"})
    heard = frame[frame["judged"]]
    methods = frame.groupby("method", sort=False)
    ahead = v.mean(frame.assign(ahead=_apart(frame)), "ahead", ["method"])
    rows = pd.DataFrame(
        {
            "title": [_title(spec) for spec in sampled.methods],
            "plan_right": v.share(frame, "plan_right", ["method"]),
            "likeliest": v.share(frame, "right", ["method"]),
            "ahead": ahead,
            "shown": [detectable(ahead[spec], own["instance"].nunique()) for spec, own in methods],
            "plan_brier": v.mean(heard, "plan_squared", ["method"]),
            "p_brier": v.mean(heard, "squared", ["method"]),
            "unsure": v.share(heard, "unsure", ["method"]),
            "samples_change": v.mean(heard, "samples_change", ["method"]),
            "change_robust": v.mean(heard[heard["robust"]], "samples_change", ["method"]),
            "change_fragile": v.mean(heard[heard["fragile"]], "samples_change", ["method"]),
            "samples": v.mean(frame, "samples", ["method"]),
            "plan_cpu": v.mean(frame, "plan_cpu", ["method"]),
            "cpu": v.mean(frame, "case_cpu", ["method"]),
            "endings": [own["ending"].value_counts().to_dict() for _, own in methods],
            "samples_lost": methods["lost"].sum(),
            "unjudged": methods["judged"].agg(lambda own: int((~own).sum())),
        },
        index=list(sampled.methods),
    )
    most = {spec: (own.n, own.value) for spec, own in rows["plan_right"].items()}
    first = max(most, key=most.__getitem__)
    alone = _cases(sampled.alone, labels)
    alone = alone[alone["judged"]]
    calibrations = [one for _, own in methods for one in _calibrated(own)]
    return Found(
        labelled_set=SET,
        part=str(PART),
        asked=asked,
        stable=next(iter(methods))[1]["stable"].mean(),
        uncertainty=str(parse_uncertainty(UNCERTAIN)),
        half_width=SAMPLING.half_width,
        most=SAMPLING.looks[-1],
        item_lists=frame["instance"].nunique(),
        rows=rows,
        first=rows.loc[first],
        alone_method=_title(alone_method),
        alone=pd.DataFrame(
            {
                "deviates": list(sampled.alone),
                "samples_change": v.mean(alone, "samples_change", ["of"]),
                "unsure": v.share(alone, "unsure", ["of"]),
            },
            index=list(sampled.alone),
        ),
        calibrated=calibrations,
        bins=[one for own in calibrations for one in own.bins],
        abstaining=[_abstaining(own) for _, own in methods],
        check=_check(_cases({CHECK: sampled.check}, labels)) if len(sampled.check) else None,
        worth=_worth(frame[frame["method"] == first]),
        costs=CostSource(CostKind.JUDGING).explained(),
        few=FEW,
        made_with=made_with,
    )


def _title(spec: str) -> str:
    return method_key(make_method(spec)).title


def _apart(frame: pd.DataFrame) -> pd.Series:
    """By case, whether the likeliest step is right, less whether that of the plan is."""
    return frame["right"].astype(float) - frame["plan_right"].astype(float)


def _worth(cases: pd.DataFrame) -> pd.DataFrame:
    """Probabilities of standing over the margin, of plans that have one as planned."""
    benchmark = load_benchmark(SET)
    margins = [
        margin_as_planned(benchmark.layout(*case)) for case in cases[KEYS].itertuples(index=False)
    ]
    cm = pd.Series([math.nan if own is None else own.cm for own in margins], cases.index)
    titles = [
        f"{low:g} to {high:g}" if math.isfinite(high) else f"{low:g} or more"
        for low, high in itertools.pairwise(_MARGINS)
    ]
    margin = pd.cut(cm.where(cases["judged"]), _MARGINS, right=False, labels=titles)
    found = cases.assign(margin=margin, firm=cases["stands"] >= UNSURE[1]).dropna(subset="margin")
    found = found.sort_values("margin", kind="stable")
    stands = v.mean(found, "stands", ["margin"])
    return pd.DataFrame(
        {
            "margin": [str(title) for title in stands.index],
            "p_stands": stands,
            "firm": v.share(found, "firm", ["margin"]),
            "p_least": found.groupby("margin", observed=True)["stands"].min(),
        },
        index=stands.index,
    )


def _labels(asked: str) -> pd.DataFrame:
    """Labels of a question, by case, and whether they are robust, where that is known."""
    benchmark, question = load_benchmark(SET), Question(asked)
    cases = benchmark.select(PART, question=question).set_index(KEYS)
    robust = benchmark.confidence_on(question)["robust"]
    return cases[["instance", "failing_step", "item_count"]].join(robust)


def _cases(tables: Mapping[str, pd.DataFrame], labels: pd.DataFrame) -> pd.DataFrame:
    """A row a case of each table of :class:`Sampled`, with the label of the case.

    ``of``: of which table. ``judged``: whether a sample has a verdict. ``stands``, ``sure``,
    ``samples_change``: shares of samples that stand, that have the likeliest failing step, and that
    have another one than the plan. ``plan_right``, ``right``: whether the plan's failing step, and
    the likeliest one, is the label's.
    """
    table = pd.concat(tables, names=["of"]).reset_index("of").reset_index(drop=True)
    own = labels.loc[pd.MultiIndex.from_frame(table[KEYS])]
    plan = table["nominal"].fillna(-1).astype(int)
    said = [
        _shares(dict(safe), *of)
        for safe, *of in zip(table["safe"], plan, table["item_count"], strict=True)
    ]
    stands, likeliest, sure, change = np.array(said).T
    stable, judged = own["failing_step"].isna().to_numpy(), ~np.isnan(sure)
    plan_right, right = (
        verdicts_against_labels(pd.Series(safe), own)["right"].to_numpy(bool)
        for safe in (table["nominal"], likeliest)
    )
    return table.assign(
        instance=own["instance"].to_numpy(),
        cluster=own["instance"].to_numpy(),
        stable=stable,
        judged=judged,
        stands=stands,
        sure=sure,
        samples_change=change,
        unsure=(stands >= UNSURE[0]) & (stands <= UNSURE[1]),
        robust=own["robust"].fillna(False).to_numpy(bool),
        fragile=~own["robust"].fillna(True).to_numpy(bool),
        plan_right=plan_right,
        right=right,
        plan_squared=((plan == table["item_count"]).astype(float) - stable) ** 2,
        squared=(stands - stable) ** 2,
        plan_cpu=1e3 * table["nominal_cpu"],
        case_cpu=1e3 * table["cpu"],
    )


def _calibrated(cases: pd.DataFrame) -> list[Calibrated]:
    """Calibration of the probabilities that samples of a method give, of those with a result."""
    own, title = cases[cases["judged"]], _title(cases["method"].iloc[0])
    lists = own["instance"].to_numpy()
    of = {"the load stands": ("stands", "stable"), "the likeliest step is right": ("sure", "right")}
    return [
        calibrated(title, kind, reliability(own[p].to_numpy(), own[true].to_numpy(), lists, _BINS))
        for kind, (p, true) in of.items()
    ]


def _abstaining(cases: pd.DataFrame) -> Abstaining:
    """Accuracy of a method without the cases whose likeliest step has the smallest share."""
    own, title = cases[cases["judged"]], _title(cases["method"].iloc[0])
    sure, right, lists = (own[name].to_numpy() for name in ("sure", "right", "instance"))
    return abstaining(title, abstention(sure, right, lists))


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


def _check(cases: pd.DataFrame) -> Check:
    rows = [
        Checked(
            layout=r.layout,
            scenario=r.scenario,
            samples=r.samples,
            stands=Estimate(float(r.stands), r.low, r.high, r.samples),
            random=r.random,
            inside=r.low <= r.random <= r.high,
        )
        for r in cases.itertuples()
    ]
    spread = cases["stands"] * (1.0 - cases["stands"]) / cases["samples"]
    return Check(
        title=_title(CHECK),
        random=RANDOM,
        inside=share([row.inside for row in rows], cases["instance"]),
        gain=ratio(spread, cases["variance"], cases["instance"]),
        rows=rows,
    )

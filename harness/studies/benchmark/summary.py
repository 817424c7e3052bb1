"""Typed results of a labelled set: what it holds, and how sure its labels are."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd

from steadyload.labelling.both_labels import QuestionShares, question_shares
from steadyload.layouts.benchmark.confidence import ENSEMBLE, Reason, agrees
from steadyload.layouts.benchmark.dataset import HELD_OUT, KEYS, SPLITS, Benchmark
from steadyload.layouts.benchmark.tables import BenchmarkError
from steadyload.layouts.model.scenarios import Scenario
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.metrics import mean, share
from steadyload.statistics.placed import items_placed_by_case

PUBLISHED_STABLE: Mapping[str, float] = {"S1": 0.790, "S2a": 0.760, "S2b": 0.708}
"""Share of stable layouts in the paper's sub-dataset 2, before balancing."""

_THRESHOLD_T, _THRESHOLD_R = 9.9995, 9.9995
"""Thresholds of 10 cm and 10 degrees for stored movements, which are rounded to thousandths."""

_BINS = 10
STABLE = "stable"


@dataclass(frozen=True, slots=True)
class ClassCount:
    """One item class: item lists, distinct geometries, items a layout, share of stable cases."""

    item_class: int
    instances: int
    layouts: int
    items: Estimate
    stable: Estimate


@dataclass(frozen=True, slots=True)
class SplitCount:
    """One split in one scenario; ``split`` is None for labelled cases of no split."""

    split: str | None
    scenario: str
    instances: int
    cases: int
    stable: int


@dataclass(frozen=True, slots=True)
class NaturalStable:
    """Share of layouts that can be loaded, before anything is balanced, in one scenario.

    ``packings``: likewise where a geometry counts as often as a heuristic gave it.
    ``criterion_paper``: likewise under the other criterion; ``other_label``: share of cases whose
    failing step differs between the two. ``published``: the paper's share, None where it has none.
    """

    scenario: str
    stable: Estimate
    packings: Estimate
    criterion_paper: Estimate | None
    other_label: Estimate | None
    published: float | None


@dataclass(frozen=True, slots=True)
class FailureReason:
    """Reasons for which loadings fail: shares of the unstable cases of a scenario."""

    reason: str
    shares: Mapping[str, Estimate]


@dataclass(frozen=True, slots=True)
class Firmness:
    """Confidence of the labels of a split in one scenario: its mean and the share of robust labels.

    ``parts`` is the mean agreement by reason of doubt.
    """

    split: str
    scenario: str
    confidence: Estimate
    robust: Estimate
    parts: Mapping[str, Estimate]


@dataclass(frozen=True, slots=True)
class MethodAgreement:
    """Agreement of one further method with the labels of the test split, by scenario and pooled.

    ``robust`` counts robust labels alone; None for the ensemble that defines them.
    """

    reason: str
    judge: str
    by_scenario: Mapping[str, Estimate]
    pooled: Estimate
    robust: Estimate | None
    earlier: int
    later: int
    without_verdict: int


@dataclass(frozen=True, slots=True)
class RobustDispute:
    """A robust label that an engine disagrees with.

    ``corner`` [cm] and ``angle`` [degrees]: how far the reference moved at the step at which the
    two part; ``margin`` [cm]: of the equilibrium there. ``said``: the failing step by each engine.
    """

    layout: str
    scenario: str
    item_count: int
    label: str
    said: Mapping[str, str]
    step: int
    corner: float
    angle: float
    margin: float | None


@dataclass(frozen=True, slots=True)
class BenchmarkSummary:
    """Everything the page of a labelled set shows.

    ``item_counts``: layouts by number of items. ``scores``: by scenario, cases by failing step's
    share of the items in ten bins, the last for stable ones.
    """

    layouts: int
    cases: int
    instances: int
    without_label: int
    classes: tuple[ClassCount, ...]
    splits: tuple[SplitCount, ...]
    natural: tuple[NaturalStable, ...]
    item_counts: Mapping[int, int]
    scores: Mapping[str, tuple[int, ...]]
    both_labels: tuple[QuestionShares, ...]
    reasons: tuple[FailureReason, ...]
    firmness: tuple[Firmness, ...]
    judges: tuple[MethodAgreement, ...]
    disputes: tuple[RobustDispute, ...]


def summarise(benchmark: Benchmark) -> BenchmarkSummary:
    """Counts, shares and agreements of a labelled set; every interval resamples item lists.

    Raises:
        BenchmarkError: nothing is labelled.
    """
    cases = benchmark.cases
    done = cases[cases["status"] == "done"]
    if done.empty:
        raise BenchmarkError("nothing in this set is labelled yet")
    packings = benchmark.layouts["sources"].map(len)
    done = done.assign(packings=packings.reindex(done["layout"]).to_numpy())
    scenarios = [str(s) for s in Scenario if (done["scenario"] == str(s)).any()]
    counts = benchmark.layouts["sizes"].map(len) // 3
    sizes = counts.value_counts().sort_index()
    said = _test_verdicts(benchmark)
    return BenchmarkSummary(
        layouts=len(benchmark.layouts),
        cases=len(cases),
        instances=benchmark.layouts["instance"].nunique(),
        without_label=len(cases) - len(done),
        classes=tuple(_classes(benchmark, done, counts)),
        splits=tuple(_splits(done, scenarios)),
        natural=tuple(_natural(done[done["scenario"] == s], s) for s in scenarios),
        item_counts={int(k): int(v) for k, v in sizes.items()},
        scores={s: _scores(done[done["scenario"] == s]) for s in scenarios},
        both_labels=tuple(question_shares(benchmark)),
        reasons=tuple(_reasons(done, scenarios)),
        firmness=tuple(_firmness(benchmark, done, scenarios)),
        judges=tuple(_agreement(said, scenarios)),
        disputes=tuple(_disputes(benchmark, said)),
    )


def _classes(benchmark: Benchmark, done: pd.DataFrame, counts: pd.Series) -> list[ClassCount]:
    rows = []
    classes = benchmark.layouts["item_class"].reindex(done["layout"]).to_numpy()
    for number, group in benchmark.layouts.groupby("item_class"):
        own = done[classes == number]
        rows.append(
            ClassCount(
                item_class=int(number),
                instances=group["instance"].nunique(),
                layouts=len(group),
                items=mean(counts[group.index], group["instance"]),
                stable=share(own["failing_step"].isna(), own["instance"]),
            )
        )
    return rows


def _splits(done: pd.DataFrame, scenarios: list[str]) -> list[SplitCount]:
    rows = []
    for split in (*SPLITS, None):
        own = done[done["split"].isna() if split is None else done["split"] == split]
        for scenario in scenarios:
            part = own[own["scenario"] == scenario]
            stable = int(part["failing_step"].isna().sum())
            lists = part["instance"].nunique()
            rows += [SplitCount(split, scenario, lists, len(part), stable)] if lists else []
    return rows


def _natural(done: pd.DataFrame, scenario: str) -> NaturalStable:
    known = not done["failing_step_paper"].isna().all()
    stable, paper = done["failing_step"].fillna(-1), done["failing_step_paper"].fillna(-1)
    return NaturalStable(
        scenario=scenario,
        stable=share(stable == -1, done["instance"]),
        packings=_of_packings(stable == -1, done["packings"], done["instance"]),
        criterion_paper=share(paper == -1, done["instance"]) if known else None,
        other_label=share(stable != paper, done["instance"]) if known else None,
        published=PUBLISHED_STABLE.get(scenario),
    )


def _of_packings(stable: pd.Series, packings: pd.Series, instances: pd.Series) -> Estimate:
    """Share of stable cases when every packing counts, as files of the published set do."""
    rows = stable.index.repeat(packings)
    return share(stable.loc[rows], instances.loc[rows])


def _scores(done: pd.DataFrame) -> tuple[int, ...]:
    """Cases by loading stability: ten bins below 1, and the stable ones."""
    failed = done.dropna(subset=["failing_step"]).astype({"failing_step": int, "item_count": int})
    tenth = _BINS * failed["failing_step"] // failed["item_count"]  # whole numbers: 0.3 is 0.3
    counts = np.bincount(tenth, minlength=_BINS)
    return (*counts.tolist(), len(done) - len(failed))


def _reasons(done: pd.DataFrame, scenarios: list[str]) -> list[FailureReason]:
    """Events at the failing step, as shares of the unstable cases."""
    known = done["corner_last"].notna() & done["margin"].notna()
    failed = done[done["failing_step"].notna() & known]
    if failed.empty:
        return []
    rows = pd.DataFrame([_at_failure(row) for row in failed.itertuples(index=False)], failed.index)
    titles = {
        "shift": "beyond 10 cm only",
        "turn": "beyond 10 degrees only",
        "both": "beyond both",
        "placed": "the item just placed moves furthest",
        "balance": "no equilibrium (margin below 0)",
        "recent": "at the last item of the layout",
    }
    own = {scenario: failed["scenario"] == scenario for scenario in scenarios}
    return [
        FailureReason(
            title, {s: share(rows[key][here], failed["instance"][here]) for s, here in own.items()}
        )
        for key, title in titles.items()
    ]


def _at_failure(row: object) -> dict[str, bool]:
    step = int(row.failing_step)  # type: ignore[attr-defined]
    shift = row.corner_last[step] > _THRESHOLD_T  # type: ignore[attr-defined]
    turn = row.angle_last[step] > _THRESHOLD_R  # type: ignore[attr-defined]
    return {
        "shift": bool(shift and not turn),
        "turn": bool(turn and not shift),
        "both": bool(shift and turn),
        "placed": int(row.moved[step]) == step,  # type: ignore[attr-defined]
        "balance": bool(row.margin[step] < 0.0),  # type: ignore[attr-defined]
        "recent": step == int(row.item_count) - 1,  # type: ignore[attr-defined]
    }


def _firmness(benchmark: Benchmark, done: pd.DataFrame, scenarios: list[str]) -> list[Firmness]:
    known = done.merge(benchmark.confidence.reset_index(), on=KEYS, how="inner")
    known = known[known["robust"].notna()]
    rows = []
    for split in HELD_OUT:
        for scenario in scenarios:
            own = known[(known["split"] == split) & (known["scenario"] == scenario)]
            if len(own):
                rows.append(
                    Firmness(
                        split=split,
                        scenario=scenario,
                        confidence=mean(own["confidence"], own["instance"]),
                        robust=share(own["robust"].astype(bool), own["instance"]),
                        parts={str(r): mean(own[str(r)], own["instance"]) for r in ENSEMBLE},
                    )
                )
    return rows


def _test_verdicts(benchmark: Benchmark) -> pd.DataFrame:
    """Further methods' verdicts on the test split, with label, instance, robustness, agreement."""
    test = benchmark.cases[benchmark.cases["split"] == "test"]
    columns = [*KEYS, "instance", "item_count", "failing_step"]
    said = benchmark.opinions.merge(
        test[columns].rename(columns={"failing_step": "label"}), on=KEYS, how="inner"
    )
    robust = benchmark.confidence["robust"].rename("robust").reset_index()
    said = said.merge(robust, on=KEYS, how="left")
    return said.assign(agrees=agrees(benchmark.cases, said).to_numpy())


def _agreement(said: pd.DataFrame, scenarios: list[str]) -> list[MethodAgreement]:
    """Agreement of every further method, from the rows of :func:`_test_verdicts`."""
    rows = []
    for reason in map(str, Reason):
        part = said[said["reason"] == reason]
        for judge in part["judge"].unique():
            own = part[part["judge"] == judge]
            firm = own[own["robust"].fillna(False).astype(bool)]
            answered = own[own["status"] == "done"]
            label = items_placed_by_case(answered["label"], answered["item_count"])
            step = items_placed_by_case(answered["failing_step"], answered["item_count"])
            rows.append(
                MethodAgreement(
                    reason=reason,
                    judge=str(judge),
                    by_scenario={s: _agreeing(own[own["scenario"] == s]) for s in scenarios},
                    pooled=_agreeing(own),
                    robust=None if reason in map(str, ENSEMBLE) else _agreeing(firm),
                    earlier=int((step < label).sum()),
                    later=int((step > label).sum()),
                    without_verdict=len(own) - len(answered),
                )
            )
    return rows


def _agreeing(verdicts: pd.DataFrame) -> Estimate:
    return share(verdicts["agrees"], verdicts["instance"])


def _disputes(benchmark: Benchmark, said: pd.DataFrame) -> list[RobustDispute]:
    """Robust labels of the test split that some engine disagrees with."""
    engines = said[(said["reason"] == str(Reason.ENGINE)) & said["robust"].fillna(False)]
    traces = benchmark.cases.set_index(KEYS)
    rows = []
    for (name, scenario), group in engines[~engines["agrees"]].groupby(KEYS):
        every = engines[(engines["layout"] == name) & (engines["scenario"] == scenario)]
        case = traces.loc[(name, scenario)]
        count = int(case["item_count"])
        steps = (count - 1, case["failing_step"], *group["failing_step"])
        first = min(int(step) for step in steps if not pd.isna(step))
        seen = case["corner_last"] is not None and first < len(case["corner_last"])
        rows.append(
            RobustDispute(
                layout=str(name),
                scenario=str(scenario),
                item_count=count,
                label=_said(case["failing_step"], "done"),
                said={str(v.judge): _said(v.failing_step, v.status) for v in every.itertuples()},
                step=first,
                corner=float(case["corner_last"][first]) if seen else math.nan,
                angle=float(case["angle_last"][first]) if seen else math.nan,
                margin=float(case["margin"][first]) if seen else None,
            )
        )
    return rows


def _said(step: object, status: str) -> str:
    if status != "done":
        return status
    return STABLE if pd.isna(step) else str(int(step))  # type: ignore[call-overload]

"""Counts of a labelled set, and how sure its labels are; intervals resample item lists."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import SimpleNamespace

import numpy as np
import pandas as pd

from steadyload.labelling.both_labels import QuestionShares, question_shares
from steadyload.layouts.benchmark.confidence import ENSEMBLE, Reason
from steadyload.layouts.benchmark.dataset import KEYS, Benchmark
from steadyload.layouts.benchmark.parts import HELD_OUT, SPLITS
from steadyload.layouts.benchmark.tables import BenchmarkError
from steadyload.layouts.model.question import Question
from steadyload.layouts.model.scenarios import Scenario
from steadyload.reports.columns import column, fixed, percent, plain_percent, row
from steadyload.runs.labels import made_with
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.metrics import mean, share
from steadyload.studies.benchmark.disputed import (
    STABLE,
    MethodAgreement,
    RobustDispute,
    agreements,
    disputes,
    verdicts_on_test,
)

PUBLISHED_STABLE: Mapping[str, float] = {"S1": 0.790, "S2a": 0.760, "S2b": 0.708}
"""Share of stable layouts in the paper's sub-dataset 2, before balancing."""

_THRESHOLD_T, _THRESHOLD_R = 9.9995, 9.9995
"""Thresholds of 10 cm and 10 degrees for stored movements, which are rounded to thousandths."""

_BINS = 10


@row
class ClassCount:
    """One item class."""

    item_class: int = column("class", left=True)
    instances: int = column("item lists")
    layouts: int = column(about="distinct geometries")
    items: Estimate = column("items a layout", lambda items: fixed(items.value, 1))
    stable: Estimate = column("stable cases %", percent)


@row
class SplitCount:
    """One split in one scenario; ``split`` is None for labelled cases of no split."""

    split: str | None = column(form=lambda split: split or "in none", left=True)
    scenario: str = column()
    instances: int = column("item lists")
    cases: int = column()
    stable: int = column()

    @property
    def unstable(self) -> int:
        """Cases that fail."""
        return self.cases - self.stable


@row
class NaturalStable:
    """Share of layouts that can be loaded, before anything is balanced, in one scenario."""

    scenario: str = column()
    stable: Estimate = column("stable %", percent)
    packings: Estimate = column(
        "stable % of packings", percent, "a geometry counts as often as a heuristic gave it"
    )
    published: float | None = column("paper's %", plain_percent, "None where it has none")
    criterion_paper: Estimate | None = column("stable % by the other criterion", percent)
    other_label: Estimate | None = column(
        "other failing step %", percent, "share of cases, between the two criteria"
    )


@row
class SizeCount:
    """Layouts with a number of items."""

    items: int = column()
    layouts: int = column()


@row
class ScoreBin:
    """Cases whose failing step is at a share of the items; stable ones have their own bin."""

    title: str = column()
    shares: Mapping[str, float] = column("{}", about="of all cases, by scenario")


@row
class FailureReason:
    """Reasons for which loadings fail: shares of the unstable cases of a scenario."""

    reason: str = column("at the failing step")
    shares: Mapping[str, Estimate] = column("{} %", percent)


@row
class Firmness:
    """Confidence of the labels of a split in one scenario."""

    split: str = column()
    scenario: str = column()
    robust: Estimate = column("robust %", percent, "share of robust labels")
    confidence: Estimate = column("confidence %", percent, "the mean")
    parts: Mapping[str, Estimate] = column("{} %", percent, "mean agreement by reason of doubt")


class Found(SimpleNamespace):
    """All that the page shows."""

    classes: Sequence[ClassCount]
    splits: Sequence[SplitCount]
    natural: Sequence[NaturalStable]
    item_counts: Sequence[SizeCount]
    scores: Sequence[ScoreBin]
    both_labels: Sequence[QuestionShares]
    reasons: Sequence[FailureReason]
    firmness: Sequence[Firmness]
    judges: Sequence[MethodAgreement]
    disputes: Sequence[RobustDispute]
    made_with: Mapping[str, str]


def summarise(benchmark: Benchmark) -> Found:
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
    said = verdicts_on_test(benchmark)
    judges = agreements(said, scenarios)
    return Found(
        layouts=len(benchmark.layouts),
        cases=len(cases),
        instances=benchmark.layouts["instance"].nunique(),
        without_label=len(cases) - len(done),
        scenarios=scenarios,
        heights={f"shares.{scenario}": scenario for scenario in scenarios},
        classes=_classes(benchmark, done, counts),
        splits=_splits(done, scenarios),
        natural=[_natural(done[done["scenario"] == s], s) for s in scenarios],
        item_counts=[SizeCount(int(items), int(count)) for items, count in sizes.items()],
        scores=_scores({s: done[done["scenario"] == s] for s in scenarios}),
        both_labels=question_shares(benchmark),
        reasons=_reasons(done, scenarios),
        firmness=_firmness(benchmark, done, scenarios),
        judges=judges,
        engines_asked=any(
            judge.robust is not None and judge.robust.n > 0
            for judge in judges
            if judge.reason == str(Reason.ENGINE)
        ),
        disputes=disputes(benchmark, said),
        notes=benchmark.notes,
        made_with=made_with(benchmark),
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


def _scores(done: Mapping[str, pd.DataFrame]) -> list[ScoreBin]:
    """Cases of each scenario by loading stability: ten bins below 1, and the stable ones."""
    counts = {}
    for scenario, own in done.items():
        failed = own.dropna(subset=["failing_step"])
        failed = failed.astype({"failing_step": int, "item_count": int})
        tenth = _BINS * failed["failing_step"] // failed["item_count"]  # whole numbers: 0.3 is 0.3
        counts[scenario] = [*np.bincount(tenth, minlength=_BINS), len(own) - len(failed)]
    titles = [*(f"{k / _BINS:.1f}-{(k + 1) / _BINS:.1f}" for k in range(_BINS)), STABLE]
    return [
        ScoreBin(title, {s: float(found[k] / max(1, sum(found))) for s, found in counts.items()})
        for k, title in enumerate(titles)
    ]


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
    known = done.merge(benchmark.confidence_on(Question.WITHIN).reset_index(), on=KEYS, how="inner")
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

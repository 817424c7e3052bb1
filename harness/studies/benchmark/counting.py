"""Counts of a labelled set, and how sure its labels are; intervals resample item lists."""

from __future__ import annotations

from collections.abc import Mapping
from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd

from steadyload.labelling.both_labels import question_shares
from steadyload.layouts.benchmark.confidence import ENSEMBLE, Reason
from steadyload.layouts.benchmark.dataset import KEYS, Benchmark
from steadyload.layouts.benchmark.parts import HELD_OUT, SPLITS
from steadyload.layouts.benchmark.tables import BenchmarkError
from steadyload.layouts.model.question import Question
from steadyload.layouts.model.scenarios import Scenario
from steadyload.runs import frames as v
from steadyload.runs.labels import made_with
from steadyload.studies.benchmark.disputed import STABLE, agreements, disputes, verdicts_on_test

PUBLISHED_STABLE: Mapping[str, float] = {"S1": 0.790, "S2a": 0.760, "S2b": 0.708}
"""Share of stable layouts in the paper's sub-dataset 2, before balancing."""

_THRESHOLD_T, _THRESHOLD_R = 9.9995, 9.9995
"""Thresholds of 10 cm and 10 degrees for stored movements, which are rounded to thousandths."""

_BINS = 10

_NO_SPLIT = "in none"
"""Of labelled cases of no split."""


class Found(SimpleNamespace):
    """All that the page shows."""

    made_with: Mapping[str, str]


def summarise(benchmark: Benchmark) -> Found:
    """Counts, shares and agreements of a labelled set; every interval resamples item lists.

    Raises:
        BenchmarkError: nothing is labelled.
    """
    cases, layouts = benchmark.cases, benchmark.layouts
    done = cases[cases["status"] == "done"]
    if done.empty:
        raise BenchmarkError("nothing in this set is labelled yet")
    order = [*SPLITS, _NO_SPLIT, *map(str, Scenario)]
    place = {name: number for number, name in enumerate(order)}
    of_layout = layouts.assign(packings=layouts["sources"].map(len))
    of_layout = of_layout[["packings", "item_class"]].reindex(done["layout"])
    done = done.assign(
        cluster=done["instance"],
        split=done["split"].astype(object).fillna(_NO_SPLIT),
        stable=done["failing_step"].isna(),
        **{name: of_layout[name].to_numpy() for name in of_layout},
    ).sort_values(["split", "scenario"], key=lambda own: own.map(place), kind="stable")
    scenarios = [str(s) for s in Scenario if (done["scenario"] == str(s)).any()]
    counts = layouts["sizes"].map(len) // 3
    said = verdicts_on_test(benchmark)
    judges, firmness = agreements(said), _firmness(benchmark, done)
    return Found(
        layouts=len(layouts),
        cases=len(cases),
        instances=layouts["instance"].nunique(),
        without_label=len(cases) - len(done),
        heights={f"shares.{scenario}": scenario for scenario in scenarios},
        classes=_classes(layouts.assign(items=counts), done),
        splits=_splits(done),
        natural=_natural(done),
        item_counts=[
            {"items": int(items), "layouts": int(count)}
            for items, count in counts.value_counts().sort_index().items()
        ],
        scores=_scores({s: done[done["scenario"] == s] for s in scenarios}),
        both_labels=question_shares(benchmark),
        reasons=_reasons(done),
        firmness=firmness,
        firm=list(firmness.loc[firmness["split"] == "test", "robust"]),
        judges=judges,
        engines_asked=bool(
            judges.loc[judges["reason"] == str(Reason.ENGINE), "right_robust"].notna().any()
        ),
        disputes=disputes(benchmark, said),
        notes=benchmark.notes,
        made_with=made_with(benchmark),
    )


def _classes(layouts: pd.DataFrame, done: pd.DataFrame) -> pd.DataFrame:
    rows = layouts.groupby("item_class")
    found = {
        "lists": rows["instance"].nunique(),
        "layouts": rows.size(),
        "mean_items": rows["items"].mean(),
        "stable": v.share(done, "stable", ["item_class"]),
    }
    return pd.DataFrame(found, rows.size().index).reset_index()


def _splits(done: pd.DataFrame) -> pd.DataFrame:
    rows = done.groupby(["split", "scenario"], sort=False)
    stable = rows["stable"].sum()
    found = {
        "lists": rows["instance"].nunique(),
        "cases": rows.size(),
        "stable_cases": stable,
        "unstable_cases": rows.size() - stable,
    }
    return pd.DataFrame(found).reset_index()


def _natural(done: pd.DataFrame) -> pd.DataFrame:
    """Shares of stable layouts by scenario, before anything is balanced."""
    by, paper = ["scenario"], done["failing_step_paper"]
    done = done.sort_values("scenario", kind="stable").assign(
        by_paper=paper.isna(), other_label=done["failing_step"].fillna(-1) != paper.fillna(-1)
    )
    known = done[done.groupby("scenario")["failing_step_paper"].transform("count") > 0]
    packed = done.loc[done.index.repeat(done["packings"])]
    found = pd.DataFrame(
        {
            "stable": v.share(done, "stable", by),
            "of_packings": v.share(packed, "stable", by),
            "by_paper": v.share(known, "by_paper", by),
            "other_label": v.share(known, "other_label", by),
        },
        pd.Index(done["scenario"].unique(), name="scenario"),
    )
    return found.assign(published=found.index.map(PUBLISHED_STABLE)).reset_index()


def _scores(done: Mapping[str, pd.DataFrame]) -> list[dict[str, Any]]:
    """Cases of each scenario by loading stability: ten bins below 1, and the stable ones."""
    counts = {}
    for scenario, own in done.items():
        failed = own.dropna(subset=["failing_step"])
        failed = failed.astype({"failing_step": int, "item_count": int})
        tenth = _BINS * failed["failing_step"] // failed["item_count"]  # whole numbers: 0.3 is 0.3
        counts[scenario] = [*np.bincount(tenth, minlength=_BINS), len(own) - len(failed)]
    titles = [*(f"{k / _BINS:.1f}-{(k + 1) / _BINS:.1f}" for k in range(_BINS)), STABLE]
    return [
        {"title": title, "shares": {s: float(n[k] / max(1, sum(n))) for s, n in counts.items()}}
        for k, title in enumerate(titles)
    ]


def _reasons(done: pd.DataFrame) -> pd.DataFrame:
    """Events at the failing step, as shares of the unstable cases."""
    known = done["corner_last"].notna() & done["margin"].notna()
    failed = done[~done["stable"] & known]
    events = pd.DataFrame([_at_failure(row) for row in failed.itertuples()], failed.index)
    rows = failed[["scenario", "cluster"]].join(events)
    found = pd.DataFrame({title: v.share(rows, title, ["scenario"]) for title in events}).T
    return found.rename(columns="scenario_right:{}".format).rename_axis("event").reset_index()


def _at_failure(row: Any) -> dict[str, bool]:
    step = int(row.failing_step)
    shift, turn = row.corner_last[step] > _THRESHOLD_T, row.angle_last[step] > _THRESHOLD_R
    return {
        "beyond 10 cm only": bool(shift and not turn),
        "beyond 10 degrees only": bool(turn and not shift),
        "beyond both": bool(shift and turn),
        "the item just placed moves furthest": int(row.moved[step]) == step,
        "no equilibrium (margin below 0)": bool(row.margin[step] < 0.0),
        "at the last item of the layout": step == int(row.item_count) - 1,
    }


def _firmness(benchmark: Benchmark, done: pd.DataFrame) -> pd.DataFrame:
    """Confidence of the labels by split and scenario."""
    known = done.merge(benchmark.confidence_on(Question.WITHIN).reset_index(), on=KEYS, how="inner")
    known = known[known["robust"].notna() & known["split"].isin(list(HELD_OUT))]
    known, by = known.assign(robust=known["robust"].astype(bool)), ["split", "scenario"]
    found = {
        "robust": v.share(known, "robust", by),
        "confidence": v.mean(known, "confidence", by),
        **{f"part:{reason}": v.mean(known, str(reason), by) for reason in ENSEMBLE},
    }
    return pd.DataFrame(found, known.groupby(by, sort=False).size().index).reset_index()

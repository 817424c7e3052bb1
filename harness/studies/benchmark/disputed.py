"""Agreement of further methods with the labels of the test split, and the labels in dispute."""

from __future__ import annotations

import math

import pandas as pd

from steadyload.layouts.benchmark.confidence import ENSEMBLE, Reason, agrees
from steadyload.layouts.benchmark.dataset import KEYS, Benchmark
from steadyload.layouts.model.question import Question
from steadyload.reports import frames
from steadyload.reports.columns import fixed
from steadyload.runs import frames as v
from steadyload.statistics.placed import items_placed_by_case

STABLE = "stable"


def _movement(value: float, digits: int) -> str:
    return "none" if math.isinf(value) else fixed(value, digits)


def verdicts_on_test(benchmark: Benchmark) -> pd.DataFrame:
    """Further methods' verdicts on the test split, with label, instance, robustness, agreement."""
    test = benchmark.cases[benchmark.cases["split"] == "test"]
    columns = [*KEYS, "instance", "item_count", "failing_step"]
    said = benchmark.further_verdicts_on(Question.WITHIN).merge(
        test[columns].rename(columns={"failing_step": "label"}), on=KEYS, how="inner"
    )
    robust = benchmark.confidence_on(Question.WITHIN)["robust"].rename("robust").reset_index()
    said = said.merge(robust, on=KEYS, how="left")
    return said.assign(agrees=agrees(benchmark.labels_on(Question.WITHIN), said).to_numpy())


def agreements(said: pd.DataFrame) -> pd.DataFrame:
    """Agreement of every further method, from the rows of :func:`verdicts_on_test`."""
    place = {str(reason): number for number, reason in enumerate(Reason)}
    said = said.sort_values("reason", key=lambda own: own.map(place), kind="stable")
    answered = said["status"] == "done"
    label = items_placed_by_case(said["label"], said["item_count"])
    step = items_placed_by_case(said["failing_step"], said["item_count"])
    said = said.assign(
        cluster=said["instance"],
        earlier=answered & (step < label),
        later=answered & (step > label),
        unknown=~answered,
    )
    by = ["judge", "reason"]
    rows = said.groupby(by, sort=False, observed=True)
    firm = said["robust"].fillna(False).astype(bool) & ~said["reason"].isin(map(str, ENSEMBLE))
    each = v.share(said.sort_values("scenario", kind="stable"), "agrees", [*by, "scenario"])
    found = pd.DataFrame(
        {
            "pooled": v.share(said, "agrees", by),
            "right_robust": v.share(said[firm], "agrees", by),
            "earlier": rows["earlier"].sum(),
            "later": rows["later"].sum(),
            "unknown": rows["unknown"].sum(),
        },
        rows.size().index,
    )
    found = found.join(frames.across(each, "scenario", "scenario_right")).reset_index()
    return found.assign(title=found["judge"] + " (" + found["reason"] + ")")


def disputes(benchmark: Benchmark, said: pd.DataFrame) -> pd.DataFrame:
    """Robust labels of the test split that some engine disagrees with.

    How far the reference moved at the step at which the two part, and the margin of equilibrium
    there, are missing where the reference did not record the step.
    """
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
        moved = {
            "corner": ("corner_last", 1),
            "angle": ("angle_last", 1),
            "apart_by": ("margin", 2),
        }
        rows.append(
            {
                "layout": name,
                "scenario": scenario,
                "items": count,
                "step": _said(case["failing_step"], "done"),
                "apart_at": first,
                **{
                    f"said_of:{v.judge}": _said(v.failing_step, v.status)
                    for v in every.itertuples()
                },
                **{
                    title: _movement(case[column][first], digits) if seen else None
                    for title, (column, digits) in moved.items()
                },
            }
        )
    return pd.DataFrame(rows)


def _said(step: object, status: str) -> str:
    if status != "done":
        return status
    return STABLE if pd.isna(step) else str(int(step))  # type: ignore[call-overload]

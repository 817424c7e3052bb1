"""Agreement of further methods with the labels of the test split, and the labels in dispute."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import partial

import pandas as pd

from steadyload.layouts.benchmark.confidence import ENSEMBLE, Reason, agrees
from steadyload.layouts.benchmark.dataset import KEYS, Benchmark
from steadyload.layouts.model.question import Question
from steadyload.reports.columns import column, fixed, percent, row
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.metrics import share
from steadyload.statistics.placed import items_placed_by_case

STABLE = "stable"


@row
class MethodAgreement:
    """Agreement of one further method with the labels of the test split."""

    judge: str = column()
    reason: str = column()
    by_scenario: Mapping[str, Estimate] = column("{} %", percent)
    pooled: Estimate = column("all %", percent)
    robust: Estimate | None = column(
        "robust labels %", percent, "of these alone; None for the ensemble that defines them"
    )
    earlier: int = column()
    later: int = column()
    without_verdict: int = column("no verdict")

    @property
    def title(self) -> str:
        """The judge, and the reason of doubt that it stands for."""
        return f"{self.judge} ({self.reason})"


def _movement(value: float | None, digits: int = 1) -> str:
    return "none" if value is not None and math.isinf(value) else fixed(value, digits)


@row
class RobustDispute:
    """A robust label that an engine disagrees with.

    How far the reference moved at the step at which the two part, and the margin of equilibrium
    there; None where the reference did not record the step.
    """

    layout: str = column()
    scenario: str = column()
    item_count: int = column("items")
    label: str = column(left=False)
    said: Mapping[str, str] = column("{}", about="failing step by each engine")
    step: int = column()
    corner_cm: float | None = column("corner cm", _movement)
    angle_deg: float | None = column("angle deg", _movement)
    margin_cm: float | None = column("margin cm", partial(_movement, digits=2))


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


def agreements(said: pd.DataFrame, scenarios: list[str]) -> list[MethodAgreement]:
    """Agreement of every further method, from the rows of :func:`verdicts_on_test`."""
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


def disputes(benchmark: Benchmark, said: pd.DataFrame) -> list[RobustDispute]:
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
                corner_cm=float(case["corner_last"][first]) if seen else None,
                angle_deg=float(case["angle_last"][first]) if seen else None,
                margin_cm=float(case["margin"][first]) if seen else None,
            )
        )
    return rows


def _said(step: object, status: str) -> str:
    if status != "done":
        return status
    return STABLE if pd.isna(step) else str(int(step))  # type: ignore[call-overload]

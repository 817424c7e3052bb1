"""Overview of a labelled set: counts of its layouts, cases and labels."""

from __future__ import annotations

from typing import Any

import pandas as pd

from steadyload.layouts.benchmark.confidence import agrees
from steadyload.layouts.benchmark.dataset import Benchmark
from steadyload.layouts.benchmark.parts import SPLITS
from steadyload.layouts.model.question import Question
from steadyload.layouts.model.scenarios import Scenario

_NO_SPLIT = "none"
_SPLITS = (*SPLITS, _NO_SPLIT)


def overview(benchmark: Benchmark) -> dict[str, Any]:
    """Counts and shares of a labelled set, as plain values for JSON.

    Returns:
        ``origin``, ``layouts``, ``instances``, ``cases``; ``splits``: a row a split (``none``: in
        no split) and scenario, with ``cases``, ``stable``, ``unstable``, ``layouts``,
        ``instances`` and ``items_mean`` of its labelled cases;
        ``natural_stable``: share of stable cases by scenario over all labelled ones;
        ``labels``: a row a question, with cases by ``status`` of their label; ``cases`` that were
        judged again, how many of their labels are ``robust`` and ``fragile`` (somebody of the
        ensemble disagrees), and the ``mean`` confidence, null where there are none;
        ``judges``: a row a question and further method, with its ``reason``, number of ``cases``
        and ``agreement``, the share of these with the label's failing step.
    """
    cases = benchmark.cases
    labelled = cases[cases["status"] == "done"]
    split = labelled["split"].fillna(_NO_SPLIT)
    parts = [
        (str(name), str(scenario), labelled[(split == name) & (labelled["scenario"] == scenario)])
        for name in _SPLITS
        for scenario in Scenario
    ]
    return {
        "origin": benchmark.manifest.get("origin"),
        "layouts": len(benchmark.layouts),
        "instances": int(benchmark.layouts["instance"].nunique()),
        "cases": len(cases),
        "splits": [_counts(name, which, part) for name, which, part in parts if len(part)],
        "natural_stable": benchmark.natural_stable,
        "labels": [_labels(benchmark, question) for question in Question],
        "judges": _further_methods(benchmark),
    }


def _counts(split: str, scenario: str, part: pd.DataFrame) -> dict[str, Any]:
    stable = int(part["failing_step"].isna().sum())
    return {
        "split": split,
        "scenario": scenario,
        "cases": len(part),
        "stable": stable,
        "unstable": len(part) - stable,
        "layouts": int(part["layout"].nunique()),
        "instances": int(part["instance"].nunique()),
        "items_mean": float(part["item_count"].astype(float).mean()),
    }


def _labels(benchmark: Benchmark, question: Question) -> dict[str, Any]:
    statuses = benchmark.labels_on(question)["status"].value_counts()
    sure = benchmark.confidence_on(question)
    sure = sure[sure["robust"].notna()]
    robust = int(sure["robust"].sum())
    return {
        "question": str(question),
        "status": {str(status): int(count) for status, count in statuses.items()},
        "cases": len(sure),
        "robust": robust,
        "fragile": len(sure) - robust,
        "mean": float(sure["confidence"].mean()) if len(sure) else None,
    }


def _further_methods(benchmark: Benchmark) -> list[dict[str, Any]]:
    rows = []
    for question in Question:
        opinions = benchmark.further_verdicts_on(question)
        same = opinions.assign(same=agrees(benchmark.labels_on(question), opinions))
        rows += [
            {
                "question": str(question), "judge": judge, "reason": reason, "cases": len(said),
                "agreement": float(said.mean()),
            }
            for (reason, judge), said in same.groupby(["reason", "judge"], sort=False)["same"]
        ]  # fmt: skip
    return rows

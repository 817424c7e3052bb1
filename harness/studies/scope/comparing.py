"""Options compared with the simulation of the whole pile, case by case: verdicts, accuracy, cost.

Shares are 0 to 1; times are in ms, or in proportion to those of the whole pile.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from types import SimpleNamespace

import numpy as np
import pandas as pd

from steadyload.layouts.benchmark import Benchmark, load_benchmark
from steadyload.layouts.benchmark.parts import REAL, Part
from steadyload.layouts.model.question import Question
from steadyload.methods.contract.method import Status
from steadyload.methods.naming import MethodKey
from steadyload.reports import frames
from steadyload.runs import frames as v
from steadyload.runs.costs import CostKind
from steadyload.runs.evaluation import Evaluation
from steadyload.runs.judged import JudgedCases
from steadyload.runs.labels import Cases
from steadyload.runs.provenance import provenance_lines
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.metrics import median
from steadyload.studies.kit import Lab
from steadyload.studies.scope.balanced_steps import BalancedSteps, balanced_steps

MOST_ITEMS = 45
"""Boxes that a case may have."""

CASES = 300
"""Cases of each question, drawn evenly over sources."""

SECONDS = 30.0
"""CPU time that a verdict may take."""

OPTIONS: Mapping[Question, tuple[str, ...]] = {
    Question.WITHIN: (
        "label@mujoco",
        "label@mujoco:scope=local",
        "label@mujoco:scope=widening,rest_speed=0.01",
        "label@mujoco:scope=moving",
        "label@mujoco:shrink=0.1mm",
        "label@mujoco:rest_speed=0.01",
        "label@mujoco:scope=moving,rest_speed=0.01",
        "label@mujoco:samples=3",
        "label@mujoco:solver_iterations=5",
        "label@mujoco:solver_iterations=20",
        "label@mujoco:solver_iterations=75",
        "label@bullet:scope=moving",
    ),
    Question.STANDS: (
        "label@mujoco:question=stands",
        "label@mujoco:question=stands,scope=widening,rest_speed=0.01",
        "label@mujoco:question=stands,scope=moving",
        "label@mujoco:question=stands,rest_speed=0.01",
        "label@mujoco:question=stands,scope=moving,rest_speed=0.01",
    ),
}
"""By question, the simulation of the whole pile, and the options that are compared with it."""

KEPT = 0.99
"""Share of the verdicts of the whole pile that nearly all are."""

_ENDED = (str(Status.DONE), str(Status.UNSETTLED))
"""Statuses of a verdict of the whole pile that others can be compared with."""

_PARTS = (str(Part.TRAIN), str(Part.VALIDATION))
_SHARD = 10
_SIZES = 3
"""Groups of cases by their number of boxes."""


class Found(SimpleNamespace):
    """All that the page shows."""

    steps: BalancedSteps
    made_with: Mapping[str, str]


def compare_options(lab: Lab, limit: int | None = None) -> Found:
    """Judge cases by all options, as far as that is missing, and compare them."""
    labelled = load_benchmark(REAL)
    cases = min(CASES, limit or CASES)
    chosen = drawn_cases(labelled, cases)
    # Ranks of the cases drawn count within scenarios, and scenarios take turns.
    standing = -(-cases // chosen["scenario"].nunique())
    found = {
        question: lab.judge(
            specs,
            Cases(labelled.drawn(chosen), limit=standing if question == Question.STANDS else None),
            timeout=SECONDS,
            folder=str(question),
            name=f"scope-{question}",
            shard_size=_SHARD,
            costs=CostKind.ONE_PROCESS,
        )
        for question, specs in OPTIONS.items()
    }
    return Found(
        tables=[options_of(own, question) for question, own in found.items()],
        steps=balanced_steps(labelled),
        sources=dict(sorted(Counter(chosen["source"]).items())),
        boxes=(int(chosen["item_count"].min()), int(chosen["item_count"].max())),
        label=str(labelled.manifest["label"]),
        screen=str(labelled.manifest["screen"]),
        costs=next(iter(found.values())).cost_source.explained(),
        kept=KEPT,
        most_items=MOST_ITEMS,
        seconds=SECONDS,
        made_with=_made_with({question: own.judged for question, own in found.items()}),
    )


def _made_with(runs: Mapping[Question, JudgedCases]) -> dict[str, str]:
    """Provenance of the runs: that of the first, with what differs between questions."""
    lines: dict[str, str] = {}
    for question, judged in runs.items():
        manifest = judged.manifest
        lines |= {
            f"labels, {question}": manifest["labels"]["hash"],
            f"rows, {question}": str(judged.rows),
            f"started, {question}": manifest["started"],
            f"finished, {question}": manifest["finished"] or "not yet",
        }
    return lines | provenance_lines(next(iter(runs.values())).manifest)


def drawn_cases(benchmark: Benchmark, count: int) -> pd.DataFrame:
    """Labelled cases of train and validation, drawn in turns over sources and scenarios by rank.
    ``source``: the first of those that gave the layout.
    """
    cases = benchmark.cases
    allowed = cases["split"].isin(_PARTS) & (cases["item_count"] <= MOST_ITEMS)
    cases = cases[allowed & (cases["status"] == "done")]
    first = benchmark.layouts["sources"].map(lambda names: str(names[0]))
    cases = cases.assign(source=first.loc[cases["layout"]].to_numpy())
    cases = cases.sort_values(["rank", "split", "layout"], kind="stable")
    turn = cases.groupby(["source", "scenario"]).cumcount()
    order = cases.assign(turn=turn).sort_values(["turn", "source", "scenario"], kind="stable")
    return order.head(count).drop(columns="turn").reset_index(drop=True)


def options_of(found: Evaluation, question: Question) -> SimpleNamespace:
    """The options that were judged for a question; the first method simulates the whole pile.

    ``rows`` has one for each method: ``alike``, share of the cases with the status and failing step
    of the whole pile, where that has a verdict or is unsettled; ``changes``, cases that fail
    earlier, later, and without a verdict; times and work in proportion to those of the whole pile.
    """
    judged, frame = found.judged, v.costed(found.judged)
    assert judged.labels is not None, "the run is on a labelled set"
    whole, *others = judged.keys
    frame = frame.assign(safe=frame["said"].fillna(-1).astype(int))
    its = {name: v.beside(frame, name, whole) for name in ("status", "safe", "cpu")}
    both = (frame["status"] == Status.DONE) & (its["status"] == Status.DONE)
    same = (frame["status"] == its["status"]) & (frame["safe"] == its["safe"])
    place, titles = size_groups(frame["items"])
    frame = frame.assign(
        alike=same.where(its["status"].isin(_ENDED)),
        earlier=both & (frame["safe"] < its["safe"]),
        later=both & (frame["safe"] > its["safe"]),
        cpu_whole=its["cpu"],
        paired=frame["cpu"] / its["cpu"],
        boxes=place,
    )
    methods = frame.groupby("method", sort=False)
    count = methods[["earlier", "later", "body_substeps"]].sum()
    count["none"] = (frame["status"] != Status.DONE).groupby(frame["method"]).sum()
    medians = methods["cpu"].median()
    column = "right_stands" if question == Question.STANDS else "right"
    tests = v.pairs(frame, column, [(spec, whole) for spec in others]).droplevel("second")
    itself = pd.Series([Estimate(0.0, 0.0, 0.0, len(judged.labels))], [whole], dtype=object)
    by_boxes = frame.sort_values("boxes", kind="stable")
    by_boxes["boxes"] = by_boxes["boxes"].map(titles)
    of_boxes = by_boxes.groupby(["method", "boxes"], sort=False)["cpu"].median()
    rows = pd.DataFrame(
        {
            "key": pd.Series(judged.keys, dtype=object),
            "title": [option_title(key, judged.keys[whole]) for key in judged.keys.values()],
            "cases": methods["alike"].count(),
            "alike": v.share(frame, "alike", ["method"]),
            "changes": [f"{own.earlier} / {own.later} / {own.none}" for own in count.itertuples()],
            "without_verdict": v.statuses(frame, ["method"]),
            "right": v.share(frame, "right", ["method"]),
            "right_stands": v.share(frame, "right_stands", ["method"]),
            "difference": pd.concat([itself, tests["difference"]]),
            "p": tests["corrected"],
            "cpu_median": medians / medians[whole],
            "cost_ratio": v.ratio(frame, "cpu", "cpu_whole", ["method"]),
            "cpu_paired": v.estimates(frame, ["method"], lambda own: median(own["paired"])),
            "body_ratio": count["body_substeps"] / count["body_substeps"][whole],
        },
        index=list(judged.keys),
    )
    rows = rows.join(
        [
            frames.across(v.share(by_boxes, "alike", ["method", "boxes"]), "boxes", "alike_boxes"),
            frames.across(of_boxes / of_boxes[whole], "boxes", "cpu_boxes"),
        ]
    )
    options = rows.loc[others].assign(
        changed=lambda own: own["alike"].map(
            lambda e: Estimate(1.0 - e.value, 1.0 - e.high, 1.0 - e.low, e.n)
        )
    )
    shares = v.values(options["alike"])
    kept = options[shares > KEPT - 1e-9]
    named = v.values(kept["cost_ratio"]).idxmin() if len(kept) else shares.idxmax()
    rows.loc[whole, "alike"] = None
    return SimpleNamespace(
        question=question,
        cases=len(judged.labels),
        layouts=judged.labels.index.get_level_values("layout").nunique(),
        instances=judged.labels["instance"].nunique(),
        milliseconds=medians[whole],
        column=column,
        rows=rows,
        options=options,
        points=options.to_dict("records"),
        named=options.loc[named],
    )


def size_groups(counts: pd.Series) -> tuple[pd.Series, dict[int, str]]:
    """The group of every case, of up to three of about as many cases by their number of boxes, from
    small to large, and titles of the groups.
    """
    ordered = sorted(counts)
    ends = [ordered[-(-len(ordered) * k // _SIZES) - 1] for k in range(1, _SIZES + 1)]
    place = pd.Series(np.searchsorted(sorted(set(ends)), counts), counts.index)
    spans = counts.groupby(place).agg(["min", "max"]).itertuples()
    return place, {
        at: f"{least} to {most}" if least < most else str(least) for at, least, most in spans
    }


def option_title(method: MethodKey, whole: MethodKey) -> str:
    """Parameters that an option changes, and the engine where that is another one."""
    if method.spec == whole.spec:
        return "whole pile"
    values = [v for v in method.spec.partition(":")[2].split(",") if v]
    changed = ", ".join(f"`{v}`" for v in values if not v.startswith("question="))
    engine = "" if method.engine == whole.engine else f"on {method.engine}"
    return " ".join(filter(None, (changed or "whole pile", engine)))

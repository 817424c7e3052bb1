"""Options compared with the simulation of the whole pile, case by case: verdicts, accuracy, cost.

Shares are 0 to 1; times are in ms, or in proportion to those of the whole pile.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
import pandas as pd

from steadyload.layouts.benchmark import Benchmark, load_benchmark
from steadyload.layouts.benchmark.parts import REAL, Part
from steadyload.layouts.model.question import Question
from steadyload.methods.contract.method import Status
from steadyload.methods.naming import MethodKey
from steadyload.reports.columns import column, compact, counts, factor, p_value, percent, row
from steadyload.runs.comparison import Compared, compared, difference
from steadyload.runs.costs import CPU, CostKind
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


class Changes(NamedTuple):
    """Cases in which an option fails earlier or later than the whole pile, or has no verdict; a
    stable layout fails later than all.
    """

    earlier: int
    later: int
    none: int

    def __str__(self) -> str:
        return " / ".join(map(str, self))


@row
class Option:
    """An option and the simulation of the whole pile, on the same cases."""

    method: MethodKey
    title: str = column("simulated", about="what it changes")
    n: int = column(about="cases in which the whole pile has a verdict or is unsettled")
    same: Estimate | None = column(
        "same %", percent, "of these, share with its status and failing step; None for itself"
    )
    changes: Changes = column("earlier / later / none")
    without_verdict: Mapping[str, int] = column("no verdict", counts, left=True)
    accuracy: Estimate = column("accuracy %", percent, "by the labels of the question")
    within: Estimate = column("accuracy, within %", percent)
    stands: Estimate = column("accuracy, stands %", percent)
    difference: Estimate = column(form=percent, about="accuracy minus that of the whole pile")
    p: float | None = column(
        form=p_value, about="corrected over the options; None for the whole pile"
    )
    milliseconds: float = column(about="median CPU time of a case")
    cpu: float = column("CPU, median", compact, "that median over that of the whole pile")
    cpu_total: Estimate = column("CPU, all", factor, "of all cases, in proportion")
    cpu_paired: Estimate = column("CPU, paired", factor, "median of proportions over the cases")
    body_substeps: float = column("body-substeps", compact, "substeps times boxes, in proportion")
    same_by_boxes: Mapping[str, Estimate] = column("{} boxes: same %", percent)
    cpu_by_boxes: Mapping[str, float] = column("{}: CPU", compact)

    @property
    def changed(self) -> Estimate:
        """Share of cases with another status or failing step than the whole pile."""
        assert self.same is not None, "an option, not the whole pile"
        same = self.same
        return Estimate(1.0 - same.value, 1.0 - same.high, 1.0 - same.low, same.n)


@row
class Options:
    """The options of one question, in the order of the study, and the whole pile beside them."""

    question: Question
    cases: int
    layouts: int
    instances: int
    whole: Option
    options: Sequence[Option]

    @property
    def rows(self) -> list[Option]:
        """The whole pile, then the options."""
        return [self.whole, *self.options]

    @property
    def cheapest(self) -> Option | None:
        """The option of least CPU time of all cases that keeps :data:`KEPT` of the verdicts."""
        kept = [own for own in self.options if own.same and own.same.value > KEPT - 1e-9]
        return min(kept, key=lambda own: own.cpu_total.value, default=None)

    @property
    def keeps_most(self) -> Option:
        """The option that keeps most verdicts of the whole pile."""
        return max(self.options, key=lambda own: own.same.value if own.same else 0.0)


@row
class Found:
    """Everything that the page shows.

    ``sources``: number of cases drawn, by their source. ``boxes``: least and greatest number of
    boxes of a case. ``label``, ``screen``: specs of the methods that gave the labels. ``costs``:
    the sentence on the source of times.
    """

    tables: Mapping[Question, Options]
    steps: BalancedSteps
    sources: Mapping[str, int]
    boxes: tuple[int, int]
    label: str
    screen: str
    costs: str
    made_with: Mapping[str, str]
    kept: float = KEPT
    most_items: int = MOST_ITEMS
    seconds: float = SECONDS


def compare_options(lab: Lab, limit: int | None = None) -> Found:
    """Judge cases by all options, as far as that is missing, and compare them.

    Raises:
        ResultsError: the folder holds something else.
    """
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
        tables={question: options_of(own, question) for question, own in found.items()},
        steps=balanced_steps(labelled),
        sources=dict(sorted(Counter(chosen["source"]).items())),
        boxes=(int(chosen["item_count"].min()), int(chosen["item_count"].max())),
        label=str(labelled.manifest["label"]),
        screen=str(labelled.manifest["screen"]),
        costs=next(iter(found.values())).cost_source.explained(),
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

    Args:
        benchmark: the labelled set.
        count: of cases; fewer where there are not so many.

    Returns:
        Rows of the table of cases in the order drawn, with the column ``source``: the first of
        those that gave the layout.
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


def options_of(found: Evaluation, question: Question) -> Options:
    """The options that were judged for a question; the first method simulates the whole pile."""
    judged, labels = found.judged, found.judged.labels
    assert labels is not None, "the run is on a labelled set"
    whole, *others = judged.keys
    truth = compared(judged.asked(question))
    tests = {test.first.spec: test for test in truth.versus(judged.keys[whole]).tests}
    verdicts = {spec: _verdicts(judged, spec) for spec in judged.keys}
    of_whole = verdicts[whole]
    ended = of_whole["status"].isin(_ENDED)
    same = Compared(
        {
            spec: (own[["status", "safe"]] == of_whole[["status", "safe"]]).all(axis=1).where(ended)
            for spec, own in verdicts.items()
        },
        judged.clusters,
    )
    (overall,) = same.slices(np.zeros(len(ended)))
    boxes = size_groups(of_whole["item_count"].tolist())
    titles = [f"{least} to {most}" if least < most else str(least) for least, most in boxes]
    places = np.searchsorted([most for _, most in boxes], of_whole["item_count"])
    by_boxes = same.slices(places)

    def option(spec: str) -> Option:
        key, own, row = judged.keys[spec], verdicts[spec], found.row(spec)
        right, reference = truth.right[key], truth.right[judged.keys[whole]]
        both = (own["status"] == "done") & (of_whole["status"] == "done")
        times, times_whole = own["milliseconds"], of_whole["milliseconds"]
        medians = times.groupby(places).median() / times_whole.groupby(places).median()
        work, work_whole = own["body_substeps"].sum(), of_whole["body_substeps"].sum()
        return Option(
            method=key,
            title=option_title(key, judged.keys[whole]),
            n=overall.accuracy[spec].n,
            same=None if spec == whole else overall.accuracy[spec],
            changes=Changes(
                int((both & (own["safe"] < of_whole["safe"])).sum()),
                int((both & (own["safe"] > of_whole["safe"])).sum()),
                sum(row.without_verdict.values()),
            ),
            without_verdict=row.without_verdict,
            accuracy=row.stands if question == Question.STANDS else row.accuracy,
            within=row.accuracy,
            stands=row.stands,
            difference=difference(right, reference, truth.clusters),
            p=None if spec == whole else tests[spec].corrected,
            milliseconds=float(times.median()),
            cpu=float(times.median() / times_whole.median()),
            cpu_total=found.cost_ratio(spec, whole),
            cpu_paired=median(times / times_whole),
            body_substeps=float(work / work_whole) if work_whole else np.nan,
            same_by_boxes={titles[own.name]: own.accuracy[spec] for own in by_boxes},
            cpu_by_boxes=dict(zip(titles, medians.tolist(), strict=True)),
        )

    return Options(
        question=question,
        cases=len(labels),
        layouts=labels.index.get_level_values("layout").nunique(),
        instances=labels["instance"].nunique(),
        whole=option(whole),
        options=[option(spec) for spec in others],
    )


def _verdicts(judged: JudgedCases, spec: str) -> pd.DataFrame:
    """Status, items placed safely (-1: no verdict), boxes, work and time of a method by case."""
    rows = judged.results[judged.results["method"] == spec]
    rows = rows[rows["repetition"] == 0].set_index(["layout", "scenario"]).loc[judged.said.index]
    return pd.DataFrame(
        {
            "status": rows["status"],
            "safe": judged.said[spec].fillna(-1).astype(int),
            "item_count": rows["item_count"].astype(int),
            "body_substeps": rows["body_substeps"].astype(float),
            "milliseconds": 1e3 * rows[CPU],
        }
    )


def size_groups(counts: Sequence[int]) -> list[tuple[int, int]]:
    """Least and greatest number of boxes of up to three groups of about as many cases."""
    ordered = sorted(counts)
    ends = [ordered[-(-len(ordered) * k // _SIZES) - 1] for k in range(1, _SIZES + 1)]
    groups, least = [], ordered[0]
    for end in dict.fromkeys(ends):
        here = [count for count in ordered if least <= count <= end]
        groups.append((here[0], here[-1]))
        least = end + 1
    return groups


def option_title(method: MethodKey, whole: MethodKey) -> str:
    """Parameters that an option changes, and the engine where that is another one."""
    if method.spec == whole.spec:
        return "whole pile"
    values = [v for v in method.spec.partition(":")[2].split(",") if v]
    changed = ", ".join(f"`{v}`" for v in values if not v.startswith("question="))
    engine = "" if method.engine == whole.engine else f"on {method.engine}"
    return " ".join(filter(None, (changed or "whole pile", engine)))

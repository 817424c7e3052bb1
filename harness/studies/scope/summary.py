"""Options beside the simulation of the whole pile, case by case: verdicts, accuracy and cost."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from steadyload.layouts.question import Question
from steadyload.methods.method import Status
from steadyload.methods.naming import MethodKey
from steadyload.runs.accuracy import verdicts_against_labels
from steadyload.runs.costs import CPU, CostKind, CostSource
from steadyload.runs.evaluation import Evaluation, evaluate
from steadyload.runs.judged import JudgedCases, load_judged
from steadyload.runs.provenance import source_line
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.metrics import mean, median, share
from steadyload.statistics.paired import holm, sign_flip

BoolArray = NDArray[np.bool_]

_ENDED = (str(Status.DONE), str(Status.UNSETTLED))
"""Statuses of a verdict of the whole pile that others can be compared with."""

KEPT = 0.99
"""Share of the verdicts of the whole pile that nearly all are."""

_SIZES = 3
"""Groups of cases by their number of boxes."""


@dataclass(frozen=True, slots=True)
class SizeRow:
    """An option on the cases with some numbers of boxes: share of verdicts of the whole pile, and
    median of CPU time over that of the whole pile.
    """

    boxes: str
    same: Estimate
    cpu: float


@dataclass(frozen=True, slots=True)
class OptionRow:
    """An option beside the simulation of the whole pile, on the same cases.

    Attributes:
        method: its name and spec.
        title: what it changes.
        same: share of cases with the status and failing step of the whole pile, of cases in which
            that has a verdict or is unsettled.
        earlier, later: cases of these in which it fails earlier, later; a stable layout fails later
            than all.
        without_verdict: cases without a verdict, by status.
        accuracy: share of cases with the label of the question that is asked.
        within, stands: by the labels of each question.
        difference: accuracy minus that of the whole pile, on the same cases.
        p: of the sign-flip test of that difference, corrected by Holm for the options of the table;
            None for the whole pile.
        milliseconds: median CPU time of a case.
        cpu: that median over that of the whole pile.
        cpu_paired: median over the cases of CPU time over that of the whole pile.
        cpu_total: CPU time of all cases over that of the whole pile.
        body_substeps: substeps times boxes of all cases over those of the whole pile.
        sizes: by number of boxes.
    """

    method: MethodKey
    title: str
    same: Estimate
    earlier: int
    later: int
    without_verdict: Mapping[str, int]
    accuracy: Estimate
    within: Estimate
    stands: Estimate
    difference: Estimate
    p: float | None
    milliseconds: float
    cpu: float
    cpu_paired: Estimate
    cpu_total: Estimate
    body_substeps: float
    sizes: tuple[SizeRow, ...]

    @property
    def changed(self) -> Estimate:
        """Share of cases with another status or failing step than the whole pile."""
        same = self.same
        return Estimate(1.0 - same.value, 1.0 - same.high, 1.0 - same.low, same.n)


@dataclass(frozen=True)
class ScopeTable:
    """The options of one question.

    Attributes:
        question: that was asked.
        cases, layouts, instances: number of each.
        whole: the simulation of the whole pile.
        options: beside it, in the order of the study.
        costs: source of the times.
        manifest: provenance of the run.
    """

    question: Question
    cases: int
    layouts: int
    instances: int
    whole: OptionRow
    options: tuple[OptionRow, ...]
    costs: CostSource
    manifest: Mapping[str, str]

    @property
    def rows(self) -> tuple[OptionRow, ...]:
        """The whole pile, then the options."""
        return (self.whole, *self.options)

    @property
    def cheapest(self) -> OptionRow | None:
        """The option of least CPU time of all cases that keeps :data:`KEPT` of the verdicts."""
        kept = [row for row in self.options if row.same.value > KEPT - 1e-9]
        return min(kept, key=lambda row: row.cpu_total.value, default=None)


def scope_table(folder: Path, question: Question, whole: str) -> ScopeTable:
    """The table of a run.

    Args:
        folder: of the run, on a labelled set.
        question: that all of its methods were asked.
        whole: spec of the simulation of the whole pile.

    Raises:
        ResultsError: not a run folder, or no case has been judged by all methods yet.
    """
    judged = load_judged(folder)
    costs = CostSource(CostKind.ONE_PROCESS)
    found = evaluate(judged, source=costs, by_scenario=False)
    others = [spec for spec in judged.keys if spec != whole]
    right = {spec: _right(judged, spec, question) for spec in judged.keys}
    tests = [_test(right[spec], right[whole], judged) for spec in others]
    p_values = dict(zip(others, holm(tests), strict=True))
    rows = {
        spec: _row(found, question, spec, whole, right, p_values.get(spec)) for spec in judged.keys
    }
    labels = judged.labels
    assert labels is not None, "the run is on a labelled set"
    return ScopeTable(
        question,
        len(labels),
        labels.index.get_level_values("layout").nunique(),
        labels["instance"].nunique(),
        rows[whole],
        tuple(rows[spec] for spec in others),
        costs,
        _manifest(judged),
    )


def _row(
    found: Evaluation,
    question: Question,
    spec: str,
    whole: str,
    right: Mapping[str, pd.Series],
    p: float | None,
) -> OptionRow:
    judged, own = found.judged, found.row(spec)
    verdicts = _verdicts(judged, spec).join(_verdicts(judged, whole).add_suffix("_whole"))
    compared = verdicts[verdicts["status_whole"].isin(_ENDED)]
    clusters = judged.clusters
    same = _same(compared)
    both = (compared["status"] == "done") & (compared["status_whole"] == "done")
    safe, safe_whole = compared["said"].fillna(-1), compared["said_whole"].fillna(-1)
    above, below = (_milliseconds(found, each) for each in (spec, whole))
    ahead = right[spec].astype(float) - right[whole].astype(float)
    work, work_whole = (
        verdicts[f"body_substeps{which}"].astype(float).sum() for which in ("", "_whole")
    )
    return OptionRow(
        method=own.method,
        title=option_title(own.method, judged.keys[whole]),
        same=share(same, clusters.loc[compared.index]),
        earlier=int((both & (safe < safe_whole)).sum()),
        later=int((both & (safe > safe_whole)).sum()),
        without_verdict=own.without_verdict,
        accuracy=own.stands if question is Question.STANDS else own.accuracy,
        within=own.accuracy,
        stands=own.stands,
        difference=mean(ahead, clusters.loc[ahead.index]),
        p=p,
        milliseconds=float(above.median()),
        cpu=float(above.median() / below.median()),
        cpu_paired=median(above / below),
        cpu_total=found.cost_ratio(spec, whole),
        body_substeps=float(work / work_whole) if work_whole else np.nan,
        sizes=_by_size(verdicts, clusters, above, below),
    )


def _same(verdicts: pd.DataFrame) -> BoolArray:
    """Mask of the cases with the status and failing step of the whole pile."""
    statuses = verdicts["status"] == verdicts["status_whole"]
    steps = verdicts["said"].fillna(-1) == verdicts["said_whole"].fillna(-1)
    found: BoolArray = (statuses & steps).to_numpy(bool)
    return found


def _verdicts(judged: JudgedCases, spec: str) -> pd.DataFrame:
    """Status, items placed safely, number of boxes and work of a method by case."""
    rows = judged.results[judged.results["method"] == spec]
    rows = rows[rows["repetition"] == 0].set_index(["layout", "scenario"])
    own = rows[["status", "item_count", "body_substeps"]].loc[judged.said.index]
    return own.assign(said=judged.said[spec])


def _milliseconds(found: Evaluation, spec: str) -> pd.Series:
    taken = found.costs.of(spec)
    assert taken is not None, "all methods of a run are timed"
    return taken[CPU].loc[found.judged.said.index]


def _by_size(
    verdicts: pd.DataFrame, clusters: pd.Series, above: pd.Series, below: pd.Series
) -> tuple[SizeRow, ...]:
    """An option by number of boxes, in groups of about as many cases."""
    counts = verdicts["item_count"].astype(int)
    rows = []
    for least, most in size_groups(counts.tolist()):
        here = counts.between(least, most)
        compared = verdicts[here & verdicts["status_whole"].isin(_ENDED)]
        rows.append(
            SizeRow(
                f"{least} to {most}" if least < most else str(least),
                share(_same(compared), clusters.loc[compared.index]),
                float(above[here].median() / below[here].median()),
            )
        )
    return tuple(rows)


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


def _right(judged: JudgedCases, spec: str, question: Question) -> pd.Series:
    """By case that has a label of the question, whether a method names it."""
    labels = judged.labels
    assert labels is not None, "the run is on a labelled set"
    if question is Question.STANDS:
        labels = labels[(labels["stands"] == "done").fillna(False).to_numpy(bool)]
        labels = labels.assign(failing_step=labels["failing_step_stands"])
    found: pd.Series = verdicts_against_labels(judged.said[spec].loc[labels.index], labels)["right"]
    return found


def _test(own: pd.Series, whole: pd.Series, judged: JudgedCases) -> float:
    return sign_flip(own.astype(int) - whole.astype(int), judged.clusters.loc[own.index])


def option_title(method: MethodKey, whole: MethodKey) -> str:
    """Parameters that an option changes, and the engine where that is another one."""
    if method.spec == whole.spec:
        return "whole pile"
    values = [v for v in method.spec.partition(":")[2].split(",") if v]
    changed = ", ".join(f"`{v}`" for v in values if not v.startswith("question="))
    engine = "" if method.engine == whole.engine else f"on {method.engine}"
    return " ".join(filter(None, (changed or "whole pile", engine)))


def _manifest(judged: JudgedCases) -> dict[str, str]:
    manifest = judged.manifest
    return {
        "labels": manifest["labels"]["hash"],
        "rows": str(judged.rows),
        "source": source_line(manifest),
        "versions": ", ".join(f"{k} {v}" for k, v in manifest["versions"].items()),
        "machine": manifest["machine"],
        "started": manifest["started"],
        "finished": manifest["finished"] or "not yet",
    }

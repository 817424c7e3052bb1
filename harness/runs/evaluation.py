"""A table of methods: accuracy and cost of each on the cases of a run.

Pages that are made of a frame of verdicts use :mod:`steadyload.runs.frames` in its place. Numbers
of items placed safely are compared with labels, which are the failing step, and all items for a
stable layout. All intervals are clustered by item list where lists are known, else by layout.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from operator import attrgetter
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike, NDArray

from steadyload.layouts.model.question import Question
from steadyload.methods.naming import MethodKey
from steadyload.reports.columns import (
    column,
    counts,
    factor,
    milliseconds,
    percent,
    row,
    significant,
)
from steadyload.runs.accuracy import (
    accuracy,
    accuracy_of,
    at_natural_prevalence,
    verdicts_against_labels,
)
from steadyload.runs.comparison import Compared, Family, Slice, compared, difference
from steadyload.runs.costs import CPU, PHASES, WALL, Costs, CostSource, judging_costs
from steadyload.runs.judged import JudgedCases, load_judged
from steadyload.runs.labels import item_lists, labels_on, statuses_on
from steadyload.statistics.error_costs import ErrorShares
from steadyload.statistics.estimate import NOTHING, Estimate
from steadyload.statistics.metrics import mean, ratio, share

ALL = "all"
"""The group of all cases; the other groups are scenarios."""

BoolArray = NDArray[np.bool_]


def _taken(time: float) -> str:
    """A time [ms]; a dash for a method that has no such phase."""
    return significant(time or None)


@row
class PhaseTimes:
    """Mean CPU time a layout by phase [ms]; all of it is ``other`` where there are no phases."""

    build: float = column("build ms", _taken)
    step: float = column("step ms", _taken)
    read: float = column("read ms", _taken)
    other: float = column("other ms", significant)


@row
class MethodEvaluation:
    """Results of one method on a group of cases. Estimates without any case have n = 0.

    Attributes:
        method: its name and spec.
        group: :data:`ALL`, or a scenario.
        accuracy: share of cases whose failing step is the label's. A case without a verdict
            counts as wrong, and as neither over nor under.
        over, under: share of cases whose failing step is later, earlier than the label's; a stable
            layout fails later than all.
        under_or_none: share of cases that are underestimated, or without a verdict.
        stable_or_not: share of cases that both call stable, or neither does.
        within_one: share of cases whose numbers of items placed safely differ by at most one.
        robust, fragile: accuracy on cases whose label is so.
        natural: accuracy at the natural share of stable layouts, where that is known.
        stands: accuracy on the labels of the question ``stands``, of cases that have one.
        behind: accuracy minus that of the most accurate method of the group, on the same cases;
            None for that method itself, for one that is not compared, and without labels.
        score: mean score of the cases with a verdict.
        fully_stable: share of layouts that the method calls stable.
        without_verdict: cases without a verdict, by status.
        cpu, wall: time a layout [ms], see :attr:`Evaluation.cost_source`.
        phases: of the CPU time; None where the source of the costs does not know them.
        substeps: of an engine, mean a layout; the same on every machine.
        ahead: accuracy of the method that this one is compared with minus its own, on the same
            cases; None where it is compared with none, or with itself.
        cost_ratio: CPU time of the method that it is compared with over its own, likewise.
    """

    method: MethodKey = column(form=attrgetter("title"), left=True)
    group: str = ALL
    accuracy: Estimate = column("accuracy %", percent, default=NOTHING)
    over: Estimate = column("overestimated %", percent, default=NOTHING)
    under: Estimate = column("underestimated %", percent, default=NOTHING)
    under_or_none: Estimate = column("underestimated or no verdict %", percent, default=NOTHING)
    stable_or_not: Estimate = column("stable or not %", percent, default=NOTHING)
    within_one: Estimate = column("within one %", percent, default=NOTHING)
    robust: Estimate = column("robust %", percent, default=NOTHING)
    fragile: Estimate = column("fragile %", percent, default=NOTHING)
    natural: Estimate = column("natural prevalence %", percent, default=NOTHING)
    stands: Estimate = column("stands %", percent, default=NOTHING)
    behind: Estimate | None = column("difference", percent, default=None)
    score: Estimate = column("mean score %", percent, default=NOTHING)
    fully_stable: Estimate = column("fully stable %", percent, default=NOTHING)
    without_verdict: Mapping[str, int] = column(
        "no verdict", counts, notable=True, default_factory=dict
    )
    cpu: Estimate = column("CPU ms", milliseconds, default=NOTHING)
    wall: Estimate = column("wall ms", milliseconds, default=NOTHING)
    phases: PhaseTimes | None = None
    substeps: float = 0.0
    ahead: Estimate | None = column(form=percent, default=None)
    cost_ratio: Estimate | None = column("cost ratio", factor, default=None)

    @property
    def errors(self) -> ErrorShares | None:
        """Errors by direction; None without labels."""
        return ErrorShares(self.over, self.under_or_none) if self.over.n else None


@dataclass(frozen=True, slots=True)
class LabelledPart:
    """The labels of the cases.

    ``stable``, ``robust``, ``fragile``: cases whose label is so; labels that are neither robust nor
    fragile have no ensemble. ``natural_stable``: share of stable layouts by scenario in the whole
    set; empty where that is not known. ``stands``: cases that were labelled for the question
    ``stands``, too, by status of that label; empty where none was.
    """

    part: str
    cases: int
    item_lists: int
    stable: int
    robust: int
    fragile: int
    natural_stable: Mapping[str, float]
    stands: Mapping[str, int] = field(default_factory=dict)


@dataclass(frozen=True)
class Evaluation:
    """The table of methods of a run: a row a method and group.

    Attributes:
        judged: the cases and verdicts that it is of.
        rows: by group, a row a method, in the order of the study.
        labelled: about the labels; None without labels.
        costs: of judging, or of the timing pass.
    """

    judged: JudgedCases
    rows: Mapping[str, tuple[MethodEvaluation, ...]]
    labelled: LabelledPart | None
    costs: Costs

    @property
    def groups(self) -> tuple[str, ...]:
        """All cases, then the scenarios where there are several."""
        return tuple(self.rows) if len(self.rows) > 2 else (ALL,)

    @property
    def by_title(self) -> dict[str, tuple[MethodEvaluation, ...]]:
        """Rows of :attr:`groups` by the title of the group."""
        return {"all scenarios" if g == ALL else g: self.rows[g] for g in self.groups}

    @property
    def cost_source(self) -> CostSource:
        """Source of CPU and wall times."""
        return self.costs.source

    @property
    def methods(self) -> tuple[MethodEvaluation, ...]:
        """All methods on all cases."""
        return self.rows[ALL]

    @cached_property
    def comparable(self) -> tuple[MethodEvaluation, ...]:
        """The methods that are compared: all but :attr:`.JudgedCases.apart`, where others are."""
        apart = self.judged.apart
        return tuple(row for row in self.methods if row.method.spec not in apart) or self.methods

    @property
    def best(self) -> MethodEvaluation:
        """The most accurate of the methods that are compared."""
        return max(self.comparable, key=lambda m: m.accuracy.value)

    def row(
        self,
        spec: str,
        group: str = ALL,
        *,
        against: str | None = None,
        key: MethodKey | None = None,
    ) -> MethodEvaluation:
        """A method's row.

        Args:
            spec: of the method, canonical.
            group: of cases.
            against: spec of the method that it is compared with; None for none.
            key: how to name the method; None names it as elsewhere.
        """
        found = next(row for row in self.rows[group] if row.method.spec == spec)
        if against is not None and against != spec:
            found = dataclasses.replace(
                found,
                ahead=self.difference(against, spec, group),
                cost_ratio=self.cost_ratio(against, spec, group),
            )
        return found if key is None else dataclasses.replace(found, method=key)

    def difference(self, first: str, second: str, group: str = ALL) -> Estimate:
        """Accuracy of the first method minus that of the second, case by case."""
        keys, own = self.judged.keys, self.compared(group)
        return difference(own.right[keys[first]], own.right[keys[second]], own.clusters)

    def cost_ratio(self, first: str, second: str, group: str = ALL) -> Estimate:
        """CPU time of the first method over that of the second; n = 0 where one was not timed."""
        above, below = (self.costs.of(spec, _scenario(group)) for spec in (first, second))
        if above is None or below is None:
            return NOTHING
        return ratio(above[CPU], below[CPU], self.judged.clusters.loc[above.index])

    def versus(self, spec: str, group: str = ALL) -> Family[MethodKey]:
        """Accuracy of every other method minus that of one, with its significance."""
        return self._in_tests(group).versus(self.judged.keys[spec])

    def pairs(self, group: str = ALL) -> Family[MethodKey]:
        """Accuracy of every method minus that of each later one, with its significance."""
        return self._in_tests(group).pairs()

    def slices(self, by: ArrayLike | pd.Series) -> tuple[Slice[MethodKey], ...]:
        """Accuracy of every method by slice of the cases.

        Args:
            by: name of the slice of each case, in the order of ``judged.said``; see
                :meth:`.Compared.slices`.
        """
        return self.compared().slices(by)

    def compared(self, group: str = ALL) -> Compared[MethodKey]:
        """The cases of a group on which each method is right, by the labels."""
        return self._compared.only(in_group(self.judged.said.index, group))

    def _in_tests(self, group: str) -> Compared[MethodKey]:
        """The same of the methods that are compared."""
        found = self.compared(group)
        own = {row.method: found.right[row.method] for row in self.comparable}
        return dataclasses.replace(found, right=own)

    @cached_property
    def _compared(self) -> Compared[MethodKey]:
        return compared(self.judged)


def evaluate(
    run: str | Path | JudgedCases,
    *,
    costs: Costs | None = None,
    source: CostSource | None = None,
    by_scenario: bool = True,
) -> Evaluation:
    """The table of methods of a run.

    Args:
        run: its folder, or what was read of it.
        costs: of the timing pass; None takes those of judging.
        source: where the costs of judging come from; None says no more of them than that.
        by_scenario: whether there are rows by scenario, too.

    Raises:
        ResultsError: see :func:`steadyload.runs.judged.load_judged`.
    """
    judged = run if isinstance(run, JudgedCases) else load_judged(run)
    if costs is None:
        costs = judging_costs(judged.results, source)
    scenarios = judged.scenarios if by_scenario else ()
    rows = {ALL: _rows(judged, costs, ALL)}
    for scenario in scenarios:
        rows[scenario] = (
            _rows(judged, costs, scenario)
            if len(scenarios) > 1
            else tuple(dataclasses.replace(row, group=scenario) for row in rows[ALL])
        )
    about = None if judged.labels is None else labelled_part(judged)
    return Evaluation(judged, rows, about, costs)


def labelled_part(judged: JudgedCases) -> LabelledPart:
    """About the labels of cases of a labelled set."""
    assert judged.labels is not None, "the run is on a labelled set"
    labels, about = judged.labels, judged.manifest["labels"]
    counts = statuses_on(labels, Question.STANDS).value_counts()
    return LabelledPart(
        part=" ".join(str(about[key]) for key in ("set", "part") if key in about),
        cases=len(labels),
        item_lists=labels["instance"].nunique(),
        stable=int(labels["failing_step"].isna().sum()),
        robust=int(labels["robust"].fillna(False).sum()),
        fragile=int((~labels["robust"].fillna(True)).sum()),
        natural_stable=_natural_stable(judged),
        stands={str(k): int(v) for k, v in counts.items()},
    )


def _natural_stable(judged: JudgedCases) -> dict[str, float]:
    shares: Mapping[str, Any] = judged.manifest["labels"]["natural_stable"]
    scenarios = dict.fromkeys(judged.said.index.get_level_values("scenario"))
    return {str(s): float(shares[s]) for s in scenarios if s in shares}


def in_group(cases: pd.Index, group: str) -> BoolArray:
    """Mask of the cases of a group, shape (cases,), of cases by layout and scenario."""
    scenarios = cases.get_level_values("scenario")
    return np.ones(len(scenarios), bool) if group == ALL else np.asarray(scenarios == group)


def _rows(judged: JudgedCases, costs: Costs, group: str) -> tuple[MethodEvaluation, ...]:
    accuracies = _accuracies(judged, in_group(judged.said.index, group))
    return tuple(
        MethodEvaluation(
            method=key,
            group=group,
            **accuracies.get(spec, {}),
            **_scores(judged, spec, group),
            **_costs(judged, costs, spec, group),
        )
        for spec, key in judged.keys.items()
    )


_SHARES = ("over", "under", "under_or_none", "stable_or_not")
"""Comparisons with labels whose shares are fields of a row under the same names."""


def _accuracies(judged: JudgedCases, here: BoolArray) -> dict[str, dict[str, Any]]:
    """Accuracies of every method by spec, as fields of a row; empty without labels."""
    if judged.labels is None:
        return {}
    labels, natural = judged.labels[here], _natural_stable(judged)
    lists = item_lists(labels)
    robust = labels["robust"].fillna(False).to_numpy(bool)
    fragile = ~labels["robust"].fillna(True).to_numpy(bool)
    compared = {
        spec: verdicts_against_labels(judged.said[spec][here], labels) for spec in judged.keys
    }
    other = labels_on(labels, Question.STANDS)
    apart = judged.apart
    among = [spec for spec in compared if spec not in apart] or list(compared)
    best = max(among, key=lambda spec: compared[spec]["right"].mean())
    found = {}
    for spec, verdicts in compared.items():
        is_ = {name: column.to_numpy(bool) for name, column in verdicts.items()}
        mine, top = is_["right"], compared[best]["right"]
        found[spec] = {
            "accuracy": accuracy(mine, lists),
            **{name: share(is_[name], lists) for name in _SHARES},
            "within_one": share(is_["within_one"], lists),
            "robust": accuracy(mine[robust], lists[robust]),
            "fragile": accuracy(mine[fragile], lists[fragile]),
            "natural": at_natural_prevalence(mine, labels, natural) if natural else NOTHING,
            "stands": accuracy_of(judged.said[spec].loc[other.index], other),
            "behind": difference(mine, top, lists) if spec in among and spec != best else None,
        }
    return found


def _scenario(group: str) -> str | None:
    return None if group == ALL else group


def _scores(judged: JudgedCases, spec: str, group: str) -> dict[str, Any]:
    """Scores and statuses of a method; of several repetitions the first counts."""
    own = judged.results[judged.results["method"] == spec]
    if group != ALL:
        own = own[own["scenario"] == group]
    first = own[own["repetition"] == 0].set_index(["layout", "scenario"])
    done = first[first["status"] == "done"]
    statuses = first["status"].value_counts().sort_index()
    return {
        "score": mean(done["score"], judged.clusters.loc[done.index]),
        "fully_stable": share(
            (first["score"] == 1.0).fillna(False), judged.clusters.loc[first.index]
        ),
        "without_verdict": {str(k): int(v) for k, v in statuses.items() if k != "done"},
        "substeps": float(own["substeps"].mean()),
    }


def _costs(judged: JudgedCases, costs: Costs, spec: str, group: str) -> dict[str, Any]:
    taken = costs.of(spec, _scenario(group))
    if taken is None:
        return {}
    clusters = judged.clusters.loc[taken.index]
    cpu = mean(taken[CPU], clusters)
    found: dict[str, Any] = {"cpu": cpu, "wall": mean(taken[WALL], clusters)}
    if set(PHASES) <= set(taken):
        build, step, read = (float(taken[phase].mean()) for phase in PHASES)
        found["phases"] = PhaseTimes(build, step, read, cpu.value - build - step - read)
    return found


def cheapest_near(methods: Iterable[MethodEvaluation], near: float) -> MethodEvaluation | None:
    """The cheapest method that is nearly as accurate as the best; None where none was timed."""
    rows = list(methods)
    least = max(m.accuracy.value for m in rows) - near
    timed = [m for m in rows if m.accuracy.value >= least and m.cpu.n]
    return min(timed, key=lambda m: m.cpu.value, default=None)

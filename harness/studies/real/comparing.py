"""Accuracy and cost of methods on layouts of real size, by question and number of boxes."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from operator import attrgetter
from pathlib import Path
from typing import Any

import pandas as pd

from steadyload.app.recommend.front import SIZES
from steadyload.layouts.benchmark import Benchmark, BenchmarkError
from steadyload.layouts.model.question import Question
from steadyload.methods.contract.method import Status
from steadyload.methods.naming import MethodKey
from steadyload.reports.columns import column, percent, row, significant
from steadyload.runs.definition import StudyError
from steadyload.runs.judged import load_judged, manifest_lines
from steadyload.runs.results import load_results
from steadyload.statistics.estimate import NOTHING, Estimate
from steadyload.statistics.metrics import share
from steadyload.studies.kit import Lab
from steadyload.studies.real.best import BestMethod, best_method
from steadyload.studies.real.costing import SOURCE
from steadyload.studies.real.delivered import CUSTOMERS, DELIVERED, PACKERS, Origin, origins
from steadyload.studies.real.floors import FloorRow, floor_rows
from steadyload.studies.real.judging import judge_real
from steadyload.studies.real.screened import ScreenedSteps, screened_steps
from steadyload.studies.real.sizes import Bin, MethodResult, SizeGroup, bins, size_group

NEAR = 0.01
"""Accuracy by which the method to choose may be behind the most accurate one."""


@row
class ByBoxes:
    """Accuracy by the labels of either question, and median CPU time [ms], of one method by bin."""

    method: MethodKey = column(form=attrgetter("title"), left=True)
    within: Mapping[Bin, Estimate] = column("{}", percent)
    stands: Mapping[Bin, Estimate] = column("{}", percent)
    median: Mapping[Bin, float | None] = column("{}", significant)


@row
class Point:
    """A value of a method at the middle of a bin; ``panel`` says by which labels it is right."""

    method: MethodKey
    title: str
    boxes: float
    value: Estimate | float
    panel: str = ""

    @property
    def parameters(self) -> str:
        """Of the method, where it does not have the usual ones."""
        return self.method.spec.partition(":")[2]


@row
class NoVerdict:
    """Cases on which a method ended with one status; ``reason`` of that with most boxes."""

    method: str = column()
    status: str = column()
    cases: int = column()
    boxes: str = column(left=False)
    reason: str = column("reason, with most boxes")


@row
class Failing:
    """Share of cases whose label is a failing step."""

    label: str = column()
    share: Estimate = column("fails %", percent)


@row
class Found:
    """Everything that the page shows.

    Attributes:
        real: all cases of the set of real size.
        groups: small cases first, then those of real size by number of boxes.
        small: whether the first group is of small layouts.
        chosen: by question, the cheapest method (by the median) that is at most :data:`NEAR` behind
            the most accurate one, which itself may be it; a question without a label is missing.
        best: by question, the most accurate method, and those that do not differ from it
            significantly; a question without a label is missing.
        origins: who planned the cases.
        lost: cases without a verdict.
        floors: shares of customers' pallets that are called stable, by floor; empty without any.
        screened: agreement of screen and reference while the labels were made.
        failing: labels on this page and in the whole set, by question.
        unlabelled: cases of the set without labels, by status.
        timeout: CPU seconds a judgement may take.
        left_out: by spec, the reason why a method cannot judge.
    """

    real: SizeGroup
    groups: tuple[SizeGroup, ...]
    small: bool
    chosen: Mapping[Question, MethodResult]
    best: Mapping[Question, BestMethod]
    origins: tuple[Origin, ...]
    lost: tuple[NoVerdict, ...]
    floors: tuple[FloorRow, ...]
    screened: ScreenedSteps
    failing: Sequence[Failing]
    unlabelled: Mapping[str, int]
    timeout: float
    left_out: Mapping[str, str]
    made_with: Mapping[str, str]
    near: float = NEAR
    cost_explained: str = SOURCE.explained()

    @property
    def by_boxes(self) -> Sequence[ByBoxes]:
        """A row a method, in the order of the study."""
        return [self._by_boxes(result.method) for result in self.real.methods]

    def _by_boxes(self, method: MethodKey) -> ByBoxes:
        found = {group.bin: group.of(method.spec) for group in self.groups}
        return ByBoxes(
            method,
            {size: own.within.overall for size, own in found.items()},
            {size: own.stands.overall for size, own in found.items()},
            {size: own.cost.median if own.cost else None for size, own in found.items()},
        )

    @property
    def accuracies(self) -> Sequence[Point]:
        """Of methods that are asked the question of the labels, or none."""
        return [
            Point(own.method, own.method.title, group.bin.middle, right, f"label: {question}")
            for question in Question
            for group in self.groups
            for own in group.methods
            if own.asked in (None, question) and (right := own.accuracy[question].overall).n
        ]

    @property
    def medians(self) -> Sequence[Point]:
        """Median CPU times [ms]; the exponent over all sizes stands in the title."""
        powers = {r.method: r.growth.everything.value for r in self.real.methods if r.growth}
        return [
            Point(key, key.title + _power(powers[key]), group.bin.middle, own.cost.median)
            for group in self.groups
            for own in group.methods
            if own.cost and (key := own.method)
        ]

    @property
    def whose(self) -> Sequence[tuple[Origin, Origin, Origin]]:
        """Customers' pallets, these as delivered, and plans of packers; empty if one is missing."""
        found = {origin.title: origin for origin in self.origins}
        own, delivered, packers = map(found.get, (CUSTOMERS, DELIVERED, PACKERS))
        return [(own, delivered, packers)] if own and delivered and packers else []


def _power(exponent: float) -> str:
    return f": n^{exponent:.2f}" if math.isfinite(exponent) else ""


def compare(
    lab: Lab,
    methods: tuple[str, ...],
    directory: str,
    *,
    timeout: float,
    sizes: tuple[int, ...],
    **cases: Any,
) -> Found:
    """Judge what is missing, and compare the methods.

    Args:
        lab: where they judge.
        methods: see :func:`.judge_real`, as of ``directory``, ``timeout`` and ``cases``.
        directory: of the labelled set.
        timeout: CPU seconds a judgement may take.
        sizes: largest numbers of boxes of the bins; empty for :data:`SIZES`.
        cases: how many of them.

    Raises:
        StudyError: sizes that do not rise.
        ResultsError: see :func:`steadyload.runs.judged.load_judged`.
        as :func:`.judge_real`.
    """
    sizes = sizes or SIZES
    if sizes[0] < 1 or any(b <= a for a, b in pairwise(sizes)):
        listed = ", ".join(map(str, sizes))
        raise StudyError(f"sizes are {listed}; allowed: whole numbers that rise from 1 on")
    judged = judge_real(lab, methods, directory, timeout=timeout, **cases)
    real = load_judged(judged.real)
    small = None if judged.small is None else load_judged(judged.small)
    whole = size_group(real, timeout, whole=True, small=small)
    parts = [real.only(here) for here in bins(real, sizes)]
    unlabelled = judged.benchmark.cases["status"].value_counts().sort_index()
    return Found(
        real=whole,
        groups=tuple(size_group(part, timeout) for part in ([small] if small else []) + parts),
        small=small is not None,
        chosen={q: found for q in Question if (found := _chosen(whole, q)) is not None},
        best={q: own for q in Question if (own := best_method(real, q)) is not None},
        origins=origins(real, judged.benchmark.layouts),
        lost=_lost([folder for folder in (judged.small, judged.real) if folder]),
        floors=floor_rows(judged),
        screened=screened_steps(judged.benchmark.screening),
        failing=list(_failing(whole.bin, judged.benchmark)),
        unlabelled={str(k): int(v) for k, v in unlabelled.items() if k != "done"},
        timeout=timeout,
        left_out=judged.left_out,
        made_with=manifest_lines(real),
    )


def _failing(here: Bin, benchmark: Benchmark) -> Iterator[Failing]:
    for question in Question:
        yield Failing(f"{question}, the cases of this page", getattr(here, question))
        try:
            cases = benchmark.select(question=question)
            natural = share(cases["failing_step"].notna(), cases["instance"])
        except BenchmarkError:
            natural = NOTHING
        yield Failing(f"{question}, the whole set", natural)


def _chosen(whole: SizeGroup, question: Question) -> MethodResult | None:
    """See :attr:`Found.chosen`."""
    close = [
        (result.cost.median, result)
        for result in whole.methods
        if result.cost is not None
        and result.accuracy[question].overall.n
        and ((behind := result.accuracy[question].behind) is None or behind.value >= -NEAR)
    ]
    return min(close, key=lambda pair: pair[0])[1] if close else None


def _lost(folders: Sequence[Path]) -> tuple[NoVerdict, ...]:
    """Cases without a verdict by method and status, over all runs."""
    columns = ("layout", "scenario", "method", "method_name", "engine", "repetition", "status",
               "reason", "item_count")  # fmt: skip
    rows = pd.concat([load_results(folder, columns) for folder in folders], ignore_index=True)
    titles = {
        spec: key.title for folder in folders for spec, key in load_judged(folder).keys.items()
    }
    rows = rows[(rows["status"] != str(Status.DONE)) & (rows["repetition"] == 0)]
    return tuple(
        NoVerdict(
            titles[str(spec)], str(status), len(own),
            f"{own['item_count'].min()} to {own['item_count'].max()}",
            str(own.loc[own["item_count"].idxmax(), "reason"]),
        )
        for (spec, status), own in rows.groupby(["method", "status"], sort=False)
    )  # fmt: skip

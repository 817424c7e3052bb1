"""Errors of methods by class and number of items, and by the margin of balance of a step."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from steadyload.layouts.sizes import binned
from steadyload.reports.columns import column, general, percent, row
from steadyload.runs.comparison import Compared
from steadyload.runs.labels import item_lists
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.metrics import share
from steadyload.statistics.placed import items_placed_by_case
from steadyload.studies.evaluation.costing import Cost, cost_of

SMALL_SIZES = (3, 5, 6, 7, 10, 15, 19, 20)
"""Largest numbers of boxes of bins. The paper cuts layouts to 20, so that many have exactly 20."""

MARGINS = (-np.inf, -20.0, -10.0, -5.0, -1.0, 0.0, 0.5, 1.0, 2.0, 5.0, np.inf)
"""Edges of bins of the margin [cm]. Below 0 a step is out of balance and fails after some time."""


@row
class CaseBin:
    """Cases of one class of items, or with about as many boxes.

    Attributes:
        items: boxes on average.
        stable: share of cases whose label is that they are stable.
        accuracy: by spec.
        costs: by spec; empty where times are of a timing pass.
    """

    name: str = column("boxes", left=False)
    middle: float = column("median", general)
    cases: int = column()
    item_lists: int = column("item lists")
    stable: Estimate = column("stable by the label %", percent)
    items: float
    accuracy: Mapping[str, Estimate]
    costs: Mapping[str, Cost]


@dataclass(frozen=True, slots=True)
class MarginBin:
    """Steps with a margin of balance in [low, high) cm, and the errors of methods on them.

    ``false_alarms``: by spec, the share of steps stable by the label that fail by the method;
    ``misses``: of those failing by the label that are stable by the method. Only steps that both
    reach are counted. ``holding``, ``failing``: numbers of steps by the labels.
    """

    low: float
    high: float
    holding: int
    failing: int
    false_alarms: Mapping[str, Estimate]
    misses: Mapping[str, Estimate]

    @property
    def name(self) -> str:
        """The margins, for a figure."""
        if math.isinf(self.low):
            return f"< {self.high:g}"
        return f"≥ {self.low:g}" if math.isinf(self.high) else f"{self.low:g}…{self.high:g}"


def class_bins(right: pd.DataFrame, labels: pd.DataFrame) -> tuple[CaseBin, ...]:
    """Accuracy by class of items; nothing where all cases are of one class, or that is not known.

    Arguments as :func:`size_bins`.
    """
    found = _bins(right, labels, labels["item_class"], None)
    return found if len(found) > 1 else ()


def size_bins(
    right: pd.DataFrame,
    labels: pd.DataFrame,
    sizes: Sequence[int] = SMALL_SIZES,
    costs: pd.DataFrame | None = None,
    *,
    stated: bool = False,
) -> tuple[CaseBin, ...]:
    """Accuracy by number of boxes; bins without a case are left out.

    Args:
        right: mask of the cases on which a method is right, cases x specs.
        labels: of the same cases, :data:`steadyload.runs.labels.LABELS`, in the same order.
        sizes: largest numbers of boxes of the bins, which rise; what is larger is a last bin.
        costs: CPU times [ms] of the same cases, missing where there is none; None for no costs.
        stated: whether a bin is named by its ends, whatever it holds; else by the smallest and
            largest number in it.
    """
    count = labels["item_count"].astype(int).to_numpy()
    place, names = binned(count, sizes)
    if not stated:
        for number in names:
            own = count[place == number]
            names[number] = " to ".join(map(str, dict.fromkeys((own.min(), own.max()))))
    found = _bins(right, labels, place, costs)
    return tuple(replace(own, name=names[int(own.name)]) for own in found)


def _bins(
    right: pd.DataFrame, labels: pd.DataFrame, by: Any, costs: pd.DataFrame | None
) -> tuple[CaseBin, ...]:
    by, lists, found = np.asarray(by), item_lists(labels), []
    for own in Compared(right, lists).slices(by):
        here = by == own.name
        count = labels["item_count"][here].astype(float)
        taken = {} if costs is None else {s: cost_of(costs[s][here], lists[here]) for s in costs}
        stable = share(labels["failing_step"][here].isna(), lists[here])
        found.append(CaseBin(
            str(own.name), float(count.median()), own.cases, own.clusters, stable,
            float(count.mean()), own.accuracy,
            {str(spec): cost for spec, cost in taken.items() if cost is not None},
        ))  # fmt: skip
    return tuple(found)


def margin_bins(
    said: pd.DataFrame, labels: pd.DataFrame, margins: Sequence[Sequence[float] | None]
) -> tuple[MarginBin, ...]:
    """False alarms and misses by margin; empty where margins are not known.

    A case is followed to the step where method and label differ, or to the label's failing step:
    verdicts on later steps are not known.

    Args:
        said: items placed safely, cases x specs, as :func:`steadyload.statistics.metrics.outcomes`.
        labels: of the same cases, :data:`steadyload.runs.labels.LABELS`, in the same order.
        margins: by case, the margin of every step up to the label's failing one [cm].
    """
    if any(margin is None for margin in margins):
        return ()
    number, step, margin, fails = _steps(labels, margins)
    place = np.digitize(margin, MARGINS[1:-1])
    lists = item_lists(labels)[number]
    safe = {str(s): said[s].fillna(-1).astype(int).to_numpy()[number] for s in said}

    def errors(of: NDArray[np.bool_], later: int) -> dict[str, Estimate]:
        """Share of some steps that methods come to, without a verdict to none, and judge wrong."""
        came = {spec: of & (own >= step) for spec, own in safe.items()}
        return {
            spec: share(np.sign(own - step)[came[spec]] == later, lists[came[spec]])
            for spec, own in safe.items()
        }

    found = []
    for bin_, (low, high) in enumerate(pairwise(MARGINS)):
        holding, failing = (place == bin_) & ~fails, (place == bin_) & fails
        alarms, misses = errors(holding, 0), errors(failing, 1)
        counts = int(holding.sum()), int(failing.sum())
        found.append(MarginBin(float(low), float(high), *counts, alarms, misses))
    return tuple(found)


def _steps(
    labels: pd.DataFrame, margins: Sequence[Sequence[float] | None]
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float64], NDArray[np.bool_]]:
    """All steps up to the labels' failing ones: case, step, margin, mask of the failing ones."""
    count = labels["item_count"].astype(int).to_numpy()
    safe = items_placed_by_case(labels["failing_step"], labels["item_count"]).to_numpy()
    steps = [np.arange(min(s + 1, n)) for s, n in zip(safe, count, strict=True)]
    case = np.repeat(np.arange(len(steps)), [len(own) for own in steps])
    step = np.concatenate(steps)
    margin = [np.asarray(m, float)[: len(own)] for m, own in zip(margins, steps, strict=True)]
    return case, step, np.concatenate(margin), step == safe[case]

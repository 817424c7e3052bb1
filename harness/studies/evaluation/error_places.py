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

from steadyload.runs.comparison import Compared
from steadyload.runs.labels import item_lists
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.metrics import share
from steadyload.statistics.placed import items_placed_by_case

SIZES = ((1, 3), (4, 5), (6, 6), (7, 7), (8, 10), (11, 15), (16, 19), (20, 20))
"""Bins of the number of items. The paper cuts layouts to 20 items, so that many have exactly 20."""

MARGINS = (-np.inf, -20.0, -10.0, -5.0, -1.0, 0.0, 0.5, 1.0, 2.0, 5.0, np.inf)
"""Edges of bins of the margin [cm]. Below 0 a step is out of balance and fails after some time."""


@dataclass(frozen=True, slots=True)
class CaseBin:
    """Cases of one class of items, or with about as many: ``items`` on average.

    ``accuracy``: by spec.
    """

    name: str
    cases: int
    item_lists: int
    items: float
    accuracy: Mapping[str, Estimate]


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
    found = _bins(right, labels, labels["item_class"])
    return found if len(found) > 1 else ()


def size_bins(right: pd.DataFrame, labels: pd.DataFrame) -> tuple[CaseBin, ...]:
    """Accuracy by number of items; bins without a case are left out.

    Args:
        right: mask of the cases on which a method is right, cases x specs.
        labels: of the same cases, :data:`steadyload.runs.labels.LABELS`, in the same order.
    """
    count = labels["item_count"].astype(int).to_numpy()
    most = max(int(count.max(initial=0)), SIZES[-1][1])
    edges = [*SIZES[:-1], (SIZES[-1][0], most)]
    found = _bins(right, labels, np.digitize(count, [fewest for fewest, _ in SIZES[1:]]))
    return tuple(replace(own, name="{} to {}".format(*edges[int(own.name)])) for own in found)


def _bins(right: pd.DataFrame, labels: pd.DataFrame, by: Any) -> tuple[CaseBin, ...]:
    items = labels["item_count"].astype(float).groupby(np.asarray(by)).mean()
    return tuple(
        CaseBin(str(own.name), own.cases, own.clusters, float(items[own.name]), own.accuracy)
        for own in Compared(right, item_lists(labels)).slices(by)
    )


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
    alarms: list[dict[str, Estimate]] = [{} for _ in MARGINS[1:]]
    misses: list[dict[str, Estimate]] = [{} for _ in MARGINS[1:]]
    for spec in said:
        safe = said[spec].fillna(-1).astype(int).to_numpy()[number]
        came = safe >= step  # without a verdict to none
        for bin_ in range(len(MARGINS) - 1):
            here = came & (place == bin_)
            of = here & ~fails, here & fails
            alarms[bin_][str(spec)] = share((safe == step)[of[0]], lists[of[0]])
            misses[bin_][str(spec)] = share((safe > step)[of[1]], lists[of[1]])
    return tuple(
        MarginBin(
            float(low),
            float(high),
            int(((place == bin_) & ~fails).sum()),
            int(((place == bin_) & fails).sum()),
            alarms[bin_],
            misses[bin_],
        )
        for bin_, (low, high) in enumerate(pairwise(MARGINS))
    )


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

"""Classes of sizes: those that count alike in a cost, and those with thresholds of their own."""

from __future__ import annotations

import math

import numpy as np

from steadyload.tuning.cascade.defaults import SIZES
from steadyload.tuning.cascade.evaluation import evaluate
from steadyload.tuning.cascade.step_scores import FloatArray, Indices, Table

_FEWEST = 20
"""Cases of a class of sizes at least; fewer count among those of the next smaller class."""

_FAILING = 20
"""Failing steps at least of a class of sizes with thresholds of its own. Of thresholds that lose
none of N failing steps, the next one is lost with a probability of 1 / (N + 1) at most, since it is
the lowest of N + 1 no more often: below 5 %."""

_LISTS = 10
"""Item lists at least that these are of: likewise, if steps of a list were alike, below 10 %."""

_LEAST = 1e-9
"""Of a cost that is divided by [ms]."""


def size_classes(boxes: Indices) -> Indices:
    """The class of sizes of every case, (M,): 0 for the smallest that hold enough cases."""
    place = np.searchsorted(SIZES, boxes)
    counts = np.bincount(place, minlength=len(SIZES) + 1)
    number, gathered, new = 0, 0, np.zeros(len(counts), dtype=np.intp)
    for k, count in enumerate(counts.tolist()):
        if gathered >= _FEWEST and counts[k:].sum() >= _FEWEST:
            number, gathered = number + 1, 0
        new[k], gathered = number, gathered + count
    return new[place]


def threshold_classes(table: Table, last: str) -> tuple[int, ...]:
    """The numbers of items above which a class of sizes begins that may have thresholds of its own.

    The first is 0. A class has failing steps enough (see above), of which the last method alone is
    right; one that has fewer has the thresholds of the next smaller one. Classes count by the
    number of items at a step, not by that of the case.
    """
    evident = table.fails & evaluate(table, (), last).alone[table.of]
    items, lists = table.places[evident] + 1, table.lists[table.of[evident]]

    def enough(above: int, to: float) -> bool:
        own = (items > above) & (items <= to)
        return own.sum() >= _FAILING and len(set(lists[own])) >= _LISTS

    begins, end = [0], math.inf
    for size in reversed(SIZES):
        if enough(size, end) and enough(0, size):
            begins.insert(1, size)
            end = size
    return tuple(begins)


def size_weights(table: Table, last: str) -> FloatArray:
    """The weight of the CPU time of every case [1/ms], (M,).

    A cost is the sum of weighted CPU times: the share of the cost of the last method alone, in the
    mean over classes of sizes.
    """
    classes = size_classes(table.boxes)
    alone = np.bincount(classes, evaluate(table, (), last).cost)
    return np.asarray(1.0 / (len(alone) * np.maximum(alone, _LEAST))[classes])

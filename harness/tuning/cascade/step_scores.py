"""Step scores of methods on every step of labelled cases, and their cost."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from steadyload.methods.contract.declared import Trait
from steadyload.methods.contract.method import Method, RefusedError, Stopwatch
from steadyload.methods.registry import make_method
from steadyload.progress import Progress, silent
from steadyload.tuning.cases import Case

BoolArray = NDArray[np.bool_]
FloatArray = NDArray[np.float64]
Indices = NDArray[np.intp]


@dataclass(frozen=True)
class StepScores:
    """Step scores of one method, the steps of all cases one below the other: N steps of M cases.

    Attributes:
        scores: see :class:`steadyload.methods.contract.method.StepScorer`; not a number where there
            is none, (N,).
        cost: CPU time of scoring [ms], (N,).
        opening: CPU time before the first step is scored [ms], (M,).
        decision_threshold: the step score above which the method itself calls a step unstable.
        trained: something was learnt from labels.
    """

    scores: FloatArray
    cost: FloatArray
    opening: FloatArray
    decision_threshold: float
    trained: bool


@dataclass(frozen=True)
class Table:
    """Cases, and the step scores of several methods on each of their labelled steps.

    Steps are labelled up to the first unstable one, that included; those after it have no label.

    Attributes:
        of: the case of every step, (N,), ascending.
        fails: whether the step is the label's failing step, (N,).
        lists: the item list of every case, (M,).
        boxes: the number of items of every case, also of those without a labelled step, (M,).
        step_scores: by spec.
        falls: the cases of which no stage may lose a fall that the last method finds, (M,); stages
            pass steps then, and call none unstable. None: falls are lost as other steps are.
    """

    of: Indices
    fails: BoolArray
    lists: NDArray[np.object_]
    boxes: Indices
    step_scores: Mapping[str, StepScores]
    falls: BoolArray | None = None

    @cached_property
    def starts(self) -> Indices:
        """The first step of every case, (M,)."""
        return np.searchsorted(self.of, np.arange(len(self.lists)))

    @cached_property
    def places(self) -> Indices:
        """The number of every step in its case, from 0, (N,)."""
        return np.arange(len(self.of)) - self.starts[self.of]

    def chosen(self, cases: BoolArray) -> Table:
        """Those cases alone."""
        steps = cases[self.of]
        renumbered = np.cumsum(cases) - 1
        return Table(
            renumbered[self.of[steps]],
            self.fails[steps],
            self.lists[cases],
            self.boxes[cases],
            {
                spec: replace(
                    o, scores=o.scores[steps], cost=o.cost[steps], opening=o.opening[cases]
                )
                for spec, o in self.step_scores.items()
            },
            None if self.falls is None else self.falls[cases],
        )


def score_steps(
    specs: Sequence[str],
    cases: Sequence[Case],
    *,
    progress: Progress = silent,
) -> Table:
    """Score every labelled step by several methods, one after the other.

    Args:
        specs: of methods, canonical.
        cases: labelled.
        progress: called with methods done and in all.

    Raises:
        NotStepwiseError: a method judges whole loadings alone.
        UserError: as :meth:`Method.prepare`.
    """
    labelled = [min(case.safe + 1, len(case.layout)) for case in cases]
    of = np.repeat(np.arange(len(cases)), labelled)
    last = np.cumsum(labelled) - 1
    fails = np.zeros(len(of), dtype=bool)
    fails[last] = [case.safe < len(case.layout) for case in cases]
    methods = {spec: make_method(spec) for spec in specs}
    for method in methods.values():  # what is only done once is no cost of a step
        method.prepare(max(len(case.layout) for case in cases))
        _of_case(method, cases[0], labelled[0])
    step_scores = {}
    for done, (spec, method) in enumerate(methods.items()):
        progress(done, len(specs))
        step_scores[spec] = _scored(method, cases, labelled)
    progress(len(specs), len(specs))
    lists = np.array([case.instance for case in cases], dtype=object)
    boxes = np.array([len(case.layout) for case in cases])
    return Table(of, fails, lists, boxes, step_scores)


def _scored(method: Method, cases: Sequence[Case], labelled: Sequence[int]) -> StepScores:
    scores, cost, opening = [], [], []
    decision_threshold = math.nan
    for case, count in zip(cases, labelled, strict=True):
        opened, threshold, steps = _of_case(method, case, count)
        opening.append(opened)
        decision_threshold = decision_threshold if threshold is None else threshold
        scores += [score for score, _ in steps]
        cost += [spent for _, spent in steps]
    return StepScores(
        np.array(scores),
        1e3 * np.array(cost),
        1e3 * np.array(opening),
        decision_threshold,
        Trait.LEARNED in method.traits,
    )


def _of_case(
    method: Method, case: Case, count: int
) -> tuple[float, float | None, list[tuple[float, float]]]:
    """CPU seconds before the first step, the decision threshold, and score and CPU seconds by step.

    CPU time is that of the process: an engine may compute in threads of its own, as Rapier does.
    A case that is refused has no threshold, and steps without a score.
    """
    clock = time.process_time
    began = clock()
    try:
        scorer = method.steps(case.layout, Stopwatch())
    except RefusedError:
        return clock() - began, None, [(math.nan, 0.0)] * count
    opened, threshold, steps = clock() - began, scorer.decision_threshold, []
    with closing(scorer):
        for step in range(count):
            began = clock()
            score = scorer.step_score(step)
            steps.append((score, clock() - began))
    return opened, threshold, steps

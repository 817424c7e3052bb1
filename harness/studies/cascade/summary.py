"""Records for the page of a cascade, and its stages' decisions. Shares are 0 to 1, times in ms."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from steadyload.layouts.model import Layout
from steadyload.methods.cascade import Cascade, Decision
from steadyload.methods.method import Method
from steadyload.methods.naming import MethodKey, method_key
from steadyload.methods.thresholds import Ladder
from steadyload.runs.costs import CostSource
from steadyload.runs.evaluation import MethodEvaluation
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.metrics import share


@dataclass(frozen=True, slots=True)
class StageShare:
    """Decisions of one stage.

    ``low``, ``high``: accept and reject thresholds of the step score; None where it never accepts
    or rejects, and both None for the last stage, which decides the rest. ``steps``: share of all
    steps that it decided; ``right``: share of these that are right, of the steps up to the label's
    failing one. ``layouts``: share of layouts that needed it and no later one; ``layouts_right``:
    share of these with the right verdict.
    """

    method: MethodKey
    low: float | None
    high: float | None
    steps: Estimate
    right: Estimate
    layouts: Estimate
    layouts_right: Estimate


@dataclass(frozen=True, slots=True)
class Decided:
    """Steps that a stage decided on the fitted cases, those of them wrong, and lost cases."""

    method: str
    steps: int
    wrong: int
    lost: int


@dataclass(frozen=True, slots=True)
class Held:
    """A stage that is not trained on labels, evaluated at every step of other cases."""

    method: str
    cases: int
    item_lists: int
    steps: int
    decided: int
    wrong: int


@dataclass(frozen=True, slots=True)
class FittedLadder:
    """Thresholds as they were fitted, for one budget [points of accuracy].

    ``stages``: (method, low, high). ``allowed``: number of cases that may be lost; ``lost``: cases
    on which the last method alone is right and the cascade wrong; ``gained`` the other way round.
    ``bound``: upper bound of the share of lost cases at the configured confidence; ``sure_bound``
    at 95 %. ``left_out``: lost cases and all cases, where every item list is judged by thresholds
    fitted without it. ``cost``,
    ``cost_alone``: of the ladder and of its last method, from the times of single steps.
    """

    budget: float
    stages: tuple[tuple[str, float | None, float | None], ...]
    last: str
    cases: int
    item_lists: int
    independent: float
    allowed: int
    lost: int
    gained: int
    bound: float
    sure_bound: float
    left_out: tuple[int, int]
    accuracy: float
    accuracy_alone: float
    cost: float
    cost_alone: float
    decided: tuple[Decided, ...]
    elsewhere: tuple[Held, ...]


@dataclass(frozen=True, slots=True)
class CascadeStudy:
    """A cascade on a part of a labelled set, beside other methods.

    ``part``: after the name of the set unless it is the package's large one. ``fitted_there``: it
    is of a set that thresholds were fitted on, and no test part.
    ``cascade`` is the first of ``methods``, which the others are compared with. ``budgets``: by
    spec of a cascade, its budget [points]. ``cost_source``: of CPU times. ``confidence``: of the
    bounds of the fit. ``made_by``: provenance of the thresholds.
    """

    part: str
    fitted_there: bool
    cases: int
    item_lists: int
    methods: tuple[MethodEvaluation, ...]
    budgets: Mapping[str, float]
    stages: tuple[StageShare, ...]
    steps_a_layout: float
    ladders: tuple[FittedLadder, ...]
    confidence: float
    cost_source: CostSource
    made_by: Mapping[str, str]

    @property
    def cascade(self) -> MethodEvaluation:
        """The cascade that all others are compared with."""
        return self.methods[0]

    @property
    def simulations(self) -> list[MethodEvaluation]:
        """Methods that run on an engine and are no cascade of this study."""
        return [m for m in self.methods if m.method.engine and m.method.spec not in self.budgets]

    @property
    def swept(self) -> list[MethodEvaluation]:
        """The cascade at all budgets, by rising budget."""
        own = [m for m in self.methods if m.method.spec in self.budgets]
        return sorted(own, key=lambda m: self.budgets[m.method.spec])


def stages(
    cascade: Cascade, cases: list[tuple[str, Layout]], labels: pd.DataFrame
) -> dict[str, Any]:
    """Stages by decided steps, and by the layouts of which they are the last stage needed.

    Args:
        cascade: the cascade whose stages decide.
        cases: scenario and layout.
        labels: of the same cases, :data:`steadyload.runs.labels.LABELS`.
    """
    cascade.prepare(max(len(layout) for _, layout in cases))
    stages = list(cascade.ladder.methods)
    rows, layouts = [], []
    for scenario, layout in cases:
        label = labels.loc[(layout.name, scenario)]
        safe = len(layout) if pd.isna(label["failing_step"]) else int(label["failing_step"])
        decisions = cascade.decisions(layout)
        numbers = [stages.index(decision.stage) for decision in decisions]
        rows += [
            (number, label["instance"], decision.step <= safe, _right(decision, safe))
            for number, decision in zip(numbers, decisions, strict=True)
        ]
        end = decisions[-1].step if decisions[-1].unstable else len(layout)
        layouts.append((max(numbers), label["instance"], end == safe))
    steps = pd.DataFrame(rows, columns=["stage", "list", "labelled", "right"])
    whole = pd.DataFrame(layouts, columns=["stage", "list", "right"])
    limits = [(stage.low, stage.high) for stage in cascade.ladder.stages] + [(None, None)]
    return {
        "stages": tuple(
            _share(number, method, limits[number], steps, whole)
            for number, method in enumerate(cascade.stage_methods)
        ),
        "steps_a_layout": len(steps) / len(whole),
    }


def _right(decision: Decision, safe: int) -> bool:
    return decision.unstable == (decision.step == safe)


def _share(
    number: int,
    method: Method,
    limits: tuple[float | None, float | None],
    steps: pd.DataFrame,
    layouts: pd.DataFrame,
) -> StageShare:
    own = steps[(steps["stage"] == number) & steps["labelled"]]
    needed = layouts[layouts["stage"] == number]
    return StageShare(
        method_key(method),
        *limits,
        steps=share(np.asarray(steps["stage"] == number), steps["list"]),
        right=share(own["right"], own["list"]),
        layouts=share(np.asarray(layouts["stage"] == number), layouts["list"]),
        layouts_right=share(needed["right"], needed["list"]),
    )


_KEPT = (
    "cases", "item_lists", "independent", "allowed", "lost", "gained", "bound", "sure_bound",
    "accuracy",
)  # fmt: skip
"""Fields of a ladder that have the same name in the file of thresholds."""


def fitted(budget: float, ladder: Ladder) -> FittedLadder:
    """Thresholds as they were fitted, for one budget."""
    found = ladder.found
    return FittedLadder(
        budget=budget,
        stages=tuple((stage.method, stage.low, stage.high) for stage in ladder.stages),
        last=ladder.last,
        **{name: found[name] for name in _KEPT},
        left_out=(found["left_out"]["lost"], found["left_out"]["cases"]),
        accuracy_alone=found["alone"],
        cost=found["milliseconds"],
        cost_alone=found["milliseconds_alone"],
        decided=tuple(Decided(**entry) for entry in found["decided"]),
        elsewhere=tuple(Held(**entry) for entry in found["elsewhere"]),
    )

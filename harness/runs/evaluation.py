"""How often methods are right: their verdicts against the labels of a labelled set.

Numbers of items placed safely are compared, which are the failing step, and all items for a stable
layout. All intervals stand on instances (item lists): layouts packed from one list are alike.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from steadyload.methods.naming import MethodKey
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.metrics import mean, share, weighted_share


@dataclass(frozen=True, slots=True)
class PhaseTimes:
    """Mean CPU time a layout by phase [ms]."""

    build: float
    step: float
    read: float
    other: float


@dataclass(frozen=True, slots=True)
class MethodSummary:
    """One method over all cases of a study.

    ``agreement`` is the mean agreement with the simulations on *other* engines, None where there is
    none to compare with. Times are a layout, in ms.
    """

    method: MethodKey
    score: Estimate
    stable: Estimate
    agreement: Estimate | None
    cpu: Estimate
    wall: Estimate
    phases: PhaseTimes
    without_verdict: Mapping[str, int]


@dataclass(frozen=True, slots=True)
class AgreementMatrix:
    """Share of equal failing steps between every two methods."""

    methods: tuple[MethodKey, ...]
    shares: tuple[tuple[Estimate, ...], ...]

    @property
    def titles(self) -> tuple[str, ...]:
        """The methods' titles, in the order of rows and columns."""
        return tuple(method.title for method in self.methods)


@dataclass(frozen=True, slots=True)
class AccuracySummary:
    """One method against the labels: shares of cases.

    ``accuracy``: the failing step is the label's. ``over``, ``under``: it is later, earlier; a
    stable layout fails later than all. ``stable``: both say stable, or neither does.
    ``within_one``: the numbers of items placed safely differ by at most one. ``robust``,
    ``fragile``: accuracy on cases whose label is so. ``natural``: accuracy at the natural share of
    stable layouts. Estimates that no case speaks of have n = 0. Times are a layout, in ms.
    ``behind``: accuracy minus that of the most accurate method on the same cases, None for that
    method itself. A case without a verdict counts as wrong, and as neither over nor under.
    """

    method: MethodKey
    accuracy: Estimate
    over: Estimate
    under: Estimate
    stable: Estimate
    within_one: Estimate
    robust: Estimate
    fragile: Estimate
    natural: Estimate
    cpu: Estimate
    wall: Estimate
    without_verdict: Mapping[str, int]
    behind: Estimate | None = None


@dataclass(frozen=True, slots=True)
class Accuracies:
    """All methods against the labels of a part of a labelled set.

    ``stable``, ``robust``, ``fragile``: cases whose label is so; what is neither robust nor fragile
    was not asked. ``natural_stable``: share of stable layouts by scenario in the whole set.
    """

    part: str
    cases: int
    instances: int
    stable: int
    robust: int
    fragile: int
    natural_stable: Mapping[str, float]
    methods: tuple[AccuracySummary, ...]
    by_scenario: Mapping[str, tuple[AccuracySummary, ...]]


BoolArray = NDArray[np.bool_]


def verdicts_against_labels(said: pd.Series, labels: pd.DataFrame) -> pd.DataFrame:
    """How one method's verdicts compare with the labels, case by case.

    Args:
        said: items placed safely, all of them for a stable layout, missing without a verdict; as a
            column of :func:`steadyload.statistics.metrics.outcomes`.
        labels: those of the same cases, :data:`steadyload.runs.labels.LABELS`, in the same
            order.

    Returns:
        Booleans, indexed as ``said``. ``right``: the same failing step (Eq. 5 of the paper).
        ``over``, ``under``: it is later, earlier. ``stable``: both say stable or neither does.
        ``within_one``: at most one item apart. A missing verdict is none of these.
    """
    count = labels["item_count"].astype(int).to_numpy()
    true = labels["failing_step"].fillna(labels["item_count"]).astype(int).to_numpy()
    known = said.notna().to_numpy()
    found = said.fillna(-1).astype(int).to_numpy()
    return pd.DataFrame(
        {
            "right": known & (found == true),
            "over": known & (found > true),
            "under": known & (found < true),
            "stable": known & ((found == count) == (true == count)),
            "within_one": known & (np.abs(found - true) <= 1),
        },
        index=said.index,
    )


def accuracies(
    about: Mapping[str, Any],
    said: pd.DataFrame,
    labels: pd.DataFrame,
    summaries: Sequence[MethodSummary],
    by_scenario: Mapping[str, Sequence[MethodSummary]],
) -> Accuracies:
    """All methods against the labels, over all cases and by scenario.

    Args:
        about: what the run folder's manifest says of the labels.
        said: as :func:`steadyload.statistics.metrics.outcomes` gives it.
        labels: those of the same cases, :data:`steadyload.runs.labels.LABELS`, in the same
            order.
        summaries: what methods cost, over all cases.
        by_scenario: the same, by scenario; may be empty.
    """
    scenarios = said.index.get_level_values("scenario")
    natural = {s: float(about["natural_stable"][s]) for s in dict.fromkeys(scenarios)}
    parts = {}
    for scenario, costs in by_scenario.items():
        here = np.asarray(scenarios == scenario)
        parts[scenario] = _summaries(said[here], labels[here], costs, natural)
    return Accuracies(
        part=" ".join(str(about[key]) for key in ("set", "part") if key in about),
        cases=len(labels),
        instances=labels["instance"].nunique(),
        stable=int(labels["failing_step"].isna().sum()),
        robust=int(labels["robust"].fillna(False).sum()),
        fragile=int((~labels["robust"].fillna(True)).sum()),
        natural_stable=natural,
        methods=_summaries(said, labels, summaries, natural),
        by_scenario=parts,
    )


def _summaries(
    said: pd.DataFrame,
    labels: pd.DataFrame,
    costs: Sequence[MethodSummary],
    natural: Mapping[str, float],
) -> tuple[AccuracySummary, ...]:
    compared = {c.method.spec: verdicts_against_labels(said[c.method.spec], labels) for c in costs}
    best = max(compared, key=lambda spec: compared[spec]["right"].mean())
    instances = labels["instance"].to_numpy()
    robust = labels["robust"].fillna(False).to_numpy(bool)
    fragile = ~labels["robust"].fillna(True).to_numpy(bool)
    found = []
    for cost in costs:
        spec = cost.method.spec
        is_ = {name: column.to_numpy(bool) for name, column in compared[spec].items()}
        right, top = is_["right"], compared[best]["right"].to_numpy(float)
        found.append(
            AccuracySummary(
                method=cost.method,
                accuracy=share(right, instances),
                over=share(is_["over"], instances),
                under=share(is_["under"], instances),
                stable=share(is_["stable"], instances),
                within_one=share(is_["within_one"], instances),
                robust=share(right[robust], instances[robust]),
                fragile=share(right[fragile], instances[fragile]),
                natural=at_natural_prevalence(right, labels, natural),
                cpu=cost.cpu,
                wall=cost.wall,
                without_verdict=cost.without_verdict,
                behind=None if spec == best else mean(right - top, instances),
            )
        )
    return tuple(found)


def at_natural_prevalence(
    right: BoolArray, labels: pd.DataFrame, natural: Mapping[str, float]
) -> Estimate:
    """Accuracy if stable layouts were as frequent as in the whole labelled set.

    By scenario the share of stable layouts times the accuracy on them, plus the rest times the
    accuracy on the others; then the mean of the scenarios.

    Args:
        right: whether a method is right, shape (cases,).
        labels: of the same cases, :data:`steadyload.runs.labels.LABELS`.
        natural: share of stable layouts by scenario.

    Returns:
        Not a number where the cases of a scenario are all stable or all unstable, and naturally
        are not.
    """
    scenarios = labels.index.get_level_values("scenario")
    stable = labels["failing_step"].isna().to_numpy()
    strata = [f"{s} {'stable' if is_stable else 'unstable'}"
              for s, is_stable in zip(scenarios, stable, strict=True)]  # fmt: skip
    weights = {}
    for scenario in dict.fromkeys(scenarios):
        weights[f"{scenario} stable"] = natural[scenario]
        weights[f"{scenario} unstable"] = 1.0 - natural[scenario]
    return weighted_share(right, strata, weights, labels["instance"].to_numpy())

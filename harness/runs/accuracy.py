"""Accuracy of verdicts: failing steps compared with labels, case by case and as shares."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike, NDArray

from steadyload.runs.labels import item_lists
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.metrics import mean, share, weighted_share
from steadyload.statistics.placed import items_placed_by_case

BoolArray = NDArray[np.bool_]


def verdicts_against_labels(said: pd.Series, labels: pd.DataFrame) -> pd.DataFrame:
    """Comparison of one method's verdicts with the labels, case by case.

    Args:
        said: items placed safely, all of them for a stable layout, missing without a verdict; as a
            column of :func:`steadyload.statistics.metrics.outcomes`.
        labels: those of the same cases, :data:`steadyload.runs.labels.LABELS`, in the same
            order.

    Returns:
        Booleans, indexed as ``said``. ``right``: the same failing step (Eq. 5 of the paper).
        ``over``, ``under``: it is later, earlier. ``stable_or_not``: both say stable or neither
        does. ``within_one``: at most one item apart. A missing verdict is none of these.
        ``under_or_none``: it is earlier, or missing.
    """
    count = labels["item_count"].astype(int).to_numpy()
    true = items_placed_by_case(labels["failing_step"], labels["item_count"]).to_numpy()
    known = said.notna().to_numpy()
    found = said.fillna(-1).astype(int).to_numpy()
    return pd.DataFrame(
        {
            "right": known & (found == true),
            "over": known & (found > true),
            "under": known & (found < true),
            "under_or_none": ~known | (found < true),
            "stable_or_not": known & ((found == count) == (true == count)),
            "within_one": known & (np.abs(found - true) <= 1),
        },
        index=said.index,
    )


def accuracy(right: ArrayLike, lists: ArrayLike) -> Estimate:
    """Accuracy of a method: the share of cases on which it is right.

    Args:
        right: whether it is right on a case.
        lists: the item list of each case.
    """
    return share(right, lists)


def accuracy_of(said: pd.Series, labels: pd.DataFrame) -> Estimate:
    """Accuracy of one method's verdicts; arguments as :func:`verdicts_against_labels`."""
    return accuracy(verdicts_against_labels(said, labels)["right"], item_lists(labels))


def accuracy_of_seeds(right: BoolArray, lists: ArrayLike) -> Estimate:
    """Accuracy of a training: the mean over its seeds.

    Args:
        right: whether a seed is right on a case, shape (seeds, cases).
        lists: the item list of each case.
    """
    return accuracy(right[0], lists) if len(right) == 1 else mean(right.mean(axis=0), lists)


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
    return weighted_share(right, strata, weights, item_lists(labels))

"""From probabilities of steps to a layout's score, and how often that is the label's."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:  # the reader of labelled sets imports pandas, which judging does without
    from steadyload.learners.sequences import Sequences

THRESHOLD = 0.5
"""A step more likely unstable than this fails."""


def items_safe(
    probabilities: Any, counts: NDArray[np.int64], threshold: float = THRESHOLD
) -> NDArray[np.int64]:
    """Items placed safely: the first step above the threshold, or all of them, (M,).

    Args:
        probabilities: that steps are unstable, (M, T); what stands after a layout's end is not
            looked at.
        counts: items of every layout, (M,).
        threshold: see :data:`THRESHOLD`.
    """
    steps = np.arange(probabilities.shape[1])
    fails = (probabilities > threshold) & (steps < counts[:, None])
    return np.where(fails.any(axis=1), fails.argmax(axis=1), counts)


def names_the_label(
    probabilities: Any, data: Sequences, threshold: float = THRESHOLD
) -> NDArray[np.bool_]:
    """Mask of the layouts whose score is the label's, (M,)."""
    right: NDArray[np.bool_] = items_safe(probabilities, data.counts, threshold) == data.safe
    return right


def confidence(probabilities: Any, counts: NDArray[np.int64]) -> NDArray[np.float64]:
    """Probability that a learned method gives to its own score, (M,).

    A step's probability is conditional on all steps before it being stable: labels end with the
    first unstable one. So a score of k has p_k (1 - p_0) ... (1 - p_(k-1)), and a stable layout the
    product of all 1 - p_j.

    Args:
        probabilities: that steps are unstable, (M, T); values after a layout's end are not used.
        counts: items of every layout, (M,).
    """
    unstable = np.asarray(probabilities, dtype=float)
    safe = items_safe(unstable, counts)
    steps = np.arange(unstable.shape[1])
    placed = np.where(steps < safe[:, None], 1.0 - unstable, 1.0).prod(axis=1)
    last = unstable[np.arange(len(safe)), np.minimum(safe, unstable.shape[1] - 1)]
    found: NDArray[np.float64] = placed * np.where(safe < counts, last, 1.0)
    return found


def accuracies(
    probabilities: Any, data: Sequences, threshold: float = THRESHOLD
) -> dict[str, float]:
    """Share of layouts whose score is the label's: ``all``, then by scenario.

    Of several sets also by set, and by set and scenario.
    """
    right = names_the_label(probabilities, data, threshold)
    sets = [str(name) for name in dict.fromkeys(data.sets)]
    found = {"all": float(right.mean())}
    for name in sets:
        own = data.sets == name
        if len(sets) > 1:
            found[name] = float(right[own].mean())
        for scenario in dict.fromkeys(data.scenarios[own]):
            key = f"{name} {scenario}" if len(sets) > 1 else str(scenario)
            found[key] = float(right[own & (data.scenarios == scenario)].mean())
    return found

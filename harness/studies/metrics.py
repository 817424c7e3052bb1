"""Numbers with intervals. Every function is pure and deterministic."""

from __future__ import annotations

import math

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from reports.records import Estimate

_Z = 1.959963984540054
_RESAMPLES = 2000
_SEED = 0


def share(hits: int, n: int) -> Estimate:
    """A proportion with its 95 % Wilson interval; NaN when n is 0."""
    if n == 0:
        return Estimate(math.nan, math.nan, math.nan, 0)
    p, z2 = hits / n, _Z * _Z
    middle = (p + z2 / (2 * n)) / (1 + z2 / n)
    half = _Z / (1 + z2 / n) * math.sqrt(p * (1 - p) / n + z2 / (4 * n * n))
    # At 0 and n hits the formula's own end is exact; floating point may miss it by an ulp.
    low = 0.0 if hits == 0 else max(0.0, middle - half)
    high = 1.0 if hits == n else min(1.0, middle + half)
    return Estimate(p, low, high, n)


def mean(values: ArrayLike) -> Estimate:
    """A mean with its 95 % percentile-bootstrap interval (2000 resamples, fixed seed)."""
    array = np.asarray(values, dtype=float)
    n = len(array)
    if n == 0:
        return Estimate(math.nan, math.nan, math.nan, 0)
    random = np.random.default_rng(_SEED)
    block = max(1, 4_000_000 // n)
    means = np.concatenate(
        [
            array[random.integers(0, n, (min(block, _RESAMPLES - start), n))].mean(axis=1)
            for start in range(0, _RESAMPLES, block)
        ]
    )
    low, high = np.quantile(means, (0.025, 0.975))
    return Estimate(float(array.mean()), float(low), float(high), n)


def outcomes(results: pd.DataFrame) -> pd.DataFrame:
    """What each method said of each case: rows (layout, scenario), a column per method.

    A value is the failing step, the number of items for a stable layout (so that equal values mean
    equal verdicts), and missing where a method has no verdict. Of several repetitions the first
    counts.
    """
    first = results[results["repetition"] == 0]
    said = first["failing_step"].fillna(first["item_count"]).where(first["status"] == "done")
    table = first.assign(said=said).pivot(
        index=["layout", "scenario"], columns="method", values="said"
    )
    return table.astype("Int32")


def agreement(said: pd.DataFrame, first: str, second: str) -> Estimate:
    """Share of cases with the same failing step; a missing verdict agrees with nothing.

    Args:
        said: as :func:`outcomes` gives it.
        first: one of its columns.
        second: another.
    """
    return share(int((said[first] == said[second]).fillna(False).sum()), len(said))

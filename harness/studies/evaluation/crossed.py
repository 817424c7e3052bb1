"""How far accuracies would move with other packing heuristics, beside other item lists."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial
from operator import attrgetter

import numpy as np

from steadyload.methods.naming import MethodKey
from steadyload.reports.columns import column, fixed, row
from steadyload.statistics.crossed import crossed_errors
from steadyload.studies.evaluation.judged_set import JudgedSet

_PACKED = r"(H\d+)_"
"""Start of the name of a layout that one of the 160 heuristics packed: its number."""


@row
class Crossed:
    """Standard errors of a method's accuracy [points].

    Attributes:
        n: number of cases.
        by_list: over other item lists that the same heuristics pack.
        by_both: over other lists and other heuristics.
        ratio: the second over the first.
    """

    method: MethodKey = column(form=attrgetter("title"), left=True)
    n: int
    by_list: float = column("item lists", partial(fixed, digits=2))
    by_both: float = column("lists and heuristics", partial(fixed, digits=2))
    ratio: float = column("ratio", partial(fixed, digits=2))


def crossed(own: JudgedSet) -> Sequence[Crossed]:
    """Standard errors of the methods of charts; empty where a layout was packed in another way."""
    compared = own.evaluation.compared()
    cases = own.evaluation.judged.said.index.get_level_values("layout").to_series()
    heuristics = cases.str.extract(f"^{_PACKED}", expand=False)
    if heuristics.isna().any():
        return ()
    found = []
    for method in (result.own.method for result in own.few):
        right = 100.0 * np.asarray(compared.right[method], dtype=float)
        one, both = crossed_errors(right, compared.clusters, heuristics.to_numpy())
        found.append(Crossed(method, len(right), one, both, both / one if one else math.nan))
    return found

"""Whose pallets the cases are: customers', as palletising software planned them, or packers'."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from steadyload.layouts.benchmark import Benchmark
from steadyload.layouts.benchmark.real import PALLET_SOFTWARE
from steadyload.layouts.model.question import Question
from steadyload.layouts.model.scenarios import Scenario
from steadyload.reports.columns import column, percent, row
from steadyload.runs.judged import JudgedCases
from steadyload.statistics.clusters import Labels
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.metrics import share
from steadyload.studies.evaluation.rows import Failing


@row
class Origin:
    """Cases of one origin and one scenario, and how many of them there are.

    ``title``: who planned them, and with which centres of mass. ``failing``: share of cases whose
    label is a failing step.
    """

    title: str = column("cases")
    cases: int = column("n")
    layouts: int = column()
    item_lists: int = column("item lists")
    failing: Mapping[Question, Estimate] = column("fails {} %", percent)


CUSTOMERS, PACKERS = "customers' pallets", "plans of packers"
DELIVERED = f"{CUSTOMERS}, as delivered (S1)"

_CENTRES = {
    DELIVERED: Scenario.S1,
    f"{CUSTOMERS}, centres of mass moved (S2a)": Scenario.S2A,
    f"{CUSTOMERS}, centres of mass moved (S2b)": Scenario.S2B,
}


def origins(judged: JudgedCases, layouts: pd.DataFrame) -> tuple[Origin, ...]:
    """Cases of a run by origin, those of customers by scenario, too.

    An origin without a case is left out; there are none where no customer's pallet is.

    Args:
        judged: by all methods.
        layouts: of the labelled set, with their sources.
    """
    scenarios = judged.said.index.get_level_values("scenario")
    theirs = of_customers(judged.said.index, layouts)
    if not theirs.any():
        return ()
    masks = {CUSTOMERS: theirs}
    masks |= {
        title: theirs & np.asarray(scenarios == str(scenario))
        for title, scenario in _CENTRES.items()
    }
    masks[PACKERS] = ~theirs
    return tuple(_origin(judged.only(here), title) for title, here in masks.items() if here.any())


def failing_shares(
    question: Question, judged: JudgedCases, benchmark: Benchmark
) -> tuple[Failing, Failing]:
    """Shares of cases whose label of a question is a failing step, of a page and of its set."""
    cases = benchmark.select(question=question)
    natural = share(cases["failing_step"].notna(), cases["instance"])
    return (
        Failing(f"{question}, the cases of this page", _failing(judged)),
        Failing(f"{question}, the whole set", natural),
    )


def of_customers(cases: pd.Index, layouts: pd.DataFrame) -> NDArray[np.bool_]:
    """Mask of the customers' pallets among cases by layout and scenario, shape (cases,).

    Args:
        cases: of the labelled set.
        layouts: of the set, with their sources.
    """
    sources = layouts["sources"].loc[cases.get_level_values("layout")]
    return sources.map(lambda found: PALLET_SOFTWARE in found).to_numpy(bool)


def _origin(judged: JudgedCases, title: str) -> Origin:
    return Origin(
        title,
        len(judged.said),
        judged.said.index.get_level_values("layout").nunique(),
        judged.clusters.nunique(),
        {q: _failing(judged.asked(q)) for q in Question},
    )


def _failing(judged: JudgedCases) -> Estimate:
    assert judged.labels is not None, "the run is on a labelled set"
    lists: Labels = judged.clusters
    return share(judged.labels["failing_step"].notna(), lists)

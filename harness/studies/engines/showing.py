"""Results of all parts, as the page shows them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import SimpleNamespace
from typing import Any

import pandas as pd

from steadyload.layouts.benchmark.parts import LISTS, REAL
from steadyload.methods.tuned import tuned_engines
from steadyload.reports import frames
from steadyload.runs.costs import CostKind, CostSource
from steadyload.runs.provenance import provenance_lines
from steadyload.studies.engines.accuracy import accuracy_by_load
from steadyload.studies.engines.agreeing import Drawn, engine_agreement, option_effects
from steadyload.studies.engines.equal_searches import equal_searches
from steadyload.studies.engines.sources import ANSWERS, judged_by_designs, sources_of_differences
from steadyload.studies.engines.speed import Cost, Gain, SpeedCurve, speed_curves, throughput
from steadyload.studies.kit import Lab

LAYOUTS, SEED = 300, 7
"""Generated layouts for agreement and options, and their seed."""

CASES = {LISTS: 100, REAL: 20}
"""Cases a scenario of part test by labelled set; on real pallets DART takes 20 s a case."""


class Found(SimpleNamespace):
    """All that the page shows."""

    made_with: Mapping[str, str]
    curves: Sequence[SpeedCurve]
    rates: Sequence[Gain]
    costs: Sequence[Cost]


def compare(lab: Lab, limit: int | None) -> Found:
    """Measure what is missing of all parts."""
    made_with = provenance_lines()  # of the code that measures
    layouts, *cases = (min(most, limit or most) for most in (LAYOUTS, *CASES.values()))
    drawn = Drawn(layouts, SEED)
    judged = {n: judged_by_designs(lab, n, most) for n, most in zip(CASES, cases, strict=True)}
    tables, curves = sources_of_differences(judged), speed_curves(lab)
    sources = [table for table in tables if table["answer"] == next(iter(ANSWERS))]
    return Found(
        made_with={"generated layouts": f"{layouts}, seed {SEED}"} | made_with,
        layouts=layouts,
        agreement=engine_agreement(lab, drawn),
        options=option_effects(lab, drawn),
        curves=curves,
        costs=costs_of(curves),
        rates=throughput(lab),
        tables=tables,
        shares=frames.records(pd.concat([table["shares"] for table in sources])),
        depends=depends(sources),
        accuracy=accuracy_by_load(lab, cases[0]),
        equal=equal_searches(judged[LISTS]),
        tuned=tuned_engines(),
        timed=CostSource(CostKind.ONE_PROCESS).explained(),
    )


def costs_of(curves: Sequence[SpeedCurve]) -> list[Cost]:
    """All points of all curves."""
    return [
        Cost(curve, point, 100.0 * point.step / point.total, point.own)
        for curve in curves
        for point in curve.points
    ]


def depends(sources: Sequence[Mapping[str, Any]]) -> bool:
    """Whether the largest source depends on the parameter sets, for one question."""
    alone = [table["largest"] for table in sources if len(table["design"].questions) == 1]
    return len(set(alone[:2])) > 1

"""Customers' pallets on several floors: what the deck's edge and small gaps change."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping

import pandas as pd

from steadyload.reports.columns import column, percent, row
from steadyload.runs.evaluation import evaluate
from steadyload.runs.judged import load_judged
from steadyload.statistics.estimate import Estimate
from steadyload.studies.real.judging import JudgedReal


@row
class FloorRow:
    """Pallets on one floor, by the title of the method.

    ``stable``: share that it calls stable. ``changed``: those whose failing step is not that on the
    first floor; a case without a verdict on either has changed.
    """

    floor: str = column()
    pallets: int
    stable: Mapping[str, Estimate] = column("{}: stable %", percent)
    changed: Mapping[str, int] = column("{}: changed")


def floor_rows(judged: JudgedReal) -> tuple[FloorRow, ...]:
    """A row a floor; the first one is the floor as delivered.

    Raises:
        ResultsError: see :func:`steadyload.runs.judged.load_judged`.
    """
    rows: list[FloorRow] = []
    first: pd.DataFrame | None = None
    lists = judged.benchmark.layouts["instance"]
    for words, folder in judged.floors.items():
        found = load_judged(folder)
        names = found.said.index.get_level_values("layout")
        clusters = pd.Series(lists.loc[names].to_numpy(), found.said.index)
        found = dataclasses.replace(found, clusters=clusters)
        first = found.said if first is None else first
        same = (found.said == first.loc[found.said.index]).fillna(False)
        rows.append(
            FloorRow(
                floor=words,
                pallets=len(found.said),
                stable={
                    own.method.title: own.fully_stable
                    for own in evaluate(found, by_scenario=False).methods
                },
                changed={key.title: int((~same[spec]).sum()) for spec, key in found.keys.items()},
            )
        )
    return tuple(rows)

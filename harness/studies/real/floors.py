"""Customers' pallets on several floors: what the deck's edge and small gaps change."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import pandas as pd

from steadyload.methods.naming import MethodKey
from steadyload.runs.evaluation import evaluate
from steadyload.runs.judged import load_judged
from steadyload.statistics.estimate import Estimate
from steadyload.studies.real.study import JudgedReal


@dataclass(frozen=True, slots=True)
class FloorRow:
    """Shares of the pallets that methods call stable on one floor.

    Attributes:
        floor: in words.
        pallets: how many were judged.
        stable: by method.
        changed: pallets whose failing step is not that on the first floor, by spec; a case without
            a verdict on either has changed.
    """

    floor: str
    pallets: int
    stable: tuple[tuple[MethodKey, Estimate], ...]
    changed: dict[str, int]


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
                stable=tuple(
                    (row.method, row.fully_stable)
                    for row in evaluate(found, by_scenario=False).methods
                ),
                changed={str(spec): int((~same[spec]).sum()) for spec in same},
            )
        )
    return tuple(rows)

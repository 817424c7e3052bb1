"""Labelled cases that golden verdicts are of, chosen by a rule, their names kept in a file.

Of every six in turn one is unstable and near the threshold, one stable and near it, two are other
unstable and two other stable ones: so any prefix is about half unstable and a third near.
"""

import hashlib
import json
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd

from steadyload.layouts import Layout
from steadyload.layouts.benchmark import load_benchmark
from steadyload.layouts.benchmark.parts import PLANAR
from steadyload.layouts.model.question import Question

FILE = Path(__file__).parent / "verdicts" / "cases.json"
_TURN = ("near unstable", "unstable", "stable", "near stable", "unstable", "stable")
_LIMIT = 10.0
"""Of a label: centimetres, and degrees."""


class Case(NamedTuple):
    """A labelled case; robust: further judges agree on its label, so that rounding hardly can."""

    scenario: str
    layout: Layout
    robust: bool


def chosen_names(count: int, *, planar: bool) -> list[list[str]]:
    """Layout and scenario of the cases, by the rule; every geometry at most once."""
    benchmark = load_benchmark(PLANAR if planar else None)
    cases = benchmark.cases
    cases = cases[cases["split"].isin(("validation", "test")) & (cases["status"] == "done")]
    nearness = np.array([_nearness(row) for row in cases.itertuples()])
    # By hash: an order that hangs on nothing but the names.
    order = [hashlib.sha256(" ".join(k).encode()).hexdigest() for k in _keys(cases)]
    cases = cases.assign(nearness=nearness, order=order, unstable=cases["failing_step"].notna())
    near, others = cases.sort_values(["nearness", "order"]), cases.sort_values("order")
    queues = {}
    for kind in set(_TURN):
        source = near if kind.startswith("near") else others
        queues[kind] = iter(_keys(source[source["unstable"] == kind.endswith("unstable")]))
    names: list[list[str]] = []
    taken: set[str] = set()
    while len(names) < count:
        name, scenario = next(key for key in queues[_TURN[len(names) % 6]] if key[0] not in taken)
        taken.add(name)
        names.append([name, scenario])
    return names


def _keys(cases: pd.DataFrame) -> list[tuple[str, str]]:
    return list(zip(cases["layout"], cases["scenario"], strict=True))


def _nearness(row) -> float:
    """How near any step comes to the thresholds: the least |log| of the share it gets to."""
    shares = np.maximum(row.corner_last, row.angle_last) / _LIMIT
    return float(np.abs(np.log(np.maximum(shares, 1e-9))).min())


@cache
def load_cases(*, planar: bool) -> list[Case]:
    """The cases whose names are kept."""
    names = json.loads(FILE.read_text())["planar" if planar else "spatial"]
    benchmark = load_benchmark(PLANAR if planar else None)
    sure = benchmark.confidence_on(Question.WITHIN)["confidence"]
    return [
        Case(scenario, benchmark.layout(name, scenario), sure.get((name, scenario), 0.0) == 1.0)
        for name, scenario in names
    ]

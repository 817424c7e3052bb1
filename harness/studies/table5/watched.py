"""Cases that divide the methods most, to be watched side by side."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import pandas as pd

from steadyload.methods.naming import MethodKey
from steadyload.runs.definition import StudyDefinition
from steadyload.runs.evaluation import MethodEvaluation

_WATCHED = 8


@dataclass(frozen=True, slots=True)
class Watch:
    """A robustly labelled case on which methods differ, and two of them to watch side by side.

    ``label``, ``said``: failing steps or ``stable``. ``right``: the most accurate method with the
    label's failing step; ``wrong``: the most accurate one without. ``wrong_methods`` of ``methods``
    are wrong. ``part``: of the labelled set; ``directory``: the word of the set, empty for the
    large one. ``view``: link to the page that plays both loadings; empty without one.
    """

    layout: str
    scenario: str
    item_count: int
    label: str
    right: MethodKey
    wrong: MethodKey
    said: str
    wrong_methods: int
    methods: int
    part: str
    directory: str
    view: str = ""

    @property
    def name(self) -> str:
        """Name of the layout of the case, where cases are written as files."""
        return f"{self.layout}_{self.scenario}"


def watched(
    study: StudyDefinition,
    methods: Sequence[MethodEvaluation],
    said: pd.DataFrame,
    right: pd.DataFrame,
    labels: pd.DataFrame,
) -> tuple[Watch, ...]:
    """Robust cases that divide the methods most evenly, no two of one item list.

    Cases on which about half the methods are right are preferred. Cases whose label has no ensemble
    count where none is known to be robust.
    """
    order = sorted(methods, key=lambda m: -m.accuracy.value)
    robust = labels["robust"].fillna(False).to_numpy(bool)
    cases = right[robust] if robust.any() else right
    wrong = len(order) - cases.sum(axis=1)
    divided = wrong[(wrong > 0) & (wrong < len(order))]
    evenly = (divided - 0.5 * len(order)).abs().sort_values(kind="stable")
    found: dict[str, Watch] = {}
    for case in evenly.index:
        name, scenario = case
        truth, label = right.loc[case], labels.loc[case]
        answers = said.loc[case]
        good = next(m.method for m in order if truth[m.method.spec])
        others = [m.method for m in order if not truth[m.method.spec]]
        bad = next((m for m in others if not pd.isna(answers[m.spec])), None)
        if bad is None or label["instance"] in found:
            continue
        found[label["instance"]] = Watch(
            layout=name,
            scenario=scenario,
            item_count=int(label["item_count"]),
            label=_step(label["failing_step"], label["item_count"]),
            right=good,
            wrong=bad,
            said=_step(answers[bad.spec], label["item_count"]),
            wrong_methods=int(wrong.loc[case]),
            methods=len(order),
            part=str(study.benchmark),
            directory=str(study.benchmark_directory or ""),
        )
        if len(found) == _WATCHED:
            break
    return tuple(found.values())


def _step(safe: Any, item_count: int) -> str:
    """A failing step as text; ``safe`` is missing or all items for a stable layout."""
    return "stable" if pd.isna(safe) or int(safe) == int(item_count) else str(int(safe))

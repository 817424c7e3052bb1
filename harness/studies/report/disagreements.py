"""The cases of a comparison that divide the methods most."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from steadyload.layouts.model.layout import Layout
from steadyload.layouts.model.naming import box_id
from steadyload.reports.columns import markdown
from steadyload.runs.answers import LABEL, Case
from steadyload.runs.judged import JudgedCases

_MOST = 10


class Drawn(NamedTuple):
    """A case, its layout as it was judged, and the failing steps of all methods."""

    layout: str
    scenario: str
    drawn: Layout
    marked: tuple[int, ...]


def most_divided(judged: JudgedCases) -> list[Case]:
    """The cases that divide the methods most: simulations first, since they claim to be exact."""
    said, keys = judged.said, judged.keys
    simulated = [m for m, key in keys.items() if key.engine] or list(keys)
    ranking = pd.DataFrame(
        {
            "divided": said[simulated].apply(_dissent, axis=1),
            "distinct": said.nunique(axis=1, dropna=False),
        }
    )
    ranking = ranking[ranking["distinct"] > 1].sort_values(
        ["divided", "distinct"], ascending=False, kind="stable"
    )
    return list(ranking.index[:_MOST])


def disagreements(
    judged: JudgedCases, shown: Sequence[Case], layouts: Mapping[Case, Layout]
) -> dict[str, Any]:
    """Some cases on which methods differ, with all that is said of them.

    Returns:
        ``disagreements``: a row a case, with each verdict: failing step (with the id of its box, if
        it has one), ``stable`` or a status. ``drawn``: the first two of them.
    """
    keys, labels, results = judged.keys, judged.labels, judged.results
    rows = results[results["repetition"] == 0].set_index(["layout", "scenario", "method"])
    found, drawn = [], []
    for name, scenario in shown:
        layout, label = layouts[name, scenario], {}
        if labels is not None:
            label = {LABEL: _step(labels.loc[(name, scenario)]["failing_step"])}
        verdicts = {m: rows.loc[(name, scenario, m)] for m in keys}
        failing = {int(x["failing_step"]) for x in verdicts.values() if pd.notna(x["failing_step"])}
        said = label | {keys[m].title: _said(verdict, layout) for m, verdict in verdicts.items()}
        found.append(
            {"layout": markdown(name), "scenario": scenario, "items": len(layout)}
            | {f"said_of:{title}": markdown(text) for title, text in said.items()}
        )
        drawn.append(Drawn(name, scenario, layout, tuple(sorted(failing))))
    return {"disagreements": pd.DataFrame(found), "drawn": drawn[:2]}


def _dissent(answers: pd.Series) -> float:
    """Share of pairs of methods that differ in a case; a missing verdict differs from all."""
    values = answers.tolist()
    pairs = [(a, b) for i, a in enumerate(values) for b in values[i + 1 :]]
    return float(np.mean([pd.isna(a) or pd.isna(b) or a != b for a, b in pairs])) if pairs else 0.0


def _said(row: pd.Series, layout: Layout) -> str:
    if row["status"] != "done":
        return str(row["status"])
    box = None if pd.isna(row["failing_step"]) else box_id(layout.items, int(row["failing_step"]))
    return _step(row["failing_step"]) + (f" ({box})" if box else "")


def _step(failing: Any) -> str:
    return "stable" if pd.isna(failing) else str(int(failing))

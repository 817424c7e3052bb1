"""Answers of every method to every case of a run, and the layouts of those that divide them."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from steadyload.layouts.formats import read_written
from steadyload.layouts.model.layout import Layout
from steadyload.layouts.model.scenarios import Scenario, apply_scenario
from steadyload.runs.definition import AS_GIVEN
from steadyload.runs.judged import JudgedCases
from steadyload.runs.labels import labelled_layout
from steadyload.statistics.placed import items_placed_by_case

MOST_LISTED = 5000
"""Cases up to which a page lists the answers to each."""

MOST_SHOWN = 300
"""Cases whose layouts are kept for a page, those first on which methods give most answers."""

Case = tuple[str, str]
"""Layout and scenario."""


@dataclass(frozen=True, slots=True)
class Answers:
    """Answers of every method to every case.

    Attributes:
        said: cases x specs, as :func:`steadyload.statistics.metrics.outcomes` gives it; what a
            label says stands first, under :data:`LABEL`, where there are labels.
        counts: items of every case, in the same order.
        layouts: as they were judged, of cases that divide the methods.
    """

    said: pd.DataFrame
    counts: pd.Series
    layouts: Mapping[Case, Layout]


LABEL = "label"


def listed_cases(judged: JudgedCases) -> list[Case]:
    """The cases whose layouts a page shows beside the answers, those that divide methods most."""
    if len(judged.said) > MOST_LISTED:
        return []
    said = _with_labels(judged, _counts(judged))
    distinct = said.nunique(axis=1, dropna=False).sort_values(ascending=False, kind="stable")
    return list(distinct.index[distinct > 1][:MOST_SHOWN])


def answers_of(judged: JudgedCases, layouts: Mapping[Case, Layout]) -> Answers | None:
    """The answers of a run; None where there are more cases than a page lists.

    Args:
        judged: the cases and verdicts.
        layouts: of :func:`listed_cases`, and perhaps of others.
    """
    if len(judged.said) > MOST_LISTED:
        return None
    counts = _counts(judged)
    shown = {case: layouts[case] for case in listed_cases(judged)}
    return Answers(_with_labels(judged, counts), counts, shown)


def _counts(judged: JudgedCases) -> pd.Series:
    first = judged.results.drop_duplicates(["layout", "scenario"])
    counts = first.set_index(["layout", "scenario"])["item_count"]
    return counts.loc[judged.said.index].astype(int)


def _with_labels(judged: JudgedCases, counts: pd.Series) -> pd.DataFrame:
    """The answers of all methods, after the label where there is one."""
    if judged.labels is None:
        return judged.said
    label = items_placed_by_case(judged.labels["failing_step"], counts).astype("Int32")
    return pd.concat([label.rename(LABEL), judged.said], axis=1)


def judged_layouts(judged: JudgedCases, kept: Path, cases: Collection[Case]) -> dict[Case, Layout]:
    """Layouts of some cases as they were judged, with the centres of mass of their scenario.

    Args:
        judged: the cases of a run.
        kept: the file that its layouts were written to.
        cases: those wanted.
    """
    names = {name for name, _ in cases}
    layouts = {layout.name: layout for layout in read_written(kept, names)} if names else {}
    found = {}
    for name, scenario in cases:
        layout = layouts[name]
        if judged.labels is not None:
            layout = labelled_layout(layout, judged.labels.loc[(name, scenario)])
        elif scenario != AS_GIVEN:
            layout = apply_scenario(layout, Scenario(scenario), judged.manifest["study"]["seed"])
        found[name, scenario] = layout
    return found

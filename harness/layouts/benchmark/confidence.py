"""Confidence of a label: the share of an ensemble of further methods that agrees with it."""

from __future__ import annotations

from enum import StrEnum

import pandas as pd


class Reason(StrEnum):
    """The respect in which a further method differs from the one that made the labels.

    ``numerical``: the same question, solved with other numerics (tolerance, positions disturbed by
    less than any plan's precision). ``model``: other properties of the contacts. ``limits``: other
    thresholds or another time. These three are the ensemble. ``loading``: the state carried over
    from placement to placement. ``engine``: another simulator.
    """

    NUMERICAL = "numerical"
    MODEL = "model"
    LIMITS = "limits"
    LOADING = "loading"
    ENGINE = "engine"


ENSEMBLE = (Reason.NUMERICAL, Reason.MODEL, Reason.LIMITS)
"""The reasons that make up a label's confidence."""


def agrees(labels: pd.DataFrame, opinions: pd.DataFrame) -> pd.Series:
    """True for each verdict that names the label's failing step; a missing verdict does not.

    Args:
        labels: of a question, :data:`steadyload.layouts.benchmark.tables.LABELS`.
        opinions: verdicts of further methods on some of them, on the same question,
            :data:`steadyload.layouts.benchmark.tables.OPINIONS`.

    Returns:
        Booleans, indexed as ``opinions``.
    """
    steps = labels.set_index(["layout", "scenario"])["failing_step"].fillna(-1).astype(int)
    keys = pd.MultiIndex.from_frame(opinions[["layout", "scenario"]])
    label = steps.reindex(keys).to_numpy()
    said = opinions["failing_step"].fillna(-1).astype(int).to_numpy()
    return pd.Series((said == label) & (opinions["status"] == "done").to_numpy(), opinions.index)


def confidence(labels: pd.DataFrame, opinions: pd.DataFrame) -> pd.DataFrame:
    """Confidence of the labels of those cases that the ensemble has judged.

    Args:
        labels: of a question, :data:`steadyload.layouts.benchmark.tables.LABELS`.
        opinions: verdicts of further methods on some of them, on the same question,
            :data:`steadyload.layouts.benchmark.tables.OPINIONS`.

    Returns:
        Indexed by layout and scenario: ``confidence``, the share of the ensemble that agrees;
        ``numerical``, ``model``, ``limits``: the share of each part; ``robust``: all agree; missing
        where a part of the ensemble that has judged other cases has not judged this one yet. Of a
        set that a part has not judged at all, *robust* says less.
    """
    asked = opinions[opinions["reason"].isin([str(r) for r in ENSEMBLE])]
    same = asked.assign(same=agrees(labels, asked).astype(float))
    keys = ["layout", "scenario"]
    table = same.groupby([*keys, "reason"], observed=True)["same"].mean().unstack("reason")
    table = table.reindex(columns=[str(r) for r in ENSEMBLE])
    table.insert(0, "confidence", same.groupby(keys, observed=True)["same"].mean())
    whole = table[sorted(set(asked["reason"]))].notna().all(axis=1)
    table["robust"] = (table["confidence"] == 1.0).astype("boolean").where(whole)
    return table

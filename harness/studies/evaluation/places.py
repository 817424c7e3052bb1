"""Where methods err: by number and class of boxes, margin of balance, and whose plan it is."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd

from steadyload.layouts.benchmark.dataset import KEYS
from steadyload.layouts.model.question import Question
from steadyload.reports import columns, frame_points, frames
from steadyload.runs import frames as v
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.metrics import share
from steadyload.studies.evaluation.methods import Values, by_method, leaders
from steadyload.studies.evaluation.verdicts import CUSTOMERS, PACKERS, with_spans

MARGINS = (-np.inf, -20.0, -10.0, -5.0, -1.0, 0.0, 0.5, 1.0, 2.0, 5.0, np.inf)
"""Edges of bins of the margin [cm]. Below 0 a step is out of balance and fails after some time."""

CONSTANT = "the constant verdict *stable*"

ROBUST = "robust falls"
"""The falls of all origins whose label holds with the other contacts that were tried."""

CENTRES = {
    "as delivered (S1)": "S1",
    "centres of mass moved (S2a)": "S2a",
    "centres of mass moved (S2b)": "S2b",
}
"""Scenarios of customers' pallets, by what is said of their centres of mass."""


def bins_of(frame: pd.DataFrame, by: str) -> pd.DataFrame:
    """Of every bin ``cases``, ``lists``, ``middle`` number of boxes, and ``stable`` share."""
    once = v.once(frame)
    found = once.groupby(by, sort=False).agg(
        cases=("items", "size"), lists=("list", "nunique"), middle=("items", "median")
    )
    return found.assign(stable=v.share(once, "stable", [by]))


def right_in_bins(frame: pd.DataFrame, by: str, name: str, counts: pd.Series) -> pd.DataFrame:
    """Accuracy by method, with a column a bin; ``counts``: cases of the bins."""
    return frames.across(v.share(frame, "right", ["method", by]), by, name, counts)


def by_boxes(frame: pd.DataFrame, rows: pd.DataFrame, lines: Sequence[str]) -> Values:
    """Accuracy by number of boxes."""
    bins = bins_of(frame, "boxes")
    right = v.share(frame, "right", ["method", "boxes"])
    return {
        "bins": bins.assign(boxes=bins.index),
        "by_boxes": rows[["title"]].join(
            frames.across(right, "boxes", "boxes_right", bins["cases"])
        ),
        "size_curve": frame_points.points(rows.loc[list(lines)], bins["middle"], right),
    }


def by_class(frame: pd.DataFrame, rows: pd.DataFrame) -> pd.DataFrame:
    """Accuracy by class of items; empty where all cases are of one class, or none is known."""
    known = frame.dropna(subset="class").sort_values("class", kind="stable")
    bins = bins_of(known, "class")
    if len(bins) < 2:
        return pd.DataFrame()
    return rows[["title", "right"]].join(
        right_in_bins(known, "class", "class_right", bins["cases"])
    )


def costs_by_boxes(
    frame: pd.DataFrame,
    bins: pd.DataFrame,
    origins: pd.DataFrame,
    rows: pd.DataFrame,
    lines: Sequence[str],
) -> Values:
    """Costs by number of boxes, of judging with a time limit."""
    costs = by_method(frame, ["boxes", "method"]).dropna(subset="cpu")
    theirs = by_method(origins.dropna(subset="origin"), ["origin", "boxes", "method"])
    titled = rows.assign(
        title=[
            title + ("" if not isinstance(one, Estimate) else f": n^{one.value:.2f}")
            for title, one in zip(rows["title"], rows["exponent_of_all"], strict=True)
        ]
    )
    cpu = costs["cpu"].swaplevel()
    return {
        "mean_cpu": rows[["title"]].join(frames.across(cpu, "boxes", "boxes_cpu", bins["cases"])),
        "size_costs": {
            name: _with_origins(costs.loc[name], theirs, name)
            for name in bins.index
            if name in costs.index.get_level_values("boxes")
        },
        "cost_curve": frame_points.points(
            titled.loc[list(lines)], bins["middle"], costs["median"].swaplevel()
        ),
    }


def _with_origins(costs: pd.DataFrame, theirs: pd.DataFrame, boxes: str) -> pd.DataFrame:
    found = costs.copy()
    for origin in (CUSTOMERS, PACKERS):
        own = theirs[theirs.index.isin([(origin, boxes, method) for method in found.index])]
        own = own.droplevel(["origin", "boxes"])
        own = own[own["cpu"].notna()]
        if own.empty:
            continue
        for column, name, form in (
            ("cpu", "mean ms", columns.milliseconds),
            ("median", "median ms", columns.significant),
            ("ninety", "90 % ms", columns.significant),
        ):
            found[f"origin_cost:{origin}, {name}"] = own[column].map(form).reindex(found.index)
    return found


def spans(frame: pd.DataFrame) -> list[Values]:
    """By the sizes that the page answers for: cases, the best method, and the cheapest near it."""
    found = []
    for name, own in with_spans(frame).groupby("span", sort=False):
        rows = by_method(own)
        compared = rows.loc[v.comparable(own)["method"].unique()]
        found.append({"name": name, "rows": rows, "cases": len(v.once(own)), **leaders(compared),
                      "stable": stable_share(own)})  # fmt: skip
    return found


def stable_share(frame: pd.DataFrame) -> Estimate:
    """Share of cases whose label is that they are stable."""
    once = v.once(frame)
    return share(once["stable"], once["cluster"])


def origins(frame: pd.DataFrame) -> list[Values]:
    """Customers' pallets and plans of packers, each by itself."""
    found = []
    for name, own in sorted(frame.dropna(subset="origin").groupby("origin")):
        rows, bins = by_method(own), bins_of(own, "boxes")
        constant = v.once(own).assign(method=CONSTANT, right=lambda one: one["stable"])
        titles = pd.concat([rows[["title"]], pd.DataFrame({"title": [CONSTANT]}, [CONSTANT])])
        every = pd.concat([own, constant])
        found.append({
            "name": name, "rows": rows, "bins": bins.assign(boxes=bins.index, origin=name),
            "cases": len(v.once(own)), "lists": own["cluster"].nunique(),
            "stable": stable_share(own),
            "by_boxes": titles.join(
                right_in_bins(every, "boxes", "boxes_right", bins["cases"])
            ),
        })  # fmt: skip
    return found


def who_planned(by_question: Mapping[Question, pd.DataFrame]) -> pd.DataFrame:
    """Cases by origin, those of customers by scenario, too: how many, and how many fail."""
    parts = []
    for question, frame in by_question.items():
        once = v.once(frame).dropna(subset="origin")
        theirs, others = (once[once["origin"] == name] for name in (CUSTOMERS, PACKERS))
        centres = [
            theirs[theirs["scenario"] == scenario].assign(origin=f"{CUSTOMERS}, {title}")
            for title, scenario in CENTRES.items()
        ]
        parts.append(pd.concat([theirs, *centres, others]).assign(question=str(question)))
    every = pd.concat(parts)
    first = every[every["question"] == str(next(iter(by_question)))]
    found = first.groupby("origin", sort=False).agg(
        cases=("layout", "size"), layouts=("layout", "nunique"), lists=("cluster", "nunique")
    )
    fails = v.share(every.assign(fails=~every["stable"]), "fails", ["origin", "question"])
    return found.join(frames.across(fails, "question", "fails_by")).assign(origin=found.index)


def falls(frame: pd.DataFrame, rows: pd.DataFrame) -> pd.DataFrame:
    """The falls that are found, and false alarms, by origin; empty where no customer's pallet is.

    A load that falls by its label is found where a method names a failing step, whichever; one
    without a verdict is not found.
    """
    known = frame.dropna(subset="origin")
    if known.empty:
        return pd.DataFrame()
    fall, stand = known[~known["stable"]], known[known["stable"]]
    firm = fall[fall["robust"]].assign(origin=ROBUST)
    found = v.share(pd.concat([fall, firm]), "said_to_fail", ["method", "origin"])
    alarms = stand.groupby(["method", "origin"])["said_to_fail"].agg(["sum", "size"])
    told = alarms["sum"].astype(str) + " of " + alarms["size"].astype(str)
    wanted = [name for name in (CUSTOMERS, PACKERS, ROBUST) if name in set(found.index.levels[1])]
    return (
        rows[["title", "right"]]
        .join(frames.across(found, "origin", "found")[[f"found:{name}" for name in wanted]])
        .join(frames.across(told, "origin", "false_alarms"))
    )


def margins(
    frame: pd.DataFrame, margin: pd.Series, rows: pd.DataFrame, few: Sequence[str]
) -> Values:
    """False alarms and misses by the margin of balance of a step; empty where it is not known.

    A case is followed to the step where method and label differ, or to the label's failing step:
    verdicts on later steps are not known.
    ``margin``: by case, of every step up to the label's failing one [cm].
    """
    if margin.isna().any():
        return {"false_alarms": [], "misses": [], "alarms": pd.DataFrame()}
    steps = margin.explode().astype(float).rename("margin").reset_index()
    steps["step"] = steps.groupby(KEYS).cumcount()
    steps["place"] = np.digitize(steps["margin"], MARGINS[1:-1])
    own = frame[[*KEYS, "method", "expected", "said", "items", "cluster"]].merge(steps, on=KEYS)
    own = own[(own["step"] <= own["expected"]) & (own["step"] < own["items"])]
    own = own.assign(fails=own["step"] == own["expected"]).sort_values("place", kind="stable")
    counts = own.drop_duplicates([*KEYS, "step"]).groupby(["fails", "place"]).size()
    found: Values = {}
    for name, fails in (("false_alarms", False), ("misses", True)):
        came = own[(own["fails"] == fails) & (own["said"] >= own["step"])]
        wrong = (came["said"] > came["step"]) if fails else (came["said"] == came["step"])
        shares = v.share(came.assign(wrong=wrong), "wrong", ["method", "place"])
        count = counts.get(fails, pd.Series(dtype=int))
        places = {place: f"{_bin(place)} (n {n})" for place, n in count.items()}
        found[name] = frame_points.cells(shares, dict(rows.loc[list(few), "title"]), places)
        if not fails:
            below = [place for place in count.index if MARGINS[place + 1] <= 0.0]
            chosen = shares[shares.index.isin(below, level="place")]
            named = {place: f"{_range(place)} (n {count[place]})" for place in below}
            wide = frames.across(chosen.rename(index=named, level="place"), "place", "alarms")
            found["alarms"] = rows[["title"]].join(wide) if below else pd.DataFrame()
    return found


def _bin(place: int) -> str:
    low, high = MARGINS[place], MARGINS[place + 1]
    if math.isinf(low):
        return f"< {high:g}"
    return f"≥ {low:g}" if math.isinf(high) else f"{low:g}…{high:g}"


def _range(place: int) -> str:
    low, high = MARGINS[place], MARGINS[place + 1]
    return f"below {high:g}" if math.isinf(low) else f"{low:g} to {high:g}"

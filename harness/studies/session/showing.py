"""Everything that the page of loading sessions shows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import SimpleNamespace

import pandas as pd

from steadyload.methods.naming import method_key
from steadyload.methods.registry import make_method
from steadyload.reports import frames
from steadyload.runs import frames as v
from steadyload.runs.costs import CostKind, CostSource
from steadyload.statistics.growth import slope
from steadyload.studies.session.packing_gains import ITEM_COUNT, JUDGE, PACKED_BY
from steadyload.studies.session.placing import SCENES, SHOWN, MeasuredCurve, PlacementCost

_BY = ["scene", "method"]


class Found(SimpleNamespace):
    """All that the page shows."""

    made_with: Mapping[str, str]


def shown(
    curves: Sequence[MeasuredCurve], packed: pd.DataFrame, made_with: Mapping[str, str]
) -> Found:
    """Costs of placements, and gains of packing heuristics."""
    keys = {one.method: method_key(make_method(one.method)) for one in curves}
    points = pd.DataFrame(
        {
            "scene": one.scene,
            "method": one.method,
            "key": keys[one.method],
            **PlacementCost(*point)._asdict(),
        }
        for one in curves
        for point in one.points
    )
    ways = {"placement": "in a session", "whole": "the whole layout"}
    dots = points.melt([*_BY, "key", "items"], list(ways), "way", "ms").replace({"way": ways})
    gains = _gains(packed)
    first = gains.loc[gains.index[0][0]]
    return Found(
        curves=_curves(points).assign(title=lambda own: [keys[m].title for m in own["method"]]),
        points=dots.astype({"ms": object}).where(dots.notna(), None).to_dict("records"),
        tasks=[
            {"title": f"Class {number}", "gains": own}
            for number, own in gains.groupby("item_class", sort=False)
        ],
        first=first.to_dict("records"),
        nobody=first.loc[""],
        best=first.loc[v.best(first["stable"].drop(""))],
        item_lists=packed["item_list"].nunique(),
        items=ITEM_COUNT,
        heuristics=[heuristic.name for heuristic in PACKED_BY],
        judge=JUDGE,
        scenes=SCENES,
        costs=CostSource(CostKind.ONE_PROCESS).explained(),
        made_with=made_with,
    )


def _gains(packed: pd.DataFrame) -> pd.DataFrame:
    """Results by class and method that rejects; some are missing where nothing is rejected."""
    by = ["item_class", "method"]
    packed = packed.assign(
        cluster=packed["item_list"],
        bins=packed["stable"].map(len),
        cpu=1e3 * packed["seconds"] / ITEM_COUNT,
        judging=1e3 * packed["judging"] / ITEM_COUNT,
    )
    bins = packed.explode(["stable", "scores"]).astype({"stable": bool, "scores": float})
    rejecting = packed[packed["method"] != ""]
    rows, of_methods = packed.groupby(by, sort=False), rejecting.groupby(by)
    found = {
        "stable": v.share(bins, "stable", by),
        "score": v.mean(bins, "scores", by),
        "bins": rows["bins"].mean(),
        "cpu": v.mean(packed, "cpu", by),
        "left_out": rows["left_out"].sum(),
        "asked": of_methods["placements"].mean() / ITEM_COUNT,
        "rejected": of_methods["rejected"].mean() / ITEM_COUNT,
        "judging": v.mean(rejecting, "judging", by),
    }
    titles = {m: method_key(make_method(m)).title if m else "nobody" for m in packed["method"]}
    gains = pd.DataFrame(found, rows.size().index)
    return gains.assign(title=gains.index.get_level_values("method").map(titles))


def _curves(points: pd.DataFrame) -> pd.DataFrame:
    """Costs by scene and method, at some numbers of items, and their growth from 100 items on."""
    late = points[points["items"] >= 100].groupby(_BY).filter(lambda own: len(own) >= 4)
    most = points[points["items"] == SHOWN[-1]].set_index(_BY)
    some = points[points["items"].isin(SHOWN)].set_index([*_BY, "items"])["placement"]
    found = {
        "growth": v.estimates(late, _BY, lambda own: slope(own["items"], own["placement"])),
        "whole_layout": most["whole"],
        "over_session": most["whole"] / most["placement"],
    }
    rows = pd.DataFrame(found, points.groupby(_BY, sort=False).size().index)
    return rows.join(frames.across(some, "items", "ms_at")).reset_index()

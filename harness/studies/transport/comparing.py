"""Distances of limits from those of another method, and what loads hold. Accelerations in g."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from types import SimpleNamespace

import pandas as pd

from steadyload.layouts.benchmark.parts import LISTS, REAL
from steadyload.layouts.model.layout import Layout
from steadyload.methods.naming import MethodKey, method_key
from steadyload.methods.registry import make_method
from steadyload.reports.columns import row
from steadyload.runs import frames as v
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.metrics import mean, share
from steadyload.studies.transport.limits_of_loads import (
    FRICTION,
    FRICTIONS,
    REFERENCE,
    RISING,
    RUBBING,
    WHOLE,
    Load,
    LoadLimits,
    exact_at,
)
from steadyload.transport.balance import Mode
from steadyload.transport.limits import DISPLACEMENT, EXACT, HELD, RESOLUTION, ROTATION

CLOSE = 4.0 * RESOLUTION
"""Distance up to which two limits count as the same [g]: that of two that are known to half of it
each, with as much again."""

LEVELS = (0.2, 0.3, 0.5)
"""Accelerations of which it is told how many loads hold them in every direction [g]."""

_SHOWN = (0.1, 0.5, 0.9)
"""Quantiles of the weakest direction of the loads that are drawn."""


_SETS = {"small": LISTS, "real size": REAL}


@row
class Around:
    """The limit of a load by a method in one direction [degrees]."""

    method: MethodKey
    direction: float
    limit_g: float

    @property
    def basis(self) -> str:
        """Simulation, or which other method: dashes of lines show it."""
        return _basis(self.method)


@row
class Drawn:
    """A load whose limits are drawn all around it, with its weakest box."""

    load: str
    layout: Layout
    limits: Sequence[Around]
    weakest: float
    moved_item: int
    mode: Mode

    @property
    def title(self) -> str:
        """Its name and size."""
        return f"{self.load}\n{len(self.layout)} boxes"


@row
class Loads:
    """Loads of a set: how many, of them those that balance as planned, item lists, and boxes."""

    loads: int
    planned: int
    item_lists: int
    fewest_boxes: int
    most_boxes: int


class Found(SimpleNamespace):
    """All that the page shows."""

    small_loads: Loads
    real_loads: Loads
    drawn: Sequence[Drawn]
    made_with: Mapping[str, str]


def compare(found: LoadLimits, made_with: Mapping[str, str]) -> Found:
    """All numbers of the page.

    Distances are from the reference, on small loads and on those of real size that it was asked of,
    apart for loads that lean on a neighbour; and, on all loads of real size, from the first engine.
    """
    rows = found.rows.assign(
        mode=found.rows["mode"].astype(object), limit_g=found.rows["limit_g"].astype(float)
    )
    exact = rows[rows["method"] == EXACT]
    falls = exact[exact["mode"] == Mode.FALLS].groupby(["of", "load"]).size().index
    planned = ~pd.MultiIndex.from_frame(rows[["of", "load"]]).isin(falls)
    steady, leaning = rows[planned], rows[~planned]
    engines = [m for m in dict.fromkeys(rows["method"]) if "@" in m and m != REFERENCE]
    asked = [m for m in engines if m in set(rows.loc[rows["of"] == REAL, "method"])]
    first, *others = asked
    steady_real, leaning_real = (each[each["of"] == REAL] for each in (steady, leaning))
    without = rows[rows["limit_g"].isna()].groupby("method").size().to_dict()
    small_loads, real_loads = (
        _loads(found.loads[of], sum(name == of for name, _ in falls)) for of in (LISTS, REAL)
    )
    small = _distances(steady[steady["of"] == LISTS], [EXACT, RUBBING, WHOLE, *engines], REFERENCE)
    real = _distances(steady_real, [EXACT, RUBBING, WHOLE, *asked], REFERENCE)
    fewest = "Loads of real size, of those with the fewest boxes,"
    distances = {
        "Small loads that balance as planned": small,
        "Small loads that lean on a neighbour": _distances(
            leaning[leaning["of"] == LISTS], [WHOLE, *engines], REFERENCE
        ),
        f"{fewest} that balance as planned": real,
        f"{fewest} that lean on a neighbour": _distances(leaning_real, [WHOLE, *asked], REFERENCE),
    }
    kinds = [("small", LISTS, method, FRICTION) for method in (EXACT, REFERENCE, *engines)]
    kinds += [("real size", REAL, method, FRICTION) for method in (EXACT, *asked)]
    holding = _holding(steady, kinds)
    return Found(
        small_loads=small_loads,
        real_loads=real_loads,
        directions=rows["direction_deg"].nunique(),
        distances={about: own for about, own in distances.items() if len(own)},
        charted=sorted(small.to_dict("records"), key=lambda one: one["key"].engine is None),
        by_equilibrium=real.loc[EXACT],
        by_thumb=real.loc[WHOLE],
        engines=_distances(steady_real, [EXACT, RUBBING, WHOLE, *others], first),
        against=_key(first).title,
        weakest=holding.iloc[1 + len(engines) + 1],
        holding=holding,
        frictions=_holding(
            steady,
            [(of, of_set, exact_at(mu), mu) for of, of_set in _SETS.items() for mu in FRICTIONS],
        ),
        rises=_rises(rows[rows["of"] == LISTS]),
        rising=_key(RISING).title,
        without={_named(spec): n for spec, n in without.items()},
        drawn=_drawn(found.loads[REAL], steady_real, [*asked, EXACT, WHOLE]),
        made_with=made_with,
        friction=FRICTION,
        displacement_cm=DISPLACEMENT,
        rotation_deg=ROTATION,
        seconds=HELD,
        resolution_g=RESOLUTION,
        close_g=CLOSE,
    )


def _loads(loads: Sequence[Load], falling: int) -> Loads:
    boxes = [len(one.layout) for one in loads]
    lists = {one.item_list for one in loads}
    return Loads(len(loads), len(loads) - falling, len(lists), min(boxes), max(boxes))


_SIDES = {EXACT: "Equilibrium", RUBBING: "Equilibrium, side faces rub"}
"""Titles by the sides whose friction counts."""


def _key(method: str) -> MethodKey:
    if method == WHOLE:
        return MethodKey("b / h of the whole load", WHOLE, "fbs")
    key = method_key(make_method(method))
    return MethodKey(_SIDES.get(method, key.title), key.spec, key.family, key.engine)


def _named(spec: str) -> str:
    """A method within a sentence."""
    return _SIDES[spec].lower() if spec in _SIDES else spec


def _basis(key: MethodKey) -> str:
    return "simulation" if key.engine else key.title


_PLACE = ["of", "load", "item_list", "direction_deg"]


def _apart(rows: pd.DataFrame, others: pd.DataFrame) -> pd.DataFrame:
    """Rows with ``apart``: the limit less that of another row of the same place, where both have
    one. Sorted by place.
    """
    limits = others.set_index(_PLACE)["limit_g"]
    less = limits.reindex(pd.MultiIndex.from_frame(rows[_PLACE])).to_numpy()
    found = rows.assign(apart=rows["limit_g"] - less, cluster=rows["item_list"])
    return found.dropna(subset="apart").sort_values(_PLACE, kind="stable")


def _distances(rows: pd.DataFrame, methods: Sequence[str], other: str) -> pd.DataFrame:
    """By method, distances from another one, on the same loads and directions."""
    still = rows[rows["rise"] == 0.0]
    frame = _apart(still, still[still["method"] == other])
    frame = frame.assign(above=frame["apart"] > CLOSE, below=frame["apart"] < -CLOSE)
    own = [method for method in methods if method in set(frame["method"])]
    groups = frame.groupby("method")
    keys = [_key(method) for method in own]
    return pd.DataFrame(
        {
            "key": keys,
            "title": [key.title for key in keys],
            "basis": [_basis(key) for key in keys],
            "limits": groups.size(),
            "limit_apart": v.mean(frame, "apart", ["method"]),
            "clearly_above": v.share(frame, "above", ["method"]),
            "clearly_below": v.share(frame, "below", ["method"]),
            "direction_cpu": v.mean(frame[frame["method"] != WHOLE], "cpu_ms", ["method"]),
            "loads": groups["load"].nunique(),
            "differences": groups["apart"].agg(sorted),
        },
        index=own,
    )


def _holding(rows: pd.DataFrame, kinds: Iterable[tuple[str, str, str, float]]) -> pd.DataFrame:
    """Limits of loads in their weakest direction, by kind: name of the loads, their set, method and
    friction.
    """
    found = []
    for loads, of, method, friction in kinds:
        own = rows[(rows["of"] == of) & (rows["method"] == method) & (rows["rise"] == 0.0)]
        weakest = own.groupby(["load", "item_list"])["limit_g"].agg(lambda g: g.min(skipna=False))
        weakest = weakest.dropna()
        lists = weakest.index.get_level_values("item_list")
        moving = own[own["mode"].isin([Mode.SLIDES, Mode.TIPS])]
        held = {f"held:{level}": share(weakest >= level - RESOLUTION, lists) for level in LEVELS}
        tips = None if "@" in method else share(moving["mode"] == Mode.TIPS, moving["item_list"])
        about = {"friction": friction, "of_loads": loads, "title": _key(method).title}
        found.append({**about, "weakest": mean(weakest, lists), **held, "tips": tips})
    return pd.DataFrame(found)


def _rises(rows: pd.DataFrame) -> list[tuple[float, Estimate]]:
    """By rise time, the limit of :data:`RISING` less that without a rise."""
    own = rows[rows["method"] == RISING]
    rising = _apart(own[own["rise"] > 0.0], own[own["rise"] == 0.0])
    return list(v.mean(rising, "apart", ["rise"]).sort_index().items())


def _drawn(loads: Sequence[Load], rows: pd.DataFrame, methods: Sequence[str]) -> list[Drawn]:
    exact = rows[rows["method"] == EXACT].dropna(subset="limit_g")
    weakest = exact.loc[exact.groupby("load")["limit_g"].idxmin()]
    weakest = weakest.sort_values("limit_g", kind="stable")
    places = dict.fromkeys(round(q * (len(weakest) - 1)) for q in _SHOWN if len(weakest))
    still = rows[rows["rise"] == 0.0].groupby(["load", "method"])
    return [
        Drawn(
            load=loads[worst.load].name,
            layout=loads[worst.load].layout,
            limits=[
                Around(_key(method), direction, limit)
                for method in methods
                for direction, limit in _closed(still.get_group((worst.load, method)))
            ],
            weakest=float(worst.limit_g),
            moved_item=int(worst.moved_item),
            mode=Mode(worst.mode),
        )
        for worst in weakest.iloc[list(places)].itertuples()
    ]


def _closed(limits: pd.DataFrame) -> list[tuple[float, float]]:
    """Directions [degrees] with their limits [g], the first one again after a whole turn."""
    pairs = zip(limits["direction_deg"], limits["limit_g"], strict=True)
    found = [(float(direction), float(limit)) for direction, limit in pairs]
    return [*found, (found[0][0] + 360.0, found[0][1])]

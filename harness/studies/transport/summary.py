"""Distances of limits from those of another method, and what loads hold. Accelerations in g."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from steadyload.layouts.benchmark import REAL
from steadyload.layouts.benchmark.dataset import LISTS
from steadyload.methods.naming import MethodKey, method_key
from steadyload.methods.registry import make_method
from steadyload.statistics.estimate import NOTHING, Estimate
from steadyload.statistics.metrics import mean, share
from steadyload.studies.transport.study import (
    FRICTIONS,
    REFERENCE,
    RISES,
    RISING,
    RUBBING,
    WHOLE,
    Load,
    LoadLimits,
    exact_at,
)
from steadyload.transport.balance import Mode
from steadyload.transport.limits import EXACT, RESOLUTION

CLOSE = 4.0 * RESOLUTION
"""Distance up to which two limits count as the same [g]: that of two that are known to half of it
each, with as much again."""

LEVELS = (0.2, 0.3, 0.5)
"""Accelerations of which it is told how many loads hold them in every direction [g]."""

_SHOWN = (0.1, 0.5, 0.9)
"""Quantiles of the weakest direction of the loads that are drawn."""


@dataclass(frozen=True)
class Distance:
    """Limits of a method beside those of another one, on the same loads and directions.

    ``loads``: how many. ``difference``: mean of its limit less the other. ``apart``: mean distance.
    ``above``, ``below``: share of limits that are more than :data:`CLOSE` above or below the other.
    ``cpu``: CPU time a direction [ms]. ``differences``: sorted, for the chart.
    """

    method: MethodKey
    loads: int
    difference: Estimate
    apart: Estimate
    above: Estimate
    below: Estimate
    cpu: Estimate
    differences: tuple[float, ...]


@dataclass(frozen=True)
class Holding:
    """Limits of loads in their weakest direction, by a method.

    ``weakest``: mean limit there. ``share``: of the loads that hold each of :data:`LEVELS` in
    every direction. ``tips``: share of limits beyond which a box tips, of those with a mode, by
    equilibrium.
    """

    of: str
    method: MethodKey
    weakest: Estimate
    share: Mapping[float, Estimate]
    tips: Estimate


@dataclass(frozen=True)
class Rising:
    """Effect of the time in which an acceleration rises: the limit, less that without a rise."""

    method: MethodKey
    rise: float
    more: Estimate


@dataclass(frozen=True)
class Drawn:
    """A load whose limits are drawn, by method and direction, with its weakest box."""

    load: Load
    directions: tuple[float, ...]
    limits: Mapping[MethodKey, tuple[float, ...]]
    weakest: float
    moved_item: int
    mode: Mode


@dataclass(frozen=True)
class TransportSummary:
    """Results of the study.

    Attributes:
        counts: by set, loads, those that balance as planned, and item lists.
        boxes: by set, the fewest and the most boxes of a load.
        directions: how many.
        small: distances from the reference on small loads that balance as planned.
        leaning: the same on small loads that do not.
        real: distances from the reference on loads of real size that it was asked of and that
            balance as planned.
        real_leaning: the same on those that do not.
        engines: distances on all loads of real size that balance from the first engine's limits.
        against: the title of that engine's method.
        holding: by set and method.
        frictions: by set and friction, of the equilibrium.
        rises: of :data:`steadyload.studies.transport.study.RISING`, on small loads.
        without: by method, limits that have no answer.
        drawn: loads of real size.
    """

    counts: Mapping[str, tuple[int, int, int]]
    boxes: Mapping[str, tuple[int, int]]
    directions: int
    small: Sequence[Distance]
    leaning: Sequence[Distance]
    real: Sequence[Distance]
    real_leaning: Sequence[Distance]
    engines: Sequence[Distance]
    against: str
    holding: Sequence[Holding]
    frictions: Sequence[tuple[float, Holding]]
    rises: Sequence[Rising]
    without: Mapping[str, int]
    drawn: Sequence[Drawn]


def summarise(found: LoadLimits) -> TransportSummary:
    """All numbers of the page."""
    rows = found.rows.assign(
        mode=found.rows["mode"].astype(object), limit_g=found.rows["limit_g"].astype(float)
    )
    exact = rows[rows["method"] == EXACT]
    falls = exact[exact["mode"] == Mode.FALLS].groupby(["of", "load"]).size().index
    planned = ~pd.MultiIndex.from_frame(rows[["of", "load"]]).isin(falls)
    steady, leaning = rows[planned], rows[~planned]
    engines = [m for m in dict.fromkeys(rows["method"]) if "@" in m and m != REFERENCE]
    small = [EXACT, RUBBING, WHOLE, *engines]
    of_real = rows[rows["of"] == REAL]
    asked = [m for m in engines if m in set(of_real["method"])]
    first, *others = asked
    referenced = of_real.loc[of_real["method"] == REFERENCE, "load"].unique()
    return TransportSummary(
        counts={
            of: (len(own), len(own) - sum(name == of for name, _ in falls), len(_lists(own)))
            for of, own in found.loads.items()
        },
        boxes={
            of: (min(len(one.layout) for one in own), max(len(one.layout) for one in own))
            for of, own in found.loads.items()
        },
        directions=rows["direction_deg"].nunique(),
        small=_distances(steady[steady["of"] == LISTS], small, REFERENCE),
        leaning=_distances(leaning[leaning["of"] == LISTS], [WHOLE, *engines], REFERENCE),
        real=_distances(_of(steady, REAL, referenced), [EXACT, RUBBING, WHOLE, *asked], REFERENCE),
        real_leaning=_distances(_of(leaning, REAL, referenced), [WHOLE, *asked], REFERENCE),
        engines=_distances(steady[steady["of"] == REAL], [EXACT, RUBBING, WHOLE, *others], first),
        against=_key(first).title,
        holding=[
            _holding(steady, of, method)
            for of, methods in ((LISTS, [EXACT, REFERENCE, *engines]), (REAL, [EXACT, *asked]))
            for method in methods
        ],
        frictions=[
            (mu, _holding(steady, of, exact_at(mu))) for of in (LISTS, REAL) for mu in FRICTIONS
        ],
        rises=_rises(rows[rows["of"] == LISTS]),
        without=rows[rows["limit_g"].isna()].groupby("method").size().to_dict(),
        drawn=_drawn(found.loads[REAL], steady[steady["of"] == REAL], [EXACT, WHOLE, *asked]),
    )


def _lists(loads: Sequence[Load]) -> set[str]:
    return {load.item_list for load in loads}


def _of(rows: pd.DataFrame, of: str, loads: Collection[int]) -> pd.DataFrame:
    return rows[(rows["of"] == of) & rows["load"].isin(loads)]


def _key(method: str) -> MethodKey:
    if method == WHOLE:
        return MethodKey("b / h of the whole load", WHOLE, "fbs")
    key = method_key(make_method(method))
    sides = {EXACT: "Equilibrium", RUBBING: "Equilibrium, side faces rub"}
    return MethodKey(sides.get(method, key.title), key.spec, key.family, key.engine)


_PLACE = ["of", "load", "item_list", "direction_deg"]


def _wide(rows: pd.DataFrame, value: str) -> pd.DataFrame:
    still = rows[rows["rise"] == 0.0]
    return still.pivot_table(value, _PLACE, "method", aggfunc="first", dropna=False)


def _distances(rows: pd.DataFrame, methods: Sequence[str], other: str) -> list[Distance]:
    """Distances of methods from another one, where both have a limit."""
    if other not in set(rows["method"]):
        return []
    limits, times = _wide(rows, "limit_g"), _wide(rows, "cpu_ms")
    found = []
    for method in methods:
        if method not in limits:
            continue
        both = limits[[method, other]].dropna()
        lists = both.index.get_level_values("item_list").to_numpy()
        differences = (both[method] - both[other]).to_numpy()
        found.append(
            Distance(
                _key(method),
                len(both.index.droplevel(["item_list", "direction_deg"]).unique()),
                mean(differences, lists),
                mean(np.abs(differences), lists),
                share(differences > CLOSE, lists),
                share(differences < -CLOSE, lists),
                NOTHING if method == WHOLE else mean(times.loc[both.index, method], lists),
                tuple(np.sort(differences).tolist()),
            )
        )
    return found


def _holding(rows: pd.DataFrame, of: str, method: str) -> Holding:
    own = rows[(rows["of"] == of) & (rows["method"] == method) & (rows["rise"] == 0.0)]
    weakest = own.groupby(["load", "item_list"])["limit_g"].agg(lambda v: v.min(skipna=False))
    weakest = weakest.dropna()
    lists = weakest.index.get_level_values("item_list").to_numpy()
    moving = own[own["mode"].isin([Mode.SLIDES, Mode.TIPS])]
    tips = share(moving["mode"] == Mode.TIPS, moving["item_list"])
    return Holding(
        of,
        _key(method),
        mean(weakest, lists),
        {level: share(weakest >= level - RESOLUTION, lists) for level in LEVELS},
        NOTHING if "@" in method else tips,
    )


def _rises(rows: pd.DataFrame) -> list[Rising]:
    own = rows[rows["method"] == RISING]
    wide = own.pivot_table("limit_g", _PLACE, "rise", dropna=False)
    found = []
    for rise in RISES:
        if rise and rise in wide:
            both = wide[[0.0, rise]].dropna()
            lists = both.index.get_level_values("item_list").to_numpy()
            found.append(Rising(_key(RISING), rise, mean(both[rise] - both[0.0], lists)))
    return found


def _drawn(loads: Sequence[Load], rows: pd.DataFrame, methods: Sequence[str]) -> list[Drawn]:
    exact = rows[rows["method"] == EXACT]
    weakest = exact.groupby("load")["limit_g"].min().sort_values(kind="stable")
    if weakest.empty:
        return []
    places = dict.fromkeys(round(q * (len(weakest) - 1)) for q in _SHOWN)
    return [_of_load(loads, rows, methods, int(weakest.index[place])) for place in places]


def _of_load(
    loads: Sequence[Load], rows: pd.DataFrame, methods: Sequence[str], place: int
) -> Drawn:
    own = rows[(rows["load"] == place) & (rows["rise"] == 0.0)]
    by_method: dict[str, Any] = {m: own[own["method"] == m] for m in methods}
    exact = by_method[EXACT]
    worst = exact.loc[exact["limit_g"].idxmin()]
    return Drawn(
        loads[place],
        tuple(exact["direction_deg"]),
        {_key(m): tuple(one["limit_g"]) for m, one in by_method.items()},
        float(worst["limit_g"]),
        int(worst["moved_item"]),
        Mode(worst["mode"]),
    )

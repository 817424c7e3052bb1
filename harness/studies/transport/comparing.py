"""Distances of limits from those of another method, and what loads hold. Accelerations in g."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from operator import attrgetter
from types import SimpleNamespace
from typing import Any

import pandas as pd
from numpy.typing import NDArray

from steadyload.layouts.benchmark.parts import LISTS, REAL
from steadyload.layouts.model.layout import Layout
from steadyload.methods.naming import MethodKey, method_key
from steadyload.methods.registry import make_method
from steadyload.reports.columns import column, decimal, general, milliseconds, percent, row
from steadyload.statistics.estimate import NOTHING, Estimate
from steadyload.statistics.metrics import mean, share
from steadyload.studies.transport.limits_of_loads import (
    FRICTION,
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
from steadyload.transport.limits import DISPLACEMENT, EXACT, HELD, RESOLUTION, ROTATION

CLOSE = 4.0 * RESOLUTION
"""Distance up to which two limits count as the same [g]: that of two that are known to half of it
each, with as much again."""

LEVELS = (0.2, 0.3, 0.5)
"""Accelerations of which it is told how many loads hold them in every direction [g]."""

_SHOWN = (0.1, 0.5, 0.9)
"""Quantiles of the weakest direction of the loads that are drawn."""


_SETS = {LISTS: "small", REAL: "real size"}


def _g(estimate: Estimate | None) -> str:
    return decimal(estimate, 3)


class _OfMethod:
    """Base of rows of a method."""

    __slots__ = ()
    method: MethodKey

    @property
    def basis(self) -> str:
        """Simulation, or which other method: dashes of lines show it."""
        return "simulation" if self.method.engine else self.method.title


@row
class Distance(_OfMethod):
    """Limits of a method beside those of another one, on the same loads and directions.

    ``differences``: sorted, for the chart.
    """

    method: MethodKey = column(form=attrgetter("title"), left=True)
    n: int = column()
    difference: Estimate = column("less the other, g", _g, "mean of its limit less the other")
    above: Estimate = column(f"> {CLOSE:g} g above %", percent)
    below: Estimate = column(f"> {CLOSE:g} g below %", percent)
    cpu: Estimate = column("CPU ms a direction", milliseconds)
    loads: int
    differences: Sequence[float]


@row
class Holding:
    """Limits of loads in their weakest direction, by a method at a coefficient of friction."""

    friction: float = column(form=general)
    loads: str = column()
    method: MethodKey = column(form=attrgetter("title"), left=True)
    weakest: Estimate = column("weakest, g", _g)
    share: Mapping[float, Estimate] = column("{} g held %", percent)
    tips: Estimate = column("tips %", percent, "of limits with a mode, by equilibrium")


@row
class Rising:
    """Effect of the time in which an acceleration rises: the limit, less that without a rise."""

    method: MethodKey
    rise: float
    more: Estimate


@row
class Around(_OfMethod):
    """The limit of a load by a method in one direction [degrees]."""

    method: MethodKey
    direction: float
    limit_g: float


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
    engines: Sequence[Distance]
    holding: Sequence[Holding]
    frictions: Sequence[Holding]
    rises: Sequence[Rising]
    drawn: Sequence[Drawn]
    distances: Mapping[str, Sequence[Distance]]
    charted: list[Distance]
    weakest: Holding
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
    exactly = _holding(steady, REAL, EXACT)
    return Found(
        small_loads=small_loads,
        real_loads=real_loads,
        directions=rows["direction_deg"].nunique(),
        distances={about: own for about, own in distances.items() if own},
        charted=sorted(small, key=lambda one: one.method.engine is None),
        by_equilibrium=next(one for one in real if one.method.spec == EXACT),
        by_thumb=next(one for one in real if one.method.spec == WHOLE),
        engines=_distances(steady_real, [EXACT, RUBBING, WHOLE, *others], first),
        against=_key(first).title,
        weakest=exactly,
        holding=[
            *(_holding(steady, LISTS, method) for method in (EXACT, REFERENCE, *engines)),
            exactly,
            *(_holding(steady, REAL, method) for method in asked),
        ],
        frictions=[
            _holding(steady, of, exact_at(mu), mu) for of in (LISTS, REAL) for mu in FRICTIONS
        ],
        rises=_rises(rows[rows["of"] == LISTS]),
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


_PLACE = ["of", "load", "item_list", "direction_deg"]


def _wide(rows: pd.DataFrame, value: str, by: str) -> pd.DataFrame:
    return rows.pivot_table(value, _PLACE, by, aggfunc="first", dropna=False)


def _item_lists(rows: pd.DataFrame | pd.Series) -> NDArray[Any]:
    return rows.index.get_level_values("item_list").to_numpy()


def _apart(limits: pd.DataFrame, one: Any, other: Any) -> pd.Series:
    """Limits of one column less those of another, where both have one."""
    both = limits[[one, other]].dropna()
    return both[one] - both[other]


def _distances(rows: pd.DataFrame, methods: Sequence[str], other: str) -> list[Distance]:
    """Distances of methods from another one, where both have a limit."""
    if other not in set(rows["method"]):
        return []
    still = rows[rows["rise"] == 0.0]
    limits, times = _wide(still, "limit_g", "method"), _wide(still, "cpu_ms", "method")
    found = []
    for method in filter(limits.__contains__, methods):
        apart = _apart(limits, method, other)
        lists = _item_lists(apart)
        found.append(
            Distance(
                method=_key(method),
                n=len(apart),
                difference=mean(apart, lists),
                above=share(apart > CLOSE, lists),
                below=share(apart < -CLOSE, lists),
                cpu=NOTHING if method == WHOLE else mean(times.loc[apart.index, method], lists),
                loads=len(apart.index.droplevel(["item_list", "direction_deg"]).unique()),
                differences=sorted(apart.tolist()),
            )
        )
    return found


def _holding(rows: pd.DataFrame, of: str, method: str, friction: float = FRICTION) -> Holding:
    own = rows[(rows["of"] == of) & (rows["method"] == method) & (rows["rise"] == 0.0)]
    weakest = own.groupby(["load", "item_list"])["limit_g"].agg(lambda v: v.min(skipna=False))
    weakest = weakest.dropna()
    lists = _item_lists(weakest)
    moving = own[own["mode"].isin([Mode.SLIDES, Mode.TIPS])]
    tips = share(moving["mode"] == Mode.TIPS, moving["item_list"])
    return Holding(
        friction=friction,
        loads=_SETS[of],
        method=_key(method),
        weakest=mean(weakest, lists),
        share={level: share(weakest >= level - RESOLUTION, lists) for level in LEVELS},
        tips=NOTHING if "@" in method else tips,
    )


def _rises(rows: pd.DataFrame) -> list[Rising]:
    limits = _wide(rows[rows["method"] == RISING], "limit_g", "rise")
    apart = {rise: _apart(limits, rise, 0.0) for rise in RISES if rise and rise in limits}
    return [Rising(_key(RISING), rise, mean(own, _item_lists(own))) for rise, own in apart.items()]


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

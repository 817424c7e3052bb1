"""Frames with a row a method: accuracy, errors, costs, tests, and the paper's numbers beside."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import combinations
from typing import Any

import numpy as np
import pandas as pd

from steadyload.layouts.benchmark.dataset import KEYS
from steadyload.methods.naming import MethodKey
from steadyload.reports import columns, frame_points, frames
from steadyload.runs import frames as v
from steadyload.runs.evaluation import ALL
from steadyload.runs.paper import Paper
from steadyload.statistics.crossed import crossed_errors
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.growth import exponent
from steadyload.statistics.paired import LEVEL
from steadyload.studies.evaluation.judging import tunings
from steadyload.studies.evaluation.verdicts import YARDSTICK

NEAR = 0.01
"""Largest difference to the best accuracy at which a method counts as nearly as accurate."""

RATIOS = (0.01, 0.1, 1.0, 10.0, 100.0)
"""Costs of an overestimation in a table, in units of that of an underestimation."""

FEW, LINES = 10, 7
"""Methods of charts, and of line charts."""

_SHARES = ("right", "over", "under", "under_or_none", "stable_or_not", "right_stands",
           "right_robust", "right_fragile", "right_failing")  # fmt: skip

_ROUNDED = 0.0101
"""Largest difference [ms] of a mean of printed numbers to a printed mean, rounded to 0.01 ms."""

Values = dict[str, Any]


def by_method(frame: pd.DataFrame, by: Sequence[str] = ("method",)) -> pd.DataFrame:
    """Shares of cases and costs, by method and whatever else rows are grouped by.

    Returns:
        ``key``, ``title``; the shares of :func:`steadyload.runs.frames.verdicts`;
        ``lost``: cases without a verdict by status; ``cpu``, ``wall``: means [ms]; ``median``,
        ``ninety``, ``worst`` [ms]; ``brief``, ``long``: shares of all cases judged within so much;
        ``of_yardstick``, ``of_unit``: ratios of CPU times on the same cases; ``note``: the costs in
        words. What is not known is missing.
    """
    timed = frame[frame.groupby(list(by), sort=False)["cpu"].transform("count") > 0]
    taken = timed.groupby(list(by), sort=False)["cpu"]
    found = v.by_method(frame, _SHARES, by).assign(
        cpu=v.mean(frame, "cpu", by), wall=v.mean(frame, "wall", by),
        median=taken.quantile(0.5), ninety=taken.quantile(0.9), worst=taken.max(),
        brief=v.share(timed, "brief", by), long=v.share(timed, "long", by),
        of_yardstick=v.ratio(frame, "cpu", "yardstick", by),
        of_unit=v.ratio(frame, "cpu", "unit", by),
    )  # fmt: skip
    found["note"] = [_spread(*both) for both in zip(found["median"], found["ninety"], strict=True)]
    own = [key.spec == YARDSTICK for key in found["key"]]
    found.loc[own, "of_yardstick"] = found.loc[own, "cpu"].map(lambda one: "1", na_action="ignore")
    return found.copy()


def _spread(median: float, ninety: float) -> str:
    if np.isnan(median):
        return ""
    return f"median {columns.significant(median)} ms, 90 % within {columns.significant(ninety)} ms"


def every_method(frame: pd.DataFrame, natural: Mapping[str, float]) -> pd.DataFrame:
    """As :func:`by_method`, on all cases, with what is shown of these alone.

    ``behind``: accuracy minus that of the most accurate of the methods that are compared.
    ``natural``: accuracy at the share of stable layouts by scenario of the whole set, where known.
    """
    found = by_method(frame)
    compared = v.comparable(frame)
    best = v.best(found.loc[compared["method"].unique(), "right"])
    behind = compared.assign(
        behind=compared["right"].astype(float) - v.beside(compared, "right", best).astype(float)
    )
    stepping = frame[frame.groupby("method")["body_substeps"].transform("any")]
    found["behind"] = v.mean(behind[behind["method"] != best], "behind", ["method"])
    found["body_substeps"] = v.mean(stepping, "body_substeps", ["method"])
    found["fragile_errors"] = [
        _fragile(*both) for both in zip(found["right_robust"], found["right_fragile"], strict=True)
    ]
    found["natural"] = v.at_prevalence(frame, natural, ["method"]) if natural else None
    return found


def _fragile(robust: Any, fragile: Any) -> str | None:
    """Share that is on fragile labels, of a method's errors where it is known which are fragile."""
    known = [one for one in (robust, fragile) if isinstance(one, Estimate)]
    wrong = sum((1.0 - one.value) * one.n for one in known)
    if not isinstance(fragile, Estimate) or wrong == 0.0:
        return None
    part = columns.fixed(100 * (1.0 - fragile.value) * fragile.n / wrong)
    return f"{part} (of {columns.fixed(wrong)})"


def exponents(frame: pd.DataFrame) -> pd.Series:
    """Exponent of the number of boxes in the CPU time, over cases that a method calls stable."""
    stable = frame[(frame["said"] == frame["items"]).fillna(False) & (frame["cpu"] > 0.0)]
    return v.estimates(
        stable, ["method"], lambda own: exponent(own["items"], own["cpu"], own["cluster"])
    )


def cheapest_near(rows: pd.DataFrame) -> str | None:
    """The cheapest method, by the median, that is nearly as accurate as the best; None untimed."""
    right = v.values(rows["right"])
    near = rows["median"][right >= right.max() - NEAR].dropna()
    return str(near.idxmin()) if len(near) else None


def leaders(rows: pd.DataFrame) -> Values:
    """The most accurate of some methods, and the cheapest within one point of it."""
    cheap = cheapest_near(rows)
    return {
        "leading": dict(rows.loc[v.best(rows["right"])]),
        "cheap": None if cheap is None else dict(rows.loc[cheap]),
    }


def chosen_few(rows: pd.DataFrame) -> list[str]:
    """The methods of charts: the front, the yardstick, and the best of further families."""
    family = rows["key"].map(lambda key: key.family)
    wanted = (*v.front(rows["right"], rows["cpu"]), YARDSTICK)
    chosen = [method for method in dict.fromkeys(wanted) if method in rows.index]
    best = v.ranked(rows["right"])
    others = family[best][~family[best].isin(set(family[chosen]))]
    chosen = [*chosen, *others.drop_duplicates().index][:FEW]
    return [method for method in rows.index if method in chosen]


def alike(tests: pd.DataFrame, titles: Mapping[str, str]) -> Values:
    """Methods that do not differ significantly from one, and the least differences shown."""
    same = v.alike(tests)
    shown = same["shown"].dropna()
    return {
        "others": len(tests), "titles": [titles[method] for method in same.index],
        "shown": sorted({shown.min(), shown.max()}) if len(shown) else [],
    }  # fmt: skip


def against(tests: Mapping[str, pd.DataFrame], rows: pd.DataFrame, held: str) -> pd.DataFrame:
    """All methods compared with one: on all cases, and in short by scenario."""
    own = {group: v.versus(pairs, held) for group, pairs in tests.items()}
    found = own.pop(ALL)
    for group, of in own.items():
        found[f"scenario_difference:{group}"] = [
            f"{round(100 * one.difference.value, 1) + 0.0:.1f} ({columns.compact(one.corrected)})"
            for one in of.loc[found.index].itertuples()
        ]
    return found.assign(title=rows["title"])


def differences(tests: pd.DataFrame, rows: pd.DataFrame, few: Sequence[str]) -> list[Values]:
    """Cells of a matrix: differences between the few methods, the most accurate first."""
    order = v.ranked(rows.loc[few, "right"])
    two_ways, titles = v.both_ways(tests), dict(rows["title"])
    return [
        {"line": titles[one], "place": titles[other], "value": test["difference"],
         "pale": test["corrected"] >= LEVEL}
        for one in order for other in order
        if one != other for test in [two_ways.loc[(one, other)]]
    ]  # fmt: skip


def engines_and_tunings(tests: pd.DataFrame, keys: Mapping[str, MethodKey]) -> Values:
    """Pairs of simulations: of one tuning on two engines, and of two tunings on one engine."""
    tuning = tunings(keys)
    own = tests[np.array([a in tuning and b in tuning for a, b in tests.index], bool)]
    same = np.array([tuning[one] == tuning[other] for one, other in own.index], bool)
    here = np.array([keys[one].engine == keys[other].engine for one, other in own.index], bool)
    titles = {spec: key.title for spec, key in keys.items()}
    return {
        name: v.family(chosen).assign(
            first=[titles[one] for one, _ in chosen.index],
            second=[titles[other] for _, other in chosen.index],
        )
        for name, chosen in (("one_tuning", own[same & ~here]), ("one_engine", own[~same & here]))
    }


def error_costs(rows: pd.DataFrame) -> Values:
    """Cost of errors, by the ratio of the costs of both directions."""
    least = v.cheapest(rows["over"], rows["under_or_none"])
    costs = v.error_costs(rows["over"], rows["under_or_none"], RATIOS)
    told = rows[rows.index.isin([*v.front(rows["right"], rows["cpu"]), *least.index])]
    named = costs.rename(index=lambda ratio: f"{ratio:g}", level="ratio")
    positive = costs[[one.value > 0.0 for one in costs]]
    return {
        "cheapest": least.join(rows[["title", "over", "under_or_none"]]),
        "error_costs": told[["title", "right"]].join(frames.across(named, "ratio", "cost_at")),
        "error_curve": frame_points.points(
            rows[rows.index.isin(least.index)], {ratio: ratio for ratio in RATIOS}, positive
        ),
    }


def crossed(frame: pd.DataFrame, rows: pd.DataFrame, few: Sequence[str]) -> pd.DataFrame:
    """Standard errors of the few methods' accuracy [points], over other lists and heuristics.

    Empty where a layout was not packed by one of the 160 heuristics.
    """
    cases = v.once(frame)
    heuristic = cases["layout"].str.extract(r"^(H\d+)_", expand=False)
    if heuristic.isna().any():
        return pd.DataFrame()
    right = 100.0 * frame.pivot(index=KEYS, columns="method", values="right").astype(float)
    right = right.loc[pd.MultiIndex.from_frame(cases[KEYS])]
    clusters = pd.Series(cases["cluster"].to_numpy())
    both = [crossed_errors(right[m].to_numpy(), clusters, heuristic.to_numpy()) for m in few]
    return rows.loc[few, ["title", "right"]].assign(
        by_list=[one for one, _ in both],
        by_both=[other for _, other in both],
        ratio=[other / one if one else np.nan for one, other in both],
    )


def beside_paper(groups: Mapping[str, pd.DataFrame], printed: Paper) -> Values:
    """The paper's numbers beside ours, and how many pairs of its methods have its order here."""
    rows = groups[ALL]
    theirs = {m: row for m, key in rows["key"].items() if (row := printed.row_of(key))}
    found = rows.loc[list(theirs), ["title", "right", "wall", "of_yardstick"]]
    shared = printed.among(groups)
    for group in shared:
        ours = groups[group]["right"]
        found[f"paper_right:{group}"] = [
            f"{100 * row.accuracy[group]:.1f} / {100 * ours[m].value:.1f}"
            for m, row in theirs.items()
        ]
    found["paper_wall"] = [row.runtime[ALL] for row in theirs.values()]
    yard = printed.row_of(rows["key"][YARDSTICK]) if YARDSTICK in rows.index else None
    found["paper_share"] = found["paper_wall"] / yard.runtime[ALL] if yard else None
    found["of_yardstick"] = [
        columns.compact(one.value) if isinstance(one, Estimate) else one
        for one in found["of_yardstick"]
    ]
    return {
        "printed": printed,
        "named_alike": found,
        "same_order": same_order(printed, rows),
        "odd_averages": ", ".join(
            f"{one.title} {one.runtime[ALL]:.2f} (mean {one.runtime_mean:.2f})"
            for one in printed.rows
            if abs(one.runtime_mean - one.runtime[ALL]) > _ROUNDED
        ),
        "dots": [
            {"key": own.key, "title": own.title, "right": own.right,
             "printed": [row.accuracy[group]],
             "group": "all scenarios" if group == ALL else group}
            for group in shared
            for own in groups[group].itertuples()
            if (row := printed.like(own.key))
        ],
    }  # fmt: skip


def same_order(printed: Paper, rows: pd.DataFrame) -> tuple[int, int]:
    """Pairs of the paper's methods in the same order of accuracy here, and all that have one there.

    A column of the paper is compared with the mean over engines of the first of its families that
    was judged; namesakes do not count. A pair that is equal here does not count as in the same
    order.
    """
    family = rows["key"].map(lambda key: key.family)
    mean = v.values(rows["right"]).groupby(family).mean()
    first = [next((f for f in row.families if f in mean), None) for row in printed.rows]
    ours = [
        (row.accuracy[ALL], mean[family])
        for row, family in zip(printed.rows, first, strict=True)
        if family
    ]
    apart = [(one[0] - other[0], one[1] - other[1]) for one, other in combinations(ours, 2)]
    return sum(a * b > 0.0 for a, b in apart), sum(a != 0.0 for a, _ in apart)

"""Queries of frames of cases, for pages that compare methods.

A *frame of verdicts* has one row for each method and case, see :func:`verdicts`. A query such as
:func:`share` gives a series with one value for each group of rows, in the order in which groups
appear; series side by side are a frame of results, which :func:`steadyload.reports.frames.table`
shows. A missing value is no case. Intervals and tests count the clusters in column ``cluster``,
such as item lists (:mod:`steadyload.statistics.clusters`).

Three rules keep pandas from aligning rows in silence: a frame of results is made with its index
given; frames are joined by named keys; numbers of two frames are never added or compared.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import combinations
from typing import Any

import numpy as np
import pandas as pd

from steadyload.layouts.benchmark.dataset import KEYS
from steadyload.layouts.model.question import Question
from steadyload.layouts.sizes import MOST_SMALL
from steadyload.runs.costs import CPU, WALL, Costs, judging_costs
from steadyload.runs.evaluation import ALL
from steadyload.runs.judged import JudgedCases
from steadyload.runs.labels import labels_on
from steadyload.statistics import metrics, paired
from steadyload.statistics.clusters import Clusters
from steadyload.statistics.error_costs import ErrorShares, cheapest_by_ratio
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.front import undominated
from steadyload.statistics.placed import items_placed_by_case


def verdicts(judged: JudgedCases) -> pd.DataFrame:
    """All verdicts of a run, in the order of methods.

    Returns:
        ``method``, ``key``, ``title``, ``family``, ``engine``: of the method; ``gave_labels``: on
        an engine on which labels of layouts of more than :data:`.MOST_SMALL` boxes rest.
        ``layout``, ``scenario``, ``items``: of the case; ``cluster``: its item list, the stratum
        first, or without labels its layout. ``status``, ``failing_step``, ``substeps``,
        ``body_substeps``, ``cpu_total`` [s], ``wall_total`` [s]: of the verdict; ``said_to_fail``:
        the method names a step.

        Of labelled cases ``list``, ``class``, too, and ``expected``, ``said``: items placed safely
        by the label and by the method, all of them for a stable layout; ``said`` is missing without
        a verdict. ``right``: both are the same step. ``over``, ``under``: a later, an earlier one;
        ``under_or_none``: or no verdict. ``stable_or_not``: both stable, or neither. ``stable``: by
        the label. ``right_robust``, ``right_fragile``, ``right_failing``, ``right_stands``:
        ``right`` where the label is so, or by the label of the question ``stands``; else missing.
    """
    found = judged.results[judged.results["repetition"] == 0]
    keys = [judged.keys[method] for method in found["method"]]
    found = found.rename(columns={"item_count": "items"}).assign(
        key=keys,
        title=[key.title for key in keys],
        family=[key.family for key in keys],
        engine=[key.engine for key in keys],
        gave_labels=found["method"].isin(judged.on_screens),
        cluster=judged.clusters.reindex(pd.MultiIndex.from_frame(found[KEYS])).to_numpy(),
        said_to_fail=found["failing_step"].notna(),
    )
    place = {spec: number for number, spec in enumerate(judged.keys)}
    found = found.sort_values("method", key=lambda own: own.map(place), kind="stable")
    return found if judged.labels is None else _against_labels(found, judged.labels)


def _against_labels(found: pd.DataFrame, labels: pd.DataFrame) -> pd.DataFrame:
    robust = labels["robust"].astype("boolean")
    standing = labels_on(labels, Question.STANDS)
    of_case = pd.DataFrame(
        {
            "list": labels["instance"],
            "class": labels["item_class"],
            "expected": items_placed_by_case(labels["failing_step"], labels["item_count"]),
            "robust": robust.fillna(False),
            "fragile": ~robust.fillna(True),
            "stands": items_placed_by_case(
                standing["failing_step"], standing["item_count"]
            ).reindex(labels.index),
        }
    )
    found = found.merge(of_case, left_on=KEYS, right_index=True)
    done = found["status"] == "done"
    placed = items_placed_by_case(found["failing_step"], found["items"])
    right, is_stable = done & (placed == found["expected"]), found["expected"] == found["items"]
    return found.assign(
        said=placed.where(done),
        stable=is_stable,
        right=right,
        over=done & (placed > found["expected"]),
        under=done & (placed < found["expected"]),
        under_or_none=~done | (placed < found["expected"]),
        stable_or_not=done & (is_stable == (placed == found["items"])),
        right_robust=right.where(found["robust"]),
        right_fragile=right.where(found["fragile"]),
        right_failing=right.where(~is_stable),
        right_stands=(done & (placed == found["stands"])).where(found["stands"].notna()),
    )


def costed(judged: JudgedCases, costs: Costs | None = None) -> pd.DataFrame:
    """As :func:`verdicts`, with ``cpu`` and ``wall`` [ms]: missing where a case was not timed.

    Args:
        judged: the cases.
        costs: None for the times of judging.
    """
    found = (costs or judging_costs(judged.results)).milliseconds
    taken = {spec: own[[CPU, WALL]] for spec, own in found.items()}
    empty = pd.DataFrame(columns=["method", *KEYS, CPU, WALL]).set_index(["method", *KEYS])
    long = pd.concat(taken, names=["method"]) if taken else empty
    return verdicts(judged).merge(
        long.rename(columns={CPU: "cpu", WALL: "wall"}).astype(float),
        "left", left_on=["method", *KEYS], right_index=True,
    )  # fmt: skip


def comparable(frame: pd.DataFrame) -> pd.DataFrame:
    """The rows of methods that are compared: all but those whose engines gave labels of the cases.

    Where all methods are on such engines, all are compared.
    """
    own = frame[~frame["gave_labels"]]
    return own if len(own) and (frame["items"] > MOST_SMALL).any() else frame


def once(frame: pd.DataFrame) -> pd.DataFrame:
    """One row for each case."""
    return frame.drop_duplicates(KEYS)


def grouped(frame: pd.DataFrame, by: str = "scenario") -> pd.DataFrame:
    """The rows all together, then by the value of a column; column ``group`` says which.

    Where the column has one value, all together are the one group.
    """
    names = sorted(frame[by].unique())
    names = names if len(names) > 1 else []
    parts = [frame.assign(group=ALL), *(frame[frame[by] == n].assign(group=n) for n in names)]
    return pd.concat(parts, ignore_index=True)


def estimates(
    frame: pd.DataFrame, by: Sequence[str], of: Callable[[pd.DataFrame], Any]
) -> pd.Series:
    """A value of every group of rows; the base of all that follow."""
    found = {name: of(own) for name, own in frame.groupby(list(by), sort=False, observed=True)}
    names: list[Any] = list(zip(*found, strict=True)) or [[] for _ in by]
    index = pd.MultiIndex.from_arrays(names, names=list(by))
    return pd.Series(
        list(found.values()), index.get_level_values(0) if len(by) == 1 else index, dtype=object
    )


def share(frame: pd.DataFrame, column: str, by: Sequence[str]) -> pd.Series:
    """Share of the rows on which a column is true, with Wilson's interval."""
    known = frame.dropna(subset=column)
    return estimates(known, by, lambda own: metrics.share(own[column], own["cluster"]))


def mean(frame: pd.DataFrame, column: str, by: Sequence[str]) -> pd.Series:
    """Mean of a column, with a bootstrap interval."""
    known = frame.dropna(subset=column)
    return estimates(known, by, lambda own: metrics.mean(own[column].astype(float), own["cluster"]))


def ratio(frame: pd.DataFrame, above: str, below: str, by: Sequence[str]) -> pd.Series:
    """Ratio of the means of two columns, with a bootstrap interval."""
    known = frame.dropna(subset=[above, below])
    return estimates(known, by, lambda own: metrics.ratio(own[above], own[below], own["cluster"]))


def statuses(frame: pd.DataFrame, by: Sequence[str], but: Sequence[str] = ("done",)) -> pd.Series:
    """Number of rows of every status but some; missing where there is none."""
    counts = frame[~frame["status"].isin(but)].groupby([*by, "status"]).size()
    return counts.groupby(list(by)).agg(lambda own: own.droplevel(list(by)).to_dict())


def by_method(
    frame: pd.DataFrame, shares: Sequence[str], by: Sequence[str] = ("method",)
) -> pd.DataFrame:
    """By method, and whatever else rows are grouped by: ``key``, ``title``, shares, and ``lost``.

    Args:
        frame: of verdicts.
        shares: columns of truth values.
        by: what rows are grouped by.

    Returns:
        ``lost``: cases without a verdict by status.
    """
    rows = frame.groupby(list(by), sort=False)
    # The index is given: of columns with other rows pandas would make a sorted one.
    found = pd.DataFrame({n: share(frame, n, by) for n in shares}, rows.size().index)
    return found.assign(
        key=rows["key"].first(), title=rows["title"].first(), lost=statuses(frame, by)
    )


def at_prevalence(frame: pd.DataFrame, stable: Mapping[str, float], by: Sequence[str]) -> pd.Series:
    """Accuracy if stable layouts were as frequent in every scenario as ``stable`` says."""

    def one(own: pd.DataFrame) -> Estimate:
        here = {name: stable[name] for name in own["scenario"].unique()}
        weights = {f"{scenario} True": part for scenario, part in here.items()}
        weights |= {f"{scenario} False": 1.0 - part for scenario, part in here.items()}
        strata = own["scenario"] + " " + own["stable"].astype(str)
        return metrics.weighted_share(own["right"], strata, weights, own["cluster"])

    return estimates(frame, by, one)


def beside(frame: pd.DataFrame, column: str, method: str) -> pd.Series:
    """The value of one method on the case of every row; missing where it has none."""
    its = frame[frame["method"] == method].drop_duplicates(KEYS).set_index(KEYS)[column]
    return pd.Series(its.reindex(pd.MultiIndex.from_frame(frame[KEYS])).to_numpy(), frame.index)


def values(found: pd.Series) -> pd.Series:
    """The values of a series of estimates."""
    return found.map(lambda one: one.value).astype(float)


def pairs(
    frame: pd.DataFrame, column: str = "right", chosen: Iterable[tuple[str, str]] | None = None
) -> pd.DataFrame:
    """Methods two by two on the cases that both have, each minus a later one.

    Args:
        frame: one row for each method and case.
        column: of truth values.
        chosen: pairs of methods; None for all.

    Returns:
        One row for each pair, indexed by ``first`` and ``second``: ``difference``; ``p`` of the
        exact sign-flip test over clusters; ``clusters``, their number; ``corrected``, the p-value
        by Holm for all tests of the frame: they are one *family*, which supports one statement.
    """
    order = list(frame["method"].unique())
    wide = frame.pivot(index=KEYS, columns="method", values=column)[order].astype(float)
    labels = once(frame).set_index(KEYS)["cluster"].reindex(wide.index)
    groups = Clusters.of(labels, len(wide))
    # The same resamples of clusters for all methods: drawn once.
    sums = np.stack([groups.sums(wide[method].to_numpy()) for method in order], axis=1)
    drawn = np.concatenate([sums[block].sum(axis=1) for block in groups.resamples()])
    count = np.concatenate([groups.sizes[block].sum(axis=1) for block in groups.resamples()])
    place, rows = {method: number for number, method in enumerate(order)}, []
    for one, other in combinations(order, 2) if chosen is None else chosen:
        each, own = (wide[one] - wide[other]).to_numpy(), groups
        known = ~np.isnan(each)
        if known.all():
            apart = (drawn[:, place[one]] - drawn[:, place[other]]) / count
            low, high = np.quantile(apart, (0.025, 0.975)).tolist()
            found = Estimate(float(each.mean()), low, high, len(each))
        else:
            each, own = each[known], Clusters.of(labels[known], int(known.sum()))
            found = metrics.mean(each, own)
        rows.append([one, other, found, paired.sign_flip(each, own), len(groups)])
    names = ["first", "second", "difference", "p", "clusters"]
    return family(pd.DataFrame(rows, columns=names).set_index(["first", "second"]))


def family(tests: pd.DataFrame) -> pd.DataFrame:
    """Some of the tests as a family of their own: corrected for their number alone."""
    return tests.assign(corrected=paired.holm(list(tests["p"])))


def both_ways(tests: pd.DataFrame) -> pd.DataFrame:
    """The tests, and each turned: the second method minus the first."""
    turned = [Estimate(-d.value, -d.high, -d.low, d.n) for d in tests["difference"]]
    other = tests.reset_index().rename(columns={"first": "second", "second": "first"})
    other["difference"] = pd.Series(turned, other.index, dtype=object)
    return pd.concat([tests, other.set_index(["first", "second"])])


def versus(tests: pd.DataFrame, method: str) -> pd.DataFrame:
    """Of all pairs those with one method: each of the others minus it, a family of their own."""
    order = dict.fromkeys(name for pair in tests.index for name in pair)
    if tests.empty:
        return tests.droplevel("second")
    own = both_ways(tests).xs(method, level="second")
    return family(own.loc[[name for name in order if name != method]])


def alike(tests: pd.DataFrame) -> pd.DataFrame:
    """The tests without a significant difference; ``shown``: the least one that they would show."""
    found = tests[tests["corrected"] >= paired.LEVEL]
    shown = [
        paired.detectable(one.difference, one.clusters, len(tests)) for one in found.itertuples()
    ]
    return found.assign(shown=[one if 0.0 < one < math.inf else math.nan for one in shown])


def letters(tests: pd.DataFrame, accuracy: pd.Series) -> pd.Series:
    """Letters that methods share exactly where they do not differ significantly among all pairs."""
    order = ranked(accuracy)
    place = {method: str(number) for number, method in enumerate(order)}
    apart = tests.index[tests["corrected"] < paired.LEVEL]
    signs = paired.letters(list(place.values()), {(place[a], place[b]) for a, b in apart})
    return pd.Series({method: signs[place[method]] for method in order}, dtype=object)


def ranked(accuracy: pd.Series) -> list[Any]:
    """The methods by falling accuracy; equal ones in their order."""
    return list(values(accuracy).sort_values(ascending=False, kind="stable").index)


def best(accuracy: pd.Series) -> str:
    """The most accurate method; of equal ones the first."""
    return str(values(accuracy).idxmax())


def front(accuracy: pd.Series, cost: pd.Series) -> list[str]:
    """Methods than which no cheaper one is as accurate, by rising cost; those without are left out.

    Args:
        accuracy: estimates by method.
        cost: estimates by method; missing without a time.
    """
    known = cost[cost.notna()]
    timed = [method for method in accuracy.index if method in known.index]
    return undominated(timed, values(known).get, (-values(accuracy)).get)


def error_costs(over: pd.Series, under: pd.Series, ratios: Sequence[float]) -> pd.Series:
    """Expected cost of errors by method and ratio of the cost of an overestimation."""
    rows = {(m, r): ErrorShares(over[m], under[m]).cost(r) for m in over.index for r in ratios}
    index = pd.MultiIndex.from_tuples(list(rows), names=["method", "ratio"])
    return pd.Series(list(rows.values()), index, dtype=object)


def cheapest(over: pd.Series, under: pd.Series) -> pd.DataFrame:
    """The method whose errors cost least, for every ratio of costs: ``least``, ``most``."""
    found = cheapest_by_ratio({m: ErrorShares(over[m], under[m]) for m in over.index})
    names = pd.Index([one.method for one in found], name="method")
    return pd.DataFrame([[one.least, one.most] for one in found], names, ["least", "most"])

"""Verdicts on families of layouts compared with those of the reference, by family and together."""

from __future__ import annotations

from collections.abc import Mapping
from types import SimpleNamespace

import pandas as pd

from steadyload.layouts.packing.families import FAMILIES
from steadyload.methods.contract.method import Status
from steadyload.methods.registry import make_method
from steadyload.reports import frames
from steadyload.runs import frames as v
from steadyload.runs.costs import CPU, CostKind, CostSource
from steadyload.runs.judged import JudgedCases, manifest_lines
from steadyload.statistics.paired import LEVEL
from steadyload.studies.families.judging import AGAINST, LABEL, SEED, FamilyCases

ALL = "all families"


class Found(SimpleNamespace):
    """All that the page shows."""

    made_with: Mapping[str, str]


def compare(found: FamilyCases) -> Found:
    """The comparison of what was judged; families in the order of their registry."""
    label, against = (str(make_method(spec).spec) for spec in (LABEL, AGAINST))
    labelled = found.judged.labelled_by(label, found.families)
    frame = v.costed(labelled.of(spec for spec in labelled.keys if spec != label))
    place = {name: number for number, name in enumerate(FAMILIES)}
    frame = frame.sort_values("class", key=lambda own: own.map(place), kind="stable")
    is_right, others = frame["right"], v.beside(frame, "right", against)
    frame = frame.assign(
        refused=frame["status"] == Status.REFUSED,
        only_it=is_right & ~others.astype(bool),
        only_other=~is_right & others.astype(bool),
        gain=is_right.astype(float) - others.astype(float),
    )
    names = list(frame["class"].unique())
    methods = _by_method(frame, ["method"])
    methods = methods.loc[v.ranked(methods["right"])]
    each = _by_method(frame, ["class", "method"])
    other = frame[frame["method"] != against]
    tests = v.pairs(frame, chosen=[(spec, against) for spec in other["method"].unique()])
    gains = pd.DataFrame(tests.droplevel("second")[["difference", "corrected"]]).assign(
        only_it=v.share(other, "only_it", ["method"]),
        only_other=v.share(other, "only_other", ["method"]),
        title=methods["title"],
    )
    by_family = v.mean(other, "gain", ["method", "class"])
    better = v.values(gains["difference"]) > 0.0
    simulates = methods["key"].map(lambda key: key.engine is not None)
    apart = gains[(gains["corrected"] < LEVEL) & simulates[gains.index]]["title"]
    return Found(
        families=_families(found, frame, label, names),
        methods=methods,
        best=methods.iloc[0],
        each={name: each.xs(name, level="class") for name in names},
        by_family=methods[["title"]].join(frames.across(each["right"], "class", "family_right")),
        gains=gains,
        gains_by_family=gains.join(frames.across(by_family, "class", "family_gain")),
        simulations=int(simulates[gains.index].sum()),
        more=list(apart[better]),
        fewer=list(apart[~better]),
        refusing=methods.loc[v.ranked(methods["refused"])].iloc[0],
        against=labelled.keys[against],
        against_right=methods["right"][against],
        layouts=found.layouts,
        seed=SEED,
        boxes=(frame["items"].min(), frame["items"].max()),
        label=label,
        label_seconds=_cpu(found.judged, label)["cpu"].sum() / 1e3,
        left_out=found.left_out,
        costs=CostSource(CostKind.JUDGING).explained(),
        made_with=manifest_lines(found.judged) | {"seed": str(SEED)},
    )


def _by_method(frame: pd.DataFrame, by: list[str]) -> pd.DataFrame:
    but = [str(Status.DONE), str(Status.REFUSED)]
    return v.by_method(frame, ["right", "over", "under", "refused"], by).assign(
        cpu=v.mean(frame, "cpu", by), lost=v.statuses(frame, by, but)
    )


def _cpu(judged: JudgedCases, spec: str) -> pd.DataFrame:
    """A row a case, with the CPU time of a method [ms]."""
    own = judged.results[judged.results["method"] == spec]
    return own.assign(cpu=1e3 * own[CPU], cluster=own["layout"])


def _families(
    found: FamilyCases, frame: pd.DataFrame, label: str, names: list[str]
) -> pd.DataFrame:
    """A row a family, all together last: its layouts, and their labels."""
    cases, costs = v.once(frame), _cpu(found.judged, label)
    cases = pd.concat([cases.assign(family=cases["class"]), cases.assign(family=ALL)])
    costs = pd.concat(
        [costs.assign(family=costs["layout"].map(found.families)), costs.assign(family=ALL)]
    )
    return pd.DataFrame(
        {
            "family": [*names, ALL],
            "about": [*(FAMILIES[name].about for name in names), ""],
            "stable": v.share(cases, "stable", ["family"]),
            "label_cpu": v.mean(costs, "cpu", ["family"]),
            "unlabelled": v.statuses(costs, ["family"]),
        },
        index=[*names, ALL],
    )

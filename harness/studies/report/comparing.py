"""Methods compared on the cases of a run: accuracy, cost, agreement, and what engines honoured."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from itertools import permutations
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd

from steadyload.engines.world import SETTINGS
from steadyload.methods.naming import MethodKey
from steadyload.methods.simulation.simulation_parameters import COMMON, tuning
from steadyload.reports import frame_points, frames
from steadyload.reports.columns import names, significant
from steadyload.runs import frames as v
from steadyload.runs.answers import answers_of, judged_layouts, listed_cases
from steadyload.runs.costs import PHASES, CostKind, CostSource, judging_costs
from steadyload.runs.evaluation import ALL, labelled_part
from steadyload.runs.judged import JudgedCases, load_judged, manifest_lines
from steadyload.runs.results import kept_layouts
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.metrics import agreement, mean, same
from steadyload.studies.agreement_section import answer_chart
from steadyload.studies.report.disagreements import Drawn, disagreements, most_divided

NEAR = 0.02
"""Largest difference to the best accuracy at which a method counts as nearly as accurate."""

_SHARES = ("right", "over", "under", "stable_or_not", "within_one", "right_stands", "right_robust",
           "right_fragile")  # fmt: skip
"""Of labelled cases."""


class Found(SimpleNamespace):
    """All that the page shows."""

    made_with: Mapping[str, str]
    drawn: Sequence[Drawn]


def compare(directory: str | Path) -> Found:
    """The comparison that a run folder holds."""
    directory = Path(directory)
    judged = load_judged(directory)
    manifest, said, keys = judged.manifest, judged.said, judged.keys
    divided = most_divided(judged)
    layouts = judged_layouts(
        judged, kept_layouts(directory, manifest), {*listed_cases(judged), *divided}
    )
    frame = v.costed(judged)
    frame["fully_stable"] = (frame["score"] == 1.0).fillna(False)
    parts = dict(list(v.grouped(frame).groupby("group", sort=False)))
    groups = {group: _by_method(judged, cases, str(group)) for group, cases in parts.items()}
    rows, uses = groups[ALL], _settings(judged)
    titles = {spec: key.title for spec, key in keys.items()}
    agree = pd.Series(
        {
            (a, b): agreement(said, a, b, judged.clusters) for a, b in permutations(keys, 2)
        },
        index=pd.MultiIndex.from_tuples(permutations(keys, 2), names=["method", "other"]),
        dtype=object,
    )  # fmt: skip
    return Found(
        title=manifest["study"]["name"],
        cases=len(said),
        layouts=judged.results["layout"].nunique(),
        scenarios=judged.scenarios,
        rows=rows,
        groups={group: own for group, own in groups.items() if group != ALL},
        headers={group: _headers(cases) for group, cases in parts.items()},
        charted={
            "all scenarios" if group == ALL else group: frames.records(own)
            for group, own in groups.items()
        },
        agreeing=frames.records(rows, rows.index[rows["agreement"].notna()]),
        phases=_phases(judged, rows),
        costs=CostSource(CostKind.JUDGING).explained(),
        labelled=None if judged.labels is None else labelled_part(judged),
        **({} if judged.labels is None else _leading(frame, rows)),
        agree=_agree(agree, titles),
        cells=frame_points.cells(agree, titles, titles),
        answer_chart=answer_chart(titles, answers_of(judged, layouts)),
        tunings=list(_same_tunings(judged, rows, uses, agree)),
        uses=uses.assign(settings=uses["settings"].map(_listed)),
        **disagreements(judged, divided, layouts),
        disputed=int((said.nunique(axis=1, dropna=False) > 1).sum()),
        missing_rows=manifest["rows"] - judged.rows,
        missing_methods=[m for m in manifest["study"]["methods"] if m not in keys],
        refused=manifest.get("refused", {}).get("count", 0),
        envelopes=_envelopes(manifest, keys),
        made_with=manifest_lines(judged),
    )


def _by_method(judged: JudgedCases, frame: pd.DataFrame, group: str) -> pd.DataFrame:
    """A row a method: what it says, its costs and agreement, and against labels its accuracy.

    Returns:
        ``score``: mean of the cases with a verdict; ``fully_stable``: share of layouts that the
        method calls stable; ``agreement``: mean share of equal failing steps with simulations on
        other engines, missing where there is none.
    """
    by = ["method"]
    if judged.labels is None:
        found = v.by_method(frame, ())
    else:
        one = (frame["said"] - frame["expected"]).abs() <= 1
        natural = labelled_part(judged).natural_stable
        found = v.by_method(frame.assign(within_one=one.fillna(False)), _SHARES).assign(
            natural=v.at_prevalence(frame, natural, by) if natural else None
        )
    return found.assign(
        cpu=v.mean(frame, "cpu", by),
        wall=v.mean(frame, "wall", by),
        score=v.mean(frame[frame["status"] == "done"], "score", by),
        fully_stable=v.share(frame, "fully_stable", by),
        agreement=pd.Series(_mean_agreement(judged, group), dtype=object),
    )


def _headers(frame: pd.DataFrame) -> dict[str, str]:
    """Headers of accuracies that are of some of the cases."""
    cases = v.once(frame)
    known = [kind for kind in ("robust", "fragile") if kind in cases]
    return {f"right_{kind}": f"{kind} % (n {cases[kind].sum()})" for kind in known}


def _mean_agreement(judged: JudgedCases, group: str) -> dict[str, Estimate]:
    """Of each method, the mean share of equal failing steps with simulations on other engines."""
    scenarios = judged.said.index.get_level_values("scenario")
    said = judged.said if group == ALL else judged.said[scenarios == group]
    clusters, found = judged.clusters.loc[said.index], {}
    for spec, key in judged.keys.items():
        others = [m for m, k in judged.keys.items() if k.engine and k.engine != key.engine]
        if others:
            equal = np.stack([same(said, spec, other) for other in others])
            found[spec] = mean(equal.mean(axis=0), clusters)
    return found


def _leading(frame: pd.DataFrame, rows: pd.DataFrame) -> dict[str, Any]:
    """The most accurate method, the cheapest near it, and how far others are behind it."""
    compared = v.comparable(frame)
    own = rows.loc[compared["method"].unique()]
    best, right = v.best(own["right"]), v.values(own["right"])
    near = own["cpu"][right >= right.max() - NEAR].dropna()
    cheapest = v.values(near).idxmin() if len(near) else best
    difference = compared["right"].astype(float) - v.beside(compared, "right", best).astype(float)
    others = compared.assign(behind=difference)[compared["method"] != best]
    behind = v.mean(others, "behind", ["method"])
    return {
        "leading": dict(own.loc[best]),
        "cheapest": None if cheapest == best else dict(own.loc[cheapest]),
        "behind": behind.to_frame("behind").assign(title=rows["title"]),
    }


def _agree(agree: pd.Series, titles: Mapping[str, str]) -> pd.DataFrame:
    """The matrix of agreement: a row a method, and a column a method."""
    found = pd.DataFrame({"title": titles})
    for spec, title in titles.items():
        if len(titles) > 1:
            found[f"agrees:{title}"] = agree.xs(spec, level="other")
    return found


def _phases(judged: JudgedCases, rows: pd.DataFrame) -> pd.DataFrame:
    """Mean CPU time by phase [ms] of methods with a time; what is in no phase is ``other``."""
    taken = judging_costs(judged.results).milliseconds
    times = pd.DataFrame({spec: taken[spec][list(PHASES)].mean() for spec in rows.index}).T
    times.columns = pd.Index(["build", "step_ms", "read"])
    other = v.values(rows["cpu"]) - times.sum(axis=1)
    return rows[["title", "cpu", "wall"]].join(times).assign(other=other)


def _envelopes(manifest: Mapping[str, Any], keys: Mapping[str, MethodKey]) -> Any:
    """Cases beyond envelopes, and methods of whose engine nothing was measured.

    None for runs that were made before envelopes were recorded.
    """
    found = [(keys[m].title, e) for m, e in manifest.get("envelope", {}).items() if m in keys]
    beyond = [
        {
            "title": title,
            "beyond": f"{entry['cases']} of {entry.get('of', 0)}",
            "by": f"{reason['limit']} ({reason['cases']})",
            "example": f"{reason['example']}: {reason['sentence']}",
        }
        for title, entry in found
        if entry.get("cases")
        for reason in entry.get("reasons", ())
    ]
    unmeasured = [title for title, e in found if e.get("cases") is None]
    return {"beyond": pd.DataFrame(beyond), "unmeasured": unmeasured} if found else None


def _settings(judged: JudgedCases) -> pd.DataFrame:
    """A row a simulation: settings that its engine honours, emulates or ignores, and all of them
    that ask for something.
    """
    first = judged.results.drop_duplicates("method").set_index("method")["parameters"]
    found = {}
    for spec, key in judged.keys.items():
        if key.engine:
            parameters, (ignored, emulated) = json.loads(first[spec]), judged.not_honoured[spec]
            asked = [
                n for n, value in parameters.items() if n in SETTINGS and value not in (None, 0)
            ]
            found[spec] = {
                "title": key.title,
                "honoured": names(n for n in asked if n not in ignored and n not in emulated),
                "emulated": names(emulated),
                "ignored": names(ignored),
                "settings": _shown(parameters),
            }
    return pd.DataFrame(
        found.values(), list(found), ["title", "honoured", "emulated", "ignored", "settings"]
    )


def _listed(settings: Mapping[str, str]) -> str:
    return ", ".join(f"{name} {value}" for name, value in settings.items())


def _shown(parameters: Mapping[str, Any]) -> dict[str, str]:
    """Parameters as text, without those that have no effect."""
    skip: tuple[object, ...] = (None, [], 0, 0.0, "all")
    return {
        name: f"{value:g}" if isinstance(value, int | float) else str(value)
        for name, value in parameters.items()
        if value not in skip
    }


def _same_tunings(
    judged: JudgedCases, rows: pd.DataFrame, uses: pd.DataFrame, agree: pd.Series
) -> Iterator[dict[str, Any]]:
    """Parameter sets on several engines, with the settings that all engines have."""
    simulated = judged.results.dropna(subset=["engine"])
    # Parameters of a single engine are left out of those that engines have in common.
    common = simulated["parameters"].map(json.loads).map(tuning)
    for _, group in simulated.groupby([simulated["method_name"], common], sort=False):
        specs = [spec for spec in judged.keys if spec in set(group["method"])]
        engines = {spec: str(judged.keys[spec].engine) for spec in specs}
        if len(set(engines.values())) < 2:
            continue
        found = rows.loc[specs].assign(engine=pd.Series(engines)).join(
            uses[["emulated", "ignored"]]
        )  # fmt: skip
        for other, engine in engines.items():
            found[f"agrees_with:{engine}"] = [agree.get((spec, other)) for spec in specs]
        phases = _phases(judged, rows.loc[specs])[["build", "step_ms", "read"]]
        found["phases"] = [" / ".join(map(significant, own)) for own in phases.to_numpy()]
        settings = uses["settings"][specs[0]]
        yield {
            "title": rows["title"][specs[0]].partition(" @ ")[0],
            "settings": _listed({k: of for k, of in settings.items() if k in COMMON}),
            "rows": found,
        }

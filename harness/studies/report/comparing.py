"""Methods compared on the cases of a run: accuracy, cost, agreement, and what engines honoured."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from steadyload.engines.world import SETTINGS
from steadyload.methods.naming import MethodKey
from steadyload.reports.columns import cell, column, names, percent, row, significant
from steadyload.runs.agreement import COMMON, AgreementMatrix, agreement_matrix, tuning
from steadyload.runs.answers import judged_layouts, listed_cases
from steadyload.runs.evaluation import ALL, Evaluation, MethodEvaluation, cheapest_near, evaluate
from steadyload.runs.judged import JudgedCases, load_judged, manifest_lines
from steadyload.runs.results import kept_layouts
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.metrics import agreement, mean, same
from steadyload.studies.report.disagreements import Disagreement, disagreements, most_divided

NEAR = 0.02
"""Largest difference to the best accuracy at which a method counts as nearly as accurate."""


@row
class Scored:
    """A method, and the mean share of equal failing steps with simulations on other engines; None
    where there is none to compare with.
    """

    own: MethodEvaluation
    agreement: Estimate | None = column("agreement with simulations %", percent)


def _listed(settings: Mapping[str, str]) -> str:
    return ", ".join(f"{name} {value}" for name, value in settings.items())


@row
class SettingsUse:
    """Settings of one method that its engine honours, emulates or ignores."""

    method: MethodKey = column(form=lambda method: method.title, left=True)
    honoured: Sequence[str] = column(form=names, left=True)
    emulated: Sequence[str] = column(form=names, left=True)
    ignored: Sequence[str] = column(form=names, left=True)
    settings: Mapping[str, str] = column(
        "all parameters that ask for something", _listed, left=True
    )


def _phases(taken: Sequence[float] | None) -> str:
    return cell(taken and " / ".join(map(significant, taken)))


@row
class OnEngine:
    """A parameter set on one engine: its results, its agreement with each engine (None with its
    own), and the settings that the engine does not honour.
    """

    own: MethodEvaluation
    engine: str = column()
    agrees: Mapping[str, Estimate | None] = column("agrees with {} %", percent)
    phases: Sequence[float] | None = column("build / step / read ms", _phases)
    emulated: Sequence[str] = column(form=names)
    ignored: Sequence[str] = column(form=names)


@row
class SameTuning:
    """One parameter set on several engines; ``settings`` are those that all engines have."""

    title: str
    settings: str
    rows: Sequence[OnEngine]


@row
class Beyond:
    """Cases of a study beyond one limit of the envelope of a method's engine."""

    method: str = column()
    cases: str = column("cases beyond", left=True)
    by: str = column("by (cases)")
    example: str = column("for example")


@row
class Envelopes:
    """Cases beyond envelopes, and methods of whose engine nothing was measured."""

    beyond: Sequence[Beyond]
    unmeasured: Sequence[str]


@row
class Found:
    """Everything that a study's page shows.

    ``disputed``: cases with more than one answer. ``envelopes``: None for runs that were made
    before envelopes were recorded. ``missing_rows``, ``missing_methods``: of a run that is not
    finished. ``refused``: layouts of the files that are not valid.
    """

    title: str
    cases: int
    layouts: int
    scenarios: Sequence[str]
    evaluation: Evaluation
    scores: Mapping[str, Sequence[Scored]]
    matrix: AgreementMatrix
    tunings: Sequence[SameTuning]
    uses: Sequence[SettingsUse]
    disagreements: Sequence[Disagreement]
    disputed: int
    missing_rows: int
    missing_methods: Sequence[str]
    refused: int
    envelopes: Envelopes | None
    made_with: Mapping[str, str]

    @property
    def cheapest(self) -> MethodEvaluation | None:
        """The cheapest method that is nearly as accurate as the best."""
        return cheapest_near(self.evaluation.comparable, NEAR)

    @property
    def answer_chart(self) -> Any:
        """The chart of the answers behind the matrix, for the HTML page; None without them."""
        from steadyload.studies.agreement_section import answer_chart

        return answer_chart(self.matrix)


def compare(directory: str | Path) -> Found:
    """The comparison that a run folder holds.

    Raises:
        ResultsError: not a run folder, or no case in it has been judged by all methods yet.
    """
    directory = Path(directory)
    judged = load_judged(directory)
    manifest, results, said, keys = judged.manifest, judged.results, judged.said, judged.keys
    kept, divided = kept_layouts(directory, manifest), most_divided(judged)
    layouts = judged_layouts(judged, kept, {*listed_cases(judged), *divided})
    evaluation = evaluate(judged)
    first = results.drop_duplicates("method").set_index("method")["parameters"]
    engines = {m: key for m, key in keys.items() if key.engine}
    uses = tuple(
        _settings_use(key, first[m], *judged.not_honoured[m]) for m, key in engines.items()
    )
    return Found(
        title=manifest["study"]["name"],
        cases=len(said),
        layouts=results["layout"].nunique(),
        scenarios=judged.scenarios,
        evaluation=evaluation,
        scores={
            group: [
                Scored(own, agreed)
                for own, agreed in zip(
                    evaluation.rows[group], _mean_agreement(judged, group), strict=True
                )
            ]
            for group in evaluation.groups
        },
        matrix=agreement_matrix(judged, layouts),
        tunings=list(_same_tunings(judged, evaluation, uses)),
        uses=uses,
        disagreements=disagreements(judged, divided, layouts),
        disputed=int((said.nunique(axis=1, dropna=False) > 1).sum()),
        missing_rows=manifest["rows"] - judged.rows,
        missing_methods=[m for m in manifest["study"]["methods"] if m not in keys],
        refused=manifest.get("refused", {}).get("count", 0),
        envelopes=_envelopes(manifest, keys),
        made_with=manifest_lines(judged),
    )


def _envelopes(manifest: Mapping[str, Any], keys: Mapping[str, MethodKey]) -> Envelopes | None:
    found = [(keys[m].title, e) for m, e in manifest.get("envelope", {}).items() if m in keys]
    if not found:
        return None
    beyond = [
        Beyond(
            title,
            f"{entry['cases']} of {entry.get('of', 0)}",
            f"{reason['limit']} ({reason['cases']})",
            f"{reason['example']}: {reason['sentence']}",
        )
        for title, entry in found
        if entry.get("cases")
        for reason in entry.get("reasons", ())
    ]
    return Envelopes(beyond, [title for title, e in found if e.get("cases") is None])


def _mean_agreement(judged: JudgedCases, group: str) -> Iterator[Estimate | None]:
    """Of each method, the mean share of equal failing steps with simulations on other engines.

    None without such simulations.
    """
    scenarios = judged.said.index.get_level_values("scenario")
    said = judged.said if group == ALL else judged.said[scenarios == group]
    clusters = judged.clusters.loc[said.index]
    for spec, key in judged.keys.items():
        others = [m for m, k in judged.keys.items() if k.engine and k.engine != key.engine]
        equal = [same(said, spec, other) for other in others]
        yield mean(np.stack(equal).mean(axis=0), clusters) if equal else None


def _settings_use(
    key: MethodKey, parameters_text: str, ignored: Iterable[str], emulated: Iterable[str]
) -> SettingsUse:
    parameters, ignored, emulated = json.loads(parameters_text), tuple(ignored), tuple(emulated)
    asked = [
        name
        for name, value in parameters.items()
        if name in SETTINGS and value not in (None, 0, 0.0)
    ]
    return SettingsUse(
        method=key,
        honoured=tuple(n for n in asked if n not in ignored and n not in emulated),
        emulated=emulated,
        ignored=ignored,
        settings=_shown(parameters),
    )


def _shown(parameters: Mapping[str, Any]) -> dict[str, str]:
    """Parameters as text, without those that have no effect."""
    skip: tuple[object, ...] = (None, [], 0, 0.0, "all")
    return {
        name: f"{value:g}" if isinstance(value, int | float) else str(value)
        for name, value in parameters.items()
        if value not in skip
    }


def _same_tunings(
    judged: JudgedCases, evaluation: Evaluation, uses: Sequence[SettingsUse]
) -> Iterator[SameTuning]:
    simulated = judged.results.dropna(subset=["engine"])
    used = {use.method.spec: use for use in uses}
    # Parameters of a single engine are left out of those that engines have in common.
    common = simulated["parameters"].map(json.loads).map(tuning)
    for _, group in simulated.groupby([simulated["method_name"], common], sort=False):
        specs = set(group["method"])
        rows = [own for own in evaluation.methods if own.method.spec in specs]
        if len({own.method.engine for own in rows}) < 2:
            continue
        settings = used[rows[0].method.spec].settings
        yield SameTuning(
            title=rows[0].method.title.partition(" @ ")[0],
            settings=_listed({k: v for k, v in settings.items() if k in COMMON}),
            rows=[_on_engine(judged, own, rows, used[own.method.spec]) for own in rows],
        )


def _on_engine(
    judged: JudgedCases, own: MethodEvaluation, rows: Sequence[MethodEvaluation], use: SettingsUse
) -> OnEngine:
    spec, phases = own.method.spec, own.phases
    return OnEngine(
        own=own,
        engine=str(own.method.engine),
        agrees={str(other.method.engine): None for other in rows}
        | {
            str(other.method.engine): agreement(
                judged.said, spec, other.method.spec, judged.clusters
            )
            for other in rows
            if other is not own
        },
        phases=None if phases is None else (phases.build, phases.step, phases.read),
        emulated=use.emulated,
        ignored=use.ignored,
    )

"""Records for a study's page, and their computation from a run folder."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from steadyload.engines.world import SETTINGS
from steadyload.methods.naming import MethodKey
from steadyload.runs.agreement import COMMON, AgreementMatrix, agreement_matrix, tuning
from steadyload.runs.answers import judged_layouts, listed_cases
from steadyload.runs.evaluation import ALL, Evaluation, MethodEvaluation, evaluate
from steadyload.runs.judged import JudgedCases, load_judged, manifest_lines
from steadyload.runs.results import LAYOUTS_FILE, kept_file
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.metrics import agreement, mean, same
from steadyload.studies.comparison.disagreements import Disagreement, disagreements, most_divided


@dataclass(frozen=True, slots=True)
class BeyondEnvelope:
    """Number of cases of a study beyond the envelope of the engine of a method.

    ``cases`` is None where nothing was measured. ``reasons``, the most frequent first: the limit
    that is exceeded, the number of cases, and of the first of them its layout and the excess.
    """

    method: str
    cases: int | None
    of: int
    reasons: tuple[tuple[str, int, str, str], ...] = ()


@dataclass(frozen=True, slots=True)
class SettingsUse:
    """Settings of one method that its engine honours, emulates or ignores."""

    method: MethodKey
    settings: Mapping[str, str]
    honoured: tuple[str, ...]
    emulated: tuple[str, ...]
    ignored: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class SameTuning:
    """One parameter set on several engines.

    ``agreement`` maps (engine, engine) to the share of equal failing steps.
    """

    title: str
    settings: Mapping[str, str]
    rows: tuple[MethodEvaluation, ...]
    uses: tuple[SettingsUse, ...]
    agreement: Mapping[tuple[str, str], Estimate]


@dataclass(frozen=True, slots=True)
class Comparison:
    """Everything that a study's page shows.

    ``agreement``: by group and spec, the mean share of equal failing steps with simulations on
    other engines; None where there is none to compare with. ``refused``: layouts of the files that
    are not valid.
    """

    title: str
    cases: int
    layouts: int
    scenarios: tuple[str, ...]
    evaluation: Evaluation
    agreement: Mapping[str, Mapping[str, Estimate | None]]
    matrix: AgreementMatrix
    tunings: tuple[SameTuning, ...]
    uses: tuple[SettingsUse, ...]
    disagreements: tuple[Disagreement, ...]
    disputed: int
    missing_rows: int = 0
    missing_methods: tuple[str, ...] = ()
    manifest: Mapping[str, str] = field(default_factory=dict)
    refused: int = 0
    beyond: tuple[BeyondEnvelope, ...] = ()


def compare(directory: str | Path) -> Comparison:
    """The comparison that a run folder holds.

    Raises:
        ResultsError: not a run folder, or no case in it has been judged by all methods yet.
    """
    directory = Path(directory)
    judged = load_judged(directory)
    manifest, results, said, keys = judged.manifest, judged.results, judged.said, judged.keys
    kept, divided = kept_file(directory, LAYOUTS_FILE, manifest), most_divided(judged)
    layouts = judged_layouts(judged, kept, {*listed_cases(judged), *divided})
    evaluation = evaluate(judged)
    first = results.drop_duplicates("method").set_index("method")["parameters"]
    engines = {m: key for m, key in keys.items() if key.engine}
    uses = tuple(
        _settings_use(key, first[m], *judged.not_honoured[m]) for m, key in engines.items()
    )
    return Comparison(
        title=manifest["study"]["name"],
        cases=len(said),
        layouts=results["layout"].nunique(),
        scenarios=judged.scenarios,
        evaluation=evaluation,
        agreement={group: _mean_agreement(judged, group) for group in evaluation.groups},
        matrix=agreement_matrix(judged, layouts),
        tunings=_same_tunings(judged, evaluation, uses),
        uses=uses,
        disagreements=disagreements(judged, divided, layouts),
        disputed=int((said.nunique(axis=1, dropna=False) > 1).sum()),
        missing_rows=manifest["rows"] - judged.rows,
        missing_methods=tuple(m for m in manifest["study"]["methods"] if m not in keys),
        manifest=manifest_lines(judged),
        refused=manifest.get("refused", {}).get("count", 0),
        beyond=_beyond(manifest, keys),
    )


def _beyond(
    manifest: Mapping[str, Any], keys: Mapping[str, MethodKey]
) -> tuple[BeyondEnvelope, ...]:
    """Cases beyond envelopes; none for runs made before envelopes were recorded."""
    return tuple(
        BeyondEnvelope(
            keys[spec].title,
            entry.get("cases"),
            entry.get("of", 0),
            tuple(
                (r["limit"], r["cases"], r["example"], r["sentence"])
                for r in entry.get("reasons", ())
            ),
        )
        for spec, entry in manifest.get("envelope", {}).items()
        if spec in keys
    )


def _mean_agreement(judged: JudgedCases, group: str) -> dict[str, Estimate | None]:
    """By spec, the mean share of equal failing steps with simulations on other engines.

    None without such simulations.
    """
    scenarios = judged.said.index.get_level_values("scenario")
    said = judged.said if group == ALL else judged.said[scenarios == group]
    clusters = judged.clusters.loc[said.index]
    found: dict[str, Estimate | None] = {}
    for spec, key in judged.keys.items():
        others = [m for m, k in judged.keys.items() if k.engine and k.engine != key.engine]
        equal = [same(said, spec, other) for other in others]
        found[spec] = mean(np.stack(equal).mean(axis=0), clusters) if equal else None
    return found


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
        settings=_shown(parameters),
        honoured=tuple(n for n in asked if n not in ignored and n not in emulated),
        emulated=emulated,
        ignored=ignored,
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
    judged: JudgedCases, evaluation: Evaluation, uses: tuple[SettingsUse, ...]
) -> tuple[SameTuning, ...]:
    simulated = judged.results.dropna(subset=["engine"])
    # Parameters of a single engine are left out of those that engines have in common.
    common = simulated["parameters"].map(json.loads).map(tuning)
    tunings = []
    for _, group in simulated.groupby([simulated["method_name"], common], sort=False):
        specs = set(group["method"])
        rows = tuple(s for s in evaluation.methods if s.method.spec in specs)
        if len({row.method.engine for row in rows}) < 2:
            continue
        used = tuple(u for u in uses if u.method.spec in specs)
        tunings.append(
            SameTuning(
                title=rows[0].method.title.partition(" @ ")[0],
                settings={k: v for k, v in used[0].settings.items() if k in COMMON},
                rows=rows,
                uses=used,
                agreement={
                    (str(a.method.engine), str(b.method.engine)): agreement(
                        judged.said, a.method.spec, b.method.spec, judged.clusters
                    )
                    for a in rows
                    for b in rows
                    if a is not b
                },
            )
        )
    return tuple(tunings)

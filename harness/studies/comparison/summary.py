"""From result rows to the records that a study's page shows."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from steadyload.engines.world import SETTINGS
from steadyload.layouts.formats import read_written
from steadyload.layouts.scenarios import Scenario, apply_scenario
from steadyload.methods.naming import MethodKey, named
from steadyload.methods.simulation_parameters import SimulationParameters
from steadyload.runs.definition import AS_GIVEN
from steadyload.runs.evaluation import AgreementMatrix, MethodSummary, PhaseTimes, accuracies
from steadyload.runs.labels import labelled_layout, load_labels
from steadyload.runs.provenance import source_line
from steadyload.runs.results import (
    KEYS,
    LAYOUTS_FILE,
    ResultsError,
    each_shard,
    kept_file,
    load_manifest,
    load_results,
)
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.metrics import agreement, mean, outcomes, same, share
from steadyload.studies.comparison.records import (
    BeyondEnvelope,
    Comparison,
    Disagreement,
    SameTuning,
    SettingsUse,
)

_CPU_PHASES = (("cpu", "build"), ("cpu", "step"), ("cpu", "read"))
_COLUMNS = (
    *KEYS, "item_count", "method_name", "engine", "parameters", "status", "failing_step", "score",
    *(f"cpu_{phase}" for phase in ("build", "step", "read", "total")), "wall_total",
)  # fmt: skip
_MOST_DISAGREEMENTS = 10
_COMMON = frozenset(f.name for f in dataclasses.fields(SimulationParameters))


def compare(directory: str | Path) -> Comparison:
    """The comparison that a run folder holds.

    Raises:
        ResultsError: not a run folder, or no case in it has been judged by all methods yet.
    """
    directory = Path(directory)
    manifest = load_manifest(directory)
    results = load_results(directory, _COLUMNS)
    order = [m for m in manifest["study"]["methods"] if m in set(results["method"])]
    rows, results = len(results), _judged_by_all(results, len(order))
    if results.empty:
        raise ResultsError(f"{directory}: no case has been judged by all methods yet; resume it")
    layouts = kept_file(directory, LAYOUTS_FILE)
    keys = {m: _key(results[results["method"] == m].iloc[0]) for m in order}
    said = outcomes(results)[order]
    labels = _labels(directory, said) if "labels" in manifest else None
    # Layouts packed from one item list are alike: where lists are known, intervals stand on them.
    groups = {name: name for name in results["layout"].unique()}
    if labels is not None:
        groups = dict(zip(labels.index.get_level_values("layout"), labels["instance"], strict=True))
    results["group"] = results["layout"].map(groups)
    together = _groups(results, said)
    summaries = _summaries(results, said, keys)
    order_of = {str(s): k for k, s in enumerate(Scenario)}
    scenarios = tuple(sorted(set(results["scenario"]), key=lambda s: order_of.get(s, -1)))
    first = results.drop_duplicates("method").set_index("method")["parameters"]
    engines = {m: key for m, key in keys.items() if key.engine}
    kept = _not_honoured(directory) if engines else {}
    uses = tuple(_settings_use(key, first[m], *kept[m]) for m, key in engines.items())
    disputed = said[said.nunique(axis=1, dropna=False) > 1]
    by_scenario = {
        scenario: _summaries(
            results[results["scenario"] == scenario],
            said[said.index.get_level_values("scenario") == scenario],
            keys,
        )
        for scenario in (scenarios if len(scenarios) > 1 else ())
    }
    return Comparison(
        title=manifest["study"]["name"],
        cases=len(said),
        layouts=results["layout"].nunique(),
        scenarios=scenarios,
        methods=summaries,
        by_scenario=by_scenario,
        matrix=AgreementMatrix(
            tuple(keys.values()),
            tuple(tuple(agreement(said, a, b, together) for b in order) for a in order),
        ),
        tunings=_same_tunings(results, said, summaries, uses, together),
        uses=uses,
        disagreements=_disagreements(
            results, said, keys, layouts, manifest["study"]["seed"], labels
        ),
        disputed=len(disputed),
        missing_rows=manifest["rows"] - rows,
        missing_methods=tuple(m for m in manifest["study"]["methods"] if m not in order),
        manifest=_manifest_lines(manifest, rows),
        accuracies=None
        if labels is None
        else accuracies(manifest["labels"], said, labels, summaries, by_scenario),
        beyond=_beyond(manifest, keys),
    )


def _beyond(
    manifest: Mapping[str, Any], keys: Mapping[str, MethodKey]
) -> tuple[BeyondEnvelope, ...]:
    """What the run found of envelopes; runs made before there were any say nothing."""
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


def _labels(directory: Path, said: pd.DataFrame) -> pd.DataFrame:
    """The labels of the cases that have been judged, in their order."""
    labels = load_labels(directory)
    missing = said.index.difference(labels.index)
    if len(missing):
        name, scenario = missing[0]
        raise ResultsError(
            f"{directory}: layout {name!r} has no label in scenario {scenario!r}; run the study "
            "again to write the labels anew"
        )
    return labels.loc[said.index]


def _judged_by_all(results: pd.DataFrame, methods: int) -> pd.DataFrame:
    """The rows of cases that every method has judged: methods are compared on equal terms."""
    judged = results.groupby(["layout", "scenario"])["method"].transform("nunique")
    return results[judged == methods].copy()


def _key(row: pd.Series) -> MethodKey:
    engine = None if pd.isna(row["engine"]) else str(row["engine"])
    return named(row["method_name"], row["method"], engine)


def _summaries(
    results: pd.DataFrame, said: pd.DataFrame, keys: Mapping[str, MethodKey]
) -> tuple[MethodSummary, ...]:
    return tuple(
        _summary(results[results["method"] == method], said, keys, method) for method in keys
    )


def _summary(
    rows: pd.DataFrame, said: pd.DataFrame, keys: Mapping[str, MethodKey], method: str
) -> MethodSummary:
    first = rows[rows["repetition"] == 0]
    done = first[first["status"] == "done"]
    times = [f"{c}_{p}" for c, p in (*_CPU_PHASES, ("cpu", "total"), ("wall", "total"))]
    milliseconds = 1e3 * rows.groupby(["group", "layout", "scenario"])[times].median()
    groups = milliseconds.index.get_level_values("group")
    cpu = mean(milliseconds["cpu_total"], groups)
    build, step, read = (
        float(milliseconds[f"{clock}_{phase}"].mean()) for clock, phase in _CPU_PHASES
    )
    others = [m for m, key in keys.items() if key.engine and key.engine != keys[method].engine]
    return MethodSummary(
        method=keys[method],
        score=mean(done["score"], done["group"]),
        stable=share((first["score"] == 1.0).fillna(False), first["group"]),
        agreement=_mean_agreement(said, method, others, _groups(rows, said)),
        cpu=cpu,
        wall=mean(milliseconds["wall_total"], groups),
        phases=PhaseTimes(build, step, read, cpu.value - build - step - read),
        without_verdict={
            str(k): int(v)
            for k, v in first["status"].value_counts().sort_index().items()
            if k != "done"
        },
    )


def _groups(rows: pd.DataFrame, said: pd.DataFrame) -> pd.Index:
    """Which cases belong together, case by case."""
    known = dict(zip(rows["layout"], rows["group"], strict=True))
    return said.index.get_level_values("layout").map(known)


def _mean_agreement(
    said: pd.DataFrame, method: str, others: list[str], groups: pd.Index
) -> Estimate | None:
    """Mean over cases of the share of ``others`` that said the same; None without others."""
    if not others:
        return None
    equal = np.stack([same(said, method, other) for other in others])
    return mean(equal.mean(axis=0), groups)


def _not_honoured(directory: Path) -> dict[str, tuple[dict[str, None], dict[str, None]]]:
    """By method, settings that an engine ignored and emulated, in the order in which it says so."""
    found: dict[str, tuple[dict[str, None], dict[str, None]]] = {}
    for shard in each_shard(directory, ["method", "ignored", "emulated"]):
        for method, rows in shard.groupby("method"):
            ignored, emulated = found.setdefault(str(method), ({}, {}))
            ignored |= dict.fromkeys(name for names in rows["ignored"] for name in names)
            emulated |= dict.fromkeys(name for names in rows["emulated"] for name in names)
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
    """Parameters as text, without those that ask for nothing."""
    skip: tuple[object, ...] = (None, [], 0, 0.0, "all")
    return {
        name: f"{value:g}" if isinstance(value, int | float) else str(value)
        for name, value in parameters.items()
        if value not in skip
    }


def _same_tunings(
    results: pd.DataFrame,
    said: pd.DataFrame,
    summaries: tuple[MethodSummary, ...],
    uses: tuple[SettingsUse, ...],
    groups: pd.Index,
) -> tuple[SameTuning, ...]:
    simulated = results.dropna(subset=["engine"])
    # What only one engine can be asked is not part of what engines have in common.
    common = simulated["parameters"].map(json.loads).map(tuning)
    tunings = []
    for _, group in simulated.groupby([simulated["method_name"], common], sort=False):
        specs = set(group["method"])
        rows = tuple(s for s in summaries if s.method.spec in specs)
        if len({row.method.engine for row in rows}) < 2:
            continue
        used = tuple(u for u in uses if u.method.spec in specs)
        tunings.append(
            SameTuning(
                title=rows[0].method.title.partition(" @ ")[0],
                settings={k: v for k, v in used[0].settings.items() if k in _COMMON},
                rows=rows,
                uses=used,
                agreement={
                    (str(a.method.engine), str(b.method.engine)): agreement(
                        said, a.method.spec, b.method.spec, groups
                    )
                    for a in rows
                    for b in rows
                    if a is not b
                },
            )
        )
    return tuple(tunings)


def tuning(parameters: Mapping[str, Any]) -> str:
    """The parameters that every engine has, as a text: what two simulations share or not."""
    return json.dumps({k: v for k, v in parameters.items() if k in _COMMON}, sort_keys=True)


def _disagreements(
    results: pd.DataFrame,
    said: pd.DataFrame,
    keys: Mapping[str, MethodKey],
    kept: Path,
    seed: int,
    labels: pd.DataFrame | None,
) -> tuple[Disagreement, ...]:
    """The cases that divide the methods most: simulations first, since they claim to be exact."""
    simulated = [m for m, key in keys.items() if key.engine] or list(keys)
    ranking = pd.DataFrame(
        {
            "divided": said[simulated].apply(_dissent, axis=1),
            "distinct": said.nunique(axis=1, dropna=False),
        }
    )
    ranking = ranking[ranking["distinct"] > 1].sort_values(
        ["divided", "distinct"], ascending=False, kind="stable"
    )
    rows = results[results["repetition"] == 0].set_index(["layout", "scenario", "method"])
    found = []
    shown = ranking.index[:_MOST_DISAGREEMENTS]
    names = set(shown.get_level_values("layout"))
    layouts = {layout.name: layout for layout in read_written(kept, names)} if names else {}
    for name, scenario in shown:
        layout, label = layouts[name], {}
        if labels is not None:
            row = labels.loc[(name, scenario)]
            layout, label = labelled_layout(layout, row), {"label": _step(row["failing_step"])}
        elif scenario != AS_GIVEN:
            layout = apply_scenario(layout, Scenario(scenario), seed)
        verdicts = {m: rows.loc[(name, scenario, m)] for m in keys}
        failing = [v["failing_step"] for v in verdicts.values() if not pd.isna(v["failing_step"])]
        found.append(
            Disagreement(
                layout=name,
                scenario=scenario,
                item_count=len(layout),
                said=label | {keys[m].title: _said(v) for m, v in verdicts.items()},
                drawn=layout,
                marked=tuple(sorted({int(f) for f in failing})),
            )
        )
    return tuple(found)


def _dissent(answers: pd.Series) -> float:
    """Share of pairs of methods that differ in a case; a missing answer differs from all."""
    values = answers.tolist()
    pairs = [(a, b) for i, a in enumerate(values) for b in values[i + 1 :]]
    return float(np.mean([pd.isna(a) or pd.isna(b) or a != b for a, b in pairs])) if pairs else 0.0


def _said(row: pd.Series) -> str:
    return _step(row["failing_step"]) if row["status"] == "done" else row["status"]


def _step(failing: Any) -> str:
    return "stable" if pd.isna(failing) else str(int(failing))


def _manifest_lines(manifest: Mapping[str, Any], rows: int) -> dict[str, str]:
    study, labels = manifest["study"], manifest.get("labels")
    source = {"layout files": ", ".join(study["files"])}
    drawn = {"scenarios": ", ".join(study["scenarios"]) or AS_GIVEN, "seed": str(study["seed"])}
    if labels is not None:
        source = {"labelled set": f"part {labels['part']}, {labels['cases']} cases "
                                  f"(labels {labels['hash']})"}  # fmt: skip
    return {
        "study": f"{study['name']} ({manifest['study_hash']})",
        **source,
        "layouts": f"{manifest['layouts']} (data {manifest['data_hash']})",
        **(drawn if labels is None else {}),
        "rows": str(rows),
        "source": source_line(manifest),
        "versions": ", ".join(f"{k} {v}" for k, v in manifest["versions"].items()),
        "machine": manifest["machine"],
        "started": manifest["started"],
        "finished": manifest["finished"] or "not yet",
    }

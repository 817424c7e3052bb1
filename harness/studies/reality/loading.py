"""Fitted contacts in loading: how parameters differ, and how many verdicts change with them."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import pandas as pd

from steadyload.layouts.benchmark import load_benchmark
from steadyload.layouts.benchmark.parts import LISTS, Part
from steadyload.layouts.model.scenarios import Scenario
from steadyload.methods.contract.spec import as_plain
from steadyload.methods.registry import make_method
from steadyload.runs import frames as v
from steadyload.runs.evaluation import Evaluation
from steadyload.runs.labels import Cases
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.metrics import share
from steadyload.studies.kit import Lab
from steadyload.studies.reality.fitting import Fitted

FRICTION = "friction"

CHANGES = (FRICTION, "bounce and hardness", "both")
"""Parameters of a preset that take the fitted values."""


class Range(NamedTuple):
    """The least and the greatest of some estimates, with the engines that they are of."""

    least: Estimate
    lowest: str
    most: Estimate
    highest: str


def differences(engine: str, preset: str, label: str, found: Fitted) -> list[dict[str, Any]]:
    """Fitted parameters beside those of a preset and of the label.

    Returns:
        ``differs``: the preset's value is outside the interval of the fitted one.
    """
    used, usual = (_stated(spec, found.parameters) for spec in (preset, label))
    rows = []
    for name, value in found.parameters.items():
        own, least, most = used[name], found.least[name], found.most[name]
        rows.append(
            {
                "engine": engine,
                "parameter": name,
                "preset_value": own,
                "label_value": usual[name],
                "fitted_value": value,
                "interval": f"{least:g} to {most:g}",
                "differs": own is None or not least <= own <= most,
            }
        )
    return rows


def _stated(spec: str, names: Mapping[str, float]) -> dict[str, float | None]:
    """Values of some parameters of a simulation; where its options bring them, those."""
    parameters = make_method(spec).parameters
    plain = as_plain(parameters)
    options = parameters.world_settings().options
    value = getattr(options, "value", None)
    return {
        name: value(name) if plain[name] is None and value is not None else plain[name]
        for name in names
    }


def changes(preset: str, found: Fitted) -> dict[str, str]:
    """Specs of a preset with fitted values, by what takes them; empty changes are left out."""
    friction = {FRICTION: found.parameters[FRICTION]}
    others = {name: value for name, value in found.parameters.items() if name != FRICTION}
    named = dict(zip(CHANGES, (friction, others, found.parameters), strict=True))
    if not others:
        named = {FRICTION: friction}
    joint = "," if ":" in preset else ":"
    return {
        change: preset + joint + ",".join(f"{name}={value!r}" for name, value in values.items())
        for change, values in named.items()
    }


def judged(lab: Lab, name: str, preset: str, found: Fitted, count: int) -> Evaluation:
    """Layouts of many item lists, judged by a preset and by what takes fitted values."""
    cases = Cases(load_benchmark(LISTS), Part.TEST, (Scenario.S1,), count)
    specs = [preset, *changes(preset, found).values()]
    return lab.judge(specs, cases, folder=f"labels_{name}", timeout=TIMEOUT)


TIMEOUT = 120.0
"""CPU seconds that a judgement may take."""


def verdicts(preset: str, found: Fitted, evaluation: Evaluation) -> dict[str, pd.Series]:
    """Items placed safely by case, by what takes fitted values."""
    said = evaluation.judged.said
    return {
        change: said[str(make_method(spec).spec)] for change, spec in changes(preset, found).items()
    }


def changed(
    engine: str,
    preset: str,
    found: Fitted,
    evaluation: Evaluation,
    reference: Mapping[str, pd.Series],
) -> list[dict[str, Any]]:
    """How many verdicts change, by change.

    Returns:
        ``layouts`` with both verdicts; of them ``verdict_changed`` and ``fails_earlier``, or fails
        at all; accuracy ``before`` and ``after``; ``as_reference``: the verdict agrees with the
        reference that takes its own fitted values, None where that was not run.
    """
    said, clusters = evaluation.judged.said, evaluation.judged.clusters
    own = str(make_method(preset).spec)
    before = evaluation.row(own).accuracy
    rows = []
    for change, spec in changes(preset, found).items():
        other = str(make_method(spec).spec)
        both = said[[own, other]].dropna().astype(int)
        at = clusters.loc[both.index]
        first, second = (both[key].to_numpy() for key in (own, other))
        rows.append(
            {
                "engine": engine,
                "change": change,
                "layouts": len(both),
                "verdict_changed": share(first != second, at),
                "fails_earlier": share(second < first, at),
                "before": before,
                "after": evaluation.row(other).accuracy,
                "as_reference": (
                    _agreement(said[other], reference[change], clusters) if reference else None
                ),
            }
        )
    return rows


def _agreement(one: pd.Series, other: pd.Series, clusters: pd.Series) -> Estimate:
    """Share of the cases on which both say the same, of those on which the second has a verdict."""
    wanted = other.dropna().astype(int)
    same = one.reindex(wanted.index).fillna(-1).astype(int) == wanted
    return share(same.to_numpy(), clusters.loc[wanted.index])


def rankings(rows: pd.DataFrame, reference: str) -> list[dict[str, Any]]:
    """The order of engines before and after, by each change of which there are several engines.

    Returns:
        By change: ``labels``, share of the verdicts of the reference, with the label's contact,
        that change, None where it was not run; the :class:`Range` of engines by verdicts that
        change (``changed``), by accuracy of presets (``before``), and of fitted values against the
        reference that takes its own, without that against the labels (``then``); ``pairs`` of
        engines; ``turned``, those of which the other one is more accurate then; ``clearly``, those
        of these whose intervals do not overlap then.
    """
    found = []
    for change, own in rows.groupby("change", sort=False):
        by_engine = own.set_index("engine")
        ranked = by_engine.drop(index=reference, errors="ignore")
        if len(ranked) < 2:
            continue
        then = ranked["as_reference"].where(ranked["as_reference"].notna(), ranked["after"])
        values = pd.DataFrame({"before": v.values(ranked["before"]), "then": v.values(then)})
        turned = [
            (then[one], then[other])
            for one, other in itertools.combinations(ranked.index, 2)
            if (values.loc[one] - values.loc[other]).prod() < 0
        ]
        found.append(
            {
                "change": change,
                "layouts": own["layouts"].max(),
                "labels": by_engine["verdict_changed"].get(reference),
                "changed": _range(ranked["verdict_changed"]),
                "before": _range(ranked["before"]),
                "then": _range(then),
                "pairs": math.comb(len(ranked), 2),
                "turned": len(turned),
                "clearly": sum(
                    one.low > other.high or other.low > one.high for one, other in turned
                ),
            }
        )
    return found


def _range(found: pd.Series) -> Range:
    order = v.values(found).sort_values(kind="stable").index
    return Range(found[order[0]], order[0], found[order[-1]], order[-1])

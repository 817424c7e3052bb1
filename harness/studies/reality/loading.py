"""Fitted contacts in loading: how parameters differ, and how many verdicts change with them."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence

import pandas as pd

from steadyload.layouts.benchmark import load_benchmark
from steadyload.layouts.benchmark.parts import LISTS, Part
from steadyload.layouts.model.scenarios import Scenario
from steadyload.methods.contract.spec import as_plain
from steadyload.methods.registry import make_method
from steadyload.reports.columns import column, general, percent, row
from steadyload.runs.evaluation import Evaluation
from steadyload.runs.labels import Cases
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.metrics import share
from steadyload.studies.kit import Lab
from steadyload.studies.reality.fitting import Fitted

FRICTION = "friction"

CHANGES = (FRICTION, "bounce and hardness", "both")
"""Parameters of a preset that take the fitted values."""


@row
class Difference:
    """A contact parameter of an engine, fitted to the record and as used for loading."""

    engine: str = column(left=True)
    parameter: str = column(left=True)
    preset: float | None = column("preset", general)
    label: float | None = column("label's", general)
    fitted: float = column("fitted", general)
    least: float = column("from", general, "interval of the fitted value")
    most: float = column("to", general)

    @property
    def interval(self) -> str:
        """The interval of the fitted value."""
        return f"{general(self.least)} to {general(self.most)}"

    @property
    def differs(self) -> bool:
        """Whether the preset's value is outside the interval of the fitted one."""
        return self.preset is None or not self.least <= self.preset <= self.most


@row
class Changed:
    """Verdicts on layouts that change when a preset takes fitted values."""

    engine: str = column(left=True)
    change: str = column("fitted", left=True)
    layouts: int = column("n")
    changed: Estimate = column("changed %", percent)
    earlier: Estimate = column("fails earlier %", percent, "or at all")
    before: Estimate = column("preset: accuracy %", percent)
    after: Estimate = column("changed: accuracy %", percent)
    agrees: Estimate | None = column("as the reference so changed %", percent)


@row
class Ranking:
    """Engines by accuracy, before and after presets take fitted values.

    Attributes:
        change: what is fitted, of :data:`CHANGES`.
        layouts: that were judged.
        labels: share of the verdicts of the reference, with the label's contact, that change; None
            where it was not run.
        least, most: the engines of the fewest and the most changed verdicts, without the reference.
        first, last: the most and the least accurate engine by presets, against the labels.
        then_first, then_last: likewise with fitted values, against the reference that takes its
            own; without that against the labels.
        pairs: of engines.
        turned: those of them of which the other one is more accurate then.
        clear: those of these whose intervals do not overlap then.
    """

    change: str
    layouts: int
    labels: Estimate | None
    least: Changed
    most: Changed
    first: Changed
    last: Changed
    then_first: Changed
    then_last: Changed
    pairs: int
    turned: int
    clear: int

    @property
    def then_most(self) -> Estimate:
        """Accuracy of the most accurate engine with fitted values."""
        return _then(self.then_first)

    @property
    def then_least(self) -> Estimate:
        """Likewise of the least accurate one."""
        return _then(self.then_last)


def differences(engine: str, preset: str, label: str, found: Fitted) -> list[Difference]:
    """Fitted parameters beside those of a preset and of the label.

    Args:
        engine: its title.
        preset: spec of a simulation on it.
        label: spec of the label's simulation on it.
        found: what was fitted.
    """
    used, usual = (_stated(spec, found.parameters) for spec in (preset, label))
    return [
        Difference(
            engine, name, used[name], usual[name], value, found.least[name], found.most[name]
        )
        for name, value in found.parameters.items()
    ]


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
    """Specs of a preset that takes fitted values, by what takes them; empty changes are left out.

    Args:
        preset: spec, such as ``ps_opt@mujoco``.
        found: what was fitted.
    """
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
    """Layouts of many item lists, judged by a preset and by what takes fitted values.

    Args:
        lab: an interrupted run goes on in its folder.
        name: of the engine.
        preset: spec.
        found: what was fitted.
        count: layouts, with centres of mass in the middle of boxes.
    """
    cases = Cases(load_benchmark(LISTS), Part.TEST, (Scenario.S1,), count)
    specs = [preset, *changes(preset, found).values()]
    return lab.judge(specs, cases, folder=f"labels_{name}", timeout=TIMEOUT)


TIMEOUT = 120.0
"""CPU seconds that a judgement may take."""


def verdicts(preset: str, found: Fitted, evaluation: Evaluation) -> dict[str, pd.Series]:
    """Items placed safely by case, by what takes fitted values.

    Args:
        preset: spec.
        found: what was fitted.
        evaluation: of :func:`judged`.
    """
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
) -> list[Changed]:
    """How many verdicts change.

    Args:
        engine: its title.
        preset: spec.
        found: what was fitted.
        evaluation: of :func:`judged`.
        reference: :func:`verdicts` of the reference; empty where it was not run.
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
            Changed(
                engine, change, len(both), share(first != second, at), share(second < first, at),
                before, evaluation.row(other).accuracy,
                _agreement(said[other], reference[change], clusters) if reference else None,
            )
        )  # fmt: skip
    return rows


def _agreement(one: pd.Series, other: pd.Series, clusters: pd.Series) -> Estimate:
    """Share of the cases on which both say the same, of those on which the second has a verdict."""
    wanted = other.dropna().astype(int)
    same = one.reindex(wanted.index).fillna(-1).astype(int) == wanted
    return share(same.to_numpy(), clusters.loc[wanted.index])


def rankings(rows: Sequence[Changed], reference: str) -> list[Ranking]:
    """The order of engines before and after, by each change of which there are several engines.

    Args:
        rows: of all engines.
        reference: title of the reference, which is no competitor.
    """
    found = []
    for change in CHANGES:
        own = [one for one in rows if one.change == change]
        ranked = [one for one in own if one.engine != reference]
        if len(ranked) < 2:
            continue
        labels = next((one.changed for one in own if one.engine == reference), None)
        turned = [
            (_then(one), _then(other))
            for one, other in itertools.combinations(ranked, 2)
            if (one.before.value - other.before.value) * (_then(one).value - _then(other).value) < 0
        ]
        by_changes = sorted(ranked, key=lambda one: one.changed.value)
        by_before = sorted(ranked, key=lambda one: one.before.value)
        by_then = sorted(ranked, key=lambda one: _then(one).value)
        found.append(
            Ranking(
                change=change,
                layouts=max(one.layouts for one in own),
                labels=labels,
                least=by_changes[0],
                most=by_changes[-1],
                first=by_before[-1],
                last=by_before[0],
                then_first=by_then[-1],
                then_last=by_then[0],
                pairs=math.comb(len(ranked), 2),
                turned=len(turned),
                clear=sum(one.low > other.high or other.low > one.high for one, other in turned),
            )
        )
    return found


def _then(one: Changed) -> Estimate:
    return one.after if one.agrees is None else one.agrees

"""Accuracy and rank of methods by the verdicts of the reference under every rule."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import cached_property
from pathlib import Path

import pandas as pd

from steadyload.methods.naming import MethodKey
from steadyload.runs.evaluation import ALL, Evaluation, evaluate
from steadyload.runs.judged import JudgedCases, load_judged, manifest_lines
from steadyload.statistics.estimate import Estimate
from steadyload.studies.sensitivity.rules import RULES, USUAL, Rule


class Knowledge(StrEnum):
    """Knowledge that a method has of the rule that it is compared by.

    ``none``: nothing, it is as it stands. ``told``: its time, thresholds and criterion are those of
    the rule, as far as it has any.
    """

    NONE = "as they stand"
    TOLD = "told the rule"


CLAIMS: tuple[tuple[str, str, str], ...] = (
    ("A tuned simulation is more accurate than SME.", "ps_opt@mujoco", "sme"),
    ("A tuned simulation is more accurate than PS_3.", "ps_opt@mujoco", "ps3-literal@bullet"),
    ("PS_3 is more accurate than SME.", "ps3-literal@bullet", "sme"),
    ("A learner is more accurate than SME.", "lstm_e", "sme"),
    ("A tuned simulation is more accurate than a learner.", "ps_opt@mujoco", "lstm_e"),
    ("A tuned simulation is more accurate than exact equilibrium.", "ps_opt@mujoco", "equilibrium"),
    ("Exact equilibrium is more accurate than SME.", "equilibrium", "sme"),
    ("SME is more accurate than PBS 0.5.", "sme", "pbs0.5"),
    ("PBS 0.5 is more accurate than FBS.", "pbs0.5", "fbs"),
    ("MuJoCo is more accurate than Bullet, both tuned.", "ps_opt@mujoco", "ps_opt@bullet"),
    ("MuJoCo is more accurate than DART, both tuned.", "ps_opt@mujoco", "ps_opt@dart"),
)
"""Conclusions that a reader may draw from Table 5: the first method is more accurate than the
second."""


@dataclass(frozen=True, slots=True)
class Place:
    """A method under one rule: accuracy and rank, 1 for the most accurate; equal ones share it."""

    method: MethodKey
    accuracy: Estimate
    rank: int


@dataclass(frozen=True, slots=True)
class Ranking:
    """All methods under one rule, in the order of the study.

    Attributes:
        rule: by which the reference labelled.
        knowledge: of the methods.
        places: a method each.
        stable: share of cases that the reference calls stable.
        changed: share of cases whose label is not that of the usual rule.
    """

    rule: Rule
    knowledge: Knowledge
    places: tuple[Place, ...]
    stable: float
    changed: float

    def of(self, spec: str) -> Place:
        """A method's place."""
        return next(place for place in self.places if place.method.spec == spec)


class Fate(StrEnum):
    """Fate of a conclusion over the rules.

    ``survives``: the interval of the difference lies above 0 under every rule. ``turns``: it lies
    below 0 under one rule at least. ``open``: neither.
    """

    SURVIVES = "survives"
    TURNS = "is turned round"
    OPEN = "stays open"


@dataclass(frozen=True)
class Claim:
    """A conclusion, and the difference in accuracy under every rule.

    Attributes:
        text: a sentence.
        knowledge: of both methods.
        differences: by name of the rule, accuracy of the first method minus that of the second.
    """

    text: str
    knowledge: Knowledge
    differences: Mapping[str, Estimate]

    @property
    def holds(self) -> tuple[str, ...]:
        """Rules under which the interval lies above 0."""
        return tuple(name for name, d in self.differences.items() if d.low > 0.0)

    @property
    def turned(self) -> tuple[str, ...]:
        """Rules under which it lies below 0."""
        return tuple(name for name, d in self.differences.items() if d.high < 0.0)

    @property
    def fate(self) -> Fate:
        """See :class:`Fate`."""
        if self.turned:
            return Fate.TURNS
        return Fate.SURVIVES if len(self.holds) == len(self.differences) else Fate.OPEN


@dataclass(frozen=True)
class Sensitivity:
    """Everything that the page shows.

    Attributes:
        rankings: every rule, for every :class:`Knowledge`.
        claims: those whose methods both took part, likewise.
        cases, item_lists: of the labelled part.
        lost: by name of a rule, cases that the reference has no verdict on, which are left out.
        manifest: provenance.
    """

    rankings: tuple[Ranking, ...]
    claims: tuple[Claim, ...]
    cases: int
    item_lists: int
    lost: Mapping[str, int]
    manifest: Mapping[str, str]

    def by(self, knowledge: Knowledge) -> tuple[Ranking, ...]:
        """The rankings of methods that know so much, in the order of the rules."""
        return tuple(r for r in self.rankings if r.knowledge is knowledge)

    @cached_property
    def methods(self) -> tuple[MethodKey, ...]:
        """The methods as they stand."""
        return tuple(place.method for place in self.rankings[0].places)


def summarise(run: Path, methods: tuple[str, ...]) -> Sensitivity:
    """Compare the methods with the reference, rule by rule.

    Args:
        run: folder of a run that has judged the reference and the methods under all rules.
        methods: canonical specs, as they stand.

    Raises:
        ResultsError: see :func:`steadyload.runs.judged.load_judged`.
    """
    judged = load_judged(run)
    usual = judged.said[USUAL.label]
    rankings, lost = [], {}
    claims: dict[tuple[Knowledge, str], dict[str, Estimate]] = {}
    for rule in RULES:
        found = relabelled(judged, rule)
        missing = len(judged.said) - len(found.said)
        if missing:
            lost[rule.name] = missing
        evaluation = evaluate(found, by_scenario=False)
        labels = found.said[rule.label]
        changed = float((labels != usual.loc[labels.index]).mean())
        for knowledge in Knowledge:
            named = {spec: _known(spec, rule, knowledge) for spec in methods}
            rankings.append(
                Ranking(
                    rule,
                    knowledge,
                    _places(evaluation, named, judged.keys),
                    _stable(found),
                    changed,
                )
            )
            for text, first, second in CLAIMS:
                if first in named and second in named:
                    difference = evaluation.difference(named[first], named[second])
                    claims.setdefault((knowledge, text), {})[rule.name] = difference
    assert judged.labels is not None, "the study is on a labelled set"
    return Sensitivity(
        tuple(rankings),
        tuple(Claim(text, knowledge, d) for (knowledge, text), d in claims.items()),
        len(judged.said),
        judged.labels["instance"].nunique(),
        lost,
        manifest_lines(judged),
    )


def relabelled(judged: JudgedCases, rule: Rule) -> JudgedCases:
    """The cases on which the reference has a verdict under a rule, with that as their label."""
    found = judged.only(judged.said[rule.label].notna().to_numpy(bool))
    assert found.labels is not None, "the study is on a labelled set"
    placed = found.said[rule.label].astype("Int64")
    failing = placed.where(placed < found.labels["item_count"].astype("Int64"))
    return replace(found, labels=found.labels.assign(failing_step=failing))


def _stable(judged: JudgedCases) -> float:
    assert judged.labels is not None
    return float(pd.isna(judged.labels["failing_step"]).mean())


def _known(spec: str, rule: Rule, knowledge: Knowledge) -> str:
    return rule.given_to(spec) if knowledge is Knowledge.TOLD else spec


def _places(
    evaluation: Evaluation, named: Mapping[str, str], keys: Mapping[str, MethodKey]
) -> tuple[Place, ...]:
    """A method each, under its name as it stands."""
    found = {spec: evaluation.row(asked, ALL).accuracy for spec, asked in named.items()}
    return tuple(
        Place(keys[spec], own, 1 + sum(other.value > own.value for other in found.values()))
        for spec, own in found.items()
    )

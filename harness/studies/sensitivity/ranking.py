"""Accuracy and rank of methods by the verdicts of the reference under every failure rule."""

from __future__ import annotations

from collections.abc import Mapping
from types import SimpleNamespace
from typing import Any

import pandas as pd

from steadyload.layouts.benchmark import load_benchmark
from steadyload.layouts.benchmark.parts import Part, set_named
from steadyload.methods.registry import make_method
from steadyload.reports import frames
from steadyload.reports.columns import names, percent
from steadyload.runs import frames as v
from steadyload.runs.failure_rules import LIMITS, RULES, TIMES, USUAL, Rule
from steadyload.runs.judged import JudgedCases, manifest_lines
from steadyload.runs.labels import Cases
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.paired import detectable
from steadyload.studies.kit import Lab

DIRECTORY, LIMIT = "lists", 100
"""The labelled set, and cases a scenario, those of the first ranks."""

METHODS = (
    "fbs",
    "pbs0.9",
    "pbs0.7",
    "pbs0.5",
    "sme",
    "equilibrium",
    "equilibrium:time=0.3",
    "ps3-literal@bullet",
    "ps3@mujoco",
    "ps_opt-paper@bullet",
    "ps_opt@bullet",
    "ps_opt@mujoco",
    "ps_opt@dart",
    "lstm_1",
    "lstm_e",
    "cascade@mujoco",
)
"""Specs of the methods that are compared."""

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

CHARTED = (
    "fbs", "pbs0.5", "sme", "equilibrium", "ps3-literal@bullet", "lstm_e", "ps_opt@mujoco",
)  # fmt: skip
"""Specs of the methods that the chart shows, as many as can be read: those of most conclusions."""

OWN, TOLD = "with their own parameters", "with the rule's parameters"
KNOWLEDGE = (OWN, TOLD)
"""Methods are as they stand, or have the time, thresholds and criterion of the rule, as far as they
have any."""

SURVIVES, TURNS, OPEN = "survives", "is turned round", "stays open"
FATES = (SURVIVES, TURNS, OPEN)
"""The interval of the difference lies above 0 under every rule; below 0 under one rule at least;
neither."""

_SHARD = 25


class Found(SimpleNamespace):
    """All that the page shows."""

    made_with: Mapping[str, str]


def compare(lab: Lab, limit: int | None) -> Found:
    """Judge cases of the test part by all methods under all rules, and compare.

    Nothing was tuned, trained or fitted on that part. The run folder is that of the lab.
    """
    plain = [str(make_method(spec).spec) for spec in METHODS]
    told = [rule.given_to(spec) for spec in plain for rule in RULES]
    judged = lab.judge(
        tuple(dict.fromkeys([*(rule.label for rule in RULES), *plain, *told])),
        Cases(load_benchmark(set_named(DIRECTORY)), Part.TEST, limit=limit or LIMIT),
        name="sensitivity",
        folder="",
        shard_size=_SHARD,
    ).judged
    assert judged.labels is not None, "the study is on a labelled set"
    labelled = {rule: judged.labelled_by(rule.label) for rule in RULES}
    lost = {rule.short: len(judged.said) - len(own.said) for rule, own in labelled.items()}
    frame = pd.concat(
        [
            _ranked_under(v.verdicts(own), rule, plain, of)
            for rule, own in labelled.items()
            for of in KNOWLEDGE
        ]
    )
    right = v.share(frame, "right", ["knowledge", "rule", "method"])
    by = frame.groupby(["knowledge", "rule"], sort=False)
    tests = pd.concat(
        {of: v.both_ways(v.pairs(own)) for of, own in by}, names=["knowledge", "rule"]
    )
    claims = _claims(tests, judged.clusters.nunique())
    fates = claims.pivot(index="claim", columns="knowledge", values="fate")
    titles = pd.Series({spec: judged.keys[spec].title for spec in plain})
    return Found(
        claims=claims,
        conclusions=len(fates),
        hold=int((fates == SURVIVES).all(axis=1).sum()),
        hold_told=int(((fates[TOLD] == SURVIVES) & (fates[OWN] != SURVIVES)).sum()),
        turned=list(claims["claim"][(claims["knowledge"] == TOLD) & (claims["fate"] == TURNS)]),
        open=[int((fates[of] == OPEN).sum()) for of in KNOWLEDGE],
        rules=pd.DataFrame(
            [_under(rule, of, judged, right, titles) for rule, of in labelled.items()]
        ),
        charted=[
            {"key": judged.keys[spec], "title": titles[spec], "rule": rule.short, "by": by,
             "knowledge": of, "right": right[of, rule.short, spec]}
            for of in KNOWLEDGE
            for by, rules in (("by time", TIMES), ("by threshold and point measured", LIMITS))
            for rule in rules
            for spec in plain if spec in CHARTED
        ],
        accuracies={of: _accuracies(right[of], _ranks(tests.loc[of]), titles) for of in KNOWLEDGE},
        cases=len(judged.said),
        item_lists=judged.labels["instance"].nunique(),
        directory=DIRECTORY,
        lost={rule: missing for rule, missing in lost.items() if missing},
        made_with=manifest_lines(judged),
    )  # fmt: skip


def _ranked_under(
    frame: pd.DataFrame, rule: Rule, plain: list[str], knowledge: str
) -> pd.DataFrame:
    """The rows of methods under a rule, under their names as they stand."""
    # Two methods may be one when they are told the rule.
    known = {spec: rule.given_to(spec) if knowledge == TOLD else spec for spec in plain}
    own = [frame[frame["method"] == told].assign(method=spec) for spec, told in known.items()]
    return pd.concat(own).assign(rule=rule.short, knowledge=knowledge)


def _claims(tests: pd.DataFrame, item_lists: int) -> pd.DataFrame:
    """All conclusions, of methods as they stand and told the rule, by fate."""
    found = [
        claim(text, of, tests["difference"].xs((of, first, second), level=_PAIR), item_lists)
        for of in KNOWLEDGE
        for text, first, second in CLAIMS
    ]
    return pd.DataFrame(sorted(found, key=lambda one: FATES.index(one["fate"])))


_PAIR = ["knowledge", "first", "second"]


def claim(text: str, knowledge: str, differences: pd.Series, item_lists: int) -> Mapping[str, Any]:
    """A conclusion, of the difference in accuracy by short name of the rule.

    Returns:
        ``holds``: rules under which the interval lies above 0; ``turned``: below it; ``shown``: the
        least difference that the cases show, under the rule with the widest interval.
    """
    holds = [rule for rule, own in differences.items() if own.low > 0.0]
    turned = [rule for rule, own in differences.items() if own.high < 0.0]
    ordered = sorted(differences, key=lambda own: own.value)
    return {
        "claim": text,
        "knowledge": knowledge,
        "fate": TURNS if turned else SURVIVES if len(holds) == len(differences) else OPEN,
        "holds": f"{len(holds)} of {len(differences)}",
        "turned": names(turned),
        "least_difference": ordered[0],
        "greatest": ordered[-1],
        "shown": max(detectable(each, item_lists) for each in ordered),
    }


def _ranks(tests: pd.DataFrame) -> pd.Series:
    """By method and rule the ranks by accuracy that it may have, 1 for the most accurate.

    The best counts the methods that are significantly more accurate, by the 95 % interval of the
    difference, the worst those that are not significantly less accurate.
    """
    difference = tests["difference"]
    groups = [tests.index.get_level_values(name) for name in ("first", "rule")]
    best = 1 + difference.map(lambda one: one.high < 0.0).groupby(groups, sort=False).sum()
    beaten = difference.map(lambda one: one.low > 0.0).groupby(groups, sort=False).sum()
    worst = len(groups[0].unique()) - beaten
    return best.astype(str).where(best == worst, best.astype(str) + " to " + worst.astype(str))


def _under(
    rule: Rule, found: JudgedCases, judged: JudgedCases, right: pd.Series, titles: pd.Series
) -> dict[str, Any]:
    """The labels of the reference under one rule, and the most accurate methods by these."""
    assert found.labels is not None
    labels = found.said[rule.label]
    usual = judged.said[USUAL.label].loc[labels.index]

    def first(knowledge: str) -> str:
        own = right[knowledge].xs(rule.short, level="rule")
        most: Estimate = own[v.best(own)]
        best = titles[[spec for spec in titles.index if own[spec].value == most.value]]
        return f"{names(dict.fromkeys(best))}, {percent(most)}"

    return {
        "rule": rule.name,
        "cases": len(labels),
        "rule_stable": found.labels["failing_step"].isna().mean(),
        "changed": (labels != usual).mean(),
        "most_accurate": first(OWN),
        "most_accurate_told": first(TOLD),
    }


def _accuracies(right: pd.Series, ranks: pd.Series, titles: pd.Series) -> Mapping[str, Any]:
    """Accuracy and ranks of methods by rule: those of time, and those of limits."""
    by_rule = right.swaplevel()
    return {
        f"{name}_{kind}": titles.to_frame("title").join(
            frames.across(found.loc[:, [rule.short for rule in rules]], "rule", column)
        )
        for kind, rules in (("time", TIMES), ("limit", LIMITS))
        for name, column, found in (("right", "rule_right", by_rule), ("rank", "rule_rank", ranks))
    }

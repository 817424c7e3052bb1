"""Accuracy and rank of methods by the verdicts of the reference under every failure rule."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from enum import StrEnum
from itertools import combinations
from typing import NamedTuple

from steadyload.layouts.benchmark import load_benchmark
from steadyload.layouts.benchmark.parts import Part, set_named
from steadyload.methods.naming import MethodKey
from steadyload.methods.registry import make_method
from steadyload.reports.columns import column, least_shown, names, percent, plain_percent, row
from steadyload.runs.accuracy import accuracy
from steadyload.runs.comparison import Compared, compared, detectable, difference
from steadyload.runs.failure_rules import LIMITS, RULES, TIMES, USUAL, Rule
from steadyload.runs.judged import JudgedCases, manifest_lines
from steadyload.runs.labels import Cases
from steadyload.statistics.estimate import Estimate
from steadyload.studies.kit import Lab

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
"""Specs of the methods that are compared by default."""

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

_SHARD = 25


class Knowledge(StrEnum):
    """Knowledge that a method has of the rule that it is compared by.

    ``none``: nothing, it is as it stands. ``told``: its time, thresholds and criterion are those of
    the rule, as far as it has any.
    """

    NONE = "with their own parameters"
    TOLD = "with the rule's parameters"


class Fate(StrEnum):
    """Fate of a conclusion over the rules.

    ``survives``: the interval of the difference lies above 0 under every rule. ``turns``: it lies
    below 0 under one rule at least. ``open``: neither.
    """

    SURVIVES = "survives"
    TURNS = "is turned round"
    OPEN = "stays open"


class Held(NamedTuple):
    """Number of rules under which a conclusion holds, of how many."""

    rules: int
    of: int

    def __str__(self) -> str:
        return f"{self.rules} of {self.of}"


@row
class Claim:
    """A conclusion under all rules: accuracy of its first method minus that of its second."""

    text: str = column("conclusion")
    knowledge: Knowledge = column("methods", about="of both methods")
    fate: Fate = column()
    holds: Held = column("holds under", about="rules under which the interval lies above 0")
    turned: Sequence[str] = column(
        "turned under", names, "rules under which it lies below 0", left=True
    )
    least: Estimate = column("least difference", percent)
    greatest: Estimate = column("greatest", percent)
    shown: float = column(
        "shown", least_shown,
        "least difference that these cases show with a probability of 80 %, under the rule with "
        "the widest interval",
    )  # fmt: skip


class Ranks(NamedTuple):
    """Ranks by accuracy that a method may have, 1 for the most accurate.

    The best counts the methods that are significantly more accurate, by the 95 % interval of the
    difference, the worst those that are not significantly less accurate.
    """

    best: int
    worst: int

    def __str__(self) -> str:
        return f"{self.best}" if self.best == self.worst else f"{self.best} to {self.worst}"


@row
class UnderRule:
    """The labels of the reference under one rule, and the most accurate methods by these."""

    rule: str = column()
    n: int = column()
    stable: float = column("stable %", plain_percent)
    changed: float = column(
        "label changed %", plain_percent, "share of cases with another label than the usual rule's"
    )
    best: str = column("most accurate")
    best_told: str = column("with the rule's parameters")


@row
class Place:
    """A method under one rule: accuracy, and the ranks that it may have.

    ``by``: what the rule differs in, as a panel of the chart is named; the usual rule is in each.
    """

    method: MethodKey
    rule: str
    by: str
    knowledge: Knowledge
    accuracy: Estimate
    ranks: Ranks


@row
class Accuracies:
    """Accuracy and ranks of one method under every rule, by the rule's short name."""

    method: str = column()
    by_time: Mapping[str, Estimate] = column("{}", percent)
    by_limit: Mapping[str, Estimate] = column("{}", percent)
    ranks_by_time: Mapping[str, Ranks] = column("{}", str)
    ranks_by_limit: Mapping[str, Ranks] = column("{}", str)


@row
class Rankings:
    """Methods under every rule.

    ``claims``: those whose methods both took part, by fate. ``lost``: by short name of a rule,
    cases that the reference has no verdict on, which are left out.
    """

    claims: Sequence[Claim]
    rules: Sequence[UnderRule]
    places: Sequence[Place]
    accuracies: Mapping[Knowledge, Sequence[Accuracies]]
    cases: int
    item_lists: int
    lost: Mapping[str, int]
    made_with: Mapping[str, str]

    @property
    def charted(self) -> list[Place]:
        """The places that the chart shows."""
        return [place for place in self.places if place.method.spec in CHARTED]

    @property
    def standing(self) -> list[Claim]:
        """Conclusions on methods as they stand."""
        return [claim for claim in self.claims if claim.knowledge is Knowledge.NONE]

    @property
    def informed(self) -> list[Claim]:
        """Conclusions on methods that are told the rule."""
        return [claim for claim in self.claims if claim.knowledge is Knowledge.TOLD]

    @property
    def shown(self) -> list[float]:
        """Least differences that the cases show, of all conclusions, in order."""
        return sorted(claim.shown for claim in self.claims)

    @property
    def survivors(self) -> tuple[list[Claim], list[Claim]]:
        """Those that hold under all rules, told or not, and those that do only where told."""
        loose = {claim.text for claim in self.standing if claim.fate is Fate.SURVIVES}
        kept = [claim for claim in self.informed if claim.fate is Fate.SURVIVES]
        return [c for c in kept if c.text in loose], [c for c in kept if c.text not in loose]

    @property
    def open(self) -> tuple[int, int]:
        """Number of those that stay open where methods are not told the rule, and where told."""
        standing, told = (
            sum(claim.fate is Fate.OPEN for claim in claims)
            for claims in (self.standing, self.informed)
        )
        return standing, told


def ranked(lab: Lab, methods: Sequence[str], limit: int | None, directory: str = "") -> Rankings:
    """Judge cases of the test part by all methods under all rules, and compare.

    Nothing was tuned, trained or fitted on that part. The run folder is that of the lab.

    Args:
        lab: where they are judged.
        methods: specs; empty for :data:`METHODS`.
        limit: cases a scenario, those of the first ranks; None for all.
        directory: of the labelled set, see :func:`steadyload.layouts.benchmark.dataset.set_named`.

    Raises:
        SpecError, StudyError: no such method, or one that cannot judge layouts in space.
        ResultsError: the folder holds another study.
    """
    plain = [str(make_method(spec).spec) for spec in methods or METHODS]
    told = [rule.given_to(spec) for spec in plain for rule in RULES]
    judged = lab.judge(
        tuple(dict.fromkeys([*(rule.label for rule in RULES), *plain, *told])),
        Cases(load_benchmark(set_named(directory)), Part.TEST, limit=limit),
        name="sensitivity",
        folder="",
        shard_size=_SHARD,
    ).judged
    assert judged.labels is not None, "the study is on a labelled set"
    found = {rule: judged.labelled_by(rule.label) for rule in RULES}
    by_rule = {rule: compared(own) for rule, own in found.items()}
    lost = {rule.short: len(judged.said) - len(own.said) for rule, own in found.items()}
    places = [
        place
        for knowledge in Knowledge
        for by, rules in (("by time", TIMES), ("by threshold and point measured", LIMITS))
        for rule in rules
        for place in _places(by_rule[rule], judged, plain, rule, by, knowledge)
    ]
    return Rankings(
        claims=sorted(_claims(by_rule, judged, plain), key=lambda c: list(Fate).index(c.fate)),
        rules=[_under(rule, found[rule], judged, places) for rule in RULES],
        places=places,
        accuracies={
            knowledge: [_accuracies(judged.keys[spec], knowledge, places) for spec in plain]
            for knowledge in Knowledge
        },
        cases=len(judged.said),
        item_lists=judged.labels["instance"].nunique(),
        lost={rule: missing for rule, missing in lost.items() if missing},
        made_with=manifest_lines(judged),
    )


def claim(
    text: str, knowledge: Knowledge, differences: Mapping[str, Estimate], item_lists: int
) -> Claim:
    """A conclusion, of the difference in accuracy by short name of the rule."""
    holds = [rule for rule, own in differences.items() if own.low > 0.0]
    turned = [rule for rule, own in differences.items() if own.high < 0.0]
    fate = Fate.SURVIVES if len(holds) == len(differences) else Fate.OPEN
    ordered = sorted(differences.values(), key=lambda own: own.value)
    return Claim(
        text=text,
        knowledge=knowledge,
        fate=Fate.TURNS if turned else fate,
        holds=Held(len(holds), len(differences)),
        turned=turned,
        least=ordered[0],
        greatest=ordered[-1],
        shown=max(detectable(each, item_lists) for each in ordered),
    )


def _claims(
    by_rule: Mapping[Rule, Compared[MethodKey]], judged: JudgedCases, plain: Sequence[str]
) -> Iterator[Claim]:
    for knowledge in Knowledge:
        for text, *pair in CLAIMS:
            if {*pair} <= {*plain}:
                differences = {}
                for rule, own in by_rule.items():
                    one, other = (judged.keys[_known(spec, rule, knowledge)] for spec in pair)
                    differences[rule.short] = difference(
                        own.right[one], own.right[other], own.clusters
                    )
                yield claim(text, knowledge, differences, judged.clusters.nunique())


def _known(spec: str, rule: Rule, knowledge: Knowledge) -> str:
    return rule.given_to(spec) if knowledge is Knowledge.TOLD else spec


def _places(
    own: Compared[MethodKey],
    judged: JudgedCases,
    plain: Sequence[str],
    rule: Rule,
    by: str,
    knowledge: Knowledge,
) -> Iterator[Place]:
    """A method each, under its name as it stands."""
    keys = {spec: judged.keys[_known(spec, rule, knowledge)] for spec in plain}
    better, worse = Counter[str](), Counter[str]()
    for one, other in combinations(keys, 2):
        ahead = difference(own.right[keys[one]], own.right[keys[other]], own.clusters)
        if ahead.low > 0.0 or ahead.high < 0.0:
            first, second = (one, other) if ahead.low > 0.0 else (other, one)
            better[second] += 1
            worse[first] += 1
    for spec, key in keys.items():
        ranks = Ranks(1 + better[spec], len(keys) - worse[spec])
        found = accuracy(own.right[key], own.clusters)
        yield Place(judged.keys[spec], rule.short, by, knowledge, found, ranks)


def _under(
    rule: Rule, found: JudgedCases, judged: JudgedCases, places: Sequence[Place]
) -> UnderRule:
    assert found.labels is not None
    labels = found.said[rule.label]
    usual = judged.said[USUAL.label].loc[labels.index]

    def first(knowledge: Knowledge) -> str:
        own = [p for p in places if (p.rule, p.knowledge) == (rule.short, knowledge)]
        most = max(own, key=lambda place: place.accuracy.value).accuracy
        best = [place.method.title for place in own if place.accuracy.value == most.value]
        return f"{names(dict.fromkeys(best))}, {percent(most)}"

    return UnderRule(
        rule=rule.name,
        n=len(labels),
        stable=float(found.labels["failing_step"].isna().mean()),
        changed=float((labels != usual).mean()),
        best=first(Knowledge.NONE),
        best_told=first(Knowledge.TOLD),
    )


def _accuracies(method: MethodKey, knowledge: Knowledge, places: Sequence[Place]) -> Accuracies:
    own = {
        place.rule: place
        for place in places
        if (place.method, place.knowledge) == (method, knowledge)
    }
    times, limits = ([own[rule.short] for rule in rules] for rules in (TIMES, LIMITS))
    return Accuracies(
        method=method.title,
        by_time={place.rule: place.accuracy for place in times},
        by_limit={place.rule: place.accuracy for place in limits},
        ranks_by_time={place.rule: place.ranks for place in times},
        ranks_by_limit={place.rule: place.ranks for place in limits},
    )

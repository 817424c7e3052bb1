"""The study of rules: labels, accuracies and fates are those that are worked out by hand."""

import math

import numpy as np
import pandas as pd
import pytest

from steadyload.layouts.benchmark import load_benchmark
from steadyload.layouts.model.question import Question
from steadyload.methods.registry import make_method
from steadyload.methods.simulation.criteria import Criterion
from steadyload.runs import frames as v
from steadyload.runs.failure_rules import LIMITS, RULES, TIMES, USUAL, Rule
from steadyload.statistics.estimate import Estimate
from steadyload.studies.kit import Lab
from steadyload.studies.sensitivity import ranking
from steadyload.studies.sensitivity.ranking import (
    CLAIMS,
    KNOWLEDGE,
    METHODS,
    OPEN,
    OWN,
    SURVIVES,
    TOLD,
    TURNS,
    claim,
)
from steadyload.studies.sensitivity.study import Sensitivity

SIMULATION, RULE = "ps_opt@mujoco", "sme"
FEW = 2
STUDY = Sensitivity(limit=FEW)


def named(name):
    return next(rule for rule in RULES if rule.name == name)


KINDS = {"TIMES": TIMES, "LIMITS": LIMITS}
FEW_RULES = (USUAL, *map(named, ("0.15 s", "5 degrees", "centre, any time")))


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    """Under four of the rules, of both kinds; what the reference judges is most of the time."""
    some = {kind: [rule for rule in own if rule in FEW_RULES] for kind, own in KINDS.items()}
    with pytest.MonkeyPatch.context() as patch:
        methods = {"METHODS": (RULE, SIMULATION), "CLAIMS": CLAIMS[:1], "DIRECTORY": ""}
        for name, own in {"RULES": FEW_RULES, **some, **methods}.items():
            patch.setattr(ranking, name, tuple(own) if isinstance(own, list) else own)
        return STUDY.run(Lab(tmp_path_factory.mktemp("sensitivity"), workers=0))


# --- rules ----------------------------------------------------------------------------------------


def test_the_usual_rule_is_the_one_that_labels_are_made_by():
    assert make_method(USUAL.label).parameters == make_method("label@reference").parameters


def test_every_other_rule_differs_from_it_in_one_thing():
    for rule in RULES:
        fields = ("seconds", "eps_t", "eps_r", "criterion")
        differ = [name for name in fields if getattr(rule, name) != getattr(USUAL, name)]
        assert len(differ) == (rule is not USUAL), rule.name
    assert {*TIMES} | {*LIMITS} == {*RULES}
    assert {*TIMES} & {*LIMITS} == {USUAL}


@pytest.mark.parametrize("spec", [m for m in METHODS if m.startswith("ps")])
def test_a_simulation_that_is_told_a_rule_has_its_time_thresholds_and_criterion(spec):
    for rule in RULES:
        told = make_method(rule.given_to(spec)).parameters
        assert (told.eps_t, told.eps_r, told.criterion) == (rule.eps_t, rule.eps_r, rule.criterion)
        if rule.seconds is None:
            assert told.question is Question.STANDS
        else:
            assert told.question is Question.WITHIN
            assert told.t_max == rule.seconds


def test_what_a_rule_says_nothing_of_stays_as_it_was():
    before = make_method("ps3-literal@bullet").parameters
    told = make_method(named("0.6 s").given_to("ps3-literal@bullet")).parameters
    assert (told.frequency, told.margin, told.samples) == (60, before.margin, before.samples)
    narrower = make_method(named("0.6 s").given_to("ps_opt@mujoco:friction=0.4")).parameters
    assert narrower.friction == 0.4


def test_equilibrium_is_told_how_long_it_is_watched():
    assert make_method(named("1 s").given_to("equilibrium")).parameters.time == 1.0
    assert make_method(named("22 cm").given_to("equilibrium:time=0.3")).parameters.eps_t == 22.0
    assert make_method(named("stands").given_to("equilibrium:time=0.3")).parameters.time is None


def test_static_rules_hear_nothing_and_learners_hear_of_the_question_alone():
    for rule in RULES:
        assert rule.given_to("pbs0.5") == "pbs0.5"
        asked = "lstm_e:question=stands" if rule.seconds is None else "lstm_e"
        assert rule.given_to("lstm_e") == asked


def test_a_corner_that_comes_back_fails_by_the_centre_at_any_time_alone():
    """The criterion of the paper looks at every sample: no early exit is kept beside it."""
    told = make_method(named("centre, any time").label).parameters
    assert told.criterion is Criterion.PAPER
    assert told.early_exit == 0.0


def test_claims_are_of_methods_that_take_part():
    assert {spec for _, *pair in CLAIMS for spec in pair} <= {*METHODS}


# --- a run ----------------------------------------------------------------------------------------


def test_accuracies_are_counted_against_the_reference_under_the_same_rule(found):
    benchmark = load_benchmark()
    chosen = benchmark.select("test", limit=FEW)
    layouts = [
        benchmark.layout(name, scenario)
        for name, scenario in zip(chosen["layout"], chosen["scenario"], strict=True)
    ]

    def steps(spec):
        return [make_method(spec).judge(layout).failing_step for layout in layouts]

    for name in ("0.15 s", "5 degrees"):
        rule = named(name)
        labels = steps(rule.label)
        for knowledge, spec in (
            (OWN, SIMULATION),
            (TOLD, rule.given_to(SIMULATION)),
        ):
            right = sum(a == b for a, b in zip(steps(spec), labels, strict=True))
            shown = accuracies(found, knowledge)[rule.short, SIMULATION]
            assert shown.value == pytest.approx(right / len(layouts))
            assert shown.n == len(layouts)
        under = found.rules.set_index("rule").loc[rule.name]
        assert under["rule_stable"] == pytest.approx(labels.count(None) / len(layouts))
        usual = [None if pd.isna(x) else x for x in chosen["failing_step"]]
        changed = sum(a != b for a, b in zip(labels, usual, strict=True))
        assert under["changed"] == pytest.approx(changed / len(layouts))


def test_the_rules_part_on_these_cases(found):
    """Else the test before could not fail."""
    assert found.rules["changed"].any()
    shown = [one.value for (_, spec), one in accuracies(found, OWN).items() if spec == SIMULATION]
    assert len(set(shown)) > 1


def test_methods_that_do_not_differ_significantly_share_ranks(found):
    for knowledge in KNOWLEDGE:
        right = accuracies(found, knowledge)
        of = found.accuracies[knowledge]
        ranks = pd.concat([of["rank_time"], of["rank_limit"].drop(columns="title")], axis=1)
        ranks = ranks.loc[:, ~ranks.columns.duplicated()].drop(columns="title")
        for column, (rule, simulation) in ranks.loc[[RULE, SIMULATION]].items():
            short = column.partition(":")[2]
            both = [right[short, spec].value for spec in (RULE, SIMULATION)]
            assert (rule, simulation) in [("1 to 2", "1 to 2"), ("1", "2"), ("2", "1")]
            if both[0] == both[1]:
                assert rule == simulation == "1 to 2"
            if rule != simulation:
                assert (both[0] > both[1]) == (rule == "1")


def accuracies(found, knowledge):
    """By short name of the rule and method."""
    own = found.accuracies[knowledge]
    return {
        (column.partition(":")[2], spec): one
        for kind in ("right_time", "right_limit")
        for column in own[kind].columns[1:]
        for spec, one in own[kind][column].items()
    }


def test_ranks_count_the_methods_that_are_significantly_better_and_worse():
    """Of four methods on 400 cases apart: 90 %, 89.8 %, 60 % and 30 % right."""
    shares = {"a": 0.9, "b": 0.898, "c": 0.6, "d": 0.3}
    frame = pd.concat(
        pd.DataFrame({"layout": case, "scenario": "S1", "cluster": case, "method": name,
                      "right": case < round(400 * share)})
        for case in [np.arange(400)] for name, share in shares.items()
    )  # fmt: skip
    tests = pd.concat({"rule": v.both_ways(v.pairs(frame))}, names=["rule"])
    assert dict(ranking._ranks(tests).droplevel("rule")) == {
        "a": "1 to 2", "b": "1 to 2", "c": "3", "d": "4",
    }  # fmt: skip


def test_the_page_shows_what_was_found(found, assert_shown):
    assert list(found.rules["rule"]) == [rule.name for rule in FEW_RULES]
    assert_shown(
        STUDY,
        found,
        answer=[found.conclusions, found.hold, found.hold_told, len(found.rules), *found.open],
        charts=["accuracies"],
    )


# --- fates ----------------------------------------------------------------------------------------


def claimed(*intervals):
    differences = {
        rule.short: Estimate(0.5 * (low + high), low, high, 9)
        for rule, (low, high) in zip(RULES, intervals, strict=False)
    }
    return claim("A.", TOLD, pd.Series(differences, dtype=object), 90)


ABOVE, BELOW, ACROSS = (0.1, 0.2), (-0.2, -0.1), (-0.1, 0.1)


@pytest.mark.parametrize(
    ("intervals", "fate"),
    [
        ((ABOVE, ABOVE), SURVIVES),
        ((ABOVE, ACROSS), OPEN),
        ((ABOVE, BELOW), TURNS),
        ((ACROSS, BELOW), TURNS),
        ((ABOVE, (math.nan, math.nan)), OPEN),
    ],
)
def test_a_conclusion_survives_where_no_interval_reaches_zero(intervals, fate):
    assert claimed(*intervals)["fate"] == fate


def test_a_conclusion_has_the_least_difference_that_its_cases_show():
    """Of the widest interval: a difference that is found significant in four of five sets."""
    error, z, power = 0.1 / 1.959964, 1.959964, 0.841621
    expected = error * (z / math.sqrt(1.0 - z * z / 90) + power)
    assert claimed(ABOVE, ACROSS)["shown"] == pytest.approx(expected, rel=1e-5)


def test_conclusions_are_counted_by_their_fates():
    """Three of them, by the differences of three methods under two rules."""

    def frame(shares):
        return pd.concat(
            pd.DataFrame({"layout": case, "scenario": "S1", "cluster": case, "method": name,
                          "right": case < share})
            for case in [np.arange(100)] for name, share in shares.items()
        )  # fmt: skip

    by_rule = {
        (OWN, "0.15 s"): {"x": 90, "y": 50, "z": 50}, (OWN, "3 s"): {"x": 90, "y": 50, "z": 90},
        (TOLD, "0.15 s"): {"x": 90, "y": 50, "z": 10}, (TOLD, "3 s"): {"x": 90, "y": 50, "z": 20},
    }  # fmt: skip
    tests = pd.concat(
        {of: v.both_ways(v.pairs(frame(shares))) for of, shares in by_rule.items()},
        names=["knowledge", "rule"],
    )
    asked = (("A.", "x", "y"), ("B.", "y", "z"), ("C.", "z", "x"))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(ranking, "CLAIMS", asked)
        claims = ranking._claims(tests, 100)
    assert list(zip(claims["claim"], claims["knowledge"], claims["fate"], strict=True)) == [
        ("A.", OWN, SURVIVES), ("A.", TOLD, SURVIVES), ("B.", TOLD, SURVIVES),
        ("B.", OWN, TURNS), ("C.", OWN, TURNS), ("C.", TOLD, TURNS),
    ]  # fmt: skip
    assert list(claims["turned"])[3:] == ["3 s", "0.15 s", "0.15 s, 3 s"]
    assert list(claims["holds"])[-1] == "0 of 2"


def test_a_rule_of_ones_own_is_told_like_any_other():
    own = Rule("half", seconds=0.45, eps_t=7.0)
    told = make_method(own.given_to("ps3@mujoco")).parameters
    assert (told.t_max, told.eps_t, told.eps_r) == (0.45, 7.0, 10.0)

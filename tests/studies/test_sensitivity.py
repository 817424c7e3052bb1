"""The study of rules: labels, accuracies and fates are those that are worked out by hand."""

import dataclasses
import math
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from steadyload.layouts.benchmark import load_benchmark
from steadyload.layouts.model.question import Question
from steadyload.methods.registry import make_method
from steadyload.methods.simulation.criteria import Criterion
from steadyload.runs.comparison import Compared
from steadyload.runs.failure_rules import LIMITS, RULES, TIMES, USUAL, Rule
from steadyload.statistics.estimate import Estimate
from steadyload.studies.kit import Lab
from steadyload.studies.sensitivity import ranking
from steadyload.studies.sensitivity.ranking import CLAIMS, METHODS, Fate, Knowledge, Rankings, claim
from steadyload.studies.sensitivity.study import Sensitivity

SIMULATION, RULE = "ps_opt@mujoco", "sme"
FEW = 2
STUDY = Sensitivity(methods=(RULE, SIMULATION), limit=FEW)


def named(name):
    return next(rule for rule in RULES if rule.name == name)


KINDS = {"TIMES": TIMES, "LIMITS": LIMITS}
FEW_RULES = (USUAL, *map(named, ("0.15 s", "5 degrees", "centre, any time")))


@pytest.fixture(scope="module")
def found(tmp_path_factory) -> Rankings:
    """Under four of the rules, of both kinds; what the reference judges is most of the time."""
    some = {kind: [rule for rule in own if rule in FEW_RULES] for kind, own in KINDS.items()}
    with pytest.MonkeyPatch.context() as patch:
        for name, own in {"RULES": FEW_RULES, **some}.items():
            patch.setattr(ranking, name, tuple(own))
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
            (Knowledge.NONE, SIMULATION),
            (Knowledge.TOLD, rule.given_to(SIMULATION)),
        ):
            right = sum(a == b for a, b in zip(steps(spec), labels, strict=True))
            [place] = [
                place
                for place in found.places
                if (place.method.spec, place.rule, place.knowledge)
                == (SIMULATION, rule.short, knowledge)
            ]
            assert place.accuracy.value == pytest.approx(right / len(layouts))
            assert place.accuracy.n == len(layouts)
        [under] = [one for one in found.rules if one.rule == rule.name]
        assert under.stable == pytest.approx(labels.count(None) / len(layouts))
        usual = [None if pd.isna(x) else x for x in chosen["failing_step"]]
        changed = sum(a != b for a, b in zip(labels, usual, strict=True))
        assert under.changed == pytest.approx(changed / len(layouts))


def test_the_rules_part_on_these_cases(found):
    """Else the test before could not fail."""
    assert any(under.changed for under in found.rules)
    assert len({p.accuracy.value for p in found.places if p.method.spec == SIMULATION}) > 1


def test_methods_that_do_not_differ_significantly_share_ranks(found):
    for first, second in zip(found.places[::2], found.places[1::2], strict=True):
        assert (first.rule, first.by, first.knowledge) == (second.rule, second.by, second.knowledge)
        ranks = sorted((first.ranks, second.ranks))
        assert ranks in ([(1, 2), (1, 2)], [(1, 1), (2, 2)])
        if first.accuracy.value == second.accuracy.value:
            assert ranks == [(1, 2), (1, 2)]
        if ranks == [(1, 1), (2, 2)]:
            assert (first.accuracy.value > second.accuracy.value) == (first.ranks == (1, 1))


def test_ranks_count_the_methods_that_are_significantly_better_and_worse():
    """Of four methods on 400 cases apart: 90 %, 89.8 %, 60 % and 30 % right."""
    shares = {"a": 0.9, "b": 0.898, "c": 0.6, "d": 0.3}
    right = {name: np.arange(400) < round(400 * share) for name, share in shares.items()}
    judged = SimpleNamespace(keys={name: name for name in right})
    rule = SimpleNamespace(short="rule", given_to=lambda spec: spec)
    places = ranking._places(
        Compared(right, np.arange(400)), judged, list(right), rule, "by time", Knowledge.NONE
    )
    assert [str(place.ranks) for place in places] == ["1 to 2", "1 to 2", "3", "4"]


def test_the_page_shows_what_was_found(found, assert_shown):
    assert [one.rule for one in found.rules] == [rule.name for rule in FEW_RULES]
    both, _ = found.survivors
    assert_shown(
        STUDY,
        found,
        answer=[len(found.informed), len(both), len(found.rules), *found.open],
        tables=[found.claims, found.rules, *(4 * [*found.accuracies.values()])],
        charts=["accuracies"],
    )


# --- fates ----------------------------------------------------------------------------------------


def claimed(text, knowledge, *intervals):
    differences = {
        rule.short: Estimate(0.5 * (low + high), low, high, 9)
        for rule, (low, high) in zip(RULES, intervals, strict=False)
    }
    return claim(text, knowledge, differences, 90)


ABOVE, BELOW, ACROSS = (0.1, 0.2), (-0.2, -0.1), (-0.1, 0.1)


@pytest.mark.parametrize(
    ("intervals", "fate"),
    [
        ((ABOVE, ABOVE), Fate.SURVIVES),
        ((ABOVE, ACROSS), Fate.OPEN),
        ((ABOVE, BELOW), Fate.TURNS),
        ((ACROSS, BELOW), Fate.TURNS),
        ((ABOVE, (math.nan, math.nan)), Fate.OPEN),
    ],
)
def test_a_conclusion_survives_where_no_interval_reaches_zero(intervals, fate):
    assert claimed("A.", Knowledge.TOLD, *intervals).fate is fate


def test_a_conclusion_has_the_least_difference_that_its_cases_show():
    """Of the widest interval: a difference that is found significant in four of five sets."""
    error, z, power = 0.1 / 1.959964, 1.959964, 0.841621
    expected = error * (z / math.sqrt(1.0 - z * z / 90) + power)
    assert claimed("A.", Knowledge.TOLD, ABOVE, ACROSS).shown == pytest.approx(expected, rel=1e-5)


def test_conclusions_are_counted_by_their_fates(found):
    told, standing = Knowledge.TOLD, Knowledge.NONE
    claims = [
        claimed("A is better.", told, ABOVE, ABOVE),
        claimed("A is better.", standing, ABOVE, ABOVE),
        claimed("B is better.", told, ABOVE, ABOVE),
        claimed("B is better.", standing, ABOVE, BELOW),
        claimed("C is better.", told, BELOW, ABOVE),
        claimed("C is better.", standing, ACROSS, ABOVE),
    ]
    own = dataclasses.replace(found, claims=claims)
    a_told, a, b_told, b, c_told, c = claims
    assert (own.informed, own.standing) == ([a_told, b_told, c_told], [a, b, c])
    assert own.survivors == ([a_told], [b_told])
    assert (own.open, b.turned, c_told.turned) == ((1, 0), [RULES[1].short], [RULES[0].short])
    more = [claimed("D is better.", of, ACROSS, ABOVE) for of in (told, standing)]
    assert dataclasses.replace(found, claims=[*claims, *more]).open == (2, 1)


def test_a_rule_of_ones_own_is_told_like_any_other():
    own = Rule("half", seconds=0.45, eps_t=7.0)
    told = make_method(own.given_to("ps3@mujoco")).parameters
    assert (told.t_max, told.eps_t, told.eps_r) == (0.45, 7.0, 10.0)

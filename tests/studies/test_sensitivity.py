"""The study of rules: labels, accuracies and fates are those that are worked out by hand."""

import dataclasses
import math

import pandas as pd
import pytest

from steadyload.layouts.benchmark import load_benchmark
from steadyload.layouts.model.question import Question
from steadyload.methods.registry import make_method
from steadyload.methods.simulation.criteria import Criterion
from steadyload.reports.pages.writing import write_page
from steadyload.runs.failure_rules import LIMITS, RULES, TIMES, USUAL, Rule
from steadyload.statistics.estimate import Estimate
from steadyload.studies.kit import Lab
from steadyload.studies.rankings import CLAIMS, METHODS, Fate, Knowledge, Rankings, claim
from steadyload.studies.sensitivity.study import Sensitivity

SIMULATION, RULE = "ps_opt@mujoco", "sme"
FEW = 2
STUDY = Sensitivity(methods=(RULE, SIMULATION), limit=FEW)


def named(name):
    return next(rule for rule in RULES if rule.name == name)


@pytest.fixture(scope="module")
def work(tmp_path_factory):
    return tmp_path_factory.mktemp("sensitivity")


@pytest.fixture(scope="module")
def found(work) -> Rankings:
    return STUDY.run(Lab(work, workers=0))


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


def test_the_most_accurate_is_first_and_equal_ones_share_a_rank(found):
    for first, second in zip(found.places[::2], found.places[1::2], strict=True):
        assert (first.rule, first.by, first.knowledge) == (second.rule, second.by, second.knowledge)
        if first.accuracy.value == second.accuracy.value:
            assert first.rank == second.rank == 1
        else:
            best, other = sorted((first, second), key=lambda place: -place.accuracy.value)
            assert (best.rank, other.rank) == (1, 2)


def test_a_second_run_judges_nothing(found, work):
    before = {path: path.stat().st_mtime_ns for path in work.rglob("results/*.parquet")}
    assert before
    assert STUDY.run(Lab(work, workers=0)) == found
    assert {path: path.stat().st_mtime_ns for path in work.rglob("results/*.parquet")} == before


def test_the_page_names_every_rule_and_says_how_many(found, tmp_path):
    text = write_page(STUDY.page(found), tmp_path).read_text()
    for rule in RULES:
        assert f"| {rule.name} " in text
    assert "All on 6 cases of" in text
    assert "](figures/ranks." in text


# --- fates ----------------------------------------------------------------------------------------


def claimed(text, knowledge, *intervals):
    differences = {
        rule.short: Estimate(0.5 * (low + high), low, high, 9)
        for rule, (low, high) in zip(RULES, intervals, strict=False)
    }
    return claim(text, knowledge, differences)


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


def test_the_sentence_names_what_survives_and_what_is_turned_round(found):
    told, standing = Knowledge.TOLD, Knowledge.NONE
    claims = (
        claimed("A is better.", told, ABOVE, ABOVE),
        claimed("A is better.", standing, ABOVE, ABOVE),
        claimed("B is better.", told, ABOVE, ABOVE),
        claimed("B is better.", standing, ABOVE, BELOW),
        claimed("C is better.", told, BELOW, ABOVE),
        claimed("C is better.", standing, ACROSS, ABOVE),
    )
    text = STUDY.page(dataclasses.replace(found, claims=claims)).summary
    kept, loose, tight = text.split("Reversed")
    kept, where_told = kept.split("Where methods take the parameters of the rule")
    assert "Of 3 conclusions" in kept
    assert "A is better" in kept
    assert "B is better" not in kept
    assert "C is better" not in kept
    assert "1 more holds: B is better" in where_told
    second = RULES[1]
    assert f"B is better ({second.short})" in loose
    assert f"C is better ({RULES[0].short})" in tight
    assert "Open are 1 where methods keep their own parameters, and 0 where they take those" in text
    more = (
        claimed("D is better.", told, ACROSS, ABOVE),
        claimed("D is better.", standing, ACROSS, ABOVE),
    )
    text = STUDY.page(dataclasses.replace(found, claims=(*claims, *more))).summary
    assert "Open are 2 where methods keep their own parameters, and 1 where they take those" in text


def test_a_rule_of_ones_own_is_told_like_any_other():
    own = Rule("half", seconds=0.45, eps_t=7.0)
    told = make_method(own.given_to("ps3@mujoco")).parameters
    assert (told.t_max, told.eps_t, told.eps_r) == (0.45, 7.0, 10.0)

"""How probable it is that a load stands, against closed forms and brute force."""

import math

import numpy as np
import pytest
from scipy.stats import binom, binomtest, norm, truncnorm

from steadyload.layouts import Item, Layout, Pallet
from steadyload.layouts.benchmark import load_benchmark
from steadyload.layouts.packing.packing import random_layouts
from steadyload.methods.contract.method import Status
from steadyload.methods.contract.spec import SpecError
from steadyload.methods.registry import make_method
from steadyload.methods.uncertainty import (
    Uncertainty,
    dimensions,
    judge_deviated,
    parse_uncertainty,
)
from steadyload.runs.verdict_reliability import (
    REPLICATES,
    Ending,
    Sampling,
    VerdictReliability,
    standing_interval,
    variance_by_scramblings,
    verdict_reliability,
)

BALANCE = make_method("equilibrium")
UNSURE = (
    ("H10_Class_2_Instance_12_ULD_0", "S1"),
    ("H117_Class_3_Instance_14_ULD_1", "S2a"),
    ("H27_Class_2_Instance_9_ULD_0", "S2b"),
    ("H17_Class_1_Instance_8_ULD_0", "S2b"),
)
"""Labelled cases that a few millimetres decide."""


def towers(*overhangs):
    """Towers far apart, of two cubes each: the upper one sticks out along x by so many cm."""
    items = []
    for k, overhang in enumerate(overhangs):
        x = 20.0 + 40.0 * k
        items.append(Item(2 * k, (x, 0.0, 40.0), (10.0, 10.0, 10.0), 1.0))
        items.append(Item(2 * k + 1, (x + overhang, 10.0, 40.0), (10.0, 10.0, 10.0), 1.0))
    return Layout("towers", Pallet(40.0 + 40.0 * len(overhangs), 40.0, 100.0), tuple(items))


def stands_by_centres(overhang, spread):
    """An upper cube stands where its centre of mass, within it, is above the lower one."""
    ends = -5.0 / spread, 5.0 / spread
    law = truncnorm(*ends, scale=spread)
    return law.cdf(5.0 - overhang) - law.cdf(-5.0 - overhang)


def test_fifty_probabilities_lie_in_their_intervals():
    random = np.random.default_rng(11)
    inside = narrow = 0
    for _ in range(50):
        overhangs = random.uniform(3.8, 5.4, 2)
        truth = math.prod(stands_by_centres(each, 0.5) for each in overhangs)
        found = verdict_reliability(
            BALANCE, towers(*overhangs), Uncertainty(com=0.5), Sampling(0.07)
        )
        inside += found.low <= truth <= found.high
        narrow += found.high - found.low <= 0.14
        assert found.stands == pytest.approx(truth, abs=0.08)
    assert inside >= 48  # of 50 at 95 %; the looks share the chance to miss, so most hold more
    assert narrow == 50


def test_random_samples_agree_with_the_interval():
    benchmark, spread = load_benchmark(), parse_uncertainty("com=5mm,position=3mm")
    for name, scenario in UNSURE:
        layout = benchmark.layout(name, scenario)
        found = verdict_reliability(BALANCE, layout, spread)
        assert 0.05 < found.stands < 0.95
        uniforms = np.random.default_rng(5).random((500, dimensions(len(layout))))
        verdicts = judge_deviated(BALANCE, layout, spread, uniforms)
        error = 3.0 * 0.5 / math.sqrt(500)  # of the random samples
        share = np.mean([v.stable for v in verdicts])
        assert found.low - error <= share <= found.high + error


def test_every_failing_step_has_its_probability():
    overhangs = 4.8, 4.6, 4.7
    each = [stands_by_centres(overhang, 0.5) for overhang in overhangs]
    found = verdict_reliability(
        BALANCE, towers(*overhangs), Uncertainty(com=0.5), Sampling(half_width=0.02)
    )
    expected = {
        1: 1 - each[0],
        3: each[0] * (1 - each[1]),
        5: each[0] * each[1] * (1 - each[2]),
        None: math.prod(each),
    }
    assert list(found.shares) == [1, 3, 5, None]
    assert found.shares == pytest.approx(expected, abs=0.04)
    assert found.likeliest == max(expected, key=expected.get)
    score = sum(p * (1.0 if step is None else step / 6) for step, p in expected.items())
    assert found.expected_score == pytest.approx(score, abs=0.03)


def test_places_of_two_cubes_deviate_apart():
    # Both are put down 0.3 cm off, independently: the overhang is so by sqrt(2) times that.
    found = verdict_reliability(
        BALANCE, towers(4.7), Uncertainty(position=0.3), Sampling(half_width=0.03)
    )
    assert found.low <= norm.cdf(0.3 / (0.3 * math.sqrt(2.0))) <= found.high


def test_friction_deviates_where_a_method_has_some():
    # A box of 1 kg is clamped between two of 1.5 kg. Each of these rubs on the floor with up to
    # mu (1.5 + 0.5) kg and must carry 0.5 kg by rubbing with mu: it stands from mu = 0.5 on.
    clamped = Layout(
        "clamped",
        Pallet(100.0, 100.0, 100.0),
        (
            Item(0, (0.0, 0.0, 0.0), (40.0, 10.0, 10.0), 1.5),
            Item(1, (50.0, 0.0, 0.0), (40.0, 10.0, 10.0), 1.5),
            Item(2, (40.0, 2.0, 0.0), (10.0, 6.0, 10.0), 1.0),
        ),
    )
    method = make_method("equilibrium:sides=friction,friction=0.55")
    found = verdict_reliability(
        method, clamped, Uncertainty(friction=0.1), Sampling(half_width=0.04)
    )
    assert found.nominal.stable
    assert found.low <= norm.cdf(0.5) <= found.high
    assert found.without_effect == ()
    rule = verdict_reliability(make_method("sme"), clamped, Uncertainty(friction=0.1))
    assert rule.without_effect == ("friction",)
    assert rule.shares == {2: 1.0}


def test_all_samples_alike_leave_an_interval():
    low, high = standing_interval([True] * 64, [False] * 64, 0.05)
    assert (low, high) == (pytest.approx(0.025 ** (1 / 64)), 1.0)
    low, high = standing_interval([False] * 64, [False] * 64, 0.05)
    assert (low, high) == (0.0, pytest.approx(1.0 - 0.025 ** (1 / 64)))


@pytest.mark.parametrize("p", [0.02, 0.1, 0.3, 0.5, 0.9])
def test_intervals_of_random_samples_hold_the_truth(p):
    random = np.random.default_rng(3)
    runs = random.random((600, 256)) < p
    ends = [standing_interval(run, np.zeros(256)) for run in runs]
    hits = sum(low <= p <= high for low, high in ends)
    # 95 %, less what chance does to 600 runs; the better of two variances costs a little.
    assert hits >= binom.ppf(0.001, 600, 0.94)


def test_looking_again_and_again_keeps_the_promise():
    looks, p, missed = Sampling().looks, 0.1, 0
    random = np.random.default_rng(8)
    for _ in range(400):
        stood = random.random(looks[-1]) < p
        for look in looks:
            ends = standing_interval(stood[:look], np.zeros(look), 0.05 / len(looks))
            if not ends[0] <= 0.9 * p <= ends[1]:  # decided, beside the truth
                break
        missed += not ends[0] <= p <= ends[1]
    assert missed <= binom.ppf(0.999, 400, 0.05)


def test_even_samples_narrow_the_interval():
    random = np.random.default_rng(3).random((16, REPLICATES)) < 0.5
    even = np.repeat([True, False], 8 * REPLICATES)  # every scrambling has half of each
    apart = [
        np.subtract(*standing_interval(each.ravel(), np.zeros(256))) for each in (random, even)
    ]
    assert apart[1] / apart[0] == pytest.approx(0.5, abs=0.1)  # worth four times as many, at most


def test_scramblings_lie_closer_together_than_random_samples():
    # One number decides, and each scrambling has one of its 16 points in every sixteenth of it.
    found = verdict_reliability(
        BALANCE, towers(4.8), Uncertainty(com=0.5), Sampling(half_width=0.001, most=256)
    )
    stands = np.array(found.said) == 2
    random = stands.mean() * (1.0 - stands.mean()) / 256
    assert variance_by_scramblings(stands) < random / 3.0
    shuffled = np.random.default_rng(0).permutation(stands)
    assert variance_by_scramblings(shuffled) > random / 3.0


def test_a_sample_is_the_same_for_every_method_layout_and_length():
    near, far = towers(4.8), towers(4.8, 0.0)
    spread = Uncertainty(com=0.5, position=0.3)
    said = [
        verdict_reliability(method, layout, spread, Sampling(half_width=0.001, most=most)).said
        for method, layout, most in (
            (BALANCE, near, 64), (BALANCE, near, 128), (make_method("sme"), near, 64),
            (BALANCE, far, 64),
        )
    ]  # fmt: skip
    falls = [np.array(each) == 1 for each in said]
    assert 0 < falls[0].sum() < 64
    assert (falls[1][:64] == falls[0]).all()
    assert (falls[2] == falls[0]).all()
    assert (falls[3] == falls[0]).all()
    other = verdict_reliability(BALANCE, near, spread, Sampling(seed=1)).said
    assert other[:64] != said[0]


def test_sampling_ends_when_enough_is_known():
    sure = verdict_reliability(BALANCE, towers(0.0), Uncertainty(com=0.5))
    assert (sure.samples, sure.ending, sure.stands) == (64, Ending.NARROW, 1.0)
    evenly = towers(5.0), Uncertainty(com=0.5)
    unsure = verdict_reliability(BALANCE, *evenly)
    assert (unsure.ending, unsure.samples > 64) == (Ending.NARROW, True)
    decided = verdict_reliability(BALANCE, *evenly, Sampling(decide=0.9))
    assert (decided.ending, decided.samples) == (Ending.DECIDED, 64)
    spent = verdict_reliability(BALANCE, *evenly, Sampling(half_width=0.01, most=200))
    assert (spent.ending, spent.samples) == (Ending.SPENT, 128)
    assert spent.high - spent.low > 0.02


def test_samples_without_a_verdict_count_for_neither_side():
    method = make_method("label@mujoco")
    none = verdict_reliability(method, towers(0.0), Uncertainty(com=0.5), timeout=1e-9)
    assert none.nominal.status is Status.TIMEOUT
    assert (none.without_verdict, none.ending) == ({"timeout": 64}, Ending.NO_VERDICT)
    assert (none.stands, none.expected_score, none.low, none.high) == (None, None, 0.0, 1.0)
    assert "no verdict within" in none.why
    # 32 stand, 16 fall, 16 say nothing: from 32 to 48 of 64 stand.
    low, high = standing_interval([True] * 32 + [False] * 32, [False] * 48 + [True] * 16)
    assert low == pytest.approx(binomtest(32, 64).proportion_ci(method="exact").low)
    assert high == pytest.approx(binomtest(48, 64).proportion_ci(method="exact").high)


def test_a_plan_that_is_refused_is_not_sampled():
    found = verdict_reliability(make_method("ps3@chipmunk"), towers(1.0, 1.0), Uncertainty(com=0.5))
    assert found.nominal.status is Status.DONE  # planar: all are as deep, one behind the other
    odd = Layout("odd", Pallet(50.0, 50.0, 50.0), (
        Item(0, (0.0, 0.0, 0.0), (10.0, 10.0, 10.0), 1.0),
        Item(1, (20.0, 0.0, 5.0), (10.0, 10.0, 8.0), 1.0),
    ))  # fmt: skip
    refused = verdict_reliability(make_method("ps3@chipmunk"), odd, Uncertainty(com=0.5))
    assert (refused.samples, refused.ending) == (0, Ending.REFUSED)
    assert "planar" in refused.nominal.reason


def test_a_planar_layout_deviates_in_its_plane_where_the_engine_has_no_other():
    spread = Uncertainty(com=0.5, position=0.3)
    found = verdict_reliability(make_method("ps3@chipmunk"), towers(4.5), spread, Sampling(most=64))
    assert (found.without_verdict, found.samples) == ({}, 64)
    assert 0.0 < found.stands < 1.0


def test_batches_say_what_single_judgements_say():
    method = make_method("lstm_1:outside=accept")
    layout = random_layouts(9, seed=2)[8]
    spread = Uncertainty(com=1.0, position=0.5)
    found = verdict_reliability(method, layout, spread, Sampling(most=64))
    uniforms = np.random.default_rng(0).random((40, dimensions(len(layout))))
    batched = judge_deviated(method, layout, spread, uniforms)
    single = [judge_deviated(method, layout, spread, row[None])[0] for row in uniforms]
    assert [v.failing_step for v in batched] == [v.failing_step for v in single]
    assert isinstance(found, VerdictReliability)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("com=5kg", "com is '5kg'; allowed units: cm, m, mm"),
        ("comm=5mm", "did you mean 'com'?"),
        ("com=-1", "com is -1; allowed: a number, 0 to 1,000 [cm]"),
        ("com=nan", "allowed: a finite number"),
        ("weight=5", "weight is 5; allowed: a number, 0 to 1"),
        ("friction=10%", "allowed units: none"),
        ("com", "is not of the form key=value"),
        ("com=1,com=2", "com stands there twice"),
        ("com=0", "nothing is uncertain; allowed: at least one of com, position, weight"),
        ("", "nothing is"),
    ],
)
def test_what_cannot_be_uncertain_is_refused(text, message):
    with pytest.raises(SpecError) as caught:
        parse_uncertainty(text)
    assert message in str(caught.value)


def test_units_become_those_of_layouts():
    found = parse_uncertainty("com=5mm,position=0.003m,weight=5%,friction=0.1")
    assert found == Uncertainty(com=0.5, position=0.3, weight=0.05, friction=0.1)
    assert parse_uncertainty(str(found)) == found
    assert parse_uncertainty("com=0.5") == Uncertainty(com=0.5)

"""Expected costs of errors, and who is the cheapest at which ratio of costs."""

import itertools

import numpy as np
import pytest

from steadyload.statistics.error_costs import CheapestRange, ErrorShares, cheapest_by_ratio
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.metrics import share


def shares(over, under, n=100):
    return ErrorShares(Estimate(over, over, over, n), Estimate(under, under, under, n))


def test_a_cost_is_that_of_every_error():
    random = np.random.default_rng(5)
    error = random.choice(["none", "over", "under"], 500, p=[0.8, 0.05, 0.15])
    found = ErrorShares(share(error == "over"), share(error == "under"))
    for ratio in (0.01, 1.0, 30.0):
        each = np.select([error == "over", error == "under"], [ratio, 1.0], 0.0)
        cost = found.cost(ratio)
        assert cost.value == pytest.approx(each.mean())
        assert cost.n == 500


@pytest.mark.parametrize("ratio", [0.1, 1.0, 10.0])
def test_intervals_hold_the_true_cost_often_enough(ratio):
    random = np.random.default_rng(6)
    inside, rounds = 0, 600
    for _ in range(rounds):
        error = random.choice(3, 400, p=[0.87, 0.03, 0.1])
        cost = ErrorShares(share(error == 1), share(error == 2)).cost(ratio)
        assert 0.0 <= cost.low <= cost.value <= cost.high
        inside += cost.low <= ratio * 0.03 + 0.1 <= cost.high
    assert 0.93 <= inside / rounds <= 0.99


def test_the_cheapest_are_those_that_a_search_finds():
    random = np.random.default_rng(7)
    for _ in range(50):
        methods = {f"m{k}": shares(*random.random(2) ** 3) for k in range(12)}
        found = cheapest_by_ratio(methods)
        assert (found[0].least, found[-1].most) == (0.01, 100.0)
        for before, after in itertools.pairwise(found):
            assert before.most == after.least
            assert before.method != after.method
        for each in found:
            assert each.least < each.most
            for ratio in np.geomspace(each.least, each.most, 20):
                costs = {name: own.cost(ratio).value for name, own in methods.items()}
                assert costs[each.method] <= min(costs.values()) * (1.0 + 1e-12)


def test_ranges_meet_where_costs_are_equal():
    # 0.1 r + 0.02 = 0.01 r + 0.2 at r = 2; a third is never the cheapest.
    methods = {"bold": shares(0.1, 0.02), "shy": shares(0.01, 0.2), "bad": shares(0.2, 0.3)}
    first, second = cheapest_by_ratio(methods)
    assert (first.method, second.method) == ("bold", "shy")
    assert first.most == second.least == pytest.approx(2.0)


def test_one_method_is_the_cheapest_everywhere_and_of_equal_ones_the_first():
    only = {"one": shares(0.1, 0.1), "same": shares(0.1, 0.1), "worse": shares(0.1, 0.2)}
    assert cheapest_by_ratio(only) == (CheapestRange("one", 0.01, 100.0),)
    assert cheapest_by_ratio({}) == ()


def test_methods_that_hardly_differ_are_told_apart():
    # 0.1 r + 0.02 = 0.095 r + 0.0202 at r = 0.04.
    first, second = cheapest_by_ratio({"a": shares(0.1, 0.02), "b": shares(0.095, 0.0202)})
    assert (first.method, second.method) == ("a", "b")
    assert second.least == pytest.approx(0.04)

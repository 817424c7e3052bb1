"""Intervals and agreement against values known from elsewhere."""

import math

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import binom

from steadyload.statistics.metrics import (
    agreement,
    mean,
    median,
    outcomes,
    quantile,
    ratio,
    share,
    weighted_share,
)


@pytest.mark.parametrize(
    ("hits", "n", "low", "high"),
    # statsmodels.stats.proportion.proportion_confint(method="wilson")
    [(0, 10, 0.0, 0.277533), (10, 10, 0.722467, 1.0), (81, 263, 0.255262, 0.366203)],
)
def test_wilson(hits, n, low, high):
    estimate = share([True] * hits + [False] * (n - hits))
    assert (estimate.value, estimate.n) == (hits / n, n)
    assert (estimate.low, estimate.high) == pytest.approx((low, high), abs=2e-4)


def test_a_share_of_nothing_is_not_a_number():
    assert math.isnan(share([]).value)
    assert math.isnan(mean([]).value)


@given(st.lists(st.integers(1, 300), min_size=1, max_size=30), st.data())
def test_no_hit_has_no_wider_interval_than_any_number_of_hits(sizes, data):
    clusters = np.repeat(np.arange(len(sizes)), sizes)
    struck = data.draw(st.lists(st.integers(0, len(clusters) - 1), min_size=1, max_size=8))
    hits = np.zeros(len(clusters), bool)
    none, every = share(hits, clusters), share(~hits, clusters)
    hits[struck] = True
    some, others = share(hits, clusters), share(~hits, clusters)
    assert (none.value, none.low, every.value, every.high) == (0.0, 0.0, 1.0, 1.0)
    assert none.high <= some.high + 1e-12
    assert every.low >= others.low - 1e-12
    # Independent cases say most; a hit in one cluster is not many times surer than none.
    assert none.high >= share(np.zeros(len(clusters), bool)).high
    assert every.low == pytest.approx(1.0 - none.high)


@settings(max_examples=25)
@given(st.integers(10, 60), st.integers(1, 200))
def test_one_hit_more_widens_an_interval_where_hits_are_spread_over_clusters(lists, size):
    clusters = np.tile(np.arange(lists), size)
    ends = [
        share(np.arange(len(clusters)) < k, clusters).high
        for k in range(min(25, lists * size // 2))
    ]
    assert (np.diff(ends) >= -1e-12).all()


def test_no_hit_is_not_many_times_less_certain_than_two():
    """3,000 cases of 15 item lists: a third of 3,000 was possible at 0 hits, and 0.4 % at 2."""
    clusters = np.repeat(np.arange(15), 200)
    none, two = (share(np.arange(3000) < k, clusters) for k in (0, 2))
    assert none.high == two.high == pytest.approx(0.0063, abs=1e-4)
    # By hand: 3000 / (1 + 199 * 0.02) cases, and z^2 / (n + z^2) of them.
    assert none.high == pytest.approx(3.8415 / (3000 / 4.98 + 3.8415), rel=1e-4)
    # Many hits have the interval of the variance between clusters, as ever.
    many = share(np.arange(3000) % 10 == 0, clusters)
    assert (many.low, many.high) == pytest.approx((0.0898, 0.1113), abs=1e-4)


@pytest.mark.parametrize(("lists", "size", "rate"), [(15, 200, 0.002), (90, 10, 0.002)])
def test_intervals_of_rare_events_cover_where_lists_are_alike(lists, size, rate):
    """Rates of lists drawn from a beta law whose intra-class correlation is 0.02."""
    random = np.random.default_rng(4)
    clusters = np.repeat(np.arange(lists), size)
    rates = random.beta(rate * 49.0, (1.0 - rate) * 49.0, (300, lists))
    found = [share(random.random(lists * size) < np.repeat(own, size), clusters) for own in rates]
    assert np.mean([f.low <= rate <= f.high for f in found]) > 0.92


def test_a_ratio_is_that_of_two_means_over_the_same_cases():
    random = np.random.default_rng(2)
    below = random.gamma(4.0, 1.0, 400)
    same = ratio(3.0 * below, below)
    assert (same.value, same.low, same.high, same.n) == pytest.approx((3.0, 3.0, 3.0, 400))
    above = below + random.normal(0.0, 1.0, 400)
    found = ratio(above, below)
    half = 1.96 * (above - found.value * below).std() / math.sqrt(400) / below.mean()
    assert found.value == pytest.approx(above.mean() / below.mean())
    assert (found.value - found.low, found.high - found.value) == pytest.approx(
        (half,) * 2, rel=0.1
    )
    assert math.isnan(ratio([], []).value)


def test_the_bootstrap_covers_like_the_normal_law():
    values = np.random.default_rng(1).normal(5.0, 2.0, 400)
    estimate = mean(values)
    half = 1.96 * values.std() / math.sqrt(400)
    assert estimate.value == pytest.approx(values.mean())
    assert estimate.low == pytest.approx(values.mean() - half, abs=0.1 * half)
    assert estimate.high == pytest.approx(values.mean() + half, abs=0.1 * half)
    assert mean(values) == estimate


@pytest.mark.parametrize(
    ("n", "low", "high"),
    # Order statistics of the sign test: ranks of scipy.stats.binom.ppf(0.025, n, 0.5)
    [(1, 1, 1), (5, 1, 5), (6, 1, 6), (8, 1, 8), (9, 2, 8), (12, 3, 10), (20, 6, 15)],
)
def test_a_median_has_the_interval_of_order_statistics(n, low, high):
    estimate = median(np.random.default_rng(3).permutation(np.arange(1, n + 1)))
    assert (estimate.value, estimate.n) == ((n + 1) / 2, n)
    assert (estimate.low, estimate.high) == (low, high)
    assert math.isnan(median([]).value)


@pytest.mark.parametrize("share_", [0.1, 0.5, 0.9])
@pytest.mark.parametrize("n", [20, 143])
def test_a_quantile_lies_in_its_interval_in_95_of_100_samples(share_, n):
    random = np.random.default_rng(7)
    found = [quantile(random.random(n), share_) for _ in range(2000)]
    held = np.mean([one.low <= share_ <= one.high for one in found])
    at_an_end = n == 20 and share_ != 0.5  # the largest of 20 values may lie below: 0.9^20
    assert held > (0.86 if at_an_end else 0.945)
    assert held < 0.985
    assert np.mean([one.value for one in found]) == pytest.approx(share_, abs=0.05)


@pytest.mark.parametrize(
    ("values", "share_", "value", "low", "high"),
    [
        ([5.0], 0.9, 5.0, 5.0, 5.0),
        (range(1, 11), 0.9, 9.0, 7.0, 10.0),
        (range(1, 101), 0.9, 90.0, 84.0, 96.0),
        ([1.0, 2.0, math.inf, math.inf], 0.9, math.inf, 2.0, math.inf),
    ],
)
def test_a_quantile_is_a_value_that_is_there(values, share_, value, low, high):
    found = quantile(list(values), share_)
    assert (found.value, found.low, found.high, found.n) == (value, low, high, len(values))
    assert math.isnan(quantile([], share_).value)


def test_cases_of_one_layout_count_once():
    """The same answer in three scenarios is one observation; independent answers are three."""
    random = np.random.default_rng(2)
    answers = random.random(40) < 0.3
    layouts = np.arange(40)
    alone = share(answers)
    copied = share(np.repeat(answers, 3), np.repeat(layouts, 3))
    assert (copied.low, copied.high) == pytest.approx((alone.low, alone.high), abs=0.01)
    assert copied.n == 120
    independent = random.random(3000) < 0.3
    pooled = share(independent, np.repeat(np.arange(1000), 3))
    free = share(independent)
    assert pooled.high - pooled.low == pytest.approx(free.high - free.low, rel=0.1)
    scores = random.random(40)
    together = mean(np.repeat(scores, 3), np.repeat(layouts, 3))
    assert (together.low, together.high) == pytest.approx((mean(scores).low, mean(scores).high))


def frame(said):
    """Rows from {method: [failing step, None for stable, or a status]} on layouts of 5 items."""
    rows = []
    for method, answers in said.items():
        for index, answer in enumerate(answers):
            done = not isinstance(answer, str)
            rows.append(
                {
                    "layout": f"L{index}",
                    "scenario": "S1",
                    "method": method,
                    "repetition": 0,
                    "item_count": 5,
                    "status": "done" if done else answer,
                    "failing_step": answer if done else None,
                }
            )
    table = pd.DataFrame(rows)
    return table.astype({"failing_step": "Int32", "item_count": "Int32"})


def test_agreement_compares_failing_steps_and_a_missing_verdict_agrees_with_nothing():
    said = outcomes(frame({"a": [0, None, 3, "diverged", 4], "b": [0, None, 2, "diverged", None]}))
    assert said["a"].tolist()[:3] == [0, 5, 3]
    assert agreement(said, "a", "b").value == 0.4
    assert agreement(said, "b", "a") == agreement(said, "a", "b")
    # Even with itself: four of five verdicts exist.
    assert agreement(said, "a", "a").value == 0.8


def test_agreement_can_stand_on_wider_clusters():
    said = outcomes(frame({"a": [0, 1, 2, 3], "b": [0, 1, 3, 2]}))
    apart, together = agreement(said, "a", "b"), agreement(said, "a", "b", ["x", "x", "y", "y"])
    assert apart == share([True, True, False, False])
    assert together == share([True, True, False, False], ["x", "x", "y", "y"])
    assert together.high - together.low > apart.high - apart.low


def test_a_weighted_share_is_the_weighted_mean_of_shares():
    hits, strata = [True, False, True, True, False], ["a", "a", "b", "b", "b"]
    found = weighted_share(hits, strata, {"a": 3.0, "b": 1.0})
    assert found.value == pytest.approx((3 * 1 / 2 + 2 / 3) / 4)
    assert found.n == 5
    assert weighted_share(hits, strata, {"b": 1.0, "a": 0.0}).value == pytest.approx(2 / 3)
    assert weighted_share(hits, strata, {"a": 3.0, "b": 1.0}) == found
    assert math.isnan(weighted_share(hits, strata, {"a": 1.0, "c": 1.0}).value)


def test_a_weighted_share_of_one_stratum_is_a_mean():
    random = np.random.default_rng(5)
    hits, clusters = random.random(60) < 0.4, np.arange(60) // 4
    assert weighted_share(hits, ["a"] * 60, {"a": 2.0}, clusters) == mean(hits, clusters)


def test_the_interval_of_a_weighted_share_covers_like_the_normal_law():
    """Strata drawn independently: variances add with the squares of the weights."""
    random = np.random.default_rng(6)
    strata = np.repeat(["a", "b"], [900, 300])
    hits = random.random(1200) < np.where(strata == "a", 0.8, 0.3)
    found = weighted_share(hits, strata, {"a": 0.25, "b": 0.75})
    a, b = hits[:900].mean(), hits[900:].mean()
    half = 1.96 * math.sqrt(a * (1 - a) / 900 * 0.25**2 + b * (1 - b) / 300 * 0.75**2)
    assert found.value == pytest.approx(0.25 * a + 0.75 * b)
    assert found.low == pytest.approx(found.value - half, abs=0.1 * half)
    assert found.high == pytest.approx(found.value + half, abs=0.1 * half)
    # Every case four times over, as one cluster: four times the cases tell nothing more.
    many = weighted_share(np.repeat(hits, 4), np.repeat(strata, 4), {"a": 0.25, "b": 0.75},
                          np.repeat(np.arange(1200), 4))  # fmt: skip
    assert (many.low, many.high) == pytest.approx((found.low, found.high), abs=0.1 * half)


def test_a_resample_without_a_stratum_is_left_out():
    """Two clusters, one stratum each: only resamples that draw both say anything."""
    found = weighted_share([True, False], ["a", "b"], {"a": 0.4, "b": 0.6})
    assert (found.value, found.low, found.high) == pytest.approx((0.4, 0.4, 0.4))


@pytest.mark.parametrize("n", [1100, 5000])
def test_an_interval_of_many_values_leaves_out_as_many_as_the_binomial_law_allows(n):
    values = np.arange(float(n))
    for share_, found in ((0.5, median(values)), (0.9, quantile(values, 0.9))):
        below, above = int(found.low), n - 1 - int(found.high)
        for left_out, of_one in ((below, share_), (above, 1.0 - share_)):
            assert binom.cdf(left_out, n, of_one) <= 0.025 < binom.cdf(left_out + 1, n, of_one)

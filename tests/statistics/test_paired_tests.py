"""The paired test by item lists, Holm's correction and letters, against counting by hand."""

from itertools import combinations, product

import numpy as np
import pytest
from scipy.stats import binomtest, permutation_test

from steadyload.statistics.estimate import Estimate
from steadyload.statistics.metrics import mean
from steadyload.statistics.paired import LEVEL, detectable, holm, letters, sign_flip


def enumerated(differences, clusters):
    """The share of all sign vectors whose sum is as far from 0: written down anew."""
    sums = [
        sum(d for d, c in zip(differences, clusters, strict=True) if c == at)
        for at in sorted({*clusters})
    ]
    found = abs(sum(sums))
    flipped = [abs(sum(s * d for s, d in zip(signs, sums, strict=True)))
               for signs in product((1, -1), repeat=len(sums))]  # fmt: skip
    return sum(value >= found for value in flipped) / len(flipped)


@pytest.mark.parametrize("seed", range(12))
def test_the_exact_law_is_that_of_all_sign_vectors(seed):
    random = np.random.default_rng(seed)
    clusters = random.integers(0, 3 + seed % 8, 60)
    differences = random.choice((-1, 0, 0, 1, 1), 60)
    assert sign_flip(differences, clusters) == pytest.approx(
        enumerated(differences.tolist(), clusters.tolist()), abs=1e-12
    )


def test_single_cases_give_the_exact_mcnemar_test():
    differences = [1] * 11 + [-1] * 3 + [0] * 30
    expected = binomtest(11, 14).pvalue
    assert sign_flip(differences, range(44)) == pytest.approx(expected)


def test_it_agrees_with_scipys_test_of_paired_samples():
    random = np.random.default_rng(3)
    first, second = random.integers(0, 9, 9), random.integers(2, 11, 9)
    other = permutation_test(
        (first, second), lambda a, b, axis: (a - b).sum(axis=axis), permutation_type="samples",
        n_resamples=np.inf, vectorized=True,
    )  # fmt: skip
    assert sign_flip(first - second, range(9)) == pytest.approx(other.pvalue)


def test_copies_of_a_case_within_a_list_tell_no_more():
    differences, clusters = np.array([1, 1, 1, -1, 1, 1]), np.arange(6)
    once = sign_flip(differences, clusters)
    assert sign_flip(np.repeat(differences, 40), np.repeat(clusters, 40)) == once


def test_all_lists_on_one_side_give_the_smallest_p():
    assert sign_flip(np.ones(30), np.repeat(np.arange(15), 2)) == 2.0**-14
    assert sign_flip([], []) == 1.0
    assert sign_flip([0, 0], [0, 1]) == 1.0


def test_false_alarms_keep_to_the_level():
    random = np.random.default_rng(5)
    clusters = np.repeat(np.arange(10), 8)
    found = []
    for _ in range(400):
        lists = random.normal(0.0, 0.4, 10)[clusters]  # cases of a list are alike
        one, two = (random.random((2, 80)) < 0.5 + lists).astype(int)
        found.append(sign_flip(one - two, clusters))
    assert np.mean(np.array(found) < 0.05) < 0.08


def test_holm_on_an_example_by_hand():
    # Sorted: 0.005 x 4, 0.01 x 3, 0.03 x 2, 0.04 x 1; the last may not fall below the one before.
    assert holm([0.01, 0.04, 0.03, 0.005]) == pytest.approx([0.03, 0.06, 0.06, 0.02])
    assert holm([0.6, 0.5]) == [1.0, 1.0]
    assert holm([]) == []


@pytest.mark.parametrize("seed", range(8))
def test_two_share_a_letter_just_where_they_are_not_told_apart(seed):
    random = np.random.default_rng(seed)
    names = [f"m{k}" for k in range(9)]
    apart = {pair for pair in combinations(names, 2) if random.random() < 0.4}
    found = letters(names, apart)
    assert found["m0"].startswith("a")
    for one, other in combinations(names, 2):
        share = set(found[one]) & set(found[other])
        assert bool(share) == ((one, other) not in apart)


def test_letters_go_on_after_z():
    names = [f"m{k}" for k in range(30)]
    found = letters(names, set(combinations(names, 2)))
    assert [found[n] for n in ("m0", "m25", "m26", "m29")] == ["a", "z", "aa", "ad"]


@pytest.mark.parametrize("tests", [1, 43])
@pytest.mark.parametrize("alike", [0.0, 0.2])
def test_a_difference_that_a_set_shows_is_found_in_four_of_five_sets(tests, alike):
    random = np.random.default_rng(7)
    clusters, size = np.repeat(np.arange(90), 10), 10

    def drawn(true):
        """Cases on which one of two methods alone is right; lists have a bias of their own."""
        bias = np.repeat(random.normal(true, alike, 90), size)
        return np.sign(bias + random.uniform(-1.0, 1.0, len(clusters))) * (
            random.random(len(clusters)) < 0.2
        )

    shown = np.mean([detectable(mean(drawn(0.0), clusters), 90, tests) for _ in range(20)])
    sets = [drawn(shown / 0.2) for _ in range(500)]
    assert np.mean(sets) == pytest.approx(shown, rel=0.1)
    found = np.mean([sign_flip(own, clusters) < LEVEL / tests for own in sets])
    assert 0.7 < found < 0.9


def test_what_no_test_can_find_is_not_shown():
    few = Estimate(0.1, -0.1, 0.3, 9)
    for clusters in (1, 3):  # all lists on one side: p = 2 / 2^3
        assert sign_flip(np.ones(clusters), np.arange(clusters)) > LEVEL
        assert detectable(few, clusters) == np.inf
    assert 0.1 < detectable(few, 9) < 1.0
    assert detectable(Estimate(0.0, 0.0, 0.0, 9), 9) == 0.0

"""Clusters and their strata: resamples keep to them, and intervals follow their variance."""

import numpy as np
import pandas as pd
import pytest

from steadyload.statistics.clusters import Clusters
from steadyload.statistics.metrics import effective_size, mean, share
from steadyload.statistics.paired import sign_flip


def pairs(strata, names):
    """Labels of clusters in strata, as an array of pairs."""
    found = np.empty(len(names), dtype=object)
    found[:] = list(zip(strata, names, strict=True))
    return found


def test_a_resample_draws_as_many_clusters_of_each_stratum_as_there_are():
    names = [*range(10), *range(12), 11]
    labels = pairs("a" * 10 + "b" * 13, names)
    groups = Clusters.of(labels, len(labels))
    assert len(groups) == 22  # equal names in two strata are two clusters
    assert groups.sizes.tolist() == [1] * 21 + [2]
    assert [len(own) for own in groups.strata] == [10, 12]
    [drawn] = groups.resamples()  # so few clusters fit in memory at once
    assert drawn.shape == (2000, 22)
    for own in groups.strata:
        assert (np.isin(drawn, own).sum(axis=1) == len(own)).all()
        counts = np.array([(drawn == cluster).sum() for cluster in own]) / len(drawn)
        assert counts == pytest.approx(np.ones(len(own)), abs=0.1)


@pytest.mark.parametrize(
    ("sizes", "kept"),
    [
        ((2, 1, 1), [4]),
        ((9, 9, 9), [27]),
        ((40, 40, 1), [40, 41]),
        ((40, 6, 5), [11, 40]),
        ((10, 12, 11), [10, 11, 12]),
        ((9,), [9]),
    ],
)
def test_strata_of_few_clusters_are_put_together(sizes, kept):
    classes = np.repeat([f"{k}" for k in range(len(sizes))], sizes)
    groups = Clusters.of(pairs(classes, range(sum(sizes))), sum(sizes))
    assert sorted(map(len, groups.strata)) == kept
    assert sorted(np.concatenate(groups.strata).tolist()) == list(range(sum(sizes)))


@pytest.mark.parametrize("lists", [2, 3, 5, 10])
def test_the_interval_of_a_mean_covers_with_few_lists_a_class(lists):
    random = np.random.default_rng(lists)
    classes, names = np.repeat(list("abc"), lists), np.arange(3 * lists)
    covered = 0
    for _ in range(400):
        found = mean(random.normal(size=3 * lists), pairs(classes, names))
        covered += found.low <= 0.0 <= found.high
    least = {2: 0.8, 3: 0.85, 5: 0.87, 10: 0.9}  # a bootstrap of few is narrow, strata or not
    assert covered / 400 >= least[lists]


@pytest.mark.parametrize("labels", [["b", "a", "b", "c"], [7, 3, 7, 9], None])
def test_labels_without_strata_are_one_stratum(labels):
    groups = Clusters.of(labels, 4)
    assert len(groups.strata) == 1
    same = np.arange(4) if labels is None else np.unique(labels, return_inverse=True)[1]
    assert groups.member.tolist() == same.tolist()


def test_a_series_of_pairs_and_an_array_say_the_same():
    labels = pairs("aabb", "1212")
    hits = np.array([1.0, 0.0, 1.0, 1.0])
    assert mean(hits, pd.Series(labels)) == mean(hits, labels)


def test_intervals_follow_the_variance_of_the_stratified_mean():
    """Lists whose classes differ much: the closed form of stratified sampling, and less width."""
    random = np.random.default_rng(3)
    classes, lists = np.repeat(list("abc"), 40), np.arange(120)
    values = np.repeat([0.0, 5.0, 10.0], 40) + random.normal(size=120)
    found = mean(values, pairs(classes, lists))
    spread = [values[classes == c].var(ddof=1) / 40 for c in "abc"]
    half = 1.96 * np.sqrt(sum(spread) / 9)
    assert found.high - found.low == pytest.approx(2 * half, rel=0.06)
    plain = mean(values, lists)
    assert found.high - found.low < 0.4 * (plain.high - plain.low)


@pytest.mark.parametrize("sizes", [(2,), (3, 5), (4, 2, 6)])
def test_the_spread_of_a_sum_is_the_unbiased_variance_of_each_stratum(sizes):
    found = np.random.default_rng(len(sizes)).normal(size=sum(sizes))
    ends = np.cumsum(sizes)
    strata = tuple(np.arange(end - size, end) for size, end in zip(sizes, ends, strict=True))
    spread = Clusters(np.arange(len(found)), strata).squared_spread(found)
    # Of independent draws: variances of sums add up, and that of n draws is n times that of one.
    assert spread == pytest.approx(sum(len(own) * found[own].var(ddof=1) for own in strata))


def test_a_share_covers_the_truth_and_is_narrower_where_classes_differ():
    random = np.random.default_rng(5)
    chances, lists, cases = np.array([0.95, 0.7, 0.45]), 12, 10
    classes = np.repeat(list("abc"), lists * cases)
    names = np.repeat(np.arange(3 * lists), cases)
    held, narrower = 0, 0
    for _ in range(300):
        own = np.clip(np.repeat(chances, lists) + random.normal(0.0, 0.05, 3 * lists), 0.0, 1.0)
        hits = random.random(3 * lists * cases) < np.repeat(own, cases)
        found, plain = share(hits, pairs(classes, names)), share(hits, names)
        held += found.low <= chances.mean() <= found.high
        narrower += found.high - found.low < plain.high - plain.low
    assert held >= 0.92 * 300
    assert narrower >= 0.95 * 300


def test_one_stratum_gives_the_size_without_strata():
    hits = np.array([True, False, True, True, False, True])
    names = ["1", "1", "2", "2", "3", "3"]
    assert effective_size(hits, pairs("aaaaaa", names)) == effective_size(hits, names)


@pytest.mark.parametrize("hits", [[True, False, True], [True] * 3, [False] * 3])
def test_cases_of_one_cluster_count_as_one(hits):
    assert effective_size(hits, ["a"] * 3) == 1.0


def test_signs_turn_by_cluster_whatever_its_stratum():
    differences = [1, 1, -1, 1, 0, 1]
    names = ["1", "1", "2", "2", "3", "3"]
    assert sign_flip(differences, pairs("ababab", names)) == sign_flip(
        differences, [s + n for s, n in zip("ababab", names, strict=True)]
    )

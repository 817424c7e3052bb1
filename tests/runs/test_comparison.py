"""Methods on the same cases: differences, families of tests and slices, against brute force."""

import math
from itertools import combinations, product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from steadyload.runs.comparison import Compared, Family, difference
from steadyload.statistics.estimate import NOTHING, Estimate
from steadyload.statistics.metrics import share

CALM = settings(max_examples=60)


@st.composite
def cases(draw, methods=(2, 4), missing=True):
    """Methods on some cases of few clusters, so that all sign vectors can be written down."""
    count = draw(st.integers(1, 14))
    values = st.sampled_from([0.0, 1.0, math.nan] if missing else [0.0, 1.0])
    names = "abcd"[: draw(st.integers(*methods))]
    right = {
        name: np.array(draw(st.lists(values, min_size=count, max_size=count))) for name in names
    }
    labels = draw(st.lists(st.sampled_from("uvwxyz"), min_size=count, max_size=count))
    return Compared(right, np.array(labels))


def both(compared, first, second):
    """Pairs of values, and the clusters, of the cases that two methods have."""
    found = [
        (a, b, c)
        for a, b, c in zip(
            compared.right[first], compared.right[second], compared.clusters, strict=True
        )
        if not (math.isnan(a) or math.isnan(b))
    ]
    return [(a, b) for a, b, _ in found], [c for *_, c in found]


def enumerated(pairs, clusters):
    """The share of all sign vectors over clusters whose sum is as far from 0."""
    sums = [
        sum(a - b for (a, b), c in zip(pairs, clusters, strict=True) if c == at)
        for at in sorted({*clusters})
    ]
    flipped = [abs(sum(s * d for s, d in zip(signs, sums, strict=True)))
               for signs in product((1, -1), repeat=len(sums))]  # fmt: skip
    return sum(value >= abs(sum(sums)) for value in flipped) / len(flipped)


def closed(p_values):
    """Holm's correction as what it is: the closed test of Bonferroni's over every subset."""
    places = range(len(p_values))
    subsets = [s for size in places for s in combinations(places, size + 1)]
    return [
        min(1.0, max(len(s) * min(p_values[k] for k in s) for s in subsets if place in s))
        for place in places
    ]


def test_three_methods_by_hand():
    """Four item lists of two cases; a is right on 7, b on 3, c on none but its only two."""
    lists = ["u", "u", "v", "v", "w", "w", "x", "x"]
    right = {
        "a": [True, True, True, True, True, True, True, False],
        "b": [True, True, False, False, False, False, False, True],
        "c": [False, False, *[None] * 6],
    }
    found = Compared({name: np.array(own, dtype=float) for name, own in right.items()}, lists)
    assert found.best == "a"
    family = found.versus("b")
    first, second = family.tests
    # By list the differences are 0, 2, 2 and 0; of the four signs of the 2s, two give 4 or -4.
    assert (first.first, first.second, first.n) == ("a", "b", 8)
    assert (first.difference.value, first.p) == (4 / 8, 1 / 2)
    assert (first.only_first.value, first.only_second.value) == (5 / 8, 1 / 8)
    # On the list that c has, b is right twice: -2 or 2, both as far from 0.
    assert (second.first, second.second, second.n) == ("c", "b", 2)
    assert (second.difference.value, second.p) == (-1.0, 1.0)
    assert [test.corrected for test in family.tests] == [1.0, 1.0]  # 2 x 1/2
    assert (family.against, family.sizes, family.letters) == ("b", (2, 2, 2, 2), {})
    assert family.least == 2 / 8
    rows = found.slices(["s", "s", "r", "r", "r", "r", None, None])
    assert [(own.name, own.cases, own.clusters) for own in rows] == [("r", 4, 2), ("s", 2, 1)]
    assert [own.accuracy["b"].value for own in rows] == [0.0, 1.0]
    assert rows[0].accuracy["c"].n == 0


@CALM
@given(cases())
def test_tests_are_those_of_all_sign_vectors(compared):
    for test in compared.pairs().tests:
        pairs, clusters = both(compared, test.first, test.second)
        assert test.n == len(pairs)
        if not pairs:
            assert test.p == 1.0
            assert math.isnan(test.difference.value)
            continue
        assert test.p == pytest.approx(enumerated(pairs, clusters), abs=1e-12)
        first, second = (sum(own) / len(pairs) for own in zip(*pairs, strict=True))
        assert test.difference.value == pytest.approx(first - second)
        assert test.difference.low <= test.difference.value + 1e-12
        assert test.difference.high >= test.difference.value - 1e-12
        assert test.only_first.value == sum(a > b for a, b in pairs) / len(pairs)
        assert test.only_second.value == sum(b > a for a, b in pairs) / len(pairs)


@CALM
@given(cases())
def test_a_family_is_corrected_as_a_closed_test(compared):
    families = [compared.pairs(), *(compared.versus(method) for method in compared.right)]
    families += [families[0].versus(method) for method in compared.right]
    for family in families:
        corrected = [test.corrected for test in family.tests]
        assert corrected == pytest.approx(closed([test.p for test in family.tests]))


@CALM
@given(cases())
def test_methods_in_reverse_order_turn_the_sign(compared):
    names = list(compared.right)
    turned = Compared({name: compared.right[name] for name in names[::-1]}, compared.clusters)
    there, back = compared.pairs(), turned.pairs()
    for test in there.tests:
        other = back.of(test.second, test.first)
        assert (other.p, other.n) == (test.p, test.n)
        assert other.corrected == pytest.approx(test.corrected)
        assert (other.only_first, other.only_second) == pytest.approx(
            (test.only_second, test.only_first), nan_ok=True
        )
        for name in ("value", "low", "high"):
            assert getattr(other.difference, name) == pytest.approx(
                getattr(test.turned.difference, name), nan_ok=True
            )


@CALM
@given(cases(methods=(1, 1), missing=False))
def test_a_method_and_itself_do_not_differ(compared):
    own = compared.right["a"]
    (test,) = Compared({"a": own, "copy": own}, compared.clusters).versus("a").tests
    assert test.difference == Estimate(0.0, 0.0, 0.0, len(own))
    assert (test.p, test.corrected) == (1.0, 1.0)
    assert test.only_first.value == test.only_second.value == 0.0
    assert not test.significant


@CALM
@given(cases())
def test_the_comparison_with_one_method_is_the_same_from_all_pairs(compared):
    pairs = compared.pairs()
    for against in compared.right:
        alone, part = compared.versus(against), pairs.versus(against)
        assert (alone.against, alone.sizes) == (part.against, part.sizes)
        assert [(t.first, t.second, t.p) for t in alone.tests] == [
            (t.first, t.second, t.p) for t in part.tests
        ]
        assert [t.corrected for t in alone.tests] == [t.corrected for t in part.tests]


@CALM
@given(cases(), st.data())
def test_slices_partition_the_cases(compared, data):
    count = len(compared.clusters)
    by = data.draw(st.lists(st.sampled_from(["r", "s", "t"]), min_size=count, max_size=count))
    rows = compared.slices(by)
    assert [own.name for own in rows] == sorted({*by})
    assert sum(own.cases for own in rows) == count
    for method, right in compared.right.items():
        assert sum(own.accuracy[method].n for own in rows) == int((~np.isnan(right)).sum())
        hits = sum(own.accuracy[method].value * own.accuracy[method].n
                   for own in rows if own.accuracy[method].n)  # fmt: skip
        assert hits == pytest.approx(np.nansum(right))
    for own in rows:
        here = np.array([name == own.name for name in by])
        assert own.cases == here.sum()
        assert own.clusters == len({*compared.clusters[here]})
        for method, right in compared.right.items():
            known = here & ~np.isnan(right)
            found = share(right[known] == 1.0, compared.clusters[known])
            assert str(own.accuracy[method]) == str(found)


@CALM
@given(cases())
def test_methods_share_a_letter_just_where_they_do_not_differ(compared):
    found = compared.pairs()
    for test in found.tests:
        alike = set(found.letters[test.first]) & set(found.letters[test.second])
        assert bool(alike) != test.significant
    assert "a" in found.letters[compared.best]


def test_a_comparison_with_one_method_is_a_family_of_its_own():
    """Twelve methods: 11 tests against the best one, and not 66 of all pairs."""
    random = np.random.default_rng(8)
    right = {f"m{n}": random.random(120) < 0.97 - 0.02 * n for n in range(12)}
    compared = Compared(right, np.arange(120) // 2)
    pairs = compared.pairs()
    assert len(pairs.tests) == 66
    own = pairs.versus(compared.best)
    assert [test.first for test in own.tests] == [m for m in right if m != compared.best]
    some = False
    for test in own.tests:
        of_all = pairs.of(test.first, compared.best)
        assert (test.difference, test.p) == (of_all.difference, of_all.p)
        assert test.corrected <= of_all.corrected
        some |= test.significant and not of_all.significant
    assert some
    with pytest.raises(KeyError, match="m10"):
        own.of("m10", "m11")


def test_a_part_of_a_family_answers_another_question():
    random = np.random.default_rng(2)
    compared = Compared({m: random.random(60) < p for m, p in zip("abc", (0.9, 0.6, 0.5),
                         strict=True)}, np.arange(60))  # fmt: skip
    pairs = compared.pairs()
    part = pairs.only(lambda test: test.first == "a")
    assert [(test.first, test.second) for test in part.tests] == [("a", "b"), ("a", "c")]
    assert [test.corrected for test in part.tests] == closed([test.p for test in part.tests])
    assert (pairs.letters, part.letters) == ({"a": "a", "b": "b", "c": "c"}, {})


def test_clusters_that_pairs_do_not_share_are_counted_pair_by_pair():
    """Two methods have one case in common, of one list: nothing can be significant there."""
    nan = math.nan
    compared = Compared({"a": [1, 1, nan], "b": [nan, 0, 0], "c": [1, nan, nan]}, ["u", "v", "w"])
    found = compared.pairs()
    assert [test.n for test in found.tests] == [1, 1, 0]
    assert found.of("a", "b").difference == Estimate(1.0, 1.0, 1.0, 1)
    assert found.of("a", "b").p == 1.0
    none = found.of("b", "c")
    assert str(none.difference) == str(none.only_first) == str(NOTHING)


def test_strata_of_clusters_stay_in_a_part_of_the_cases():
    """Labels are pairs of a stratum and a cluster, and stay so where cases are chosen."""
    labels = np.empty(80, dtype=object)
    labels[:] = [("heavy" if k < 40 else "light", f"list {k // 2}") for k in range(80)]
    random = np.random.default_rng(4)
    right = {m: random.random(80) < 0.6 for m in "ab"}
    here = random.random(80) < 0.8
    (found,) = Compared(right, labels).only(here).pairs().tests
    again = difference(right["a"][here], right["b"][here], labels[here])
    assert found.difference == again
    plain = difference(right["a"][here], right["b"][here], [name for _, name in labels[here]])
    assert found.difference != plain


def test_the_difference_of_trainings_is_that_of_the_means_over_their_seeds():
    lists = np.arange(4)
    first = np.array([[1, 1, 0, 1], [1, 0, 0, 1], [1, 1, 0, 1]], dtype=bool)
    second = np.array([[0, 1, 0, 1]], dtype=bool)
    found = difference(first, second, lists)
    assert found.value == pytest.approx(np.mean([1.0, 2 / 3 - 1.0, 0.0, 0.0]))
    assert found.n == 4
    assert difference(second[0], second, lists) == Estimate(0.0, 0.0, 0.0, 4)


@pytest.mark.parametrize(
    ("tests", "clusters", "least"), [(1, 2, 0.5), (3, 5, 0.1875), (40, 3, 1.0), (1, 1, 1.0)]
)
def test_no_p_is_smaller_than_signs_of_clusters_allow_and_none_is_above_one(tests, clusters, least):
    assert Family((None,) * tests, (4,) * clusters).least == least


def test_what_could_be_found_is_the_range_of_the_pairs_that_ever_differ():
    """a and b are right on the same cases, so that their difference has an interval of no width."""
    random = np.random.default_rng(3)
    first, third = random.random(60) < 0.7, random.random(60) < 0.7
    right = {"a": first, "b": first, "c": third}
    found = Compared(right, np.arange(60)).pairs().alike
    assert len(found.tests) == 3
    low, high = found.shown
    assert 0.1 < low <= high < 0.5

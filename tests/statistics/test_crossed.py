"""Standard errors of cases that belong together in two ways, against many samples."""

import numpy as np
import pytest

from steadyload.statistics.crossed import crossed_errors

LISTS, HEURISTICS = 60, 40


def sampled(random, by_list, by_heuristic, cases=400):
    """Values of cases, each of a list and a heuristic that are drawn, with effects of both."""
    lists, heuristics = (random.integers(0, count, cases) for count in (LISTS, HEURISTICS))
    values = (
        random.normal(0.0, by_list, LISTS)[lists]
        + random.normal(0.0, by_heuristic, HEURISTICS)[heuristics]
        + random.normal(0.0, 1.0, cases)
    )
    return values, lists, heuristics


@pytest.mark.parametrize(("by_list", "by_heuristic"), [(0.5, 1.0), (1.0, 0.0), (0.0, 1.0)])
def test_the_error_is_how_far_means_of_samples_lie_apart(by_list, by_heuristic):
    random = np.random.default_rng(4)
    samples = [sampled(random, by_list, by_heuristic) for _ in range(600)]
    spread = np.std([values.mean() for values, *_ in samples])
    one, both = np.mean([crossed_errors(*sample) for sample in samples], axis=0)
    assert both == pytest.approx(spread, rel=0.12)
    if by_heuristic:
        assert one < 0.75 * spread
    else:
        assert one == pytest.approx(spread, rel=0.12)


def test_two_kinds_that_are_the_same_are_one():
    random = np.random.default_rng(5)
    values, lists, _ = sampled(random, 1.0, 0.0)
    one, both = crossed_errors(values, lists, lists)
    assert both == pytest.approx(one)
    assert crossed_errors(values, None, None) == pytest.approx(
        [values.std() / len(values) ** 0.5] * 2
    )

"""Shares of factors in differences, against answers that are made of known parts."""

import numpy as np
import pytest

from steadyload.statistics.variance import source_shares

FACTORS = ("engine", "parameters")


def shares(answers, clusters=None):
    return {" x ".join(s.factors): s for s in source_shares(answers, FACTORS, clusters)}


def test_a_factor_that_shifts_all_answers_has_all_of_the_share_and_always():
    cases = np.random.default_rng(0).normal(size=40)
    answers = cases[:, None, None] + np.array([0.0, 1.0, 3.0])[None, :, None] + np.zeros((40, 3, 2))
    found = shares(answers)
    assert found["engine"].whole.value == pytest.approx(1.0)
    assert found["engine"].always.value == pytest.approx(1.0)
    assert found["parameters"].whole.value == pytest.approx(0.0)
    assert found["engine x parameters"].whole.value == pytest.approx(0.0, abs=1e-12)


def test_parts_of_known_size_are_told_apart():
    """Squares: engine 4 (half of it by case), parameters 1, both together 4; nine in all."""
    random = np.random.default_rng(1)
    cases, sign = 4000, np.array([-1.0, 1.0])
    luck = random.choice([-1.0, 1.0], cases)
    answers = (
        random.normal(size=cases)[:, None, None] * 10
        + np.sqrt(2.0) * (1.0 + luck)[:, None, None] * sign[None, :, None]
        + sign[None, None, :]
        + 2.0 * random.choice([-1.0, 1.0], cases)[:, None, None] * np.outer(sign, sign)
    )
    found = shares(answers)
    assert found["engine"].whole.value == pytest.approx(4 / 9, abs=0.02)
    assert found["engine"].always.value == pytest.approx(2 / 9, abs=0.02)
    assert found["engine"].by_case.value == pytest.approx(2 / 9, abs=0.02)
    assert found["parameters"].whole.value == pytest.approx(1 / 9, abs=0.01)
    assert found["engine x parameters"].always.value == pytest.approx(0.0, abs=0.005)
    assert sum(s.whole.value for s in found.values()) == pytest.approx(1.0)
    for share in found.values():
        assert share.whole.low <= share.whole.value <= share.whole.high
        assert share.whole.n == cases


def test_cases_of_one_list_make_an_interval_wider():
    random = np.random.default_rng(2)
    kinds = np.repeat(random.choice([0.0, 1.0], 20), 30)
    answers = np.zeros((600, 2, 2))
    answers[:, 1, :] += kinds[:, None]
    answers[:, :, 1] += random.choice([0.0, 1.0], 600)[:, None]
    alone, together = shares(answers), shares(answers, np.repeat(np.arange(20), 30))

    def width(found):
        return found["engine"].whole.high - found["engine"].whole.low

    assert width(together) > 2.0 * width(alone)


def test_answers_that_never_differ_have_no_shares():
    found = shares(np.ones((5, 2, 2)))
    assert np.isnan(found["engine"].whole.value)
    assert shares(np.ones((0, 2, 2)))["engine"].whole.n == 0


@pytest.mark.parametrize("levels", [(5, 4), (5, 2), (3, 3)])
def test_components_are_the_variances_that_levels_were_drawn_with(levels):
    """Variances: engine 1, parameters 4, both together 3, whatever the numbers of levels."""
    random = np.random.default_rng(6)
    cases, (engines, sets) = 2000, levels
    answers = (
        random.normal(0.0, 1.0, (cases, engines, 1))
        + random.normal(0.0, 2.0, (cases, 1, sets))
        + random.normal(0.0, 3.0**0.5, (cases, engines, sets))
    )
    found = shares(answers)
    expected = {"engine": 1 / 8, "parameters": 4 / 8, "engine x parameters": 3 / 8}
    for name, own in expected.items():
        share = found[name].component
        assert share.value == pytest.approx(own, abs=0.04), name
        assert share.low <= share.value <= share.high


def test_components_of_three_factors_are_those_that_they_were_drawn_with():
    random = np.random.default_rng(7)
    shape = (2000, 4, 3, 2)
    answers = sum(
        random.normal(0.0, own**0.5, tuple(n if k in axes else 1 for k, n in enumerate(shape)))
        for own, axes in ((1, (0, 1)), (2, (0, 3)), (1, (0, 1, 2)), (4, (0, 1, 2, 3)))
    )
    found = {"".join(s.factors): s.component.value for s in source_shares(answers, ("a", "b", "c"))}
    expected = {"a": 1, "c": 2, "ab": 1, "abc": 4}
    for name, value in found.items():
        assert value == pytest.approx(expected.get(name, 0.0) / 8, abs=0.05), name


def test_a_factor_that_adds_nothing_has_no_component():
    noise = np.random.default_rng(8).normal(size=(2000, 5, 2))
    found = shares(noise)
    assert found["engine"].whole.value > 0.4  # four of nine degrees of freedom
    assert found["engine"].component.value == pytest.approx(0.0, abs=0.03)
    assert found["engine x parameters"].component.value == pytest.approx(1.0, abs=0.05)

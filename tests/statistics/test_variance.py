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

"""Calibration and abstention: closed forms of their numbers."""

import numpy as np
import pytest

from steadyload.statistics.reliability import BINS, abstention, reliability


def test_brier_and_calibration_error_have_closed_forms():
    # Ten say 0.75 and six come true; ten say 0.2 and two do.
    p = np.repeat([0.75, 0.2], 10)
    y = np.repeat([1, 0, 1, 0], [6, 4, 2, 8])
    found = reliability(p, y, np.arange(20))
    assert found.brier.value == pytest.approx(
        (6 * 0.25**2 + 4 * 0.75**2 + 2 * 0.8**2 + 8 * 0.2**2) / 20
    )
    assert found.error.value == pytest.approx(0.5 * 0.15 + 0.5 * 0.0)
    assert [(b.happened.value, b.happened.n) for b in found.bins] == [(0.2, 10), (0.6, 10)]
    assert [b.mean for b in found.bins] == pytest.approx([0.2, 0.75])
    halves = reliability(p, y, np.arange(20), (0.0, 0.5, 1.0))
    assert [(b.low, b.high) for b in halves.bins] == [(0.0, 0.5), (0.5, 1.0)]
    assert halves.error.value == pytest.approx(found.error.value)
    sure = reliability([0.0, 1.0, 1.0], [0, 1, 1], [0, 1, 2])
    assert (sure.brier.value, sure.error.value, sure.error.high) == (0.0, 0.0, 0.0)
    wrong = reliability([0.0, 1.0, 1.0], [1, 0, 0], [0, 1, 2])
    assert (wrong.brier.value, wrong.error.value, wrong.error.low) == (1.0, 1.0, 1.0)


def test_what_keeps_its_word_has_next_to_no_error():
    random = np.random.default_rng(1)
    p = random.uniform(size=20_000)
    y = random.uniform(size=20_000) < p
    lists = random.integers(0, 400, 20_000)
    kept, broken = reliability(p, y, lists), reliability(np.sqrt(p), y, lists)
    assert kept.error.value < 0.012
    # The mean of sqrt(p) - p over uniform p is 2/3 - 1/2.
    assert broken.error.low < 1 / 6 < broken.error.high
    assert kept.brier.value == pytest.approx(1 / 6, abs=0.005)  # mean of p (1 - p)
    assert len(kept.bins) == BINS
    # Lists of one opinion each leave an interval as wide as their number makes it.
    few = reliability(np.repeat(p[:40], 50), np.repeat(y[:40], 50), np.repeat(np.arange(40), 50))
    single = reliability(p[:40], y[:40], np.arange(40))
    assert few.error.high - few.error.low == pytest.approx(single.error.high - single.error.low)


def test_what_abstaining_gives():
    sure = np.linspace(1.0, 0.05, 20)
    right = np.ones(20, bool)
    right[[18, 19]] = False
    found = abstention(sure, right, np.arange(20))
    assert (found.every.value, found.sure.value, found.unsure.value) == (0.9, 1.0, 0.0)
    assert (found.sure.n, found.unsure.n) == (18, 2)
    assert found.least == pytest.approx(sure[17])
    assert found.curve[-1] == pytest.approx((1.0, 0.1))
    assert found.curve[-2] == pytest.approx((0.95, 1 / 19))
    assert all(wrong == 0.0 for _, wrong in found.curve[:-2])
    # Who is right when unsure gains nothing.
    assert abstention(sure[::-1], right, np.arange(20)).sure.value < 0.9

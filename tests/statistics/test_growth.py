"""Exponents of growth against costs that are known to grow as a power."""

import math

import numpy as np
import pytest

from steadyload.statistics.growth import exponent, slope

SIZES = np.repeat([10, 20, 50, 100, 200], 8)
LAYOUTS = np.tile(np.arange(8), 5)


@pytest.mark.parametrize("power", [-0.5, 0.0, 1.0, 1.3, 2.6])
def test_a_power_law_has_its_exponent(power):
    found = exponent(SIZES, 3e-6 * SIZES**power, LAYOUTS)
    assert (found.value, found.low, found.high) == pytest.approx((power,) * 3, abs=1e-9)
    assert found.n == 40
    assert slope(SIZES, 3e-6 * SIZES**power) == pytest.approx(power, abs=1e-9)


def test_the_interval_holds_the_exponent_nineteen_times_out_of_twenty():
    random = np.random.default_rng(0)
    held = 0
    for _ in range(40):
        of_layouts = random.normal(0.0, 0.1, 8)[LAYOUTS]
        costs = SIZES**1.3 * np.exp(of_layouts + random.normal(0.0, 0.2, 40))
        found = exponent(SIZES, costs, LAYOUTS)
        assert found.low < found.value < found.high
        held += found.low <= 1.3 <= found.high
    assert held >= 34


def test_one_layout_has_an_exponent_without_an_interval():
    found = exponent([10, 20], [1.0, 2.0], ["a", "a"])
    assert (found.value, found.n) == (pytest.approx(1.0), 2)
    assert math.isnan(found.low)
    assert math.isnan(found.high)


@pytest.mark.parametrize("sizes", [[], [10], [10, 10]])
def test_one_size_has_no_exponent(sizes):
    assert math.isnan(exponent(sizes, [1.0] * len(sizes)).value)
    assert math.isnan(slope(sizes, [1.0] * len(sizes)))

"""S1, S2a, S2b: bounds, distributions, and what a draw depends on."""

import numpy as np
import pytest

from steadyload.layouts import Item, Layout, Pallet
from steadyload.layouts.model.scenarios import Scenario, apply_scenario


@pytest.fixture(scope="module")
def many():
    """3000 items with sides 1, 2 and 4 cm in a row: 9000 draws."""
    items = tuple(Item(k, (float(k), 0.0, 0.0), (1.0, 2.0, 4.0), 1.0) for k in range(3000))
    return Layout("row", Pallet(3000.0, 10.0, 10.0), items)


def shares(layout, scenario, seed=0):
    drawn = apply_scenario(layout, scenario, seed)
    return (drawn.mass_offsets / (drawn.upper - drawn.lower)).ravel()


def test_s1_centres_every_item(stack):
    off_centre = stack(0.0, 0.0, offset=3.0)
    assert off_centre.mass_offsets.any()
    assert not apply_scenario(off_centre, Scenario.S1, 0).mass_offsets.any()


def test_s2a_is_a_clipped_normal(many):
    drawn = shares(many, Scenario.S2A)
    # sigma = 0.8 / 6 of a side; clipping at three sigma takes 0.27 % of draws to the limit.
    assert abs(drawn.mean()) < 4 * 0.1333 / np.sqrt(9000)
    assert drawn.std() == pytest.approx(0.8 / 6, rel=0.03)
    assert np.abs(drawn).max() == pytest.approx(0.4, abs=1e-12)
    assert (np.abs(drawn) > 0.4 - 1e-12).mean() == pytest.approx(0.0027, abs=0.002)


def test_s2b_is_uniform(many):
    drawn = shares(many, Scenario.S2B)
    counts, _ = np.histogram(drawn, bins=8, range=(-0.4, 0.4))
    assert counts.sum() == 9000
    # Chi-square with 7 degrees of freedom: 24.3 is exceeded once in a thousand seeds.
    assert ((counts - 1125) ** 2 / 1125).sum() < 24.3


def test_a_draw_depends_on_seed_scenario_and_geometry_alone(stack):
    layout, moved = stack(0.0, 0.0), stack(0.0, 1.0)
    first = apply_scenario(layout, Scenario.S2B, 1).mass_offsets
    again = apply_scenario(stack(0.0, 0.0, offset=2.0).renamed("x"), Scenario.S2B, 1).mass_offsets
    assert (first == again).all()
    for other in (
        apply_scenario(layout, Scenario.S2B, 2),
        apply_scenario(layout, Scenario.S2A, 1),
        apply_scenario(moved, Scenario.S2B, 1),
    ):
        assert (first != other.mass_offsets).any()

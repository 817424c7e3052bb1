"""The model of the first moments against equations of motion and the project's own reference."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from steadyload.engines.world import GRAVITY
from steadyload.layouts import Item, Layout, Pallet
from steadyload.methods import make_method
from steadyload.statics.motion import Bodies, displacements_after
from steadyload.statics.touching import touching_points

PALLET = Pallet(200.0, 200.0, 200.0)
WIDTH, HEIGHT = 20.0, 10.0


def overhanging(past_edge):
    """A block whose centre of mass lies this far past the edge of the one below [cm]."""
    return Layout("block", PALLET, (
        Item(0, (20.0, 0.0, 0.0), (WIDTH, 60.0, 10.0), 1.0),
        Item(1, (30.0 + past_edge, 60.0, 0.0), (WIDTH, HEIGHT, 10.0), 2.0),
    ))  # fmt: skip


def angle(past_edge, seconds):
    """(k2 + d2 + h2) a'' = g (d cos a + h sin a), solved; [rad]."""
    d, h = 0.01 * past_edge, 0.005 * HEIGHT
    square = (WIDTH**2 + HEIGHT**2) / 12e4 + d * d + h * h
    return solve_ivp(
        lambda _, s: (s[1], GRAVITY * (d * np.cos(s[0]) + h * np.sin(s[0])) / square),
        (0.0, seconds), (0.0, 0.0), rtol=1e-10, atol=1e-12,
    ).y[0, -1]  # fmt: skip


def way(layout, items, seconds, *, reach=10.0):
    firm = [j for j in range(len(layout)) if j not in items]
    points = touching_points(layout, items, firm, reach=reach)
    centres = (0.5 * (layout.lower + layout.upper) + layout.mass_offsets)[items]
    bodies = Bodies(layout.weights[items], centres, (layout.upper - layout.lower)[items])
    return displacements_after(bodies, points, np.where(points.axes == 1, 0.5, 0.0), seconds)


@pytest.mark.parametrize("past_edge", [0.05, 0.3, 1.0, 2.0])
@pytest.mark.parametrize("seconds", [0.05, 0.15, 0.3])
def test_one_block_tips_as_the_pendulum_does(past_edge, seconds):
    expected = angle(past_edge, seconds)
    turns = np.abs(way(overhanging(past_edge), [1], seconds).turns[0])
    # The model's equation leaves out terms of second order in the angle.
    assert turns.max() == pytest.approx(expected, rel=1e-9 + 0.5 * expected**2 + 1e-3)
    assert np.sort(turns)[1] < 1e-9


def test_two_blocks_tip_together_as_one():
    # A second block of the same size on top: one rigid body about the same edge.
    lay = overhanging(0.5)
    top = Item(2, (30.5, 60.0 + HEIGHT, 0.0), (WIDTH, HEIGHT, 10.0), 2.0)
    turns = way(Layout("two", PALLET, (*lay.items, top)), [1, 2], 0.2).turns
    d, h = 0.005, 0.01 * HEIGHT
    square = (WIDTH**2 + (2 * HEIGHT) ** 2) / 12e4 + d * d + h * h
    rate = np.sqrt(GRAVITY * h / square)
    expected = d / h * (np.cosh(rate * 0.2) - 1.0)
    assert turns[:, 2] == pytest.approx([-expected] * 2, rel=2e-3)


def test_what_nothing_carries_falls_freely():
    lay = Layout("free", PALLET, (Item(0, (0.0, 100.0, 0.0), (10.0, 10.0, 10.0), 1.0),))
    fall = way(lay, [0], 0.3)
    assert fall.shifts[0] == pytest.approx((0.0, -44.1, 0.0), abs=1e-6)  # g t2 / 2
    verdict = make_method("equilibrium:time=0.3").judge(lay)
    assert (verdict.failing_step, verdict.rotation) == (0, pytest.approx(0.0))
    assert verdict.displacement == pytest.approx(44.1, abs=1e-3)


def test_a_fall_ends_where_something_is_in_the_way():
    # 3 cm above the floor, and it lands flat.
    lay = Layout("low", PALLET, (Item(0, (0.0, 3.0, 0.0), (10.0, 10.0, 10.0), 1.0),))
    assert way(lay, [0], 0.3).shifts[0, 1] == pytest.approx(-3.0, abs=0.2)
    assert make_method("equilibrium").judge(lay).failing_step == 0
    assert make_method("equilibrium:time=0.3").judge(lay).failing_step is None
    assert make_method("equilibrium:time=0.3,eps_t=2").judge(lay).failing_step == 0


def test_a_block_that_tips_onto_a_step_settles():
    lay = overhanging(3.0)
    # 1 cm lower, under the end that stands out: 13 cm from the edge it may drop by 1 cm.
    step = Item(1, (45.0, 0.0, 0.0), (20.0, 59.0, 10.0), 1.0)
    block = Item(2, lay.items[1].position, lay.items[1].size, 2.0)
    caught = Layout("caught", PALLET, (lay.items[0], step, block))
    for spec, fails in {
        "equilibrium": 2,
        "equilibrium:time=0.3": None,
        "label@reference": None,
    }.items():
        assert make_method(spec).judge(caught).failing_step == fails
    for spec in ("equilibrium:time=0.3", "label@reference"):
        assert make_method(spec).judge(lay).failing_step == 1


def test_the_verdict_on_an_overhanging_block_is_the_reference_s():
    # 10 degrees in 0.3 s are passed near 0.16 cm past the edge.
    assert np.degrees(angle(0.15, 0.3)) < 10.0 < np.degrees(angle(0.17, 0.3))
    for past_edge, fails in {-1.0: None, 0.05: None, 0.14: None, 0.18: 1, 0.5: 1, 3.0: 1}.items():
        for spec in ("equilibrium:time=0.3", "label@reference"):
            assert make_method(spec).judge(overhanging(past_edge)).failing_step == fails

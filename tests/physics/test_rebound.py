"""Restitution of the reference's contacts: impacts of free boxes, against impulse and momentum.

The speed that rebounds is that of the material point that was struck, along the normal. A box keeps
the angular momentum about that point, so that the impulse, and with it the energy, follows from
the coefficient: what moves at the point has the mass m with 1/m = n (M^-1 + r x I^-1 (n x r)) n.
"""

import dataclasses
import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from steadyload.engines.attitudes import rotate
from steadyload.engines.reference.law import LEAST_REBOUND, damping_ratio
from steadyload.engines.reference.options import ReferenceOptions
from steadyload.engines.reference.world import ReferenceWorld
from steadyload.engines.world import GRAVITY, Box, WorldSettings
from steadyload.methods.contract.spec import SpecError
from steadyload.methods.registry import make_method

WEIGHTLESS = (0.0, 0.0, 0.0)
DENSITY = 500.0
SHAPE = np.array([1.3, 1.0, 0.8])
CORNERS = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
NORMAL = np.array([0.0, 0.0, 1.0])
GAP = 1e-5


def turned(axis, degrees):
    axis = np.array(axis) / np.linalg.norm(axis)
    half = math.radians(degrees) / 2.0
    return (math.cos(half), *(math.sin(half) * axis))


STRUCK = {
    "flat": (1.0, 0.0, 0.0, 0.0),
    "a long edge": turned((1.0, 0.0, 0.0), 35.0),
    "a short edge": turned((0.0, 1.0, 0.0), 70.0),
    "a corner": turned((1.0, 0.6, 0.2), 40.0),
    "a sharp corner": turned((0.3, 1.0, -0.4), 60.0),
}


class Impact:
    """A box that strikes the floor downwards.

    ``rebound``: speed of what was struck afterwards, over that before. ``left``: kinetic energy
    afterwards, over that before. ``share``: mass that moves at what was struck, over all of it.
    """

    def __init__(self, options, mass, speed, attitude, gravity=WEIGHTLESS, friction=0.0):
        size = SHAPE * (mass / DENSITY / SHAPE.prod()) ** (1.0 / 3.0)
        arms = rotate(np.tile(attitude, (8, 1)), CORNERS * size)
        struck = np.isclose(arms[:, 2], arms[:, 2].min(), rtol=0.0, atol=1e-9)
        box = Box(
            tuple(size), mass, (0.0, 0.0, GAP - arms[:, 2].min()), attitude=attitude,
            velocity=(0.0, 0.0, -speed),
        )  # fmt: skip
        settings = WorldSettings(gravity=gravity, friction=friction, options=options)
        with ReferenceWorld(settings) as world:
            world.add_box(box)
            self._follow(world, speed)
            pose, (linear, angular) = world.poses(), world.velocities()
        turn = np.tile(pose.quaternions[0], (8, 1))
        arm = rotate(turn, CORNERS * size)[struck].mean(axis=0)
        self.rebound = (linear[0] + np.cross(angular[0], arm))[2] / speed
        spin = rotate(turn[:1] * (1.0, -1.0, -1.0, -1.0), angular)[0]
        energy = mass * linear[0] @ linear[0] + np.array(box.inertia) @ spin**2
        self.left = energy / (mass * speed**2)
        self.share = self._share(box, attitude, arms[struck].mean(axis=0))

    def _follow(self, world, speed):
        """Until it has been struck, and nothing but gravity acts any more."""
        step, last, met = 1e-5, -speed, False
        fall = world.gravity[2] * step
        for _ in range(20_000):
            world.stepSimulation(step, 1, step)
            now = world.velocities().linear[0, 2]
            pushed = abs(now - last - fall) > 1e-6 * speed
            if met and not pushed and now > -speed:
                return
            met, last = met or pushed, now
        raise AssertionError("it stays in contact")

    def _share(self, box, attitude, arm):
        turn = np.tile(attitude, (3, 1))
        axes = rotate(turn, np.eye(3)).T
        inertia = axes @ np.diag(box.inertia) @ axes.T
        lever = np.cross(arm, NORMAL)
        return 1.0 / (1.0 + box.mass * lever @ np.linalg.solve(inertia, lever))


# --- one contact --------------------------------------------------------------------------------


@pytest.mark.parametrize("rebound", [1e-3, 0.05, math.exp(-2.0), 0.3, 0.7, 0.99])
def test_the_damping_is_that_of_a_spring_which_never_pulls(rebound):
    """A mass of 1 kg on a spring of 1 N/m, at 1 m/s, until the force is zero."""
    damping = 2.0 * damping_ratio(rebound)

    def force(_, state):
        return -state[0] - damping * state[1]

    force.terminal, force.direction = True, 1.0
    end = solve_ivp(
        lambda t, state: (state[1], force(t, state)), (0.0, 1e4), (0.0, 1.0), method="Radau",
        events=force, rtol=1e-8, atol=1e-11,
    )  # fmt: skip
    assert -end.y_events[0][0, 1] == pytest.approx(rebound, rel=1e-4)


def test_less_than_the_least_restitution_counts_as_it():
    assert damping_ratio(0.0) == damping_ratio(LEAST_REBOUND) < 51.0
    assert damping_ratio(0.999) == pytest.approx(1e-3 / math.pi, rel=1e-2)


# --- impacts ------------------------------------------------------------------------------------


@pytest.mark.parametrize("struck", STRUCK)
@pytest.mark.parametrize(("rebound", "speed"), [(0.1, 0.3), (0.3, 1.0), (0.6, 3.0), (0.9, 1.0)])
@pytest.mark.parametrize("mass", [0.05, 1.0, 30.0, 1000.0])
def test_every_box_rebounds_by_the_coefficient(mass, rebound, speed, struck):
    impact = Impact(ReferenceOptions(rebound=rebound), mass, speed, STRUCK[struck])
    assert impact.rebound == pytest.approx(rebound, rel=2e-3 if struck == "flat" else 0.02)
    # What the impact takes of the energy of what moves at the point, and of no other.
    left = 1.0 - impact.share * (1.0 - rebound**2)
    assert impact.left == pytest.approx(left, rel=5e-3)
    assert impact.share == pytest.approx(1.0) if struck == "flat" else impact.share < 0.9


@pytest.mark.parametrize("struck", ["flat", "a long edge", "a corner"])
def test_without_the_option_the_mass_decides(struck):
    """What is missing otherwise: heavy boxes rebound, light ones do not."""
    options = ReferenceOptions(damping_time=3e-4)
    light, heavy = (Impact(options, mass, 1.0, STRUCK[struck]).rebound for mass in (1.0, 1000.0))
    assert heavy > 5.0 * light


@pytest.mark.parametrize("struck", ["a long edge", "a sharp corner"])
def test_what_an_edge_rebounds_too_much_goes_with_the_stiffness(struck):
    """The box turns while it is in contact, and the faster the longer that takes."""
    excess = [
        Impact(ReferenceOptions(rebound=0.3, stiffness=k, most_rate=1e6), 30.0, 3.0, STRUCK[struck])
        .rebound / 0.3 - 1.0
        for k in (1e8, 1e10)
    ]  # fmt: skip
    assert 0.0 < excess[1] < 0.15 * excess[0] < 0.01


@pytest.mark.parametrize("struck", STRUCK)
@pytest.mark.parametrize("mass", [0.05, 100.0])
def test_restitution_converges_with_the_tolerance(mass, struck):
    found = [
        Impact(ReferenceOptions(rebound=0.4, tolerance=eps), mass, 0.5, STRUCK[struck]).rebound
        for eps in (1e-5, 1e-7, 1e-9)
    ]
    assert found[1] == pytest.approx(found[2], rel=5e-4)
    assert abs(found[1] - found[2]) < abs(found[0] - found[2])


def test_radau_rebounds_as_far():
    options = ReferenceOptions(rebound=0.4)
    both = [
        Impact(dataclasses.replace(options, integrator=name), 2.0, 1.0, STRUCK["a corner"]).rebound
        for name in ("rodas", "radau")
    ]
    assert both[0] == pytest.approx(both[1], rel=1e-3)


def test_a_weight_takes_little_of_a_fast_impact():
    gravity = (0.0, 0.0, -GRAVITY)
    for mass in (1.0, 1000.0):
        impact = Impact(ReferenceOptions(rebound=0.3), mass, 3.0, STRUCK["flat"], gravity)
        assert impact.rebound == pytest.approx(0.3, rel=0.01)


@pytest.mark.parametrize("masses", [(1.0, 1.0), (0.05, 20.0), (300.0, 5.0)])
@pytest.mark.parametrize(
    "attitudes",
    [(STRUCK["flat"], STRUCK["flat"]), (turned((1, 0, 0), 45.0), turned((0, 1, 0), 45.0))],
    ids=["faces", "edges that cross"],
)
@pytest.mark.parametrize("rebound", [0.2, 0.7])
def test_boxes_that_meet_in_flight_part_by_the_coefficient(rebound, attitudes, masses):
    side, speed = 0.2, 1.0
    reach = 0.5 * side if attitudes[0] == STRUCK["flat"] else side / math.sqrt(2.0)
    settings = WorldSettings(gravity=WEIGHTLESS, options=ReferenceOptions(rebound=rebound))
    with ReferenceWorld(settings) as world:
        for mass, attitude, above in zip(masses, attitudes, (0.0, 1.0), strict=True):
            centre = (0.0, 0.0, 5.0 + above * (2.0 * reach + 1e-3))
            velocity = (0.0, 0.0, -above * speed)
            world.add_box(Box((side,) * 3, mass, centre, attitude=attitude, velocity=velocity))
        world.stepSimulation(0.02, 1, 0.02)
        linear = world.velocities().linear
    assert linear[1, 2] - linear[0, 2] == pytest.approx(rebound * speed, rel=0.01)
    assert linear[0, 2] * masses[0] + linear[1, 2] * masses[1] == pytest.approx(-masses[1] * speed)


# --- what is refused ----------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("rebound=-0.1", "rebound is -0.1; allowed: a number, 0 to 0.999"),
        ("rebound=1", "rebound is 1; allowed: a number, 0 to 0.999"),
        ("rebound=nan", "rebound is 'nan'; allowed: a finite number"),
        ("rebound=much", "rebound is 'much'; allowed: a finite number"),
        ("rebound=0.3,damping_time=1e-3", "allowed: one of them, as both say how"),
        ("rebound=0.3,contact=adams", "rebound is 0.3 at an exponent of 1.2; allowed: an exponent"),
    ],
)
def test_what_is_no_restitution_is_refused(text, message):
    with pytest.raises(SpecError, match=f"^label@reference:{text}: .*{message}"):
        make_method(f"label@reference:{text}")


def test_the_option_is_none_and_is_no_part_of_what_was_judged_without_it():
    assert ReferenceOptions().law(0.5).damping_ratio == 0.0
    assert "rebound" not in str(make_method("label@reference").spec)
    assert str(make_method("label@reference:rebound=0.3").spec) == "label@reference:rebound=0.3"

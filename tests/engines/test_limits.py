"""Numbers that no engine is given; what every layout may hold lies within."""

import itertools
import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from steadyload.engines.attitudes import axes_of_quaternion, rotation_vector
from steadyload.engines.box import MASSES, SIZES, check_box
from steadyload.engines.errors import BadNumberError, EngineError
from steadyload.engines.substeps import SubstepClock
from steadyload.engines.world import Box, WorldSettings
from steadyload.layouts import Item, Layout, Pallet
from steadyload.layouts.model.layout import SIDES, WEIGHTS
from steadyload.methods.simulation.scene import boxes

NAN, INF = math.nan, math.inf


@pytest.mark.parametrize(
    ("name", "values", "allowed"),
    [
        ("friction", (-0.1, NAN, INF, None), "a finite number, 0 or more"),
        ("restitution", (-0.1, 1.01, NAN), "0 to 1"),
        ("linear_damping", (-0.1, 1.0, NAN), "0 to less than 1"),
        ("angular_damping", (-0.1, 1.0, NAN), "0 to less than 1"),
        ("margin", (-1e-3, NAN, INF), "a finite number, 0 or more [m]"),
        ("solver_iterations", (0, -1, 2.5, NAN, INF), "None, or a whole number from 1 on"),
        ("gravity", ((0.0, 0.0, NAN), (INF, 0.0, 0.0), (0.0, 0.0), -9.8), "three finite numbers"),
    ],
)
def test_settings_that_cannot_be_are_refused(name, values, allowed):
    for value in values:
        with pytest.raises(BadNumberError) as caught:
            WorldSettings(**{name: value})
        assert str(caught.value) == f"{name} is {value!r}; allowed: {allowed}"
        assert isinstance(caught.value, EngineError)
        assert isinstance(caught.value, ValueError)


def test_the_ends_of_the_ranges_are_allowed():
    WorldSettings(friction=0.0, restitution=1.0, linear_damping=0.999999, solver_iterations=1)
    WorldSettings(gravity=(0.0, 0.0, 1e306), margin=1.0, friction=10.0)


@pytest.mark.parametrize(
    ("box", "message"),
    [
        (Box((0.1, NAN, 0.1), 1.0, (0.0, 0.0, 0.0)), "box 7: size is (0.1, nan, 0.1); allowed"),
        (Box((0.1, 0.1), 1.0, (0.0, 0.0, 0.0)), "box 7: size is (0.1, 0.1); allowed: three num"),
        (Box((0.1, 0.1, "x"), 1.0, (0.0, 0.0, 0.0)), "box 7: size is (0.1, 0.1, 'x'); allowed"),
        (Box((0.1, 0.1, 0.1), None, (0.0, 0.0, 0.0)), "box 7: mass is None; allowed: 1e-12 to"),
        (Box((0.1, 0.1, 0.1), 1.0, (0.0, INF, 0.0)), "box 7: centre is (0.0, inf, 0.0); allowed"),
        (
            Box((0.1, 0.1, 0.1), 1.0, (0.0, 0.0, 0.0), (0.0, 0.0, -0.06)),
            "box 7: mass_offset is (0.0, 0.0, -0.06); allowed: inside the box, whose size is",
        ),
        (
            Box((0.1, 0.1, 0.1), 1.0, (0.0, 0.0, 0.0), attitude=(1.0, 0.0, 0.0)),
            "box 7: attitude is (1.0, 0.0, 0.0); allowed: four numbers w, x, y, z, whose length "
            "differs from 1 by at most 1e-06",
        ),
        (
            Box((0.1, 0.1, 0.1), 1.0, (0.0, 0.0, 0.0), attitude=(1.0, 2e-3, 0.0, 0.0)),
            "box 7: attitude is (1.0, 0.002, 0.0, 0.0); allowed: four",
        ),
        (
            Box((0.1, 0.1, 0.1), 1.0, (0.0, 0.0, 0.0), attitude=None),
            "box 7: attitude is None; allowed: four",
        ),
        (
            Box((0.1, 0.1, 0.1), 1.0, (0.0, 0.0, 0.0), velocity=(0.0, NAN, 0.0)),
            "box 7: velocity is (0.0, nan, 0.0); allowed: three numbers from -1e+06 to 1e+06 m/s",
        ),
        (
            Box((0.1, 0.1, 0.1), 1.0, (0.0, 0.0, 0.0), angular_velocity=(0.0, 0.0, 2e6)),
            "box 7: angular_velocity is (0.0, 0.0, 2000000.0); allowed: three numbers from -1e+06 "
            "to 1e+06 rad/s",
        ),
        (
            Box((0.1, 0.1, 0.1), 1.0, (0.0, 0.0, 0.0), fixed=True, velocity=(1.0, 0.0, 0.0)),
            "box 7: velocities are (1.0, 0.0, 0.0) and (0.0, 0.0, 0.0); allowed: zeros, as it is",
        ),
        (
            Box((0.1, 0.1, 0.2), 1.2, (0.0, 0.0, 0.0), moments=(1e-3, 1e-3, 7e-3)),
            "box 7: moments is (0.001, 0.001, 0.007); allowed: None, or three numbers of 1.5e-05 "
            "to 0.015, 1.5e-05 to 0.015, 6e-06 to 0.006 kg m2, of which none is more than the sum",
        ),
        (
            Box((0.1, 0.1, 0.1), 1.0, (0.0, 0.0, 0.0), moments=(1e-3, 1e-3)),
            "box 7: moments is (0.001, 0.001); allowed: None, or three numbers of",
        ),
        (
            Box((0.1, 0.1, 0.1), 1.0, (0.0, 0.0, 0.0), moments=(2e-3, 1e-3, 9e-4)),
            "box 7: moments is (0.002, 0.001, 0.0009); allowed: None, or three numbers of",
        ),
    ],
)
def test_a_refusal_says_which_box_and_what_is_allowed(box, message):
    with pytest.raises(BadNumberError) as caught:
        check_box(box, 7)
    assert str(caught.value).startswith(message)


@pytest.mark.parametrize("shrink", [0.0, 1.0])
def test_whatever_a_layout_may_hold_is_allowed(shrink):
    """The smallest and the largest, with centres of mass on a corner, under any shrink."""
    for side, weight, sign in itertools.product(SIDES, WEIGHTS, (-1.0, 1.0)):
        offset = (sign * side / 2.0, sign * side / 2.0, -sign * side / 2.0)
        item = Item(0, (0.0, 0.0, 0.0), (side, side, side), weight, offset)
        (box,) = boxes(Layout("A", Pallet(*(SIDES[1],) * 3), (item,)), shrink=shrink)
        check_box(box, 0)


def test_a_start_within_the_limits_is_allowed():
    """Also an attitude in single precision, which is scaled to length 1."""
    attitude = tuple(float(np.float32(part)) for part in (0.1, -0.7, 0.1, 0.7))
    box = Box(
        (0.1, 0.2, 0.3),
        1.0,
        (1.0, 2.0, 3.0),
        (0.01, 0.02, 0.03),
        attitude=attitude,
        velocity=(1e6, 0.0, -1e6),
        angular_velocity=(0.0, 1e6, 0.0),
    )
    check_box(box, 0)
    assert math.hypot(*box.unit_attitude) == pytest.approx(1.0, abs=1e-15)
    axes = Rotation.from_quat(attitude, scalar_first=True).as_matrix()
    assert np.subtract(box.mass_centre, box.centre) == pytest.approx(axes @ box.mass_offset)
    assert axes_of_quaternion(box.unit_attitude) == pytest.approx(axes)


@pytest.mark.parametrize("degrees", [0.0, 1e-7, 40.0, 179.9, 180.0, 200.0, 359.0, 540.0])
def test_a_rotation_vector_is_that_of_its_quaternion(degrees):
    for axis in ((1.0, 0.0, 0.0), (0.6, -0.8, 0.0), (-0.48, 0.6, 0.64)):
        half = math.radians(0.5 * degrees)
        quaternion = (math.cos(half), *(math.sin(half) * part for part in axis))
        turned = Rotation.from_rotvec(rotation_vector(quaternion))
        expected = Rotation.from_quat(quaternion, scalar_first=True)
        assert (turned * expected.inv()).magnitude() < 1e-12
        assert np.linalg.norm(rotation_vector(quaternion)) <= math.pi


@pytest.mark.parametrize(
    "points",
    [
        [(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)],  # its corners
        [(0, 0, -1), (0, 0, 1), (0.1, 0, 0), (0, -0.1, 0)],
        [(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 0), (0, 0, 0.5), (0, 0, -0.5)],
    ],
)
def test_moments_of_masses_inside_a_box_are_allowed(points):
    size, mass = np.array((0.2, 0.3, 0.5)), 4.0
    at = 0.5 * size * np.array(points, dtype=float)
    squares = (at * at).mean(axis=0)
    moments = tuple((mass * (squares.sum() - squares)).tolist())
    box = Box(tuple(size.tolist()), mass, (0.0, 0.0, 0.0), moments=moments)
    check_box(box, 0)
    assert box.inertia == moments


def test_allowed_boxes_have_moments_of_inertia():
    """They are products of a mass and two lengths: neither zero nor infinite."""
    for size, mass in itertools.product(SIZES, MASSES):
        box = Box((size, size, size), mass, (0.0, 0.0, 0.0))
        check_box(box, 0)
        assert all(0.0 < moment < INF for moment in box.inertia)


def test_durations_are_refused_by_the_same_name():
    with pytest.raises(BadNumberError, match="durations must be finite, got nan"):
        SubstepClock().advance(NAN, 1, 0.01)

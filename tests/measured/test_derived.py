"""Derived quantities against motion in closed form."""

from dataclasses import replace

import numpy as np
import pytest
from motions import CUBE, G, bouncing, free_flight, resting, turned, upright

from steadyload.measured.derived import (
    face_down,
    impacts,
    rest_frame,
    resting_height,
    spins,
    time_to_rest,
    velocities,
)
from steadyload.measured.motion import Trial


def test_velocities_of_a_free_flight_are_exact():
    flight = free_flight()
    fall = np.zeros((len(flight), 3))
    fall[:, 2] = G * flight.times
    # v = v0 - g t, at the ends of the recording, too
    assert velocities(flight) + fall == pytest.approx(np.tile([1.0, -0.5, 2.0], (21, 1)), abs=1e-9)


def test_velocities_that_are_given_are_kept():
    flight = free_flight()
    given = replace(flight, velocities=velocities(flight) * 1.01, spins=spins(flight) * 0.99)
    assert velocities(given) is given.velocities
    assert spins(given) is given.spins


@pytest.mark.parametrize("axis", [(1.0, 2.0, -0.5), (0.0, 0.0, 1.0), (-1.0, 0.0, 0.0)])
@pytest.mark.parametrize("rate", [0.0, 0.3, 7.0, 120.0])
def test_spins_of_a_constant_turn_are_exact(axis, rate):
    flight = free_flight(axis, rate)
    unit = np.array(axis) / np.linalg.norm(axis)
    assert spins(flight) == pytest.approx(np.tile(rate * unit, (21, 1)), abs=1e-9)


def test_a_quaternion_and_its_negative_are_one_attitude():
    flight = free_flight()
    signs = np.where(np.arange(len(flight)) % 3 == 0, -1.0, 1.0)[:, None]
    assert spins(replace(flight, attitudes=flight.attitudes * signs)) == pytest.approx(
        spins(flight), abs=1e-9
    )


def test_spins_are_in_the_axes_of_the_body():
    """A cube that lies on a side turns about the vertical, which is its own y."""
    count, rate = 11, 2.0
    times = np.linspace(0.0, 1.0, count)
    lying = turned((1.0, 0.0, 0.0), [0.5 * np.pi])[0]  # its y points up
    yaw = turned((0.0, 0.0, 1.0), rate * times)
    w, x = lying[:2]
    attitudes = np.stack(
        [yaw[:, 0] * w, yaw[:, 0] * x, yaw[:, 3] * x, yaw[:, 3] * w], axis=1
    )  # the product of the turn and the lying attitude
    trial = Trial("yaw", times, np.tile([0.0, 0.0, 0.05], (count, 1)), attitudes)
    assert spins(trial) == pytest.approx(np.tile([0.0, rate, 0.0], (count, 1)), abs=1e-9)
    given = replace(trial, spins=spins(trial))
    assert given.world_spins == pytest.approx(np.tile([0.0, 0.0, rate], (count, 1)), abs=1e-9)


@pytest.mark.parametrize(
    ("axis", "degrees", "face", "tilt"),
    [
        ((1.0, 0.0, 0.0), 0.0, "-z", 0.0),
        ((1.0, 0.0, 0.0), 90.0, "-y", 0.0),
        ((1.0, 0.0, 0.0), -90.0, "+y", 0.0),
        ((0.0, 1.0, 0.0), 90.0, "+x", 0.0),
        ((0.0, 1.0, 0.0), -90.0, "-x", 0.0),
        ((0.0, 1.0, 0.0), 180.0, "+z", 0.0),
        ((1.0, 0.0, 0.0), 30.0, "-z", 30.0),
        ((1.0, 0.0, 0.0), 50.0, "-y", 40.0),
        ((0.0, 0.0, 1.0), 77.0, "-z", 0.0),
    ],
)
def test_the_face_that_points_down(axis, degrees, face, tilt):
    found = face_down(turned(axis, np.radians([degrees]))[0])
    assert found.name == face
    assert found.tilt_deg == pytest.approx(tilt, abs=1e-5)


def test_a_box_that_lies_on_a_face_is_tilted_by_nothing_however_it_is_turned():
    """Rounding makes the cosine of no tilt larger than 1 for some of these."""
    for angle in np.radians(np.arange(360.0)):
        c, s = np.cos(angle), np.sin(angle)
        for attitude, name in (
            (np.array([c, 0.0, 0.0, s]), "-z"),
            (np.array([0.0, c, s, 0.0]), "+z"),
        ):
            found = face_down(attitude)
            assert (found.name, found.tilt_deg) == (name, pytest.approx(0.0, abs=1e-5))


def test_the_face_of_a_corner_points_down_by_no_more_than_the_diagonal():
    """A turn about (1, -1, 0) by atan(sqrt 2) brings a diagonal of the cube upright."""
    found = face_down(turned((1.0, -1.0, 0.0), [np.arctan(np.sqrt(2.0))])[0])
    assert found.tilt_deg == pytest.approx(np.degrees(np.arctan(np.sqrt(2.0))))


def test_a_resting_cube_is_at_rest_from_the_first_frame():
    cube = resting(body=CUBE)
    assert (rest_frame(cube), time_to_rest(cube)) == (0, 0.0)
    assert resting_height(cube) == pytest.approx(0.05)
    assert impacts(cube) == ()


def test_a_cube_in_flight_never_rests_and_hits_nothing():
    flight = free_flight()
    assert rest_frame(flight) is None
    assert time_to_rest(flight) is None
    assert resting_height(flight) is None
    assert impacts(flight) == ()


def test_a_sliding_cube_rests_when_it_has_used_up_its_speed():
    """v0 / (mu g) after the start, by a threshold of speed earlier."""
    mu, start = 0.3, 1.0
    times = np.linspace(0.0, 1.0, 1001)
    stop = start / (mu * G)
    moving = np.minimum(times, stop)
    positions = np.zeros((1001, 3))
    positions[:, 0] = start * moving - 0.5 * mu * G * moving**2
    positions[:, 2] = 0.05
    trial = Trial("slide", times, positions, upright(1001), body=CUBE)
    assert time_to_rest(trial) == pytest.approx((start - 0.05) / (mu * G), abs=2e-3)
    assert impacts(trial) == ()


@pytest.mark.parametrize("bounces", [0, 1, 3])
def test_impacts_of_a_bouncing_cube(bounces):
    trial, expected = bouncing(bounces)
    found = impacts(trial)
    assert len(found) == bounces + 1
    assert found == pytest.approx(expected, abs=0.004)
    assert time_to_rest(trial) == pytest.approx(expected[-1], abs=0.006)
    assert resting_height(trial) == pytest.approx(0.05)


def test_a_smaller_jump_than_named_is_no_impact():
    trial, expected = bouncing(3)
    speed = np.sqrt(2.0 * G * 0.5)  # before the first impact; 0.6 of it after it, and so on
    assert len(impacts(trial, least=1.5 * speed)) == 1
    assert len(impacts(trial, least=1.7 * speed)) == 0
    assert len(expected) == 4

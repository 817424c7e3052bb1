"""Differences of a simulated trial from its record, on motion that is made by hand."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from motions import CUBE, bouncing, free_flight, resting, turned
from scipy.spatial.transform import Rotation

from steadyload.engines.attitudes import degrees_apart
from steadyload.measured.deviations import (
    before_impacts,
    deviation,
    distances,
)
from steadyload.measured.motion import Trial


def lying(axis=(1.0, 0.0, 0.0), degrees=0.0, at=(0.3, 0.1, 0.05), count=10):
    attitudes = np.tile(turned(axis, [np.radians(degrees)])[0], (count, 1))
    return replace(
        resting(count, body=CUBE), attitudes=attitudes, positions=np.tile(at, (count, 1))
    )


def test_a_trial_deviates_from_itself_by_nothing():
    record, _ = bouncing()
    found = deviation(record, record)
    assert (found.face, found.same_face) == ("-z", True)
    assert found.off_m == pytest.approx(0.0)
    assert found.turn_deg == pytest.approx(0.0, abs=1e-6)
    assert found.height_m == pytest.approx(0.05, abs=1e-9)
    assert found.rest_s == pytest.approx(bouncing()[1][-1], abs=0.01)
    assert found.deepest_m == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize(
    ("axis", "degrees", "face"),
    [
        ((0.0, 0.0, 1.0), 30.0, "-z"),
        ((1.0, 0.0, 0.0), 90.0, "-y"),
        ((0.0, 1.0, 0.0), 90.0, "+x"),
        ((1.0, 0.0, 0.0), 180.0, "+z"),
    ],
)
def test_faces_and_turns_are_compared(axis, degrees, face):
    found = deviation(lying(), lying(axis, degrees))
    assert (found.face, found.same_face) == (face, face == "-z")
    assert found.turn_deg == pytest.approx(degrees, abs=1e-6)


def test_rest_is_off_in_the_plane_and_sunk_in_is_what_is_deepest():
    found = deviation(lying(), lying(at=(0.33, 0.14, 0.048)))
    assert found.off_m == pytest.approx(0.05)
    assert found.height_m == pytest.approx(0.048)
    assert found.deepest_m == pytest.approx(-0.002)
    assert found.rest_s == 0.0


def test_what_moves_in_the_end_has_no_height_and_no_time_of_rest():
    found = deviation(lying(), replace(free_flight(body=CUBE), name="rest"))
    assert (found.height_m, found.rest_s) == (None, None)


@settings(max_examples=50, deadline=None)
@given(st.integers(0, 10**6), st.floats(0.0, 179.9))
def test_angles_between_attitudes_are_those_of_rotations(seed, degrees):
    random = np.random.default_rng(seed)
    first = Rotation.random(random_state=seed)
    axis = random.normal(size=3)
    other = Rotation.from_rotvec(np.radians(degrees) * axis / np.linalg.norm(axis)) * first
    quaternions = [one.as_quat(scalar_first=True) for one in (first, other)]
    assert degrees_apart(*quaternions) == pytest.approx(degrees, abs=1e-6)
    assert degrees_apart(quaternions[1], -quaternions[0]) == pytest.approx(degrees, abs=1e-6)


def test_distances_grow_with_a_difference_of_speed_and_end_with_the_record():
    times = np.linspace(2.0, 3.0, 11)
    ours = np.linspace(2.0, 3.5, 16)

    def moving(at, speed):
        positions = np.outer(at - 2.0, (speed, 0.0, 0.0)) + np.array((0.0, 0.0, 0.05))
        return Trial("t", at, positions, np.tile([1.0, 0.0, 0.0, 0.0], (len(at), 1)))

    found = distances(moving(times, 0.2), moving(ours, 0.3), [-0.1, 0.0, 0.33, 1.0, 1.2, 1.6])
    assert found == [None, pytest.approx(0.0), pytest.approx(0.033), pytest.approx(0.1),
                     pytest.approx(0.16), None]  # fmt: skip


def test_times_before_impacts_are_those_of_the_bounces():
    record, times = bouncing(bounces=3)
    found = before_impacts(record)
    assert found[:-1] == pytest.approx(np.array(times) - 0.015, abs=0.005)
    assert found[-1] == pytest.approx(record.times[-1])

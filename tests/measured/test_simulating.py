"""Simulated trials against free fall, Coulomb's friction and rest, in every engine."""

import math

import numpy as np
import pytest
from motions import turned

from steadyload.engines.registry import capabilities
from steadyload.engines.world import GRAVITY, Box, WorldSettings
from steadyload.measured.derived import (
    face_down,
    impacts,
    resting_height,
    spins,
    time_to_rest,
    velocities,
)
from steadyload.measured.simulating import LONGER, _substeps, end_pose, simulated

SIDE = 0.1
CUBE = (SIDE, SIDE, SIDE)
FRAMES = np.arange(60) / 148.0


@pytest.fixture
def spatial(any_engine):
    if capabilities(any_engine).dimensions < 3:
        pytest.skip("not applicable: two dimensions")
    return any_engine


def test_a_flight_has_the_frames_of_the_record_and_is_a_parabola(spatial):
    offset, spin = (0.01, -0.005, 0.02), (3.0, -2.0, 1.0)
    box = Box(
        CUBE, 0.4, (0.0, 0.0, 20.0), offset, attitude=tuple(turned((1, 1, 0), [0.4])[0].tolist()),
        velocity=(1.0, 0.5, 2.0), angular_velocity=spin,
    )  # fmt: skip
    times = FRAMES + 3.0
    found = simulated("t", box, spatial, WorldSettings(), 960, times)
    assert found.times[: len(times)] == pytest.approx(times, abs=1e-12)
    assert found.times[-1] == pytest.approx(times[-1] + LONGER, abs=0.01)
    t = found.times - 3.0
    wanted = np.array(box.mass_centre) + t[:, None] * box.velocity
    wanted[:, 2] -= 0.5 * GRAVITY * t**2
    rates = spins(found)
    assert rates[0] == pytest.approx(rates[-1], abs=0.02), "a cube turns at one rate"
    bare = type(found)(found.name, found.times, found.positions, found.attitudes)
    assert velocities(found)[1:-1] == pytest.approx(velocities(bare)[1:-1], abs=0.05)
    assert rates[1:-1] == pytest.approx(spins(bare)[1:-1], abs=0.02)
    arms = np.array([_turned(q, offset) for q in found.attitudes])
    assert found.positions + arms == pytest.approx(wanted, abs=0.02)


def _turned(attitude, vector):
    w, *axis = attitude
    axis = np.array(axis)
    aside = 2.0 * np.cross(axis, vector)
    return vector + w * aside + np.cross(axis, aside)


@pytest.mark.parametrize("rate", [148.0, 60.0])
def test_a_cube_that_is_dropped_flat_rests_where_it_fell(spatial, rate):
    drop = 0.1
    box = Box(CUBE, 0.4, (0.2, 0.1, 0.5 * SIDE + drop))
    found = simulated("t", box, spatial, WorldSettings(), 480, np.arange(20) / rate)
    fall = math.sqrt(2.0 * drop / GRAVITY)
    assert impacts(found)[0] == pytest.approx(fall, abs=1.5 / rate)
    assert fall - 1.0 / rate < time_to_rest(found) < fall + 0.4
    assert resting_height(found) == pytest.approx(0.5 * SIDE, abs=3e-3)  # DART sinks in
    assert found.times[-1] >= found.times[0] + time_to_rest(found) + 0.1 - 1e-9
    assert face_down(found.attitudes[-1]).name == "-z"
    assert found.positions[-1][:2] == pytest.approx([0.2, 0.1], abs=1e-3)


@pytest.mark.parametrize("friction", [0.15, 0.4])
def test_a_cube_that_slides_stops_after_the_way_of_coulomb(spatial, friction):
    speed = 0.5
    box = Box(CUBE, 0.4, (0.0, 0.0, 0.5 * SIDE), velocity=(speed, 0.0, 0.0))
    times = np.arange(30) / 148.0
    found = simulated("t", box, spatial, WorldSettings(friction=friction), 960, times)
    way = speed**2 / (2.0 * friction * GRAVITY)
    assert found.positions[-1, 0] == pytest.approx(way, rel=0.1, abs=1e-3)
    centre, attitude = end_pose(box, spatial, WorldSettings(friction=friction), 960, times)
    assert centre[0] == pytest.approx(way, rel=0.1, abs=1e-3)
    assert face_down(attitude).name == "-z"


def test_the_last_pose_alone_is_that_of_the_whole_way():
    """Both take the same substeps."""
    for seed in range(4):
        random = np.random.default_rng(seed)
        box = Box(
            CUBE, 0.4, (0.0, 0.0, 0.2), attitude=tuple(turned(random.normal(size=3), [2.0])[0]),
            velocity=(0.5, 0.2, 0.0), angular_velocity=tuple(random.normal(0.0, 3.0, 3)),
        )  # fmt: skip
        times = np.arange(148) / 148.0
        found = simulated("t", box, "mujoco", WorldSettings(friction=0.3), 480, times)
        centre, attitude = end_pose(box, "mujoco", WorldSettings(friction=0.3), 480, times)
        assert centre == pytest.approx(found.positions[147], abs=1e-6)
        assert attitude == pytest.approx(found.attitudes[147], abs=1e-6)


@pytest.mark.parametrize(
    ("span", "frequency", "count"),
    [(0.01, 240.0, 3), (1 / 120, 240.0, 2), (0.1, 120.0, 12), (1e-4, 60.0, 1)],
)
def test_between_two_frames_are_whole_substeps_at_least_so_many_a_second(span, frequency, count):
    assert _substeps(span, frequency) == count

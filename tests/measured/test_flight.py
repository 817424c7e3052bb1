"""Free flight in closed form: the centre of mass and gravity that it shows, and releases."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from motions import CUBE, G, bouncing, free_flight, resting, turned
from scipy.spatial.transform import Rotation

from steadyload.measured.bodies import Body
from steadyload.measured.errors import MotionError
from steadyload.measured.flight import flight_facts, flight_frames, scaled
from steadyload.measured.motion import Trial
from steadyload.measured.releases import (
    Noise,
    departure,
    first_frame,
    landed,
    release,
    turns_as_a_cube,
)

LONG = Body(size=(0.1, 0.1, 0.3), mass=0.5)


def thrown(offset, seed, noise=0.0, count=25, gravity=G, body=CUBE):
    """A cube in flight whose centre of mass is off its middle; and its start, spin and velocity."""
    random = np.random.default_rng(seed)
    times = np.linspace(0.0, 0.2, count)
    start, velocity, spin = random.uniform((-1, -1, 2), (1, 1, 3)), *random.normal(size=(2, 3))
    spin = 8.0 * spin / np.linalg.norm(spin)
    first = Rotation.random(random_state=seed)
    turns = Rotation.from_rotvec(times[:, None] * spin) * first
    mass_centres = start + velocity * times[:, None]
    mass_centres[:, 2] -= 0.5 * gravity * times**2
    centres = mass_centres - turns.apply(offset)
    centres += noise * random.normal(size=centres.shape)
    attitudes = turns.as_quat(scalar_first=True)
    return Trial(f"{seed}", times, centres, attitudes, body=body), (start, velocity, spin, first)


@pytest.mark.parametrize("offset", [(0.0, 0.0, 0.0), (0.0, 0.0, 0.005), (0.01, -0.02, 0.003)])
@pytest.mark.parametrize("gravity", [9.6, G])
def test_the_centre_of_mass_and_gravity_are_those_of_the_flights(offset, gravity):
    trials = [thrown(offset, seed, gravity=gravity)[0] for seed in range(3)]
    facts = flight_facts(trials)
    assert facts.offset == pytest.approx(offset, abs=1e-8)
    assert facts.gravity.value == pytest.approx(gravity)
    assert facts.scale == pytest.approx(9.8 / gravity)
    longer = flight_facts([scaled(trial, 1.02) for trial in trials])
    assert longer.offset == pytest.approx(np.multiply(1.02, offset), abs=1e-8)
    assert longer.gravity.value == pytest.approx(1.02 * gravity)


def test_intervals_of_noisy_flights_hold_the_values_and_a_bad_trial_decides_nothing():
    offset = (0.002, 0.0, -0.006)
    good = [thrown(offset, seed, noise=1e-4)[0] for seed in range(80)]
    bad = [thrown(offset, seed, noise=5e-3)[0] for seed in range(80, 84)]
    for trials in (good, good + bad):
        facts = flight_facts(trials)
        assert facts.gravity.n == len(trials)
        for found, wanted in zip(facts.mass_offset, offset, strict=True):
            half = 0.5 * (found.high - found.low)
            assert 1e-5 < half < 1e-3
            assert abs(found.value - wanted) < 2.0 * half
        assert abs(facts.gravity.value - G) < 0.02


@pytest.mark.parametrize("offset", [(0.0, 0.0, 0.0), (0.01, -0.02, 0.003)])
def test_a_release_is_the_state_at_the_first_frame(offset):
    trial, (start, velocity, spin, first) = thrown(offset, 5)
    found = release(trial, offset, G)
    assert found.mass_centre == pytest.approx(start, abs=1e-9)
    assert found.velocity == pytest.approx(velocity, abs=1e-9)
    assert found.spin == pytest.approx(spin, abs=1e-6)
    aside = Rotation.from_quat(found.attitude, scalar_first=True) * first.inv()
    assert aside.magnitude() < 1e-6
    assert departure(trial, found, offset, G) < 1e-6
    box = found.box(replace(CUBE, inertia=(1e-3, 1e-3, 1e-3)), offset)
    assert box.mass_centre == pytest.approx(start, abs=1e-9)
    assert box.inertia == (1e-3, 1e-3, 1e-3)
    assert (box.size, box.mass, box.mass_offset) == (CUBE.size, CUBE.mass, offset)


def test_all_frames_of_a_flight_are_less_noisy_than_the_first():
    offset, apart, of_first = (0.0, 0.0, 0.0), [], []
    for seed in range(30):
        trial, (start, velocity, *_) = thrown(offset, seed, noise=1e-3)
        found = release(trial, offset, G)
        apart.append((np.abs(found.mass_centre - start).max(), found.velocity - velocity))
        of_first.append(np.abs(trial.positions[0] - start).max())
    assert np.median([each[0] for each in apart]) < 0.7 * np.median(of_first)
    assert np.std([each[1] for each in apart]) < 0.02


def test_what_departs_from_free_flight_is_found():
    trial, _ = thrown((0.0, 0.0, 0.0), 3)
    moved = trial.positions.copy()
    moved[12] += (0.0, 0.004, 0.0)
    off = replace(trial, positions=moved)
    assert departure(off, release(off, gravity=G), gravity=G) == pytest.approx(0.004, rel=0.1)


def test_a_body_that_is_no_cube_is_released_as_its_first_frame_is():
    trial, (_, velocity, *_) = thrown((0.0, 0.0, 0.0), 4, body=LONG)
    assert not turns_as_a_cube(LONG)
    assert turns_as_a_cube(CUBE)
    assert turns_as_a_cube(replace(LONG, inertia=(1e-3, 1.005e-3, 1e-3)))
    found = release(trial, gravity=G)
    assert found.attitude == pytest.approx(trial.attitudes[0])
    assert found.velocity == pytest.approx(velocity, abs=1e-9)


def test_the_first_frame_is_taken_as_it_is_recorded():
    trial = free_flight(body=CUBE)
    speeds = np.tile([1.0, -0.5, 2.0], (len(trial), 1)) - np.outer(G * trial.times, (0, 0, 1))
    axis = np.array((1.0, 2.0, -0.5))
    spins = np.tile(7.0 * axis / np.linalg.norm(axis), (len(trial), 1))
    found = first_frame(replace(trial, velocities=speeds, spins=spins))
    assert found.mass_centre == pytest.approx(trial.positions[0])
    assert found.velocity == pytest.approx([1.0, -0.5, 2.0])
    assert found.spin == pytest.approx(spins[0])  # it turns about an axis of its own
    by_differences = first_frame(trial)
    assert by_differences.velocity == pytest.approx([1.0, -0.5, 2.0], abs=1e-9)
    assert by_differences.spin == pytest.approx(spins[0], abs=1e-9)


def test_frames_of_a_flight_end_before_the_first_contact():
    trial, times = bouncing(height=0.5, rate=500.0)
    count = flight_frames(trial)
    corner = trial.positions[:, 2] - 0.05
    assert (corner[:count] >= 0.003).all()
    assert trial.times[count] < times[0]
    assert trial.times[count + 1] > times[0] - 0.01
    assert flight_frames(free_flight(body=CUBE)) == 21


@pytest.mark.parametrize(
    ("trials", "message"),
    [
        ([free_flight()], "trial 'flight': its size is not known; allowed: a trial with size_x"),
        ([resting(body=CUBE)], "trial 'rest': flies freely for 0 frames; allowed: 3 or more"),
        ([free_flight(body=CUBE)], "1 trials fly freely for 6 frames; allowed: 2 or more"),
        (
            [free_flight(rate=0.0, body=CUBE)] * 2,
            "the body does not turn in flight; allowed: one that does",
        ),
    ],
)
def test_what_flights_do_not_say_is_refused(trials, message):
    with pytest.raises(MotionError) as caught:
        flight_facts(trials)
    assert str(caught.value).startswith(message)


def test_size_and_mass_have_to_be_known_for_a_simulation():
    start = release(free_flight(body=CUBE), gravity=G)
    with pytest.raises(MotionError, match="size and mass of the body are not both known"):
        start.box(Body(size=(0.1, 0.1, 0.1)))


def test_noise_has_the_stated_deviations_and_grows_with_the_factor():
    start = release(free_flight(body=CUBE), gravity=G)
    noise = Noise(position_m=0.002, attitude_deg=1.0, velocity_ms=0.05, spin_rads=0.4)
    for factor in (0.5, 2.0):
        moved = [start.moved(noise, factor, np.random.default_rng(k)) for k in range(400)]
        aside = [
            Rotation.from_quat(one.attitude, scalar_first=True)
            * Rotation.from_quat(start.attitude, scalar_first=True).inv()
            for one in moved
        ]
        spreads = {
            0.002: np.std([one.mass_centre - start.mass_centre for one in moved]),
            np.radians(1.0): np.std([one.as_rotvec() for one in aside]),
            0.05: np.std([one.velocity - start.velocity for one in moved]),
            0.4: np.std([one.spin - start.spin for one in moved]),
        }
        for wanted, found in spreads.items():
            assert found == pytest.approx(factor * wanted, rel=0.1)
    still = start.moved(noise, 0.0, np.random.default_rng(0))
    assert still.attitude == pytest.approx(start.attitude, abs=1e-15)
    assert (still.velocity == start.velocity).all()


@settings(max_examples=60, deadline=None)
@given(
    axis=st.tuples(*[st.floats(-1.0, 1.0)] * 3).filter(lambda v: np.linalg.norm(v) > 0.1),
    angle=st.floats(-7.0, 7.0),
    seconds=st.floats(0.0, 0.3),
)
def test_flight_is_a_parabola_and_a_turn_and_can_be_flown_back(axis, angle, seconds):
    start = release(free_flight(axis, angle, body=CUBE), gravity=G)
    later = start.flown(seconds, G)
    fall = np.array((0.0, 0.0, -0.5 * G * seconds**2))
    assert later.mass_centre == pytest.approx(
        start.mass_centre + seconds * start.velocity + fall, abs=1e-12
    )
    aside = Rotation.from_quat(later.attitude, scalar_first=True)
    wanted = Rotation.from_rotvec(seconds * start.spin) * Rotation.from_quat(
        start.attitude, scalar_first=True
    )
    assert (aside * wanted.inv()).magnitude() < 1e-9
    back = later.flown(-seconds, G)
    assert back.mass_centre == pytest.approx(start.mass_centre, abs=1e-12)
    assert back.velocity == pytest.approx(start.velocity, abs=1e-12)


@pytest.mark.parametrize(("degrees", "reach"), [(0.0, 0.05), (45.0, 0.05 * np.sqrt(2.0))])
@pytest.mark.parametrize("offset", [(0.0, 0.0, 0.0), (0.0, 0.0, 0.01)])
def test_a_cube_lands_when_its_lowest_corner_is_on_the_floor(degrees, reach, offset):
    attitude = turned((0.0, 1.0, 0.0), [np.radians(degrees)])[0]
    trial = free_flight(rate=0.0, body=CUBE)
    start = replace(
        release(trial, gravity=G), attitude=attitude, velocity=np.array((0.5, 0.0, 0.0))
    )
    end = landed(start, CUBE.size, offset)
    up = offset[2] * np.cos(np.radians(degrees))
    assert end.mass_centre[2] == pytest.approx(reach + up, abs=1e-9)
    seconds = np.sqrt(2.0 * (1.0 - reach - up) / 9.8)
    assert end.mass_centre[0] == pytest.approx(start.mass_centre[0] + 0.5 * seconds)

"""The measured tosses of a cube: read by columns and constants that are named here."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from motions import G

from steadyload.measured.derived import (
    face_down,
    impacts,
    resting_height,
    spins,
    time_to_rest,
    velocities,
)
from steadyload.measured.flight import flight_facts, scaled
from steadyload.measured.motion_files import read_motion
from steadyload.measured.profiles import motion_profile
from steadyload.measured.releases import departure, release

DOCS = Path(__file__).resolve().parents[2] / "docs"
TOSSES = Path(__file__).resolve().parents[3] / "shared" / "data" / "tosses" / "tosses.parquet"
EDGE = 0.1048
NAMES = {"trial": "toss", "time": "t"}
CONSTANTS = {"size_x": EDGE, "size_y": EDGE, "size_z": EDGE, "mass": 0.37}


@pytest.fixture(scope="module")
def tosses():
    if not TOSSES.exists():
        pytest.skip("the tosses are not beside the project (../shared/data)")
    return read_motion(TOSSES, columns=NAMES, constants=CONSTANTS, ignored=["frame"])


def test_all_tosses_are_read_with_their_body(tosses):
    assert len(tosses) == 285
    assert sum(map(len, tosses)) == 29_791
    assert {trial.body.size for trial in tosses} == {(EDGE, EDGE, EDGE)}


def test_every_toss_ends_at_rest_flat_on_a_face(tosses):
    assert all(time_to_rest(trial) is not None for trial in tosses)
    assert all(len(impacts(trial)) >= 1 for trial in tosses)
    assert max(face_down(trial.attitudes[-1]).tilt_deg for trial in tosses) < 3.0


def test_stated_velocities_are_those_of_positions_and_attitudes(tosses):
    """Angular ones in axes of the body: by differences they agree as the data's page says."""
    turns, moves = [], []
    for trial in tosses:
        bare = replace(trial, velocities=None, spins=None)
        moves.append(np.linalg.norm(velocities(bare) - trial.velocities, axis=1))
        turns.append(np.linalg.norm(spins(bare) - trial.spins, axis=1))
    assert np.median(np.concatenate(turns)) < 0.11
    assert np.median(np.concatenate(moves)) < 0.03


def test_a_toss_begins_in_free_flight(tosses):
    """The mean vertical acceleration of the first frames is that of gravity, to within a tenth."""
    found = [np.polyfit(trial.times[:8], trial.velocities[:8, 2], 1)[0] for trial in tosses]
    assert np.median(found) == pytest.approx(-G, rel=0.1)


def test_flights_show_a_centre_of_mass_off_the_middle_and_lengths_that_are_too_short(tosses):
    """Both halves say the same; heights at rest confirm the lengths."""
    facts = [flight_facts(half) for half in (tosses[::2], tosses[1::2])]
    for one in facts:
        x, y, z = one.mass_offset
        assert 0.0045 < z.low < z.high < 0.0065
        assert max(abs(x.value), abs(y.value)) < 0.001
        assert 9.59 < one.gravity.low < one.gravity.high < 9.63
    assert facts[0].offset[2] == pytest.approx(facts[1].offset[2], abs=1.2e-3)
    height = np.median([resting_height(trial) for trial in tosses])
    assert facts[0].scale == pytest.approx(0.5 * EDGE / height, abs=3e-3)


def test_tosses_are_free_flight_before_they_touch_the_floor(tosses):
    facts = flight_facts(tosses)
    trials = [scaled(one, facts.scale) for one in tosses]
    apart = [departure(one, release(one, facts.offset), facts.offset) for one in trials]
    assert np.median(apart) < 2e-4
    assert np.quantile(apart, 0.98) < 2e-3


def test_the_profile_beside_the_docs_reads_the_same(tosses):
    profile = motion_profile(DOCS / "measured" / "tosses.toml")
    again = profile.read(TOSSES)
    assert len(again) == len(tosses)
    assert np.array_equal(again[7].positions, tosses[7].positions)
    assert again[7].body.size == tosses[7].body.size
    assert (again[7].body.friction, again[7].body.restitution) == (0.18, 0.125)

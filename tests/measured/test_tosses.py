"""The measured tosses of a cube: read by columns and constants that are named here."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from motions import G

from steadyload.measured.derived import face_down, impacts, spins, time_to_rest, velocities
from steadyload.measured.motion_files import read_motion

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

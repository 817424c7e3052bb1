"""Profiles of files of recorded motion: what they state, and what is refused."""

from pathlib import Path

import numpy as np
import pytest
from motions import free_flight

from steadyload.measured.errors import MotionError
from steadyload.measured.motion_files import write_motion
from steadyload.measured.profiles import motion_profile
from steadyload.measured.releases import Noise

DOCS = Path(__file__).parents[2] / "docs"


def profile_of(folder, text):
    path = folder / "profile.toml"
    path.write_text(text)
    return path


def test_a_file_is_read_by_its_profile(tmp_path):
    write_motion(tmp_path / "own.csv", [free_flight()])
    header, *rows = (tmp_path / "own.csv").read_text().splitlines()
    header = header.replace("trial", "toss").replace("time", "t")
    (tmp_path / "theirs.csv").write_text("\n".join([f"{header},n", *(f"{r},0" for r in rows)]))
    profile = motion_profile(
        profile_of(
            tmp_path,
            'body = "a cube"\nignored = ["n"]\n[columns]\ntrial = "toss"\ntime = "t"\n'
            "[constants]\nmass = 0.4\nfriction = 0.2\n[noise]\nspin_rads = 0.1\n",
        )
    )
    (trial,) = profile.read(tmp_path / "theirs.csv")
    assert (trial.body.mass, trial.body.friction, trial.body.size) == (0.4, 0.2, None)
    assert np.array_equal(trial.positions, free_flight().positions)
    assert (profile.body, profile.source) == ("a cube", "")
    assert profile.noise == Noise(spin_rads=0.1)


def test_the_profile_of_the_tosses_states_the_cube_and_its_source():
    profile = motion_profile(DOCS / "measured" / "tosses.toml")
    assert "CoRL 2020" in profile.source
    half, mass = 0.5 * profile.constants["size_x"], profile.constants["mass"]
    # As the authors state it: 0.295 in units of mass and half width.
    assert profile.constants["inertia_x"] == pytest.approx(0.295 * half**2, rel=1e-3)
    assert profile.constants["inertia_x"] > mass * (2 * half) ** 2 / 6.0
    assert profile.noise == Noise()


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("colums = {}", "unknown key 'colums'; did you mean 'columns'?"),
        ("columns = 3", "columns is 3; allowed: keys with values"),
        ("[constants]\nmass = 'heavy'", "constants[mass] is 'heavy'; allowed: a number"),
        ("[noise]\nspin_rads = -1", "noise: spin_rads is -1; allowed: a number, 0 to 100 [rad/s]"),
        ("[noise]\nattitude_deg = nan", "noise: attitude_deg is nan; allowed: a number, 0 to 180"),
        ("ignored = 'frame'", "ignored is 'frame'; allowed: a list"),
        ("[columns", "not valid TOML"),
        ("[columns]\ntrail = 'toss'", "columns: unknown column 'trail'; did you mean 'trial'?"),
        ("[constants]\nz = 1", "constants: unknown quantity 'z'; allowed"),
    ],
)
def test_a_profile_that_is_not_allowed_is_refused(tmp_path, text, message):
    path = profile_of(tmp_path, text)
    with pytest.raises(MotionError) as caught:
        motion_profile(path)
    assert str(caught.value).startswith(f"{path}: {message}")

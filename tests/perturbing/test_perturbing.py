"""``--perturb`` moves every start that a simulation gets, in this process and in workers."""

import shutil
from pathlib import Path

import numpy as np
import pytest

TESTS = Path(__file__).parents[1]

INNER = """
import subprocess, sys
import numpy as np, pytest
from steadyload.engines.registry import open_world
from steadyload.engines.world import Box, WorldSettings
from steadyload.runs.pool import SinglePart, run_units

SIZE, CENTRE = (0.4, 0.1, 0.2), (1.0, 2.0, 0.1)

def start():
    with open_world("mujoco", WorldSettings()) as world:
        world.add_box(Box(SIZE, 1.0, CENTRE))
        world.prepare()
        return world.poses().centres[0]

class Unit(SinglePart):
    def describe(self, part): return "it"

def work(unit):
    yield start()

def in_a_command():
    code = f"import sys; sys.path[:0] = {sys.path!r}; import test_inner; print(*test_inner.start())"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return np.array(done.stdout.split(), dtype=float)

def test_all_are_moved_alike():
    here, again, there = start(), start(), in_a_command()
    [(_, [worker])] = run_units(work, [Unit()], workers=1, crashed=None)
    off = here - CENTRE
    assert (off != 0.0).all() and (np.abs(off) <= 1e-7 * np.array(SIZE)).all()
    for other in (again, there, worker):
        np.testing.assert_array_equal(here, other)
    print("STARTS", *here.tolist())

@pytest.mark.exact("it has to be")
def test_nothing_is_moved_where_it_holds_to_the_last_bit():
    [(_, [worker])] = run_units(work, [Unit()], workers=1, crashed=None)
    for found in (start(), in_a_command(), worker):
        np.testing.assert_array_equal(found, CENTRE)
"""


@pytest.fixture
def perturbed(pytester, monkeypatch):
    """Runs the tests above with a seed; returns the start that they tell."""
    shutil.copytree(TESTS / "perturbing", pytester.path / "perturbing")
    (pytester.path / "perturbing" / Path(__file__).name).unlink()
    for name in ("conftest.py", "allowed_skips.toml"):
        shutil.copy(TESTS / name, pytester.path)
    pytester.makeini("[pytest]\nmarkers = exact(reason)\npythonpath = .\n")
    pytester.makepyfile(test_inner=INNER)

    def run(seed):
        result = pytester.runpytest_subprocess("--perturb", seed, "-s", "-p", "no:cacheprovider")
        result.assert_outcomes(passed=2)
        [told] = [line for line in result.outlines if "STARTS" in line]
        return np.array(told.partition("STARTS")[2].split(), dtype=float)

    return run


def test_every_process_starts_where_the_seed_says(perturbed):
    first, second = perturbed("1"), perturbed("2")
    assert (first != second).any()

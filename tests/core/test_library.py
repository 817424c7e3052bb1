"""The C library that is loaded is that of the sources, and has the constants of Python."""

import copy
import pickle
import subprocess
import sys

import numpy as np
import pytest

from steadyload.core import building
from steadyload.core.forces import Energy
from steadyload.core.library import RefusedError, WrongArrayError, count_of
from steadyload.core.session import Session

COMMAND = "from steadyload.cli import main; sys.exit(main(['methods']))"


def run(code):
    """A command in a process in which some code runs before."""
    program = f"import sys; from steadyload.core import building, constants; {code}; {COMMAND}"
    return subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)


def test_without_a_library_from_these_sources_a_command_names_the_one_that_builds_it():
    done = run("building.name = lambda: 'of-older-sources.lib'")
    assert (done.returncode, done.stdout) == (1, "")
    assert done.stderr == (
        "steadyload: the C library of this installation is not built from its present sources; "
        "`make build` builds it\n"
    )


@pytest.mark.parametrize("name", ["TOLERANCE", "REFUSED", "CARRIED", "QUANTITIES"])
def test_a_constant_that_differs_in_c_is_found_when_the_library_is_loaded(name):
    done = run(f"constants.{name} = 17.0")
    assert done.returncode == 1
    assert done.stderr == (
        f"steadyload: {name} is 17.0 in Python, and another number in the C library\n"
    )


def test_what_c_made_is_not_copied():
    """Two would free the same memory."""
    session = Session([0.0] * 3 + [100.0] * 3 + [0.0, 0.0, 100.0, 100.0, 0.0])
    for copy_of in (copy.deepcopy, pickle.dumps):
        with pytest.raises(TypeError, match="cannot be copied or pickled"):
            copy_of(session)


def test_columns_whose_starts_descend_are_refused_before_a_row_is_read():
    starts, none = np.array([0, 2**20, 1, 1], np.int32), np.zeros(0)
    with pytest.raises(RefusedError):
        Energy(
            starts, np.ones(1, np.int32), np.ones(3), np.zeros(1, np.int32),
            np.zeros(0, np.int32), none, np.zeros(3), none.astype(bool),
        )  # fmt: skip


def test_at_the_end_of_a_process_what_c_made_can_still_be_used():
    code = (
        "import atexit; atexit.register(lambda: print(kept.put(box), len(kept.supports.below))); "
        "from steadyload.layouts.model.growing import GrowingLayout; "
        "from steadyload.layouts import Item, Pallet; "
        "kept = GrowingLayout(Pallet(100.0, 100.0, 100.0), 'a'); "
        "box = Item(0, (0.0, 0.0, 0.0), (10.0, 10.0, 10.0), 1.0)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert (done.returncode, done.stdout) == (0, "None 1\n"), done.stderr


def test_with_the_library_the_command_runs():
    assert run("pass").returncode == 0


@pytest.mark.parametrize(
    "given",
    [[1.0], np.float64(1.0), np.array(1.0), np.broadcast_to(np.zeros(1), 2**31)],
    ids=["list", "number", "no dimension", "too long"],
)
def test_what_has_no_length_that_c_counts_is_refused(given):
    with pytest.raises(WrongArrayError, match="x has to be an array of at most 2147483647 rows"):
        count_of("x", given)


def test_an_array_is_as_long_as_it_is():
    assert count_of("x", np.zeros((3, 2))) == 3


@pytest.mark.skipif(not building.found(), reason="there is no C compiler")
def test_a_library_that_is_built_takes_the_place_of_others_in_its_folder(tmp_path):
    into = tmp_path / "lib"
    into.mkdir()
    (into / "older.lib").touch()
    assert building.build(into, "newer.lib", "-O0") == into / "newer.lib"
    assert [path.name for path in into.iterdir()] == ["newer.lib"]

"""The C library that is loaded is that of the sources, and has the constants of Python."""

import subprocess
import sys

import pytest

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


@pytest.mark.parametrize("name", ["TOLERANCE", "REFUSED", "CARRIED", "OF_MOVED"])
def test_a_constant_that_differs_in_c_is_found_when_the_library_is_loaded(name):
    done = run(f"constants.{name} = 17.0")
    assert done.returncode == 1
    assert done.stderr == (
        f"steadyload: {name} is 17.0 in Python, and another number in the C library\n"
    )


def test_with_the_library_the_command_runs():
    assert run("pass").returncode == 0

"""What judging a file costs, shared by the tests of files that do harm."""

import json
import os
import subprocess
import sys
from typing import NamedTuple

import pytest

CPU_LIMIT = 6
"""[s], where a command would never end."""
ADDRESS_LIMIT = 1500
"""[MB] that a command may address. Libraries reserve memory and do not touch it."""

MEASURE = """
import json, resource, subprocess, sys
cpu, memory = map(int, sys.argv[1:3])
def limit():
    resource.setrlimit(resource.RLIMIT_CPU, (cpu, cpu))
    resource.setrlimit(resource.RLIMIT_AS, (memory, memory))
run = subprocess.run(sys.argv[3:], capture_output=True, text=True, preexec_fn=limit)
used = resource.getrusage(resource.RUSAGE_CHILDREN)
cpu = used.ru_utime + used.ru_stime
print(json.dumps([run.returncode, run.stdout, run.stderr, cpu, used.ru_maxrss / 1024]))
"""


class Ended(NamedTuple):
    """A command that has ended: CPU time in seconds, peak of resident memory in MiB."""

    status: int
    out: str
    err: str
    cpu: float
    memory: float


def run_command(*arguments: str, cpu: int = CPU_LIMIT) -> Ended:
    """A command of the command line with limits; that of CPU time is in seconds.

    A small process starts it: the kernel's peak of memory begins with that of the starting process,
    and a process that runs tests has had a lot.
    """
    command = [sys.executable, "-m", "steadyload.cli", *arguments]
    limits = [str(cpu), str(ADDRESS_LIMIT * 2**20)]
    measured = subprocess.run(
        [sys.executable, "-S", "-c", MEASURE, *limits, *command],
        capture_output=True, text=True, check=True, env=os.environ | {"OPENBLAS_NUM_THREADS": "1"},
    )  # fmt: skip
    return Ended(*json.loads(measured.stdout))


@pytest.fixture(scope="session")
def ended():
    """Runs a command of the command line, with limits and measured."""
    return run_command


@pytest.fixture(scope="session")
def cost_of_version():
    """CPU seconds of the command that does nothing."""
    return run_command("--version").cpu

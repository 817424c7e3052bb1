"""A process whose parent was killed while it started it ends in silence."""

import os
import pickle
import subprocess
from multiprocessing import resource_tracker, spawn

import pytest

from steadyload.runs.worker import silent_orphans, start_process


def started(content):
    """Exit status and errors of a new process that finds no more than this in its pipe."""
    read, write = os.pipe()
    tracker = resource_tracker.getfd()
    command = spawn.get_command_line(tracker_fd=tracker, pipe_handle=read)
    process = subprocess.Popen(command, pass_fds=(read, tracker), stderr=subprocess.PIPE, text=True)
    os.close(read)
    os.write(write, content)
    os.close(write)
    _, said = process.communicate(timeout=1800)
    return process.returncode, said


@pytest.mark.parametrize("content", [b"", pickle.dumps({"name": "worker"})[:10]])
def test_a_process_that_cannot_read_its_work_says_nothing(content):
    assert "Traceback" in started(content)[1]
    with silent_orphans():
        assert started(content) == (1, "")
    assert "Traceback" in started(content)[1]


def test_a_process_says_what_goes_wrong_in_its_work(capfd):
    process, pipe = start_process(int)  # which takes no pipe
    with pipe:
        process.join(600)
    assert process.exitcode == 1
    assert "TypeError: int() argument must be" in capfd.readouterr().err

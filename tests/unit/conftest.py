"""What tests share: judges that do their process harm, commands to interrupt, a clock of steps."""

import importlib
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from types import SimpleNamespace

import pytest

from steadyload.engines.registry import world_class
from steadyload.methods import registry

_JUDGES = Path(__file__).parent / "outside" / "outside_judges.py"


@pytest.fixture
def outside(tmp_path, monkeypatch):
    """The judges of another distribution, found by entry points as an installed one's are."""
    site = tmp_path / "site"
    about = site / "outside_judges-1.0.dist-info"
    about.mkdir(parents=True)
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: outside-judges\nVersion: 1.0\n")
    (about / "entry_points.txt").write_text(
        "[steadyload.methods]\nharmful = outside_judges:Harmful\n"
    )
    (site / "outside_judges.py").write_bytes(_JUDGES.read_bytes())
    monkeypatch.syspath_prepend(site)
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(site), *filter(None, sys.path)]))
    monkeypatch.setenv("OUTSIDE_JUDGES", str(tmp_path))
    registry._from_other_distributions.cache_clear()
    yield importlib.import_module("outside_judges")
    registry._from_other_distributions.cache_clear()
    del sys.modules["outside_judges"]


@pytest.fixture
def begin():
    """Starts the command as the leader of a process group, which Ctrl-C reaches as a whole."""

    def started(*arguments, cwd=None):
        return subprocess.Popen(
            [sys.executable, "-m", "steadyload.cli", *arguments], cwd=cwd, stderr=subprocess.PIPE,
            text=True, start_new_session=True,
            env=os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))},
            # What a shell runs in the background ignores interrupts, and so does all it starts.
            preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
        )  # fmt: skip

    return started


@pytest.fixture
def begin_study(begin):
    """Starts ``study.toml`` in a folder, and returns when the first of its results is there."""

    def started(folder, *options):
        process = begin("study", "run", "study.toml", "-o", "run", *options, cwd=folder)
        deadline = time.monotonic() + 60
        while not list(folder.glob("run/results/*.parquet")) and time.monotonic() < deadline:
            time.sleep(0.005)
        return process

    return started


@pytest.fixture
def told_time(monkeypatch):
    """Puts a clock into modules that stands still but for two things that ``engine`` does.

    A substep takes a millisecond, and adding a box takes 20. What is clocked can then be told
    exactly, on any machine.
    """

    def installed(engine, *modules):
        world, now = world_class(engine), 0.0
        advance, add_box = world._advance, world.add_box

        def stepping(self, substeps, length):
            nonlocal now
            advance(self, substeps, length)
            now += 1e-3 * substeps

        def adding(self, box):
            nonlocal now
            now += 20e-3
            return add_box(self, box)

        monkeypatch.setattr(world, "_advance", stepping)
        monkeypatch.setattr(world, "add_box", adding)
        clock = SimpleNamespace(process_time=lambda: now, perf_counter=lambda: now)
        for module in modules:
            monkeypatch.setattr(module, "time", clock)

    return installed

"""Commands killed at random moments go on to what a command makes that was never killed."""

import dataclasses
import os
import shutil
import signal
import subprocess
import time
from itertools import cycle
from pathlib import Path
from random import Random

import pandas as pd
import pytest
from verdict_tables import verdicts

from steadyload.cli import main
from steadyload.labelling.building.splits import SplitSizes
from steadyload.labelling.labelling import write_unlabelled
from steadyload.layouts.benchmark import load_benchmark
from steadyload.layouts.benchmark.dataset import row_of
from steadyload.layouts.packing.packing import random_layouts
from steadyload.learners.weights import load_weights
from steadyload.runs.definition import load_study
from steadyload.runs.results import load_manifest, load_results
from steadyload.runs.runner import run_study
from steadyload.tuning.ledger import Ledger

STUDY = 'shard_size = 1\ngenerated = {}\nseed = 20\nscenarios = ["S1"]\nmethods = {}\n'
STATUS = {signal.SIGINT: 130, signal.SIGTERM: -signal.SIGTERM, signal.SIGKILL: -signal.SIGKILL}
BEFORE_OURS = 0.1
"""CPU seconds of a command after which interrupts are its own; before, they are Python's."""


class Victim:
    """A command that is killed and begun again, in a folder.

    Args:
        begin: the fixture.
        folder: where it is called.
        words: of the command.
        last: word with which the last line begins that it says when it was not killed, if any.
    """

    def __init__(self, begin, folder, words, last=None):
        self._start = lambda: begin(*words, cwd=folder)
        self._last = last
        self.kills = []

    def kill(self, number, seconds, *, alone):
        """Send a signal after some seconds, to its process alone or to its whole group.

        Returns whether it was still at work; then it has ended as it should.
        """
        process, said = self._signalled(number, seconds, alone=alone)
        while "Fatal Python error: init_import_site" in said:  # a start so slow that Python was hit
            seconds += BEFORE_OURS
            process, said = self._signalled(number, seconds, alone=alone)
        lines = [line.split() for line in said.splitlines()]
        if process.returncode == 0 or any(self._last in line[:1] for line in lines):
            return False  # it had said all that it had to say
        self.kills.append((number.name, round(seconds, 2), alone, process.returncode, said))
        print(*self.kills[-1])
        # A search tells of every generation when it is judged.
        lines = [line for line in said.splitlines() if not line.startswith("generation ")]
        assert process.returncode == STATUS[number], self.kills[-1]
        assert len(lines) == (number is signal.SIGINT), self.kills[-1]
        assert all(line.startswith("steadyload: interrupted") for line in lines)
        return True

    def _signalled(self, number, seconds, *, alone):
        """The process after its end, and its errors."""
        process = self._start()
        while process.poll() is None and _cpu_seconds(process.pid) < BEFORE_OURS:
            time.sleep(0.002)
        try:
            process.wait(seconds)
        except subprocess.TimeoutExpired:
            (os.kill if alone else os.killpg)(process.pid, number)
        _, said = process.communicate(timeout=1800)
        _await_the_end_of_all(process.pid)
        return process, said

    def kill_at(self, seconds, anew):
        """Kill it at these moments, by every signal in turn; anew and sooner where it was done."""
        random = Random(7)
        for number, moment in zip(cycle(STATUS), seconds, strict=False):
            while not self.kill(number, moment, alone=random.random() < 0.5):
                anew()
                moment *= 0.7

    def finish(self):
        """Let it come to its end.

        Returns the seconds it took, and the word with which its last line began, if any.
        """
        process, begun = self._start(), time.monotonic()
        _, said = process.communicate(timeout=1800)
        assert process.returncode == 0, said
        return time.monotonic() - begun, (said.splitlines() or [""])[-1].partition(" ")[0] or None


def _cpu_seconds(pid):
    try:
        return int(Path(f"/proc/{pid}/schedstat").read_text().split()[0]) / 1e9
    except OSError:
        return float("inf")


def _group(leader):
    """The states of the processes of a group, without those that have ended."""
    found = subprocess.run(["ps", "-eo", "pgid=,stat="], capture_output=True, text=True, check=True)
    rows = [line.split() for line in found.stdout.splitlines()]
    return [stat for pgid, stat in rows if pgid == str(leader) and not stat.startswith("Z")]


def _await_the_end_of_all(leader):
    """Python's tracker of shared resources goes last, by itself."""
    deadline = time.monotonic() + 600
    while _group(leader) and time.monotonic() < deadline:
        time.sleep(0.02)
    assert not _group(leader), "processes are left"


def names(folder):
    """The files in a folder; those of shards without their checksums, which cover clocks."""
    files = [path.relative_to(folder) for path in folder.rglob("*") if path.is_file()]
    shard = {file: file.name.split(".") for file in files}
    return sorted(str(f.parent / s[0] if len(s) == 3 and s[0] else f) for f, s in shard.items())


def labels(folder):
    return load_benchmark(folder).cases.to_csv()


def search(folder):
    ledger = Ledger.of(folder)[1]
    entries = {
        g: (e.generation, e.trial.right.tolist(), e.trial.cost.tolist(), e.trial.reason)
        for g, e in ledger.entries.items()
    }
    return entries, [(end.number, end.asked, end.median) for end in ledger.ends]


def weights(folder):
    return load_weights(folder / "weights").manifest["hashes"]


def spatial_verdicts(folder):
    return verdicts(folder / "spatial").to_csv()


def study_in(folder, layouts, *methods):
    """Write a study; methods are quoted as TOML and Python do."""
    folder.mkdir(exist_ok=True)
    (folder / "study.toml").write_text(STUDY.format(layouts, list(methods)))
    return folder


ENDED = (60, "fbs", "sme", "ps_opt@mujoco")
"""A study that is ended: layouts, and methods."""


@pytest.fixture(scope="module")
def never_ended(tmp_path_factory):
    folder = study_in(tmp_path_factory.mktemp("never"), *ENDED)
    run_study(load_study(folder / "study.toml"), folder / "run")
    return folder / "run"


@pytest.mark.parametrize(
    ("number", "told"),
    [
        (signal.SIGTERM, ""),
        (signal.SIGINT, "steadyload: interrupted; what is finished stays in run, and the same "
                        "command goes on\n"),
    ],
    ids=["as a batch system", "by Ctrl-C"],
)  # fmt: skip
def test_a_study_that_is_ended_ends_at_once_and_resumes_to_the_same_table(
    begin_study, tmp_path, never_ended, number, told
):
    """A signal to the whole group: of the command and of its workers."""
    process, run = begin_study(study_in(tmp_path, *ENDED), "-j", "2"), tmp_path / "run"
    assert len(_group(process.pid)) >= 3
    os.killpg(process.pid, number)
    _, said = process.communicate(timeout=1800)
    assert (process.returncode, said) == (STATUS[number], told)
    _await_the_end_of_all(process.pid)
    assert 0 < len(load_results(run)) < 180
    assert load_manifest(run)["finished"] is None
    run_study(load_study(tmp_path / "study.toml"), run)
    pd.testing.assert_frame_equal(verdicts(run), verdicts(never_ended))
    assert names(run) == names(never_ended)


def test_a_study_killed_twenty_times_ends_with_the_same_table(begin, tmp_path):
    """At seven moments of the first second and 13 of the three after it, by three signals."""
    methods = ("fbs", "sme", "equilibrium", "ps3@mujoco", "ps3@bullet")
    whole, killed = (study_in(tmp_path / name, 16, *methods) for name in ("whole", "killed"))
    words = ("study", "run", "study.toml", "-o", "run", "-j", "2")
    Victim(begin, whole, words).finish()

    def check():
        pd.testing.assert_frame_equal(verdicts(killed / "run"), verdicts(whole / "run"))
        assert names(killed) == names(whole)

    def anew():
        check()
        shutil.rmtree(killed / "run")

    random, victim = Random(1), Victim(begin, killed, words)
    early = [random.uniform(0, 1 - BEFORE_OURS) for _ in range(7)]
    moments = early + [random.uniform(1, 4) for _ in range(13)]
    victim.kill_at(random.sample(moments, 20), anew)
    victim.finish()
    check()
    assert len(victim.kills) == 20


@pytest.fixture(scope="module")
def unlabelled(tmp_path_factory):
    """A set of 24 small layouts, two an item list."""
    layouts = [lay.first(6) for lay in random_layouts(24, seed=5)]
    rows = [
        row_of(lay, f"Class_1_Instance_{k // 2}", 1, (lay.name,)) for k, lay in enumerate(layouts)
    ]
    sizes = SplitSizes(test=4, validation=4, test_lists=2, validation_lists=2)
    folder = tmp_path_factory.mktemp("unlabelled") / "set"
    cases = [("S1", lay) for lay in layouts]
    manifest = {"seed": 1, "splits": dataclasses.asdict(sizes)}
    write_unlabelled(folder, pd.DataFrame(rows), cases, manifest)
    return folder


@pytest.fixture(scope="module")
def labelled(unlabelled, tmp_path_factory):
    folder = shutil.copytree(unlabelled, tmp_path_factory.mktemp("labelled") / "set")
    assert main(["benchmark", "label", str(folder), "--judges", "none", "-j", "1"]) == 0
    return folder


COMMANDS = {
    "label": ("benchmark label out --judges none -j 2", labels),
    "tune": (
        "tune --engine mujoco --benchmark SET --cost cost.json --population 4 --generations 2 "
        "-j 2 -o out", search,
    ),
    "train": (
        "train --data SET --option hidden=8 --option epochs=6 --threads 1 --members 2 "
        "--left-out 0.2 -o out", weights,
    ),
    "evaluation": (
        "study evaluation -m fbs -m sme -m equilibrium --limit 3 -j 2 "
        "--work out -o page", spatial_verdicts,
    ),
}  # fmt: skip
"""Commands that can be gone on with, and what they make, without clocks."""


@pytest.mark.parametrize("name", COMMANDS)
def test_a_killed_command_goes_on_to_the_same_output(name, begin, tmp_path, unlabelled, labelled):
    words, made = COMMANDS[name]
    whole, killed = tmp_path / "whole", tmp_path / "killed"
    words = words.replace("SET", str(labelled))  # made by now, and with it what is compiled

    def anew(folder):
        shutil.rmtree(folder / "out", ignore_errors=True)
        if name == "label":
            shutil.copytree(unlabelled, folder / "out")

    for folder in (whole, killed):
        folder.mkdir()
        anew(folder)
    seconds, last = Victim(begin, whole, words.split()).finish()
    if name == "tune":  # what judging costs is measured
        shutil.copy(whole / "cost.json", killed)
    random, victim = Random(name), Victim(begin, killed, words.split(), last)
    moments = [random.uniform(0.2, 0.7) * seconds for _ in STATUS]
    victim.kill_at(moments, lambda: anew(killed))
    victim.finish()
    assert made(killed / "out") == made(whole / "out")
    assert names(killed) == names(whole)
    assert len(victim.kills) == len(STATUS)

"""A command that is given a file without end says so, in little time and memory."""

import hashlib
import json
import os
import re
import shutil
import subprocess
import sys

import numpy as np
import pytest

from steadyload.atomic import manifest_text
from steadyload.layouts import Item, Layout, Pallet
from steadyload.layouts.writers import as_csv, as_native
from steadyload.learners.weights import SHIPPED

COMMANDS = """
import json, os, resource, sys
from steadyload.cli import main
import steadyload.layouts.formats, steadyload.learners.weights, steadyload.runs.runner
import steadyload.transport.rules, steadyload.studies.registry
def used():
    return int(open("/proc/self/statm").read().split()[0]) * resource.getpagesize()
for words in json.loads(sys.argv[1]):
    sys.stdout.flush()
    if not (child := os.fork()):
        cpu = sum(resource.getrusage(resource.RUSAGE_SELF)[:2])
        resource.setrlimit(resource.RLIMIT_CPU, (int(cpu) + 4, int(cpu) + 5))
        memory = used() + 500 * 2**20
        resource.setrlimit(resource.RLIMIT_AS, (memory, memory))
        try:
            status = main(words)
        except BaseException as error:
            print(repr(error)[:200], file=sys.stderr)
            status = 99
        sys.stderr.flush()
        os._exit(status)
    print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), flush=True)
    print("--", file=sys.stderr, flush=True)
"""
"""Every command in a process of its own, which ends after some seconds of CPU time."""


@pytest.fixture
def ended(tmp_path):
    """Exit status and standard error of commands."""
    layout = Layout("A", Pallet(120, 160, 80), (Item(0, (0, 0, 0), (40, 30, 40), 12.0),))
    (tmp_path / "ok.json").write_text("".join(as_native([layout])))
    (tmp_path / "zero.toml").symlink_to("/dev/zero")
    (tmp_path / "sparse.toml").touch()
    os.truncate(tmp_path / "sparse.toml", 3 * 2**30)

    def run(*commands):
        told = subprocess.run(
            [sys.executable, "-c", COMMANDS, json.dumps(commands)],
            cwd=tmp_path, capture_output=True, text=True, check=True,
            env=os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))},
        )  # fmt: skip
        return list(zip(told.stdout.split(), told.stderr.split("--\n"), strict=False))

    return run


def test_every_door_for_a_file_of_a_user_has_a_limit(ended):
    commands = [
        words
        for file in ("zero.toml", "sparse.toml")
        for words in (
            ["transport", "ok.json", "--rule", file],
            ["transport", "ok.json", "--history", file],
            ["study", "evaluation", "--config", file],
            ["study", "run", file],
            ["check", "ok.json", "--profile", file],
        )
    ]
    for words, (status, said) in zip(commands, ended(*commands), strict=True):
        assert status == "2", (words, said)
        assert re.fullmatch(r"steadyload: \S+: is too large \(.*\); allowed: \d+ MiB\n", said), (
            words
        )


def test_weights_whose_names_share_their_bytes_are_refused_at_once(ended, tmp_path):
    """Five thousand tensors of 200 kB each in a file of no more than the network's."""
    size = 200_000
    entry = {"dtype": "F32", "shape": [size // 4 - 1], "data_offsets": [4, size]}
    header = json.dumps({f"t{k}": entry for k in range(5000)}).encode()
    content = np.uint64(len(header)).tobytes() + header + bytes(size)
    manifest = json.loads((SHIPPED / "lstm_1" / "manifest.json").read_bytes())
    del manifest["checksum"]
    manifest["hashes"] = [hashlib.sha256(content).hexdigest()]
    (tmp_path / "w").mkdir()
    (tmp_path / "w" / "manifest.json").write_text(manifest_text(manifest))
    (tmp_path / "w" / "member_0.safetensors").write_bytes(content)
    [(status, said)] = ended(["check", "ok.json", "-m", "lstm_1:weights=./w"])
    assert status == "2", said
    assert said.endswith("member_0.safetensors: is no safetensors file of numbers\n")


def test_weights_that_are_too_large_are_refused_by_a_sentence_of_the_worker(ended, tmp_path):
    shutil.copytree(SHIPPED / "lstm_1", tmp_path / "w")
    os.truncate(tmp_path / "w" / "member_0.safetensors", 40_000_000)
    [(status, said)] = ended(["check", "ok.json", "-m", "lstm_1:weights=./w"])
    assert status == "2", said
    assert said.endswith("member_0.safetensors: is too large (39 MiB); allowed: 2 MiB\n")


def test_a_layout_file_with_a_hole_is_refused_before_the_hole_is_held(ended, tmp_path):
    """A table that begins as one, and goes on with zeros for as long as is allowed, or longer."""
    header, row = as_csv(
        [Layout("A", Pallet(9, 9, 9), (Item(0, (0, 0, 0), (9, 9, 9), 1.0),))]
    ).split()
    rows = "\n".join(f"A{k}{row[1:]}" for k in range(3000))
    for name, size in (("hole.csv", 2**28 - 1), ("long.csv", 2**28 + 1)):
        (tmp_path / name).write_text(f"{header}\n{rows}\n")
        os.truncate(tmp_path / name, size)
    (hole, said), (long, too) = ended(["check", "hole.csv"], ["check", "long.csv"])
    assert (hole, long) == ("2", "2"), (said, too)
    assert re.fullmatch(r"steadyload: hole\.csv: is no text \(byte \d+ is 0\); .*\n", said)
    assert too == "steadyload: long.csv: is too large; allowed for this format: 256 MiB\n"

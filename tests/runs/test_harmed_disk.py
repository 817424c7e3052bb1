"""A full disk, a folder that is none, a changed bit: one sentence, and running again mends."""

import os
import resource
import subprocess
import sys
from pathlib import Path

import pandas as pd
import pytest

from steadyload.cli import main
from steadyload.runs.results import load_results

STUDY = 'generated = 6\nmethods = ["fbs", "sme"]\nshard_size = 2\n'
PHASES = ("build", "step", "read", "total")
TIMES = [f"{clock}_{phase}" for clock in ("cpu", "wall") for phase in PHASES]


def run(folder):
    return main(["study", "run", str(folder / "study.toml"), "-o", str(folder / "run")])


def table(folder):
    return load_results(folder / "run").drop(columns=TIMES)


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "study.toml").write_text(STUDY)
    return tmp_path


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    made = tmp_path_factory.mktemp("whole")
    (made / "study.toml").write_text(STUDY)
    assert run(made) == 0
    return made


def full_disk(folder, most):
    """The command where no file may have more bytes than ``most``."""
    return subprocess.run(
        [sys.executable, "-m", "steadyload.cli", "study", "run", "study.toml", "-o", "run"],
        cwd=folder, capture_output=True, text=True,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (most, most)),
        env=os.environ | {"PYTHONDONTWRITEBYTECODE": "1"},
    )  # fmt: skip


@pytest.mark.parametrize("most", [100, 5_000])
def test_a_full_disk_loses_nothing(folder, whole, most):
    """The first limit stops the copy of the layouts, the second one a shard."""
    ended = full_disk(folder, most)
    assert ended.returncode == 2
    assert ended.stderr.startswith("steadyload: ")
    assert ended.stderr.count("\n") == 1
    assert "File too large" in ended.stderr
    left = [p for p in folder.rglob("*") if p.is_file() and p.name != "study.toml"]
    assert not [p for p in left if p.name != ".lock" and p.stat().st_size >= most]
    assert run(folder) == 0
    pd.testing.assert_frame_equal(table(folder), table(whole))


@pytest.mark.parametrize("place", ["run", "run/results", "run/manifest.json"])
def test_a_place_that_cannot_be_written_to_is_named(folder, place, capsys):
    harm = folder / place
    harm.parent.mkdir(exist_ok=True)
    if harm.suffix:
        harm.mkdir()
    else:
        harm.write_text("mine")
    assert run(folder) == 2
    err = capsys.readouterr().err
    assert err.startswith("steadyload: ")
    assert err.count("\n") == 1
    assert str(folder / "run") in err
    if harm.is_file():
        assert harm.read_text() == "mine"
        harm.unlink()
    else:
        harm.rmdir()
    assert run(folder) == 0


@pytest.mark.parametrize("pattern", ["manifest.json", "layouts.json", "results/*.parquet"])
def test_a_changed_bit_is_told_and_mended_by_running_again(folder, whole, pattern, capsys):
    assert run(folder) == 0
    path = min((folder / "run").glob(pattern))
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 1
    content[0] ^= 128
    path.write_bytes(content)
    capsys.readouterr()
    assert main(["study", "report", str(folder / "run")]) == 2
    err = capsys.readouterr().err
    assert err.startswith(f"steadyload: {folder / 'run'}")
    assert err.count("\n") == 1
    assert run(folder) == 0
    assert main(["study", "report", str(folder / "run")]) == 0
    pd.testing.assert_frame_equal(table(folder), table(whole))


def test_a_lock_that_is_a_link_is_not_followed(folder, capsys):
    mine = folder / "mine"
    mine.write_text("mine")
    (folder / "run").mkdir()
    (folder / "run" / ".lock").symlink_to(mine)
    assert run(folder) == 2
    assert "is a link, which no lock may be; remove it" in capsys.readouterr().err
    assert mine.read_text() == "mine"
    assert Path(folder / "run" / ".lock").is_symlink()


def test_a_manifest_with_another_value_is_damaged(folder, capsys):
    """A bit may change a number to another one, and the file is JSON as before."""
    assert run(folder) == 0
    path = folder / "run" / "manifest.json"
    path.write_text(path.read_text().replace('"generated": 6', '"generated": 7'))
    assert main(["study", "report", str(folder / "run")]) == 2
    assert "manifest.json: cannot be read, it is damaged" in capsys.readouterr().err
    assert run(folder) == 0
    assert main(["study", "report", str(folder / "run")]) == 0

"""What a run's folder holds: files of others stay, links are left, a full disk loses nothing."""

import json
import os
import resource
import shutil
import subprocess
import sys

import pandas as pd
import pytest
from verdict_tables import verdicts

from steadyload.atomic import LinkError, clear_unfinished, write_atomically
from steadyload.cli import main
from steadyload.runs.store import JSON, Store
from steadyload.tuning.ledger import Ledger

STUDY = 'generated = 4\nmethods = ["fbs"]\nshard_size = 2\n'


def run(folder):
    words = ["study", "run", str(folder / "study.toml"), "-o", str(folder / "run")]
    return main([*words, "--executor", "serial"])


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "study.toml").write_text(STUDY)
    return tmp_path


@pytest.mark.parametrize("name", ["manifest.json", ".layouts.parquet"])
def test_the_swap_file_of_an_editor_stays(folder, name):
    assert run(folder) == 0
    swap = folder / "run" / f".{name}.swp"
    swap.write_text("mine")
    cut = folder / "run" / f".{name}.abcd_123.unfinished"
    cut.write_text("{")
    assert run(folder) == 0
    assert main(["study", "report", str(folder / "run")]) == 0
    assert swap.read_text() == "mine"
    assert not cut.exists()


@pytest.mark.parametrize("name", ["manifest.json", "layouts.parquet", ".layouts.parquet"])
def test_a_file_that_is_a_link_gives_way_and_what_it_points_to_stays(folder, name):
    assert run(folder) == 0
    place = folder / "run" / name
    theirs = folder / "theirs"
    theirs.write_bytes(place.read_bytes() if place.exists() else b"theirs")
    before = theirs.read_bytes()
    place.unlink(missing_ok=True)
    place.symlink_to(theirs)
    (folder / "study.toml").write_text(STUDY.replace("4", "6"))
    assert run(folder) == 0
    assert theirs.read_bytes() == before
    assert not place.is_symlink()


def test_a_folder_of_shards_that_is_a_link_is_refused(folder, capsys):
    assert run(folder) == 0
    theirs = folder / "theirs"
    (folder / "run" / "results").rename(theirs)
    (folder / "run" / "results").symlink_to(theirs)
    before = {path: path.read_bytes() for path in theirs.iterdir()}
    (folder / "study.toml").write_text(STUDY.replace("4", "6"))
    capsys.readouterr()
    assert run(folder) == 2
    assert (
        "results: is a link, which nothing that is written here may be" in capsys.readouterr().err
    )
    assert {path: path.read_bytes() for path in theirs.iterdir()} == before


def test_a_run_folder_that_is_itself_a_link_is_where_a_user_wants_it(folder):
    (folder / "disk").mkdir()
    (folder / "run").symlink_to(folder / "disk")
    assert run(folder) == 0
    assert main(["study", "report", str(folder / "run")]) == 0
    assert (folder / "disk" / "report.md").exists()


def test_a_store_writes_and_removes_nothing_through_a_link(tmp_path):
    store = Store(tmp_path / "theirs", JSON)
    store.write("some", [1])
    (tmp_path / "mine").symlink_to(tmp_path / "theirs")
    through = Store(tmp_path / "mine", JSON)
    for use in (lambda: through.write("more", [2]), lambda: through.drop("some"),
                lambda: through.survey([])):  # fmt: skip
        with pytest.raises(LinkError):
            use()
    assert Store(tmp_path / "theirs", JSON).keys() == ["some"]


def test_a_search_goes_on_in_no_file_that_is_a_link(tmp_path):
    theirs = tmp_path / "theirs.jsonl"
    theirs.write_text("")
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "search.jsonl").symlink_to(theirs)
    with pytest.raises(LinkError):
        Ledger(tmp_path / "mine", {"seed": 3}).state("goal", 3.0)
    assert theirs.read_text() == ""


def test_only_what_the_program_names_is_cleared(tmp_path):
    names = [".x.json.swp", ".x.json.abcd1234", ".x.json.abcd.unfinished", ".x.json.unfinished"]
    for name in names:
        (tmp_path / name).write_text("mine")
    (tmp_path / ".x.json.k_3.tt9z.unfinished").write_text("mine")
    (tmp_path / ".x.json.k_3tt9zq.unfinished").write_text("cut off")
    clear_unfinished(tmp_path, "x.json")
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(
        [*names, ".x.json.k_3.tt9z.unfinished"]
    )


def test_what_is_cut_off_is_known_by_its_name(tmp_path):
    def parts():
        yield json.dumps("begun")
        [cut] = tmp_path.iterdir()
        cut.rename(tmp_path / "kept")
        raise KeyboardInterrupt(cut.name)

    with pytest.raises(KeyboardInterrupt) as cut:
        write_atomically(tmp_path / "x.json", parts())
    (tmp_path / "kept").rename(tmp_path / str(cut.value))
    clear_unfinished(tmp_path, "x.json")
    assert not list(tmp_path.iterdir())


def test_a_file_that_a_user_names_is_followed_to_where_it_points(tmp_path):
    (tmp_path / "real.json").write_text("old")
    (tmp_path / "link.json").symlink_to(tmp_path / "real.json")
    write_atomically(tmp_path / "link.json", "new", follow=True)
    assert (tmp_path / "real.json").read_text() == "new"
    assert (tmp_path / "link.json").is_symlink()


# --- where nothing can be written -----------------------------------------------------------------


def full_disk(folder, most):
    """The command where no file may have more bytes than ``most``."""
    return subprocess.run(
        [sys.executable, "-m", "steadyload.cli", "study", "run", "study.toml", "-o", "run"],
        cwd=folder, capture_output=True, text=True,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (most, most)),
        env=os.environ | {"PYTHONDONTWRITEBYTECODE": "1"},
    )  # fmt: skip


@pytest.mark.parametrize(("most", "stopped"), [(100, ".layouts.parquet"), (5_000, ".parquet")])
def test_a_full_disk_loses_nothing(folder, most, stopped):
    (folder / "study.toml").write_text(STUDY.replace("4", "1"))
    ended = full_disk(folder, most)
    assert ended.returncode == 2
    assert ended.stderr.startswith("steadyload: ")
    assert ended.stderr.count("\n") == 1
    assert ended.stderr.endswith(f"{stopped}: File too large\n")
    left = [p for p in folder.rglob("*") if p.is_file() and p.name != "study.toml"]
    assert not [p for p in left if p.name != ".lock" and p.stat().st_size >= most]
    assert run(folder) == 0
    again = shutil.copytree(folder, folder / "again", ignore=shutil.ignore_patterns("run"))
    assert run(again) == 0
    pd.testing.assert_frame_equal(verdicts(folder / "run"), verdicts(again / "run"))


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

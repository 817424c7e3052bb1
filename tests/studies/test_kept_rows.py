"""Rows behind pages are packed and unpacked whole, and a page made of them judges nothing."""

import io
import json
import os
import re
import shutil
import subprocess
import sys
import tarfile
from dataclasses import replace
from importlib.metadata import version
from lzma import FILTER_LZMA2 as LZMA2
from lzma import compress
from pathlib import Path

import pytest

from steadyload.atomic import checksum, manifest_text
from steadyload.cli import main
from steadyload.engines.registry import engines_here, package_versions
from steadyload.runs.provenance import MadeWith, provenance_lines
from steadyload.runs.results import load_results
from steadyload.runs.store import DamagedError
from steadyload.studies import kept_rows, published
from steadyload.studies.kept_rows import RowsError, keep, kept, made_with, unpack

ROOT = Path(__file__).parents[2]


def contents(folder):
    return {p.relative_to(folder): p.read_bytes() for p in folder.rglob("*") if p.is_file()}


@pytest.fixture
def entry(tmp_path):
    (page,) = published.named(("evaluation",))
    found = replace(page, work=tmp_path / "runs" / "evaluation", verdicts=False)
    for name, text in {"a/rows.parquet": "1", "manifest.json": "2", "b/c/d": "3"}.items():
        (found.work / name).parent.mkdir(parents=True, exist_ok=True)
        (found.work / name).write_text(text)
    return found


def test_rows_come_back_as_they_were_without_page_and_lock(entry, tmp_path):
    before = contents(entry.work)
    for name in (
        ".lock", "report.md", "report.html", "report-details.0a.md", "figures/x.svg",
        "checkpoints/x", "t/checkpoint.pt",
    ):  # fmt: skip
        (entry.work / name).parent.mkdir(exist_ok=True)
        (entry.work / name).write_text("page")
    archive = keep(entry, tmp_path / "rows")
    first = archive.read_bytes()
    assert keep(entry, tmp_path / "rows").read_bytes() == first
    assert unpack(entry, tmp_path / "rows") is None, "what is there stays"
    entry.work.rename(tmp_path / "gone")
    assert unpack(entry, tmp_path / "rows") == entry.work
    assert contents(entry.work) == before


def test_what_is_not_there_is_said(entry, tmp_path):
    lost = replace(entry, work=tmp_path / "nowhere")
    with pytest.raises(RowsError, match=r"steadyload pages remake evaluation makes them"):
        keep(lost, tmp_path / "rows")
    assert unpack(lost, tmp_path / "rows") is None
    assert not (tmp_path / "rows").exists()


def run_folder(folder, names, listed):
    """A folder of a run that lists some shards, each of a byte."""
    (folder / "results").mkdir(parents=True)
    for name in names:
        (folder / "results" / f"{name}.{checksum(b'1')}.parquet").write_bytes(b"1")
    about = {
        "schema_version": 2, "study": {"name": "x", "methods": ["sme", "ps3@physx"]},
        "study_hash": "", "data_hash": "", "shards": listed, "finished": None,
    }  # fmt: skip
    (folder / "manifest.json").write_text(manifest_text(about))


def test_shards_that_no_manifest_lists_are_not_packed(entry, tmp_path):
    run_folder(entry.work / "spatial", ["a", "b", "c"], ["a", "c", "d"])
    (entry.work / "weights").mkdir()
    (entry.work / "weights" / "manifest.json").write_text("{}")
    keep(entry, tmp_path / "rows")
    entry.work.rename(tmp_path / "gone")
    unpack(entry, tmp_path / "rows")
    there = contents(entry.work)
    assert {p.name[0] for p in there if p.parts[:2] == ("spatial", "results")} == {"a", "c"}
    assert set(contents(tmp_path / "gone")) - set(there) == {
        Path("spatial", "results", f"b.{checksum(b'1')}.parquet")
    }
    manifest = entry.work / "spatial" / "manifest.json"
    manifest.write_text(manifest.read_text().replace('"d"', '"b"'))
    with pytest.raises(DamagedError, match=r"manifest\.json"):
        keep(entry, tmp_path / "rows")


def packed(*members, filters=None):
    """An archive of some members and their contents."""
    found = io.BytesIO()
    with tarfile.open(fileobj=found, mode="w", format=tarfile.PAX_FORMAT) as archive:
        for about, content in members:
            about.size = len(content)
            archive.addfile(about, io.BytesIO(content))
    return compress(found.getvalue(), filters=filters)


def member(name, kind=tarfile.REGTYPE, target=""):
    about = tarfile.TarInfo(name)
    about.type, about.linkname = kind, target
    return about


WHOLE = packed((member("a"), bytes(range(256)) * 40), (member("b"), b"2"))

HARMED = {
    "cut off": (WHOLE[:-100], "is damaged or cut off"),
    "without its last bytes": (WHOLE[:-4], "is damaged or cut off"),
    "begins alone": (WHOLE[:40], "is damaged or cut off"),
    "no archive": (b"rows", "is damaged or cut off"),
    "empty": (b"", "is damaged or cut off"),
    "a changed bit": (WHOLE[:60] + bytes([WHOLE[60] ^ 1]) + WHOLE[61:], "is damaged or cut off"),
    "no tar in it": (compress(b"x" * 4096), "is damaged or cut off"),
    "needs much memory": (
        packed((member("a"), b"1"), filters=[{"id": LZMA2, "preset": 0, "dict_size": 2**30}]),
        "is damaged or cut off",
    ),
    "an absolute path": (packed((member("/tmp/x"), b"1")), "holds '/tmp/x'; allowed: files below"),
    "a path above": (packed((member("a"), b"1"), (member("b/../../x"), b"1")), r"'b/\.\./\.\./x'"),
    "a link": (packed((member("a", tarfile.SYMTYPE, "/etc/passwd"), b"")), "holds 'a'; allowed"),
    "a hard link": (packed((member("a", tarfile.LNKTYPE, "b"), b"")), "holds 'a'; allowed: files"),
    "a device": (packed((member("a", tarfile.CHRTYPE), b"")), "holds 'a'; allowed: files below"),
    "too large": (compress(bytes(4096) * 64 + b"x"), "is too large; allowed: 131072 bytes"),
}  # fmt: skip


@pytest.mark.parametrize("harm", HARMED)
def test_a_damaged_or_harmful_archive_is_named_and_leaves_no_folder(
    harm, entry, tmp_path, monkeypatch
):
    monkeypatch.setattr(kept_rows, "MAX_FILE_BYTES", 2**17)
    content, message = HARMED[harm]
    archive = tmp_path / "rows" / "evaluation.tar.xz"
    archive.parent.mkdir()
    archive.write_bytes(content)
    entry.work.rename(tmp_path / "gone")
    with pytest.raises(RowsError, match=message) as told:
        unpack(entry, tmp_path / "rows")
    assert str(archive) in str(told.value)
    assert list(entry.work.parent.iterdir()) == []
    archive.write_bytes(WHOLE)
    assert unpack(entry, tmp_path / "rows") == entry.work
    assert {path.name for path in entry.work.iterdir()} == {"a", "b"}


def test_more_files_than_allowed_and_no_file_are_refused(entry, tmp_path, monkeypatch):
    (tmp_path / "rows").mkdir()
    archive = tmp_path / "rows" / "evaluation.tar.xz"
    archive.write_bytes(WHOLE)
    entry.work.rename(tmp_path / "gone")
    with monkeypatch.context() as few:
        few.setattr(kept_rows, "_MOST_FILES", 1)
        with pytest.raises(RowsError, match="holds too much; allowed: 1 files"):
            unpack(entry, tmp_path / "rows")
    archive.unlink()
    os.mkfifo(archive)
    with pytest.raises(RowsError, match="is no file"):
        unpack(entry, tmp_path / "rows")


def test_kept_archives_hold_no_superseded_shards():
    """As the manifests in them list; they are what :func:`keep` packs of them."""
    for path in sorted((ROOT / published.ROWS).glob("*.tar.xz")):
        with tarfile.open(path, "r:xz") as archive:
            names = archive.getnames()
            shards = [Path(n) for n in names if n.endswith(".parquet") and "results/" in n]
            manifests = {str(shard.parents[1] / "manifest.json") for shard in shards}
            for name in manifests & {*names}:
                listed = json.load(archive.extractfile(name))["shards"]
                own = [s.name[:20] for s in shards if s.parents[1] == Path(name).parent]
                assert sorted(own) == sorted(listed), f"{path.name}: {name}"


def test_every_page_has_a_folder_of_its_rows():
    work = {entry.name: str(entry.work) for entry in published.entries()}
    assert work["evaluation_real"] == "runs/evaluation_real"
    assert work["properties"] == "runs/properties"
    assert work["evaluation"] == work["evaluation_stands"] == "runs/evaluation"


def test_what_is_kept_is_listed_with_its_size():
    folder = ROOT / published.ROWS
    assert (folder / published.INDEX).read_text() == kept(folder)
    files = {path.name for path in folder.iterdir()} - {published.INDEX, kept_rows.MADE_WITH}
    stated = json.loads((folder / kept_rows.MADE_WITH).read_text())
    assert files == {
        kept_rows.archive_of(entry, folder).name
        for entry in published.entries()
        if entry.work.name in stated
    }
    assert {Path(name).suffix for name in files} == {".xz", ".parquet"}


def test_a_page_of_unpacked_rows_is_the_same_and_judges_nothing(
    tmp_path, monkeypatch, in_this_process, undrawn, capsys
):
    monkeypatch.chdir(tmp_path)
    one = published.named(("evaluation",))[0]
    few = replace(one, command=("study", "evaluation", "--limit", "2", "-m", "fbs", "-m", "sme"))
    monkeypatch.setattr("steadyload.cli.pages.named", lambda names: [few])
    monkeypatch.setattr(kept_rows, "entries", lambda: [few])
    assert main(["pages", "remake", "evaluation", "--keep", "-o", "pages", "--rows", "rows"]) == 0
    page = Path("pages/evaluation/report.md").read_text()
    times = contents(few.work / "spatial" / "times")
    packed = Path("rows/evaluation.parquet").read_bytes()
    assert main(["pages", "keep", "evaluation", "--rows", "rows"]) == 0
    assert Path("rows/evaluation.parquet").read_bytes() == packed
    assert "| `evaluation.parquet` |" in Path("rows/README.md").read_text()
    few.work.rename("gone")
    assert main(["pages", "remake", "evaluation", "--rows", "rows", "-o", "again"]) == 0
    assert Path("again/evaluation/report.md").read_text() == page
    assert contents(few.work / "spatial" / "times") == times
    assert len(load_results(few.work / "spatial")) == 12
    less = replace(few, command=few.command[:-2])
    monkeypatch.setattr("steadyload.cli.pages.named", lambda names: [less])
    capsys.readouterr()
    assert main(["pages", "remake", "evaluation", "--rows", "rows", "-o", "again"]) == 2
    told = capsys.readouterr().err
    assert (
        "times: 1 of 1 results are not kept for these methods, this code and these packages "
        "(timing 1 methods on 6 layouts, turn 0); steadyload pages remake" in told
    )
    assert told.endswith("pages remake evaluation --judge judges and times them here\n")
    assert Path("again/evaluation/report.md").read_text() == page
    assert contents(few.work / "spatial" / "times") == times
    more = replace(few, command=(*few.command, "-m", "pbs0.9"))
    monkeypatch.setattr("steadyload.cli.pages.named", lambda names: [more])
    assert main(["pages", "remake", "evaluation", "--rows", "rows", "-o", "again"]) == 2
    told = capsys.readouterr().err
    assert "spatial: 6 of 18 results are not kept for these methods, this code and" in told
    assert "these packages (pbs0.9); steadyload pages remake" in told


GONE = """
import importlib.metadata
import sys

GONE = {"sapien", "rapier3d", "pybullet", "drake"}


class Gone:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in GONE:
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)


def without(found=importlib.metadata.Distribution.discover, **asked):
    return iter(()) if asked.get("name") in GONE else found(**asked)


importlib.metadata.Distribution.discover = without
sys.meta_path.insert(0, Gone())
"""
"""A ``sitecustomize`` that hides packages of engines."""

TOY = """
from steadyload.engines.world import Capabilities, FixedStepWorld, declare


class ToyWorld(FixedStepWorld):
    capabilities = Capabilities(title="Toy", dimensions=3, settings=declare())
"""


def test_a_page_of_kept_rows_is_the_same_without_packages_of_engines_and_with_further_engines(
    tmp_path, monkeypatch, capsys
):
    """All that is kept of a page, remade here and where packages are missing and a plugin is."""
    monkeypatch.chdir(tmp_path)
    remake = ["pages", "remake", "properties", "--rows", str(ROOT / published.ROWS), "-o"]
    assert main([*remake, "here"]) == 0
    elsewhere = tmp_path / "elsewhere"
    (elsewhere / "toy_engine-1.dist-info").mkdir(parents=True)
    (elsewhere / "sitecustomize.py").write_text(GONE)
    (elsewhere / "toy_engine.py").write_text(TOY)
    about = {
        "METADATA": "Metadata-Version: 2.1\nName: toy-engine\nVersion: 1\n",
        "entry_points.txt": "[steadyload.engines]\ntoy = toy_engine:ToyWorld\n",
    }
    for name, text in about.items():
        (elsewhere / "toy_engine-1.dist-info" / name).write_text(text)
    paths = [str(elsewhere), os.environ.get("PYTHONPATH", "")]
    env = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, paths))}

    def run(*words):
        told = subprocess.run(
            [sys.executable, *words], capture_output=True, text=True, check=False, env=env
        )
        return told.returncode, told.stdout, told.stderr

    asked = "from steadyload.engines.registry import engines_here as here; print(*here())"
    others = {*run("-c", asked)[1].split()}
    assert "toy" in others
    assert not others & {"physx", "rapier"}
    shutil.rmtree("runs")
    status, _, told = run("-m", "steadyload.cli", *remake, "there")
    assert (status, told.splitlines()[0]) == (
        0,
        "page 'properties' has no kept rows of toy; steadyload pages remake properties --judge "
        "judges and times them here",
    )
    assert not re.search("physx|sapien|rapier", told)
    assert contents(Path("there", "properties")) == contents(Path("here", "properties"))
    status, _, told = run("-m", "steadyload.cli", *remake, "there", "--judge")
    assert (status, told) == (
        2,
        f"uses the rows in runs/properties; {ROOT / published.ROWS / 'properties.tar.xz'} is "
        "not unpacked over them\n"
        "steadyload: page 'properties' has kept rows of physx, rapier, not installed here; "
        "without --judge it is made of what is kept\n",
    )


MADE = {
    "engines": ["mujoco", "gone"], "versions": {"mujoco": "1.2"}, "machine": "another",
    "git": "0123456789ab",
}  # fmt: skip


def test_with_what_rows_were_made_is_packed_beside_them_and_comes_back(entry, tmp_path):
    folder = tmp_path / "rows"
    keep(entry, folder)
    assert not (folder / kept_rows.MADE_WITH).exists(), "nothing states it"
    (entry.work / kept_rows.MADE_WITH).write_text(json.dumps(MADE))
    other = replace(entry, work=tmp_path / "runs" / "other")
    shutil.copytree(entry.work, other.work)
    archives = [keep(each, folder).read_bytes() for each in (other, entry)]
    assert archives[0] == archives[1]
    assert json.loads((folder / kept_rows.MADE_WITH).read_text()) == dict.fromkeys(
        ("evaluation", "other"), MADE
    )
    entry.work.rename(tmp_path / "gone")
    unpack(entry, folder)
    assert made_with(entry.work) == MadeWith(**{**MADE, "engines": ("mujoco", "gone")})


def test_a_page_of_kept_rows_names_the_code_and_machine_of_these(
    entry, tmp_path, monkeypatch, capsys
):
    (entry.work / kept_rows.MADE_WITH).write_text(json.dumps(MADE))
    told = {}

    def made(words):
        told.update(provenance_lines(), engines=engines_here())
        told["absent"] = package_versions(["mujoco", "no-such-package"])
        return 0

    monkeypatch.setattr("steadyload.cli.pages.named", lambda names: [entry])
    monkeypatch.setattr("steadyload.cli.pages.run", made)
    monkeypatch.setattr("steadyload.cli.pages.write_index", lambda folder: folder)
    remake = ["pages", "remake", "evaluation", "-o", str(tmp_path)]
    assert main(remake) == 0
    assert (told["source"], told["versions"], told["machine"]) == (
        "git 0123456789ab", "mujoco 1.2", "another",
    )  # fmt: skip
    assert told["engines"] == ("mujoco",)
    assert told["absent"] == {"mujoco": version("mujoco")}, "what is installed counts"
    said = capsys.readouterr().err
    assert "page 'evaluation' is made without its rows of gone, an unknown engine\n" in said
    assert provenance_lines()["machine"] != "another"
    (entry.work / kept_rows.MADE_WITH).write_text('{"engines": 1}')
    assert main(remake) == 2
    assert "made_with.json: engines is 1; allowed: a list" in capsys.readouterr().err
    (entry.work / kept_rows.MADE_WITH).write_text("{")
    assert main(remake) == 2
    assert "made_with.json: cannot be read, it is damaged" in capsys.readouterr().err


def test_a_run_states_with_what_its_rows_were_made_and_one_that_makes_none_leaves_that(
    tmp_path, monkeypatch, in_this_process, undrawn
):
    monkeypatch.chdir(tmp_path)
    study = ["study", "evaluation", "--limit", "2", "-m", "fbs"]
    assert main(study) == 0
    work = Path("runs", "evaluation")
    assert made_with(work) == MadeWith.here()
    (work / kept_rows.MADE_WITH).write_text(json.dumps(MADE))
    assert main(study) == 0
    assert made_with(work).machine == "another"
    assert main([*study, "-m", "sme"]) == 0
    assert made_with(work) == MadeWith.here()


def test_a_page_whose_archive_is_damaged_stops_no_other(entry, tmp_path, monkeypatch, capsys):
    archive = tmp_path / "rows" / "evaluation.tar.xz"
    archive.parent.mkdir()
    archive.write_bytes(WHOLE[:100])
    entry.work.rename(tmp_path / "gone")
    other = replace(entry, name="other", work=tmp_path / "runs" / "other")
    begun = []
    monkeypatch.setattr("steadyload.cli.pages.named", lambda names: [entry, other])
    monkeypatch.setattr("steadyload.cli.pages.run", lambda words: begun.append(words[-1]) or 0)
    monkeypatch.setattr("steadyload.cli.pages.write_index", lambda folder: folder)
    assert main(["pages", "remake", "--rows", str(archive.parent), "-o", "pages"]) == 2
    assert capsys.readouterr().err.startswith(
        f"steadyload: {archive}: cannot be read, it is damaged or cut off; restore the file\n"
    )
    assert begun == [str(Path("pages", "other"))]


def test_an_index_is_written_only_where_a_page_was_made(entry, tmp_path, monkeypatch, capsys):
    archive = tmp_path / "rows" / "evaluation.tar.xz"
    archive.parent.mkdir()
    archive.write_bytes(WHOLE[:100])
    entry.work.rename(tmp_path / "gone")
    monkeypatch.setattr("steadyload.cli.pages.named", lambda names: [entry])
    monkeypatch.setattr("steadyload.cli.pages.run", lambda words: 0)
    pages = tmp_path / "pages"
    remake = ["pages", "remake", "--rows", str(archive.parent), "-o", str(pages)]
    assert main(remake) == 2
    assert not pages.exists()
    archive.write_bytes(WHOLE)
    assert main(remake) == 0
    assert (pages / "README.md").is_file()
    assert "not unpacked" not in capsys.readouterr().err


def test_packed_rows_that_are_not_read_are_told_once(entry, tmp_path, monkeypatch, capsys):
    archive = tmp_path / "rows" / "evaluation.tar.xz"
    archive.parent.mkdir()
    archive.write_bytes(WHOLE)
    other = replace(entry, name="other")
    monkeypatch.setattr("steadyload.cli.pages.named", lambda names: [entry, other])
    monkeypatch.setattr("steadyload.cli.pages.run", lambda words: 0)
    assert main(["pages", "remake", "--rows", str(archive.parent), "-o", str(tmp_path)]) == 0
    told = capsys.readouterr().err
    line = f"uses the rows in {entry.work}; {archive} is not unpacked over them\n"
    assert told.count("not unpacked") == told.count(line) == 1

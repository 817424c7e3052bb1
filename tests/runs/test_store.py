"""The store: what is missing is computed, what is damaged is noticed, one run at a time."""

import json
import random
import shutil
from concurrent.futures import Future
from dataclasses import dataclass, replace
from pathlib import Path

import pandas as pd
import pyarrow as pa
import pytest
from verdict_tables import verdicts

from steadyload.cli import main
from steadyload.runs.pool import Serial
from steadyload.runs.provenance import key_of
from steadyload.runs.results import ResultsError, load_manifest
from steadyload.runs.store import JSON, DamagedError, Store, locked, parquet

REPRO = Path(__file__).resolve().parents[3] / "shared" / "repro"
"""Shards that were damaged by hand, where there are some: each broke an earlier check."""

STUDY = 'name = "few"\ngenerated = 4\nseed = 1\nshard_size = 4\nmethods = ["fbs", "sme"]\n'


@dataclass(frozen=True)
class Squares:
    """A unit: numbers to square."""

    numbers: tuple[int, ...]

    @property
    def key(self):
        return key_of(list(self.numbers))

    def __len__(self):
        return len(self.numbers)

    def without(self, done):
        return replace(self, numbers=self.numbers[done:])

    def describe(self, part):
        return f"the square of {self.numbers[part]}"


def square(unit):
    for number in unit.numbers:
        yield number**2


class Fragile(Serial):
    """Works here, as if negative numbers ended its process."""

    def submit(self, task):
        unit = task.unit
        if all(number >= 0 for number in unit.numbers):
            return super().submit(task)
        future = Future()
        future.set_result([task.crashed(unit, part, "by SIGABRT") for part in range(len(unit))])
        return future


UNITS = [Squares((1, 2)), Squares((3,)), Squares((4, 5, 6))]


@pytest.fixture
def store(tmp_path):
    return Store(tmp_path / "shards", JSON)


def flipped(content, random):
    """Bytes with one bit turned over."""
    changed, at = bytearray(content), random.randrange(8 * len(content))
    changed[at // 8] ^= 1 << at % 8
    return bytes(changed)


def test_what_is_missing_is_computed_once(store, tmp_path):
    seen = []
    assert store.complete(UNITS, square, progress=lambda *at: seen.append(at)) == 6
    assert seen == [(0, 6), (2, 6), (3, 6), (6, 6)]
    assert [store.read(unit.key) for unit in UNITS] == [[1, 4], [9], [16, 25, 36]]
    again = Store(tmp_path / "shards", JSON)
    assert again.complete(UNITS, square) == 0
    again.drop(UNITS[1].key)
    assert again.complete([*UNITS, *UNITS], square) == 1
    assert len(list((tmp_path / "shards").iterdir())) == 3


def test_what_was_half_written_is_removed(store, tmp_path):
    store.complete(UNITS, square)
    cut, mine = (
        tmp_path / "shards" / f".{key_of([1])}.json.abcd1234.unfinished",
        tmp_path / "shards" / ".mine",
    )
    for file in (cut, mine):
        file.write_text("[")
    assert store.complete(UNITS, square) == 0
    assert not cut.exists()
    assert mine.exists()


def test_a_name_without_a_checksum_is_no_shard(store, tmp_path):
    store.complete(UNITS, square)
    for file in (tmp_path / "shards").iterdir():
        file.rename(file.with_name(file.name.split(".")[0] + ".json"))
    assert Store(tmp_path / "shards", JSON).complete(UNITS, square) == 6


def test_an_end_of_the_process_is_an_error_a_note_or_an_answer(tmp_path):
    units = [Squares((7,)), Squares((-1,))]
    with pytest.raises(ResultsError, match=r"the square of -1: .*SIGABRT"):
        Store(tmp_path / "a", JSON).complete(units, square, workers=Fragile())
    store, told = Store(tmp_path / "b", JSON), []
    assert store.complete(units, square, workers=Fragile(), lost=lambda *of: told.append(of)) == 1
    [(unit, why)] = told
    assert unit.numbers == (-1,)
    assert "SIGABRT" in why
    assert unit.key not in store
    assert store.complete(units, square, workers=Fragile(), crashed=lambda *_: None) == 1
    assert store.read(unit.key) == [None]


@pytest.mark.parametrize("codec", ["json", "parquet"])
def test_a_bit_anywhere_is_noticed(codec, tmp_path, caplog):
    schema = pa.schema([pa.field("x", pa.int32()), pa.field("name", pa.string())])
    rows = [{"x": k, "name": f"row {k % 7}"} for k in range(200)]
    store = Store(tmp_path, JSON if codec == "json" else parquet(schema))
    store.write("some", rows)
    (file,) = tmp_path.iterdir()
    whole, drawn = file.read_bytes(), random.Random(7)
    damaged = [flipped(whole, drawn) for _ in range(40)]
    damaged += [whole[: drawn.randrange(len(whole))] for _ in range(10)] + [whole + b"\0", b""]
    for content in damaged:
        file.write_bytes(content)
        with pytest.raises(DamagedError, match=r"some\..*: cannot be read, it is damaged"):
            store.read("some")
        caplog.clear()
        assert store.missing(["some"]) == {"some"}
        assert [record.getMessage() for record in caplog.records] == [
            f"{file}: is damaged; it is thrown away and made again"
        ]
        assert not file.exists()
        store.write("some", rows)
        assert file.read_bytes() == whole
    assert store.missing(["some"]) == set()


def test_a_lock_follows_no_link(tmp_path):
    precious = tmp_path / "precious.txt"
    precious.write_text("x")
    (tmp_path / "run").mkdir()
    (tmp_path / "run" / ".lock").symlink_to(precious)
    told = r"\.lock: is a link, which no lock may be; remove it"
    with pytest.raises(ResultsError, match=told), locked(tmp_path / "run"):
        pass
    assert precious.read_text() == "x"
    with pytest.raises(ResultsError, match=r"precious\.txt: is not a folder"), locked(precious):
        pass


# --- a study's folder ---------------------------------------------------------------------------


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    """The folder of a finished study, and its table."""
    folder = tmp_path_factory.mktemp("done")
    (folder / "study.toml").write_text(STUDY)
    assert run(folder) == 0
    return folder


def run(folder):
    words = ["study", "run", str(folder / "study.toml"), "-o", str(folder / "run")]
    return main([*words, "--executor", "serial"])


def sentences(text):
    """Those about files."""
    return [line for line in text.splitlines() if "damaged" in line]


def check_mended(folder, file, reference, capfd):
    """A report names the file and fails; another run names it and mends it."""
    assert main(["study", "report", str(folder / "run")]) == 2
    [sentence] = capfd.readouterr().err.splitlines()
    assert sentence.startswith(f"steadyload: {folder / 'run'}")
    assert file.name in sentence
    assert run(folder) == 0
    assert len([line for line in sentences(capfd.readouterr().err) if file.name in line]) == 1
    pd.testing.assert_frame_equal(verdicts(folder / "run"), reference)
    assert main(["study", "report", str(folder / "run")]) == 0
    assert run(folder) == 0
    assert not sentences(capfd.readouterr().err)


@pytest.mark.parametrize("what", ["cut", "bit", "other rows"])
def test_a_damaged_shard_is_named_and_computed_again(done, tmp_path, what, capfd):
    folder = Path(shutil.copytree(done, tmp_path / "mine"))
    file, other = sorted((folder / "run" / "results").glob("*.parquet"))
    content = file.read_bytes()
    file.write_bytes(
        {"cut": content[:-1], "bit": flipped(content, random.Random(1))}.get(
            what, other.read_bytes()
        )
    )
    check_mended(folder, file, verdicts(done / "run"), capfd)


@pytest.mark.parametrize("name", ["shard_one_bit", "silent", "whole_but_bad", "is_whole_crash"])
def test_shards_that_broke_earlier_checks_are_computed_again(done, tmp_path, name, capfd):
    found = REPRO / f"{name}.parquet"
    if not found.exists():
        pytest.skip("the inputs are not beside the project (../shared/repro)")
    folder = Path(shutil.copytree(done, tmp_path / "mine"))
    file = next((folder / "run" / "results").glob("*.parquet"))
    file.write_bytes(found.read_bytes())
    check_mended(folder, file, verdicts(done / "run"), capfd)


def test_a_bit_of_the_layouts_is_noticed(done, tmp_path, capfd):
    folder = Path(shutil.copytree(done, tmp_path / "mine"))
    file, drawn = folder / "run" / "layouts.parquet", random.Random(3)
    whole = file.read_bytes()
    for _ in range(40):
        file.write_bytes(flipped(whole, drawn))
        assert main(["study", "report", str(folder / "run")]) == 2
        assert "layouts.parquet: cannot be read, it is damaged" in capfd.readouterr().err
    check_mended(folder, file, verdicts(done / "run"), capfd)
    assert file.read_bytes() == whole


def test_a_changed_manifest_is_named_and_written_again(done, tmp_path, capfd):
    folder = Path(shutil.copytree(done, tmp_path / "mine"))
    file = folder / "run" / "manifest.json"
    changed = file.read_text().replace('"rows": 8', '"rows": 9')
    file.write_text(changed)
    with pytest.raises(DamagedError, match=r"manifest\.json: .* is damaged; run the study again"):
        load_manifest(folder / "run")
    check_mended(folder, file, verdicts(done / "run"), capfd)
    assert load_manifest(folder / "run")["rows"] == 8
    without = {k: v for k, v in json.loads(file.read_text()).items() if k != "checksum"}
    file.write_text(json.dumps(without))
    with pytest.raises(DamagedError):
        load_manifest(folder / "run")


def test_a_manifest_that_was_cut_off_is_written_again(done, tmp_path, capfd):
    folder = Path(shutil.copytree(done, tmp_path / "mine"))
    file = folder / "run" / "manifest.json"
    file.write_bytes(file.read_bytes()[:-9])
    assert run(folder) == 0
    said_of = capfd.readouterr()
    assert "manifest.json: is damaged; it is thrown away and made again" in said_of.err
    assert said_of.out.startswith("0 ")
    pd.testing.assert_frame_equal(verdicts(folder / "run"), verdicts(done / "run"))


def test_a_folder_of_an_earlier_version_is_judged_anew(done, tmp_path, capfd):
    folder = Path(shutil.copytree(done, tmp_path / "mine"))
    for file in (folder / "run" / "results").iterdir():
        file.rename(file.with_name(file.name.split(".")[0] + ".parquet"))
    manifest = load_manifest(folder / "run")
    del manifest["files"]
    (folder / "run" / "manifest.json").write_text(json.dumps(manifest | {"schema_version": 1}))
    assert main(["study", "report", str(folder / "run")]) == 2
    assert "schema version 1; allowed: 2; run the study again" in capfd.readouterr().err
    assert run(folder) == 0
    assert capfd.readouterr().out.startswith("8 ")
    pd.testing.assert_frame_equal(verdicts(folder / "run"), verdicts(done / "run"))

"""Every file that is read has a limit on its size, which is looked at before it is read."""

import json
import lzma
import os
import struct
from pathlib import Path

import numpy as np
import pytest

from steadyload.app.recommend.kept import load_fronts
from steadyload.cli.flags import read_config
from steadyload.config import ConfigError
from steadyload.errors import UserError
from steadyload.layouts.benchmark.dataset import load_benchmark
from steadyload.layouts.files.dialect import load_profile
from steadyload.layouts.formats import read_layouts, read_written
from steadyload.learners import LearnerError
from steadyload.learners.plans.plan_file import load_plan
from steadyload.learners.weights import SHIPPED, load_weights, parse_arrays
from steadyload.methods.cascade.thresholds import load_thresholds
from steadyload.reading import (
    MAX_KEY_PARTS,
    TooLargeError,
    content_of,
    json_of,
    lines_of,
    regular,
    toml_of,
    unpacked,
)
from steadyload.runs.definition import StudyDefinition, load_study
from steadyload.runs.results import load_manifest
from steadyload.runs.store import JSON, Store, checksum_of
from steadyload.runs.timing import kept_load
from steadyload.stored import stored_list, stored_object
from steadyload.transport.history import recorded
from steadyload.transport.rules import rule_named
from steadyload.tuning.cost import stored_model
from steadyload.tuning.ledger import Ledger


def bytes_of(folder, content):
    path = folder / "file.toml"
    path.write_bytes(content)
    return path


REFUSED = r"is too large \(.*\); allowed: [\d,]+ MiB$|no such file of|there are none of that name"
"""Thresholds and weights are looked for among regular files."""

READERS = {
    "rule": lambda path: rule_named(str(path)),
    "history": recorded,
    "study": load_study,
    "configuration": lambda path: read_config(path, StudyDefinition),
    "profile": load_profile,
    "plan": load_plan,
    "thresholds": lambda path: load_thresholds("mujoco", path),
    "cost model": lambda path: stored_model(path, {"engine": "mujoco", "space": "extended"}),
    "front": load_fronts,
    "stored object": lambda path: stored_object(path, "remove it"),
    "stored list": lambda path: stored_list(path, "runs", "remove it"),
    "layouts of a run": lambda path: list(read_written(path)),
    "checksum": checksum_of,
}
"""Readers of one file, by what they read."""

FOLDERS = {
    "run": ("manifest.json", load_manifest),
    "labelled set": ("manifest.json", load_benchmark),
    "weights": ("manifest.json", load_weights),
    "search": ("search.jsonl", lambda folder: Ledger(folder, {"seed": 3})),
    "kept search": ("search.jsonl.xz", lambda folder: Ledger(folder, {"seed": 3})),
    "shard": (f"some.{'0' * 16}.json", lambda folder: Store(folder, JSON).content("some")),
}
"""Readers of a folder, with the name of a file in it."""


@pytest.fixture(params=["sparse", "endless"])
def too_large(request, tmp_path):
    """Puts a sparse file of 40 GB, or a link to an endless device, under a name."""

    def put(name):
        path = tmp_path / name
        if request.param == "endless":
            path.symlink_to("/dev/zero")
        else:
            path.touch()
            os.truncate(path, 40 * 10**9)
        return path

    return put


@pytest.mark.parametrize("kind", READERS)
def test_a_file_without_end_is_refused_before_it_is_read(kind, too_large):
    with pytest.raises(UserError, match=rf"file\.toml: ({REFUSED})"):
        READERS[kind](too_large("file.toml"))


@pytest.mark.parametrize("kind", FOLDERS)
def test_a_folder_with_a_file_without_end_is_refused(kind, too_large):
    name, read = FOLDERS[kind]
    path = too_large(name)
    with pytest.raises(UserError, match=REFUSED):
        read(path.parent)


def test_a_load_of_the_machine_without_end_is_not_known(too_large):
    assert kept_load(too_large("load.json")) is None


def test_a_layout_file_without_end_is_refused(too_large):
    with pytest.raises(UserError, match=r"file: is in no known format; allowed"):
        read_layouts(too_large("file"))


def test_an_error_while_a_file_is_read_names_the_file():
    for read in (lambda path: content_of(path, 10), read_layouts):
        with pytest.raises(OSError, match="Input/output error") as failed:
            read(Path("/proc/self/mem"))
        assert failed.value.filename == "/proc/self/mem"


def test_what_has_no_more_than_is_allowed_is_read(tmp_path):
    path = bytes_of(tmp_path, b"x" * 3000)
    assert content_of(path, 3000) == b"x" * 3000
    with pytest.raises(TooLargeError, match=r"is too large \(3 KiB\); allowed: 3 KiB"):
        content_of(path, 2999)


def test_a_file_that_is_read_in_parts_is_no_pipe(tmp_path):
    """Opening one would wait for somebody to write to it."""
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(TooLargeError):
        regular(tmp_path / "pipe", 3000)


def test_a_file_of_toml_is_refused_by_the_error_of_its_reader(tmp_path):
    with pytest.raises(ConfigError, match=r"file\.toml: not valid TOML \("):
        toml_of(bytes_of(tmp_path, b"a = "), ConfigError)
    for content in (b"a = \xff", b"a = " + b"[" * 100_000):
        with pytest.raises(ConfigError, match="not valid TOML"):
            toml_of(bytes_of(tmp_path, content), ConfigError)
    assert toml_of(bytes_of(tmp_path, b"\xef\xbb\xbfa = 1\r\n"), ConfigError) == {"a": 1}


@pytest.mark.parametrize(
    "key", ["a." * MAX_KEY_PARTS + "b = 1", "[" + " a ." * MAX_KEY_PARTS + "b]"]
)
def test_a_key_whose_parts_cost_their_square_is_refused(tmp_path, key):
    with pytest.raises(ConfigError, match=f"a key of more than {MAX_KEY_PARTS} parts"):
        toml_of(bytes_of(tmp_path, key.encode()), ConfigError)
    fewer = key.replace("a.", "", 1).replace(" a .", "", 1)
    assert toml_of(bytes_of(tmp_path, fewer.encode()), ConfigError)
    many = f"a = [{'0.5, ' * 1000}]"
    assert len(toml_of(bytes_of(tmp_path, many.encode()), ConfigError)["a"]) == 1000


def test_a_stored_file_of_many_values_is_refused():
    assert json_of(b"[1, {}]") == [1, {}]
    for many in (b"[]," * 4_000_000, b"[" * 4_000_001):
        with pytest.raises(ValueError, match="more than 4,000,000 values"):
            json_of(b"[" + many + b"1]")


def test_what_unpacks_to_more_than_is_allowed_is_refused():
    packed = lzma.compress(b"x" * 100_000)
    assert unpacked(packed, 100_000) == b"x" * 100_000
    for content, most in ((packed, 99_999), (packed[:-10], 100_000), (b"no", 10)):
        with pytest.raises(ValueError, match=r"\S"):
            unpacked(content, most)


def test_a_line_without_end_is_refused(tmp_path):
    path = bytes_of(tmp_path, b"one\n" + b"x" * 100)
    with path.open() as file, pytest.raises(TooLargeError):
        list(lines_of(file, path, 99))
    with path.open() as file:
        assert [len(line) for line in lines_of(file, path, 100)] == [4, 100]


def safetensors(entries, body):
    header = json.dumps(
        {name: {"dtype": "F32", "shape": shape, "data_offsets": at} for name, shape, at in entries}
    ).encode()
    return struct.pack("<Q", len(header)) + header + body


def test_tensors_that_do_not_fill_a_file_one_after_the_other_are_refused(tmp_path):
    """The same bytes under many names would be as many arrays."""
    whole = [("a", [1], [0, 4]), ("b", [2], [4, 12])]
    body = np.arange(3, dtype=np.float32).tobytes()
    assert parse_arrays(safetensors(whole, body), tmp_path)["b"].tolist() == [1.0, 2.0]
    for entries, held in (
        ([("a", [1], [0, 4]), ("b", [3], [0, 12])], body), ([("b", [2], [4, 12])], body),
        (whole, body + b"more"), (whole, body[:-4]),
        ([("a", [1], [0, 4]), ("b", [0], [4, 2])], body),
        ([*whole, ("c", [0], ["x", None])], body), ([*whole, ("c", [0], [0])], body),
    ):  # fmt: skip
        with pytest.raises(LearnerError, match="is no safetensors file"):
            parse_arrays(safetensors(entries, held), tmp_path)


def test_weights_of_more_bytes_than_their_networks_are_refused_unread(tmp_path):
    manifest = json.loads((SHIPPED / "lstm_1" / "manifest.json").read_bytes())
    manifest.pop("checksum", None)
    place = tmp_path / "member_0.safetensors"
    place.symlink_to("/dev/zero")
    (tmp_path / "manifest.json").write_text(json.dumps(manifest))
    with pytest.raises(TooLargeError, match=r"member_0\.safetensors: is too large"):
        load_weights(tmp_path)
    manifest["members"][0]["options"] |= {"hidden": 4096, "layers": 8}
    (tmp_path / "manifest.json").write_text(json.dumps(manifest))
    with pytest.raises(LearnerError, match=r"its networks have [\d,]+ MiB; allowed: 256 MiB"):
        load_weights(tmp_path)

"""A bit flipped in a stored file of any kind: one sentence names it, or it is made anew."""

import dataclasses
import json
import logging
import re

import numpy as np
import pytest

from steadyload.app.recommend.kept import load_fronts, write_fronts
from steadyload.atomic import manifest_text
from steadyload.errors import UserError
from steadyload.learners.generation import GenerationOptions
from steadyload.learners.generation import _claim as claim_set
from steadyload.learners.search import _claim as claim_search
from steadyload.learners.weights import load_arrays, load_weights, save_weights
from steadyload.methods.cascade.thresholds import (
    Ladder,
    Stage,
    Thresholds,
    load_thresholds,
    write_thresholds,
)
from steadyload.runs.store import JSON, Store
from steadyload.runs.timing import kept_load
from steadyload.stored import store_list, stored_list
from steadyload.tuning.cost import TERMS, CostModel, stored_model
from steadyload.tuning.ledger import Entry, GenerationEnd, Ledger
from steadyload.tuning.trial import TrialResult

ABOUT = {"engine": "mujoco", "space": "extended"}
IDENTITY = {"seed": 3}
OPTIONS = GenerationOptions(lists=2, label="fbs", seed=7)


def thresholds(folder):
    ladder = Ladder((Stage("fbs", 0.1, None), Stage("lstm_1", None, 0.5)), "label", {"lost": 1})
    write_thresholds("dart", Thresholds(1.0, {1.0: ladder}, {"fbs": "x"}, {}), folder / "t.json")
    return folder / "t.json", lambda: load_thresholds("dart", folder / "t.json")


def front(folder):
    file = write_fronts(load_fronts(), folder / "fronts.json")
    return file, lambda: load_fronts(file)


def cost(folder):
    file, model = folder / "cost.json", CostModel(dict.fromkeys(TERMS, 1.5), 32, 0.9, 0.1)
    file.write_text(manifest_text({"about": ABOUT, "model": dataclasses.asdict(model)}))
    return file, lambda: stored_model(file, ABOUT)


def search(folder):
    ledger = Ledger(folder, IDENTITY)
    ledger.state("goal", 3.0)
    ledger.add(Entry((1, 2), 0, TrialResult(np.array([True, False]), np.array([0.5, 1.5]), 0.1)))
    ledger.end(GenerationEnd(0, 4, 0.25, 1.5))
    return folder / "search.jsonl", lambda: Ledger(folder, IDENTITY)


def asked_set(folder):
    claim_set(folder, OPTIONS)
    return folder / "asked.json", lambda: claim_set(folder, OPTIONS)


def asked_search(folder):
    file = folder / "search.json"
    claim_search(file, IDENTITY)
    return file, lambda: claim_search(file, IDENTITY)


def noted(folder):
    file = folder / "made_by.json"
    store_list(file, "runs", [{"git": "0" * 7}])
    return file, lambda: stored_list(file, "runs", "remove it")


def weights(folder):
    shipped = load_weights("lstm_1")
    manifest = {key: value for key, value in shipped.manifest.items() if key != "hashes"}
    manifest["members"] = manifest["members"][:1]
    save_weights(folder, [load_arrays("lstm_1")], manifest)
    return folder / "manifest.json", lambda: load_weights(folder)


def tensors(folder):
    weights(folder)
    return folder / "member_0.safetensors", lambda: load_weights(folder)


def times(folder):
    """Every repeat of a timing, and every cell of a study, is a shard."""
    Store(folder, JSON).write("some", [{"load": 0.5, "cpu": {"fbs": [0.25]}}])
    [file] = folder.iterdir()
    return file, lambda: Store(folder, JSON).read("some")


KINDS = (
    thresholds, front, cost, search, asked_set, asked_search, noted, weights, tensors, times
)  # fmt: skip


def says_the_same(one, other):
    """Whether both are JSON of the same values, as where the last digit of a number is lost."""
    try:
        return json.loads(one) == json.loads(other)
    except ValueError:
        return False


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.__name__)
def test_a_changed_bit_is_told_by_one_sentence_that_names_the_file(tmp_path, kind):
    file, read = kind(tmp_path)
    read()
    whole = file.read_bytes()
    draw = np.random.default_rng(7)
    # The search of a published page has no sums of lines; the end of a file is in no checksum.
    unchecked = [found.span() for found in re.finditer(rb'"sum"|\n\Z', whole)]
    for place in draw.integers(len(whole), size=60):
        changed = bytearray(whole)
        changed[place] ^= 1 << int(draw.integers(8))
        file.write_bytes(changed)
        if any(begin <= place < end for begin, end in unchecked) or says_the_same(changed, whole):
            continue
        with pytest.raises(UserError) as caught:
            read()
        said = str(caught.value)
        assert str(tmp_path) in said
        assert said.isprintable()
    file.write_bytes(whole)
    read()


@pytest.mark.parametrize("kind", [thresholds, front, cost, asked_set, asked_search, weights])
def test_a_file_without_its_checksum_is_damaged(tmp_path, kind):
    file, read = kind(tmp_path)
    without = {k: v for k, v in json.loads(file.read_text()).items() if k != "checksum"}
    file.write_text(json.dumps(without))
    with pytest.raises(UserError, match=re.escape(str(tmp_path))):
        read()


def test_a_damaged_line_of_a_search_says_what_can_be_kept(tmp_path):
    file, read = search(tmp_path)
    lines = file.read_text().splitlines(keepends=True)
    file.write_text("".join([*lines[:2], lines[2].replace("0.5", "0.7"), *lines[3:]]))
    with pytest.raises(UserError, match=r"remove it to start anew, or its lines from 3 on to go"):
        read()
    file.write_text("".join(lines[:2]))
    assert read().facts == {"goal": 3.0}


def test_a_load_that_is_damaged_is_not_known(tmp_path, caplog):
    file = tmp_path / "load.json"
    file.write_text(manifest_text({"load of the machine": 0.5}).replace("0.5", "0.7"))
    with caplog.at_level(logging.WARNING):
        assert kept_load(file) is None
    assert f"{file}: is damaged" in caplog.text


def test_a_set_goes_on_when_what_was_asked_is_damaged_and_removed(tmp_path):
    """Nothing of what was made is lost: shards, runs and tables stay."""
    file, read = asked_set(tmp_path)
    (tmp_path / "shards").mkdir()
    (tmp_path / "made_with.json").write_text("[]")
    (tmp_path / "manifest.json").write_text("{}")
    file.write_bytes(b"{")
    with pytest.raises(UserError, match="is damaged; remove it and run again with the options"):
        read()
    file.unlink()
    read()

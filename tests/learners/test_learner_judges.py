"""Trained judges: they say what torch says, alone and in batches, and refuse what they do not know.

The networks are tiny and trained for seconds; what they say is of no matter here.
"""

import dataclasses
import json
import shutil
import struct
import subprocess
import sys
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest
import safetensors.numpy
import torch

from steadyload.cli import main
from steadyload.layouts import Item, Layout, Pallet
from steadyload.layouts.benchmark import load_benchmark
from steadyload.layouts.formats import Format, write_layouts
from steadyload.learners import LearnerError
from steadyload.learners.features import FeatureKind, features, names
from steadyload.learners.inference import Network
from steadyload.learners.jobs import TrainingJob, train_weights
from steadyload.learners.network import NETWORKS
from steadyload.learners.options import NetworkKind, TrainingOptions
from steadyload.learners.ranges import quantities_of
from steadyload.learners.tensors import tensor_shapes
from steadyload.learners.weights import (
    SHIPPED,
    load_arrays,
    load_weights,
    parse_arrays,
    save_weights,
    weights_folder,
)
from steadyload.methods.contract.method import Status, Stopwatch
from steadyload.methods.contract.spec import SpecError
from steadyload.methods.registry import make_method, method_listing
from steadyload.runs.provenance import made_by

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def weights(tmp_path_factory):
    """Three members on some cases."""
    options = TrainingOptions(hidden=12, epochs=3, batch=16, learning_rate=1e-2)
    job = TrainingJob(options, members=3, left_out=0.2, limit=40)
    return train_weights(job, tmp_path_factory.mktemp("training"))


@pytest.fixture(scope="module")
def layouts():
    benchmark = load_benchmark()
    cases = benchmark.select("validation", limit=30)
    return [
        benchmark.layout(name, scenario)
        for name, scenario in zip(cases["layout"], cases["scenario"], strict=True)
    ]


def judge(weights, name="lstm_1", **parameters):
    values = "".join(f",{key}={value}" for key, value in parameters.items())
    return make_method(f"{name}:weights={weights}{values}")


def between(method, layouts):
    """A threshold that some layouts exceed and some do not, far from every probability.

    What a short training gives depends on the processor, and a batch rounds as no single layout.
    """
    found = [method.probabilities(lay) for lay in layouts]
    low, high = np.quantile([each.max() for each in found], [0.3, 0.7])
    values = np.sort(np.concatenate(found))
    values = values[(values >= low) & (values <= high)]
    widest = np.argmax(np.diff(values))
    return float(values[widest : widest + 2].mean())


@pytest.mark.parametrize("kind", NetworkKind)
@pytest.mark.parametrize("layers", [1, 2, 3])
def test_without_torch_a_network_says_what_it_says_with_it(kind, layers):
    torch.manual_seed(layers)
    random = np.random.default_rng(layers)
    rows = random.normal(3.0, 5.0, (7, 11, 9)).astype(np.float32)
    network = NETWORKS[kind](9, 20, layers).eval()
    network.normalise_as(rows.reshape(-1, 9))
    with torch.no_grad():
        for parameter in network.parameters():
            parameter.mul_(3.0)  # far from the even odds of fresh weights
        expected = torch.sigmoid(network(torch.from_numpy(rows))).numpy()
    assert np.ptp(expected) > 0.1
    alone = Network({name: value.numpy() for name, value in network.state_dict().items()})
    np.testing.assert_allclose(alone.probabilities_of_many(rows), expected, atol=1e-6)
    for k in range(len(rows)):
        np.testing.assert_allclose(alone.probabilities(rows[k]), expected[k], atol=1e-6)


@pytest.mark.parametrize("kind", NetworkKind)
@pytest.mark.parametrize("padding", range(4))
def test_weights_may_begin_at_any_byte_of_a_file(kind, padding):
    arrays = {name: value.numpy() for name, value in NETWORKS[kind](9, 4, 1).state_dict().items()}
    content = safetensors.numpy.save(arrays)
    (length,) = struct.unpack("<Q", content[:8])
    head = content[8 : 8 + length] + padding * b" "
    read = parse_arrays(struct.pack("<Q", len(head)) + head + content[8 + length :], Path("here"))
    rows = np.random.default_rng(padding).normal(0.0, 2.0, (5, 9)).astype(np.float32)
    expected = Network(arrays).probabilities(rows)
    np.testing.assert_array_equal(Network(read).probabilities(rows), expected)


@pytest.mark.parametrize("kind", NetworkKind)
def test_a_network_that_goes_on_says_what_it_says_of_all_steps(kind):
    torch.manual_seed(5)
    rows = np.random.default_rng(5).normal(0.0, 2.0, (11, 9)).astype(np.float32)
    network = NETWORKS[kind](9, 20, 2)
    with torch.no_grad():
        for parameter in network.parameters():
            parameter.mul_(3.0)
    alone = Network({name: value.numpy() for name, value in network.state_dict().items()})
    whole, memories = alone.probabilities(rows), [alone.start()]
    assert np.ptp(whole) > 0.1
    for step in range(len(rows)):
        found, memory = alone.go_on(rows[: step + 1], memories[-1])
        np.testing.assert_allclose(found, whole[step : step + 1], atol=1e-6)
        memories.append(memory)
    # A memory stays as it is when a network has gone on from it.
    several, _ = alone.go_on(rows, memories[4])
    np.testing.assert_allclose(several, whole[4:], atol=1e-6)


@pytest.mark.parametrize("name", ["lstm_1", "lstm_e"])
@pytest.mark.parametrize("batch", [1, 7, 256])
def test_many_at_once_are_judged_as_one_by_one(weights, layouts, name, batch):
    threshold = between(judge(weights, name), layouts)
    method = judge(weights, name, batch=batch, outside="accept", threshold=threshold)
    alone, together = [method.judge(lay) for lay in layouts], method.judge_many(layouts)
    for one, other in zip(alone, together, strict=True):
        for field in ("item_count", "status", "failing_step", "moved_item", "reason"):
            assert getattr(one, field) == getattr(other, field)
    assert len({verdict.failing_step for verdict in alone}) > 2
    assert method.judge_many([]) == []


def test_an_ensemble_is_the_mean_of_its_members(weights, layouts):
    networks = load_weights(weights).networks
    assert len(networks) == 3
    for lay in layouts[:10]:
        rows = features(lay, FeatureKind.SUPPORT)
        each = [network.probabilities(rows) for network in networks]
        found = judge(weights, "lstm_e").probabilities(lay)
        np.testing.assert_allclose(found, np.mean(each, axis=0), atol=1e-6)
        np.testing.assert_array_equal(judge(weights).probabilities(lay), each[0])
        assert np.ptp(each, axis=0).max() > 0.0


def test_the_first_step_above_the_threshold_fails(weights, layouts):
    middle = between(judge(weights), layouts)
    for lay in layouts:
        found = judge(weights).probabilities(lay)
        for threshold in (0.1, middle, 0.9):
            verdict = judge(weights, threshold=threshold, outside="accept").judge(lay)
            above = [k for k, p in enumerate(found) if p > threshold]
            assert verdict.failing_step == (above[0] if above else None)
            if above:
                assert f"probability {found[above[0]]:.2f}" in verdict.reason
            else:
                assert "probability" not in verdict.reason


def changed_folder(weights, folder, **tensors):
    """The first member, with other tensors; None takes one away."""
    arrays = {**load_arrays(weights), **tensors}
    manifest = {k: v for k, v in load_weights(weights).manifest.items() if k != "hashes"}
    kept = {name: array for name, array in arrays.items() if array is not None}
    return save_weights(folder, [kept], manifest)


def test_what_is_no_number_is_not_stable(weights, layouts, tmp_path):
    # Every value is finite, but not what becomes of features by them.
    arrays = load_arrays(weights)
    odd = {name: np.full_like(arrays[name], 3e38) for name in ("scale", "lstm.weight_ih_l0")}
    with np.errstate(over="ignore"):
        changed_folder(weights, tmp_path, mean=np.zeros_like(arrays["mean"]), **odd)
    judge = make_method(f"lstm_1:weights={tmp_path},outside=accept")
    with np.errstate(all="ignore"):
        verdicts = judge.judge(layouts[0]), *judge.judge_many(layouts[:2])
    for verdict in verdicts:
        assert (verdict.status, verdict.score) == (Status.ERROR, None)
        assert "no number" in verdict.reason


WIDTH = 12
TENSORS = {
    "ten times": ("head.weight", (1, 10 * WIDTH), "has shape (1, 120); allowed: (1, 12)"),
    "one short": ("head.weight", (1, WIDTH - 1), "has shape (1, 11); allowed: (1, 12)"),
    "flat": ("head.weight", (WIDTH,), "has shape (12,); allowed: (1, 12)"),
    "bias": ("head.bias", (0,), "has shape (0,); allowed: (1,)"),
    "inputs": ("lstm.weight_ih_l0", (4 * WIDTH, 3), "has shape (48, 3); allowed: (48, 43)"),
    "states": ("lstm.weight_hh_l1", (4 * WIDTH, 2), "has shape (48, 2); allowed: (48, 12)"),
    "gates": ("lstm.bias_hh_l0", (4 * WIDTH + 4,), "has shape (52,); allowed: (48,)"),
    "mean": ("mean", (1,), "has shape (1,); allowed: (43,)"),
    "layer": ("lstm.weight_ih_l2", (4 * WIDTH, WIDTH), "'lstm.weight_ih_l2'; allowed: mean, "),
    "attention": ("query.weight", (WIDTH, WIDTH), "unknown tensor 'query.weight'; allowed: mean"),
    "missing": ("lstm.bias_ih_l1", None, "lacks the tensor lstm.bias_ih_l1; allowed: one of sha"),
}


@pytest.mark.parametrize("name", TENSORS)
def test_tensors_are_those_of_the_network_before_anything_runs(name, weights, tmp_path):
    tensor, shape, message = TENSORS[name]
    array = None if shape is None else np.zeros(shape, dtype=np.float32)
    changed_folder(weights, tmp_path, **{tensor: array})
    with pytest.raises(LearnerError) as caught:
        load_weights(tmp_path)
    assert str(caught.value).startswith(f"{tmp_path / 'member_0.safetensors'}: ")
    assert tensor in str(caught.value)
    assert message in str(caught.value)


def test_tensors_are_finite_and_of_one_type(weights, tmp_path):
    head = load_arrays(weights)["head.weight"]
    for odd in (np.nan, np.inf):
        changed = head.copy()
        changed.flat[-1] = odd
        changed_folder(weights, tmp_path, **{"head.weight": changed})
        with pytest.raises(LearnerError, match=r"member_0.*: head.weight has a value that is not"):
            load_weights(tmp_path)
    for kind in (np.float64, np.int64):
        changed_folder(weights, tmp_path, **{"head.weight": head.astype(kind)})
        with pytest.raises(LearnerError, match=r"head.weight has type \w+; allowed: float32"):
            load_weights(tmp_path)


def test_members_take_the_features_of_their_manifest(weights, tmp_path):
    folder = changed_folder(weights, tmp_path)
    manifest = json.loads((folder / "manifest.json").read_text())
    manifest["members"][0]["options"]["features"] = "plain"
    (folder / "manifest.json").write_text(json.dumps(manifest))
    with pytest.raises(LearnerError, match="features of member 0 are plain; allowed: support"):
        load_weights(folder)


def test_ranges_beyond_all_numbers_are_refused(weights, tmp_path):
    folder = changed_folder(weights, tmp_path)
    manifest = json.loads((folder / "manifest.json").read_text())
    name = next(iter(manifest["ranges"]))
    manifest["ranges"][name][1] = 10**400
    (folder / "manifest.json").write_text(json.dumps(manifest))
    with pytest.raises(LearnerError, match="is not the manifest of weights"):
        load_weights(folder)


def test_weights_of_an_earlier_version_are_to_be_trained_again(weights, tmp_path):
    folder = changed_folder(weights, tmp_path)
    manifest = json.loads((folder / "manifest.json").read_text())
    del manifest["ranges"]["overhang"]
    (folder / "manifest.json").write_text(json.dumps(manifest))
    with pytest.raises(LearnerError, match="ranges are not those of this version; train it again"):
        load_weights(folder)


@pytest.mark.parametrize("kind", NetworkKind)
@pytest.mark.parametrize("layers", [1, 3])
def test_the_tensors_that_are_allowed_are_those_that_are_trained(kind, layers):
    for told in FeatureKind:
        options = TrainingOptions(features=told, network=kind, hidden=8, layers=layers)
        network = NETWORKS[kind](len(names(told)), options.hidden, options.layers)
        found = {name: tuple(value.shape) for name, value in network.state_dict().items()}
        assert found == tensor_shapes(options)


@pytest.mark.parametrize("length", [10 * WIDTH, WIDTH - 1])
def test_a_head_of_another_length_ends_in_a_sentence(length, weights, tmp_path, layouts, capsys):
    changed_folder(weights, tmp_path / "odd", **{"head.weight": np.ones((1, length), np.float32)})
    write_layouts(tmp_path / "layouts.json", layouts[:1], Format.NATIVE)
    asked = ["score", str(tmp_path / "layouts.json"), "-m", f"lstm_1:weights={tmp_path / 'odd'}"]
    assert main(asked) == 2
    said = capsys.readouterr().err
    assert (
        f"odd/member_0.safetensors: head.weight has shape (1, {length}); allowed: (1, 12)" in said
    )
    assert said.count("\n") == 1


def test_a_verdict_on_a_step_hangs_on_the_items_placed_by_then(weights, layouts):
    for method in (judge(weights), judge(weights, "lstm_e")):
        for lay in layouts[:15]:
            whole = method.probabilities(lay)
            for count in range(1, len(lay)):
                part = method.probabilities(lay.first(count))
                np.testing.assert_allclose(part, whole[:count], atol=1e-6)


def with_item(lay, **changes):
    return Layout(
        lay.name, lay.pallet, (dataclasses.replace(lay.items[0], **changes), *lay.items[1:])
    )


def test_what_it_was_not_trained_on_is_refused_or_flagged(weights, layouts):
    lay = next(lay for lay in layouts if lay.pallet.width == 100.0)
    heavy = with_item(lay, weight=1e6)
    shifted = with_item(lay, mass_offset=(0.499 * lay.items[0].size[0], 0.0, 0.0))
    alone = (Item(0, (0.0, 0.0, 0.0), (50.0, 50.0, 50.0), 31.0),)
    alone_on = Pallet(100.0, 100.0, 100.0)
    edge = Layout("edge", alone_on, (Item(0, (-5.0, 0.0, 0.0), (50.0, 50.0, 50.0), 31.0),))
    for odd, message in (
        (edge, "item 0: overhang is 5 cm; trained on 0 to 0 cm"),
        (heavy, "item 1: heaviest over lightest is "),
        (shifted, "item 0: shift of the centre of mass is 0.499 of a side; trained on 0 to 0.4"),
    ):
        [verdict] = judge(weights).judge_many([odd])
        for found in (verdict, judge(weights).judge(odd)):
            assert found.status is Status.REFUSED
            assert found.score is None
            assert message in found.reason
            assert "outside=accept" in found.reason
        accepted = judge(weights, outside="accept").judge(odd)
        assert accepted.status is Status.DONE
        assert message in accepted.reason
        assert judge(weights, outside="accept").judge_many([odd])[0].reason == accepted.reason
    whole = make_method(f"lstm_1:weights={weights}").judge_many(layouts)
    assert np.mean([v.status is Status.DONE for v in whole]) > 0.9
    # On what its features do not depend, it has no range.
    hangar = Layout(
        "hangar", Pallet(400.0, 100.0, 100.0), (dataclasses.replace(alone[0], weight=9e4),)
    )
    for inside in (hangar, Layout("deck", dataclasses.replace(alone_on, floor="deck"), alone)):
        assert judge(weights).judge(inside).status is Status.DONE
    # A layout shows all its beginnings: few items are never too few.
    assert judge(weights).judge(lay.first(1)).status is Status.DONE


def test_more_items_than_any_layout_had_in_training_are_judged_step_by_step():
    """Twelve layers of ten boxes; then the same with the last box beyond its support."""
    boxes = [
        Item(10 * y + k, (20.0 * (k % 5), 10.0 * y, 30.0 * (k // 5)), (20.0, 10.0, 30.0), 4.0)
        for y in range(12)
        for k in range(10)
    ]
    deck = Pallet(200.0, 200.0, 100.0)
    pile = Layout("pile", deck, tuple(boxes))
    beyond = dataclasses.replace(boxes[-1], position=(95.0, 110.0, 30.0))
    falling = Layout("falling", deck, (*boxes[:-1], beyond))
    for spec in ("lstm_1", "lstm_e", "lstm_1:question=stands", "lstm_e:question=stands"):
        method = make_method(spec)
        for layout, failing in ((pile, None), (falling, 119)):
            [among_many] = method.judge_many([layout])
            for verdict in (method.judge(layout), among_many):
                assert (verdict.status, verdict.failing_step) == (Status.DONE, failing)
                assert "trained on" not in verdict.reason
        with closing(method.steps(falling, Stopwatch())) as scorer:
            scores = [scorer.step_score(step) for step in range(120)]
        assert np.isfinite(scores).all()
        assert np.argmax(scores) == 119


def test_the_manifest_says_what_the_weights_are(weights):
    manifest = load_weights(weights).manifest
    assert manifest["command"].startswith("steadyload train --preset quick --option features=")
    assert list(manifest["ranges"]) == list(quantities_of(FeatureKind.SUPPORT))
    assert manifest["data"][0]["cases"] == manifest["cases"] == 120
    assert {"git", "versions", "training", "torch"} <= set(manifest["made_by"])
    assert set(manifest["validation"]["mean"]) == {"all", "S1", "S2a", "S2b"}
    left_out = [tuple(member["left_out"]) for member in manifest["members"]]
    assert len(set(left_out)) == len({m["options"]["seed"] for m in manifest["members"]}) == 3
    assert all(lists for lists in left_out)


def test_weights_are_read_as_they_were_written(weights, tmp_path):
    path = weights / "member_0.safetensors"
    ours, theirs = load_arrays(weights), safetensors.numpy.load_file(path)
    assert ours.keys() == theirs.keys()
    for name in theirs:
        np.testing.assert_array_equal(ours[name], theirs[name])
    manifest = {k: v for k, v in load_weights(weights).manifest.items() if k != "hashes"}
    save_weights(tmp_path, [ours], manifest)
    assert (tmp_path / "member_0.safetensors").read_bytes() == path.read_bytes()
    assert len(load_weights(tmp_path).networks) == 1


@pytest.mark.parametrize("content", [b"", b"12345678", b"\x05" + 7 * b"\x00" + b"[1,2]", 99 * b"x"])
def test_what_is_no_safetensors_file_is_refused(content):
    with pytest.raises(LearnerError, match="here: is no safetensors file"):
        parse_arrays(content, Path("here"))


def test_damaged_weights_are_refused(weights, tmp_path):
    arrays = load_arrays(weights)
    manifest = dict(load_weights(weights).manifest)
    del manifest["hashes"]
    save_weights(tmp_path, [arrays], manifest)
    member, about = tmp_path / "member_0.safetensors", tmp_path / "manifest.json"
    whole, text = member.read_bytes(), about.read_text()
    member.write_bytes(whole[:-1] + b"\x01")
    with pytest.raises(LearnerError, match=r"member_0.safetensors: is damaged"):
        load_weights(tmp_path)
    member.unlink()
    with pytest.raises(LearnerError, match=r"member_0.safetensors: is missing"):
        load_weights(tmp_path)
    for broken, message in (
        ("{", "is not the manifest of weights"),
        (json.dumps(json.loads(text) | {"version": 9}), "version is 9; allowed: 1"),
        (json.dumps(json.loads(text) | {"feature_names": ["x"]}), "are not those of this version"),
        (json.dumps(json.loads(text) | {"hashes": []}), "is not the manifest of weights"),
        (json.dumps(json.loads(text) | {"members": []}), "is not the manifest of weights"),
        (json.dumps(json.loads(text) | {"members": [{"options": {"hidden": 0}}]}), "hidden is 0"),
        ("[" * 100_000, "is not the manifest of weights"),
    ):
        about.write_text(broken)
        with pytest.raises(LearnerError, match=message):
            load_weights(tmp_path)


def test_missing_weights_say_what_makes_them():
    method = make_method("lstm_1:weights=nowhere")
    with pytest.raises(LearnerError, match="steadyload train --preset quick -o nowhere makes"):
        method.prepare()
    with pytest.raises(SpecError, match="threshold is 2; allowed: a number, 0 to 1"):
        make_method("lstm_1:threshold=2")
    with pytest.raises(SpecError, match="did you mean 'weights'"):
        make_method("lstm_1:weight=x")


def test_a_folder_is_named_as_a_path_and_may_be_that_of_a_training(weights, tmp_path, monkeypatch):
    # A folder that has the name of shipped weights is meant where it is written as a path.
    own = tmp_path / "lstm_1"
    shutil.copytree(weights, own)
    monkeypatch.chdir(tmp_path)
    assert weights_folder("./lstm_1").resolve() == own
    assert weights_folder(Path("lstm_1")).resolve() == own
    assert weights_folder("lstm_1") == SHIPPED / "lstm_1"
    # What a sentence says makes weights must lead to some: a training keeps them in a folder of it.
    assert load_weights(weights.parent).digest == load_weights(weights).digest


def test_other_weights_are_another_judge(weights, tmp_path):
    arrays = load_arrays(weights)
    manifest = {k: v for k, v in load_weights(weights).manifest.items() if k != "hashes"}
    save_weights(tmp_path, [arrays], manifest)
    one = made_by(judge(tmp_path))
    assert one == made_by(judge(tmp_path))
    arrays["head.bias"] = arrays["head.bias"] + 0.5
    save_weights(tmp_path, [arrays], manifest)
    assert made_by(judge(tmp_path)) != one


def test_preparing_reads_the_weights(weights, layouts, tmp_path):
    """A time of the first layout is not one of reading."""
    folder = shutil.copytree(weights, tmp_path / "read")
    method = judge(folder, outside="accept")
    method.prepare()
    shutil.rmtree(folder)
    assert method.judge(layouts[0]).status is Status.DONE


def test_neither_listing_nor_judging_imports_torch(weights):
    listed = {entry.name: entry for entry in method_listing()}
    assert {p.name for p in listed["lstm_e"].parameters} >= {"weights", "threshold", "outside"}
    script = f"""
import sys
from steadyload.layouts.packing.packing import random_layouts
from steadyload.methods.registry import make_method, method_listing
method_listing()
method = make_method("lstm_e:weights={weights}")
print([v.failing_step for v in method.judge_many(random_layouts(3, seed=1))])
assert not {{"torch", "safetensors", "optuna"}} & set(sys.modules)
"""
    done = subprocess.run(
        [sys.executable, "-c", script], cwd=ROOT, env={"PYTHONPATH": str(ROOT)},
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("name", ["lstm_1", "lstm_e"])
def test_every_question_has_networks_of_its_own(name):
    stands = make_method(f"{name}:question=stands")
    assert stands.parameters.weights == f"{name}-stands"
    assert stands.weights.manifest["question"] == "stands"
    assert stands.trained != make_method(name).trained
    with pytest.raises(LearnerError, match=f"{name}-stands' were trained for the question stands"):
        _ = make_method(f"{name}:weights={name}-stands").weights
    with pytest.raises(LearnerError, match="were trained for the question within, not stands"):
        _ = make_method(f"{name}:question=stands,weights={name}").weights

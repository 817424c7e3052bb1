"""``steadyload train`` and ``generate``, as a user calls them."""

import json

import pytest
import torch

from steadyload.atomic import manifest_text, verified_manifest
from steadyload.cli import main
from steadyload.layouts import Item, Layout, Pallet
from steadyload.layouts.benchmark import load_benchmark
from steadyload.layouts.formats import Format, write_layouts
from steadyload.learners import LearnerError, shipping
from steadyload.learners.shipping import check_shippable, ship
from steadyload.learners.weights import load_weights

SMALL = ["--option", "hidden=8", "--option", "epochs=2", "--limit", "20", "--threads", "1"]


@pytest.fixture(autouse=True)
def _nothing_is_shipped_into_this_tree(tmp_path, monkeypatch):
    monkeypatch.setattr(shipping, "SHIPPED", tmp_path / "package")


def test_what_is_trained_judges_a_file(tmp_path, capsys):
    output = tmp_path / "training"
    command = ["train", *SMALL, "--members", "2", "--left-out", "0.2", "-o", str(output)]
    assert main(command) == 0
    shown = capsys.readouterr()
    weights = output / "weights"
    assert shown.out.strip() == str(weights)
    assert "accuracy on validation: " in shown.err
    assert f"steadyload score FILE -m lstm_e:weights={weights}" in shown.err
    before = (weights / "member_1.safetensors").read_bytes()
    # Again: all is found done, and the same weights come out.
    assert main(command) == 0
    assert (weights / "member_1.safetensors").read_bytes() == before
    capsys.readouterr()
    file = tmp_path / "layouts.json"
    write_layouts(
        file, [load_benchmark().layout("H1_Class_1_Instance_0_ULD_0", "S1")], Format.NATIVE
    )
    assert main(["score", str(file), "-m", f"lstm_e:weights={weights}", "--json"]) == 0
    [record] = json.loads(capsys.readouterr().out)
    assert record["status"] in ("done", "refused")
    assert record["items"] == 20


def test_the_command_of_a_manifest_makes_the_same_weights(tmp_path):
    one = tmp_path / "one"
    assert main(["train", *SMALL, "--features", "plain", "--seed", "5", "-o", str(one)]) == 0
    manifest = load_weights(one / "weights").manifest
    words = manifest["command"].split()[1:]
    two = tmp_path / "two"
    assert main([*words, "--threads", "1", "-o", str(two)]) == 0
    assert load_weights(two / "weights").manifest["hashes"] == manifest["hashes"]
    assert manifest["members"][0]["options"]["seed"] == 5


def test_training_goes_on_from_weights_on_other_data(tmp_path, capsys):
    data, first, second = (tmp_path / name for name in ("data", "first", "second"))
    generate = ["generate", "--lists", "1", "--label", "sme", "--heuristics", "2", "--most", "3"]
    assert main([*generate, "--scenario", "S2b", "-j", "1", "-o", str(data)]) == 0
    assert capsys.readouterr().out.endswith(f"layouts -> {data}\n")
    assert (
        main(["train", *SMALL, "--data", str(data), "--network", "attention", "-o", str(first)])
        == 0
    )
    assert main(["train", "--option", "epochs=1", "--limit", "10", "--start",
                 str(first / "weights"), "-o", str(second)]) == 0  # fmt: skip
    manifest = load_weights(second / "weights").manifest
    assert (manifest["network"], manifest["hidden"]) == ("attention", 8)
    assert load_weights(first / "weights").manifest["data"][0]["label"] == "sme"


def test_a_search_comes_before_the_training(tmp_path, capsys):
    command = ["train", "--option", "epochs=1", "--limit", "10", "--search", "1"]
    assert main([*command, "-o", str(tmp_path)]) == 0
    manifest = load_weights(tmp_path / "weights").manifest
    assert manifest["hidden"] in (100, 125, 150, 175, 200)
    assert 1e-4 <= manifest["members"][0]["options"]["learning_rate"] <= 1e-3


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["train", "--preset", "quik"], "did you mean 'quick'"),
        (["train", "--features", "plian"], "features is 'plian'; did you mean 'plain'"),
        (["train", "--option", "hiden=3"], "did you mean 'hidden'"),
        (["train", "--data", "nowhere"], "nowhere: no manifest.json; is it a labelled set?"),
        (["train", "--start", "nowhere"], "weights 'nowhere': there are none of that name"),
        (["train", "--device", "nonsense"], "device is 'nonsense'; allowed: cpu, cuda"),
        (["train", "--device", "meta"], "device is 'meta'; allowed: cpu, cuda"),
        pytest.param(
            ["train", "--device", "cuda"],
            "device is 'cuda'; torch finds no GPU here",
            marks=pytest.mark.skipif(torch.cuda.is_available(), reason="there is a GPU"),
        ),
        (["train", "--seed", "4294967296"], "seed is 4294967296; allowed: a whole number, 0 to "),
        (["train", "--start", "lstm_1", "--features", "plain"], "features is plain; weights 'lstm"),
        (["train", "--start", "lstm_1", "--option", "hidden=8"], "hidden is 8; weights 'lstm_1'"),
        (["train", "--start", "lstm_1", "--search", "1"], "a search chooses the hidden size"),
        (["generate", "--lists", "1", "--label", "smee"], "unknown method 'smee'"),
        (["generate", "--lists", "1", "--scenario", "S3"], "scenario is 'S3'"),
        (["score", "FILE", "-m", "lstm_1:weights=nowhere"], "steadyload train --preset quick"),
    ],
)
def test_wrong_input_is_one_sentence(words, message, tmp_path, capsys):
    file = tmp_path / "layout.json"
    box = Item(0, (0.0, 0.0, 0.0), (10.0, 10.0, 10.0), 1.0)
    write_layouts(file, [Layout("one", Pallet(80.0, 120.0, 120.0), (box,))], Format.NATIVE)
    words = [str(file) if word == "FILE" else word for word in words]
    assert main([*words, *(["-o", str(tmp_path / "x")] if words[0] != "score" else [])]) == 2
    shown = capsys.readouterr().err
    assert message in shown
    assert shown.count("\n") == 1


def test_presets_are_listed(capsys):
    assert main(["train", "--preset", "list"]) == 0
    assert [line.partition(":")[0] for line in capsys.readouterr().out.splitlines()] == [
        "quick", "paper", "paper-ensemble", "ensemble",
    ]  # fmt: skip


@pytest.mark.parametrize("git", [None, "0123456789ab-dirty"])
def test_what_nobody_could_make_again_is_not_shipped(git):
    with pytest.raises(LearnerError, match="in no commit"):
        check_shippable({"git": git})
    check_shippable({"git": "0123456789ab"})


def test_what_learnt_from_held_out_lists_is_not_shipped(tmp_path):
    output = tmp_path / "leaky"
    assert main(["train", *SMALL, "--leaky", "-o", str(output)]) == 0
    about = output / "weights" / "manifest.json"
    manifest = verified_manifest(json.loads(about.read_text()))
    manifest["made_by"]["git"] = "0123456789ab"
    about.write_text(manifest_text(manifest))
    with pytest.raises(LearnerError, match="learnt from what is held out"):
        ship(output / "weights", "lstm_1")
    # Nor is what was trained on from such weights: they still know it.
    later = tmp_path / "later"
    start = ["--start", str(output / "weights")]
    assert main(["train", "--option", "epochs=1", "--limit", "10", *start, "-o", str(later)]) == 0
    manifest = load_weights(later / "weights").manifest
    assert manifest["leaky"]
    assert manifest["started_from"]["digest"] == load_weights(output / "weights").digest
    assert manifest["started_from"]["command"].endswith("--leaky")


def test_what_uncommitted_code_began_is_not_shipped_as_if_it_were_committed(tmp_path, monkeypatch):
    """A run that goes on, or finds all done, says what code began."""
    from steadyload.learners import jobs

    made_by = jobs.provenance() | {"git": "0123456789ab-dirty"}
    monkeypatch.setattr(jobs, "provenance", lambda: dict(made_by))
    command = ["train", *SMALL, "-o", str(tmp_path / "one")]
    assert main(command) == 0
    made_by["git"] = "0123456789ab"
    assert main(command) == 0
    with pytest.raises(LearnerError, match="in no commit"):
        ship(tmp_path / "one" / "weights", "lstm_1")
    assert "gone_on_by" not in load_weights(tmp_path / "one" / "weights").manifest
    # And likewise what it went on with.
    two, cut = tmp_path / "two", ["--members", "2", "--left-out", "0.2"]
    assert main([*command[:-1], str(two), *cut]) == 0
    made_by["git"] = "0123456789ab-dirty"
    (two / "member_1" / "checkpoint.pt").unlink()
    assert main([*command[:-1], str(two), *cut]) == 0
    manifest = load_weights(two / "weights").manifest
    assert manifest["made_by"]["git"] == "0123456789ab"
    assert [made["git"] for made in manifest["gone_on_by"]] == ["0123456789ab-dirty"]
    with pytest.raises(LearnerError, match="in no commit"):
        ship(two / "weights", "lstm_1")


@pytest.mark.parametrize("name", ["", "..", "a/b", "/tmp/x", "a,b", "a=b", ".x"])
def test_shipped_weights_have_a_plain_name(name, tmp_path):
    with pytest.raises(LearnerError, match="allowed: letters, digits"):
        ship(tmp_path, name)


def test_what_will_not_be_shipped_is_not_trained_for_it(tmp_path, capsys):
    for words, message in ((["a/b"], "name of weights is 'a/b'"), (["x", "--leaky"], "held out")):
        assert main(["train", *SMALL, "-o", str(tmp_path / "x"), "--ship", *words]) == 2
        assert message in capsys.readouterr().err
    assert not (tmp_path / "x").exists()

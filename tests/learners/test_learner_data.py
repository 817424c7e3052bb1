"""Sequences of labelled layouts, what is held out of them, and sets made to learn from."""

import dataclasses
import json

import numpy as np
import pandas as pd
import pytest

from steadyload.layouts.benchmark import load_benchmark
from steadyload.layouts.packing.packing import make_instance
from steadyload.learners import LeakError, LearnerError
from steadyload.learners.features import FeatureKind, features
from steadyload.learners.generation import (
    OWN_SEEDS,
    GenerationOptions,
    generate_labelled,
)
from steadyload.learners.scoring import accuracies, confidence, items_safe
from steadyload.learners.sequences import HeldOut, geometry_of, joined, load_sequences
from steadyload.methods.registry import make_method

PLAIN = FeatureKind.PLAIN
FEW = GenerationOptions(lists=2, label="sme", heuristics=2, most=4)


@pytest.fixture(scope="module")
def benchmark():
    return load_benchmark()


@pytest.fixture(scope="module")
def held_out():
    return HeldOut.of()


@pytest.fixture(scope="module")
def generated(tmp_path_factory):
    directory = tmp_path_factory.mktemp("generated")
    return directory, generate_labelled(FEW, directory, workers=0)


def test_sequences_hold_features_and_labels_in_order(benchmark):
    data = load_sequences(PLAIN, "validation", limit=20)
    cases = benchmark.select("validation", limit=20)
    assert len(data) == len(cases) == 60
    padded = data.padded()
    for k, case in cases.iterrows():
        lay = benchmark.layout(case["layout"], case["scenario"])
        np.testing.assert_array_equal(padded[k, : len(lay)], features(lay, PLAIN))
        assert not padded[k, len(lay) :].any()
        stable = pd.isna(case["failing_step"])
        assert data.safe[k] == (len(lay) if stable else case["failing_step"])
        # Labels end with the first unstable step; after it nobody knows.
        assert data.valid()[k] == (len(lay) if stable else case["failing_step"] + 1)
        assert data.geometries[k] == lay.geometry_hash()
    half = data.chosen(data.scenarios == "S2a")
    assert half.counts.tolist() == data.counts[20:40].tolist()
    again = joined([half, data.chosen(data.scenarios == "S2b")])
    np.testing.assert_array_equal(again.rows, data.chosen(data.scenarios != "S1").rows)


def test_few_item_lists_are_among_more():
    every = load_sequences(PLAIN, limit=40)
    few, more = (load_sequences(PLAIN, limit=40, lists=count) for count in (4, 9))
    assert [len(set(data.instances)) for data in (few, more)] == [4, 9]
    assert set(few.instances) < set(more.instances) < set(every.instances)
    # All cases of a list that would be there, and no range of any other.
    assert len(few) == np.isin(every.instances, few.instances).sum()
    largest = max(few.ranges["weight"][1], more.ranges["weight"][1])
    assert largest == more.ranges["weight"][1] <= every.ranges["weight"][1]
    again = load_sequences(PLAIN, limit=40, lists=10**6)
    assert again.fingerprint() == every.fingerprint()


def test_scores_are_compared_whole():
    data = load_sequences(PLAIN, "validation", limit=2, scenarios=("S1",))
    data = dataclasses.replace(data, safe=np.array([2, data.counts[1]]))
    steps = int(data.counts.max())
    probabilities = np.zeros((2, steps))
    probabilities[0, [2, 4]] = 0.7  # the first one counts
    probabilities[1, data.counts[1] :] = 1.0  # after the end nothing does
    assert items_safe(probabilities, data.counts).tolist() == data.safe.tolist()
    assert accuracies(probabilities, data) == {"all": 1.0, "S1": 1.0}
    assert accuracies(probabilities, data, threshold=0.8)["all"] == 0.5


def test_the_confidence_in_a_score_follows_from_its_steps():
    p = np.array([[0.2, 0.9, 0.7], [0.2, 0.1, 0.99], [0.6, 0.3, 0.2], [0.1, 0.2, 0.3]])
    sure = confidence(p, np.array([3, 2, 3, 3]))
    assert sure == pytest.approx([0.8 * 0.9, 0.8 * 0.9, 0.6, 0.9 * 0.8 * 0.7])
    # The probabilities of all scores of a layout are a distribution.
    every = [np.prod(1.0 - p[0, :k]) * (p[0, k] if k < 3 else 1.0) for k in range(4)]
    assert sum(every) == pytest.approx(1.0)
    assert every[1] == pytest.approx(sure[0])


def test_nothing_of_validation_and_test_is_in_the_training_part(benchmark, held_out):
    data = load_sequences(PLAIN)
    held_out.check(data)
    assert len(held_out.without_twins(data)) == len(data)
    # Independently of how it is enforced: from the tables, and from the layouts' own hashes.
    cases = benchmark.cases[benchmark.cases["split"].isin(["validation", "test"])]
    assert not {i.split("/")[1] for i in data.instances} & set(cases["instance"])
    own = {benchmark.layout(n, s).geometry_hash() for n, s in
           zip(cases["layout"], cases["scenario"], strict=True)}  # fmt: skip
    assert own <= held_out.geometries
    assert not own & set(data.geometries)
    assert len(held_out.instances) == cases["instance"].nunique()


def test_a_leak_is_an_error_that_names_it(held_out):
    leaky = load_sequences(PLAIN, limit=500, scenarios=("S1",), leaky=True)
    with pytest.raises(LeakError, match=r"item list '2024/Class_._Instance_.*' is held out"):
        held_out.check(leaky)
    # Under another name, its geometry betrays it; a twin by chance can be let go.
    disguised = dataclasses.replace(
        leaky, instances=np.array(["elsewhere"] * len(leaky), dtype=object)
    )
    with pytest.raises(LeakError, match="'elsewhere' has the geometry of a layout that is held"):
        held_out.check(disguised)
    held_out.check(held_out.without_twins(disguised))
    assert 0 < len(held_out.without_twins(disguised)) < len(disguised)
    # Named openly, no layout is let go in silence.
    assert len(held_out.without_twins(leaky)) == len(leaky)


def test_the_leaky_part_holds_no_case_of_validation_or_test(benchmark):
    leaky = load_sequences(PLAIN, leaky=True, limit=None, scenarios=("S2b",))
    train = load_sequences(PLAIN, scenarios=("S2b",))
    cases = benchmark.cases
    asked = cases[cases["split"].isin(["validation", "test"]) & (cases["scenario"] == "S2b")]
    hashes = {geometry_of(benchmark.layouts.loc[name]) for name in asked["layout"]}
    assert not hashes & set(leaky.geometries)
    assert len(leaky) > len(train)
    assert set(leaky.geometries) > set(train.geometries)


def test_a_generated_set_is_labelled_by_its_method(generated, held_out):
    directory, manifest = generated
    benchmark, method = load_benchmark(directory), make_method("sme")
    cases = benchmark.select("train")
    assert len(cases) == manifest["cases"] > 40
    assert manifest["left_out"]["no label"] == {}
    for _, case in cases.iterrows():
        verdict = method.judge(benchmark.layout(case["layout"], case["scenario"]))
        label = case["failing_step"]
        assert verdict.failing_step == (None if pd.isna(label) else label)
    for scenario, group in cases.groupby("scenario"):
        assert group["rank"].tolist() == list(range(len(group))), scenario
    data = load_sequences(PLAIN, directory=directory)
    HeldOut.of([None, directory]).check(data)
    held_out.check(data)
    # The classes as in the labelled set: there four of five layouts are of class 3.
    assert 0.7 < benchmark.layouts["item_class"].eq(3).mean() < 0.9


def test_generated_item_lists_are_of_seeds_of_their_own(generated, benchmark):
    assert benchmark.manifest["seed"] < OWN_SEEDS
    assert load_benchmark(generated[0]).manifest["seed"] == OWN_SEEDS
    old = {make_instance(c, n, seed=2024).sizes[:5] for c in (1, 2, 3) for n in range(17)}
    new = {make_instance(c, n, seed=OWN_SEEDS).sizes[:5] for c in (1, 2, 3) for n in range(17)}
    assert not old & new


def test_a_generation_goes_on_and_grows_to_the_same_set(generated, tmp_path):
    directory, _ = generated
    grown = tmp_path / "grown"
    one = dataclasses.replace(FEW, lists=1)
    counts = []
    generate_labelled(one, grown, workers=0, progress=lambda *done: counts.append(done))
    # Cut off while it was at the last list.
    next((grown / "shards").glob("3_000007.*")).unlink()
    generate_labelled(FEW, grown, workers=2, progress=lambda *done: counts.append(done))
    assert counts[:11] == [(done, 10) for done in range(11)]
    assert counts[11] == (9, 20)
    for name in ("layouts.parquet", "cases.parquet"):
        assert (grown / name).read_bytes() == (directory / name).read_bytes()
    with pytest.raises(LearnerError, match=r"holds another set \(label differ\)"):
        generate_labelled(dataclasses.replace(FEW, label="fbs"), grown)


def test_a_generated_set_names_every_code_that_labelled_it(tmp_path, monkeypatch):
    one = GenerationOptions(lists=1, label="sme", heuristics=1, most=1, scenarios=("S1",))

    def run(code, options=one):
        monkeypatch.setattr("steadyload.learners.generation.provenance", lambda: {"code": code})
        made = generate_labelled(options, tmp_path, workers=0)
        return [run["code"] for run in (*made["labelled_with_before"], made["labelled_with"])]

    assert run("old") == ["old"]
    assert run("idle") == ["old"]  # nothing was left to label
    assert run("new", dataclasses.replace(one, lists=2)) == ["old", "new"]
    assert run("new", dataclasses.replace(one, lists=3)) == ["old", "new"]


@pytest.mark.parametrize("name", ["manifest.json", "mine.csv", "spatial"])
def test_a_folder_of_something_else_is_left_alone(name, tmp_path):
    (tmp_path / name).write_text(json.dumps({"version": 1}))
    with pytest.raises(LearnerError, match="holds something else"):
        generate_labelled(FEW, tmp_path)
    assert {path.name for path in tmp_path.iterdir()} == {name, ".lock"}


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"lists": 0}, "lists is 0; allowed: 1 to"),
        ({"heuristics": 161}, "heuristics is 161; allowed: 1 to 160"),
        ({"seed": OWN_SEEDS}, "seed is 1000000000; allowed: 0 to 999999999"),
        ({"label": "nobody"}, "unknown method 'nobody'"),
    ],
)
def test_a_set_that_cannot_be(change, message):
    with pytest.raises(ValueError, match=message):
        dataclasses.replace(FEW, **change)

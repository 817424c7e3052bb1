"""The weights that come with the package: what they are, and what they are worth."""

import numpy as np
import pandas as pd
import pytest

from steadyload.layouts.benchmark import load_benchmark
from steadyload.learners.weights import SHIPPED, load_weights, shipped_weights
from steadyload.methods.contract.method import Status
from steadyload.methods.registry import make_method

NAMES = ("lstm_1", "lstm_e")


def share_right(spec, scenario):
    benchmark = load_benchmark()
    cases = benchmark.select("validation", scenarios=(scenario,))
    layouts = [benchmark.layout(name, scenario) for name in cases["layout"]]
    verdicts = make_method(spec).judge_many(layouts)
    assert all(verdict.status is Status.DONE for verdict in verdicts)
    labels = [None if pd.isna(label) else label for label in cases["failing_step"]]
    return np.mean([v.failing_step == label for v, label in zip(verdicts, labels, strict=True)])


@pytest.mark.parametrize("name", NAMES)
def test_they_can_be_made_again_and_learnt_from_nothing_held_out(name):
    weights = load_weights(name)
    manifest = weights.manifest
    assert "dirty" not in manifest["made_by"]["git"]
    assert manifest["command"].startswith("steadyload train ")
    assert not manifest["leaky"]
    assert len(weights.networks) == len(manifest["members"]) == (1 if name == "lstm_1" else 5)
    assert set(NAMES) <= set(shipped_weights())
    assert sum(file.stat().st_size for file in SHIPPED.rglob("*")) < 16e6


@pytest.mark.parametrize("name", NAMES)
def test_they_are_as_accurate_as_their_manifest_says_and_beat_the_static_rules(name):
    found = share_right(name, "S1")
    manifest = load_weights(name).manifest["validation"]
    stated = manifest["members"][0] if name == "lstm_1" else manifest["mean"]
    assert found == pytest.approx(stated["benchmark S1"], abs=0.004)  # a case of 300
    for rule in ("fbs", "pbs:alpha=0.5", "pbs:alpha=0.7", "pbs:alpha=0.9", "sme"):
        assert found > share_right(rule, "S1")

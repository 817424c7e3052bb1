"""The shipped set of many item lists: a test that shares no list and no geometry with others."""

import json

import numpy as np
import pandas as pd
import pytest

from steadyload.layouts.benchmark import load_benchmark
from steadyload.layouts.benchmark.dataset import CHOOSING, KEYS, LISTS, SETS
from steadyload.methods.contract.verdict import Status
from steadyload.methods.registry import make_method

PER_CLASS, MOST_OF_LIST, MOST_LAYOUTS = 30, 40, 30


@pytest.fixture(scope="module")
def lists():
    return load_benchmark(LISTS)


def test_thirty_lists_a_class_with_at_most_forty_balanced_cases_each(lists):
    cases = lists.cases
    assert set(cases["split"].dropna()) == {"test"}
    test = cases[cases["split"] == "test"]
    assert test.groupby("instance").size().max() <= MOST_OF_LIST
    classes = test.drop_duplicates("instance")["instance"].str.split("_").str[1]
    assert classes.value_counts().to_dict() == {"1": PER_CLASS, "2": PER_CLASS, "3": PER_CLASS}
    stable = test["failing_step"].isna()
    assert stable.groupby(test["scenario"]).mean().eq(0.5).all()
    of_a_list = stable.groupby([test["instance"], test["scenario"]])
    assert len(of_a_list) == 3 * 3 * PER_CLASS  # every list is asked in every scenario
    assert of_a_list.sum().between(2, MOST_OF_LIST // 6).all()
    assert (of_a_list.size() - of_a_list.sum()).between(2, MOST_OF_LIST // 6).all()
    assert lists.layouts.groupby("instance").size().max() == MOST_LAYOUTS


@pytest.mark.parametrize("limit", [60, 300])
def test_first_ranks_are_balanced_and_of_many_lists(lists, limit):
    chosen = lists.select("test", limit=limit)
    assert chosen.groupby("scenario").size().eq(limit).all()
    assert chosen["failing_step"].isna().groupby(chosen["scenario"]).mean().eq(0.5).all()
    assert chosen["instance"].nunique() >= min(PER_CLASS * 3, limit // 2)


def test_no_list_and_no_geometry_is_in_the_large_set(lists):
    large = load_benchmark()
    assert not set(lists.layouts["instance"]) & set(large.layouts["instance"])

    def geometries(benchmark):
        names = benchmark.cases["layout"].unique()
        return {benchmark.layout(name, "S1").geometry_hash() for name in names}

    found = geometries(lists)
    assert len(found) == len(lists.layouts) == 2700
    assert not found & geometries(large)


def test_almost_every_case_is_labelled_and_some_labels_are_the_reference_asked_anew(lists):
    assert (lists.cases["status"] == Status.DONE).mean() > 0.9995
    judge = make_method("label@reference")
    random = np.random.default_rng(4)
    labelled = lists.cases[lists.cases["status"] == Status.DONE]
    for _, case in labelled.iloc[random.choice(len(labelled), 5, replace=False)].iterrows():
        verdict = judge.judge(lists.layout(case["layout"], case["scenario"]))
        step = None if pd.isna(case["failing_step"]) else int(case["failing_step"])
        assert verdict.failing_step == step, (case["layout"], case["scenario"])


def test_whatever_fails_within_the_time_does_not_stand_longer(lists):
    """The second question has the same thresholds and more time: it never names a later step."""
    test = lists.cases[lists.cases["split"] == "test"]
    both = test.merge(lists.stands, on=KEYS, suffixes=("", "_stands"))
    assert len(both) == len(lists.stands) == len(test)
    done = both[both["status_stands"] == Status.DONE]
    assert len(done) > 0.99 * len(both)
    within, stands = (
        done[c].fillna(done["item_count"]) for c in ("failing_step", "failing_step_stands")
    )
    assert (stands <= within).all()
    assert 0.02 < (stands < within).mean() < 0.2


@pytest.mark.parametrize("name", [LISTS, CHOOSING])
def test_the_manifest_names_clean_commits(name):
    manifest = json.loads((SETS[name] / "manifest.json").read_text())
    for made in (
        manifest["built_with"],
        manifest["labelled_with"],
        manifest["stands"]["labelled_with"],
    ):
        assert made["git"]
        assert "dirty" not in made["git"]

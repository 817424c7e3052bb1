"""Engines with parameters that equal searches found, on cases of real labelled layouts."""

import pandas as pd
import pytest

from steadyload.layouts.benchmark import load_benchmark
from steadyload.layouts.benchmark.parts import LISTS, Part
from steadyload.methods.registry import make_method
from steadyload.methods.tuned import EQUAL, TUNED, tuned
from steadyload.runs.labels import Cases
from steadyload.studies.engines.equal_searches import equal_searches
from steadyload.studies.kit import Lab

ENGINES = ("bullet", "mujoco", "rapier")
DESCRIPTION = ("found", "model", "goal", "engine", "git", "versions", "machine")


@pytest.fixture(scope="module")
def judged(tmp_path_factory):
    cases = Cases(load_benchmark(LISTS), Part.TEST, limit=4)
    specs = tuple(f"{name}@{engine}" for engine in ENGINES for name in (EQUAL, TUNED))
    return (
        Lab(tmp_path_factory.mktemp("equal"), 0)
        .judge(specs, cases, folder="run", name="equal")
        .judged
    )


def test_searches_differ_in_their_engine_alone():
    searches = [
        {key: value for key, value in entry.made_by.items() if key not in DESCRIPTION}
        for entry in tuned(preset=EQUAL).values()
    ]
    assert len(searches) >= 5
    assert all(own == searches[0] for own in searches)
    assert searches[0]["begin_with"] == []
    cases = {entry.made_by["found"]["cases"] for entry in tuned(preset=EQUAL).values()}
    assert len(cases) == 1


def test_each_engine_is_compared_with_the_best_one_and_with_its_own_preset(judged, monkeypatch):
    monkeypatch.setattr("steadyload.studies.engines.equal_searches.tuned_engines", lambda: ENGINES)
    found = equal_searches(judged)
    benchmark = load_benchmark(LISTS)
    right = dict.fromkeys((f"{name}@{engine}" for engine in ENGINES for name in (EQUAL, TUNED)), 0)
    for case in benchmark.select("test", limit=4).itertuples():
        label = None if case.failing_step is pd.NA else case.failing_step
        for spec in right:
            verdict = make_method(spec).judge(benchmark.layout(case.layout, case.scenario))
            right[spec] += verdict.failing_step == label
    assert (found["cases"], found["item_lists"]) == (
        12,
        benchmark.select("test", limit=4).instance.nunique(),
    )
    rows = found["engines"]
    best = max(right[f"{EQUAL}@{engine}"] for engine in ENGINES)
    assert max(own.value for own in rows["right"]) == pytest.approx(best / 12)
    assert not found["worse"], "12 cases show no difference"
    for own in rows.itertuples():
        equal, other = right[f"{EQUAL}@{own.engine}"], right[f"{TUNED}@{own.engine}"]
        assert own.right.value == pytest.approx(equal / 12)
        assert own.more.value == pytest.approx((equal - other) / 12)
        if own.behind is not None:
            assert own.behind.value == pytest.approx((best - equal) / 12)
    assert rows["behind"].isna().sum() == 1

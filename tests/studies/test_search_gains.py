"""Accuracy that searches add to their starts, counted by hand on a few labelled cases."""

import pandas as pd
import pytest

from steadyload.layouts.benchmark import load_benchmark
from steadyload.layouts.benchmark.parts import LISTS
from steadyload.layouts.model.question import Question, with_question
from steadyload.methods.registry import make_method
from steadyload.methods.tuned import tuned
from steadyload.statistics.paired import detectable
from steadyload.studies.kit import Lab
from steadyload.studies.tuning.gains import search_gains
from steadyload.tuning.space import space_on

ENGINES = ("mujoco", "rapier")


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    return search_gains(Lab(tmp_path_factory.mktemp("gains"), 0), (*ENGINES, "chipmunk"), 3)


def test_every_engine_with_a_preset_is_compared_for_both_questions(found):
    pairs = list(zip(found["question"], found["engine"], strict=True))
    expected = [(question, engine) for question in Question for engine in ENGINES]
    assert [pair for pair in pairs if pair[1] != "chipmunk"] == expected
    assert (Question.STANDS, "chipmunk") not in pairs


@pytest.mark.parametrize("question", list(Question))
@pytest.mark.parametrize("engine", ENGINES)
def test_the_gain_is_what_the_preset_has_right_more_often(found, engine, question):
    own = found.set_index(["question", "engine"]).loc[(question, engine)]
    entry = tuned(question)[engine]
    space = space_on(engine, entry.made_by["space"])
    specs = (space.spec(space.start), with_question(f"ps_opt@{engine}", question))
    benchmark, right = load_benchmark(LISTS), dict.fromkeys(specs, 0)
    chosen = benchmark.select("test", limit=3, question=question)
    for case in chosen.itertuples():
        label = None if pd.isna(case.failing_step) else case.failing_step
        for spec in specs:
            said = make_method(spec).judge(benchmark.layout(case.layout, case.scenario))
            right[spec] += said.failing_step == label
    start, after = (right[spec] / len(chosen) for spec in specs)
    assert own["gain"].n == len(chosen) == 9
    assert (own["start"].value, own["preset"].value) == (pytest.approx(start), pytest.approx(after))
    assert own["gain"].value == pytest.approx(after - start)
    lists = chosen["instance"].nunique()
    assert own["shown"] == detectable(own["gain"], lists)

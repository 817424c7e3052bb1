"""What the page of engines shows of each part, and which sources of differences lead it."""

import pandas as pd
import pytest

from steadyload.layouts.model.question import Question
from steadyload.reports.table import percent
from steadyload.statistics.estimate import Estimate
from steadyload.studies.engines.showing import Found, costs_of, depends
from steadyload.studies.engines.sources import Design
from steadyload.studies.engines.speed import Gain, SpeedCurve, SpeedPoint, Throughput
from steadyload.studies.engines.study import EngineStudy

BOTH = (Question.WITHIN, Question.STANDS)


def about(value):
    return Estimate(value, value - 0.01, value + 0.01, 50)


def made_up(parameters, largest, questions=(Question.WITHIN,)):
    parts = ("whole", "always", "by_case", "component")
    shares = pd.DataFrame([
        {"title": title, **dict.fromkeys(parts, about(value)), "freedom": 4, "design": "a design"}
        for title, value in (("engine", 0.2), ("parameters", 0.5), ("engine with parameters", 0.3))
    ])  # fmt: skip
    return {
        "design": Design("lists", parameters, questions), "answer": "share of items placed",
        "cases": 299, "item_lists": 50, "left_out": 1, "differing": about(0.5), "shares": shares,
        "largest": largest,
    }  # fmt: skip


FOUR, TWO = made_up(("ps3-literal", "ps_opt"), "parameters"), made_up(("ps_opt",), "engine")
ASKED_BOTH = made_up(("ps_opt",), "question", BOTH)


@pytest.mark.parametrize(
    ("tables", "answer"),
    [
        ([FOUR, TWO, ASKED_BOTH], True),
        ([FOUR], False),
        ([TWO, TWO], False),
        ([TWO, ASKED_BOTH], False),
    ],
)
def test_the_largest_source_depends_on_the_parameter_sets_of_one_question(tables, answer):
    assert depends(tables) is answer


def test_the_page_shows_every_part(assert_shown):
    points = (
        SpeedPoint(10, 2.0, 0.5, 1.0, 0.2, 0.8, 0.1, 3),
        SpeedPoint(20, 5, 1, 3, 1, None, None, 3),
    )
    curves = [SpeedCurve("bullet", "pile", "all", points, 1.2)]
    costs = costs_of(curves)
    assert [cost.own for cost in costs] == [pytest.approx(110.0), None]
    assert [cost.share for cost in costs] == pytest.approx([50.0, 60.0])
    chart = [
        {"engine": a, "other": b, "frequency": f, "same": about(0.7)}
        for f in (60, 240) for a, b in (("bullet", "mujoco"), ("mujoco", "bullet"))
    ]  # fmt: skip
    engine = {"engine": ["bullet", "dart"]}
    worse = {"engine": "bullet", "behind": about(0.05)}
    found = Found(
        made_with={}, layouts=50, tuned=("bullet", "dart"), timed="", depends=True,
        agreement={
            "pairs": pd.DataFrame({"pair": ["bullet and mujoco"], "same:60": [about(0.7)]}),
            "stable": pd.DataFrame({**engine, "stable_at:60": about(0.7)}),
            "cpu": pd.DataFrame({**engine, "cpu_at:60": about(1.5)}),
            "points": chart, "matrix": chart[2:], "finest": 240,
            "alike": [about(0.7), about(0.9)],
        },
        accuracy={
            "whole": pd.DataFrame({**engine, "single": "double", "right": about(0.75)}),
            "groups": {"items": pd.DataFrame({**engine, "engine_right:up to 10": about(0.8)})},
            "single": [], "cases": 40, "item_lists": 20,
        },
        options={
            "changed": pd.DataFrame({"option": ["local"], "option_changed:bullet": [about(0.1)]}),
            "ratio": pd.DataFrame({"option": ["local"], "option_ratio:bullet": [0.5]}),
        },
        curves=curves, costs=costs, rates=[Gain(Throughput("bullet", 60, 10.0, 18.0), 1.8)],
        tables=[FOUR, TWO, ASKED_BOTH], shares=FOUR["shares"].to_dict("records"),
        equal={
            "engines": pd.DataFrame({
                **engine, "right": about(0.9), "behind": [about(0.05), None], "genotypes": 115,
                "searched_on": 900, "found_there": 0.97, "more": about(0.0),
            }),
            "worse": [worse], "cases": 300, "item_lists": 50,
        },
    )  # fmt: skip
    assert_shown(
        EngineStudy(),
        found,
        answer=["70.0", "90.0", 50, percent(about(0.05))],
        charts=["agreement", "sources", "convergence", "growth"],
    )

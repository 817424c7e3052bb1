"""What the page of engines shows of each part, and which sources of differences lead it."""

import pytest

from steadyload.layouts.model.question import Question
from steadyload.reports.table import percent
from steadyload.statistics.estimate import Estimate
from steadyload.studies.engines.accuracy import ALL, Accuracy, Group
from steadyload.studies.engines.agreeing import FREQUENCIES, Agreement, OptionEffect, Pair, Untuned
from steadyload.studies.engines.equal_searches import EquallySearched, EqualSearches
from steadyload.studies.engines.showing import Found
from steadyload.studies.engines.sources import ANSWERS, Design, Source, SourceTable
from steadyload.studies.engines.speed import Gain, SpeedCurve, SpeedPoint, Throughput
from steadyload.studies.engines.study import EngineStudy
from steadyload.studies.kit import Lab

BOTH = (Question.WITHIN, Question.STANDS)
PLACED, STABLE = ANSWERS


def about(value):
    return Estimate(value, value - 0.01, value + 0.01, 50)


def made_up(parameters, shares, questions=(Question.WITHIN,), answer=PLACED):
    factors = [("engine",), ("parameters",), ("engine", "parameters")]
    found = [Source("", f, *4 * [about(v)], 4) for f, v in zip(factors, shares, strict=True)]
    return SourceTable(
        Design("lists", parameters, questions), answer, 299, 50, 1, about(0.5), tuple(found)
    )


FOUR = made_up(("ps3-literal", "ps_opt"), (0.147, 0.555, 0.298))
TWO = made_up(("ps_opt", "label"), (0.530, 0.083, 0.387))
LIKE_TWO = made_up(("ps_opt",), (0.6, 0.1, 0.3))
ASKED_BOTH = made_up(("ps_opt",), (0.25, 0.61, 0.14), BOTH)


@pytest.mark.parametrize(
    ("tables", "depends"),
    [
        ([FOUR, TWO, ASKED_BOTH], True),
        ([FOUR], False),
        ([TWO, LIKE_TWO], False),
        ([TWO, ASKED_BOTH], False),
        ([made_up(("label",), (0.1, 0.6, 0.3), answer=STABLE), TWO], False),
    ],
)
def test_the_largest_source_depends_on_the_parameter_sets_of_one_question(tables, depends):
    assert Found({}, tables=tables).depends is depends
    assert TWO.largest.factors == ("engine",)
    assert FOUR.largest.factors == ("parameters",)


def test_the_page_shows_every_part(assert_shown):
    engines = ("bullet", "mujoco", "dart")
    shares = {60: about(0.8), 240: about(0.9)}
    agreement = Agreement(
        [Pair(engines[:2], shares), Pair(engines[1:], shares | {240: about(0.7)})],
        [Untuned(name, shares, {60: about(1.5), 240: about(5.0)}) for name in engines],
    )
    assert (agreement.finest, agreement.alike) == (240, [about(0.7), about(0.9)])
    points = (
        SpeedPoint(10, 2.0, 0.5, 1.0, 0.2, 0.8, 0.1, 3),
        SpeedPoint(20, 5, 1, 3, 1, None, None, 3),
    )
    groups = {
        ALL: [Group("bullet", True, {ALL: about(0.75)})],
        "items": [Group("bullet", True, {"up to 10 items": about(0.8)})],
    }
    everything = Found(
        {},
        agreement=agreement,
        accuracy=Accuracy(40, 20, groups),
        options=[OptionEffect("local scope", {"bullet": about(0.1)}, {"bullet": 0.5})],
        curves=[SpeedCurve("bullet", "pile", "all", points, 1.2)],
        rates=[Gain(Throughput("bullet", 60, 10.0, 18.0), 1.8)],
        tables=[FOUR, TWO, ASKED_BOTH],
        equal=EqualSearches(
            [
                EquallySearched("bullet", 115, 900, 0.97, about(0.93), about(0.05), about(-0.01)),
                EquallySearched("dart", 120, 900, 0.98, about(0.98), None, about(0.0)),
            ],
            300, 50,
        ),
    )  # fmt: skip
    assert [cost.own for cost in everything.costs] == [pytest.approx(110.0), None]
    assert [cost.share for cost in everything.costs] == pytest.approx([50.0, 60.0])
    assert_shown(
        EngineStudy(),
        everything,
        answer=["70.0", "90.0", 50, percent(about(0.05))],
        tables=[
            *(table.shares for table in everything.tables),
            everything.equal.engines,
            *groups.values(),
            *(agreement.pairs, agreement.engines, agreement.engines),
            *(
                everything.options,
                everything.options,
                everything.costs,
                everything.curves,
                everything.rates,
            ),
        ],
        charts=["agreement", "sources", "convergence", "growth"],
    )


def test_the_study_measures_the_parts_that_are_chosen(tmp_path):
    only = EngineStudy(parts=("agreement",), layouts=1).run(Lab(tmp_path, 0))
    assert {share.n for share in only.agreement.alike} == {1}
    assert list(only.agreement.pairs[0].same) == list(FREQUENCIES)
    assert not any((only.options, only.curves, only.rates, only.tables))

"""Sources of differences between verdicts, judged by real engines and by answers made up."""

import numpy as np
import pytest

from steadyload.layouts.model.question import Question
from steadyload.methods.tuned import tuned_engines
from steadyload.reports.pages.writing import write_page
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.variance import SourceShare
from steadyload.studies.engines import sources as module
from steadyload.studies.engines.showing import Found
from steadyload.studies.engines.sources import (
    ANSWERS,
    DESIGNS,
    Design,
    SourceTable,
    sources_of_differences,
)
from steadyload.studies.engines.study import EngineStudy
from steadyload.studies.kit import Lab

BOTH = Design("lists", ("ps_opt",), (Question.WITHIN, Question.STANDS))


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, "DESIGNS", (BOTH,))
        work = tmp_path_factory.mktemp("sources")
        tables = sources_of_differences(Lab(work, 0), {"lists": 4})
        again = sources_of_differences(Lab(work, 0), {"lists": 4})
    assert again == tables
    return tables


def test_designs_ask_every_engine_everything_in_the_order_of_their_levels():
    for design in DESIGNS:
        shape = [len(own) for own in design.levels.values()]
        specs = design.specs()
        assert len(set(specs)) == len(specs) == np.prod(shape)
    engines = tuned_engines()
    assert {"mujoco", "dart"} <= set(engines)
    names = np.array(BOTH.specs()).reshape(len(engines), 2)
    for engine, (within, stands) in zip(engines, names, strict=True):
        assert f"@{engine}" in within
        assert f"@{engine}" in stands
        assert "question=stands" not in within
        assert "question=stands" in stands


def test_all_of_the_differences_are_shared_out(found):
    assert [table.answer for table in found] == list(ANSWERS)
    for table in found:
        # Asked whether a load stands, one that rattles has no verdict: which ones, rounding says.
        assert table.cases + table.left_out == 12
        assert table.cases >= 9
        assert list(table.design.levels) == ["engine", "question"]
        assert [share.factors for share in table.shares] == [
            ("engine",), ("question",), ("engine", "question")
        ]  # fmt: skip
        if table.differing:
            assert sum(share.whole.value for share in table.shares) == pytest.approx(1.0)


def page_of(tables):
    return EngineStudy().page(Found(None, [], [], [], tables, None, {}))


def leading(*tables):
    """The first paragraph of the page."""
    return page_of(tables).summary.partition("\n")[0]


def made_up(parameters, shares, questions=(Question.WITHIN,)):
    of = [("engine",), ("parameters",), ("engine", "parameters")]
    about = [SourceShare(f, *[Estimate(value, value, value, 50)] * 3)
             for f, value in zip(of, shares, strict=True)]  # fmt: skip
    design = Design("lists", parameters, questions)
    return SourceTable(design, next(iter(ANSWERS)), 299, 50, 1, 0.5, tuple(about))


def test_the_answer_shows_every_choice_of_parameters_and_all_shares():
    both = (Question.WITHIN, Question.STANDS)
    four = made_up(("ps3-literal", "ps_opt"), (0.147, 0.555, 0.298))
    two = made_up(("ps_opt", "label"), (0.530, 0.083, 0.387))
    said = leading(four, two, made_up(("ps_opt",), (0.25, 0.61, 0.14), both))
    for shown in ("14.7", "55.5", "29.8", "53.0", "8.3", "38.7"):
        assert f"{shown} [" in said
    assert "25.0" not in said
    assert "depends on the parameter sets" in said
    assert "depends on" not in leading(four)
    assert "depends on" not in leading(four, made_up(("ps_opt",), (0.1, 0.6, 0.3)))


def test_the_page_says_the_largest_source_first(found, tmp_path):
    text = write_page(page_of(found), tmp_path).read_text()
    assert "cases have verdicts that differ" in text
    assert "figures/sources" in text
    assert text.index("what verdicts differ by") < text.index("| what differs")

"""Sources of differences between verdicts of real engines."""

import numpy as np
import pandas as pd
import pytest

from steadyload.layouts.model.question import Question
from steadyload.methods.tuned import tuned_engines
from steadyload.studies.engines import sources as module
from steadyload.studies.engines.sources import (
    ANSWERS,
    DESIGNS,
    Design,
    judged_by_designs,
    sources_of_differences,
)
from steadyload.studies.kit import Lab

BOTH = Design("lists", ("ps_opt",), (Question.WITHIN, Question.STANDS))


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, "DESIGNS", (BOTH,))
        patch.setattr(module, "tuned_engines", lambda: ("bullet", "mujoco"))
        work = tmp_path_factory.mktemp("sources")
        tables, again = (
            sources_of_differences({"lists": judged_by_designs(Lab(work, 0), "lists", 4)})
            for _ in range(2)
        )
    for table, other in zip(tables, again, strict=True):
        pd.testing.assert_frame_equal(table["shares"], other["shares"])
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
    assert [table["answer"] for table in found] == list(ANSWERS)
    for table in found:
        # Asked whether a load stands, one that rattles has no verdict: which ones, rounding says.
        assert table["cases"] + table["left_out"] == 12
        assert table["cases"] >= 9
        assert list(table["design"].levels) == ["engine", "question"]
        shares = table["shares"]
        assert list(shares["title"]) == ["engine", "question", "engine with question"]
        assert list(shares["freedom"]) == [1, 1, 1]
        if table["differing"]:
            assert sum(own.value for own in shares["whole"]) == pytest.approx(1.0)
            by_title = {row.title: row.whole.value for row in shares.itertuples()}
            assert table["largest"] == max(("engine", "question"), key=by_title.get)

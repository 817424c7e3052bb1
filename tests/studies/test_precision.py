"""The study of precision: its changes keep a verdict, and its page says who turned which."""

import math
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from steadyload.engines.registry import engines_here
from steadyload.methods import make_method
from steadyload.properties.closed_form_tests import ClosedFormResult, closed_form_tests
from steadyload.properties.closed_forms import Stage, fall
from steadyload.reports.pages.writing import write_page
from steadyload.runs.able import fixed_step_engines
from steadyload.runs.definition import StudyError
from steadyload.statistics.clusters import Clusters
from steadyload.studies.precision.changes import AS_IT_IS, CHANGES, DISTANCES, SCALES
from steadyload.studies.precision.comparing import Found, size_rows, summarise
from steadyload.studies.precision.judging import Answers, judge_changed, turned
from steadyload.studies.precision.sizes import EDGES, TESTS, ScaledStage, closed_forms_by_size
from steadyload.studies.precision.study import Precision


def page(rows, sizes):
    return Precision().page(Found(rows, 20, 20, size_rows(sizes), {}))


@pytest.mark.parametrize("change", CHANGES, ids=lambda change: change.name)
def test_a_change_keeps_shape_and_verdict_of_a_load(change, stack):
    """A double-precision engine says the same of a load that stands and of one that falls."""
    method = make_method(change.method("mujoco"))
    for shifts, step in (((0.0, 4.0), None), ((0.0, 6.0), 1)):
        layout = stack(*shifts)
        made = change.of(layout)
        assert np.allclose(made.sizes, change.scale * layout.sizes)
        apart = made.lower[1:] - made.lower[:-1]
        assert np.allclose(apart, change.scale * (layout.lower[1:] - layout.lower[:-1]))
        assert method.judge(made).failing_step == step


def test_a_scaled_loading_takes_as_many_substeps():
    for change in SCALES:
        parameters = make_method(change.method("mujoco")).parameters
        assert parameters.t_max * parameters.frequency == pytest.approx(144.0, rel=1e-12)
        assert parameters.eps_t == pytest.approx(10.0 * change.scale)


def test_engines_that_only_check_others_and_unknown_ones_are_left_out():
    assert "drake" not in engines_here()
    assert {"mujoco", "dart"} <= set(fixed_step_engines())
    assert not {"reference", "chipmunk", "drake"} & set(fixed_step_engines())
    with pytest.raises(StudyError, match="did you mean 'mujoco'"):
        fixed_step_engines(["mujocco"])


def test_cases_are_judged_under_every_change_and_kept(tmp_path):
    answers = judge_changed("lists", 2, tmp_path, only=["mujoco"], workers=0)
    assert set(answers.said) == set(CHANGES)
    for said in answers.said.values():
        assert list(said.columns) == ["mujoco"]
        assert said.index.equals(answers.cases.index)
        assert said["mujoco"].notna().all()
    (row,) = summarise(answers)
    assert row.accuracy["all"]["all"].n == 6
    assert not row.single
    rows = sum(len(list((tmp_path / c.name / "results").iterdir())) for c in CHANGES)
    again = judge_changed("lists", 2, tmp_path, only=["mujoco"], workers=0)
    assert again.said[AS_IT_IS].equals(answers.said[AS_IT_IS])
    assert sum(len(list((tmp_path / c.name / "results").iterdir())) for c in CHANGES) == rows


def test_a_verdict_that_is_lost_or_another_counts_as_turned(tmp_path):
    index = pd.Index([f"case {k}" for k in range(4)], name="case")
    same = pd.DataFrame({"mujoco": pd.array([1, 2, 3, 4], dtype="Int32")}, index=index)
    other = pd.DataFrame({"mujoco": pd.array([1, 2, 5, None], dtype="Int32")}, index=index)
    said = dict.fromkeys(CHANGES, same) | {DISTANCES[-1]: other}
    cases = pd.DataFrame(
        {
            "safe": [1, 2, 3, 5],
            "items": [5, 12, 20, 20],
            "height": [20.0, 40.0, 90.0, 100.0],
            "mass_ratio": [2.0, 50.0, 500.0, 3.0],
        },
        index=index,
    )
    answers = Answers(("mujoco",), said, cases, Clusters.of(None, 4))
    assert turned(answers, DISTANCES[-1], "mujoco").tolist() == [False, False, True, True]
    (row,) = summarise(answers)
    assert row.accuracy["all"]["all"].value == 0.75
    assert [share.n for share in row.accuracy["items"].values()] == [1, 1, 2]
    assert [share.n for share in row.accuracy["masses"].values()] == [2, 1, 1]
    sizes = closed_forms_by_size(["mujoco"], tmp_path / "sizes", workers=0)
    text = write_page(page([row], sizes), tmp_path).read_text()
    assert "No engine of single precision and one of double precision are" in text
    assert row.excess[DISTANCES[-1]].value == 0.0
    assert "moved 20 m" in text


def test_at_the_first_size_a_closed_form_is_as_it_is_and_mechanics_holds_at_all(tmp_path):
    """DART, in double precision, hardly notices the size."""
    known = {test.name: test for test in closed_form_tests()}
    found = closed_forms_by_size(["dart"], tmp_path, workers=0)
    assert set(found) == {(test, "dart", edge) for test in TESTS for edge in EDGES}
    plain = known["tipping offset"].measure(Stage("dart", 480))
    assert found["tipping offset", "dart", EDGES[0]].found == plain
    for edge in EDGES:
        assert abs(found["sliding threshold", "dart", edge].error) < 0.01
        assert abs(found["tipping offset", "dart", edge].error) < 0.02


def test_a_scaled_fall_is_the_fall_in_the_lengths_of_the_test():
    stage = ScaledStage("dart", 480, scale=100.0)
    assert fall(stage) == pytest.approx(fall(Stage("dart", 480)), rel=1e-7)
    assert math.isclose(stage.scale, EDGES[2] / EDGES[0])


def verdicts_of(single, double, monkeypatch):
    """Rows of an engine of single precision beside one of double, by verdicts that are turned.

    Args:
        single, double: by change, how many of 20 verdicts are turned; no other change turns any.
        monkeypatch: so that no engine need be installed.
    """
    monkeypatch.setattr(
        "steadyload.studies.precision.comparing.capabilities",
        lambda name: SimpleNamespace(single_precision=name == "single"),
    )
    index = pd.Index([f"case {k}" for k in range(20)], name="case")
    cases = pd.DataFrame(
        {"safe": 3, "items": 5, "height": 20.0, "mass_ratio": 2.0}, index=index
    )  # fmt: skip

    def said(turned):
        return pd.array([4] * turned + [3] * (20 - turned), dtype="Int32")

    changed = {
        change: pd.DataFrame(
            {"single": said(single.get(change, 0)), "double": said(double.get(change, 0))},
            index=index,
        )
        for change in CHANGES
    }
    return summarise(Answers(("single", "double"), changed, cases, Clusters.of(None, 20)))


def headline(rows):
    sizes = {
        (test, "single", edge): ClosedFormResult(test, "single", 480, 1.0, 0.0)
        for test in TESTS
        for edge in EDGES
    }
    return page(rows, sizes).summary


def test_the_headline_counts_what_single_precision_turns_beyond_double(monkeypatch):
    near, far, size = DISTANCES[0], DISTANCES[-1], SCALES[0]
    rows = verdicts_of({near: 1, far: 19, size: 11}, {near: 1, far: 2, size: 1}, monkeypatch)
    one, other = rows
    assert one.excess[far].value == pytest.approx(0.85)
    assert one.excess[near].value == 0.0
    assert one.excess[size].value == pytest.approx(0.5)
    assert other.excess[far].value == 0.0, "beside itself"
    text = headline(rows)
    assert text.startswith("On single 85.0 ")
    assert "origin of a world, and 0.0 " in text
    assert "the effect grows with the distance." in text
    assert f"where a load is {size.name}: 50.0 " in text


def test_an_engine_that_turns_fewer_than_double_precision_has_no_cost(monkeypatch):
    far = DISTANCES[-1]
    rows = verdicts_of({far: 1}, {far: 9}, monkeypatch)
    assert rows[0].excess[far].value == pytest.approx(-0.4)
    assert "On single -40.0 " in headline(rows)
    assert "no effect of single precision was measured" in headline(rows)


def test_an_engine_that_is_turned_at_any_distance_is_sensitive_to_rounding(monkeypatch):
    rows = verdicts_of(dict.fromkeys(DISTANCES, 12), dict.fromkeys(DISTANCES, 1), monkeypatch)
    assert "it is more sensitive to any rounding, at any distance." in headline(rows)

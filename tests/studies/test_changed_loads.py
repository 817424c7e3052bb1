"""Loads that are moved and scaled keep their verdict; the pages show which engine changes it."""

import math
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from steadyload.engines.registry import engines_here
from steadyload.methods import make_method
from steadyload.properties.closed_form_tests import closed_form_tests
from steadyload.properties.closed_forms import Stage, fall
from steadyload.runs.able import fixed_step_engines
from steadyload.runs.definition import StudyError
from steadyload.runs.provenance import provenance
from steadyload.statistics.clusters import Clusters
from steadyload.studies.changed_loads import (
    AS_IT_IS,
    DISTANCES,
    SCALES,
    Answers,
    judge_changed,
)
from steadyload.studies.engines.accuracy import summarised
from steadyload.studies.extremes.loads import Loads, summarise
from steadyload.studies.extremes.measuring import Outcome
from steadyload.studies.extremes.showing import shown
from steadyload.studies.extremes.sizes import EDGES, TESTS, ScaledStage, closed_forms_by_size
from steadyload.studies.extremes.study import Extremes
from steadyload.studies.extremes.sweeps import ExtremeCell
from steadyload.studies.kit import Lab

CHANGES = (AS_IT_IS, *DISTANCES, *SCALES)


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
    def judged():
        found = judge_changed(Lab(tmp_path, 0), ["mujoco"], 2, CHANGES, "loads")
        return found, sorted(tmp_path.glob("loads/*/results/*"))

    answers, shards = judged()
    assert set(answers.said) == set(CHANGES)
    for said in answers.said.values():
        assert list(said.columns) == ["mujoco"]
        assert said.index.equals(answers.cases.index)
        assert said["mujoco"].notna().all()
    assert len(answers.cases) == 6
    again, same = judged()
    assert again.said[AS_IT_IS].equals(answers.said[AS_IT_IS])
    assert same == shards


def test_a_verdict_that_is_lost_or_another_counts_as_changed():
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
    assert answers.changed(DISTANCES[-1], "mujoco").tolist() == [False, False, True, True]
    (row,) = summarise(answers)
    assert row.distances[DISTANCES[-1]].value == 0.5
    assert row.excess[DISTANCES[-1]].value == 0.0
    accuracy = summarised(answers)
    assert accuracy["whole"]["right"].iloc[0].value == 0.75
    assert (accuracy["single"], accuracy["cases"], accuracy["item_lists"]) == ([], 4, 4)
    for kind, counts in (("items", [1, 1, 2]), ("height", [1, 1, 2]), ("masses", [2, 1, 1])):
        shares = accuracy["groups"][kind].filter(like="engine_right:").iloc[0]
        assert [share.n for share in shares] == counts


def test_at_the_first_size_a_closed_form_is_as_it_is_and_mechanics_holds_at_all(tmp_path):
    """DART, in double precision, hardly notices the size."""
    known = {test.name: test for test in closed_form_tests()}
    found = closed_forms_by_size(Lab(tmp_path, 0), ["dart"], "sizes")
    assert [(row.test, row.edge) for row in found] == [(t, e) for t in TESTS for e in EDGES]
    by_test = {name: [row.errors["dart"] for row in found if row.test == name] for name in TESTS}
    plain = known["tipping offset"].measure(Stage("dart", 480))
    assert by_test["tipping offset"][0].found == plain
    for name, most in (("sliding threshold", 0.01), ("tipping offset", 0.02)):
        assert all(abs(result.error) < most for result in by_test[name])


def test_a_scaled_fall_is_the_fall_in_the_lengths_of_the_test():
    stage = ScaledStage("dart", 480, scale=100.0)
    assert fall(stage) == pytest.approx(fall(Stage("dart", 480)), rel=1e-7)
    assert math.isclose(stage.scale, EDGES[2] / EDGES[0])


def loads_of(single, double, monkeypatch):
    """An engine of single precision beside one of double, by verdicts that change.

    Args:
        single, double: by change, how many of 20 verdicts change; no other change changes any.
        monkeypatch: so that no engine need be installed.
    """
    monkeypatch.setattr(
        "steadyload.studies.extremes.loads.capabilities",
        lambda name: SimpleNamespace(single_precision=name == "single"),
    )
    index = pd.Index([f"case {k}" for k in range(20)], name="case")
    cases = pd.DataFrame({"safe": 3, "items": 5, "height": 20.0, "mass_ratio": 2.0}, index=index)

    def said(changed):
        return pd.array([4] * changed + [3] * (20 - changed), dtype="Int32")

    changed = {
        change: pd.DataFrame(
            {"single": said(single.get(change, 0)), "double": said(double.get(change, 0))},
            index=index,
        )
        for change in CHANGES
    }
    answers = Answers(("single", "double"), changed, cases, Clusters.of(None, 20))
    return Loads(summarise(answers), 20, 20, [])


NEAR, FAR, SIZE = DISTANCES[0], DISTANCES[-1], SCALES[0]


@pytest.mark.parametrize(
    ("single", "double", "excess", "has_cost", "grows"),
    [
        ({NEAR: 1, FAR: 19}, {NEAR: 1, FAR: 2}, 0.85, True, True),
        ({FAR: 1}, {FAR: 9}, -0.4, False, False),
        (dict.fromkeys(DISTANCES, 12), dict.fromkeys(DISTANCES, 1), 0.55, True, False),
    ],
    ids=["grows with the distance", "no cost", "at any distance"],
)
def test_what_changes_beyond_double_precision(single, double, excess, has_cost, grows, monkeypatch):
    one, other = loads_of(single, double, monkeypatch).rows
    assert one.excess[FAR].value == pytest.approx(excess)
    assert (one.has_cost, one.grows) == (has_cost, grows)
    assert other.excess[FAR].value == 0.0, "beside itself"


def test_the_page_of_extremes_shows_loads(monkeypatch):
    loads = loads_of({NEAR: 1, FAR: 19, SIZE: 11}, {NEAR: 1, FAR: 2, SIZE: 1}, monkeypatch)
    assert loads.dearest == SIZE
    numbers = {"found": 1.02, "expected": 1.0}
    cells = [ExtremeCell("sliding", "bullet", 240, 0.5, Outcome.CLOSE, numbers)]

    def section(loads):
        page = Extremes().page(shown(cells, provenance(), loads))
        *_, own, last = page.details
        assert own.title == "Loads far from the origin, and loads of other sizes"
        assert last.title == "Closed forms at three sizes"
        return "\n".join(map(str, own.placed))

    text = section(loads)
    assert text.startswith("On single 85.0 ")
    assert "origin of a world, and 0.0 " in text
    assert "the effect grows with the distance." in text
    assert f"where a load is {SIZE.name}: 50.0 " in text
    alone = Loads(loads.rows[1:], 20, 20, [])
    text = section(alone)
    assert text.startswith("No engine of single precision and one of double precision are")

"""A verdict as a line for people, and as values for programs."""

import json

import pytest

from steadyload.layouts import Item, Layout, Pallet
from steadyload.methods.contract.method import Status, Verdict
from steadyload.methods.registry import make_method


@pytest.mark.parametrize(("verdict", "line"), [
    (Verdict(20), "stands, all 20 items placed (score 1)"),
    (Verdict(20, failing_step=5), "fails at box 6 of 20 (score 0.25)"),
    (Verdict(20, failing_step=5, reason="item 4 tips"),
     "fails at box 6 of 20 (score 0.25): box 5 of 20 tips"),
    (Verdict(3, failing_step=2, moved_item=1, displacement=13.06, rotation=12.04, reason="long"),
     "fails at box 3 of 3 (score 0.667): box 2 of 3 moved 13.1 cm, 12.0 degrees"),
    (Verdict(20, Status.REFUSED, reason="too many items"),
     "no verdict, refused: too many items"),
    (Verdict(20, Status.TIMEOUT), "no verdict, timeout"),
])  # fmt: skip
def test_a_verdict_is_one_line(verdict, line):
    assert str(verdict) == line


def test_its_values_have_units_and_survive_json():
    items = tuple(
        Item(n, (40.0 + x, 10.0 * n, 40.0), (10, 10, 10), 1.0) for n, x in enumerate((0, 9))
    )
    said = make_method("ps_opt@mujoco").judge(Layout("falls", Pallet(100, 60, 100), items))
    values = said.to_dict()
    assert json.loads(json.dumps(values)) == values
    assert (values["items"], values["failing_step"], values["score"]) == (2, 1, 0.5)
    assert values["displacement_cm"] == said.displacement > 0.0
    assert values["cpu_seconds"] > 0.0


def test_one_without_an_answer_has_no_score():
    assert Verdict(2, Status.UNSETTLED).to_dict()["score"] is None

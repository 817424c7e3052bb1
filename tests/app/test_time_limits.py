"""Limits on time count what is judged, not what is compiled or loaded for it."""

from __future__ import annotations

import pytest

from steadyload.app import checking, repairs
from steadyload.layouts.model.layout import Item, Layout, Pallet

SIDE = (20.0, 20.0, 20.0)
BOXES = (Item(0, (0.0, 0.0, 0.0), SIDE, 5.0), Item(1, (15.0, 20.0, 0.0), SIDE, 5.0))
LEANS = Layout("leans", Pallet(100.0, 100.0, 100.0), BOXES)
SLOW = "harmful:harm=slow-start"
"""Takes 2 CPU seconds to be prepared, and none to judge."""


@pytest.mark.usefixtures("outside")
def test_a_method_that_takes_its_time_to_be_prepared_answers(monkeypatch):
    monkeypatch.setattr(checking, "_PATIENCE", 0.0)
    [one] = checking.check_all([("", LEANS)], SLOW, timeout=0.5, workers=1)
    assert (one.answer, one.reason) == (checking.Answer.STANDS, "")


@pytest.mark.usefixtures("outside")
def test_a_method_that_takes_its_time_to_be_prepared_confirms_a_repair(monkeypatch):
    monkeypatch.setattr(repairs, "_PATIENCE", 0.0)
    options = repairs.RepairOptions(method=SLOW, seconds=0.4)
    [one] = repairs.repair_all([("", LEANS)], options, workers=1)
    assert (one.outcome, one.reason) == (repairs.Outcome.UNCHANGED, "")

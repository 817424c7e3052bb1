"""Failing steps and items placed safely: one module turns one into the other."""

import re
from pathlib import Path

import pandas as pd
import pytest

from steadyload.methods.contract.verdict import Status, Verdict
from steadyload.statistics.placed import failing_step_of, items_placed, items_placed_by_case

ROOT = Path(__file__).parents[2]

SPELT_OUT = re.compile(
    r'failing_step\w*"\](\.astype\([^)]*\))?\s*\.fillna\((?!-1|False)'
    r"|if \S*failing_step is None else \S*failing_step(?!_)"
)


@pytest.mark.parametrize(("step", "placed"), [(None, 3), (0, 0), (2, 2)])
def test_a_failing_step_and_the_items_placed_say_the_same(step, placed):
    assert items_placed(step, 3) == placed
    assert failing_step_of(placed, 3) == step
    assert Verdict(3, failing_step=step).items_placed == placed
    assert Verdict(3, failing_step=step).score == placed / 3


def test_without_a_verdict_nothing_is_said_of_items():
    assert Verdict(3, Status.TIMEOUT).items_placed is None


@pytest.mark.parametrize("kind", ["Int16", "float32", "object"])
def test_a_column_has_the_items_placed_of_every_case(kind):
    steps = pd.Series([None, 0, 2], ["a", "b", "c"], dtype=kind)
    placed = items_placed_by_case(steps, pd.Series([300, 3, 3], steps.index, dtype="Int32"))
    assert placed.dtype == "int64"
    assert placed.to_dict() == {"a": 300, "b": 0, "c": 2}


def test_no_other_module_spells_it_out():
    home = ROOT / "harness" / "statistics" / "placed.py"
    found = [
        f"{path.relative_to(ROOT)}: {match[0]}"
        for folder in ("harness", "learners", "reports")
        for path in sorted((ROOT / folder).rglob("*.py"))
        if path != home
        for match in SPELT_OUT.finditer(path.read_text())
    ]
    assert found == []

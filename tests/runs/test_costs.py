"""Costs are medians of repetitions, in milliseconds, a row a case."""

import numpy as np
import pandas as pd
import pytest

from steadyload.runs.costs import CPU, WALL, CostKind, CostSource, judging_costs, timed_costs
from steadyload.runs.timing import Times

CASES = [("a", "s1"), ("a", "s2"), ("b", "s1")]
KEYS = ["layout", "scenario"]


def repeated(repetition, disturbed):
    """Seconds of two methods on three cases; in one repetition something else ran."""
    for method, seconds in (("fbs", 0.001), ("sme", 0.004)):
        for place, (layout, scenario) in enumerate(CASES):
            taken = seconds * (1 + place) + (1.0 if disturbed else 0.0)
            yield {
                "method": method, "layout": layout, "scenario": scenario, "repetition": repetition,
                "cpu_total": taken, "wall_total": 2 * taken, "cpu_step": taken / 2,
            }  # fmt: skip


@pytest.mark.parametrize("disturbed", [0, 1, 2])
def test_one_disturbed_repetition_of_three_costs_nothing(disturbed):
    rows = [row for k in range(3) for row in repeated(k, k == disturbed)]
    found = judging_costs(pd.DataFrame(rows), CostSource(CostKind.JUDGING))
    for method, milliseconds in (("fbs", [1.0, 2.0, 3.0]), ("sme", [4.0, 8.0, 12.0])):
        own = found.milliseconds[method]
        assert list(own.index) == CASES
        assert own[CPU].tolist() == pytest.approx(milliseconds)
        assert own[WALL].tolist() == pytest.approx([2 * ms for ms in milliseconds])
        assert own["cpu_step"].tolist() == pytest.approx([ms / 2 for ms in milliseconds])
    assert found.of("sme", "s1")[CPU].tolist() == pytest.approx([4.0, 12.0])
    assert found.of("sme", "s3") is None
    assert found.of("pbs") is None


def test_timed_costs_are_medians_over_repeats_of_each_clock():
    cpu = {"fbs": np.array([[1.0, 2.0, 3.0], [1.0, 2.0, 90.0], [80.0, 2.5, 3.0]])}
    wall = {"fbs": np.array([[5.0, 6.0, 7.0], [5.0, 70.0, 7.0], [5.0, 6.0, 7.5]])}
    found = timed_costs(Times(cpu, wall, 1.2), pd.MultiIndex.from_tuples(CASES, names=KEYS))
    assert found.milliseconds["fbs"][CPU].tolist() == [1.0, 2.0, 3.0]
    assert found.milliseconds["fbs"][WALL].tolist() == [5.0, 6.0, 7.0]
    assert (found.source.kind, found.source.cases, found.source.load) == (CostKind.TIMED, 3, 1.2)
    # The means of the repeats are 2, 31 and 28.5 ms.
    assert found.source.spread == 31.0 / 2.0
    assert "differs by a factor of up to 15.50." in found.source.explained()


def test_one_repeat_has_no_spread_of_repeats():
    once = Times({"fbs": np.array([[1.0, 2.0, 90.0]])}, {"fbs": np.ones((1, 3))}, 1.2)
    source = timed_costs(once, pd.MultiIndex.from_tuples(CASES, names=KEYS)).source
    assert source.spread is None
    assert "repeat" not in source.explained()

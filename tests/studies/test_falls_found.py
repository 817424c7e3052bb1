"""Falls that methods find, and false alarms, by origin, against cases counted by hand."""

from types import SimpleNamespace

import pandas as pd
import pytest

from steadyload.layouts.benchmark.real import PALLET_SOFTWARE
from steadyload.methods.naming import method_key
from steadyload.methods.registry import make_method
from steadyload.studies.evaluation.delivered import CUSTOMERS, PACKERS
from steadyload.studies.evaluation.falls import ROBUST, falls_found

SPECS = ("sme", "fbs")
CASES = {
    # name: (source, label, robust, steps that the two methods name)
    "a": (PALLET_SOFTWARE, 3, True, (3, None)),
    "b": (PALLET_SOFTWARE, 5, False, (4, None)),  # a wrong step is a fall that is found, too
    "c": (PALLET_SOFTWARE, None, True, (None, 2)),
    "d": (PALLET_SOFTWARE, None, True, (None, None)),
    "e": ("py3dbp", 1, True, (None, 1)),
    "f": ("py3dbp", None, False, (6, 6)),
    "g": ("py3dbp", 2, None, ("none", 2)),  # the first has no verdict
}


def judged(cases):
    index = pd.MultiIndex.from_tuples(
        [(name, "S1") for name in cases], names=["layout", "scenario"]
    )
    labels = pd.DataFrame(
        {"failing_step": pd.array([label for _, label, *_ in cases.values()], dtype="Int64")}, index
    )
    rows = [
        {"layout": name, "scenario": "S1", "method": spec, "failing_step": said[place]}
        for place, spec in enumerate(SPECS)
        for name, (*_, said) in reversed(cases.items())
        if said[place] != "none"
    ]
    return SimpleNamespace(
        labels=labels, said=pd.DataFrame(index=index), results=pd.DataFrame(rows),
        keys={spec: method_key(make_method(spec)) for spec in SPECS},
        clusters=pd.Series([*cases], index=index),
    )  # fmt: skip


def evaluated(cases):
    accuracy = {spec: SimpleNamespace(accuracy=spec) for spec in SPECS}
    return SimpleNamespace(judged=judged(cases), row=accuracy.get)


def set_of(cases, robust=True):
    layouts = pd.DataFrame({"sources": [[source] for source, *_ in cases.values()]}, [*cases])
    index = judged(cases).said.index
    values = [own for _, _, own, _ in cases.values()]
    known = pd.DataFrame({"robust": pd.array(values, dtype="boolean")}, index)
    return SimpleNamespace(
        layouts=layouts, confidence_on=lambda _: known if robust else known.assign(robust=pd.NA)
    )


def test_falls_and_false_alarms_are_counted_by_origin():
    first, second = falls_found(evaluated(CASES), set_of(CASES), "stands")
    found = {name: (each.value, each.n) for name, each in first.found.items()}
    assert found == {CUSTOMERS: (1.0, 2), PACKERS: (0.0, 2), ROBUST: (0.5, 2)}
    assert first.alarms == {CUSTOMERS: "0 of 2", PACKERS: "1 of 1"}
    assert (first.accuracy, second.accuracy) == SPECS
    found = {name: (each.value, each.n) for name, each in second.found.items()}
    assert found == {CUSTOMERS: (0.0, 2), PACKERS: (1.0, 2), ROBUST: (0.5, 2)}
    assert second.alarms == {CUSTOMERS: "1 of 2", PACKERS: "1 of 1"}


def test_without_a_judge_of_robustness_there_are_no_robust_falls():
    for row in falls_found(evaluated(CASES), set_of(CASES, robust=False), "stands"):
        assert set(row.found) == {CUSTOMERS, PACKERS}


@pytest.mark.parametrize("names", ["efg", ""])
def test_without_customers_pallets_there_is_nothing_to_count(names):
    cases = {name: CASES[name] for name in names or "e"}
    assert falls_found(evaluated(cases), set_of(cases), "stands") == []

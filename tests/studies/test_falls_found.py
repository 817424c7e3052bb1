"""Falls that methods find, and false alarms, by origin, against cases counted by hand."""

import numpy as np
import pandas as pd
import pytest

from steadyload.studies.evaluation.places import ROBUST, falls
from steadyload.studies.evaluation.verdicts import CUSTOMERS, PACKERS

SPECS = ("sme", "fbs")
ROWS = pd.DataFrame({"title": ["SME", "FBS"], "right": [None, None]}, list(SPECS))
CASES = {
    # name: (origin, label, robust, steps that the two methods name)
    "a": (CUSTOMERS, 3, True, (3, None)),
    "b": (CUSTOMERS, 5, False, (4, None)),  # a wrong step is a fall that is found, too
    "c": (CUSTOMERS, None, True, (None, 2)),
    "d": (CUSTOMERS, None, True, (None, None)),
    "e": (PACKERS, 1, True, (None, 1)),
    "f": (PACKERS, None, False, (6, 6)),
    "g": (PACKERS, 2, False, (None, 2)),  # the first has no verdict
}


def frame_of(cases):
    return pd.DataFrame(
        [
            {"layout": name, "scenario": "S1", "method": spec, "cluster": name, "origin": origin,
             "stable": label is None, "robust": robust, "said_to_fail": said[place] is not None}
            for place, spec in enumerate(SPECS)
            for name, (origin, label, robust, said) in cases.items()
        ]
    )  # fmt: skip


def test_falls_and_false_alarms_are_counted_by_origin():
    found = falls(frame_of(CASES), ROWS)
    assert [c for c in found if ":" in c] == [
        f"found:{CUSTOMERS}", f"found:{PACKERS}", f"found:{ROBUST}",
        f"false_alarms:{CUSTOMERS}", f"false_alarms:{PACKERS}",
    ]  # fmt: skip
    shares = {
        spec: [(row[f"found:{name}"].value, row[f"found:{name}"].n)
               for name in (CUSTOMERS, PACKERS, ROBUST)]
        for spec, row in found.iterrows()
    }  # fmt: skip
    assert shares == {
        "sme": [(1.0, 2), (0.0, 2), (0.5, 2)], "fbs": [(0.0, 2), (1.0, 2), (0.5, 2)],
    }  # fmt: skip
    alarms = found[[f"false_alarms:{CUSTOMERS}", f"false_alarms:{PACKERS}"]].to_numpy().tolist()
    assert alarms == [["0 of 2", "1 of 1"], ["1 of 2", "1 of 1"]]


def test_without_a_judge_of_robustness_there_are_no_robust_falls():
    found = falls(frame_of(CASES).assign(robust=False), ROWS)
    assert f"found:{ROBUST}" not in found
    assert f"found:{CUSTOMERS}" in found


@pytest.mark.parametrize("names", ["efg", "e"])
def test_without_customers_pallets_there_is_nothing_to_count(names):
    frame = frame_of({name: CASES[name] for name in names})
    assert falls(frame.assign(origin=np.full(len(frame), None)), ROWS).empty

"""What is stored and is no method stays valid because these hold: see ``docs/studies.md``."""

import json
import math

import pytest
from computations import FILE, computed
from verdicts import FOLDER, machine, read

_SURE = 1e-6
"""Relative; rounding on another kind of machine."""


@pytest.fixture(scope="module")
def now():
    return computed()


@pytest.mark.exact("what is kept was computed from planned starts")
@pytest.mark.parametrize(
    ("kind", "version"),
    [
        ("labels", "methods/simulation/trace.py or labelling/label_rows.py"),
        ("features", "learners/features.py"),
        ("extremes", "studies/extremes/measuring.py or sweeps.py"),
        ("closed forms", "properties/closed_forms.py"),
        ("certainty", "runs/verdict_reliability.py or studies/uncertain/cases.py"),
        ("properties", "properties/search.py, or of the property"),
        ("proposals", "tuning/proposers.py"),
    ],
)
def test_what_is_computed_is_what_was_kept(kind, version, now):
    same_machine = read(FOLDER / "quick.parquet")[1] == machine()
    kept = json.loads(FILE.read_text())[kind]
    assert same(kept, now[kind], exact=same_machine), (
        f"{kind} are others now: mend the code, or raise VERSION in {version} and record anew: "
        "python tests/golden/record.py"
    )


def same(one, other, *, exact):
    """Equal; floats to rounding where not exact."""
    if isinstance(one, dict):
        return one.keys() == other.keys() and all(same(one[k], other[k], exact=exact) for k in one)
    if isinstance(one, list):
        return len(one) == len(other) and all(
            same(a, b, exact=exact) for a, b in zip(one, other, strict=True)
        )
    if isinstance(one, float) and isinstance(other, float) and not exact:
        return math.isclose(one, other, rel_tol=_SURE, abs_tol=_SURE)
    return one == other


def test_floats_may_differ_by_rounding_on_another_machine_only():
    assert same({"a": [1.0, 2]}, {"a": [1.0 + 1e-9, 2]}, exact=False)
    assert not same({"a": [1.0, 2]}, {"a": [1.0 + 1e-9, 2]}, exact=True)
    assert not same({"a": [1.0, 2]}, {"a": [1.0, 3]}, exact=False)

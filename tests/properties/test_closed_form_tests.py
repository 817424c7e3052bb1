"""Closed forms: an engine that keeps to them measures what they say."""

import pytest

from steadyload.properties.closed_form_tests import closed_form_tests
from steadyload.properties.closed_forms import Stage

TESTS = {test.name: test for test in closed_form_tests()}


@pytest.mark.parametrize(
    ("name", "within"),
    [
        ("free fall", 5.0),
        ("sliding distance", 0.01),
        ("sliding threshold", 0.002),
        ("creep", 2.0),
        ("tipping offset", 0.5),
        ("time to 10 degrees, 10 mm", 0.002),
        ("time to 10 degrees, 1 mm", 0.01),
        ("overhang of 2", 0.01),
        ("rocking from 0.5 alpha", 0.002),
        ("energy after rocking from 0.5 alpha", 0.02),
        ("overturning by a pulse of 0.5 s", 0.01),
    ],
)
def test_mujoco_at_960_hz_comes_near_to_a_closed_form(name, within):
    found = TESTS[name].measure(Stage("mujoco", 960))
    assert found == pytest.approx(TESTS[name].expected, abs=within)

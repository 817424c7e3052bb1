"""Forms of numbers in cells and sentences."""

import math

import pytest

from steadyload.reports.table import MISSING, least_shown


@pytest.mark.parametrize(
    ("difference", "shown"),
    [(0.0123, "1.2"), (None, MISSING), (0.0, MISSING), (math.inf, MISSING), (math.nan, MISSING)],
)
def test_a_least_difference_is_in_points_and_missing_where_cases_show_none(difference, shown):
    assert least_shown(difference) == shown

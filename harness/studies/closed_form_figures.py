"""Charts of errors in closed forms, and columns of their tables, for a page without a template."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from steadyload.properties.closed_form_tests import ClosedFormResult, ClosedFormTest
from steadyload.reports.charts.curves import curves
from steadyload.reports.table import Column, words
from steadyload.studies.closed_form_errors import (
    OWN_STEPS,
    errors_by_argument,
    errors_by_frequency,
    hertz,
)

__all__ = [
    "ENGINE", "OWN_STEPS", "SUBSTEPS", "hertz", "plot_closed_form_series", "plot_closed_forms",
]  # fmt: skip

ENGINE = words("engine")
SUBSTEPS = Column("substeps", "frequency", hertz)

_LINES: dict[str, Any] = {
    "look": "engine", "of": "engine", "dash": "own_steps", "hollow": "is_negative",
    "limit": "limit", "panel": "panel",
}  # fmt: skip


def plot_closed_forms(tests: Sequence[ClosedFormTest], results: Sequence[ClosedFormResult]) -> Any:
    """Size of the error against frequency, a panel a test, all axes logarithmic."""
    return curves(
        errors_by_frequency(tests, results), "place", "size", **_LINES, across=3, own_y=True,
        apart=True, log="xy", ticks="apart", x_label="substeps a second (Hz)",
        y_label="size of the error", size=(9.6, 0.8 + 2.6 * math.ceil(len(tests) / 3)),
    ).figure  # fmt: skip


def plot_closed_form_series(
    tests: Sequence[ClosedFormTest], results: Sequence[ClosedFormResult]
) -> Any:
    """Size of the error against the number in which tests differ, a panel a frequency."""
    points, first = errors_by_argument(tests, results), tests[0]
    wide = (tests[-1].argument or 0.0) > 10 * (first.argument or 0.0)
    return curves(
        points, "place", "size", **_LINES, log="xy" if wide else "y", ticks="apart",
        x_label=first.argument_name, y_label=f"size of the error ({first.error_unit})",
        size=(3.2 * len({point.panel for point in points}), 3.2),
    ).figure  # fmt: skip

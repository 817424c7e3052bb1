"""Errors of engines in tests of closed forms, as points of charts."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple

from steadyload.properties.closed_form_tests import ClosedFormResult, ClosedFormTest

OWN_STEPS = "own"
"""Text for the frequency of an engine that chooses its own steps."""


def hertz(frequency: int | None) -> str:
    """A frequency, or that the engine chooses its own steps."""
    return OWN_STEPS if frequency is None else f"{frequency} Hz"


class ErrorPoint(NamedTuple):
    """The size of an error at its place in a chart.

    ``place``: substeps a second, or the argument of the test. ``size``: of the error, in its unit,
    at least what the test resolves. ``limit``: what the tests of the panel resolve; None where no
    error is smaller. ``own_steps``: the engine chooses its steps.
    """

    panel: str
    title: str
    engine: str
    own_steps: bool
    place: float
    size: float
    is_negative: bool
    limit: float | None


def errors_by_frequency(
    tests: Sequence[ClosedFormTest], results: Sequence[ClosedFormResult]
) -> list[ErrorPoint]:
    """Points over substeps a second, a panel a test.

    An engine that chooses its own steps has the same error at every frequency of the others.
    """
    frequencies = _frequencies(results)
    points = []
    for test in tests:
        argument = "" if test.argument is None else f": {test.argument_name} {test.argument:g}"
        unit = f" ({test.error_unit})" if test.error_unit else ""
        mine = [r for r in results if r.test == test.name]
        points += [
            _point(f"{test.series}{argument}{unit}", place, test, r, mine)
            for r in mine
            if r.error is not None
            for place in (frequencies if r.frequency is None else [r.frequency])
        ]
    return points


def errors_by_argument(
    tests: Sequence[ClosedFormTest], results: Sequence[ClosedFormResult]
) -> list[ErrorPoint]:
    """Points over the number in which tests differ, a panel a frequency.

    An engine that chooses its own steps is in every panel.
    """
    by_name = {test.name: test for test in tests}
    mine = [r for r in results if r.test in by_name]
    panels: list[int | None] = [*_frequencies(results)] or [None]
    return [
        _point("own steps" if panel is None else hertz(panel), test.argument or 0.0, test, r, mine)
        for panel in panels
        for r in mine
        if r.error is not None and r.frequency in (panel, None)
        for test in [by_name[r.test]]
    ]


def _frequencies(results: Iterable[ClosedFormResult]) -> list[int]:
    return sorted({r.frequency for r in results if r.frequency is not None})


def _point(
    panel: str,
    place: float,
    test: ClosedFormTest,
    result: ClosedFormResult,
    shown: Sequence[ClosedFormResult],
) -> ErrorPoint:
    error, own, least = result.error or 0.0, result.frequency is None, test.resolution
    is_limit = any(r.error is not None and abs(r.error) < least for r in shown)
    return ErrorPoint(
        panel, f"{result.engine} (own steps)" if own else result.engine, result.engine, own, place,
        max(abs(error), least), error < 0.0, least if is_limit else None,
    )  # fmt: skip

"""Errors of engines, test by test, and how many tests every engine meets."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from types import MappingProxyType, SimpleNamespace
from typing import NamedTuple

from steadyload.properties.closed_form_tests import (
    ClosedFormResult,
    ClosedFormTest,
    closed_form_tests,
    rocking_tests,
)
from steadyload.reports.columns import cell, column, compact, general, row
from steadyload.studies.closed_form_errors import (
    OWN_STEPS,
    ErrorPoint,
    errors_by_argument,
    errors_by_frequency,
    hertz,
)

_RIGHT_WITHIN = 1.0
"""Error up to which an engine counts as right: in per cent of what is expected, and in the unit of
a test (mm or degrees) whose errors are not relative."""


class Score(NamedTuple):
    """How many of the tests that are defined for an engine it meets at its highest frequency."""

    engine: str
    frequency: str
    right: int
    of: int

    @property
    def share(self) -> float:
        """Of the tests, those that it meets."""
        return self.right / self.of


@row
class Errors:
    """Errors in a test, by engine at its highest frequency."""

    test: str = column()
    unit: str = column("error in")
    errors: Mapping[str, str] = column("{}")


@row
class Rocked:
    """Of every series of a rocking block, the largest error of an engine at a frequency, in %."""

    engine: str = column()
    frequency: int | None = column("substeps", hertz)
    errors: Mapping[str, str] = column("{}")


@row
class Beaten:
    """A test in which an engine that chooses its own steps is not the best, and why."""

    test: str = column()
    engine: str = column()
    error: str = column()
    best: str = column("best other")
    unit: str = column("in")
    why: str = column()


@row
class Run:
    """A value found by an engine at a frequency, and its errors in all tests of the series."""

    engine: str = column()
    frequency: int | None = column("substeps", hertz)
    found: float | None = column("found", general)
    error: str = column(left=False)
    errors: Mapping[str, str] = column("{}")


@row
class Series:
    """Tests that differ in one number, or a single one, with their results."""

    tests: Sequence[ClosedFormTest]
    runs: Sequence[Run]
    points: Sequence[ErrorPoint]

    @property
    def first(self) -> ClosedFormTest:
        """The first test."""
        return self.tests[0]

    @property
    def is_wide(self) -> bool:
        """Whether the number spans more than a decade."""
        return (self.tests[-1].argument or 0.0) > 10 * (self.first.argument or 0.0)


class Found(SimpleNamespace):
    """All that the page shows."""

    scores: Sequence[Score]
    overview: Sequence[Errors]
    rocked: Sequence[Rocked]
    points: Sequence[ErrorPoint]
    beaten: Sequence[Beaten]
    series: Sequence[Series]
    made_with: Mapping[str, str]


def compare(
    results: Sequence[ClosedFormResult],
    made_with: Mapping[str, str],
    left_out: Mapping[str, str] = MappingProxyType({}),
) -> Found:
    """Results beside what is expected; tests without any result are left out.

    Args:
        results: of engines, test by test.
        made_with: versions of what measured them.
        left_out: by name of an engine that was wanted, the reason why it was not measured.
    """
    measured = {r.test for r in results}
    tests = [test for test in closed_form_tests() if test.name in measured]
    series: dict[str, list[ClosedFormTest]] = {}
    for test in tests:
        series.setdefault(test.series, []).append(test)
    middle = [group[len(group) // 2] for group in series.values()]
    return Found(
        scores=_scores(tests, results),
        overview=_overview(tests, results),
        rocked=_rocked(results),
        points=errors_by_frequency(middle, results),
        beaten=list(_beaten(tests, results)),
        series=[_series(group, results) for group in series.values()],
        made_with=made_with,
        left_out=left_out,
        right_within=_RIGHT_WITHIN,
        own_steps=OWN_STEPS,
    )


def _scores(tests: Sequence[ClosedFormTest], results: Sequence[ClosedFormResult]) -> list[Score]:
    known, scores = {test.name: test for test in tests}, []
    for engine, finest in _finest_of(results).items():
        asked = [r for r in results if (r.engine, r.frequency) == (engine, finest) and r.defined]
        right = sum(_is_right(known[r.test], r) for r in asked)
        scores.append(Score(engine, hertz(finest), right, len(asked)))
    return scores


def _is_right(test: ClosedFormTest, result: ClosedFormResult) -> bool:
    if result.error is None:
        return False
    share = 0.0 if test.relative else abs(test.expected) * _RIGHT_WITHIN / 100.0
    return abs(result.error) <= max(_RIGHT_WITHIN, share, test.resolution)


def _overview(tests: Sequence[ClosedFormTest], results: Sequence[ClosedFormResult]) -> list[Errors]:
    found = {(r.test, r.engine, r.frequency): r for r in results}
    finest = _finest_of(results)
    return [
        Errors(
            test.name,
            test.error_unit,
            {
                f"{engine}, {hertz(frequency)}": _error(
                    test, found.get((test.name, engine, frequency))
                )
                for engine, frequency in finest.items()
            },
        )
        for test in tests
    ]


def _rocked(results: Sequence[ClosedFormResult]) -> list[Rocked]:
    found = {(r.test, r.engine, r.frequency): r for r in results}
    series: dict[str, list[ClosedFormTest]] = {}
    for test in rocking_tests():
        series.setdefault(test.series, []).append(test)

    def largest(tests: Sequence[ClosedFormTest], engine: str, frequency: int | None) -> str:
        own = [found[test.name, engine, frequency] for test in tests]
        first, *_ = sorted(own, key=lambda r: (r.error is not None, -_size(r)))
        return _error(tests[0], first)

    return [
        Rocked(
            engine,
            frequency,
            {name: largest(tests, engine, frequency) for name, tests in series.items()},
        )
        for engine, frequency in dict.fromkeys((r.engine, r.frequency) for r in results)
        if all((t.name, engine, frequency) in found for tests in series.values() for t in tests)
    ]


def _beaten(
    tests: Sequence[ClosedFormTest], results: Sequence[ClosedFormResult]
) -> Iterable[Beaten]:
    for test in tests:
        mine = [r for r in results if r.test == test.name and r.error is not None]
        fixed = [r for r in mine if r.frequency is not None]
        finest = _finest(fixed)
        others = [r for r in fixed if r.frequency == finest]
        best = min(others, key=_size, default=None)
        for r in mine:
            if best and r.frequency is None and _size(r) > max(_size(best), test.resolution):
                beaten_by = f"{_error(test, best)} ({best.engine}, {hertz(finest)})"
                yield Beaten(
                    test.name, r.engine, _error(test, r), beaten_by, test.error_unit, test.when_soft
                )


def _series(tests: Sequence[ClosedFormTest], results: Sequence[ClosedFormResult]) -> Series:
    first, found = tests[0], {(r.test, r.engine, r.frequency): r for r in results}
    runs = [
        Run(
            r.engine,
            r.frequency,
            r.found,
            _error(first, r),
            {
                f"{test.argument_name} {test.argument:g}": _error(
                    test, found.get((test.name, r.engine, r.frequency))
                )
                for test in tests
                if test.argument is not None
            },
        )
        for r in results
        if r.test == first.name
    ]
    return Series(tests, runs, errors_by_argument(tests, results) if len(tests) > 1 else [])


def _error(test: ClosedFormTest, result: ClosedFormResult | None) -> str:
    """The error as text, the reason why there is none, or that it is below the resolution."""
    if result is None:
        return cell(None)
    if result.error is None:
        return result.note
    return f"< {test.resolution:g}" if _size(result) < test.resolution else compact(result.error)


def _size(result: ClosedFormResult) -> float:
    return abs(result.error or 0.0)


def _finest_of(results: Sequence[ClosedFormResult]) -> dict[str, int | None]:
    """The highest frequency of every engine."""
    engines = dict.fromkeys(r.engine for r in results)
    return {engine: _finest(r for r in results if r.engine == engine) for engine in engines}


def _finest(results: Iterable[ClosedFormResult]) -> int | None:
    """The highest frequency; None for an engine that chooses its own steps."""
    return max((r.frequency for r in results if r.frequency is not None), default=None)

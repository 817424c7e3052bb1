"""The page that compares engines with mechanics."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from steadyload.properties.closed_form_tests import ClosedFormResult, ClosedFormTest
from steadyload.reports.pages.page import Page, Picture, Section
from steadyload.reports.table import MISSING, Column, Table, columns_for, compact, words
from steadyload.studies.closed_form_figures import (
    ENGINE,
    OWN_STEPS,
    SUBSTEPS,
    hertz,
    plot_closed_form_series,
    plot_closed_forms,
)

_RIGHT_WITHIN = 1.0
"""Error up to which an engine counts as right: in per cent of what is expected, and in the unit of
a test (mm or degrees) whose errors are not relative."""


def closed_forms_page(
    tests: Sequence[ClosedFormTest],
    results: Sequence[ClosedFormResult],
    manifest: Mapping[str, str],
) -> Page:
    """Compose the page; tests without any result are left out."""
    measured = {r.test for r in results}
    shown = [t for t in tests if t.name in measured]
    series: dict[str, list[ClosedFormTest]] = {}
    for test in shown:
        series.setdefault(test.series, []).append(test)
    sections = [_overview(shown, list(series.values()), results)] if shown else []
    behind = _behind(shown, results)
    if behind:
        sections.append(behind)
    sections += [
        _family(group, results) if len(group) > 1 else _single(group[0], results)
        for group in series.values()
    ]
    return Page(
        "Engines against mechanics",
        f"{_answer(shown, results)}Single bodies and small stacks whose motion follows from a "
        "formula, or from an equation of motion solved to 1e-12, at equal SI values and every "
        "engine's settings for contacts as they are. An error is what was found minus what is "
        "expected, in the unit given, or in per cent of what is expected. Engines run at fixed "
        f"substeps a second (Hz), except those that choose their own steps (`{OWN_STEPS}`). "
        "Nothing here is drawn by chance, so there are no intervals; a bisection ends at the "
        "resolution named with its test.",
        sections,
        manifest,
    )


def _answer(tests: Sequence[ClosedFormTest], results: Sequence[ClosedFormResult]) -> str:
    """Sentence on how many tests every engine meets at its highest frequency."""
    known = {test.name: test for test in tests}
    met = []
    for engine in dict.fromkeys(r.engine for r in results):
        own = [r for r in results if r.engine == engine]
        finest = _finest(own)
        asked = [r for r in own if r.frequency == finest and r.test in known and r.defined]
        right = sum(_is_right(known[r.test], r) for r in asked)
        met.append(f"{engine} ({hertz(finest)}) {right} of {len(asked)}")
    if not met:
        return ""
    return (
        f"Within {_RIGHT_WITHIN:g} % of mechanics, or {_RIGHT_WITHIN:g} mm or degree where errors "
        f"are not relative, come {', '.join(met)} of the tests that are defined for them.\n\n"
    )


def _is_right(test: ClosedFormTest, result: ClosedFormResult) -> bool:
    if result.error is None:
        return False
    share = 0.0 if test.relative else abs(test.expected) * _RIGHT_WITHIN / 100.0
    return abs(result.error) <= max(_RIGHT_WITHIN, share, test.resolution)


def _overview(
    tests: Sequence[ClosedFormTest],
    series: Sequence[Sequence[ClosedFormTest]],
    results: Sequence[ClosedFormResult],
) -> Section:
    engines = list(dict.fromkeys(r.engine for r in results))
    finest = {e: _finest(r for r in results if r.engine == e) for e in engines}
    cells = {(r.test, r.engine): r for r in results if r.frequency == finest[r.engine]}
    columns = [
        words("test", "name"),
        words("error in", "error_unit"),
        *columns_for(
            engines,
            lambda engine: f"{engine}, {hertz(finest[engine])}",
            lambda test, engine: _error(test, cells.get((test.name, engine))),
        ),
    ]
    return Section(
        "Overview",
        "Errors at the highest frequency. How each test is defined, and all frequencies, below.",
        [Table(tests, columns)],
        [
            Picture(
                "closed-forms",
                plot_closed_forms([group[len(group) // 2] for group in series], results),
                "Size of the error against frequency, log axes: filled markers are positive "
                "errors, hollow ones negative, dashed lines engines that choose their own steps. "
                "Errors below what a test resolves stand on a dotted line. Engines are set a "
                "little apart, so that equal ones are seen. Of a series, the test in its middle.",
            )
        ],
    )


def _behind(tests: Sequence[ClosedFormTest], results: Sequence[ClosedFormResult]) -> Section | None:
    """Tests in which an engine that chooses its own steps is not the best, with the reason."""
    rows = []
    for test in tests:
        own = [r for r in results if r.test == test.name]
        fixed = [r for r in own if r.frequency is not None and r.error is not None]
        finest = _finest(fixed)
        others = [r for r in fixed if r.frequency == finest]
        best = min(others, key=lambda r: abs(r.error or 0.0), default=None)
        for r in own:
            if r.frequency is not None or r.error is None or best is None or best.error is None:
                continue
            if abs(r.error) > max(abs(best.error), test.resolution):
                beaten = f"{_error(test, best)} ({best.engine}, {hertz(finest)})"
                rows.append(
                    (test.name, r.engine, _error(test, r), beaten, test.error_unit, test.when_soft)
                )
    if not rows:
        return None
    titles = ("test", "engine", "error", "best other", "in", "why")
    return Section(
        "Where an engine with steps of its own is not the best",
        "Its error is then the model's, not the integrator's.",
        [Table(rows, [words(title, k) for k, title in enumerate(titles)])],
    )


def _single(test: ClosedFormTest, results: Sequence[ClosedFormResult]) -> Section:
    found = f"found ({test.unit})" if test.unit else "found"
    columns = [
        ENGINE,
        SUBSTEPS,
        Column(found, lambda r: MISSING if r.found is None else f"{r.found:.6g}"),
        Column(f"error ({test.error_unit})", lambda r: _error(test, r)),
    ]
    text = f"{test.definition} Expected: {f'{test.expected:.6g} {test.unit}'.strip()}."
    return Section(test.series, text, [Table([r for r in results if r.test == test.name], columns)])


def _family(tests: Sequence[ClosedFormTest], results: Sequence[ClosedFormResult]) -> Section:
    first = tests[0]
    found = {(r.test, r.engine, r.frequency): r for r in results}
    columns = [
        ENGINE,
        SUBSTEPS,
        *columns_for(
            tests,
            lambda t: f"{t.argument_name} {t.argument:g}",
            lambda r, t: _error(t, found.get((t.name, r.engine, r.frequency))),
        ),
    ]
    text = (
        f"{first.definition} Expected: {f'{first.expected:g} {first.unit}'.strip()}. Cells are "
        f"errors in {first.error_unit}."
    )
    runs = [r for r in results if r.test == first.name]
    file = first.series.lower().replace(" ", "-")
    caption = f"{first.series}: size of the error against {first.argument_name}."
    picture = Picture(file, plot_closed_form_series(tests, results), caption)
    return Section(first.series, text, [Table(runs, columns)], [picture])


def _error(test: ClosedFormTest, result: ClosedFormResult | None) -> str:
    """The error as text, the reason why there is none, or that it is below the resolution."""
    if result is None:
        return MISSING
    if result.error is None:
        return result.note
    if abs(result.error) < test.resolution:
        return f"< {test.resolution:g}"
    return compact(result.error)


def _finest(results: Iterable[ClosedFormResult]) -> int | None:
    """The highest frequency; None for an engine that chooses its own steps."""
    return max((r.frequency for r in results if r.frequency is not None), default=None)

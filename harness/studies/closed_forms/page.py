"""The page that compares engines with mechanics."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from steadyload.reports.page import Page, Picture, Section
from steadyload.reports.table import MISSING, compact, markdown_table
from steadyload.studies.closed_forms.figures import (
    plot_closed_form_series,
    plot_closed_forms,
)
from steadyload.studies.closed_forms.records import ClosedFormResult, ClosedFormTest

_OWN = "own"
"""Text for the frequency of an engine that chooses its own steps."""


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
        "Single bodies and small stacks whose motion follows from a formula, or from an equation "
        "of motion solved to 1e-12, at equal SI values and every engine's settings for contacts as "
        "they are. An error is what was found minus what is expected, in the unit given, or in per "
        "cent of what is expected. Engines run at fixed substeps a second (Hz), except those that "
        f"choose their own steps (`{_OWN}`). Nothing here is drawn by chance, so there are no "
        "intervals; a bisection ends at the resolution named with its test.",
        sections,
        manifest,
    )


def _overview(
    tests: Sequence[ClosedFormTest],
    series: Sequence[Sequence[ClosedFormTest]],
    results: Sequence[ClosedFormResult],
) -> Section:
    engines = list(dict.fromkeys(r.engine for r in results))
    finest = {e: _finest(r for r in results if r.engine == e) for e in engines}
    cells = {(r.test, r.engine): r for r in results if r.frequency == finest[r.engine]}
    rows = [
        (
            test.name,
            test.error_unit,
            *(_error(test, cells.get((test.name, engine))) for engine in engines),
        )
        for test in tests
    ]
    header = ("test", "error in", *(f"{e}, {_hertz(finest[e])}" for e in engines))
    return Section(
        "Overview",
        "Errors at the highest frequency. How each test is defined, and all frequencies, below.",
        [markdown_table(header, rows, left=2)],
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
                beaten = f"{_error(test, best)} ({best.engine}, {_hertz(finest)})"
                rows.append(
                    (test.name, r.engine, _error(test, r), beaten, test.error_unit, test.when_soft)
                )
    if not rows:
        return None
    return Section(
        "Where an engine with steps of its own is not the best",
        "Its error is then the model's, not the integrator's.",
        [markdown_table(("test", "engine", "error", "best other", "in", "why"), rows, left=6)],
    )


def _single(test: ClosedFormTest, results: Sequence[ClosedFormResult]) -> Section:
    rows = [
        (
            r.engine,
            _hertz(r.frequency),
            MISSING if r.found is None else f"{r.found:.6g}",
            _error(test, r),
        )
        for r in results
        if r.test == test.name
    ]
    found = f"found ({test.unit})" if test.unit else "found"
    header = ("engine", "substeps", found, f"error ({test.error_unit})")
    text = f"{test.definition} Expected: {f'{test.expected:.6g} {test.unit}'.strip()}."
    return Section(test.series, text, [markdown_table(header, rows)])


def _family(tests: Sequence[ClosedFormTest], results: Sequence[ClosedFormResult]) -> Section:
    first = tests[0]
    found = {(r.test, r.engine, r.frequency): r for r in results}
    runs = dict.fromkeys((r.engine, r.frequency) for r in results if r.test == first.name)
    header = (
        "engine",
        "substeps",
        *(f"{t.argument_name} {t.argument:g}" for t in tests),
    )
    rows = [
        (
            engine,
            _hertz(frequency),
            *(_error(t, found.get((t.name, engine, frequency))) for t in tests),
        )
        for engine, frequency in runs
    ]
    text = (
        f"{first.definition} Expected: {f'{first.expected:g} {first.unit}'.strip()}. Cells are "
        f"errors in {first.error_unit}."
    )
    file = first.series.lower().replace(" ", "-")
    caption = f"{first.series}: size of the error against {first.argument_name}."
    picture = Picture(file, plot_closed_form_series(tests, results), caption)
    return Section(first.series, text, [markdown_table(header, rows)], [picture])


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


def _hertz(frequency: int | None) -> str:
    return _OWN if frequency is None else f"{frequency} Hz"

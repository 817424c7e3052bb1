"""Figures of closed-form tests: errors of engines by frequency and by argument."""

from __future__ import annotations

import math
from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from steadyload.properties.closed_form_tests import ClosedFormResult, ClosedFormTest
from steadyload.reports.charts.drawing import PLAIN_TICKS, engine_legend
from steadyload.reports.style import engine_colour, engine_marker
from steadyload.reports.table import Column, words

OWN_STEPS = "own"
"""Text for the frequency of an engine that chooses its own steps."""

ENGINE = words("engine")


_FEW = 7
"""Largest number of ticks side by side in a narrow panel."""


def plot_closed_forms(
    tests: Sequence[ClosedFormTest], results: Sequence[ClosedFormResult]
) -> Figure:
    """Size of the error against frequency, a panel a test, all axes logarithmic.

    Filled markers are positive errors, hollow ones negative; an engine that chooses its own steps
    is a dashed line. Errors below a test's resolution are drawn on the dotted line.
    """
    across = 3
    figure = Figure(figsize=(9.6, 2.5 * math.ceil(len(tests) / across)))
    grid = figure.subplots(math.ceil(len(tests) / across), across, squeeze=False)
    frequencies = sorted({r.frequency for r in results if r.frequency is not None})
    for axes, test in zip(grid.flat, tests, strict=False):
        title = test.series
        if test.argument is not None:
            title += f": {test.argument_name} {test.argument:g}"
        axes.set_title(title, fontsize=9.0)
        shown = [r for r in results if r.test == test.name and r.error is not None]
        engines = list(dict.fromkeys(r.engine for r in shown))
        for place, engine in enumerate(engines):
            apart = 1.04 ** (place - 0.5 * (len(engines) - 1))
            mine = [r for r in shown if r.engine == engine]
            own = [r for r in mine if r.frequency is None]
            for result in own:
                axes.axhline(
                    _size(result, test), linestyle="--", linewidth=1.0, color=engine_colour(engine)
                )
            points = [(apart * r.frequency, r) for r in mine if r.frequency is not None]
            _error_curve(axes, test, engine, points)
        axes.set(xscale="log", yscale="log")
        many = 90 if len(frequencies) > _FEW else 0
        axes.set_xticks(frequencies, [f"{f:g}" for f in frequencies], rotation=many)
        axes.set_ylabel(f"|error| ({test.error_unit})")
        _finish_errors(axes, test, shown)
    for axes in grid.flat[len(tests) :]:
        axes.set_axis_off()
    for axes in grid.flat[max(0, len(tests) - across) : len(tests)]:
        axes.set_xlabel("substeps a second (Hz)")
    _engine_legend(figure, results)
    figure.tight_layout(rect=(0.0, 0.03, 1.0, 1.0))
    return figure


def plot_closed_form_series(
    tests: Sequence[ClosedFormTest], results: Sequence[ClosedFormResult]
) -> Figure:
    """Size of the error against the number in which tests differ, a panel a frequency.

    Markers as in :func:`plot_closed_forms`; an engine that chooses its own steps is dashed and
    drawn in every panel.
    """
    frequencies = sorted({r.frequency for r in results if r.frequency is not None}) or [0]
    figure = Figure(figsize=(3.2 * len(frequencies), 3.2))
    row = figure.subplots(1, len(frequencies), sharey=True, squeeze=False)[0]
    first, by_name = tests[0], {t.name: t for t in tests}
    arguments = [t.argument for t in tests if t.argument is not None]
    shown = [r for r in results if r.test in by_name and r.error is not None]
    for axes, frequency in zip(row, frequencies, strict=True):
        for engine in dict.fromkeys(r.engine for r in shown):
            mine = [r for r in shown if r.engine == engine and r.frequency in (frequency, None)]
            points = [(float(by_name[r.test].argument or 0.0), r) for r in mine]
            own = any(r.frequency is None for r in mine)
            _error_curve(axes, first, engine, points, "--" if own else "-")
        axes.set(yscale="log", xscale="log" if arguments[-1] > 10 * arguments[0] else "linear")
        many = 90 if len(arguments) > _FEW else 0
        axes.set_xticks(arguments, [_power_of_ten(a) for a in arguments], rotation=many)
        axes.set_xlabel(first.argument_name)
        axes.set_title(f"{frequency} Hz" if frequency else "own steps", fontsize=9.0)
        _finish_errors(axes, first, shown)
    row[0].set_ylabel(f"|error| ({first.error_unit})")
    _engine_legend(figure, shown)
    figure.tight_layout(rect=(0.0, 0.09, 1.0, 1.0))
    return figure


def _size(result: ClosedFormResult, test: ClosedFormTest) -> float:
    return max(abs(result.error or 0.0), test.resolution)


def _error_curve(
    axes: Axes,
    test: ClosedFormTest,
    engine: str,
    points: Sequence[tuple[float, ClosedFormResult]],
    line: str = "-",
) -> None:
    """One engine's errors; hollow where they are negative."""
    shade = engine_colour(engine)
    sizes = [_size(result, test) for _, result in points]
    axes.plot([x for x, _ in points], sizes, line, color=shade, linewidth=1.0, zorder=2)
    for (x, result), size in zip(points, sizes, strict=True):
        face = shade if (result.error or 0.0) >= 0.0 else "white"
        axes.plot(
            x,
            size,
            engine_marker(engine),
            color=shade,
            markerfacecolor=face,
            markersize=5.0,
            zorder=3,
        )


def _finish_errors(axes: Axes, test: ClosedFormTest, shown: Sequence[ClosedFormResult]) -> None:
    if any(abs(r.error or 0.0) < test.resolution for r in shown):
        axes.axhline(test.resolution, linestyle=":", linewidth=0.8, color="#7f7f7f")
    low, high = axes.get_ylim()
    if high < 100.0 * low:  # so that a curve that is flat looks flat
        middle = math.sqrt(low * high)
        axes.set_ylim(middle / 10.0, middle * 10.0)
    axes.minorticks_off()
    axes.yaxis.set_major_formatter(PLAIN_TICKS)
    axes.grid(visible=True, linewidth=0.4, alpha=0.6)


def _power_of_ten(value: float) -> str:
    return f"{value:g}" if value < 100.0 else f"1e{math.log10(value):g}"


def _engine_legend(figure: Figure, results: Sequence[ClosedFormResult]) -> None:
    """One legend below all panels."""
    own = {r.engine for r in results if r.frequency is None}
    labels = {r.engine: f"{r.engine} (own steps)" if r.engine in own else r.engine for r in results}
    engine_legend(figure, labels, dashed=own)


def hertz(frequency: int | None) -> str:
    """A frequency, or that the engine chooses its own steps."""
    return OWN_STEPS if frequency is None else f"{frequency} Hz"


SUBSTEPS = Column("substeps", "frequency", hertz)

"""Pictures of records. A figure shows what its record holds and computes nothing.

Pictures are PNG without date or software stamps: the same record gives the same bytes.
"""

from __future__ import annotations

import io
import math
from collections.abc import Sequence

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, LogFormatter
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

from steadyload.runs.evaluation import AgreementMatrix, MethodSummary
from steadyload.studies.closed_forms.records import ClosedFormResult, ClosedFormTest
from steadyload.studies.engines.records import EngineAgreement, SpeedCurve
from steadyload.methods.naming import MethodKey
from steadyload.reports.charts import Scene, TradeOff
from steadyload.reports.style import colour, engine_colour, face, marker

matplotlib.rcParams.update(
    {
        "text.parse_math": False,  # a dollar sign in a name is a dollar sign
        "font.size": 9.0,
        "axes.spines.top": False,
        "axes.spines.right": False,
    }
)

_DPI = 150
_PLAIN = FuncFormatter(lambda value, _: f"{value:g}")
"""Ticks of a log axis as plain numbers."""

_FEW = 7
"""So many ticks have room side by side in a narrow panel."""

_SHORT = 0.1
"""An axis below this share of the longest one has a single tick."""

_PHASE_COLOURS = {"build": "#9ecae1", "step": "#3182bd", "read": "#08519c", "other": "#c7c7c7"}


class _PlainBetween(LogFormatter):
    """Ticks between the decades of a log axis as plain numbers, where there is room for them."""

    def __call__(self, x: float, pos: int | None = None) -> str:
        return f"{x:g}" if super().__call__(x, pos) else ""


def png(figure: Figure) -> bytes:
    """A figure as PNG, reproducible to the byte."""
    sink = io.BytesIO()
    figure.savefig(sink, format="png", dpi=_DPI, bbox_inches="tight", metadata={"Software": None})
    return sink.getvalue()


def plot_trade_off(points: Sequence[TradeOff], *, x_label: str) -> Figure:
    """Runtime (log axis) against a share in per cent, with intervals: Fig. 3 of the paper.

    Good methods stand at the lower right. Methods without a share are left out.
    """
    figure = Figure(figsize=(7.6, 4.6))
    axes = figure.add_subplot()
    shown = [point for point in points if not math.isnan(point.share.value)]
    for point in shown:
        x, y = point.share, point.cpu
        filled = face(point.method) == colour(point.method)
        axes.errorbar(
            100 * x.value,
            y.value,
            xerr=[[100 * (x.value - x.low)], [100 * (x.high - x.value)]],
            yerr=[[y.value - y.low], [y.high - y.value]],
            fmt=marker(point.method),
            color=colour(point.method),
            markersize=8,
            markerfacecolor=face(point.method),
            markeredgecolor="white" if filled else colour(point.method),
            elinewidth=0.8,
        )
        axes.plot(
            [],
            [],
            marker(point.method),
            color=colour(point.method),
            markerfacecolor=face(point.method),
            markersize=7,
            label=point.method.title,
        )
    if any(point.cpu.value > 0.0 for point in shown):
        axes.set_yscale("log")
        # Says something only where the times span less than a decade.
        axes.yaxis.set_minor_formatter(_PlainBetween())
    axes.yaxis.set_major_formatter(_PLAIN)
    axes.set_xlabel(x_label)
    axes.set_ylabel("CPU time a layout (ms)")
    axes.grid(visible=True, which="major", linewidth=0.4, alpha=0.6)
    axes.legend(loc="center left", bbox_to_anchor=(1.01, 0.5), frameon=False)
    return figure


def plot_agreement_matrix(matrix: AgreementMatrix) -> Figure:
    """Share of equal failing steps between every two methods, in per cent."""
    titles = [m.title for m in matrix.methods]
    values = np.array([[e.value for e in row] for row in matrix.shares]) * 100
    side = 1.8 + 0.5 * len(titles)
    figure = Figure(figsize=(side + 0.6, side))
    axes = figure.add_subplot()
    image = axes.imshow(values, vmin=0, vmax=100, cmap="viridis")
    axes.set_xticks(range(len(titles)), titles, rotation=45, ha="right")
    axes.set_yticks(range(len(titles)), titles)
    axes.spines[:].set_visible(False)
    for row in range(len(titles)):
        for column in range(len(titles)):
            value = values[row, column]
            axes.text(
                column,
                row,
                f"{value:.0f}",
                ha="center",
                va="center",
                fontsize=8,
                color="white" if value < 65 else "black",
            )
    bar = figure.colorbar(image, ax=axes, fraction=0.046, pad=0.03)
    bar.set_label("same failing step (%)")
    return figure


def plot_phases(methods: Sequence[MethodSummary]) -> Figure:
    """Mean CPU time a layout by phase, for methods that have phases."""
    shown = [m for m in methods if m.phases.step > 0.0]
    figure = Figure(figsize=(7.6, 0.8 + 0.36 * max(1, len(shown))))
    axes = figure.add_subplot()
    for row, summary in enumerate(reversed(shown)):
        left = 0.0
        for phase, shade in _PHASE_COLOURS.items():
            width = getattr(summary.phases, phase)
            axes.barh(row, width, left=left, color=shade, label=phase if row == 0 else None)
            left += width
        axes.text(left, row, f" {left:.3g}", va="center", fontsize=8)
    axes.set_yticks(range(len(shown)), [m.method.title for m in reversed(shown)])
    axes.set_xlabel("mean CPU time a layout (ms)")
    if shown:
        axes.legend(frameon=False, ncols=4, loc="lower center", bbox_to_anchor=(0.5, 1.0))
    return figure


def plot_growth(curves: Sequence[SpeedCurve]) -> Figure:
    """CPU time against the number of items, both on log axes; solid all items, dashed local."""
    figure = Figure(figsize=(7.6, 4.8))
    axes = figure.add_subplot()
    for curve in curves:
        key = MethodKey(curve.engine, curve.engine, curve.engine, curve.engine)
        label = f"{curve.engine}, {curve.scene}, {curve.scope}"
        if math.isfinite(curve.exponent):
            label += f": J^{curve.exponent:.2f}"
        axes.plot(
            [p.item_count for p in curve.points],
            [p.total for p in curve.points],
            linestyle={"all": "-", "local": "--"}[curve.scope],
            linewidth=1.2 if curve.scene == "pile" else 0.7,
            marker=marker(key),
            markersize=6 if curve.scene == "pile" else 3,
            color=engine_colour(curve.engine),
            label=label,
        )
    axes.set(xscale="log", yscale="log")
    axes.yaxis.set_major_formatter(_PLAIN)
    axes.set_xlabel("items in the layout, J")
    axes.set_ylabel("CPU time a layout (ms)")
    counts = sorted({p.item_count for c in curves for p in c.points})
    axes.set_xticks(counts, [str(n) for n in counts])
    axes.minorticks_off()
    axes.grid(visible=True, linewidth=0.4, alpha=0.6)
    axes.legend(loc="center left", bbox_to_anchor=(1.01, 0.5), frameon=False)
    return figure


def plot_convergence(rows: Sequence[EngineAgreement]) -> Figure:
    """Agreement between every two engines against frequency."""
    figure = Figure(figsize=(6.4, 3.8))
    axes = figure.add_subplot()
    for pair in rows[0].agreement:
        found = [100 * row.agreement[pair].value for row in rows]
        low = [100 * (row.agreement[pair].value - row.agreement[pair].low) for row in rows]
        high = [100 * (row.agreement[pair].high - row.agreement[pair].value) for row in rows]
        axes.errorbar(
            [row.frequency for row in rows],
            found,
            yerr=[low, high],
            marker="o",
            capsize=2,
            linewidth=1.0,
            label=" and ".join(pair),
        )
    axes.set_xscale("log")
    axes.set_xticks([row.frequency for row in rows], [str(row.frequency) for row in rows])
    axes.minorticks_off()
    axes.set_xlabel("substeps a second (Hz)")
    axes.set_ylabel("same failing step (%)")
    axes.grid(visible=True, linewidth=0.4, alpha=0.6)
    axes.legend(frameon=False)
    return figure


def plot_closed_forms(
    tests: Sequence[ClosedFormTest], results: Sequence[ClosedFormResult]
) -> Figure:
    """Size of the error against frequency, a panel a test, all axes logarithmic.

    Filled markers are positive errors, hollow ones negative; an engine that chooses its own steps
    is a dashed line. Errors below a test's resolution stand on the dotted line.
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
    stands in every panel.
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
    shade, key = engine_colour(engine), MethodKey(engine, engine, engine, engine)
    sizes = [_size(result, test) for _, result in points]
    axes.plot([x for x, _ in points], sizes, line, color=shade, linewidth=1.0, zorder=2)
    for (x, result), size in zip(points, sizes, strict=True):
        face = shade if (result.error or 0.0) >= 0.0 else "white"
        axes.plot(x, size, marker(key), color=shade, markerfacecolor=face, markersize=5.0, zorder=3)


def _finish_errors(axes: Axes, test: ClosedFormTest, shown: Sequence[ClosedFormResult]) -> None:
    if any(abs(r.error or 0.0) < test.resolution for r in shown):
        axes.axhline(test.resolution, linestyle=":", linewidth=0.8, color="#7f7f7f")
    low, high = axes.get_ylim()
    if high < 100.0 * low:  # so that a curve that is flat looks flat
        middle = math.sqrt(low * high)
        axes.set_ylim(middle / 10.0, middle * 10.0)
    axes.minorticks_off()
    axes.yaxis.set_major_formatter(_PLAIN)
    axes.grid(visible=True, linewidth=0.4, alpha=0.6)


def _power_of_ten(value: float) -> str:
    return f"{value:g}" if value < 100.0 else f"1e{math.log10(value):g}"


def _engine_legend(figure: Figure, results: Sequence[ClosedFormResult]) -> None:
    """One legend below all panels."""
    own = {r.engine for r in results if r.frequency is None}
    handles = []
    for engine in dict.fromkeys(r.engine for r in results):
        key = MethodKey(engine, engine, engine, engine)
        label = f"{engine} (own steps)" if engine in own else engine
        line = Line2D([], [], marker=marker(key), color=engine_colour(engine), label=label)
        line.set_linestyle("--" if engine in own else "-")
        handles.append(line)
    figure.legend(handles=handles, loc="lower center", ncols=max(1, len(handles)), frameon=False)


def plot_scene(scene: Scene) -> Figure:
    """A layout in 3-D: items with their sequence numbers, centres of mass, marked items in red."""
    figure = Figure(figsize=(5.6, 5.2))
    axes = figure.add_subplot(projection="3d")
    count = len(scene.lower)
    shades = matplotlib.colormaps["viridis"](np.linspace(0.15, 0.95, max(count, 2)))
    for index in range(count):
        # Matplotlib draws z up: (x, y, z) of the layout becomes (z, x, y).
        low, high = scene.lower[index, [2, 0, 1]], scene.upper[index, [2, 0, 1]]
        marked = index in scene.marked
        faces = Poly3DCollection(
            _faces(low, high),
            facecolor="#e31a1c" if marked else shades[index],
            edgecolor="black",
            linewidths=0.5,
            alpha=0.85 if marked else 0.35,
        )
        axes.add_collection3d(faces)
        centre, mass = 0.5 * (low + high), scene.mass_centres[index, [2, 0, 1]]
        axes.text(*centre, str(index), fontsize=7, ha="center", zorder=1000)
        axes.scatter(*mass, s=6, color="black", depthshade=False)
    width, height, depth = scene.contour
    top = min(height, float(scene.upper[:, 1].max()) * 1.05)
    axes.set(xlim=(0, depth), ylim=(0, width), zlim=(0, top))
    axes.set(xlabel="z, depth (cm)", ylabel="x, width (cm)", zlabel="y, height (cm)")
    axes.set_box_aspect((depth, width, top))
    axes.locator_params(nbins=4)
    for axis, side in ((axes.xaxis, depth), (axes.yaxis, width), (axes.zaxis, top)):
        if side < _SHORT * max(depth, width, top):  # no room for more than one number
            axis.set_ticks([side])
    axes.set_title(scene.title)
    return figure


def _faces(low: np.ndarray, high: np.ndarray) -> list[list[tuple[float, float, float]]]:
    (x0, y0, z0), (x1, y1, z1) = low.tolist(), high.tolist()
    bottom = [(x0, y0), (x1, y0), (x1, y1), (x0, y1)]
    sides = [
        [(*a, z0), (*b, z0), (*b, z1), (*a, z1)]
        for a, b in zip(bottom, bottom[1:] + bottom[:1], strict=True)
    ]
    return [[(x, y, z0) for x, y in bottom], [(x, y, z1) for x, y in bottom], *sides]

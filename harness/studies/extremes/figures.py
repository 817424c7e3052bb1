"""Figures of the extremes: outcomes of engines by frequency and value, cell by cell."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch, Rectangle

from steadyload.studies.extremes.measuring import Outcome
from steadyload.studies.extremes.sweeps import ExtremeCell, ExtremeSweep

_COLOURS = {
    Outcome.CLOSE: "#08519c",
    Outcome.HELD: "#9ecae1",
    Outcome.FAILED: "#f16913",
    Outcome.NO_VERDICT: "#d9d9d9",
    Outcome.UNDEFINED: "white",
}
"""Dark and light blue, and orange: distinct in every kind of colour vision, and as greys."""

_SIGNS = {Outcome.FAILED: "×", Outcome.NO_VERDICT: "?", Outcome.UNDEFINED: "–"}


def plot_outcomes(
    sweep: ExtremeSweep, cells: Sequence[ExtremeCell], frequencies: Sequence[int]
) -> Figure:
    """One panel an engine: frequency across, value up, colour and sign for the outcome.

    Args:
        sweep: the sweep.
        cells: of that sweep.
        frequencies: columns of every engine that does not choose its own steps.
    """
    engines = list(dict.fromkeys(cell.engine for cell in cells))
    columns = {e: _columns([c for c in cells if c.engine == e], frequencies) for e in engines}
    values = list(sweep.values)
    figure = Figure(figsize=(10.0, 1.6 + 0.2 * len(values)))
    widths = [max(2.0, float(len(columns[e]))) for e in engines]
    panels = figure.subplots(
        1, len(engines), sharey=True, squeeze=False, gridspec_kw={"width_ratios": widths}
    )[0]
    for axes, engine in zip(panels, engines, strict=True):
        mine = [c for c in cells if c.engine == engine]
        _panel(axes, engine, mine, columns[engine], values)
    panels[0].set_yticks(range(len(values)), [_number(v) for v in values], fontsize=8.0)
    unit = f" ({sweep.unit})" if sweep.unit else ""
    panels[0].set_ylabel(f"{sweep.axis}{unit}")
    height = figure.get_figheight()
    figure.text(0.5, 0.3 / height, "substeps a second (Hz)", fontsize=9.0, ha="center")
    _legend(figure, {cell.outcome for cell in cells})
    figure.tight_layout(rect=(0.0, 0.4 / height, 1.0, 1.0), w_pad=0.4)
    return figure


def _columns(cells: Sequence[ExtremeCell], frequencies: Sequence[int]) -> list[int | None]:
    if any(cell.frequency is None for cell in cells):
        return [None]
    return list(frequencies)


def _panel(
    axes: Axes,
    engine: str,
    cells: Sequence[ExtremeCell],
    columns: Sequence[int | None],
    values: Sequence[float],
) -> None:
    place = {column: k for k, column in enumerate(columns)}
    level = {value: k for k, value in enumerate(values)}
    for cell in cells:
        x, y = place[cell.frequency], level[cell.value]
        axes.add_patch(
            Rectangle(
                (x - 0.5, y - 0.5), 1.0, 1.0, facecolor=_COLOURS[cell.outcome], edgecolor="white"
            )
        )
        axes.text(x, y - 0.05, _SIGNS.get(cell.outcome, ""), fontsize=7, ha="center", va="center")
    axes.set(xlim=(-0.5, len(columns) - 0.5), ylim=(-0.5, len(values) - 0.5))
    names = ["own" if column is None else f"{column}" for column in columns]
    axes.set_xticks(range(len(columns)), names, rotation=90, fontsize=8.0)
    axes.tick_params(length=0.0)
    axes.set_title(engine, fontsize=9.0)
    axes.spines[:].set_visible(False)
    axes.set_facecolor("#f7f7f7")


def _legend(figure: Figure, present: set[Outcome]) -> None:
    titles = {
        Outcome.CLOSE: "within the stricter limit",
        Outcome.HELD: "held",
        Outcome.FAILED: "× failed",
        Outcome.NO_VERDICT: "? no verdict",
        Outcome.UNDEFINED: "– not defined",
    }
    handles = [
        Patch(facecolor=_COLOURS[o], edgecolor="#7f7f7f", linewidth=0.5, label=title)
        for o, title in titles.items()
        if o in present
    ]
    blank = Patch(facecolor="#f7f7f7", edgecolor="#7f7f7f", linewidth=0.5, label="not measured")
    figure.legend(
        handles=[*handles, blank], loc="lower center", ncols=len(handles) + 1, frameon=False,
        fontsize=8.0,
    )  # fmt: skip


def _number(value: float) -> str:
    if value >= 1e4:
        return f"{value:.0e}".replace("e+0", "e")
    return f"{value:g}"

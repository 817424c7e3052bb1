"""The page of the extremes: the envelope of each engine, and its outcomes beyond it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence

from steadyload.reports.pages.page import Page, Picture, Section
from steadyload.reports.table import Column, Table, columns_for, compact, words, yes_no
from steadyload.studies.closed_form_figures import (
    ENGINE,
    OWN_STEPS,
    SUBSTEPS,
    hertz,
    plot_closed_form_series,
    plot_closed_forms,
)
from steadyload.studies.extremes.figures import plot_outcomes
from steadyload.studies.extremes.measuring import Outcome
from steadyload.studies.extremes.summary import (
    EnvelopeRow,
    Extremes,
    closed_form_results,
    closed_form_test,
    expected_value,
)
from steadyload.studies.extremes.sweeps import ExtremeCell, ExtremeSweep

_WITH_NEGATIVE = ("plate-on-edge",)
"""Sweeps whose largest held value is not meaningful."""

_SPOKEN_OF = (60, 240, 1000)
"""Frequencies in sentences and tables of numbers, where they were measured."""

_USUAL = 240
"""Substeps a second of the sentence that begins the page."""

_CURVES = (30, 90, 240, 1000)
"""Frequencies of the panels that show errors against the value."""

_TALL, _UNEVEN = 10, 10.0
"""Stack height [items] and mass ratio on a pallet: weights are a few kilograms to tens of them."""


def _ratio(value: float) -> str:
    return f"{value:,.0f}" if value else "none"


def _edges(row: EnvelopeRow) -> str:
    return f"{row.least_size:g} to {row.most_size:g}" if row.most_size else "none"


def _envelope_columns(since: str, up_to: str) -> list[Column]:
    """Columns of what was held; ``since`` is the title of the frequency."""
    return [
        ENGINE,
        Column(since, "frequency", hertz),
        Column(f"stacks{up_to}", "tower_height", _ratio),
        Column(f"heavy on light{up_to}", "heavy_on_light", _ratio),
        Column(f"light on heavy{up_to}", "light_on_heavy", _ratio),
        Column("edges (cm)", _edges),
        Column(f"items{up_to}", "item_count", _ratio),
    ]


_OUTCOMES = {
    Outcome.CLOSE: "within the stricter limit",
    Outcome.HELD: "held",
    Outcome.FAILED: "failed",
    Outcome.NO_VERDICT: "without a verdict",
    Outcome.UNDEFINED: "not defined for the engine",
}
_NUMBERS = {
    "moved": "moved (mm)",
    "turned": "turned (deg)",
    "penetration": "penetration (mm)",
    "energy": "energy (mm)",
    "cpu": "CPU ms",
}
"""Titles of numbers of a cell."""


def extremes_page(extremes: Extremes, manifest: Mapping[str, str]) -> Page:
    """Compose the page."""
    sections = []
    if extremes.envelope:
        sections = [_use(extremes), _findings(extremes), _envelope(extremes.envelope)]
    formulas = [s for s in extremes.sweeps if s.quantity]
    sections += [_resting(s, extremes) for s in extremes.sweeps if not s.quantity]
    if formulas:
        sections.append(_overview(formulas, extremes))
    sections += [_formula(s, extremes) for s in formulas]
    return Page(
        "The engines at the edge",
        f"{_answer(extremes)}Every engine is taken to where it stops being right: "
        "from 5 to 1000 substeps a second, towers of up to 100 cubes, mass ratios of up "
        "to a million, edges from a millimetre to ten metres, "
        "plates of 1 x 100 x 100 cm, friction 0 to 2, restitution up to 0.95, up to 200 items. "
        "Boxes that are in balance are placed and simulated for 0.3 s, as the label's "
        "loading does, at friction 0.5 and restitution 0 where these are not swept; *held* means "
        "that none moved by more than 10 cm or turned by more than 10 degrees at the end of it. "
        "What moves is held against a closed form. Each axis is swept by itself. An engine that "
        f"chooses its own steps (`{OWN_STEPS}`) runs once. A cell that takes longer than "
        f"{extremes.timeout:g} s has no verdict, which is neither held nor failed. "
        "Nothing here is drawn by chance, so there are no intervals.",
        sections,
        manifest,
    )


def _answer(extremes: Extremes) -> str:
    """Sentence on what holds at a usual frequency and above; empty where that was not measured."""
    holds: dict[str, EnvelopeRow] = {}
    for row in extremes.from_here_on:
        if row.frequency is None or row.frequency <= _USUAL:
            holds[row.engine] = row
    if not any(row.frequency for row in holds.values()):
        return ""
    towers = ", ".join(f"{row.tower_height} ({name})" for name, row in holds.items())
    ratios = ", ".join(f"{_ratio(row.heavy_on_light)} ({name})" for name, row in holds.items())
    return (
        f"At {_USUAL} substeps a second and more, towers of up to {towers} equal cubes hold, and a "
        f"cube on a lighter one up to a mass ratio of {ratios}.\n\n"
    )


def _use(extremes: Extremes) -> Section:
    columns = _envelope_columns("at or above", " up to")
    return Section(
        "What to use",
        "Use an engine at or above so many substeps a second for stacks of up to so many items and "
        "mass ratios of up to so much: what was held at that frequency and at all higher ones, "
        "with all smaller values. Left out are frequencies at which a plate beyond an edge does "
        "not fall, or one before it does, or not even two equal cubes hold. Where a larger value "
        "has no verdict, the number is what was seen to hold, not all that does.",
        [
            Table(extremes.from_here_on, columns),
            Table(
                extremes.at_rest,
                columns,
                "The same where nothing may move by 1 mm or turn by half a degree:",
            ),
        ],
    )


def _findings(extremes: Extremes) -> Section:
    """Sentences made from the envelope's rows."""
    rows = extremes.envelope
    counted = Counter(cell.outcome for cell in extremes.cells)
    outcomes = ", ".join(f"{counted[outcome]} {title}" for outcome, title in _OUTCOMES.items())
    said = [f"- {len(extremes.cells)} cells: {outcomes}."]
    for frequency in [f for f in _SPOKEN_OF if any(r.frequency == f for r in rows)]:
        at = [r for r in rows if r.frequency in (frequency, None)]
        towers = ", ".join(f"{r.tower_height} ({r.engine})" for r in at)
        heavy = ", ".join(f"{_ratio(r.heavy_on_light)} ({r.engine})" for r in at)
        said.append(
            f"- At {frequency} Hz the tallest tower that holds has {towers} cubes; a cube stands "
            f"on lighter ones up to a mass ratio of {heavy}."
        )
    for engine in dict.fromkeys(r.engine for r in rows):
        fit = [r for r in extremes.from_here_on if r.engine == engine and _is_fit(r)]
        when = f"from {hertz(fit[0].frequency)} on" if fit else "at no frequency measured"
        if fit and fit[0].frequency is None:
            when = "with its own steps"
        said.append(
            f"- {engine} holds stacks of {_TALL} and mass ratios of {_UNEVEN:g}, both ways, {when}"
            + (f", with edges down to {fit[0].least_size:g} cm." if fit else ".")
        )
    blind = [f"{r.engine} at {hertz(r.frequency)}" for r in rows if not r.sees_falls]
    if blind:
        said.append(
            f"- A plate over an edge is misjudged by {', '.join(blind)}: a row that holds towers "
            "there says little."
        )
    silent = _silent(extremes)
    if silent:
        said.append(f"- Without a verdict, so that larger values may hold: {silent}.")
    return Section("What it shows", "\n".join(said))


def _silent(extremes: Extremes) -> str:
    """Sweeps of engines that ran out of time, with the frequencies at which they did."""
    titles = {s.name: s.title.lower() for s in extremes.sweeps}
    at: dict[str, list[str]] = {}
    for c in extremes.cells:
        if c.outcome is Outcome.NO_VERDICT:
            at.setdefault(f"{c.engine}, {titles[c.sweep]}", []).append(hertz(c.frequency))
    return "; ".join(f"{what} ({', '.join(dict.fromkeys(hertz))})" for what, hertz in at.items())


def _is_fit(row: EnvelopeRow) -> bool:
    return row.tower_height >= _TALL and min(row.heavy_on_light, row.light_on_heavy) >= _UNEVEN


def _envelope(rows: Sequence[EnvelopeRow]) -> Section:
    columns = _envelope_columns("substeps", "")
    return Section(
        "The envelope",
        "What is held at each frequency by itself. `harness/methods/envelopes.json` has these "
        "numbers; studies and scores warn of layouts that leave the row of the engine and "
        "frequency that judges them.",
        [Table(rows, [*columns, Column("sees falls", "sees_falls", yes_no)])],
    )


def _resting(sweep: ExtremeSweep, extremes: Extremes) -> Section:
    cells = [c for c in extremes.cells if c.sweep == sweep.name]
    text = f"{sweep.definition} Stricter limit: {sweep.close}. Held: {sweep.held}."
    if sweep.stops is not None:
        text += (
            f" After {sweep.stops} values in a row that were not held no larger one is measured."
        )
    if sweep.name in _WITH_NEGATIVE:
        return Section(sweep.title, text, [], [_map(sweep, cells, extremes)])
    columns = [
        ENGINE,
        SUBSTEPS,
        Column(f"largest {sweep.axis} held", "value", "{:,g}".format),
        *columns_for(_NUMBERS, _NUMBERS.__getitem__, "numbers", compact),
    ]
    return Section(
        sweep.title,
        f"{text} The table has the largest value that was held: how far any box moved, turned and "
        "came into another one, the energy gained over the weight of all (a height; below 0: lost) "
        "and, for information, the CPU time.",
        [Table(_largest_held(cells), columns)],
        [_map(sweep, cells, extremes)],
    )


def _largest_held(cells: Sequence[ExtremeCell]) -> list[ExtremeCell]:
    largest: dict[tuple[str, int | None], ExtremeCell] = {}
    for cell in cells:
        if cell.outcome.good and cell.frequency in (*_SPOKEN_OF, None):
            largest[cell.engine, cell.frequency] = cell
    return list(largest.values())


def _map(sweep: ExtremeSweep, cells: Sequence[ExtremeCell], extremes: Extremes) -> Picture:
    frequencies = sorted({c.frequency for c in extremes.cells if c.frequency is not None})
    return Picture(
        sweep.name,
        plot_outcomes(sweep, cells, frequencies),
        f"{sweep.title}: {sweep.axis} against substeps a second, a panel an engine.",
    )


def _overview(formulas: Sequence[ExtremeSweep], extremes: Extremes) -> Section:
    shown = [closed_form_test(s, s.shown) for s in formulas if s.shown is not None]
    results = [r for s in formulas for r in closed_form_results(s, extremes.cells)]
    return Section(
        "Errors against closed forms",
        "At one value of each of the sweeps below.",
        [],
        [
            Picture(
                "closed-forms",
                plot_closed_forms(shown, results),
                "Size of the error against frequency, log axes: filled markers are positive "
                "errors, hollow ones negative, dashed lines engines that choose their own steps; "
                "smaller errors than a test resolves stand on a dotted line. Values: "
                + ", ".join(f"{s.title.lower()} at {s.axis} {s.shown:g}" for s in formulas)
                + ".",
            )
        ],
    )


def _formula(sweep: ExtremeSweep, extremes: Extremes) -> Section:
    cells = [c for c in extremes.cells if c.sweep == sweep.name]
    # A value of 0 is another test: a box that does not stop, or does not rebound.
    tests = [
        closed_form_test(sweep, v) for v in sweep.values if v and expected_value(sweep, v, cells)
    ]
    results = [r for r in closed_form_results(sweep, cells) if r.frequency in (*_CURVES, None)]
    found = {(c.engine, c.frequency, c.value): c.numbers.get("found") for c in cells}
    runs = dict.fromkeys((c.engine, hertz(c.frequency), c.frequency) for c in cells)
    rows = [
        ("closed form", "", {v: expected_value(sweep, v, cells) for v in sweep.values}),
        *((e, hertz, {v: found.get((e, f, v)) for v in sweep.values}) for e, hertz, f in runs),
    ]
    columns = [
        words("engine", 0),
        Column("substeps", 1),
        *columns_for(
            sweep.values,
            lambda value: f"{sweep.axis} {value:g}",
            lambda row, value: row[2][value],
            lambda number: compact(number, 3),
        ),
    ]
    pictures = [_map(sweep, cells, extremes)]
    if any(r.error is not None for r in results):
        caption = f"{sweep.title}: size of the error against {sweep.axis}."
        figure = plot_closed_form_series(tests, results)
        pictures.append(Picture(f"{sweep.name}-error", figure, caption))
    return Section(
        sweep.title,
        f"{sweep.definition} Stricter limit: {sweep.close}. Held: {sweep.held}. Cells are what was "
        f"found: {sweep.quantity}.",
        [Table(rows, columns)],
        pictures,
    )

"""The page that compares engines: agreement, options, speed."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from steadyload.reports.pages.page import Page, Picture, Section
from steadyload.reports.table import (
    MISSING,
    Column,
    Table,
    columns_for,
    milliseconds,
    percent,
    significant,
    words,
)
from steadyload.runs.costs import CostKind, CostSource
from steadyload.studies.engines.figures import plot_convergence, plot_growth
from steadyload.studies.engines.sources import SourceTable
from steadyload.studies.engines.sources_section import leading_source, sources
from steadyload.studies.engines.speed import SpeedCurve, Throughput
from steadyload.studies.engines.study import EngineAgreement, OptionEffect


def _whole(value: float | None) -> str:
    return MISSING if value is None else f"{value:.0f}"


def _of_point(title: str, name: str, form: Callable[[Any], str] = significant) -> Column:
    """A column of the points of curves, over rows of a curve and a point."""
    return Column(title, lambda row: getattr(row[1], name), form)


_SPEED = (
    words("engine", lambda row: row[0].engine),
    words("scene", lambda row: row[0].scene),
    words("scope", lambda row: row[0].scope),
    _of_point("J", "item_count", str),
    _of_point("CPU ms", "total"),
    _of_point("build ms", "build"),
    _of_point("step ms", "step"),
    _of_point("read ms", "read"),
    Column("step %", lambda row: 100 * row[1].step / row[1].total, _whole),
    _of_point("floor ms", "floor"),
    _of_point("create ms", "create"),
    _of_point("own us a placement", "own", _whole),
)
_THROUGHPUT = (
    words("engine"),
    Column("n", "layouts"),
    Column("layouts/s, 1 process", "one", significant),
    Column("layouts/s, 2 processes", "two", significant),
    Column("gain", lambda r: r.two / r.one, "{:.2f}".format),
)


def engine_study_page(
    agreement: Sequence[EngineAgreement],
    options: Sequence[OptionEffect],
    curves: Sequence[SpeedCurve],
    rates: Sequence[Throughput],
    shares: Sequence[SourceTable],
    manifest: Mapping[str, str],
) -> Page:
    """Compose the page; a part that was not measured is left out."""
    sections = []
    if shares:
        sections.append(sources(shares))
    if agreement:
        sections.append(_agreement(agreement))
    if options:
        sections.append(_options(options))
    if curves:
        sections.append(_speed(curves))
    if rates:
        sections.append(_throughput(rates))
    return Page(
        "The same question asked of several engines",
        f"{_answer(agreement, shares)}One loading algorithm, equal SI values, every engine. "
        "Brackets hold 95 % intervals (Wilson for shares, bootstrap for means). "
        f"{CostSource(CostKind.ONE_PROCESS).explained()}",
        sections,
        manifest,
    )


def _answer(agreement: Sequence[EngineAgreement], shares: Sequence[SourceTable]) -> str:
    """Sentences on what verdicts differ by, and on how far untuned engines agree."""
    said = [leading_source(shares)] if shares else []
    if agreement:
        finest = agreement[-1]
        alike = sorted(finest.agreement.values(), key=lambda share: share.value)
        said.append(
            f"Untuned at {finest.frequency} Hz, any two engines name the same failing step on "
            f"{percent(alike[0])} to {percent(alike[-1])} % of {alike[0].n} layouts."
        )
    return " ".join(said) + "\n\n" if said else ""


def _agreement(rows: Sequence[EngineAgreement]) -> Section:
    engines, pairs = list(rows[0].cpu), list(rows[0].agreement)
    n = next(iter(rows[0].agreement.values())).n

    def by_frequency(title: str, name: str, form: Callable[[Any], str]) -> list[Column]:
        return [
            words(title, lambda key: key if isinstance(key, str) else " and ".join(key)),
            *(Column(f"{row.frequency} Hz", getattr(row, name).__getitem__, form) for row in rows),
        ]

    return Section(
        "Agreement",
        f"Untuned, {n} generated layouts of 3 to 20 items in the three scenarios: 0.3 s a "
        "placement, reseat, 10 cm or 10 degrees at its end, contact friction 0.5.",
        [
            Table(
                pairs,
                by_frequency("engines", "agreement", percent),
                "Layouts on which two engines name the same failing step, %:",
            ),
            Table(engines, by_frequency("engine", "stable", percent), "Stable layouts, %:"),
            Table(engines, by_frequency("engine", "cpu", milliseconds), "CPU time a layout, ms:"),
        ],
        [
            Picture(
                "convergence",
                plot_convergence(rows),
                "On how many layouts each other engine names the failing step of the one above; "
                "bars are 95 % intervals.",
            )
        ],
    )


def _options(effects: Sequence[OptionEffect]) -> Section:
    found = {(e.option, e.engine): e for e in effects}
    engines = dict.fromkeys(e.engine for e in effects)

    options = dict.fromkeys(e.option for e in effects)

    def table(caption: str, name: str, form: Callable[[Any], str]) -> Table:
        each = columns_for(
            engines, "{}", lambda option, e: getattr(found.get((option, e)), name, None), form
        )
        return Table(options, [words("option", str), *each], caption)

    return Section(
        "Options: what they change and what they cost",
        f"At 240 Hz, n = {effects[0].changed.n} layouts. *Changed* is the share of layouts whose "
        "failing step is another with the option than without; *CPU ratio* is its CPU time over "
        "that without, both measured in turn, some layouts at a time. All options are off by "
        "default: an untuned method is the plain algorithm, and whoever tunes one can give the "
        "same options to the others.",
        [
            table("Changed, %:", "changed", percent),
            table("CPU ratio:", "ratio", significant),
        ],
    )


def _speed(curves: Sequence[SpeedCurve]) -> Section:
    return Section(
        "Speed",
        "0.3 s a placement at 90 Hz, reseat, one look at its end; every item is placed. *Pile*: "
        "random boxes packed from the bottom up. *Wall*: bricks of full depth, planar. *Local* "
        "scope simulates what shares a stack with the new item; what stands beside it is fixed, "
        "the rest left out. *Floor* is the stepping of the same states alone: the engine's native "
        "steps and the adapter's call. *Create* is the adding of boxes (native bodies, where the "
        "engine has them), *own* all the rest, a difference of measurements: noise where steps are "
        "long. The exponent in the figure is fitted from 10 items on. A curve ends where an engine "
        "has no verdict within a minute, or none at all (DART refuses more than 1000 contacts).",
        [Table([(curve, point) for curve in curves for point in curve.points], _SPEED)],
        [
            Picture(
                "growth",
                plot_growth(curves),
                "CPU time against the number of items; the exponent stands in the legend.",
            )
        ],
    )


def _throughput(rates: Sequence[Throughput]) -> Section:
    return Section(
        "Throughput",
        "Generated layouts of 3 to 20 items, wall time, start-up excluded.",
        [Table(rates, _THROUGHPUT)],
    )

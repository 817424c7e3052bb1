"""The page that compares engines: agreement, options, speed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from steadyload.reports.page import Page, Picture, Section
from steadyload.reports.table import (
    MISSING,
    markdown_table,
    milliseconds,
    percent,
    significant,
)
from steadyload.runs.costs import CostKind, CostSource
from steadyload.studies.engines.figures import plot_convergence, plot_growth
from steadyload.studies.engines.records import (
    EngineAgreement,
    OptionEffect,
    SpeedCurve,
    Throughput,
)


def engine_study_page(
    agreement: Sequence[EngineAgreement],
    options: Sequence[OptionEffect],
    curves: Sequence[SpeedCurve],
    rates: Sequence[Throughput],
    manifest: Mapping[str, str],
) -> Page:
    """Compose the page; a part that was not measured is left out."""
    sections = []
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
        "One loading algorithm, equal SI values, every engine. Brackets hold 95 % intervals "
        "(Wilson for shares, bootstrap for means). "
        f"{CostSource(CostKind.ONE_PROCESS).explained()}",
        sections,
        manifest,
    )


def _agreement(rows: Sequence[EngineAgreement]) -> Section:
    engines, pairs = list(rows[0].cpu), list(rows[0].agreement)
    n = next(iter(rows[0].agreement.values())).n
    header = (
        "Hz",
        *(f"{a} = {b} %" for a, b in pairs),
        *(f"{e} stable %" for e in engines),
        *(f"{e} ms" for e in engines),
    )
    table = markdown_table(
        header,
        [
            (
                str(row.frequency),
                *(percent(row.agreement[pair]) for pair in pairs),
                *(percent(row.stable[e]) for e in engines),
                *(milliseconds(row.cpu[e]) for e in engines),
            )
            for row in rows
        ],
    )
    return Section(
        "Agreement",
        f"Untuned, {n} generated layouts of 3 to 20 items in the three scenarios: 0.3 s a "
        "placement, reseat, 10 cm or 10 degrees at its end, contact friction 0.5. A cell is the "
        "share of layouts on which two engines name the same failing step.",
        [table],
        [
            Picture(
                "convergence",
                plot_convergence(rows),
                "Unrelated engines come together as their step shrinks.",
            )
        ],
    )


def _options(effects: Sequence[OptionEffect]) -> Section:
    engines = list(dict.fromkeys(e.engine for e in effects))
    found = {(e.option, e.engine): e for e in effects}
    header = ("option", *(f"{e}: {what}" for e in engines for what in ("changed %", "CPU ratio")))
    rows = []
    for option in dict.fromkeys(e.option for e in effects):
        cells = [option]
        for engine in engines:
            effect = found.get((option, engine))
            cells += (
                [percent(effect.changed), significant(effect.ratio)]
                if effect
                else [MISSING, MISSING]
            )
        rows.append(tuple(cells))
    return Section(
        "Options: what they change and what they cost",
        f"At 240 Hz, n = {effects[0].changed.n} layouts. *Changed* is the share of layouts whose "
        "failing step is another with the option than without; *CPU ratio* is its CPU time over "
        "that without, both measured in turn, layout by layout. All options are off by default: an "
        "untuned method is the plain algorithm, and whoever tunes one can give the same options to "
        "the others.",
        [markdown_table(header, rows)],
    )


def _speed(curves: Sequence[SpeedCurve]) -> Section:
    header = (
        "engine", "scene", "scope", "J", "CPU ms", "build ms", "step ms", "read ms", "step %",
        "floor ms", "create ms", "own us a placement",
    )  # fmt: skip
    rows = []
    for curve in curves:
        for p in curve.points:
            cells = [curve.engine, curve.scene, curve.scope, str(p.item_count)]
            cells += [significant(v) for v in (p.total, p.build, p.step, p.read)]
            cells.append(f"{100 * p.step / p.total:.0f}")
            if p.floor is None or p.create is None:
                cells += [MISSING] * 3
            else:
                own = 1e3 * (p.total - p.floor - p.create) / p.item_count
                cells += [significant(p.floor), significant(p.create), f"{own:.0f}"]
            rows.append(tuple(cells))
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
        [markdown_table(header, rows, left=3)],
        [
            Picture(
                "growth",
                plot_growth(curves),
                "CPU time against the number of items; the exponent stands in the legend.",
            )
        ],
    )


def _throughput(rates: Sequence[Throughput]) -> Section:
    header = ("engine", "n", "layouts/s, 1 process", "layouts/s, 2 processes", "gain")
    rows = [
        (r.engine, str(r.layouts), significant(r.one), significant(r.two), f"{r.two / r.one:.2f}")
        for r in rates
    ]
    return Section(
        "Throughput",
        "Generated layouts of 3 to 20 items, wall time, start-up excluded.",
        [markdown_table(header, rows)],
    )

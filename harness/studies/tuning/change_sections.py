"""The part of the page of tuning that changes what was found, and takes it to other engines."""

from __future__ import annotations

from collections.abc import Sequence

from steadyload.reports.page import Picture, Section
from steadyload.reports.table import (
    MISSING,
    compact,
    markdown_table,
    names,
    percent,
    significant,
)
from steadyload.statistics.estimate import Estimate
from steadyload.studies.tuning.figures import plot_changes, plot_transfer
from steadyload.studies.tuning.records import (
    TransferCell,
    TransferTable,
    Variant,
    VariantTable,
)


def left_out(tables: Sequence[VariantTable]) -> Section:
    """What each part of the tuned parameters adds."""
    return Section(
        "What the gain is made of",
        "\n".join(_dearest(t) for t in tables)
        + "\n\nOne thing at a time is taken back from the tuned parameters; changes of accuracy "
        "and the factor of the cost are against them, on the same cases.",
        _variant_tables(tables),
        [
            Picture(
                "left-out",
                plot_changes(tables),
                "Change of accuracy when one thing is taken back, with 95 % intervals; beside each "
                "panel the factor of the cost.",
            )
        ],
    )


def plausibility(tables: Sequence[VariantTable]) -> Section:
    """Which of the found values the accuracy depends on."""
    return Section(
        "Physical or fitted",
        "\n".join(_free(t) for t in tables)
        + "\n\nFound values go back to those of the reference simulator, which made the labels. "
        "*At no loss*: the interval of the change holds 0, which a wide one does easily, or lies "
        "above it. A value that the "
        "accuracy needs and that is not the reference's makes up for something else in the engine.",
        _variant_tables(tables),
    )


def _loses(row: Variant) -> bool:
    return row.accuracy_change.high < 0.0


def _dearest(table: VariantTable) -> str:
    losing = sorted(
        (r for r in table.rows if _loses(r)), key=lambda r: (r.accuracy_change.value, r.change)
    )
    told = ", ".join(f"{r.change} ({percent(r.accuracy_change)})" for r in losing[:3])
    dearer = max(table.rows, key=lambda r: r.cost_change)
    said = f"- {table.engine}, part `{table.part}`: "
    said += (
        f"{len(losing)} of {len(table.rows)} changes cost accuracy, most of all {told}"
        if losing
        else f"none of {len(table.rows)} changes costs accuracy for certain"
    )
    if dearer.cost_change > 1.0:
        said += f"; {dearer.change} costs the most time, ×{compact(dearer.cost_change)}"
    return f"{said}."


def _free(table: VariantTable) -> str:
    free = [r.change for r in table.rows if not _loses(r)]
    bound = [f"{r.change} ({percent(r.accuracy_change)})" for r in table.rows if _loses(r)]
    said = f"- {table.engine}, part `{table.part}`: "
    said += f"at no loss: {names(free)}" if free else "nothing goes back at no loss"
    return said + (f"; accuracy is lost by: {names(bound)}." if bound else ".")


def _variant_tables(tables: Sequence[VariantTable]) -> list[str]:
    header = ("change", "to", "n", "accuracy %", "change of accuracy", "cost ms", "cost factor")
    return [
        f"**{table.engine}, part {table.part}**\n\n"
        + markdown_table(
            header,
            [
                (
                    r.change,
                    r.values,
                    str(r.found.accuracy.n),
                    percent(r.found.accuracy),
                    percent(r.accuracy_change),
                    significant(r.found.cpu.value),
                    compact(r.cost_change),
                )
                for r in table.rows
            ],
            left=2,
        )
        for table in tables
    ]


def transfer(table: TransferTable, number: int) -> Section:
    """Parameters of every engine on every other one; ``number`` tells pictures apart."""
    ignored = [
        f"- {judged_on} has no such setting as {names(settings)}, which were tuned on {tuned_on}."
        for (tuned_on, judged_on), settings in table.ignored.items()
        if settings
    ]
    text = _belongs(table)
    if ignored:
        text += "\n\nNot all settings exist on every engine:\n\n" + "\n".join(ignored)
    cells = {(c.tuned_on, c.judged_on): c for c in table.cells}
    counts = sorted({c.found.accuracy.n for c in table.cells})
    header = ("tuned on, judged on", *table.engines)
    tables = [
        f"{title}:\n\n"
        + markdown_table(
            header,
            [
                (
                    row,
                    *(said(cells[row, e]) if (row, e) in cells else MISSING for e in table.engines),
                )
                for row in table.engines
            ],
        )
        for title, said in (
            (
                f"Accuracy % with its interval (n {names(map(str, counts))})",
                lambda c: percent(c.found.accuracy),
            ),
            ("Overestimated % / underestimated %, then CPU time", _faults),
        )
    ]
    return Section(
        f"Transfer between engines, part {table.part}",
        text,
        tables,
        [
            Picture(
                f"transfer-{number + 1}",
                plot_transfer(table),
                "Accuracy in per cent and CPU time a layout of parameters tuned on one engine "
                "(rows) and judged on another (columns). Colour: how far they are ahead of "
                "those that were tuned on the engine they are judged on.",
            )
        ],
    )


def _faults(cell: TransferCell) -> str:
    over, under = (100 * share.value for share in (cell.found.over, cell.found.under))
    return f"{over:.1f} / {under:.1f}, {significant(cell.found.cpu.value)} ms"


def _belongs(table: TransferTable) -> str:
    """Does a tuning belong to a problem or to an engine?"""
    own = [c for c in table.cells if c.tuned_on == c.judged_on]
    foreign = [c for c in table.cells if c.tuned_on != c.judged_on]
    if not own or not foreign:
        return "There are no two engines to compare."
    at_home, away = (
        100 * sum(c.found.accuracy.value for c in cells) / len(cells) for cells in (own, foreign)
    )
    said = (
        f"On part `{table.part}` parameters are {at_home:.1f} % accurate on the engine that they "
        f"were tuned on, and {away:.1f} % on another one, on average: {at_home - away:+.1f} points."
    )
    told = [c.found.ahead for c in foreign if c.found.ahead is not None]
    ahead = sum(d.low > 0.0 for d in told)
    behind = sum(d.high < 0.0 for d in told)
    if told:
        said += (
            f" Of {len(told)} pairs the engine's own parameters are ahead in {ahead} and behind in "
            f"{behind}; {len(told) - ahead - behind} are not told apart. "
        ) + _answer(ahead, len(told))
    return said + "\n\n" + "\n".join(_ahead(e, foreign) for e in table.engines)


def _answer(ahead: int, pairs: int) -> str:
    if ahead == pairs:
        return "A tuning belongs to its engine."
    if ahead == 0:
        return "No engine's own tuning is seen to be better there than another one's."
    return "A tuning belongs to its engine in part."


def _ahead(engine: str, foreign: Sequence[TransferCell]) -> str:
    mine = [c for c in foreign if c.judged_on == engine]
    told = "; ".join(
        f"of {c.tuned_on}'s by {percent(c.found.ahead)}{_apart(c.found.ahead)}" for c in mine
    )
    return f"- Judged on {engine}, its own parameters are ahead {told or 'of no others'}."


def _apart(difference: Estimate | None) -> str:
    if difference is None or difference.low > 0.0 or difference.high < 0.0:
        return ""
    return " (not told apart)"

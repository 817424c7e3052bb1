"""The part of the page of tuning on changed parameters, and on transfer to other engines."""

from __future__ import annotations

from collections.abc import Sequence

from steadyload.reports.pages.page import Picture, Section
from steadyload.reports.table import (
    Column,
    Table,
    columns_for,
    compact,
    names,
    percent,
    significant,
    words,
)
from steadyload.statistics.estimate import Estimate
from steadyload.studies.tuning.figures import plot_changes, plot_transfer
from steadyload.studies.tuning.summary import TransferCell, TransferTable, Variant, VariantTable

_CHANGES = (
    words("change"),
    words("to", "values"),
    Column("n", "found.accuracy.n"),
    Column("accuracy %", "found.accuracy", percent),
    Column("change of accuracy", "accuracy_change", percent),
    Column("cost ms", "found.cpu.value", significant),
    Column("cost factor", "cost_change", compact),
)


def left_out(tables: Sequence[VariantTable]) -> Section:
    """Section of the gain of each part of the tuned parameters."""
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
    """Section of the tuned values on which the accuracy depends."""
    return Section(
        "Physical or fitted",
        "\n".join(_free(t) for t in tables)
        + "\n\nFound values go back to those of the reference simulator, which made the labels. "
        "*At no loss*: the interval of the change holds 0, which a wide one does easily, or lies "
        "above it. A value that the "
        "accuracy needs and that is not the reference's makes up for something else in the engine.",
        _variant_tables(tables),
    )


def _variant_tables(tables: Sequence[VariantTable]) -> list[Table]:
    return [Table(t.rows, _CHANGES, f"**{t.engine}, part {t.part}**") for t in tables]


def _loses(row: Variant) -> bool:
    return row.accuracy_change.high < 0.0


def _with_change(rows: Sequence[Variant]) -> str:
    return ", ".join(f"{r.change} ({percent(r.accuracy_change)})" for r in rows)


def _dearest(table: VariantTable) -> str:
    losing = sorted(filter(_loses, table.rows), key=lambda r: (r.accuracy_change.value, r.change))
    dearer = max(table.rows, key=lambda r: r.cost_change)
    said = f"- {table.engine}, part `{table.part}`: " + (
        f"{len(losing)} of {len(table.rows)} changes cost accuracy, most of all "
        f"{_with_change(losing[:3])}"
        if losing
        else f"none of {len(table.rows)} changes costs accuracy for certain"
    )
    if dearer.cost_change > 1.0:
        said += f"; {dearer.change} costs the most time, ×{compact(dearer.cost_change)}"
    return f"{said}."


def _free(table: VariantTable) -> str:
    free = [r.change for r in table.rows if not _loses(r)]
    bound = [r for r in table.rows if _loses(r)]
    said = f"at no loss: {names(free)}" if free else "nothing goes back at no loss"
    lost = f"; accuracy is lost by: {_with_change(bound)}" if bound else ""
    return f"- {table.engine}, part `{table.part}`: {said}{lost}."


def transfer(table: TransferTable, number: int) -> Section:
    """Section of the parameters of every engine on every other; ``number`` is in file names."""
    text = _belongs(table)
    ignored = [
        f"- {judged_on} has no such setting as {names(settings)}, which were tuned on {tuned_on}."
        for (tuned_on, judged_on), settings in table.ignored.items()
        if settings
    ]
    if ignored:
        text += "\n\nNot all settings exist on every engine:\n\n" + "\n".join(ignored)
    cells = {(c.tuned_on, c.judged_on): c for c in table.cells}
    counts = sorted({c.found.accuracy.n for c in table.cells})
    tables = [
        Table(
            table.engines,
            [
                words("tuned on, judged on", str),
                *columns_for(table.engines, "{}", lambda here, there: cells[here, there], form),
            ],
            caption,
        )
        for caption, form in (
            (
                f"Accuracy % with its interval (n {names(map(str, counts))}):",
                lambda c: percent(c.found.accuracy),
            ),
            ("Overestimated % / underestimated %, then CPU time:", _faults),
        )
    ]
    picture = Picture(
        f"transfer-{number + 1}",
        plot_transfer(table),
        "Accuracy in per cent and CPU time a layout of parameters tuned on one engine "
        "(rows) and judged on another (columns). Colour: how far they are ahead of "
        "those that were tuned on the engine they are judged on.",
    )
    return Section(f"Transfer between engines, part {table.part}", text, tables, [picture])


def _faults(cell: TransferCell) -> str:
    over, under = (100 * share.value for share in (cell.found.over, cell.found.under))
    return f"{over:.1f} / {under:.1f}, {significant(cell.found.cpu.value)} ms"


def _belongs(table: TransferTable) -> str:
    """Paragraph on whether tuned parameters are specific to an engine."""
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
    told = "; ".join(
        f"of {c.tuned_on}'s by {percent(c.found.ahead)}{_apart(c.found.ahead)}"
        for c in foreign
        if c.judged_on == engine
    )
    return f"- Judged on {engine}, its own parameters are ahead {told or 'of no others'}."


def _apart(difference: Estimate | None) -> str:
    if difference is None or difference.low > 0.0 or difference.high < 0.0:
        return ""
    return " (not told apart)"

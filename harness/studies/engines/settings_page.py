"""The table engine x setting, as text and as a page."""

from __future__ import annotations

from collections.abc import Sequence

from steadyload.reports.table import markdown_table
from steadyload.studies.engines.settings import EngineSettings

_PRECISION = {True: "single", False: "double", None: "?"}


def engines_rows(
    records: Sequence[EngineSettings],
) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
    """Header and rows: a row per setting, a column per engine."""
    settings = list(dict.fromkeys(s for r in records for s in r.answers))
    header = ("setting", *(r.name for r in records))
    rows = [
        (setting, *(r.answers.get(setting, ("?", ""))[0] for r in records)) for setting in settings
    ]
    facts = [
        ("dimensions", *(str(r.dimensions) for r in records)),
        ("precision", *(_PRECISION[r.single_precision] for r in records)),
    ]
    return header, [*facts, *rows]


def engines_markdown(records: Sequence[EngineSettings]) -> str:
    """The table and every engine's notes as a Markdown page."""
    header, rows = engines_rows(records)
    parts = [
        "# Engines and settings",
        "Made by `steadyload engines --markdown` from the declarations beside each adapter. "
        "*Honoured*: the engine has it. *Emulated*: the adapter reaches the same effect by other "
        "means. *Emulated on request*: only with `emulate=SETTING`, because it has a price. "
        "*Ignored*: it has no effect, and every result says so.",
        markdown_table(header, rows, left=len(header)),
    ]
    for record in records:
        notes = [f"- {s}: {note}" for s, (_, note) in record.answers.items() if note]
        if record.notes:
            notes.append(f"- {record.notes}")
        parts.append("\n".join([f"## {record.title} (`{record.name}`)", "", *notes]))
    return "\n\n".join(parts)

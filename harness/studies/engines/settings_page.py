"""The engines' declared capabilities: the table setting x engine, as text and as a page."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from steadyload.engines.registry import capabilities, engines
from steadyload.engines.world import EngineNotInstalledError, KnownFailure
from steadyload.reports.table import markdown_table


@dataclass(frozen=True, slots=True)
class EngineSettings:
    """An engine's declared capabilities.

    Attributes:
        answers: by setting, a capability and a note, and likewise for a gravity that changes while
            a world runs, and for boxes that are turned or move from the start; empty where the
            engine is not installed.
        failures: checks of conformance that it is known to fail.
    """

    name: str
    title: str
    notes: str
    dimensions: int = 3
    precision: str = "?"
    answers: Mapping[str, tuple[str, str]] = field(default_factory=dict)
    failures: Sequence[KnownFailure] = ()


def engine_records() -> list[EngineSettings]:
    """Every engine's capability for every setting; the title says where a library is missing."""
    records = []
    for name in engines():
        try:
            facts = capabilities(name)
        except EngineNotInstalledError as error:
            records.append(EngineSettings(name, f"{name} (not installed)", str(error)))
            continue
        answers = {}
        more = {"changing_gravity": facts.changing_gravity, "in_flight": facts.in_flight}
        for setting, own in {**facts.settings, **more}.items():
            limits = "" if own.values is None else f" ({', '.join(map(str, own.values))})"
            answers[setting] = (f"{own.support}{limits}", own.note)
        precision = "single" if facts.single_precision else "double"
        records.append(
            EngineSettings(
                name,
                facts.title,
                facts.notes,
                facts.dimensions,
                precision,
                answers,
                facts.known_failures,
            )
        )
    return records


def engines_rows(
    records: Sequence[EngineSettings],
) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
    """Header and rows: a row per setting, a column per engine."""
    settings = dict.fromkeys(s for r in records for s in r.answers)
    rows = [
        ("dimensions", *(str(r.dimensions) for r in records)),
        ("precision", *(r.precision for r in records)),
        *((s, *(r.answers.get(s, ("?", ""))[0] for r in records)) for s in settings),
    ]
    return ("setting", *(r.name for r in records)), rows


def engines_markdown(records: Sequence[EngineSettings]) -> str:
    """The table and every engine's notes as a Markdown page."""
    header, rows = engines_rows(records)
    parts = [
        "# Engines and settings",
        "Made by `steadyload engines --markdown` from the declarations beside each adapter. "
        "*Honoured*: the engine has it. *Emulated*: the adapter reaches the same effect by other "
        "means. *Emulated on request*: only with `emulate=SETTING`, because it has a price. "
        "*Ignored*: it has no effect, and every result says so. `in_flight`: a box may be turned "
        "and move when it is added to a world, as no judged layout asks for.",
        markdown_table(header, rows, left=len(header)),
    ]
    for record in records:
        notes = [f"- {s}: {note}" for s, (_, note) in record.answers.items() if note]
        notes += [f"- {record.notes}"] if record.notes else []
        notes += [
            f"- fails the check `{failure.check}`: {failure.reason}. Measured: {failure.evidence}."
            for failure in record.failures
        ]
        parts.append("\n".join([f"## {record.title} (`{record.name}`)", "", *notes]))
    return "\n\n".join(parts)

"""The engines' declared capabilities as records for a page."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from steadyload.engines.registry import capabilities, engines
from steadyload.engines.world import EngineNotInstalledError


@dataclass(frozen=True, slots=True)
class EngineSettings:
    """An engine's declared capabilities; ``answers`` has, by setting, a capability and a note, and
    likewise for a gravity that changes while a world runs.

    What is not known because the engine is not installed is None, or missing.
    """

    name: str
    title: str
    dimensions: int
    single_precision: bool | None
    answers: Mapping[str, tuple[str, str]]
    notes: str


def engine_records() -> list[EngineSettings]:
    """Every engine's capability for every setting; the title says where a library is missing."""
    records = []
    for name in engines():
        try:
            facts = capabilities(name)
        except EngineNotInstalledError as error:
            records.append(EngineSettings(name, f"{name} (not installed)", 3, None, {}, str(error)))
            continue
        declared = {**facts.settings, "changing_gravity": facts.changing_gravity}
        answers = {
            setting: (_limited(str(answer.support), answer.values), answer.note)
            for setting, answer in declared.items()
        }
        records.append(
            EngineSettings(
                name, facts.title, facts.dimensions, facts.single_precision, answers, facts.notes
            )
        )
    return records


def _limited(support: str, values: tuple[object, ...] | None) -> str:
    return support if values is None else f"{support} ({', '.join(map(str, values))})"

"""Parameters that searches found, with their provenance: ``tuned.json``.

``{name: {engine: {"parameters": ..., "made_by": ...}}}``. Searches write it
(``steadyload tune --write-preset``); nobody edits it.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Any

from steadyload.atomic import write_atomically

TUNED = "ps_opt"
"""Name of the tuned preset; it exists before anything was tuned, and then on no engine."""

FILE = Path(str(resources.files("steadyload.methods"))) / "tuned.json"
"""Where searches write to, and presets are read from."""


@dataclass(frozen=True, slots=True)
class Tuned:
    """Parameters that a search found on one engine.

    Attributes:
        parameters: of a simulation on that engine.
        made_by: everything that is needed to find them again, and their evaluation.
    """

    parameters: Mapping[str, Any]
    made_by: Mapping[str, Any]


def tuned() -> Mapping[str, Mapping[str, Tuned]]:
    """Tuned parameters, by name of the preset and by engine."""
    return _read(FILE)


@cache
def _read(file: Path) -> Mapping[str, Mapping[str, Tuned]]:
    entries = json.loads(file.read_text()) if file.exists() else {}
    return {TUNED: {}} | {
        name: {engine: Tuned(**entry) for engine, entry in engines.items()}
        for name, engines in entries.items()
    }


def write_tuned(name: str, engine: str, found: Tuned) -> Path:
    """Replace the tuned parameters of an engine by newly found ones; returns :data:`FILE`."""
    entries = json.loads(FILE.read_text()) if FILE.exists() else {}
    entry = {"parameters": dict(found.parameters), "made_by": dict(found.made_by)}
    entries.setdefault(name, {})[engine] = entry
    ordered = {n: dict(sorted(engines.items())) for n, engines in sorted(entries.items())}
    write_atomically(FILE, json.dumps(ordered, indent=1) + "\n")
    _read.cache_clear()
    return FILE

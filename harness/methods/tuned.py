"""Parameters that a search has found, with what they were found by: ``tuned.json``.

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

from harness.atomic import write_atomically

_FILE = "tuned.json"


@dataclass(frozen=True, slots=True)
class Tuned:
    """What was found on one engine.

    Attributes:
        parameters: of a simulation on that engine.
        made_by: everything that is needed to find them again, and what they came to.
    """

    parameters: Mapping[str, Any]
    made_by: Mapping[str, Any]


@cache
def tuned() -> Mapping[str, Mapping[str, Tuned]]:
    """What was found, by name of the preset and by engine."""
    file = resources.files("harness.methods").joinpath(_FILE)
    if not file.is_file():
        return {}
    return {
        name: {engine: Tuned(**entry) for engine, entry in entries.items()}
        for name, entries in json.loads(file.read_text()).items()
    }


def write_tuned(name: str, engine: str, found: Tuned) -> Path:
    """Put what was found on an engine in the place of what was there.

    Returns:
        The file, beside this module.
    """
    path = Path(str(resources.files("harness.methods"))) / _FILE
    entries = json.loads(path.read_text()) if path.exists() else {}
    entry = {"parameters": dict(found.parameters), "made_by": dict(found.made_by)}
    entries.setdefault(name, {})[engine] = entry
    ordered = {n: dict(sorted(engines.items())) for n, engines in sorted(entries.items())}
    write_atomically(path, json.dumps(ordered, indent=1) + "\n")
    tuned.cache_clear()
    return path

"""Properties known not to hold for a method: declared, with the smallest counterexample.

A finding is a table in ``findings.toml`` and a layout file in ``counterexamples``. Findings are
strict: one whose counterexample passes has to go.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib import resources

from steadyload.layouts.files.record import Record, to_layout
from steadyload.layouts.readers import read_json
from steadyload.properties.property import Case

MOST_PER_ENGINE = 3
"""An engine with more counterexamples is one to mend, or not to use."""


@dataclass(frozen=True, slots=True)
class KnownFinding:
    """A property that does not hold for a method.

    ``found``: what the counterexample shows. ``why``: the reason, as far as it is known.
    """

    property: str
    method: str
    found: str
    why: str
    case: Case


@cache
def known_findings() -> tuple[KnownFinding, ...]:
    """All declared findings."""
    folder = resources.files("steadyload.properties")
    tables = tomllib.loads(folder.joinpath("findings.toml").read_text(encoding="utf-8")).get(
        "finding", []
    )
    found = []
    for table in tables:
        # Extremes, whose units nobody doubts.
        content = folder.joinpath("counterexamples", table["layout"]).read_bytes()
        (record,) = read_json([content])
        assert isinstance(record, Record), "a counterexample is a valid layout"
        layout = to_layout(record)
        change: Mapping[str, float] = table.get("change", {})
        case = Case(layout, dict(change))
        found.append(
            KnownFinding(table["property"], table["method"], table["found"], table["why"], case)
        )
    return tuple(found)


def finding(property_name: str, spec: str) -> KnownFinding | None:
    """The declared finding on a property and a method, if any."""
    return next(
        (f for f in known_findings() if (f.property, f.method) == (property_name, spec)), None
    )

"""Properties known not to hold for a method: declared, with the smallest counterexample.

A finding is a table in ``findings.toml`` and a layout file in ``counterexamples``. Findings are
strict: one whose counterexample passes has to go.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache

from steadyload.config import bind
from steadyload.layouts.files.record import Record, to_layout
from steadyload.layouts.readers import read_json
from steadyload.properties import PropertyError
from steadyload.properties.property import Case
from steadyload.reading import MAX_STORED_BYTES, content_of, own_file, toml_of

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
    tables = toml_of(own_file("steadyload.properties", "findings.toml"), PropertyError)
    return tuple(_finding(**table) for table in tables["finding"])


def _finding(layout: str, change: Mapping[str, float] | None = None, **table: str) -> KnownFinding:
    """A finding of its table, and of the layout file that the table names."""
    file = own_file("steadyload.properties", "counterexamples") / layout
    # Extremes, whose units nobody doubts.
    (record,) = read_json([content_of(file, MAX_STORED_BYTES)])
    assert isinstance(record, Record), "a counterexample is a valid layout"
    case = Case(to_layout(record), dict(change or {}))
    return bind(KnownFinding, table, f"finding {layout}", PropertyError, case=case)


def finding(property_name: str, spec: str) -> KnownFinding | None:
    """The declared finding on a property and a method, if any."""
    return next(
        (f for f in known_findings() if (f.property, f.method) == (property_name, spec)), None
    )

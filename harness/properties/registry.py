"""All properties by name; a property is a record in the module of its kind."""

from __future__ import annotations

from collections.abc import Iterable

from steadyload.properties import (
    bearing,
    consistency,
    road,
    stability,
    symmetry,
    worlds,
)
from steadyload.properties.property import Property

KINDS: dict[str, tuple[Property, ...]] = {
    "Verdicts among themselves": consistency.PROPERTIES,
    "The same layout, moved or turned": symmetry.PROPERTIES,
    "What must stand, and what must fall": stability.PROPERTIES,
    "What boxes bear": bearing.PROPERTIES,
    "Loads on the road": road.PROPERTIES,
    "Bodies in an engine's world": worlds.PROPERTIES,
}
"""Properties by what they are about."""

PROPERTIES: dict[str, Property] = {p.name: p for group in KINDS.values() for p in group}


def by_kind(names: Iterable[str]) -> dict[str, tuple[str, ...]]:
    """Names of properties by what they are about, without what none is about; others come last."""
    asked = list(names)
    found = {
        kind: tuple(name for name in asked if name in {p.name for p in group})
        for kind, group in KINDS.items()
    }
    known = {name for group in found.values() for name in group}
    found["Others"] = tuple(name for name in asked if name not in known)
    return {kind: group for kind, group in found.items() if group}

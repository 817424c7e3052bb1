"""All properties by name; a property is a record in the module of its kind."""

from __future__ import annotations

from collections.abc import Sequence

from steadyload.errors import nearest
from steadyload.properties import (
    PropertyError,
    consistency,
    stability,
    symmetry,
    worlds,
)
from steadyload.properties.property import Property

PROPERTIES: dict[str, Property] = {
    p.name: p for module in (consistency, symmetry, stability, worlds) for p in module.PROPERTIES
}


def chosen(names: Sequence[str] | None) -> list[Property]:
    """Properties by name; all of them for None.

    Raises:
        PropertyError: no property of that name.
    """
    for name in names or ():
        if name not in PROPERTIES:
            raise PropertyError(f"unknown property {name!r}; {nearest(name, PROPERTIES)}")
    return [p for name, p in PROPERTIES.items() if names is None or name in names]

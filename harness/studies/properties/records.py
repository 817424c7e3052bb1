"""Typed records for a page of property tests."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum

from steadyload.layouts.model import Layout
from steadyload.methods.naming import MethodKey


class Standing(StrEnum):
    """Result of a property for a method.

    ``holds``: no counterexample among the cases tried. ``finding``: it does not hold, and that is
    declared. ``violated``: it does not hold, and that is not declared. ``not asked``: the method
    does not declare what the property needs, or the property applies to no case, or the method
    refused all cases to which it applies.
    """

    HOLDS = "holds"
    FINDING = "finding"
    VIOLATED = "violated"
    NOT_ASKED = "not asked"


@dataclass(frozen=True, slots=True)
class ItemRow:
    """An item of a counterexample: corner, size and offset of the centre of mass [cm], [kg]."""

    position: tuple[float, float, float]
    size: tuple[float, float, float]
    mass_offset: tuple[float, float, float]
    weight: float


@dataclass(frozen=True, slots=True)
class SmallestCase:
    """The smallest case found on which a property does not hold.

    ``found``: found and expected results. ``change``: other values drawn for the case.
    ``file``: path of the layout, relative to the page.
    """

    found: str
    change: Mapping[str, float]
    items: tuple[ItemRow, ...]
    layout: Layout
    file: str


@dataclass(frozen=True, slots=True)
class PropertyRow:
    """Result of one property for one method.

    ``examples``: cases tried; ``asked``: those to which the property applies; ``refused``: those
    that the method refused, which lie outside its range. ``why``: the reason of a declared finding,
    or how an engine ended its process.
    """

    property: str
    method: MethodKey
    standing: Standing
    examples: int
    asked: int
    why: str = ""
    smallest: SmallestCase | None = None
    refused: int = 0


@dataclass(frozen=True, slots=True)
class PropertyTable:
    """Properties x methods: the statement of each property, and a row for each pair."""

    about: Mapping[str, str]
    methods: tuple[MethodKey, ...]
    rows: tuple[PropertyRow, ...]

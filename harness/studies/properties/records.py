"""What a page shows of property tests, as small typed records."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum

from steadyload.layouts.model import Layout
from steadyload.methods.naming import MethodKey


class Standing(StrEnum):
    """How a method stands to a property.

    ``holds``: no counterexample among the cases tried. ``finding``: it does not hold, and that is
    declared. ``violated``: it does not hold, and nobody knew. ``not asked``: the method does not
    declare what the property is about, or no case said anything, or it refused all that would have.
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

    ``found``: what was found and what was to be expected. ``change``: what else was drawn.
    ``file``: where the layout lies, relative to the page.
    """

    found: str
    change: Mapping[str, float]
    items: tuple[ItemRow, ...]
    layout: Layout
    file: str


@dataclass(frozen=True, slots=True)
class PropertyRow:
    """One property asked of one method.

    ``examples``: cases tried; ``asked``: those that the property said something about;
    ``refused``: those that the method refused, which lie outside its range. ``why``: the reason of
    a declared finding, or how an engine ended its process.
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
    """Properties x methods: what each property says, and a row for each pair."""

    about: Mapping[str, str]
    methods: tuple[MethodKey, ...]
    rows: tuple[PropertyRow, ...]

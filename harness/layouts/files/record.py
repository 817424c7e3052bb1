"""A layout as a file states it, and the one way from there to a validated layout."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from steadyload.escaping import shown as shown
from steadyload.layouts.model.floor import FloorKind
from steadyload.layouts.model.frame import AxisName, Part, SideName
from steadyload.layouts.model.item import not_a_number
from steadyload.layouts.model.layout import Item, Layout, LayoutError, Pallet
from steadyload.layouts.model.naming import box_label

DECK_KEYS = ("overhang", "deck_height", "floor")
"""Keys of a pallet that a file may state beside its size; see :class:`Pallet`."""

LOAD_KEYS = ("max_load", "max_load_per_m2")
"""Keys of the load that an item's top may bear, of which a file may state one: [kg], or [kg/m2] of
the whole top."""

_SIDES = ("width", "height", "depth")
_CM2_A_M2 = 1e4


class FormatError(LayoutError):
    """A file that is in none of the known formats, is cut off, or cannot be written."""


@dataclass(frozen=True, slots=True)
class Record:
    """A layout as a file states it, before anything is believed.

    ``pallet`` has the keys ``width, height, depth`` and, when given, those of :data:`DECK_KEYS`; an
    item ``sequence, name, x, y, z, width, height, depth, weight`` and, when given, ``offset_x,
    offset_y, offset_z`` and one of :data:`LOAD_KEYS`; of a packer's plan ``place``, that in its
    list.
    """

    name: str
    pallet: Mapping[str, Any]
    items: list[dict[str, Any]]


@dataclass(frozen=True, slots=True)
class Refused:
    """A layout of a readable file that is not a valid layout, with the reason."""

    name: str
    error: LayoutError


def to_layout(
    record: Record, *, overhang: float | None = None, floor: FloorKind | None = None
) -> Layout:
    """Validate a record.

    Args:
        record: a layout as a file states it.
        overhang: how far items may stand out over the edges of the deck [cm]; None for what the
            file states, or else the pallet's default.
        floor: what the items stand on; None likewise.

    Raises:
        LayoutError: a value is missing, of the wrong type, or not allowed.
    """
    pallet = to_pallet(record.pallet, overhang=overhang, floor=floor)
    return Layout(record.name, pallet, tuple(_item(v, i) for i, v in enumerate(record.items)))


def to_pallet(
    values: Mapping[str, Any], *, overhang: float | None = None, floor: FloorKind | None = None
) -> Pallet:
    """Validate the pallet of a record, see :func:`to_layout`."""
    pallet = Pallet(*(_number(values, key, "pallet ", SideName(k)) for k, key in enumerate(_SIDES)))
    given = {"overhang": overhang, "floor": floor}
    deck = _deck(values) | {k: v for k, v in given.items() if v is not None}
    return replace(pallet, **deck) if deck else pallet


def _deck(values: Mapping[str, Any]) -> dict[str, Any]:
    """Statements of a file on a deck, as fields of a pallet."""
    found: dict[str, Any] = {
        key: _number(values, key, f"pallet {key}")
        for key in ("overhang", "deck_height")
        if key in values
    }
    if "floor" in values:
        if not isinstance(values["floor"], str) or values["floor"] not in list(FloorKind):
            allowed = ", ".join(FloorKind)
            raise LayoutError(f"pallet floor is {shown(values['floor'])}; allowed: {allowed}")
        found["floor"] = FloorKind(values["floor"])
    return found


def _item(values: Mapping[str, Any], index: int) -> Item:
    name = values.get("name", "")
    try:
        sequence = values.get("sequence")
        if type(sequence) is float and sequence.is_integer():
            sequence = int(sequence)
        if type(sequence) is not int:
            raise LayoutError(f"sequence is {shown(sequence)}; allowed: 0, 1, 2, ...")
        x, y, z = (_number(values, a, "position ", AxisName(k)) for k, a in enumerate("xyz"))
        sides = tuple(_number(values, key, SideName(k)) for k, key in enumerate(_SIDES))
        offsets = tuple(
            _number(values, f"offset_{axis}", "centre-of-mass offset ", AxisName(k))
            if f"offset_{axis}" in values
            else 0.0
            for k, axis in enumerate("xyz")
        )
        weight = _number(values, "weight", "weight", weight=True)
        most = _max_load(values, sides[0] * sides[2])
        return Item(sequence, (x, y, z), sides, weight, offsets, name, most)  # type: ignore[arg-type]
    except LayoutError as error:
        number = values["sequence"] if type(values.get("sequence")) is int else index
        label = box_label(number, name if isinstance(name, str) else "")
        raise error.located(item=label) from None


def _max_load(values: Mapping[str, Any], top: float) -> float | None:
    """The load [kg] that a top of so many cm2 may bear, as a file states it."""
    given = [key for key in LOAD_KEYS if key in values]
    if len(given) > 1:
        raise LayoutError("states max_load and max_load_per_m2; allowed: one of the two")
    if not given:
        return None
    [key] = given
    if key == "max_load":
        return _number(values, key, key, weight=True)
    return _number(values, key, key, weight=True, per="/m2") * top / _CM2_A_M2


def _number(
    values: Mapping[str, Any], key: str, *name: Part, weight: bool = False, per: str = ""
) -> float:
    """The length, or the weight ``per`` an area, that stands under a key and has this name."""
    value = values.get(key)
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise LayoutError(*name, *not_a_number(value, weight=weight, per=per))
    try:
        return float(value)
    except OverflowError:
        return math.inf


def place_in_order(item: Mapping[str, Any], index: int) -> str:
    """The sequence number of an item for a message; its place in the file where there is none."""
    sequence = item.get("sequence", index)
    return str(sequence) if type(sequence) is int else shown(sequence)

"""Changed plans in JSON: steadyload's own, job files, and results of Packvium.

Of a result, positions, sizes, orientations, and what is packed and how many are those of the
changed plan; payloads lose the weights with which what is left out was read. What Packvium found of
its own plan stays as it is: support ratios, loads on tops, centres of mass, volumes, feasibility,
the score, alternatives.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from decimal import Decimal
from typing import Any

import orjson

from steadyload.layouts.files.record import FormatError, Record, Refused, shown
from steadyload.layouts.packers.with_packvium import TICKS_PER_CM, TICKS_PER_KG
from steadyload.layouts.rewriting.changes import (
    DECIMALS,
    OFFSETS,
    POSITION,
    SIDES,
    Form,
    Replanned,
    changed_boxes,
    number_text,
)

_TICKS = {
    "mm": TICKS_PER_CM // 10, "cm": TICKS_PER_CM, "m": 100 * TICKS_PER_CM,
    "in": 254 * TICKS_PER_CM // 100, "ft": 3048 * TICKS_PER_CM // 100,
    "mg": TICKS_PER_KG // 10**6, "g": TICKS_PER_KG // 1000, "kg": TICKS_PER_KG,
    "oz": 226_796_185, "lb": 3_628_738_960,
}  # fmt: skip
"""Of a unit."""

_REASON = "no_feasible_placement"
"""Packvium's word for a box of which none was found."""

_INDENTED = 64 * 1024
"""Characters by which a text is known to have lines."""


class _Number(str):
    """A number of JSON by its digits, so that it is written as it was read."""

    __slots__ = ()


def changed_json(
    text: str, records: Sequence[Record | Refused], plans: Mapping[str, Replanned]
) -> str:
    """The text of a JSON file with changed plans.

    Raises:
        LayoutError: the file cannot state a plan.
    """
    content = json.loads(text, parse_float=_Number, parse_int=_Number, parse_constant=_Number)
    first = next((name for name in content if name in ("layouts", "ulds")), "")
    if first:
        for layout, record in zip(content[first], records, strict=True):
            if isinstance(record, Record) and record.name in plans:
                items, form = _FORMS[first]
                plan = plans[record.name]
                layout[items] = changed_boxes(layout[items], record.items, plan, form)
    else:
        _change_result(content, {record.name: record for record in records}, plans)
    lines = orjson.OPT_INDENT_2 if "\n" in text[:_INDENTED].strip() else 0
    how = orjson.OPT_PASSTHROUGH_SUBCLASS | lines
    try:
        written = orjson.dumps(content, default=_fragment, option=how).decode()
    except TypeError:
        raise FormatError(
            "has a text of half a character (a lone surrogate), which no file of UTF-8 can state; "
            "allowed: whole characters"
        ) from None
    return written + text[len(text.rstrip()) :]


def _fragment(number: _Number) -> orjson.Fragment:
    return orjson.Fragment(number.encode())


def _written(key: str, value: float, old: str) -> _Number:
    text = str(int(value)) if key == "sequence" else number_text(value, DECIMALS, old)
    return _Number(text)


def _measured(_key: str, value: float, old: Mapping[str, Any]) -> dict[str, Any]:
    return _measure(old, round(value * TICKS_PER_CM))


def _measure(old: Mapping[str, Any], ticks: int) -> dict[str, Any]:
    """A measure of Packvium with other ticks, and the value that these are in its unit."""
    made = {**old, "ticks": _Number(str(ticks))}
    if "value" in old:
        unit = old.get("unit")
        if unit not in _TICKS:
            raise FormatError(f"has the unit {shown(unit)}; allowed: {', '.join(_TICKS)}")
        value = (Decimal(ticks) / _TICKS[unit]).quantize(Decimal("1e-8")).normalize()
        made["value"] = type(old["value"])(f"{value:f}")
    return made


_FORMS = {
    "layouts": (
        "items",
        Form(
            {"sequence": ("sequence",)}
            | {
                key: (list_of, place)
                for list_of, keys in (
                    ("position", POSITION), ("size", SIDES), ("mass_offset", OFFSETS)
                )
                for place, key in enumerate(keys)
            },
            _written,
        ),
    ),
    "ulds": (
        "placedItems",
        Form(
            {key: (key,) for key in ("sequence", *POSITION)}
            | {key: ("shape", key) for key in SIDES}
            | {o: ("centerOfMass", axis) for o, axis in zip(OFFSETS, POSITION, strict=True)},
            _written,
        ),
    ),
}  # fmt: skip
"""Of the files whose layouts stand under a name: the name of their boxes, and how they state
these."""

_PLACEMENT = Form(
    {
        "x": ("position", "y"), "y": ("position", "z"), "z": ("position", "x"),
        "width": ("dimensions", "width"), "height": ("dimensions", "height"),
        "depth": ("dimensions", "length"),
    },
    _measured,
    code=("orientation",),
    axes="LWH",
)  # fmt: skip
"""Of a result of Packvium, whose x is our z, and whose y is our x."""


def _change_result(
    content: dict[str, Any], records: Mapping[str, Any], plans: Mapping[str, Replanned]
) -> None:
    """Change the plans of a result of Packvium."""
    left: list[Mapping[str, Any]] = []
    for container in content["containers"]:
        placed = container.get("placements")
        if not placed or container["id"] not in plans:
            continue
        plan = plans[container["id"]]
        items = sorted(records[container["id"]].items, key=lambda item: item["place"])
        container["placements"] = changed_boxes(placed, items, plan, _PLACEMENT)
        gone = [box for box, item in zip(placed, items, strict=True)
                if item["sequence"] not in plan.kept]  # fmt: skip
        if gone:
            _lighten(container, sum(item["weight"] for item in items), plan)
        left += gone
    if left:
        _unpack(content, left)


def _lighten(container: dict[str, Any], weight: float, plan: Replanned) -> None:
    """Take the weights of boxes [kg] from those of a container that has lost them."""
    less = weight - sum(item.weight for item in plan.layout.items)
    for key in ("payload_weight", "gross_weight"):
        stated = container.get(key)
        if isinstance(stated, dict) and isinstance(stated.get("ticks"), _Number):
            ticks = round(Decimal(stated["ticks"])) - round(less * TICKS_PER_KG)
            container[key] = _measure(stated, ticks)


def _unpack(content: dict[str, Any], left: Sequence[Mapping[str, Any]]) -> None:
    """Say of all containers that placements were left out."""
    proof = {"level": "observed", "observations": [{"code": _REASON, "count": 1, "details": []}]}
    content["unpacked_items"] += [
        {key: box[key] for key in ("item_id", "item_type")}
        | {"reason": _REASON, "details": [], "proof": proof}
        for box in left
    ]
    if "complete" in content:
        content["complete"] = False
    counts = content.get("summary")
    for key, more in (("packed_item_count", -len(left)), ("unpacked_item_count", len(left))):
        if isinstance(counts, dict) and isinstance(counts.get(key), _Number):
            counts[key] = round(Decimal(counts[key])) + more

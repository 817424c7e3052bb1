"""Changed plans in the text of results of Packvium.

Positions, sizes, orientations, and what is packed and how many are those of the changed plan;
payloads lose the weights with which what is left out was read. What Packvium found of its own plan
stays as it is: support ratios, loads on tops, centres of mass, volumes, feasibility, the score,
alternatives.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from decimal import Decimal

from steadyload.layouts.files.record import FormatError, Record, shown
from steadyload.layouts.packers.with_packvium import TICKS_PER_CM, TICKS_PER_KG
from steadyload.layouts.rewriting.edits import (
    Edit,
    Entry,
    Form,
    Replanned,
    Span,
    applied,
    list_cuts,
    plan_edits,
)
from steadyload.layouts.rewriting.json_text import elements, members, top

_TICKS = {
    "mm": TICKS_PER_CM // 10, "cm": TICKS_PER_CM, "m": 100 * TICKS_PER_CM,
    "in": 254 * TICKS_PER_CM // 100, "ft": 3048 * TICKS_PER_CM // 100,
    "mg": TICKS_PER_KG // 10**6, "g": TICKS_PER_KG // 1000, "kg": TICKS_PER_KG,
    "oz": 226_796_185, "lb": 3_628_738_960,
}  # fmt: skip
"""Of a unit."""

_PLACES = {
    "x": ("position", "y"), "y": ("position", "z"), "z": ("position", "x"),
    "width": ("dimensions", "width"), "height": ("dimensions", "height"),
    "depth": ("dimensions", "length"),
}  # fmt: skip
"""Number of a box -> where a placement states it: x is our z, and y our x."""

_REASON = "no_feasible_placement"
"""Packvium's word for a box of which none was found."""


def packvium_edits(
    text: str, records: Mapping[str, Record], plans: Mapping[str, Replanned]
) -> list[Edit]:
    """Edits of a result.

    Raises:
        LayoutError: the result cannot state a plan.
    """
    head = top(text)
    edits: list[Edit] = []
    left: list[str] = []
    for span in elements(text, head["containers"]):
        container = members(text, span)
        placed = elements(text, container["placements"]) if "placements" in container else []
        name = json.loads(text[slice(*container["id"])]) if placed else ""
        if name not in plans:
            continue
        plan = plans[name]
        items = sorted(records[name].items, key=lambda item: item["place"])
        steps = [item["sequence"] for item in items]
        cuts = list_cuts(placed, [step in plan.kept for step in steps])
        entries = [_entry(text, *both) for both in zip(placed, cuts, strict=True)]
        edits += plan_edits(text, entries, items, plan, Form(_length, axes="LWH"))
        gone = [text[slice(*one)] for one, step in zip(placed, steps, strict=True)
                if step not in plan.kept]  # fmt: skip
        if gone:
            edits += _lighter(text, container, sum(item["weight"] for item in items), plan)
        left += gone
    return edits + (_unpacked(text, head, left) if left else [])


def _entry(text: str, span: Span, cut: Span) -> Entry:
    stated = members(text, span)
    own = {key: members(text, stated[key]) for key in ("position", "dimensions")}
    numbers = {key: own[place][name] for key, (place, name) in _PLACES.items()}
    code = stated.get("orientation")
    return Entry(span, cut, numbers, code and Span(code.start + 1, code.end - 1))


def _length(_key: str, value: float, old: str) -> str:
    return _measure(old, round(value * TICKS_PER_CM))


def _measure(old: str, ticks: int) -> str:
    """A measure of Packvium with other ticks, and the value that these are in its unit."""
    stated = members(old, Span(0, len(old)))
    edits = [Edit(stated["ticks"], str(ticks))]
    if "value" in stated:
        unit = json.loads(old[slice(*stated["unit"])]) if "unit" in stated else None
        if unit not in _TICKS:
            raise FormatError(f"has the unit {shown(unit)}; allowed: {', '.join(_TICKS)}")
        value = f"{(Decimal(ticks) / _TICKS[unit]).quantize(Decimal('1e-8')).normalize():f}"
        quoted = old[stated["value"].start] == '"'
        edits.append(Edit(stated["value"], json.dumps(value) if quoted else value))
    return applied(old, edits)


def _lighter(
    text: str, container: Mapping[str, Span], weight: float, plan: Replanned
) -> list[Edit]:
    """Edits of the weights of a container that has lost some of its boxes' weight [kg]."""
    less = weight - sum(item.weight for item in plan.layout.items)
    edits = []
    for key in ("payload_weight", "gross_weight"):
        stated = members(text, container[key]) if key in container else {}
        ticks = json.loads(text[slice(*stated["ticks"])]) if "ticks" in stated else 0
        if ticks:
            now = ticks - round(less * TICKS_PER_KG)
            edits.append(Edit(container[key], _measure(text[slice(*container[key])], now)))
    return edits


def _unpacked(text: str, head: Mapping[str, Span], left: list[str]) -> list[Edit]:
    """Edits of what a result says of all containers, of which placements were left out."""
    listed = head["unpacked_items"]
    told = [_unpacked_item(json.loads(placement)) for placement in left]
    last = max((span.end for span in elements(text, listed)), default=listed.start + 1)
    more = (", " if last > listed.start + 1 else "") + ", ".join(told)
    edits = [Edit(Span(last, last), more)]
    if "complete" in head:
        edits.append(Edit(head["complete"], "false"))
    if "summary" in head:
        counts = members(text, head["summary"])
        add: dict[str, Callable[[int], int]] = {
            "packed_item_count": lambda count: count - len(left),
            "unpacked_item_count": lambda count: count + len(left),
        }
        edits += [Edit(counts[key], str(change(int(text[slice(*counts[key])]))))
                  for key, change in add.items() if key in counts]  # fmt: skip
    return edits


def _unpacked_item(placement: Mapping[str, object]) -> str:
    proof = {"level": "observed", "observations": [{"code": _REASON, "count": 1, "details": []}]}
    item = {key: placement[key] for key in ("item_id", "item_type")}
    return json.dumps({**item, "reason": _REASON, "details": [], "proof": proof})

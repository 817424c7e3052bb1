"""Plans of Packvium: the JSON of any of its engines, and the results of its Python package.

Its x is the length, y the width and z the height. Lengths are exact: 16,000 ticks a millimetre. The
JSON names the payload of a container and no weights of items.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from steadyload.layouts.model import LayoutError, Vector
from steadyload.layouts.packers.plan import Bin, Order, Placed, Plan, PlanError, plan, record
from steadyload.layouts.record import FormatError, Record, shown

_TICKS_PER_CM = 160_000
_TICKS_PER_KG = 8_000_000_000
_SIDES = ("length", "width", "height")


def from_packvium(
    result: Any, *, weights: Mapping[str, float] | None = None, order: Order = "height"
) -> Plan:
    """Layouts of a result of Packvium.

    Args:
        result: a ``packvium.PackingResult``, its dictionary, or the path of its JSON.
        weights: of item types [kg]; None for those of the result. A dictionary or a file has none:
            there a container's payload is shared by volume.
        order: the loading order: ``height`` (base, then from the back to the front) or ``given``,
            as containers list their placements.

    Raises:
        PlanError: what is given is no result.
        LayoutError: the result cannot be read, or a container is no valid layout.
        OSError: the file cannot be read.
    """
    known: dict[str, float] = dict(weights or {})
    if isinstance(result, str | Path):
        content = _parsed(Path(result))
    elif isinstance(result, Mapping):
        content = result
    elif hasattr(result, "to_dict") and hasattr(result, "containers"):
        content = result.to_dict(include_alternatives=False)
        for each in result.containers:
            for placement in each.placements:
                item = placement.instance.item
                known.setdefault(item.id, item.weight.ticks / _TICKS_PER_KG)
    else:
        raise PlanError(
            f"a {type(result).__name__} is no plan; allowed: a PackingResult of packvium, its "
            "dictionary, or the path of its JSON"
        )
    try:
        left = [_text(each, "item_id") for each in _list(content, "unpacked_items")]
        return plan(_bins(content, known), left, order)
    except LayoutError as error:
        if isinstance(result, str | Path):
            raise error.located(file=str(result)) from None
        raise


def is_packvium(content: Mapping[str, Any]) -> bool:
    """Whether a JSON object is a result of Packvium."""
    return "containers" in content and "unpacked_items" in content


def read_packvium(content: Mapping[str, Any]) -> Iterator[Record]:
    """Records of a result: one a container, in order of height.

    Raises:
        FormatError: a container is not as Packvium writes it.
    """
    for loaded in _bins(content, {}):
        if loaded.boxes:
            yield record(loaded)


def _parsed(path: Path) -> Mapping[str, Any]:
    try:
        content = json.loads(path.read_text(encoding="utf-8-sig"))
    except (ValueError, RecursionError):
        raise FormatError("is not valid JSON", file=str(path)) from None
    if not isinstance(content, dict) or not is_packvium(content):
        raise FormatError("is no result of Packvium", file=str(path))
    return content


def _bins(content: Mapping[str, Any], weights: Mapping[str, float]) -> Iterator[Bin]:
    for index, each in enumerate(_list(content, "containers")):
        if not isinstance(each, Mapping):
            raise FormatError(f"containers[{index}] is {shown(each)}; allowed: an object")
        name = _text(each, "id")
        try:
            yield Bin(name, _vector(each, "inner_dimensions", _SIDES), _boxes(each, weights))
        except LayoutError as error:
            raise error.located(layout=name) from None


def _boxes(container: Mapping[str, Any], weights: Mapping[str, float]) -> list[Placed]:
    if "placements" not in container and "lattice_summary" in container:
        raise FormatError(
            "lists no placements, only a summary of a lattice; allowed: packed with every "
            "placement listed"
        )
    placements = _list(container, "placements")
    found = []
    for each in placements:
        if not isinstance(each, Mapping):
            raise FormatError(f"a placement is {shown(each)}; allowed: an object")
        corner = _vector(each, "position", ("x", "y", "z"))
        size = _vector(each, "dimensions", _SIDES)
        found.append((_text(each, "item_id"), _text(each, "item_type"), corner, size))
    payload = _payload(container)
    volume = sum(math.prod(size) for *_, size in found)
    density = payload / volume if volume else 0.0
    return [
        Placed(name, corner, size, weights.get(kind) or density * math.prod(size) or None)
        for name, kind, corner, size in found
    ]


def _payload(container: Mapping[str, Any]) -> float:
    stated = container.get("payload_weight")
    return _ticks(stated, "payload_weight") / _TICKS_PER_KG if stated is not None else 0.0


def _vector(values: Mapping[str, Any], key: str, names: Sequence[str]) -> Vector:
    stated = values.get(key)
    if not isinstance(stated, Mapping):
        raise FormatError(f"{key} is {shown(stated)}; allowed: {', '.join(names)}")
    x, y, z = (_ticks(stated.get(name), f"{key} {name}") / _TICKS_PER_CM for name in names)
    return x, y, z


def _ticks(measure: Any, label: str) -> int:
    ticks = measure.get("ticks") if isinstance(measure, Mapping) else None
    if type(ticks) is not int or abs(ticks) > 10**18:
        raise FormatError(f"{label} is {shown(measure)}; allowed: a measure with whole ticks")
    return ticks


def _list(values: Mapping[str, Any], key: str) -> Sequence[Any]:
    found = values.get(key)
    if not isinstance(found, list | tuple):
        raise FormatError(f"{key} is {shown(found)}; allowed: a list")
    return found


def _text(values: Any, key: str) -> str:
    found = values.get(key) if isinstance(values, Mapping) else None
    if not isinstance(found, str):
        raise FormatError(f"{key} is {shown(found)}; allowed: a text")
    return found

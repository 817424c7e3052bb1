"""Plans of Packvium: the JSON of any of its engines, and the results of its Python package.

Its x is the length, y the width and z the height. Lengths are exact: 16,000 ticks a millimetre. The
JSON names the payload of a container and no weights of items.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from steadyload.layouts.files.json_stream import Elements, JsonText, members
from steadyload.layouts.files.limits import (
    MAX_FILE_BYTES,
    MAX_ITEMS,
    MAX_LAYOUTS,
    MAX_TEXT_LENGTH,
)
from steadyload.layouts.files.record import FormatError, Record, Refused, shown
from steadyload.layouts.files.sources import opened_source
from steadyload.layouts.model.layout import LayoutError, Vector
from steadyload.layouts.packers.plan import Bin, Order, Placed, Plan, PlanError, plan, stated

TICKS_PER_CM = 160_000
TICKS_PER_KG = 8_000_000_000
_SIDES = ("length", "width", "height")
_CHUNK_BYTES = 256 * 1024

MEMBERS = ("containers", "unpacked_items")
"""Members of a result that are read."""


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
        try:
            bins, left = _of_file(result, known)
            return plan(bins, left, order)
        except LayoutError as error:
            raise error.located(file=str(result)) from None
    if isinstance(result, Mapping):
        content = result
    elif hasattr(result, "to_dict") and hasattr(result, "containers"):
        content = result.to_dict(include_alternatives=False)
        for each in result.containers:
            for placement in each.placements:
                item = placement.instance.item
                known.setdefault(item.id, item.weight.ticks / TICKS_PER_KG)
    else:
        raise PlanError(
            f"a {type(result).__name__} is no plan; allowed: a PackingResult of packvium, its "
            "dictionary, or the path of its JSON"
        )
    left = _unplaced(_list(content, "unpacked_items"))
    return plan(_accepted(_list(content, "containers"), known), left, order)


def read_containers(containers: Iterable[Any]) -> Iterator[Record | Refused]:
    """Records of a result's containers, as they are read: each in order of height.

    Raises:
        FormatError: there are more containers than a file may have.
    """
    for loaded in _bins(containers, {}):
        if isinstance(loaded, Refused):
            yield loaded
        elif loaded.boxes:
            yield stated(loaded)


def _of_file(path: str | Path, weights: Mapping[str, float]) -> tuple[list[Bin], list[str]]:
    """Bins of a file, one container in memory at a time, and what is in none."""
    bins: list[Bin] | None = None
    left: list[str] | None = None
    with opened_source(path) as file:
        text = JsonText(iter(partial(file.read, _CHUNK_BYTES), b""), MAX_FILE_BYTES)
        for name, value in members(text, MEMBERS):
            if name in MEMBERS and not isinstance(value, Elements):
                raise FormatError(f"{name} is {shown(value)}; allowed: a list")
            if name == "containers":
                bins = list(_accepted(value, weights))
            elif name == "unpacked_items":
                left = _unplaced(value)
    if bins is None or left is None:
        raise FormatError("is no result of Packvium")
    return bins, left


def _unplaced(items: Iterable[Any]) -> list[str]:
    return [_text(each, "item_id") for each in items]


def _accepted(containers: Iterable[Any], weights: Mapping[str, float]) -> Iterator[Bin]:
    for loaded in _bins(containers, weights):
        if isinstance(loaded, Refused):
            raise loaded.error
        yield loaded


def _bins(containers: Iterable[Any], weights: Mapping[str, float]) -> Iterator[Bin | Refused]:
    for index, each in enumerate(containers):
        if index == MAX_LAYOUTS:
            raise FormatError(f"holds more than {MAX_LAYOUTS:,} containers; that is the most")
        name = f"containers[{index}]"
        try:
            if not isinstance(each, Mapping):
                raise FormatError(f"{name} is {shown(each)}; allowed: an object")
            name = _text(each, "id")
            yield Bin(name, _vector(each, "inner_dimensions", _SIDES), _boxes(each, weights))
        except LayoutError as error:
            yield Refused(name, error.located(layout=name))


def _boxes(container: Mapping[str, Any], weights: Mapping[str, float]) -> list[Placed]:
    if "placements" not in container and "lattice_summary" in container:
        raise FormatError(
            "lists no placements, only a summary of a lattice; allowed: packed with every "
            "placement listed"
        )
    placements = _list(container, "placements")
    if len(placements) > MAX_ITEMS:
        raise FormatError(f"has {len(placements):,} items; allowed: at most {MAX_ITEMS:,}")
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
    found = container.get("payload_weight")
    return _ticks(found, "payload_weight") / TICKS_PER_KG if found is not None else 0.0


def _vector(values: Mapping[str, Any], key: str, names: Sequence[str]) -> Vector:
    found = values.get(key)
    if not isinstance(found, Mapping):
        raise FormatError(f"{key} is {shown(found)}; allowed: {', '.join(names)}")
    x, y, z = (_ticks(found.get(name), f"{key} {name}") / TICKS_PER_CM for name in names)
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
    if len(found) > MAX_TEXT_LENGTH:
        raise FormatError(
            f"{key} has {len(found):,} characters; allowed: at most {MAX_TEXT_LENGTH:,}"
        )
    return found

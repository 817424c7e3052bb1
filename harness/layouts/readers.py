"""Readers of JSON and YAML files, one a format: bytes or text in, records out."""

from __future__ import annotations

import difflib
import json
from collections import deque
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from hashlib import sha256
from typing import Any

from steadyload.layouts.files.json_stream import Elements, JsonText, members
from steadyload.layouts.files.limits import (
    MAX_FILE_BYTES,
    MAX_ITEMS,
    MAX_LAYOUTS,
    MAX_TEXT_LENGTH,
    MAX_VALUE_LENGTH,
    MAX_WAITING,
)
from steadyload.layouts.files.plain_yaml import parse_plain_yaml
from steadyload.layouts.files.record import (
    DECK_KEYS,
    LOAD_KEYS,
    FormatError,
    Record,
    Refused,
    place_in_order,
    shown,
)
from steadyload.layouts.model.layout import LayoutError
from steadyload.layouts.packers.with_packvium import MEMBERS, read_containers

NATIVE_FORMAT = "steadyload-layouts"
NATIVE_VERSION = 1

_ULD_SIZES = {
    "ake": (144.0, 195.0, 153.0),
    "pmc_F_ld": (243.0, 405.0, 153.0),
    "pmc_md11f_md": (317.0, 243.0, 244.0),
    "pge_md11f_md": (605.0, 243.0, 238.0),
}
"""Inner length, width and height [cm] of the ACLPP's load devices; ``_cad`` variants are equal."""

_NATIVE_KEYS = ("format", "version", "layouts")
_ITEM_KEYS = ("sequence", "id", "name", "position", "size", "weight", "mass_offset", *LOAD_KEYS)

_KEPT = ("format", "version", "label", *MEMBERS)
"""Members of a file, beside its layouts, whose values are asked for."""

_Parsed = Iterator[Record | Refused]


def read_json(chunks: Iterable[bytes]) -> _Parsed:
    """Records of a native file, a job file or a packer's plan, whichever the JSON turns out to be.

    Args:
        chunks: the bytes of the file, in turn. Those of a native file that states its format and
            version first, as steadyload writes it, are asked for as its records are.
    """
    text = JsonText(chunks)
    head: dict[str, Any] = {}
    plan: list[Record | Refused] = []
    found = members(text, ("layouts", "ulds", *MEMBERS))
    for name, value in found:
        if name == "ulds":
            text.limit(MAX_FILE_BYTES)
            return (yield from _read_job(head, value, found))
        if name == "layouts":
            return (yield from _read_native(head, value, found))
        if name == "containers" and isinstance(value, Elements):
            text.limit(MAX_FILE_BYTES)
            plan = _held(read_containers(value), "its unpacked items")
            value = ()
        _keep(head, name, value)
        if head.get("format") == NATIVE_FORMAT:
            _check_keys(head, _NATIVE_KEYS, "the file")
    if head.keys() >= set(MEMBERS):
        for name in MEMBERS:
            if not isinstance(head[name], list | tuple):
                raise FormatError(f"{name} is {shown(head[name])}; allowed: a list")
        return (yield from plan)
    _check_head(head)
    raise FormatError("the file has layouts missing; allowed: a list")


def _keep(head: dict[str, Any], name: str, value: Any) -> None:
    """Keep what describes the file; of lists and of other members that they are there."""
    if isinstance(value, Elements):
        deque(value, maxlen=0)
        value = ()
    head[name] = value if name in _KEPT else None


def _check_head(head: Mapping[str, Any]) -> None:
    if head.get("format") != NATIVE_FORMAT:
        raise FormatError(
            f'is JSON of another kind; allowed: an object with "format": "{NATIVE_FORMAT}" '
            "or with 'ulds', or a result of Packvium"
        )
    version = head.get("version")
    if type(version) is not int or version != NATIVE_VERSION:
        raise FormatError(f"has version {shown(version)}; allowed: {NATIVE_VERSION}")
    _check_keys(head, _NATIVE_KEYS, "the file")


def _read_native(head: dict[str, Any], layouts: Any, rest: Iterator[tuple[str, Any]]) -> _Parsed:
    """Records of the layouts, at once where the head is known, else when it is."""
    known = {"format", "version"} <= head.keys()
    waiting: list[Record | Refused] = []
    if known:
        _check_head(head)
        yield from _native_layouts(layouts)
    else:
        waiting = _held(_native_layouts(layouts), "its format and version")
    for name, value in rest:
        _keep(head, name, value)
    _check_head(head)
    yield from waiting


def _native_layouts(layouts: Any) -> _Parsed:
    for index, layout in enumerate(_elements(layouts, "layouts")):
        name = _mapping(layout, f"layouts[{index}]").get("name")
        if not isinstance(name, str):
            raise FormatError(f"layouts[{index}] has name {shown(name)}; allowed: a text")
        yield _attempt(name, layout, _native_record)


def _held(records: _Parsed, what: str) -> list[Record | Refused]:
    """Records that wait for what names them or tells whether they may be read."""
    held, count = [], 0
    for record in records:
        count += 1 + (len(record.items) if isinstance(record, Record) else 0)
        if count > MAX_WAITING:
            raise FormatError(
                f"states {what} only after more than {MAX_WAITING:,} items; allowed: before them, "
                "or several files"
            )
        held.append(record)
    return held


def read_blocks(lines: Iterable[str]) -> Iterator[Record]:
    """Records of a native file as it is written here: a layout begins and ends at two spaces.

    Raises:
        FormatError: the lines are none of such a file, or some are missing.
    """
    block: list[str] = []
    last, length = "", 0
    for line in lines:
        last, length = line, length + len(line)
        if length > MAX_VALUE_LENGTH:
            raise FormatError(f"a layout has too many characters; allowed: {MAX_VALUE_LENGTH:,}")
        if line.startswith("  "):
            block.append(line)
        if line.rstrip(",\n") == "  }":
            yield _block_record("".join(block).rstrip(",\n"))
            block, length = [], 0
    if block or last != "}\n":
        raise FormatError("is not as steadyload writes it, or is cut off")


def _block_record(text: str) -> Record:
    try:
        layout = json.loads(text)
    except (ValueError, RecursionError):
        raise FormatError("is not as steadyload writes it, or is cut off") from None
    return _native_record(_text(_mapping(layout, "a layout").get("name"), "name"), layout)


def _native_record(name: str, layout: Mapping[str, Any]) -> Record:
    _check_keys(layout, ("name", "pallet", "items"), "the layout")
    pallet = _mapping(layout.get("pallet"), "pallet")
    _check_keys(pallet, ("width", "height", "depth", *DECK_KEYS), "pallet")
    items = []
    for place, item in enumerate(_items(layout, "items", "the layout")):
        item = _mapping(item, f"items[{place}]")
        _check_keys(item, _ITEM_KEYS, f"items[{place}]")
        values = {k: item.get(k) for k in ("sequence", "weight")}
        values |= {k: item[k] for k in LOAD_KEYS if k in item}
        values["name"] = _identity(item, f"items[{place}]")
        values |= _unpacked(item, "position", ("x", "y", "z"), place)
        values |= _unpacked(item, "size", ("width", "height", "depth"), place)
        if "mass_offset" in item:
            values |= _unpacked(item, "mass_offset", ("offset_x", "offset_y", "offset_z"), place)
        items.append(values)
    return Record(name, pallet, items)


def _read_job(head: dict[str, Any], ulds: Any, rest: Iterator[tuple[str, Any]]) -> _Parsed:
    """Records of the load devices, when the whole file is known: its label may come last."""
    held = _held(_job_ulds(ulds), "its label")
    for name, value in rest:
        _keep(head, name, value)
    label = _text(head.get("label") or "", "label")
    for record in held:
        number = record.name
        name = number if not label else label if len(held) == 1 else f"{label}#{number}"
        if isinstance(record, Refused):
            yield replace(record, name=name)
        else:
            yield _attempt(name, record, lambda name, record: replace(record, name=name))


def _job_ulds(ulds: Any) -> _Parsed:
    for index, uld in enumerate(_elements(ulds, "ulds")):
        identity = _mapping(uld, f"ulds[{index}]").get("id")
        if identity is None:
            identity = index
        if not isinstance(identity, str | int | float):
            raise FormatError(f"ulds[{index}].id is {shown(identity)}; allowed: a text or a number")
        yield _attempt(str(identity), uld, _job_record)


def _job_record(name: str, uld: Mapping[str, Any]) -> Record:
    properties = _mapping(uld.get("properties"), "properties")
    pallet = {
        "width": properties.get("width"),
        "height": properties.get("maxHeight"),
        "depth": properties.get("depth"),
    }
    items = []
    for place, item in enumerate(_items(uld, "placedItems", "the layout")):
        item = _mapping(item, f"placedItems[{place}]")
        shape = _mapping(item.get("shape"), f"placedItems[{place}].shape")
        if shape.get("shapeType", "Box") != "Box":
            raise LayoutError(
                f"shape is {shown(shape['shapeType'])}; allowed: 'Box'",
                item=place_in_order(item, place),
            )
        values = {k: item.get(k) for k in ("sequence", "weight", "x", "y", "z")}
        values |= {k: shape.get(k) for k in ("width", "height", "depth")}
        values["name"] = _text(item.get("itemLabel") or "", f"placedItems[{place}].itemLabel")
        if item.get("centerOfMass") is not None:
            offset = _mapping(item["centerOfMass"], f"placedItems[{place}].centerOfMass")
            values |= {f"offset_{axis}": offset.get(axis) for axis in "xyz"}
        items.append(values)
    return Record(name, pallet, items)


def read_aclpp(text: str) -> _Parsed:
    """Records of an ACLPP schedule: one layout per built load device, named segment/device."""
    content = parse_plain_yaml(text)
    segments = _mapping(_mapping(content, "the file").get("segments"), "segments")
    for segment, parts in segments.items():
        parts = _mapping(parts, f"segments.{segment}")
        shipments = parts.get("shipments")
        all_built = _mapping(parts.get("built_ulds") or {}, f"segments.{segment}.built_ulds")
        for uld, built in all_built.items():
            yield _attempt(f"{segment}/{uld}", (built, shipments), _aclpp_record)


def _aclpp_record(name: str, source: tuple[Any, Any]) -> Record:
    built, shipments = _mapping(source[0], "the device"), source[1]
    kind = built.get("uld_type")
    size = _ULD_SIZES.get(kind.removesuffix("_cad")) if isinstance(kind, str) else None
    if size is None:
        raise FormatError(f"uld_type is {shown(kind)}; allowed: {', '.join(sorted(_ULD_SIZES))}")
    length, width, height = size
    items = []
    for sequence, entry in enumerate(_items(built, "loaded", "the device")):
        entry = _mapping(entry, f"loaded[{sequence}]")
        # x = lat, y = height, z = lng: the turn (not the mirror) of their axes into ours.
        items.append(
            {
                "sequence": sequence,
                "name": _label(entry.get("piece", ""), f"loaded[{sequence}].piece"),
                "x": entry.get("start_lat"),
                "y": entry.get("start_height"),
                "z": entry.get("start_lng"),
                "width": entry.get("lat"),
                "height": entry.get("height"),
                "depth": entry.get("lng"),
                "weight": _piece_weight(shipments, entry),
            }
        )
    return Record(name, {"width": width, "height": height, "depth": length}, items)


def _piece_weight(shipments: Any, entry: Mapping[str, Any]) -> Any:
    try:
        return shipments[entry["shipment"]]["pieces"][entry["piece"]]["weight"]
    except (LookupError, TypeError):
        raise FormatError(
            f"states no weight for shipment {shown(entry.get('shipment'))}, piece "
            f"{shown(entry.get('piece'))}; is it cut off?"
        ) from None


def _attempt(name: str, source: Any, parse: Callable[[str, Any], Record]) -> Record | Refused:
    """A layout's record, or why there is none, so that one bad layout does not hide the others.

    One whose name is too long is known by a part of it that no valid layout has as its name, and
    by its hash.
    """
    if len(name) > MAX_TEXT_LENGTH:
        known = f"{name[:MAX_TEXT_LENGTH]}... ({sha256(name.encode(errors='replace')).hexdigest()})"
        return Refused(known, _too_long("name", len(name)))
    try:
        return parse(name, source)
    except LayoutError as error:
        # The error as it was raised would hold the source, by the frames of its traceback.
        return Refused(name, error.located())


def _check_keys(values: Mapping[str, Any], known: Collection[str], where: str) -> None:
    for key in values:
        if key not in known:
            close = difflib.get_close_matches(key[:40], known, n=1)
            hint = f"did you mean {close[0]!r}? " if close else ""
            raise FormatError(
                f"{where} has the unknown key {shown(key)}; {hint}allowed: {', '.join(known)}"
            )


def _identity(item: Mapping[str, Any], where: str) -> str:
    """The id of a box, which may stand under either key; some programs give numbers."""
    if "id" in item and "name" in item:
        raise FormatError(f"{where} has id and name; allowed: one of them, the id of the box")
    if type(item.get("id")) is int:
        return _label(item["id"], f"{where}.id")
    return _text(
        item.get("id", item.get("name", "")), f"{where}.{'id' if 'id' in item else 'name'}"
    )


def _text(value: Any, where: str) -> str:
    if not isinstance(value, str):
        raise FormatError(f"{where} is {shown(value)}; allowed: a text")
    if len(value) > MAX_TEXT_LENGTH:
        raise _too_long(where, len(value))
    return value


def _too_long(where: str, length: int) -> FormatError:
    return FormatError(f"{where} has {length:,} characters; allowed: at most {MAX_TEXT_LENGTH:,}")


def _label(value: Any, where: str) -> str:
    """A text or a number as a text."""
    return _text(str(value) if isinstance(value, int | float) else value, where)


def _mapping(value: Any, where: str) -> Mapping[str, Any]:
    if not isinstance(value, Mapping):
        raise FormatError(f"{where} is {shown(value)}; allowed: an object with named values")
    return value


def _sequence(values: Any, key: str, where: str) -> Sequence[Any]:
    value = _mapping(values, where).get(key)
    if not isinstance(value, list):
        raise FormatError(f"{where} has {key} {shown(value)}; allowed: a list")
    return value


def _items(values: Any, key: str, where: str) -> Sequence[Any]:
    found = _sequence(values, key, where)
    if len(found) > MAX_ITEMS:
        raise FormatError(f"has {len(found):,} items; allowed: at most {MAX_ITEMS:,}")
    return found


def _elements(value: Any, key: str) -> Iterator[Any]:
    """The elements of a list of layouts, as they are read."""
    if not isinstance(value, Elements):
        raise FormatError(f"the file has {key} {shown(value)}; allowed: a list")
    for index, element in enumerate(value):
        if index == MAX_LAYOUTS:
            raise FormatError(f"holds more than {MAX_LAYOUTS:,} layouts; that is the most allowed")
        yield element


def _unpacked(
    item: Mapping[str, Any], key: str, names: tuple[str, ...], place: int
) -> dict[str, Any]:
    value = item.get(key)
    if not (isinstance(value, list) and len(value) == len(names)):
        raise LayoutError(
            f"{key} is {shown(value)}; allowed: a list of three numbers",
            item=place_in_order(item, place),
        )
    return dict(zip(names, value, strict=True))

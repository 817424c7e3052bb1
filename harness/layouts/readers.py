"""One reader per file format: text in, records out."""

from __future__ import annotations

import csv
import difflib
import io
import json
import re
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from typing import Any

from steadyload.layouts.model import LayoutError
from steadyload.layouts.packers.with_packvium import is_packvium, read_packvium
from steadyload.layouts.plain_yaml import parse_plain_yaml
from steadyload.layouts.record import FormatError, Record, Refused, shown

NATIVE_FORMAT = "steadyload-layouts"
NATIVE_VERSION = 1

_ULD_SIZES = {
    "ake": (144.0, 195.0, 153.0),
    "pmc_F_ld": (243.0, 405.0, 153.0),
    "pmc_md11f_md": (317.0, 243.0, 244.0),
    "pge_md11f_md": (605.0, 243.0, 238.0),
}
"""Inner length, width and height [cm] of the ACLPP's load devices; ``_cad`` variants are equal."""

_ITEM_KEYS = ("sequence", "name", "position", "size", "weight", "mass_offset")

CSV_COLUMNS = (
    "layout",
    "pallet_width",
    "pallet_height",
    "pallet_depth",
    "sequence",
    "item",
    "x",
    "y",
    "z",
    "width",
    "height",
    "depth",
    "weight",
    "offset_x",
    "offset_y",
    "offset_z",
)


_Parsed = Iterator[Record | Refused]
_ASCII_NUMBER = re.compile(
    r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?|[+-]?(nan|inf|infinity)", re.A | re.I
)


def read_json(text: str) -> _Parsed:
    """Records of a native file, a job file or a packer's plan, as the JSON turns out."""
    try:
        content = json.loads(text, object_pairs_hook=_without_duplicates)
    except json.JSONDecodeError as error:
        raise FormatError(
            f"is not valid JSON ({error.msg} at line {error.lineno}, column {error.colno}); "
            "is it cut off?"
        ) from None
    except RecursionError:
        raise FormatError("is not a layout file: its JSON is nested too deeply") from None
    except ValueError as error:
        # Python refuses to convert integers of thousands of digits.
        raise FormatError(f"holds a number that is none ({error})") from None
    if "ulds" in content:
        yield from _read_job(content)
    elif content.get("format") == NATIVE_FORMAT:
        yield from _read_native(content)
    elif is_packvium(content):
        yield from read_packvium(content)
    else:
        raise FormatError(
            f'is JSON of another kind; allowed: an object with "format": "{NATIVE_FORMAT}" '
            "or with 'ulds', or a result of Packvium"
        )


def _read_native(content: Mapping[str, Any]) -> _Parsed:
    version = content.get("version")
    if type(version) is not int or version != NATIVE_VERSION:
        raise FormatError(f"has version {shown(version)}; allowed: {NATIVE_VERSION}")
    _check_keys(content, ("format", "version", "layouts"), "the file")
    for index, layout in enumerate(_sequence(content, "layouts", "the file")):
        name = _mapping(layout, f"layouts[{index}]").get("name")
        if not isinstance(name, str):
            raise FormatError(f"layouts[{index}] has name {shown(name)}; allowed: a text")
        yield _attempt(name, layout, _native_record)


def read_blocks(lines: Iterable[str]) -> Iterator[Record]:
    """Records of a native file as it is written here: a layout begins and ends at two spaces.

    Raises:
        FormatError: the lines are none of such a file, or some are missing.
    """
    block: list[str] = []
    last = ""
    for line in lines:
        last = line
        if line.startswith("  "):
            block.append(line)
        if line.rstrip(",\n") == "  }":
            yield _block_record("".join(block).rstrip(",\n"))
            block = []
    if block or last != "}\n":
        raise FormatError("is not as steadyload writes it, or is cut off")


def _block_record(text: str) -> Record:
    try:
        layout = json.loads(text)
    except ValueError:
        raise FormatError("is not as steadyload writes it, or is cut off") from None
    return _native_record(_text(_mapping(layout, "a layout").get("name"), "name"), layout)


def _native_record(name: str, layout: Mapping[str, Any]) -> Record:
    _check_keys(layout, ("name", "pallet", "items"), "the layout")
    pallet = _mapping(layout.get("pallet"), "pallet")
    _check_keys(pallet, ("width", "height", "depth"), "pallet")
    items = []
    for place, item in enumerate(_sequence(layout, "items", "the layout")):
        item = _mapping(item, f"items[{place}]")
        _check_keys(item, _ITEM_KEYS, f"items[{place}]")
        values = {k: item.get(k) for k in ("sequence", "weight")}
        values["name"] = _text(item.get("name", ""), f"items[{place}].name")
        values |= _unpacked(item, "position", ("x", "y", "z"), place)
        values |= _unpacked(item, "size", ("width", "height", "depth"), place)
        if "mass_offset" in item:
            values |= _unpacked(item, "mass_offset", ("offset_x", "offset_y", "offset_z"), place)
        items.append(values)
    return Record(name, pallet, items)


def _read_job(content: Mapping[str, Any]) -> _Parsed:
    ulds = _sequence(content, "ulds", "the file")
    for index, uld in enumerate(ulds):
        uld = _mapping(uld, f"ulds[{index}]")
        label = _text(content.get("label") or "", "label")
        identity = uld.get("id")
        number = str(index if identity is None else identity)
        name = number if not label else label if len(ulds) == 1 else f"{label}#{number}"
        yield _attempt(name, uld, _job_record)


def _job_record(name: str, uld: Mapping[str, Any]) -> Record:
    properties = _mapping(uld.get("properties"), "properties")
    pallet = {
        "width": properties.get("width"),
        "height": properties.get("maxHeight"),
        "depth": properties.get("depth"),
    }
    items = []
    for place, item in enumerate(_sequence(uld, "placedItems", "the layout")):
        item = _mapping(item, f"placedItems[{place}]")
        shape = _mapping(item.get("shape"), f"placedItems[{place}].shape")
        if shape.get("shapeType", "Box") != "Box":
            raise LayoutError(
                f"shape is {shown(shape['shapeType'])}; allowed: 'Box'",
                item=str(item.get("sequence", place)),
            )
        values = {k: item.get(k) for k in ("sequence", "weight", "x", "y", "z")}
        values |= {k: shape.get(k) for k in ("width", "height", "depth")}
        values["name"] = _text(item.get("itemLabel") or "", f"placedItems[{place}].itemLabel")
        if item.get("centerOfMass") is not None:
            offset = _mapping(item["centerOfMass"], f"placedItems[{place}].centerOfMass")
            values |= {f"offset_{axis}": offset.get(axis) for axis in "xyz"}
        items.append(values)
    return Record(name, pallet, items)


def read_csv(text: str) -> _Parsed:
    """Records of a CSV file: one row an item, the columns of :data:`CSV_COLUMNS` in any order."""
    reader = csv.reader(io.StringIO(text.replace("\r", "\n"), newline=""), strict=True)
    records: dict[str, Record] = {}
    try:
        header = [name.strip() for name in next(reader)]
        _check_columns(header)
        for row in reader:
            if not row:
                continue
            if len(row) != len(header):
                raise FormatError(
                    f"line {reader.line_num} has {len(row)} values; allowed: {len(header)}, "
                    "as the header says"
                )
            values = dict(zip(header, row, strict=True))
            pallet = {s: _from_text(values[f"pallet_{s}"]) for s in ("width", "height", "depth")}
            record = records.setdefault(values["layout"], Record(values["layout"], pallet, []))
            if record.pallet != pallet:
                raise FormatError(
                    f"line {reader.line_num} states another pallet size than the lines before; "
                    "allowed: one pallet a layout",
                    layout=record.name,
                )
            item = {k: _from_text(values[k]) for k in CSV_COLUMNS[4:] if k in values}
            record.items.append(item | {"name": values.get("item", "")})
    except csv.Error as error:
        raise FormatError(f"line {reader.line_num} is not CSV ({error})") from None
    yield from records.values()


def _check_columns(header: Sequence[str]) -> None:
    optional = {"item", "offset_x", "offset_y", "offset_z"}
    allowed = f"allowed: {', '.join(CSV_COLUMNS)}"
    for name in header:
        if name not in CSV_COLUMNS:
            raise FormatError(f"has the unknown CSV column {shown(name)}; {allowed}")
        if header.count(name) > 1:
            raise FormatError(f"has the CSV column {name!r} twice; allowed: each once")
    for name in CSV_COLUMNS:
        if name not in header and name not in optional:
            raise FormatError(f"lacks the CSV column {name!r}; {allowed}")


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
    kind = str(built.get("uld_type"))
    size = _ULD_SIZES.get(kind.removesuffix("_cad"))
    if size is None:
        raise FormatError(f"uld_type is {kind!r}; allowed: {', '.join(sorted(_ULD_SIZES))}")
    length, width, height = size
    items = []
    for sequence, entry in enumerate(_sequence(built, "loaded", "the device")):
        entry = _mapping(entry, f"loaded[{sequence}]")
        # x = lat, y = height, z = lng: the turn (not the mirror) of their axes into ours.
        items.append(
            {
                "sequence": sequence,
                "name": str(entry.get("piece", "")),
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
    """A layout's record, or why there is none, so that one bad layout does not hide the others."""
    try:
        return parse(name, source)
    except LayoutError as error:
        return Refused(name, error)


def _without_duplicates(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    values = dict(pairs)
    if len(values) < len(pairs):
        names = [name for name, _ in pairs]
        twice = next(name for name in names if names.count(name) > 1)
        raise FormatError(f"states {shown(twice)} twice in one object; allowed: each name once")
    return values


def _check_keys(values: Mapping[str, Any], known: Collection[str], where: str) -> None:
    for key in values:
        if key not in known:
            close = difflib.get_close_matches(key, known, n=1)
            hint = f"did you mean {close[0]!r}? " if close else ""
            raise FormatError(
                f"{where} has the unknown key {shown(key)}; {hint}allowed: {', '.join(known)}"
            )


def _text(value: Any, where: str) -> str:
    if not isinstance(value, str):
        raise FormatError(f"{where} is {shown(value)}; allowed: a text")
    return value


def _from_text(text: str) -> int | float | str:
    """A CSV cell as the number that it states, else as it is."""
    text = text.strip()
    if not _ASCII_NUMBER.fullmatch(text):
        return text
    number = float(text)
    # Sequence numbers are whole; beyond this a float is no longer exact.
    return int(number) if abs(number) < 1e15 and text.lstrip("+-").isdigit() else number


def _mapping(value: Any, where: str) -> Mapping[str, Any]:
    if not isinstance(value, Mapping):
        raise FormatError(f"{where} is {shown(value)}; allowed: an object with named values")
    return value


def _sequence(values: Any, key: str, where: str) -> Sequence[Any]:
    value = _mapping(values, where).get(key)
    if not isinstance(value, list):
        raise FormatError(f"{where} has {key} {shown(value)}; allowed: a list")
    return value


def _unpacked(
    item: Mapping[str, Any], key: str, names: tuple[str, ...], place: int
) -> dict[str, Any]:
    value = item.get(key)
    if not (isinstance(value, list) and len(value) == len(names)):
        raise LayoutError(
            f"{key} is {shown(value)}; allowed: a list of three numbers",
            item=str(item.get("sequence", place)),
        )
    return dict(zip(names, value, strict=True))

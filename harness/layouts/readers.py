"""One reader per file format: text in, records out."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import yaml

from harness.layouts.model import LayoutError
from harness.layouts.record import FormatError, Record, shown

NATIVE_FORMAT = "steadyload-layouts"
NATIVE_VERSION = 1

_ULD_SIZES = {
    "ake": (144.0, 195.0, 153.0),
    "pmc_F_ld": (243.0, 405.0, 153.0),
    "pmc_md11f_md": (317.0, 243.0, 244.0),
    "pge_md11f_md": (605.0, 243.0, 238.0),
}
"""Inner length, width and height [cm] of the ACLPP's load devices; ``_cad`` variants are equal."""

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


def read_json(text: str) -> Iterator[Record]:
    """Records of a native file or of a job file, whichever the JSON turns out to be."""
    try:
        content = json.loads(text)
    except json.JSONDecodeError as error:
        raise FormatError(
            f"is not valid JSON ({error.msg} at line {error.lineno}, column {error.colno}); "
            "is it cut off?"
        ) from None
    except RecursionError:
        raise FormatError("is not a layout file: its JSON is nested too deeply") from None
    if "ulds" in content:
        yield from _read_job(content)
    elif content.get("format") == NATIVE_FORMAT:
        yield from _read_native(content)
    else:
        raise FormatError(
            f'is JSON of another kind; allowed: an object with "format": "{NATIVE_FORMAT}" '
            "or with 'ulds'"
        )


def _read_native(content: Mapping[str, Any]) -> Iterator[Record]:
    if content.get("version") != NATIVE_VERSION:
        raise FormatError(f"has version {content.get('version')!r}; allowed: {NATIVE_VERSION}")
    for index, layout in enumerate(_sequence(content, "layouts", "the file")):
        name = str(_mapping(layout, f"layouts[{index}]").get("name") or index)
        items = []
        for place, item in enumerate(_sequence(layout, "items", f'layout "{name}"')):
            item = _mapping(item, f'layout "{name}": items[{place}]')
            values = {k: v for k, v in item.items() if k in ("sequence", "name", "weight")}
            values |= _unpacked(item, "position", ("x", "y", "z"))
            values |= _unpacked(item, "size", ("width", "height", "depth"))
            if "mass_offset" in item:
                values |= _unpacked(item, "mass_offset", ("offset_x", "offset_y", "offset_z"))
            items.append(values)
        yield Record(name, _mapping(layout.get("pallet"), f'layout "{name}": pallet'), items)


def _read_job(content: Mapping[str, Any]) -> Iterator[Record]:
    ulds = _sequence(content, "ulds", "the file")
    for index, uld in enumerate(ulds):
        uld = _mapping(uld, f"ulds[{index}]")
        label = str(content.get("label") or "")
        number = str(uld.get("id", index))
        name = number if not label else label if len(ulds) == 1 else f"{label}#{number}"
        properties = _mapping(uld.get("properties"), f'layout "{name}": properties')
        pallet = {
            "width": properties.get("width"),
            "height": properties.get("maxHeight"),
            "depth": properties.get("depth"),
        }
        items = []
        for place, item in enumerate(_sequence(uld, "placedItems", f'layout "{name}"')):
            item = _mapping(item, f'layout "{name}": placedItems[{place}]')
            shape = _mapping(item.get("shape"), f'layout "{name}": placedItems[{place}].shape')
            if shape.get("shapeType", "Box") != "Box":
                raise LayoutError(
                    f"shape is {shape['shapeType']!r}; allowed: 'Box'",
                    layout=name,
                    item=str(item.get("sequence", place)),
                )
            offset = _mapping(
                item.get("centerOfMass") or {},
                f'layout "{name}": placedItems[{place}].centerOfMass',
            )
            items.append(
                {k: item.get(k) for k in ("sequence", "weight", "x", "y", "z")}
                | {k: shape.get(k) for k in ("width", "height", "depth")}
                | {f"offset_{axis}": offset.get(axis, 0.0) for axis in "xyz"}
                | {"name": str(item.get("itemLabel") or "")}
            )
        yield Record(name, pallet, items)


def read_csv(text: str) -> Iterator[Record]:
    """Records of a CSV file: one row an item, the columns of :data:`CSV_COLUMNS` in any order."""
    reader = csv.DictReader(io.StringIO(text), skipinitialspace=True, strict=True)
    optional = {"item", "offset_x", "offset_y", "offset_z"}
    header = [name.strip() for name in reader.fieldnames or ()]
    reader.fieldnames = header
    missing = [c for c in CSV_COLUMNS if c not in header and c not in optional]
    if missing:
        raise FormatError(f"lacks the CSV column {missing[0]!r}; allowed: {', '.join(CSV_COLUMNS)}")
    pallets: dict[str, dict[str, Any]] = {}
    items: dict[str, list[dict[str, Any]]] = {}
    try:
        for row in reader:
            if None in row or None in row.values():
                found = sum(v is not None for k, v in row.items() if k is not None)
                found += len(row.get(None) or ())
                raise FormatError(
                    f"line {reader.line_num} has {found} values; allowed: {len(header)}, "
                    "as the header says"
                )
            name = row["layout"]
            pallet = {side: row[f"pallet_{side}"] for side in ("width", "height", "depth")}
            if pallets.setdefault(name, pallet) != pallet:
                raise FormatError(
                    f"line {reader.line_num} states another pallet size than the lines before; "
                    "allowed: one pallet a layout",
                    layout=name,
                )
            values = {k: _from_text(v) for k, v in row.items() if k in CSV_COLUMNS[4:]}
            values["name"] = row.get("item", "")
            items.setdefault(name, []).append(values)
    except csv.Error as error:
        raise FormatError(f"line {reader.line_num} is not CSV ({error})") from None
    for name, rows in items.items():
        yield Record(name, {k: _from_text(v) for k, v in pallets[name].items()}, rows)


def read_aclpp(text: str) -> Iterator[Record]:
    """Records of an ACLPP schedule: one layout per built load device, named segment/device."""
    try:
        content = yaml.load(text, Loader=yaml.CSafeLoader)
    except yaml.YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        where = f" at line {mark.line + 1}" if mark else ""
        raise FormatError(f"is not valid YAML{where}; is it cut off?") from None
    segments = _mapping(_mapping(content, "the file").get("segments"), "segments")
    for segment, parts in segments.items():
        parts = _mapping(parts, f"segments.{segment}")
        shipments = parts.get("shipments")
        all_built = _mapping(parts.get("built_ulds") or {}, f"segments.{segment}.built_ulds")
        for uld, built in all_built.items():
            name = f"{segment}/{uld}"
            built = _mapping(built, name)
            kind = str(built.get("uld_type"))
            size = _ULD_SIZES.get(kind.removesuffix("_cad"))
            if size is None:
                raise FormatError(
                    f"uld_type is {kind!r}; allowed: {', '.join(sorted(_ULD_SIZES))}", layout=name
                )
            length, width, height = size
            items = []
            for sequence, entry in enumerate(_sequence(built, "loaded", f'layout "{name}"')):
                entry = _mapping(entry, f'layout "{name}": loaded[{sequence}]')
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
                        "weight": _piece_weight(shipments, entry, name),
                    }
                )
            yield Record(name, {"width": width, "height": height, "depth": length}, items)


def _piece_weight(shipments: Any, entry: Mapping[str, Any], name: str) -> Any:
    try:
        return shipments[entry["shipment"]]["pieces"][entry["piece"]]["weight"]
    except (KeyError, TypeError):
        raise FormatError(
            f"states no weight for shipment {entry.get('shipment')!r}, piece "
            f"{entry.get('piece')!r}; is it cut off?",
            layout=name,
        ) from None


def _from_text(text: str) -> int | float | str:
    for convert in (int, float):
        try:
            return convert(text)
        except ValueError:
            continue
    return text


def _mapping(value: Any, where: str) -> Mapping[str, Any]:
    if not isinstance(value, Mapping):
        raise FormatError(f"{where} is {shown(value)}; allowed: an object with named values")
    return value


def _sequence(values: Any, key: str, where: str) -> Sequence[Any]:
    value = _mapping(values, where).get(key)
    if not isinstance(value, list):
        raise FormatError(f"{where} has {key} {shown(value)}; allowed: a list")
    return value


def _unpacked(item: Mapping[str, Any], key: str, names: tuple[str, ...]) -> dict[str, Any]:
    value = item.get(key)
    if not (isinstance(value, list) and len(value) == len(names)):
        raise LayoutError(
            f"{key} is {shown(value)}; allowed: a list of three numbers",
            item=str(item.get("sequence", "?")),
        )
    return dict(zip(names, value, strict=True))

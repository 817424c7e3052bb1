"""One writer per file format that can hold a layout in full: layouts in, text out."""

from __future__ import annotations

import csv
import io
import json
import math
from collections.abc import Iterable, Iterator
from textwrap import indent
from typing import Any

from steadyload.layouts.csv_cells import harmless
from steadyload.layouts.csv_reader import CSV_COLUMNS
from steadyload.layouts.model import Layout
from steadyload.layouts.readers import NATIVE_FORMAT, NATIVE_VERSION


def as_native(layouts: Iterable[Layout]) -> Iterator[str]:
    """steadyload JSON, a text for each layout."""
    head = json.dumps({"format": NATIVE_FORMAT, "version": NATIVE_VERSION, "layouts": []}, indent=1)
    yield head.removesuffix("]\n}")
    before = "\n"
    for layout in layouts:
        yield before + indent(json.dumps(_native(layout), indent=1), "  ")
        before = ",\n"
    yield "]\n}\n" if before == "\n" else "\n ]\n}\n"


def _native(layout: Layout) -> dict[str, Any]:
    return {
        "name": layout.name,
        "pallet": dict(zip(("width", "height", "depth"), layout.pallet.size, strict=True)),
        "items": [
            {
                "sequence": item.sequence,
                "name": item.name,
                "position": item.position,
                "size": item.size,
                "weight": item.weight,
                "mass_offset": item.mass_offset,
            }
            for item in layout.items
        ],
    }


def as_csv(layouts: Iterable[Layout]) -> str:
    """CSV, one row an item."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(CSV_COLUMNS)
    for layout in layouts:
        for item in layout.items:
            writer.writerow(
                (
                    harmless(layout.name),
                    *layout.pallet.size,
                    item.sequence,
                    harmless(item.name),
                    *item.position,
                    *item.size,
                    item.weight,
                    *item.mass_offset,
                )
            )
    return text.getvalue()


def as_job(layouts: Iterable[Layout]) -> str:
    """The job JSON of the published benchmark; several layouts share its list of ``ulds``."""
    layouts = list(layouts)
    ulds = []
    for number, layout in enumerate(layouts, start=1):
        width, height, depth = layout.pallet.size
        placed = []
        for item in layout.items:
            sides = dict(zip(("width", "height", "depth"), item.size, strict=True))
            placed.append(
                {"itemLabel": item.name, "weight": item.weight}
                | dict(zip("xyz", item.position, strict=True))
                | {
                    "sequence": item.sequence,
                    "shape": {"shapeType": "Box", **sides, "volume": math.prod(item.size)},
                    "centerOfMass": dict(zip("xyz", item.mass_offset, strict=True)),
                }
            )
        properties = {"width": width, "depth": depth, "maxHeight": height, "uldType": "pallet"}
        identity = number if len(layouts) == 1 else layout.name
        ulds.append({"placedItems": placed, "id": identity, "properties": properties})
    label = layouts[0].name if len(layouts) == 1 else ""
    content = {"ulds": ulds, "assessmentCriteria": ["LoadingStability"], "label": label}
    return json.dumps(content, indent=1) + "\n"

"""One writer per file format that can hold a layout in full: layouts in, text out."""

from __future__ import annotations

import csv
import io
import json
import math
from collections.abc import Iterable, Iterator
from textwrap import indent
from typing import Any

from steadyload.layouts.files.csv_cells import harmless
from steadyload.layouts.files.csv_reader import CSV_COLUMNS
from steadyload.layouts.files.record import DECK_KEYS, FormatError
from steadyload.layouts.model.layout import Layout, Pallet
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


def _pallet(pallet: Pallet) -> dict[str, Any]:
    """The size, and what differs from a pallet that has only one."""
    plain = Pallet(*pallet.size)
    stated = (key for key in DECK_KEYS if getattr(pallet, key) != getattr(plain, key))
    size = dict(zip(("width", "height", "depth"), pallet.size, strict=True))
    return size | {key: getattr(pallet, key) for key in stated}


def _size(layout: Layout, kind: str) -> tuple[float, float, float]:
    """The size of a pallet that has nothing else to state.

    Raises:
        FormatError: it has.
    """
    stated = {k: v for k, v in _pallet(layout.pallet).items() if k in DECK_KEYS}
    for key, value in stated.items():
        raise FormatError(
            f"has a pallet with {key} {value}, for which {kind} has no place; allowed: native",
            layout=layout.name,
        )
    return layout.pallet.size


def _native(layout: Layout) -> dict[str, Any]:
    return {
        "name": layout.name,
        "pallet": _pallet(layout.pallet),
        "items": [
            {
                "sequence": item.sequence,
                "name": item.name,
                "position": item.position,
                "size": item.size,
                "weight": item.weight,
                "mass_offset": item.mass_offset,
                **({} if item.max_load is None else {"max_load": item.max_load}),
            }
            for item in layout.items
        ],
    }


def as_csv(layouts: Iterable[Layout]) -> str:
    """CSV, one row an item."""
    layouts = list(layouts)
    loads = any(_limited(layout) for layout in layouts)
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow((*CSV_COLUMNS, *(["max_load"] * loads)))
    for layout in layouts:
        size = _size(layout, "csv")
        for item in layout.items:
            writer.writerow(
                (
                    harmless(layout.name),
                    *size,
                    item.sequence,
                    harmless(item.name),
                    *item.position,
                    *item.size,
                    item.weight,
                    *item.mass_offset,
                    *([item.max_load] * loads),
                )
            )
    return text.getvalue()


def _limited(layout: Layout) -> bool:
    """Whether an item states the load that it may bear."""
    return any(item.max_load is not None for item in layout.items)


def as_job(layouts: Iterable[Layout]) -> str:
    """The job JSON of the published benchmark; several layouts share its list of ``ulds``."""
    layouts = list(layouts)
    ulds = []
    for number, layout in enumerate(layouts, start=1):
        width, height, depth = _size(layout, "job")
        if _limited(layout):
            raise FormatError(
                "has items with max_load, for which job has no place; allowed: native, csv",
                layout=layout.name,
            )
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

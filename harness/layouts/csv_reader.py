"""Reader of CSV files: one row an item, text in, records out."""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Iterator, Sequence

from steadyload.layouts.record import FormatError, Record, shown

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

_ASCII_NUMBER = re.compile(
    r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?|[+-]?(nan|inf|infinity)", re.A | re.I
)


def read_csv(text: str) -> Iterator[Record]:
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


def _from_text(text: str) -> int | float | str:
    """A CSV cell as the number that it states, else as it is."""
    text = text.strip()
    if not _ASCII_NUMBER.fullmatch(text):
        return text
    number = float(text)
    # Sequence numbers are whole; beyond this a float is no longer exact.
    return int(number) if abs(number) < 1e15 and text.lstrip("+-").isdigit() else number

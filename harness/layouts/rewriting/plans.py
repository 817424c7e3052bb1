"""A changed plan is written back: same file, other places, or nothing."""

from __future__ import annotations

import io
import math
from collections.abc import Mapping
from pathlib import Path

from steadyload.atomic import write_atomically
from steadyload.layouts.files.dialect import Dialect
from steadyload.layouts.files.parquet_footer import is_parquet
from steadyload.layouts.files.record import FormatError, Record, Refused, shown
from steadyload.layouts.files.sources import decoded, opened_source
from steadyload.layouts.formats import HEAD_BYTES, Format, detect_format, records_of
from steadyload.layouts.model.frame import Frame
from steadyload.layouts.model.layout import Item, LayoutError, Vector
from steadyload.layouts.rewriting.csv_text import certificate_edits, csv_edits
from steadyload.layouts.rewriting.edits import (
    OFFSETS,
    POSITION,
    SIDES,
    Edit,
    Replanned,
    applied,
)
from steadyload.layouts.rewriting.json_text import job_edits, native_edits, top
from steadyload.layouts.rewriting.packvium_text import packvium_edits
from steadyload.layouts.rewriting.yaml_text import aclpp_edits

_READ_BACK = 1e-4
"""Lengths [cm] of what is read back differ by no more from those of the plan."""

_DECIMALS = 4
"""Of positions [cm] that are the same."""

_BOM = "\ufeff"


def rewrite(
    source: Path,
    target: Path,
    changed: Mapping[str, Replanned],
    *,
    dialect: Dialect | None = None,
) -> None:
    """Write a file again with changed plans: all else in it stays, to the character.

    Only numbers that changed are written, in the file's unit, axes and decimal mark. Rows and
    entries keep their order where a sequence number states that of loading, and are put into the
    order of loading where theirs is that. What is left out goes; Packvium's results and ACLPP
    schedules list it as not packed. What is written has been read back as the changed plans.

    Args:
        source: a file of any format that is read.
        target: the file that is written, whole or not at all.
        changed: the changed plans, by the names of layouts; the others stay.
        dialect: with which a CSV file was read; of a certificate of PackingSolver, its unit.

    Raises:
        LayoutError: the source cannot be read, has no valid layout of a name, or cannot state a
            plan, such as another loading order than that of height in a packer's plan; says what is
            allowed instead. Nothing is written.
        OSError: a file cannot be read or written.
    """
    dialect = dialect or Dialect()
    try:
        with opened_source(source) as file:
            content = file.read()
        after = _rewritten(content, changed, dialect)
    except LayoutError as error:
        raise error.framed(Frame.of(dialect)).located(file=str(source)) from None
    write_atomically(target, after, follow=True)


def _rewritten(content: bytes, changed: Mapping[str, Replanned], dialect: Dialect) -> bytes:
    if is_parquet(content):
        raise FormatError(
            "is a Parquet file, which has no text to change; allowed: another file, in a format "
            "that is named, such as parquet or native"
        )
    records = list(records_of(io.BytesIO(content), dialect, None))
    valid = {record.name: record for record in records if isinstance(record, Record)}
    for name in changed:
        if name not in valid:
            raise FormatError(f"has no layout {shown(name)} to change; allowed: {', '.join(valid)}")
    whole = decoded(content)
    text = whole.removeprefix(_BOM)
    edits = _edits(text, records, valid, changed, dialect)
    after = (whole[: len(whole) - len(text)] + applied(text, edits)).encode()
    read = {each.name: each for each in records_of(io.BytesIO(after), dialect, None)}
    for name, plan in changed.items():
        _check_read_back(read[name], plan)
    return after


def _edits(
    text: str,
    records: list[Record | Refused],
    valid: Mapping[str, Record],
    changed: Mapping[str, Replanned],
    dialect: Dialect,
) -> list[Edit]:
    kind = detect_format(text[:HEAD_BYTES], dialect)
    if kind is Format.CSV:
        return csv_edits(text, valid, changed, dialect)
    if kind is Format.PACKINGSOLVER:
        return certificate_edits(text, valid, changed, dialect)
    if kind is Format.ACLPP:
        return aclpp_edits(text, records, changed)
    first = next((name for name in top(text) if name in ("layouts", "ulds")), "")
    if not first:
        return packvium_edits(text, valid, changed)
    return (native_edits if first == "layouts" else job_edits)(text, records, changed)


def _height(item: Item) -> Vector:
    x, y, z = (round(value, _DECIMALS) for value in item.position)
    return y, z, x


def _check_read_back(record: Record | Refused, plan: Replanned) -> None:
    """Refuse what reads back as another plan.

    Raises:
        LayoutError: it does, or as none.
    """
    if isinstance(record, Refused):
        raise record.error
    items, found = plan.layout.items, sorted(record.items, key=lambda item: item["sequence"])
    by_height = sorted(items, key=_height)
    if "place" in found[0] and list(items) != by_height:
        raise FormatError(
            "is loaded in another order than that of height, by which plans of packers are read; "
            "allowed: boxes by their bases, then from the back, then from the left, or another "
            "format for the changed plan, such as native",
            layout=record.name,
        )
    for item, read in zip(items, found, strict=True):
        told = {"place": (POSITION, item.position), "size": (SIDES, item.size),
                "centre of mass": (OFFSETS, item.mass_offset)}  # fmt: skip
        same = {
            what: all(abs(read.get(key, 0.0) - value) <= _READ_BACK
                      for key, value in zip(keys, values, strict=True))
            for what, (keys, values) in told.items()
        }  # fmt: skip
        same["id"] = read["name"] == item.name
        same["weight"] = math.isclose(read["weight"], item.weight, rel_tol=1e-6)
        for what in (what for what, is_same in same.items() if not is_same):
            raise FormatError(
                f"would be read back with another {what}; allowed: of a box, what the file has a "
                "place for, and the origin of each box in the plan as it was read",
                layout=record.name, item=str(item),
            )  # fmt: skip
